"""Pictures of a recording: functions that draw on figures, and ``draw_figure``, which makes the figure."""

from chain_impact.pictures.bars import Bars, axis_ends, bars_size, draw_bar_figure
from chain_impact.pictures.curves import curves_size, draw_curve_figure, draw_curve_panels, narrow_peak
from chain_impact.pictures.drawing.figures import FIGURE_SIZE, NoRoomError, check_alone, draw_figure
from chain_impact.pictures.drawing.sizes import MM
from chain_impact.pictures.impact import IMPACT_SIZE, draw_impact, draw_loop_panel
from chain_impact.pictures.motion.poses import draw_chain
from chain_impact.pictures.motion.walls import draw_walls
from chain_impact.pictures.overview import draw_overview, draw_panels, usual_size
from chain_impact.pictures.sensitivities import draw_sensitivities

__all__ = [
    "FIGURE_SIZE",
    "IMPACT_SIZE",
    "MM",
    "Bars",
    "NoRoomError",
    "axis_ends",
    "bars_size",
    "check_alone",
    "curves_size",
    "draw_bar_figure",
    "draw_chain",
    "draw_curve_figure",
    "draw_curve_panels",
    "draw_figure",
    "draw_impact",
    "draw_loop_panel",
    "draw_overview",
    "draw_panels",
    "draw_sensitivities",
    "draw_walls",
    "narrow_peak",
    "usual_size",
]

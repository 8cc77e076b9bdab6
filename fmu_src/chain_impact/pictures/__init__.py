"""Pictures of a recording: functions that fill figures, and ``draw_figure``, which makes the figure."""

from chain_impact.pictures.bars import Bars, axis_ends, bars_size, fill_bars
from chain_impact.pictures.curves import curves_size, fill_curve_axes, fill_curves, narrow_peak
from chain_impact.pictures.drawing.figures import FIGURE_SIZE, NoRoomError, check_alone, draw_figure
from chain_impact.pictures.drawing.sizes import MM
from chain_impact.pictures.impact import IMPACT_SIZE, fill_impact, fill_loop_axes
from chain_impact.pictures.motion.poses import draw_chain
from chain_impact.pictures.motion.walls import draw_walls
from chain_impact.pictures.overview import fill, fill_axes, usual_size
from chain_impact.pictures.sensitivities import fill_sensitivities

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
    "draw_chain",
    "draw_figure",
    "draw_walls",
    "fill",
    "fill_axes",
    "fill_bars",
    "fill_curve_axes",
    "fill_curves",
    "fill_impact",
    "fill_loop_axes",
    "fill_sensitivities",
    "narrow_peak",
    "usual_size",
]

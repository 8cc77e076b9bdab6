"""Pictures of a recording: ``Picture``, and functions that draw on figures and axes."""

from chain_impact.pictures.curves import draw_curve_panels, narrow_peak
from chain_impact.pictures.drawing.figures import NoRoomError, check_alone, draw_figure
from chain_impact.pictures.drawing.sizes import MM
from chain_impact.pictures.impact import draw_loop_panel
from chain_impact.pictures.motion.poses import draw_chain
from chain_impact.pictures.motion.walls import draw_walls
from chain_impact.pictures.overview import draw_panels
from chain_impact.pictures.picture import (
    Picture,
    curves_picture,
    impact_picture,
    overview_picture,
    ranking_picture,
    sensitivities_picture,
)

__all__ = [
    "MM",
    "NoRoomError",
    "Picture",
    "check_alone",
    "curves_picture",
    "draw_chain",
    "draw_curve_panels",
    "draw_figure",
    "draw_loop_panel",
    "draw_panels",
    "draw_walls",
    "impact_picture",
    "narrow_peak",
    "overview_picture",
    "ranking_picture",
    "sensitivities_picture",
]

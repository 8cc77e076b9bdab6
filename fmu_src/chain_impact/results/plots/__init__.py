"""Pictures of a recording. `plot` writes a file; what it draws with serves other pictures, too."""

from chain_impact.results.plots.changes import fill_sensitivities
from chain_impact.results.plots.motion import draw_chain
from chain_impact.results.plots.overview import check_alone, drawn, fill, fill_axes, plot
from chain_impact.results.plots.room import draw_walls

__all__ = [
    "check_alone",
    "draw_chain",
    "draw_walls",
    "drawn",
    "fill",
    "fill_axes",
    "fill_sensitivities",
    "plot",
]

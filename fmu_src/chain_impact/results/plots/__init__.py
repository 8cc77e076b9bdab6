"""Pictures of a recording. `plot` writes a file; what it draws with serves other pictures, too."""

from chain_impact.results.plots.changes import fill_sensitivities
from chain_impact.results.plots.motion import draw_chain
from chain_impact.results.plots.overview import drawn, fill, page_size, plot
from chain_impact.results.plots.room import draw_walls

__all__ = ["draw_chain", "draw_walls", "drawn", "fill", "fill_sensitivities", "page_size", "plot"]

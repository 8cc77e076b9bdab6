"""Pictures of a recording. `plot` writes a file; what it draws with serves other pictures, too."""

from chain_impact.results.plots.motion import draw_chain
from chain_impact.results.plots.overview import SIZE, fill, plot
from chain_impact.results.plots.room import draw_walls

__all__ = ["SIZE", "draw_chain", "draw_walls", "fill", "plot"]

"""The colours of all pictures: colour-blind readers can distinguish those of curves."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgb

from chain_impact.pictures.drawing.dark_ground import PLUM, TIME, UMBER

BLACK = "#000000"
GREEN = "#009e73"
BLUE = "#0072b2"
VERMILLION = "#d55e00"
PURPLE = "#cc79a7"
BROWN, VIOLET = "#7a4b2a", "#7a3fa8"
PEAK_COLOUR = VERMILLION  # the colour of the impact with the largest force, moment or impulse
# the colours of a decrease and of an increase, which no curve has and colour-blind readers can distinguish
DECREASE, INCREASE = "#a08400", "#5e3c99"
LOAD = "#b3006e"  # the colour of the forces in joints, also in films and pages; no time has it
# The colours of curves.
# The first four are from Okabe and Ito, Color Universal Design (2008), whose other colours, except black, are
# too pale for lines on white. The last two are dark, so that colour-blind readers can distinguish them from
# the first four.
PALETTE = (BLUE, VERMILLION, GREEN, PURPLE, UMBER, PLUM)
GREY = "0.72"  # the colour of curves, marks and thin lines in the background
PALE_GREY = "0.9"  # the colour of a grid's lines
INK = "0.25"  # the colour of text and outlines
OUTSIDE_COLOUR = "0.93"  # the colour of the ground beyond walls
SHORT_TIMES_COLOUR = "0.965"  # the colour of the ground where the chain may be only at some times
# The colours of the ground on which labels may stand.
FLAT_COLOURS = ("white", OUTSIDE_COLOUR, SHORT_TIMES_COLOUR)
# Parts of the text's colour in mixtures with the ground (``faint_colour``). SHADE: for a time in which
# nothing moves; IMPACT_LINE: for the line at an impact.
SHADE, IMPACT_LINE = 0.05, 0.35
# the colour map viridis without its upper end, whose yellow is too pale on white
TIME_COLOURS = LinearSegmentedColormap.from_list(TIME, mpl.colormaps["viridis"](np.linspace(0.0, 0.85, 64)))


def faint_colour(axes: Axes, fraction: float) -> tuple[float, float, float]:
    """Return a mixture of the colour of the text, with the part ``fraction``, and the axes' ground.

    Both are the colours in use, so the mixture suits dark styles, too.
    """
    ground, text = (np.array(to_rgb(colour)) for colour in (axes.get_facecolor(), mpl.rcParams["text.color"]))
    red, green, blue = (ground + fraction * (text - ground)).tolist()
    return red, green, blue

"""Colours for axes with a dark ground: the colours of pictures are chosen for a white page."""

from __future__ import annotations

import colorsys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

DARK = 0.18  # the luminance of a ground below which white has more contrast to it than black
LEAST = 0.3  # the least luminance of a colour on a dark ground: on black it has the contrast 7
GAMMA = 2.2  # the exponent of a screen
COLOURED = 0.15  # the saturation above which a colour is not a grey


def luminance(colour: Any) -> float:
    """Return the relative luminance of a colour, from 0 to 1 (as WCAG 2.1, with a simple power law)."""
    # L = 0.2126 R^γ + 0.7152 G^γ + 0.0722 B^γ
    return float(np.array(to_rgba(colour)[:3]) ** GAMMA @ [0.2126, 0.7152, 0.0722])


def lighter(colour: Any) -> tuple[float, float, float, float]:
    """Return a colour of the same hue with a luminance of at least LEAST; greys stay as they are."""
    red, green, blue, alpha = to_rgba(colour)
    if colorsys.rgb_to_hsv(red, green, blue)[1] < COLOURED or luminance(colour) >= LEAST:
        return red, green, blue, alpha
    shares = np.linspace(0.0, 1.0, 41)
    mixed = [(*(part + share * (1.0 - part) for part in (red, green, blue)), alpha) for share in shares]
    r, g, b, a = next(one for one in mixed if luminance(one) >= LEAST)
    return r, g, b, a


@contextmanager
def lighter_on_dark(axes: Axes) -> Iterator[None]:
    """Lighten the colours of all that is drawn in this context, if the ground of the axes is dark."""
    there = set(axes.findobj())
    yield
    if luminance(axes.get_facecolor()) >= DARK:
        return
    for artist in set(axes.findobj()) - there:
        if isinstance(artist, Line2D):
            artist.set_color(lighter(artist.get_color()))
        elif isinstance(artist, Collection):
            artist.set_edgecolor([lighter(one) for one in np.asarray(artist.get_edgecolor())])
        elif isinstance(artist, Patch):
            artist.set_facecolor(lighter(artist.get_facecolor()))


def suit_legend(axes: Axes) -> None:
    """Give the legend of a motion, which has a white ground, a white ground, too, if the page is dark."""
    legend, page = axes.get_legend(), axes.get_figure(root=True)
    if legend is None or page is None or luminance(page.get_facecolor()) >= DARK:
        return
    legend.set_frame_on(True)
    legend.get_frame().set(facecolor="white", edgecolor="none", alpha=1.0)
    for text in legend.get_texts():
        text.set_color("black")

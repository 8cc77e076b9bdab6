"""Dark grounds: the colours of pictures are chosen for white figures, and are changed for dark ones."""

from __future__ import annotations

import colorsys
from collections.abc import Iterable
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection, LineCollection
from matplotlib.colors import Colormap, ListedColormap, to_hex, to_rgb, to_rgba
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation, Text

# a ground with less luminance is dark: white text has more contrast on it than black text
DARK_LUMINANCE = 0.18
# the least luminance of a colour on a dark ground; a colour with this luminance has the contrast ratio 5 on
# black; with a larger least luminance, blue and light blue would look alike
LEAST_LUMINANCE = 0.2
# the least contrast ratios to the ground (WCAG 2.1, 1.4.3 and 1.4.11). READABLE_CONTRAST applies to colours,
# and to the greys of text and outlines, from 0 (black) to LIGHTEST_TEXT. VISIBLE_CONTRAST applies to the
# greys of lines, between LIGHTEST_TEXT and LIGHTEST_LINE. For the greys of areas and grids, above
# LIGHTEST_LINE, the least ratio is 1 + FAINT_GROWTH × the distance of the grey from white, 0…1, but at most
# FAINT_CONTRAST, because a small ratio is visible on white, but not on black. Transparent lines without marks
# and transparent areas have at least FAINT_CONTRAST. All greys are those that are chosen for a white ground.
READABLE_CONTRAST = 4.5
VISIBLE_CONTRAST = 3.0
FAINT_CONTRAST = 2.0
FAINT_GROWTH = 10.0
GLARE = 0.05  # the luminance that a screen adds to each colour (WCAG 2.1)
# The number of mixtures that are tried. MIXTURES: of a colour with white, by increasing part of white, and of
# a transparent colour with the ground, by increasing opacity;
# GREY_MIXTURES: for a grey, of the colours of ground and text, by increasing part of text. The first mixture
# that is light enough is taken; for a grey, the last mixture if no mixture is light enough.
MIXTURES, GREY_MIXTURES = 41, 201
# the largest luminance that is required of a mixture with white; it is less than 1 because the luminance of
# white is 1 only up to round-off
LEAST_WHITE = 0.999
LIGHTEST_TEXT, LIGHTEST_LINE = 0.5, 0.75
GAMMA = 2.2  # the exponent γ from a colour's value to the brightness of a screen
# colours of curves on white
UMBER = "#6b4c00"
PLUM = "#5c1a6e"
OCHRE = "#c07f00"
# colours of curves on a dark ground, which are too pale for lines on white
YELLOW = "#f0e442"
SKY = "#8fd3ff"
ORANGE = "#e69f00"
# colour of a curve on white → the colour that replaces it on a dark ground; only mixed with white, the colour
# would look like that of another curve
REPLACED = {UMBER: YELLOW, PLUM: SKY, OCHRE: ORANGE}
NO_MARK = ("", "None", None)  # what matplotlib returns as the marker of a line without marks
LEAST_SATURATION = 0.3  # a colour with less saturation counts as a grey
# The distance of a grey from white, 0…1, raised to this power is the part of the text's colour in the mixture
# with a dark ground. The power enlarges the part, because greys near black are hard to see.
SPREAD = 0.8
# [points] the width of the outline of a text: so large that a line behind the text is not visible in the
# spaces between words
TEXT_OUTLINE = 4.0
# The name of the colour map for time. Its colours change on a dark ground, because lines are drawn in these
# colours. Of any other colour map, only the colour for missing values changes.
TIME = "time"
# the matplotlib identifier (gid) of a text that keeps its colour, on a coloured area
COLOURED_GROUND = "on colour"
Colour = tuple[float, float, float, float]


class Ground(NamedTuple):
    """The colours of a dark style: of the ground, which replaces white, and of text, which replaces black."""

    ground: Any
    text: Any

    @classmethod
    def current(cls) -> Ground | None:
        """Return the colours of the style in use; None if its ground is not dark."""
        ground = mpl.rcParams["figure.facecolor"]
        return cls(ground, mpl.rcParams["text.color"]) if is_dark(ground) else None

    def suited_colour(self, colour: Any) -> Colour:
        """Return the colour for this ground that replaces ``colour``, chosen for white; the opacity stays."""
        red, green, blue, alpha = to_rgba(colour)
        if is_coloured(colour):
            return lightened_colour(colour, least_luminance(self.ground, READABLE_CONTRAST))
        grey = (red + green + blue) / 3.0
        low, high = np.array(to_rgb(self.ground)), np.array(to_rgb(self.text))
        needed_luminance = (
            READABLE_CONTRAST
            if grey <= LIGHTEST_TEXT
            else VISIBLE_CONTRAST
            if grey <= LIGHTEST_LINE
            else min(FAINT_CONTRAST, 1.0 + FAINT_GROWTH * (1.0 - grey))
        )
        least_mix_luminance = least_luminance(self.ground, needed_luminance) if grey < 1.0 else 0.0
        mixed = [
            low + part * (high - low) for part in np.linspace((1.0 - grey) ** SPREAD, 1.0, GREY_MIXTURES)
        ]
        red, green, blue = next(
            (mix for mix in mixed if luminance(mix) >= least_mix_luminance), mixed[-1]
        ).tolist()
        return red, green, blue, alpha

    def suited_fill(self, colour: Any) -> Colour:
        """Return ``suited_colour`` for an area; a transparent one has at least FAINT_CONTRAST if possible."""
        *opaque, alpha = suited = self.suited_colour(colour)
        if not 0.0 < alpha < 1.0 or luminance(opaque) < least_luminance(self.ground, FAINT_CONTRAST):
            return suited
        red, green, blue = opaque
        return red, green, blue, self._opacity(alpha, (red, green, blue), FAINT_CONTRAST)

    def suit(self, artists: Iterable[Artist]) -> None:
        """Give artists that were drawn for a white figure the colours for this ground.

        In ``artists`` an axis must come after its ticks, as in the result of ``findobj``. Otherwise the
        colours of the ticks would change twice: with the axis, and as artists.
        """
        for artist in artists:
            if isinstance(artist, Line2D):
                marker = artist.get_markerfacecolor(), artist.get_markeredgecolor()
                artist.set_color(self.suited_colour(artist.get_color()))
                artist.set_markerfacecolor(self._suited_colour_or_none(marker[0]))
                artist.set_markeredgecolor(self._suited_colour_or_none(marker[1]))
                alpha = to_rgba(artist.get_color())[3]
                opacity = artist.get_alpha()
                if (opacity := alpha if opacity is None else opacity) < 1.0:
                    contrast = FAINT_CONTRAST if artist.get_marker() in NO_MARK else VISIBLE_CONTRAST
                    artist.set_alpha(self._opacity(opacity, artist.get_color(), contrast))
            elif isinstance(artist, Collection | AxesImage):
                self._suit_mapped(artist)
            elif isinstance(artist, Patch):
                colours = artist.get_facecolor(), artist.get_edgecolor()
                artist.set_alpha(None)
                artist.set_facecolor(self.suited_fill(colours[0]))
                artist.set_edgecolor(self.suited_colour(colours[1]))
            elif isinstance(artist, Text) and artist.get_gid() != COLOURED_GROUND:
                artist.set_color(self.suited_colour(artist.get_color()))
                if artist.get_path_effects():  # the outline of a text must have the colour of the ground
                    artist.set_path_effects([withStroke(linewidth=TEXT_OUTLINE, foreground=self.ground)])
                if isinstance(artist, Annotation) and artist.arrow_patch is not None:
                    self.suit([artist.arrow_patch])
            # ticks that matplotlib makes later get the colours of the axis, too
            elif isinstance(artist, Axis):
                labels = [(label, label.get_color()) for label in artist.get_majorticklabels()]
                artist.set_tick_params(which="both", color=self.text, labelcolor=self.text)
                for label, colour in labels:
                    if is_coloured(colour):
                        label.set_color(colour)

    def _opacity(self, least_opacity: float, colour: Any, contrast: float) -> float:
        """Return the least opacity with which ``colour`` has at least ``contrast`` to the ground.

        MIXTURES opacities from ``least_opacity`` to 1 are tried; the result is 1 if none is enough.
        """
        low, high = np.array(to_rgb(self.ground)), np.array(to_rgb(colour))
        needed_luminance = least_luminance(self.ground, contrast)
        opacities = np.linspace(least_opacity, 1.0, MIXTURES).tolist()
        return next(
            (part for part in opacities if luminance(low + part * (high - low)) >= needed_luminance), 1.0
        )

    def _suited_colour_or_none(self, colour: Any) -> Any:
        return colour if isinstance(colour, str) and colour == "none" else self.suited_colour(colour)

    def _suit_mapped(self, artist: Collection | AxesImage) -> None:
        """Give a collection or an image the colours for this ground, by its colour map if it has one."""
        if artist.get_array() is not None:
            artist.set_cmap(self._suited_map(artist))
        elif isinstance(artist, Collection):
            colours = artist.get_facecolor(), artist.get_edgecolor()
            opacity, is_lines = artist.get_alpha(), isinstance(artist, LineCollection)
            if not is_lines and isinstance(opacity, float):
                artist.set_alpha(None)  # the colours have their own opacities
            artist.set_facecolor(self._suited_colours(colours[0], is_fill=not is_lines))
            artist.set_edgecolor(self._suited_colours(colours[1]))
            if is_lines and isinstance(opacity, float) and len(colours[1]):
                colour = artist.get_edgecolor()[0]
                artist.set_alpha(self._opacity(opacity, colour, FAINT_CONTRAST))

    def _suited_colours(self, colours: Any, *, is_fill: bool = False) -> Colour | list[Colour]:
        """Return the colours that replace the colours of a collection; ``is_fill``: whether of areas.

        A single colour is returned without a list, because matplotlib accepts any number of opacities with a
        colour that is not in a list.
        """
        suit = self.suited_fill if is_fill else self.suited_colour
        suited_list = [suit(colour) for colour in np.asarray(colours)]
        return suited_list[0] if len(suited_list) == 1 else suited_list

    def _suited_map(self, artist: ScalarMappable) -> Colormap:
        """Return the colour map that replaces the map of an artist.

        The map TIME gets new colours; any other map gets only a new colour for missing values.
        """
        colour_map = artist.get_cmap()
        if colour_map.name == TIME:
            return ListedColormap(
                [self.suited_colour(colour_map(index)) for index in range(colour_map.N)], TIME
            )
        return colour_map.with_extremes(bad=self.suited_colour(colour_map.get_bad()))


def luminance(colour: Any) -> float:
    """Return the relative luminance of a colour, from 0 for black to 1 for white.

    The definition is that of WCAG 2.1, but with a power law (GAMMA) for each of red, green and blue.
    """
    # the luminance is L = 0.2126 R^γ + 0.7152 G^γ + 0.0722 B^γ for the colour R, G, B
    return float(np.array(to_rgba(colour)[:3]) ** GAMMA @ [0.2126, 0.7152, 0.0722])


def is_coloured(colour: Any) -> bool:
    """Return whether a colour is not a grey (LEAST_SATURATION)."""
    return colorsys.rgb_to_hsv(*to_rgb(colour))[1] >= LEAST_SATURATION


def is_dark(ground: Any) -> bool:
    """Return whether a ground is dark; a completely transparent ground is not."""
    return to_rgba(ground)[3] > 0.0 and luminance(ground) < DARK_LUMINANCE


def least_luminance(ground: Any, ratio: float) -> float:
    """Return the least luminance with which a colour has a contrast ``ratio`` to a dark ground; at most 1."""
    return min(1.0, ratio * (luminance(ground) + GLARE) - GLARE)


def lightened_colour(colour: Any, at_least: float = 0.0) -> Colour:
    """Return a colour mixed with white, with a luminance of at least LEAST_LUMINANCE and ``at_least``.

    But at most LEAST_WHITE is required. Of MIXTURES parts of white, the least that is enough is taken. The
    opacity stays. A colour in REPLACED is replaced before it is mixed.
    """
    alpha = to_rgba(colour)[3]
    red, green, blue = to_rgb(REPLACED.get(to_hex(colour), colour))
    shares = np.linspace(0.0, 1.0, MIXTURES)
    mixed = [(*(part + share * (1.0 - part) for part in (red, green, blue)), alpha) for share in shares]
    needed_luminance = min(max(LEAST_LUMINANCE, at_least), LEAST_WHITE)
    r, g, b, a = next(mixture for mixture in mixed if luminance(mixture) >= needed_luminance)
    return r, g, b, a

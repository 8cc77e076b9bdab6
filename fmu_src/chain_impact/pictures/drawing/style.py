"""The style of all pictures: fonts, colours that colour-blind readers can distinguish, headline and foot."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.text import Text
from matplotlib.ticker import AutoLocator, EngFormatter, FuncFormatter, MaxNLocator
from matplotlib.transforms import Transform, blended_transform_factory

from chain_impact.files import written_atomically
from chain_impact.pictures.drawing.dark_ground import PLUM, TIME, UMBER, Ground
from chain_impact.pictures.drawing.line_breaks import COMMA, break_lines
from chain_impact.text import LOAD_UNITS, prefixed_unit

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

# Settings of matplotlib for every picture; a setting that a user or a style sheet has changed stays.
STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "figure.constrained_layout.w_pad": 0.075,  # [inch] the space to the left and to the right of axes
    "figure.titlesize": 11,
    "figure.titleweight": "bold",
    "grid.color": PALE_GREY,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": "small",
    "legend.borderaxespad": 0.2,
    "xtick.labelsize": "small",
    "ytick.labelsize": "small",
    "pdf.fonttype": 42,  # 42 means TrueType fonts; many journals refuse Type 3 fonts, matplotlib's default
    "ps.fonttype": 42,
    "svg.fonttype": "none",  # with "none", text stays text, and does not become outlines
    # without hinting the width of text does not depend on the resolution, so one layout fits all resolutions
    "text.hinting": "none",
}
# The settings of text in a narrow figure, in place of those in STYLE: a figure as wide as a column is printed
# in its own size, for which journals ask for text of 5 to 9 points.
NARROW_TYPE: Any = {"font.size": 7.5, "figure.titlesize": 9}
# Settings with which a picture in a new figure is drawn: black on white, whatever the user's style is.
# If the user's style is dark, ``adapt_to_dark_style`` changes the colours afterwards.
COLOURS: Any = {
    name: "white" if name.endswith("facecolor") else "black"
    for name in (
        *("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"),
        *("axes.facecolor", "figure.facecolor", "savefig.facecolor"),
    )
}
# The groups of matplotlib's settings, such as ``font``, whose values a ``StyledFigure`` stores.
DRAWING = ("axes", "font", "mathtext", "pdf", "ps", "savefig", "svg", "text", "xtick", "ytick")
DPI = 160
FULL_WIDTH = 10.0  # [inch] the usual width of a figure
TWO_COLUMN_WIDTH = 6.0  # [inch] the least width for two columns of axes
COLUMN = 3.5  # [inch] the largest width of a figure for one column of a printed page
# [inch] distance of the headline from the left and the upper edge of the figure
LEFT_MARGIN, TOP_MARGIN = 0.12, 0.08
# [inch] GAP: space below the headline, and below the conditions; LINE_GAP: space between two of the coloured
# lines below the headline
GAP, LINE_GAP = 0.09, 0.02
# conditions are left out if they and the headline together would be higher than this part of the figure
MOST_HEAD = 0.33
# The largest height of all texts at the foot, relative to the height of the figure. FREE_FOOT: if the
# contents determine the height of the figure; MOST_FOOT: otherwise.
MOST_FOOT, FREE_FOOT = 0.15, 0.25
LEAST_LOAD = 0.1  # a value below this in a unit of LOAD_UNITS gets a prefix, such as mN
LEAST_TICKS = 3  # the least number of ticks on an axis
TICK_STEPS = (1, 2, 2.5, 5, 10)  # the allowed distances between ticks, times any power of ten
# the allowed distances between ticks on an axis of counts, times any power of ten
COUNT_STEPS = (1, 2, 5, 10)


@contextmanager
def drawing_style(colours: dict[str, str] = COLOURS) -> Iterator[None]:
    """Draw in the style of all pictures; the function is a context manager and a decorator.

    A setting in STYLE applies unless the user has changed this setting. The settings in ``colours`` apply in
    any case; with empty ``colours``, the colours of the user's style stay.
    """
    default_style = {
        key: value for key, value in STYLE.items() if mpl.rcParams[key] == mpl.rcParamsDefault[key]
    }
    with mpl.rc_context(default_style | colours):
        yield


@contextmanager
def type_for(width: float) -> Iterator[None]:
    """Write in NARROW_TYPE if a figure of a ``width`` [inches] is narrow, unless the user has set a size."""
    is_usual = all(mpl.rcParams[key] == mpl.rcParamsDefault[key] for key in NARROW_TYPE)
    with mpl.rc_context(NARROW_TYPE if is_usual and width < TWO_COLUMN_WIDTH else {}):
        yield


class StyledFigure(Figure):
    """An empty figure for a picture.

    A notebook shows the figure exactly once, whatever backend of matplotlib is in use.
    """

    def __init__(self, *, free_height: bool = False, **options: Any) -> None:
        """Make a figure that arranges its contents.

        Args:
            free_height: whether the contents determine the height of the figure.
            options: keywords of a matplotlib figure.
        """
        self.free_height = free_height
        with type_for((options.get("figsize") or mpl.rcParams["figure.figsize"])[0]), drawing_style():
            super().__init__(**{"layout": "constrained"} | options)
            new_canvas: Any = FigureCanvasAgg  # matplotlib has no type information for the canvas
            # this canvas keeps its renderer; matplotlib's usual canvas makes one for each text, which is slow
            new_canvas(self)
            self.settings = {
                key: value for key, value in mpl.rcParams.items() if key.partition(".")[0] in DRAWING
            }

    def draw(self, renderer: Any) -> None:
        """Draw with the settings (DRAWING) with which the figure was made: they determine the layout."""
        with mpl.rc_context(self.settings):
            super().draw(renderer)

    def savefig(self, *args: Any, **options: Any) -> None:
        """Write a file with the settings (DRAWING) with which the figure was made, such as fonts."""
        with mpl.rc_context(self.settings):
            super().savefig(*args, **options)

    def _repr_png_(self) -> bytes:
        """Return the picture as PNG; IPython calls this only if no backend of matplotlib shows figures."""
        file = BytesIO()
        self.savefig(file, format="png", dpi="figure")
        return file.getvalue()


def adapt_to_dark_style(figure: Figure) -> None:
    """Change the colours of a figure from those for a white ground, if the style in use is dark."""
    ground = Ground.current()
    if ground is None:
        return
    ground.suit(figure.findobj())
    figure.set_facecolor(ground.ground)
    if isinstance(figure, StyledFigure):
        figure.settings |= {name: mpl.rcParams[name] for name in COLOURS} | {"savefig.facecolor": "auto"}


def faint_colour(axes: Axes, fraction: float) -> tuple[float, float, float]:
    """Return a mixture of the colour of the text, with the part ``fraction``, and the axes' ground.

    Both are the colours in use, so the mixture suits dark styles, too.
    """
    ground, text = (np.array(to_rgb(colour)) for colour in (axes.get_facecolor(), mpl.rcParams["text.color"]))
    red, green, blue = (ground + fraction * (text - ground)).tolist()
    return red, green, blue


def is_narrow(figure: Figure) -> bool:
    """Return whether a figure is too narrow for two columns of axes (TWO_COLUMN_WIDTH)."""
    return bool(figure.get_figwidth() < TWO_COLUMN_WIDTH)


def give_ticks(*axes: Axes) -> None:
    """Give each linear axis x or y that has matplotlib's own ticks at least LEAST_TICKS ticks."""
    for panel in axes:
        for axis in (panel.xaxis, panel.yaxis):
            if axis.get_scale() == "linear" and isinstance(axis.get_major_locator(), AutoLocator):
                axis.set_major_locator(MaxNLocator("auto", steps=list(TICK_STEPS), min_n_ticks=LEAST_TICKS))


def scale_numbers(axis: Axis, factor: float) -> None:
    """Write the values at the ticks of an axis times ``factor``; the caller writes the unit of the result."""
    if factor != 1.0:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{factor * value:.10g}".replace("-", "−")))


def write_headline(figure: Figure, message: str, conditions: str = "", *lines: tuple[str, str]) -> None:
    """Write ``message`` above the picture and, in a smaller font below it, ``conditions``.

    ``lines`` are pairs of a text and its colour; they stand between message and conditions.
    All texts are broken at the edge of the figure. In a narrow figure the conditions stand at the foot.
    Without room for all of them, none is written (MOST_HEAD, ``write_foot``).
    """
    width, height = figure.get_size_inches()
    placement: dict[str, Any] = {"x": LEFT_MARGIN / width, "ha": "left", "in_layout": False}
    title = figure.suptitle(message, y=1.0 - TOP_MARGIN / height, va="top", **placement)
    break_lines(title, (width - 2.0 * LEFT_MARGIN) * figure.dpi, COMMA, 0)
    top = TOP_MARGIN + title.get_window_extent().height / figure.dpi + GAP
    for text, colour in lines:
        look: dict[str, Any] = {"fontsize": "small", "color": colour, "va": "top"}
        line = figure.text(
            s=fitted_lines(figure, text), y=1.0 - (top - 0.5 * GAP) / height, **placement, **look
        )
        top += line.get_window_extent().height / figure.dpi + LINE_GAP
    if conditions and is_narrow(figure):
        write_foot(figure, conditions)
    elif conditions:
        text_style: dict[str, Any] = {"fontsize": "small", "color": INK, "va": "top"}
        lines_below = figure.text(
            s=fitted_lines(figure, conditions), y=1.0 - top / height, **placement, **text_style
        )
        room = lines_below.get_window_extent().height / figure.dpi + GAP
        if top + room <= MOST_HEAD * height:
            top += room
        else:
            lines_below.remove()
    reserve_margins(figure, top / height, 0.0)


def fitted_lines(figure: Figure, text: str, more_lines: int = 1) -> str:
    """Return a text in lines that fit between the margins of a figure in a small font.

    ``more_lines`` is as in ``break_lines``.
    """
    probe = figure.text(0.0, 0.0, text, fontsize="small")
    break_lines(probe, (figure.get_figwidth() - 2.0 * LEFT_MARGIN) * figure.dpi, more_lines=more_lines)
    probe.remove()
    return str(probe.get_text())


def write_foot(figure: Figure, text: str, most_share: float | None = None) -> Text | None:
    """Write a text at the foot of a figure, above earlier texts there; return matplotlib's object for it.

    A text without room is left out, and None is returned. All texts at the foot together take at most the
    fraction ``most_share`` of the figure's height; by default FREE_FOOT if the contents of the figure
    determine this height, else MOST_FOOT.
    """
    if most_share is None:
        most_share = FREE_FOOT if getattr(figure, "free_height", False) else MOST_FOOT
    (width, height), foot_height = figure.get_size_inches(), foot_of(figure)
    text_style: dict[str, Any] = {"fontsize": "small", "color": INK, "va": "bottom", "in_layout": False}
    foot = figure.text(LEFT_MARGIN / width, foot_height + 0.5 * GAP / height, "", **text_style)
    for more_lines in (1, 0):
        foot.set_text(fitted_lines(figure, text, more_lines))
        room = (foot.get_window_extent().height / figure.dpi + GAP) / height
        if foot_height + room <= most_share:
            reserve_margins(figure, 0.0, foot_height + room)
            return foot
    foot.remove()
    return None


def foot_of(figure: Figure) -> float:
    """Return the height that is reserved for texts at the foot, relative to the height of the figure.

    The result is 0 if the figure's layout is not constrained.
    """
    engine = figure.get_layout_engine()
    return float(engine.get()["rect"][1]) if isinstance(engine, ConstrainedLayoutEngine) else 0.0


def head_of(figure: Figure) -> float:
    """Return the height that is reserved for texts at the head, relative to the height of the figure.

    The result is 0 if the figure's layout is not constrained.
    """
    engine = figure.get_layout_engine()
    if not isinstance(engine, ConstrainedLayoutEngine):
        return 0.0
    _, bottom, _, height = engine.get()["rect"]
    return 1.0 - float(bottom + height)


def reserve_margins(figure: Figure, top: float, bottom: float) -> None:
    """Keep at least the fractions ``top`` and ``bottom`` of a figure's height free above and below its axes.

    Nothing happens if the figure's layout is not constrained.
    """
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        left, bottom_edge, width, height = engine.get()["rect"]
        top_edge = min(bottom_edge + height, 1.0 - top)
        bottom_edge = max(bottom_edge, bottom)
        engine.set(rect=(left, bottom_edge, width, top_edge - bottom_edge))


def start_at_headline(figure: Figure) -> None:
    """Let nothing beside the axes of a figure start farther left than the headline.

    Nothing happens if the figure's layout is not constrained.
    """
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        left, bottom_edge, width, height = engine.get()["rect"]
        shift = (LEFT_MARGIN - mpl.rcParams["figure.constrained_layout.w_pad"]) / figure.get_figwidth() - left
        engine.set(rect=(left + shift, bottom_edge, width - shift, height))


def start_left(axes: Axes, text: Text, upward: Transform | None = None) -> None:
    """Let a text start at the left edge of its axes or, in a narrow figure, below the start of the headline.

    ``upward``: the transform of the text's vertical position; by default that of a title of the axes.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    is_small = is_narrow(figure)
    offset: Any = axes.titleOffsetTrans  # type: ignore[attr-defined]  # matplotlib's type lacks it
    text.set_x(LEFT_MARGIN / figure.get_figwidth() if is_small else 0.0)
    horizontal = figure.transFigure if is_small else axes.transAxes
    text.set_transform(blended_transform_factory(horizontal, upward or axes.transAxes + offset))


def picture_metadata(figure: Figure) -> dict[str, str]:
    """Return the metadata of a picture's file: the headline as title; other texts as description.

    The other texts are those of the figure and, of all axes, centred titles, labels, texts and legends.
    """
    title = figure.get_suptitle()
    texts = [text.get_text().replace("\n", " ") for text in figure.texts if text.get_text() != title]
    for axes in figure.axes:
        legend = axes.get_legend()
        texts += [axes.get_title(), axes.get_xlabel(), axes.get_ylabel()]
        texts += [text.get_text() for text in (*axes.texts, *(legend.get_texts() if legend else ()))]
    return {"Title": title, "Description": "\n".join(filter(None, texts)).replace("\u00a0", " ")}


def drawn_figure(draw_contents: Callable[[Figure], None], size: tuple[float, float] | None = None) -> Figure:
    """Return a new figure that ``draw_contents`` has drawn on, with the resolution of files.

    ``size``: width and height [inches]; None for matplotlib's default size.
    """
    figure = StyledFigure(figsize=size, dpi=DPI)
    draw_contents(figure)
    return figure


def save(path: str | os.PathLike[str], make: Callable[[], Figure]) -> None:
    """Write the figure that ``make`` returns into a file, in colours that suit the style in use.

    The suffix of the path determines the kind of the file. A PNG also has the texts (``picture_metadata``).

    Raises:
        OSError: when the file cannot be written.
    """
    with written_atomically(Path(path)) as new_file:
        figure = make()
        adapt_to_dark_style(figure)
        metadata = picture_metadata(figure) if Path(path).suffix == ".png" else None
        figure.savefig(new_file, dpi="figure", metadata=metadata)


def load_unit(largest_load: float, unit: str) -> tuple[float, str]:
    """Return ``prefixed_unit``, in which a unit of LOAD_UNITS stays for LEAST_LOAD ≤ ``largest_load`` < 1."""
    is_load = unit.replace("·", ".") in LOAD_UNITS
    return (1.0, unit) if is_load and LEAST_LOAD <= largest_load < 1.0 else prefixed_unit(largest_load, unit)


def force_text(value: float, unit: str) -> str:
    """Return a value > 0, in three digits at most, in the unit of ``load_unit``: "12.3 kN", "0.5 N"."""
    value = float(f"{value:.3g}")  # 9.999 is 10.0, not 10.00
    if value < 1.0 and load_unit(value, unit)[1] == unit:
        return f"{value:.3g} {unit}"
    return EngFormatter(unit, places=2 - int(np.floor(np.log10(value))) % 3)(value)


def raise_exponents(text: str) -> str:
    """Return a text for matplotlib in which exponents after ``^`` are raised: N/m$^{1.5}$ for N/m^1.5."""
    return re.sub(r"\^([\d.]+|[a-z]+)", r"$^{\1}$", text)

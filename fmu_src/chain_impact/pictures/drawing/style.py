"""The settings of matplotlib for all pictures: fonts, lines and ground, the usual sizes of figures."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.colours import PALE_GREY
from chain_impact.pictures.drawing.dark_ground import Ground

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


def is_narrow(figure: Figure) -> bool:
    """Return whether a figure is too narrow for two columns of axes (TWO_COLUMN_WIDTH)."""
    return bool(figure.get_figwidth() < TWO_COLUMN_WIDTH)

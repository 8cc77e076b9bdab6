"""Files of pictures: figures in the resolution of files, and the texts that a file has as metadata."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from chain_impact.files import written_atomically
from chain_impact.pictures.drawing.style import DPI, StyledFigure, adapt_to_dark_style


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

"""A page that a notebook shows inside a cell."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape

HEIGHT = 640  # [pixels] height of the frame in which a cell shows the page


@dataclass(frozen=True)
class InlinePage:
    """A page that a notebook shows as the value of a cell.

    Attributes:
        html: the whole page, which needs no other file.
    """

    html: str = field(repr=False)

    def _repr_html_(self) -> str:
        """Return the page inside a frame."""
        look_text = f'width="100%" height="{HEIGHT}" style="border:0"'
        return f'<iframe {look_text} srcdoc="{escape(self.html)}"></iframe>'

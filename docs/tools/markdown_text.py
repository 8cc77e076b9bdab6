"""Markdown of the generated parts of the docs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def code(text: object) -> str:
    """Return a text as inline code; empty for an empty text."""
    return f"`{text}`" if text not in ("", None) else ""


def short_description(description: str) -> str:
    """Return a description without "of (in) the joint nearer to the base", "of the model", "for its FMU"."""
    for phrase in (" of the joint nearer to the base", " in the joint nearer to the base", " of the model"):
        description = description.replace(phrase, "")
    return description.removesuffix(", for its FMU")

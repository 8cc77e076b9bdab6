"""Breaks texts into lines at allowed places, into as few lines as possible, of similar lengths."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Sequence

from matplotlib.text import Text

# pattern of a space at which a line may end: a space after a comma, a colon or a semicolon, or a space that
# is not beside =, ≤ or ±, not after +, not beside the "to" between two numbers, and not before a number, e′,
# a unit or a mark in brackets
BREAKABLE_SPACE = re.compile(
    r"(?<=[,:;]) |"
    r"(?<![=≤±+])(?<!\d to) "
    r"(?![=≤±\d−]|e′|\((?:\+|\d|dashed|outside)|to \d|[kMGmµn]?(?:N|J|m|rad|s)\b|kg\b|%)"
)
SEPARATOR = "\u00a0\u00a0·\u00a0 "  # the text between two conditions of a run; lines end here if possible
COMMA = ", "  # the text between two parts of a headline
# in a headline with MANY_LINES lines or more, parts are broken if the lines are then narrower than RAGGED
# times those of whole parts
MANY_LINES, RAGGED = 3, 0.95
HALVINGS = 8  # the number of steps of a bisection for the least width that needs no additional line


def break_lines(text: Text, room: float, parts: str = SEPARATOR, more_lines: int = 1) -> None:
    """Break a text into lines that fit into a width [pixels], as few as possible and of similar lengths.

    A part of the text is broken only if the part is longer than ``room``, or if lines of whole parts would be
    more than ``more_lines`` lines more than necessary, or if lines of the parts of a headline would be ragged
    (RAGGED). At the end of a line, the separator between two parts is left out, except a comma.

    Args:
        text: the text, which is changed.
        room: the width [pixels].
        parts: the separator between two parts.
        more_lines: how many lines more than necessary are allowed, so that parts stay whole.
    """
    whole_text, dropped_characters = text.get_text(), parts if parts != COMMA else " "

    @functools.cache
    def width(words: str) -> float:
        """Return the width of some words in the font of ``text`` [pixels]."""
        text.set_text(words)
        return float(text.get_window_extent().width)

    pieces: list[str] = []
    for part in re.split(f"(?<={re.escape(parts.rstrip(' '))}) ", whole_text):
        is_narrow = width(part.rstrip(dropped_characters)) <= room
        pieces += [part] if is_narrow else BREAKABLE_SPACE.split(part)
    lines, words = _packed_lines(pieces, room, width, dropped_characters), BREAKABLE_SPACE.split(whole_text)
    filled_lines = _packed_lines(words, room, width, dropped_characters)
    if len(lines) > len(filled_lines) + more_lines:
        lines, pieces = filled_lines, words
    lines, narrowest = _balanced(pieces, lines, room, width, dropped_characters)
    if parts == COMMA and len(filled_lines) == len(lines) >= MANY_LINES:
        of_words, narrower = _balanced(words, filled_lines, room, width, dropped_characters)
        lines = of_words if narrower < RAGGED * narrowest else lines
    text.set_text("\n".join(line.rstrip(dropped_characters) for line in lines))


def _balanced(
    pieces: Sequence[str], lines: list[str], room: float, width: Callable[[str], float], dropped: str
) -> tuple[list[str], float]:
    """Return as many lines as ``lines``, as narrow as possible, and a width that all of them keep [pixels].

    The width is nearly the least one or, for a single line, ``room``.

    The other arguments are those of ``_packed_lines``.
    """
    low, high = max(map(width, pieces), default=0.0), room
    for _ in range(HALVINGS if len(lines) > 1 else 0):
        middle = 0.5 * (low + high)
        tried_lines = _packed_lines(pieces, middle, width, dropped)
        if len(tried_lines) == len(lines):
            lines, high = tried_lines, middle
        else:
            low = middle
    return lines, high


def _packed_lines(
    pieces: Sequence[str], room: float, width: Callable[[str], float], dropped_characters: str
) -> list[str]:
    """Return lines of text, each with as many successive pieces as fit into ``room``, a width [pixels].

    ``width`` returns the width of some words [pixels]; ``dropped_characters`` has the characters that are
    left out at the end of a line, and whose width does not count there.
    """
    space = width("n n") - width("nn")
    lines: list[str] = []
    line_width = (
        math.inf
    )  # the width [pixels] of the last line and a space; infinite as long as no line exists
    for piece in pieces:
        if line_width + width(piece.rstrip(dropped_characters)) <= room:
            lines[-1] += f" {piece}"
        else:
            lines.append(piece)
            line_width = 0.0
        line_width += width(piece) + space
    return lines

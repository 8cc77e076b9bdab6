"""What is said of work that takes long."""

from __future__ import annotations

import sys
from collections.abc import Callable

Notify = Callable[[str], None]
Progress = Callable[[float], None]


class Work(str):
    """A sentence about work that is done once and then kept, and how many ``seconds`` it takes about."""

    __slots__ = ("seconds",)
    seconds: float

    def __new__(cls, sentence: str, seconds: float) -> Work:
        """The sentence, with its seconds."""
        work = super().__new__(cls, sentence)
        work.seconds = seconds
        return work

    def __getnewargs__(self) -> tuple[str, float]:  # type: ignore[override]
        """So that it can go to another process."""
        return str(self), self.seconds


class Part(float):
    """The part of a work that is done, which is counted: so many of so many."""

    __slots__ = ("done", "of")
    done: int
    of: int

    def __new__(cls, done: int, of: int) -> Part:
        """The part, with what is counted."""
        part = super().__new__(cls, done / of)
        part.done, part.of = done, of
        return part


class Fact(str):
    """A sentence that a user is told in any case, not only while something is done."""

    __slots__ = ()


def announce(sentence: str) -> None:
    """Say on standard error, in one line, what is done once and takes long, or a fact."""
    if isinstance(sentence, Fact):
        print(f"chain-impact: {sentence}", file=sys.stderr, flush=True)
    if isinstance(sentence, Work):
        text = f"chain-impact: {sentence} (about {sentence.seconds:.0f} s, then kept)"
        print(text, file=sys.stderr, flush=True)


def silent(_done: float) -> None:
    """Show nothing of the progress."""

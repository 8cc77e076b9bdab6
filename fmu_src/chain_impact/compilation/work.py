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


def announce(sentence: str) -> None:
    """Say on standard error, in one line, what is done once and takes long."""
    if isinstance(sentence, Work):
        text = f"chain-impact: {sentence} (about {sentence.seconds:.0f} s, then kept)"
        print(text, file=sys.stderr, flush=True)


def silent(_done: float) -> None:
    """Show nothing of the progress."""

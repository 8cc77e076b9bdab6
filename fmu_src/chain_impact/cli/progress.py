"""What the command line shows of work that takes its time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from rich.console import Console

from chain_impact.compilation.work import Fact, Notify, Part, announce

LINES = 10.0  # s, between two lines of progress where there is no terminal
Advance = Callable[[float], None]
out, err = Console(highlight=False), Console(stderr=True, highlight=False)


def say(text: str) -> None:
    """Print a text as it is."""
    out.print(text, markup=False, soft_wrap=True)


def complain(text: object) -> None:
    """Say on standard error what is wrong."""
    err.print(f"chain-impact: {text}", markup=False, soft_wrap=True)


@contextmanager
def progress(work: str = "simulating") -> Iterator[tuple[Notify, Advance]]:
    """A progress bar, for work that takes long enough to see it.

    Where there is no terminal, a line is written about what takes long, and now and then how far it is.

    Yields a function that says what is being done, for as long as it takes, and one that tells the fraction
    of a simulation that is done.
    """

    def describe(fraction: float) -> str:
        """What is done, and how far: in what it counts, else in percent."""
        if isinstance(fraction, Part):
            return f"{work}, {fraction.done} of {fraction.of}"
        return f"{work}, {100 * fraction:.0f} %"

    if out.quiet:
        yield lambda _: None, lambda _: None
    elif err.is_terminal:
        from chain_impact.cli.bar import progress_bar

        with progress_bar(work, describe, err) as told:
            yield told
    else:
        yield announce, now_and_then(describe)


def now_and_then(describe: Callable[[float], str]) -> Advance:
    """Write what ``describe`` says of a fraction, but not too often."""
    written = monotonic()

    def advance(fraction: float) -> None:
        nonlocal written
        if monotonic() >= written + LINES:
            announce(Fact(describe(fraction)))
            written = monotonic()

    return advance

"""Reports during work that takes its time: the package's log, and the progress."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from rich.console import Console

from chain_impact.progress import Progress, log, silent

BRIEF = 1.0  # s, for which nobody needs a progress bar
LINES = 10.0  # s, between two lines of progress where there is no terminal
out, err = Console(highlight=False), Console(stderr=True, highlight=False)


def say(text: str) -> None:
    """Print a text as it is."""
    out.print(text, markup=False, soft_wrap=True)


def complain(text: object) -> None:
    """Print an error on standard error."""
    err.print(f"chain-impact: {text}", markup=False, soft_wrap=True)


@contextmanager
def progress(work: str = "simulating") -> Iterator[Progress]:
    """Show a progress bar for work that takes long enough; yield a function that tells the finished fraction.

    Where there is no terminal, lines name the work that takes long, and now and then its progress.
    """
    if out.quiet:
        yield silent
    elif err.is_terminal:
        with _bar(work) as advance:
            yield advance
    else:
        with _listening(logging.INFO, lambda record: complain(record.getMessage())):
            yield _now_and_then(work)


@contextmanager
def _listening(level: int, tell: Callable[[logging.LogRecord], None]) -> Iterator[None]:
    """Pass the messages that the package logs to a function, from a level on."""

    def heard(record: logging.LogRecord) -> bool:
        if record.levelno >= level:
            tell(record)
        return True

    before = log.level
    log.addFilter(heard)
    log.setLevel(level)
    try:
        yield
    finally:
        log.removeFilter(heard)
        log.setLevel(before)


def _now_and_then(work: str) -> Progress:
    """Write how far some work is, but not too often."""
    written = monotonic()

    def advance(fraction: float) -> None:
        nonlocal written
        if monotonic() >= written + LINES:
            complain(_described(work, fraction))
            written = monotonic()

    return advance


def _described(work: str, fraction: float) -> str:
    return f"{work}, {100 * fraction:.0f} %"


@contextmanager
def _bar(work: str) -> Iterator[Progress]:
    """Show a bar for some work, or for the work done before it."""
    from rich import progress as rich_progress  # takes a while to import

    columns = rich_progress.TextColumn("{task.description}"), rich_progress.BarColumn(pulse_style="cyan")
    bar = rich_progress.Progress(*columns, rich_progress.TimeElapsedColumn(), console=err, transient=True)
    started, shown = monotonic(), 0.0

    def begin(sentence: str, total: float | None) -> None:
        for task in bar.task_ids:
            bar.remove_task(task)
        bar.add_task(sentence, total=total)
        bar.start()

    def tell(record: logging.LogRecord) -> None:
        if record.levelno < logging.INFO or hasattr(record, "seconds"):
            begin(record.getMessage(), None)
        else:
            complain(record.getMessage())

    def advance(fraction: float) -> None:
        nonlocal shown
        if fraction > shown + 0.01 and monotonic() > started + BRIEF:
            if not any(task.total for task in bar.tasks):
                begin(work, 1.0)
            bar.update(bar.task_ids[0], completed=fraction, description=_described(work, fraction))
            shown = fraction

    try:
        with _listening(logging.DEBUG, tell):
            yield advance
    finally:
        if bar.task_ids:
            bar.stop()

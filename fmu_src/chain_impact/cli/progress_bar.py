"""Shows the progress of long work on standard error, and the messages that the package logs meanwhile."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from chain_impact.cli import printing
from chain_impact.cli.printing import complain
from chain_impact.progress import Progress, log, no_progress

BAR_DELAY = 1.0  # [s] time after the start of work at which the progress bar of the whole work appears
# [s] the least time between two lines with the finished fraction, which stand in place of the progress bar
# where standard error is no terminal
LINE_INTERVAL = 10.0


@contextmanager
def progress(work: str = "simulating") -> Iterator[Progress]:
    """Context manager that shows the progress of long work.

    It yields a function to call with the finished fraction of the work, from 0 to 1. On a terminal it shows a
    bar. If standard error is no terminal, it prints lines: the messages that the package logs at the level
    INFO or above and, at most once in LINE_INTERVAL seconds, the finished fraction. With ``--quiet`` it shows
    nothing. ``work`` are the words for the work.
    """
    if printing.out.quiet:
        yield no_progress
    elif printing.err.is_terminal:
        with _bar(work) as advance:
            yield advance
    else:
        with _listen(logging.INFO, lambda record: complain(record.getMessage())):
            yield _limit_rate(work)


@contextmanager
def _listen(level: int, receive: Callable[[logging.LogRecord], None]) -> Iterator[None]:
    """Context manager that calls ``receive`` with each message that is logged at ``level`` or above.

    Meanwhile ``level`` is the level of the package's logger.
    """

    def receive_at_level(record: logging.LogRecord) -> bool:
        if record.levelno >= level:
            receive(record)
        return True

    earlier_level = log.level
    log.addFilter(receive_at_level)
    log.setLevel(level)
    try:
        yield
    finally:
        log.removeFilter(receive_at_level)
        log.setLevel(earlier_level)


def _limit_rate(work: str) -> Progress:
    """Return a function (fraction) that prints ``work`` and the fraction, at most once in LINE_INTERVAL."""
    written_time = monotonic()

    def advance(fraction: float) -> None:
        nonlocal written_time
        if monotonic() >= written_time + LINE_INTERVAL:
            complain(_work_text(work, fraction))
            written_time = monotonic()

    return advance


def _work_text(work: str, fraction: float) -> str:
    return f"{work}, {100 * fraction:.0f} %"


@contextmanager
def _bar(work: str) -> Iterator[Progress]:
    """Context manager that shows a progress bar on a terminal.

    It yields a function to call with the finished fraction of ``work``, from 0 to 1. The bar of ``work``
    appears after the time BAR_DELAY. When the package logs a message on a part of the work, such as a
    compilation, a bar with this message, but no fraction, replaces any other bar; other messages are printed.
    """
    from rich import progress as rich_progress  # imported here, because the import takes long

    text_column = rich_progress.TextColumn("{task.description}", markup=False)
    columns = text_column, rich_progress.BarColumn(pulse_style="cyan")
    bar = rich_progress.Progress(
        *columns, rich_progress.TimeElapsedColumn(), console=printing.err, transient=True
    )
    start_time, shown_fraction = monotonic(), 0.0

    def begin(sentence: str, total: float | None) -> None:
        for task in bar.task_ids:
            bar.remove_task(task)
        bar.add_task(sentence, total=total)
        bar.start()

    def receive(record: logging.LogRecord) -> None:
        if record.levelno < logging.INFO or hasattr(record, "seconds"):
            begin(record.getMessage(), None)
        else:
            complain(record.getMessage())

    def advance(fraction: float) -> None:
        nonlocal shown_fraction
        if fraction > shown_fraction + 0.01 and monotonic() > start_time + BAR_DELAY:
            if not any(task.total for task in bar.tasks):
                begin(work, 1.0)
            bar.update(bar.task_ids[0], completed=fraction, description=_work_text(work, fraction))
            shown_fraction = fraction

    try:
        with _listen(logging.DEBUG, receive):
            yield advance
    finally:
        if bar.task_ids:
            bar.stop()

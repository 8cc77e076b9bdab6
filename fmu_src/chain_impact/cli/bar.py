"""The progress bar on a terminal. It is imported where one is shown only, as that takes a while."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
from rich.progress_bar import ProgressBar
from rich.text import Text

from chain_impact.compilation.work import Fact, Notify, Work, announce

BRIEF = 1.0  # s, for which nobody needs a progress bar


class EstimatedBar(BarColumn):
    """A bar that moves with the time, for work of which nothing is known but how long it takes about."""

    def render(self, task: Task) -> ProgressBar:
        """The bar, which is not full before the work is done."""
        expected = task.fields.get("expected")
        if expected:
            task.total, task.completed = expected, min(task.elapsed or 0.0, 0.98 * expected)
        return super().render(task)


class TimeColumn(ProgressColumn):
    """The seconds that have passed, and how many there will be."""

    def render(self, task: Task) -> Text:
        """For example: 3 of about 12 s."""
        expected = task.fields.get("expected")
        of = f" of about {expected:.0f}" if expected else ""
        return Text(f"{task.elapsed or 0.0:.0f}{of} s", style="progress.elapsed")


@contextmanager
def progress_bar(
    work: str, describe: Callable[[float], str], console: Console
) -> Iterator[tuple[Notify, Callable[[float], None]]]:
    """A progress bar for what ``progress`` yields.

    Args:
        work: what is done.
        describe: says what is done, and how far, for a fraction.
        console: the terminal.
    """
    columns = TextColumn("{task.description}"), EstimatedBar(pulse_style="cyan"), TimeColumn()
    bar = Progress(*columns, console=console, transient=True)
    started, shown, simulating = monotonic(), 0.0, False

    def begin(sentence: str, total: float | None = None) -> None:
        nonlocal simulating
        for task in bar.task_ids:
            bar.remove_task(task)
        bar.add_task(sentence, total=total, expected=sentence.seconds if isinstance(sentence, Work) else None)
        bar.start()
        simulating = total is not None

    def notify(sentence: str) -> None:
        if isinstance(sentence, Fact):
            announce(sentence)
        else:
            begin(sentence)

    def advance(fraction: float) -> None:
        nonlocal shown
        if fraction > shown + 0.01 and monotonic() > started + BRIEF:
            if not simulating:
                begin(work, 1.0)
            bar.update(bar.task_ids[0], completed=fraction, description=describe(fraction))
            shown = fraction

    try:
        yield notify, advance
    finally:
        if bar.task_ids:
            bar.stop()

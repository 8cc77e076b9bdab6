"""What the command line shows of work that takes its time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
from rich.progress_bar import ProgressBar
from rich.text import Text

from chain_impact.compilation.work import Fact, Notify, Part, Work, announce

BRIEF = 1.0  # s, for which nobody needs a progress bar
LINES = 10.0  # s, between two lines of progress where there is no terminal
Advance = Callable[[float], None]
out, err = Console(highlight=False), Console(stderr=True, highlight=False)


def say(text: str) -> None:
    """Print a text as it is."""
    out.print(text, markup=False, soft_wrap=True)


def complain(text: object) -> None:
    """Say on standard error what is wrong."""
    err.print(f"chain-impact: {text}", markup=False, soft_wrap=True)


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


def counted(fraction: float) -> str:
    """How far a work is: in what it counts, else in percent."""
    if isinstance(fraction, Part):
        return f"{fraction.done} of {fraction.of}"
    return f"{100 * fraction:.0f} %"


@contextmanager
def progress(work: str = "simulating") -> Iterator[tuple[Notify, Advance]]:
    """A progress bar, for work that takes long enough to see it.

    Where there is no terminal, a line is written about what takes long, and now and then how far it is.

    Yields a function that says what is being done, for as long as it takes, and one that tells the fraction
    of a simulation that is done.
    """
    if out.quiet:
        yield lambda _: None, lambda _: None
        return
    columns = TextColumn("{task.description}"), EstimatedBar(pulse_style="cyan"), TimeColumn()
    bar = Progress(*columns, console=err, transient=True, disable=not err.is_terminal)
    started, shown, simulating = monotonic(), 0.0, False
    written = started

    def begin(sentence: str, total: float | None = None) -> None:
        nonlocal simulating
        for task in bar.task_ids:
            bar.remove_task(task)
        bar.add_task(sentence, total=total, expected=sentence.seconds if isinstance(sentence, Work) else None)
        bar.start()
        simulating = total is not None

    def notify(sentence: str) -> None:
        if err.is_terminal and not isinstance(sentence, Fact):
            begin(sentence)
        else:
            announce(sentence)

    def advance(fraction: float) -> None:
        nonlocal shown, written
        told = f"{work}, {counted(fraction)}"
        if not err.is_terminal:
            if monotonic() >= written + LINES:
                announce(Fact(told))
                written = monotonic()
        elif fraction > shown + 0.01 and monotonic() > started + BRIEF:
            if not simulating:
                begin(work, 1.0)
            bar.update(bar.task_ids[0], completed=fraction, description=told)
            shown = fraction

    try:
        yield notify, advance
    finally:
        if bar.task_ids:
            bar.stop()

"""Pieces of a sweep on all cores of this machine: the kernel lets other threads work while it does."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from threading import Event

from chain_impact.studies.sweep.job import Runner
from chain_impact.studies.sweep.pieces import Made, Span, hand_out
from chain_impact.studies.sweep.work import Work
from chain_impact.system import LISTEN

Done = Future[tuple[Made, float]]


class Threads:
    """Threads that do pieces of a sweep."""

    def __init__(self, work: Work, count: int) -> None:
        """Take what is done with each piece, and how many threads there shall be."""
        self.count, self._work = count, work
        self._pool, self._enough = ThreadPoolExecutor(count), Event()

    def submit(self, piece: Span) -> Done:
        """A future for a piece."""
        return self._pool.submit(self._work.do, piece, lambda: not self._enough.is_set())

    def finished(self, futures: list[Done]) -> list[Done]:
        """Those that are done, after a moment at the latest: Ctrl-C is heard in between."""
        return list(wait(futures, LISTEN, FIRST_COMPLETED).done)

    def result(self, future: Done, _piece: Span) -> tuple[Made, float]:
        """What came of a piece, and how long it took [s]."""
        return future.result()

    def stop(self, _futures: list[Done]) -> None:
        """End all threads, which takes less than a second."""
        self._enough.set()
        self._pool.shutdown(cancel_futures=True)


def run_in_threads(work: Work, spans: Sequence[Span], threads: int) -> Generator[tuple[Span, Made]]:
    """Yield what comes of the runs in some spans, piece by piece as they are done.

    Raises:
        BuildError: when the kernel cannot be compiled.
        OSError: when a file cannot be written.
    """
    Runner(work.job)  # compiles the kernel, here
    return hand_out(Threads(work, threads), spans)

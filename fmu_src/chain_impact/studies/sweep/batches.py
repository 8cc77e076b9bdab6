"""The missing runs of a sweep, divided into batches for workers.

A worker is a thread, of this process or of a process in a cluster, that computes one batch at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from functools import partial
from threading import Event

from chain_impact.studies.sweep.computation import Computation, Outcome, Span
from chain_impact.system import LISTEN

# largest number of runs in a batch: in those submitted before one has ended, and in any batch
FIRST_BATCH, LONGEST_BATCH = 8, 2**18
# [s] shortest and longest time that a batch is meant to take
SHORTEST_BATCH_TIME, LONGEST_BATCH_TIME = 0.5, 60.0
# A batch is meant to take SHARE × the time since the start of the sweep, between the two limits above. So an
# interruption, which loses the unfinished batches, loses about this part of the time.
SHARE = 0.2
# A batch has at most BATCH_RATIO times as many runs as the batch before, because the first batches are too
# short for a good estimate of the time. At the end, batches become smaller, so that all workers end at about
# the same time, but they are meant to take at least 1/BATCH_RATIO of the usual time.
BATCH_RATIO = 16
# number of batches submitted for each worker: while one is computed, the next one already waits for its
# worker
AHEAD = 2


class Batches:
    """The missing runs of a sweep, which workers take batch by batch.

    A batch takes about SHARE × the time so far, between SHORTEST_BATCH_TIME and LONGEST_BATCH_TIME, so that
    an hour of a core has about a hundred batches.
    """

    def __init__(self, spans: Sequence[Span], workers: int) -> None:
        """Store ``spans``, the missing runs in order, and the number of workers."""
        self._spans, self._workers = list(reversed(spans)), workers
        self._left = sum(end - first for first, end in spans)
        self._size, self._least, self._elapsed = FIRST_BATCH, 1, 0.0

    def take(self) -> Span | None:
        """Return the next batch as a span of runs, or None if no run is left.

        The last batches are smaller, so that all workers end at about the same time.
        """
        if not self._spans:
            return None
        first, end = self._spans.pop()
        size = min(self._size, max(self._left // (2 * self._workers), self._least))
        middle = min(end, first + size)
        if middle < end:
            self._spans.append((middle, end))
        self._left -= middle - first
        return first, middle

    def took(self, batch: Span, seconds: float) -> None:
        """Record the computing time of a batch [s]; this time determines the size of the next batches."""
        self._elapsed += seconds / self._workers
        a_second = (batch[1] - batch[0]) / max(seconds, 1e-6)
        wanted = min(max(SHORTEST_BATCH_TIME, SHARE * self._elapsed), LONGEST_BATCH_TIME)
        self._size = max(1, min(int(wanted * a_second), BATCH_RATIO * self._size, LONGEST_BATCH))
        self._least = max(1, int(wanted / BATCH_RATIO * a_second))


def hand_out(
    executor: Executor,
    count: int,
    do: Callable[[Span], tuple[Outcome, float]],
    spans: Sequence[Span],
    *,
    check: Callable[[], None] = lambda: None,
    patience: float = LISTEN,
) -> Generator[tuple[Span, Outcome]]:
    """Divide spans of runs into batches; yield each batch with its results when the executor has finished it.

    Args:
        executor: executes the batches in threads of this machine, or on the machines of a cluster.
        count: the number of workers; AHEAD × ``count`` batches are submitted at the same time.
        do: function that computes a batch, and returns the result and the computing time [s].
        spans: the runs, in order.
        check: function that is called when no batch was finished for some time; it raises an error if there
            is a fault.
        patience: the time without a finished batch after which ``check`` is called [s]; after this time at
            the latest, Ctrl-C is noticed.
    """
    batches = Batches(spans, count)
    at_work: dict[Future[tuple[Outcome, float]], Span] = {}

    def submit() -> None:
        if batch := batches.take():
            at_work[executor.submit(do, batch)] = batch

    try:
        for _ in range(AHEAD * count):
            submit()
        while at_work:
            done = wait(at_work, patience, FIRST_COMPLETED).done
            if not done:
                check()
            for future in done:
                batch = at_work.pop(future)
                rows, seconds = future.result()
                batches.took(batch, seconds)
                submit()
                yield batch, rows
    finally:
        for future in at_work:
            future.cancel()


def run_in_threads(
    computation: Computation, spans: Sequence[Span], threads: int
) -> Generator[tuple[Span, Outcome]]:
    """Compute spans of runs in threads; yield each finished batch of runs with its results.

    Other Python threads can run meanwhile. If the caller stops the iteration, all threads end within about a
    second.

    Raises:
        BuildError: when the kernel cannot be compiled.
        OSError: when a file cannot be written.
    """
    if spans:
        # compile the kernel here, or else each thread would wait for the compilation or compile it, too
        computation.runner()
    enough = Event()
    with ThreadPoolExecutor(threads) as pool:
        try:
            yield from hand_out(
                pool, threads, partial(computation.run_batch, wanted=lambda: not enough.is_set()), spans
            )
        finally:
            enough.set()


def missing(done: Sequence[Span], count: int) -> list[Span]:
    """Return the spans of the runs 0 … count − 1 that are in no span of ``done``, in order."""
    spans, start = [], 0
    for first, end in sorted(done):
        if first > start:
            spans.append((start, first))
        start = max(start, end)
    return [*spans, (start, count)] if start < count else spans

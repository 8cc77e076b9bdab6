"""The missing runs of a sweep, divided into batches for workers.

A worker is a thread, of this process or of a process in a cluster, that computes one batch at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from functools import partial
from threading import Event

from chain_impact.console import LISTEN
from chain_impact.studies.sweep.computation import Computation, Outcome, Span

# largest number of runs in a batch: FIRST_BATCH until the first batch has ended, LONGEST_BATCH afterwards
FIRST_BATCH, LONGEST_BATCH = 8, 2**18
# [s] shortest and longest time for which the size of a batch is chosen
SHORTEST_BATCH_TIME, LONGEST_BATCH_TIME = 0.5, 60.0
# The size of a batch is chosen so that its computation takes SHARE × the mean computing time of a worker so
# far, within the two limits above. So an interruption, which loses the unfinished batches, loses about this
# part of the computing time.
SHARE = 0.2
# When a batch ends, the size of the next batches grows at most by the factor BATCH_RATIO, because the first
# batches are too short for a good estimate of the time. At the end of a sweep, batches become smaller, so
# that all workers end at about the same time, but not below 1/BATCH_RATIO of the time that is chosen
# otherwise.
BATCH_RATIO = 16
# number of batches submitted for each worker: while one batch is computed, the next one waits for the worker
BATCHES_PER_WORKER = 2


class Batches:
    """The missing runs of a sweep, which workers take batch by batch.

    The size of batches follows from the computing times that ``record_time`` records (SHARE, BATCH_RATIO). An
    hour of one worker has about a hundred batches.
    """

    def __init__(self, spans: Sequence[Span], workers: int) -> None:
        """Store ``spans``, the missing runs in ascending order, and the number of workers."""
        self._spans, self._workers = list(reversed(spans)), workers
        self._rest_count = sum(end - first for first, end in spans)
        self._size, self._least_size, self._elapsed = FIRST_BATCH, 1, 0.0

    def take(self) -> Span | None:
        """Return the next batch as a span of runs, or None if all runs have been taken.

        The last batches are smaller, so that all workers end at about the same time.
        """
        if not self._spans:
            return None
        first, end = self._spans.pop()
        size = min(self._size, max(self._rest_count // (2 * self._workers), self._least_size))
        middle = min(end, first + size)
        if middle < end:
            self._spans.append((middle, end))
        self._rest_count -= middle - first
        return first, middle

    def record_time(self, batch: Span, seconds: float) -> None:
        """Record the computing time of a batch [s], and set the size of the next batches."""
        self._elapsed += seconds / self._workers
        a_second = (batch[1] - batch[0]) / max(seconds, 1e-6)
        wanted_time = min(max(SHORTEST_BATCH_TIME, SHARE * self._elapsed), LONGEST_BATCH_TIME)
        self._size = max(1, min(int(wanted_time * a_second), BATCH_RATIO * self._size, LONGEST_BATCH))
        self._least_size = max(1, int(wanted_time / BATCH_RATIO * a_second))


def run_batches(
    executor: Executor,
    count: int,
    do: Callable[[Span], tuple[Outcome, float]],
    spans: Sequence[Span],
    *,
    check: Callable[[], None] = lambda: None,
    patience: float = LISTEN,
) -> Generator[tuple[Span, Outcome]]:
    """Divide spans of runs into batches; yield each batch with its result, in the order in which they end.

    An error of ``do`` or ``check`` ends the iteration. Batches that have not begun are then cancelled.

    Args:
        executor: executes the batches in threads of this machine, or on the machines of a cluster.
        count: the number of workers; BATCHES_PER_WORKER × ``count`` batches are submitted at the same time.
        do: function that computes a batch, and returns the result and the computing time [s].
        spans: the runs, in ascending order.
        check: function that is called each time no batch has ended for ``patience``; it raises an error if
            there is a fault.
        patience: time without a finished batch [s]; after this time at the latest, Ctrl-C is noticed.
    """
    batches = Batches(spans, count)
    at_work: dict[Future[tuple[Outcome, float]], Span] = {}

    def submit() -> None:
        if batch := batches.take():
            at_work[executor.submit(do, batch)] = batch

    try:
        for _ in range(BATCHES_PER_WORKER * count):
            submit()
        while at_work:
            finished_tasks = wait(at_work, patience, FIRST_COMPLETED).done
            if not finished_tasks:
                check()
            for future in finished_tasks:
                batch = at_work.pop(future)
                rows, seconds = future.result()
                batches.record_time(batch, seconds)
                submit()
                yield batch, rows
    finally:
        for future in at_work:
            future.cancel()


def run_in_threads(
    computation: Computation, spans: Sequence[Span], threads: int
) -> Generator[tuple[Span, Outcome]]:
    """Compute spans of runs in threads of this process; yield each finished batch of runs with its result.

    Python threads of the caller can run meanwhile. If the caller closes the generator, all threads of the
    sweep end within about a second.

    Raises:
        BuildError: when the kernel cannot be compiled.
        OSError: when a file cannot be written.
    """
    if spans:
        # compile the kernel before the threads begin; otherwise each of them would compile it, or wait for it
        computation.runner()
    stop_event = Event()
    with ThreadPoolExecutor(threads) as pool:
        try:
            yield from run_batches(
                pool,
                threads,
                partial(computation.run_batch, is_wanted=lambda: not stop_event.is_set()),
                spans,
            )
        finally:
            stop_event.set()


def missing_spans(finished_spans: Sequence[Span], count: int) -> list[Span]:
    """Return the spans of the runs 0 … count − 1 that are in no span of ``finished_spans``, ascending."""
    spans, start = [], 0
    for first, end in sorted(finished_spans):
        if first > start:
            spans.append((start, first))
        start = max(start, end)
    return [*spans, (start, count)] if start < count else spans

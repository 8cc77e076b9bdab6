"""Blocks of runs on all cores of this machine: the kernel lets other threads work while it does."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from threading import Event, local
from time import perf_counter

import numpy as np

from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.job import Job, Runner
from chain_impact.studies.sweep.pieces import Pieces, Span
from chain_impact.system import LISTEN

PIECE = 0.1  # s


def run_in_threads(
    job: Job, design: Design, spans: Sequence[Span], threads: int
) -> Generator[tuple[int, np.ndarray]]:
    """Yield the rows of the runs in some spans, piece by piece as they are done: (first, rows).

    Whoever stops listening, by Ctrl-C for one, waits for less than a second until all threads have ended.
    """
    Runner(job)  # compiles the kernel, here
    pieces, enough, mine = Pieces(spans, threads, PIECE), Event(), local()

    def work() -> tuple[int, np.ndarray] | None:
        piece = pieces.take()
        if piece is None:
            return None
        mine.runner = getattr(mine, "runner", None) or Runner(job)
        started = perf_counter()
        rows = mine.runner.run(design.values(*piece), lambda: not enough.is_set())
        pieces.took(piece, perf_counter() - started)
        return (piece[0], rows) if rows is not None else None

    pool = ThreadPoolExecutor(threads)
    try:
        todo = {pool.submit(work) for _ in range(2 * threads)}  # no thread waits for who listens
        while todo:
            done, todo = wait(todo, LISTEN, FIRST_COMPLETED)
            for found in filter(None, [one.result() for one in done]):
                todo.add(pool.submit(work))
                yield found
    finally:
        enough.set()
        pool.shutdown(cancel_futures=True)

"""Blocks of runs on all cores of this machine: the kernel lets other threads work while it does."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from queue import SimpleQueue
from threading import Event, Thread
from time import perf_counter

import numpy as np

from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.job import Job, Runner
from chain_impact.studies.sweep.pieces import Pieces, Span
from chain_impact.system import next_of

PIECE = 0.1  # s


def run_in_threads(
    job: Job, design: Design, spans: Sequence[Span], threads: int
) -> Generator[tuple[int, np.ndarray]]:
    """Yield the rows of the runs in some spans, piece by piece as they are done: (first, rows).

    Whoever stops listening, by Ctrl-C for one, waits for less than a second until all threads have ended.
    """
    Runner(job)  # compiles the kernel, here
    pieces, enough = Pieces(spans, threads, PIECE), Event()
    finished: SimpleQueue[tuple[int, np.ndarray] | BaseException | None] = SimpleQueue()

    def work() -> None:
        try:
            runner = Runner(job)
            while (piece := pieces.take()) and not enough.is_set():
                started = perf_counter()
                rows = runner.run(design.values(*piece), lambda: not enough.is_set())
                if rows is not None:
                    finished.put((piece[0], rows))
                pieces.took(piece, perf_counter() - started)
            finished.put(None)
        except BaseException as error:
            finished.put(error)

    team = [Thread(target=work, daemon=True) for _ in range(threads)]
    try:
        for thread in team:
            thread.start()
        at_work = len(team)
        while at_work:
            found = next_of(finished)
            if isinstance(found, BaseException):
                raise found
            if found is None:
                at_work -= 1
            else:
                yield found
    finally:
        enough.set()
        for thread in team:
            if thread.ident is not None:
                thread.join()

"""Blocks of runs on the workers of an existing dask.distributed cluster."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from importlib.metadata import version
from time import perf_counter
from typing import Any

import numpy as np

from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.sources import fingerprint
from chain_impact.extras import require
from chain_impact.scene.reading import SceneError
from chain_impact.simulation.record_scene import RunError
from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.job import Job, Runner
from chain_impact.studies.sweep.pieces import Pieces, Span

PIECE = 1.0  # s
AHEAD = 2  # pieces for each thread of a worker, so that none waits for the network
LOST = "the connection was lost"
CONNECT, PATIENCE = 10.0, 30.0  # s, for the scheduler to answer, and without any worker


def run_on_cluster(
    job: Job, design: Design, spans: Sequence[Span], address: str
) -> Generator[tuple[int, np.ndarray]]:
    """Yield the rows of the runs in some spans, piece by piece as they are done: (first, rows).

    When a worker is lost the others take over its pieces.

    Args:
        job: what the runs share.
        design: the values of each run.
        spans: the runs.
        address: of the scheduler, ``tcp://host:port``.

    Raises:
        MissingExtraError: when distributed is not installed.
        SceneError: when there is no scheduler, or its workers do not have the same chain-impact.
        BuildError: when a worker cannot compile the kernel.
        RunError: when the cluster gives up a piece, has no workers left, or is lost.
    """
    distributed = require("distributed", "cluster")
    with _connected(distributed.Client, address) as client:
        threads = _check_workers(client, address)
        pieces = Pieces(spans, threads, PIECE)
        at_work: dict[Any, Span] = {}

        def submit() -> None:
            piece = pieces.take()
            if piece:
                at_work[client.submit(run_piece, job, design.values(*piece), pure=False)] = piece

        try:
            for _ in range(AHEAD * threads):
                submit()
            while at_work:
                for future in _finished(distributed, client, list(at_work), address):
                    piece = at_work.pop(future)
                    rows, seconds = _result(client, future, piece, job, address)
                    pieces.took(piece, seconds)
                    submit()
                    yield piece[0], rows
        finally:
            client.cancel(list(at_work))


def run_piece(job: Job, values: np.ndarray) -> tuple[np.ndarray | None, float]:
    """What a worker does: run the chain for each row of values; the rows, and how long it took [s]."""
    started = perf_counter()
    return Runner(job).run(values), perf_counter() - started


def identity() -> tuple[str, str]:
    """The version of this package, and that of its kernel's sources."""
    return version("chain-impact"), fingerprint()


def _connected(kind: Any, address: str) -> Any:
    """A client of the scheduler.

    One that cannot connect is closed here. If that were left to the garbage collector, it could happen while
    this thread starts another client and holds the lock that closing takes: neither would ever end.
    """
    client = kind.__new__(kind)
    try:
        client.__init__(address, timeout=CONNECT, set_as_default=False)
    except Exception as error:
        with suppress(Exception):
            client.close()
        client.status = "closed"  # whatever came of it, the collector has nothing left to do
        reason = str(error) or type(error).__name__
        raise SceneError(f"scheduler {address}: no dask scheduler answers there: {reason}") from None
    return client


def _check_workers(client: Any, address: str) -> int:
    """Refuse workers that would not give the same rows; return the number of their threads."""
    threads = client.nthreads()
    if not threads:
        raise SceneError(f"scheduler {address}: it has no workers; start some with: dask worker {address}")
    ours = identity()
    for worker, found in client.run(identity, on_error="return").items():
        if isinstance(found, BaseException):
            raise SceneError(
                f"scheduler {address}: the worker {worker} cannot import chain-impact ({found}); "
                f"install version {ours[0]} there"
            )
        if tuple(found) != ours:
            raise SceneError(
                f"scheduler {address}: the worker {worker} has chain-impact {found[0]} (kernel {found[1]}), "
                f"must have {ours[0]} (kernel {ours[1]}) as here"
            )
    return sum(threads.values())


def _finished(distributed: Any, client: Any, futures: list[Any], address: str) -> list[Any]:
    """Those that are done, as soon as one is."""
    while True:
        try:
            with client.as_current():
                return list(distributed.wait(futures, timeout=PATIENCE, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            _check_alive(client, address)
        except CancelledError:
            raise RunError(f"scheduler {address}: {LOST}") from None


def _result(client: Any, future: Any, piece: Span, job: Job, address: str) -> tuple[np.ndarray, float]:
    """The rows of a piece, and how long it took [s]; if a worker is lost with them, they are made again."""
    while True:
        try:
            rows, seconds = future.result(timeout=PATIENCE)
        except Exception as error:
            if isinstance(error, BuildError):
                raise
            if future.status == "error":
                name, reason = job.scene.name, f"{type(error).__name__}: {error}"
                runs = f"the runs {piece[0]} to {piece[1] - 1}"
                raise RunError(f"{name}: the cluster could not do {runs}: {reason}") from None
            if not isinstance(error, TimeoutError):
                raise RunError(f"scheduler {address}: {LOST}") from None
            _check_alive(client, address)
        else:
            return rows, seconds


def _check_alive(client: Any, address: str) -> None:
    """Go on waiting only while there are workers."""
    try:
        threads = client.nthreads()
    except OSError:
        raise RunError(f"scheduler {address}: {LOST}") from None
    if not threads:
        raise RunError(f"scheduler {address}: it has no workers left")

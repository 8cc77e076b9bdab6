"""Runs on an existing dask.distributed cluster, whose workers are processes."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.sources import fingerprint
from chain_impact.extras import require
from chain_impact.scene.errors import SceneError
from chain_impact.simulation.errors import RunError
from chain_impact.studies.sweep.batches import run_batches
from chain_impact.studies.sweep.computation import Computation, Outcome, Span

# [s] CONNECT: the time limit for an answer of the scheduler; CHECK_INTERVAL: the time without a finished
# batch of runs after which the connection and the number of workers are checked
CONNECT, CHECK_INTERVAL = 10.0, 30.0


def run_on_cluster(
    computation: Computation, spans: Sequence[Span], address: str
) -> Generator[tuple[Span, Outcome]]:
    """Compute spans of runs on a cluster; yield the span of each finished batch of runs, and the result.

    If a worker is lost, other workers compute the batches of this worker.

    Args:
        computation: the computation of each batch.
        spans: the runs to compute, in ascending order.
        address: the address of the scheduler, ``tcp://host:port``.

    Raises:
        MissingExtraError: when distributed is not installed.
        SceneError: when no scheduler answers, the cluster has no workers at the start, or a worker lacks
            chain-impact, has another version of it, or does not see the sweep's folder.
        BuildError: when a worker cannot compile the kernel.
        RunError: when the cluster cannot compute a batch, has no workers left, or the connection is lost.
    """
    connection_error = RunError(f"scheduler {address}: the connection was lost")

    def check() -> None:
        """Raise a RunError if the cluster has no workers left, or the connection is lost."""
        try:
            threads = client.nthreads()
        except OSError:
            raise connection_error from None
        if not threads:
            raise RunError(f"scheduler {address}: it has no workers left")

    with _connect(require("distributed", "cluster").Client, address) as client:
        count = _check_workers(client, computation, address)
        try:
            executor = client.get_executor(pure=False)
            yield from run_batches(
                executor, count, computation.run_batch, spans, check=check, patience=CHECK_INTERVAL
            )
        except (BuildError, RunError):
            raise
        except CancelledError:
            raise connection_error from None
        except Exception as error:
            name, reason = computation.job.scene.name, f"{type(error).__name__}: {error}"
            raise RunError(f"{name}: the cluster could not do a part of the sweep: {reason}") from None


def version_and_kernel_hash() -> tuple[str, str]:
    """Return the version of this package and the hash of the kernel's sources; workers need equal ones."""
    return version("chain-impact"), fingerprint()


def _can_read_manifest(folder: Path) -> bool:
    """Return whether this machine sees a manifest (``*.json``) in ``folder``; each worker calls this."""
    return any(folder.glob("*.json"))


def _connect(kind: Any, address: str) -> Any:
    """Return a client of the scheduler at an address; ``kind`` is the class ``distributed.Client``.

    A client that cannot connect is closed here. Otherwise the garbage collector would close this client
    later, perhaps while the thread holds a lock that closing needs, and the thread would wait forever.

    Raises:
        SceneError: when no scheduler answers within CONNECT.
    """
    client = kind.__new__(kind)
    try:
        client.__init__(address, timeout=CONNECT, set_as_default=False)
    except Exception as error:
        with suppress(Exception):
            client.close()
        client.status = "closed"  # with this status the garbage collector does not close the client again
        reason = str(error) or type(error).__name__
        raise SceneError(f"scheduler {address}: no dask scheduler answers there: {reason}") from None
    return client


def _check_workers(client: Any, computation: Computation, address: str) -> int:
    """Return the number of threads of all workers of a cluster.

    Raises:
        SceneError: when the cluster has no workers, or a worker lacks the package, has another version of the
            package or kernel, or does not see the folder of the sweep.
    """
    threads = client.nthreads()
    if not threads:
        raise SceneError(f"scheduler {address}: it has no workers; start some with: dask worker {address}")
    own_identity = version_and_kernel_hash()
    for worker, answer in client.run(version_and_kernel_hash, on_error="return").items():
        if isinstance(answer, BaseException):
            raise SceneError(
                f"scheduler {address}: the worker {worker} cannot import chain-impact ({answer}); "
                f"install version {own_identity[0]} there"
            )
        if tuple(answer) != own_identity:
            raise SceneError(
                f"scheduler {address}: the worker {worker} has chain-impact {answer[0]} "
                f"(kernel {answer[1]}), must have {own_identity[0]} (kernel {own_identity[1]}) as here"
            )
    if computation.folder:
        for worker, answer in client.run(_can_read_manifest, computation.folder).items():
            if not answer:
                raise SceneError(
                    f"scheduler {address}: the worker {worker} does not see {computation.folder}: "
                    "give a folder on a disk that all workers share, or a file, as runs.parquet"
                )
    return sum(threads.values())

"""The computation of a batch of runs: their rows are returned, or written to a file."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from uuid import uuid4

import numpy as np

from chain_impact.extras import require
from chain_impact.studies.sweep.job import Job, Runner
from chain_impact.study_data.sweep.design import Design
from chain_impact.study_data.sweep.runs import CHUNK, Columns, columns_of

Span = tuple[int, int]
"""A span of runs as a pair (first, end): the runs first … end − 1."""
Outcome = np.ndarray | str
"""The result of a batch: its rows or, for a sweep into a folder, the name of the file with the rows."""
PARQUET = ".parquet"


def write_parquet(path: Path, chunks: Iterable[Columns]) -> None:
    """Write a table to a Parquet file; ``chunks`` yields all columns of some successive rows at a time.

    Without a chunk, no file is written.

    Raises:
        MissingExtraError: when pyarrow is not installed.
        OSError: when the file cannot be written.
    """
    arrow, parquet = require("pyarrow", "sweep"), require("pyarrow.parquet", "sweep")
    with ExitStack() as stack:
        writer = None
        for columns in chunks:
            table = arrow.table(columns)
            writer = writer or stack.enter_context(
                parquet.ParquetWriter(path, table.schema, write_page_checksum=True)
            )
            writer.write_table(table)


@dataclass(frozen=True)
class Computation:
    """The computation of any batch of a sweep; a cluster sends this object to its workers.

    Attributes:
        job: the data that the runs share.
        design: the varied values of each run.
        folder: the folder to which each batch writes its rows as a Parquet file; None if rows are returned.
        own_kernel: whether the runs use a kernel for exactly the counts of the scene.
    """

    job: Job
    design: Design
    folder: Path | None = None
    own_kernel: bool = False

    def runner(self) -> Runner:
        """Return a new runner, with an instance record of its own, for the runs of a batch.

        Raises:
            BuildError: when the kernel cannot be compiled.
        """
        return Runner(self.job, own_kernel=self.own_kernel)

    def run_batch(self, batch: Span, is_wanted: Callable[[], bool] = lambda: True) -> tuple[Outcome, float]:
        """Compute the runs of a batch; return the ``Outcome`` of the batch, and the time taken [s].

        If the outcome is the name of a file, the name is temporary; ``Dataset.add`` gives the final name.

        Raises:
            CancelledError: when ``is_wanted``, which is called about once a second, returns False.
            BuildError: when the kernel cannot be compiled.
            MissingExtraError: when a file is asked for, and pyarrow is not installed.
            OSError: when the file cannot be written.
        """
        runner, start_time = self.runner(), perf_counter()

        def chunks() -> Iterator[tuple[int, np.ndarray]]:
            for first in range(batch[0], batch[1], CHUNK):
                values = self.design.values(first, min(first + CHUNK, batch[1]))
                yield first, runner.run(values, is_wanted)

        if self.folder is None:
            return np.concatenate([rows for _, rows in chunks()]), perf_counter() - start_time
        path = self.folder / f".{file_name(batch)}-{uuid4().hex}"
        try:
            write_parquet(path, (columns_of(self.design, rows, first) for first, rows in chunks()))
        except BaseException as error:
            path.unlink(missing_ok=True)
            if not isinstance(error, OSError):
                raise
            # an error of Arrow names no file, so a new error names the folder
            raise OSError(error.errno or errno.EIO, error.strerror or str(error), str(self.folder)) from None
        return path.name, perf_counter() - start_time


def file_name(batch: Span) -> str:
    """Return the final name of the file with a batch's rows; the names sort in the order of the runs."""
    return f"runs-{batch[0]:015d}{PARQUET}"

"""Sweeps: many runs of one scene, each with different values of some parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.compilation.prebuilt import missing_compilers
from chain_impact.progress import Progress, log, no_progress
from chain_impact.scene.scene import SceneSource, scene_of
from chain_impact.studies.sweep.batches import missing_spans, run_in_threads
from chain_impact.studies.sweep.cluster import run_on_cluster
from chain_impact.studies.sweep.computation import Computation, Span
from chain_impact.studies.sweep.dataset import locked_dataset, sweep_identity
from chain_impact.studies.sweep.interrupted import (
    is_complete,
    partial_path,
    restore_runs,
    store_finished_runs,
)
from chain_impact.studies.sweep.job import has_own_kernel, job_of
from chain_impact.studies.sweep.table import Sweep, is_folder, table_path, write_table
from chain_impact.study_data.sweep.design import (
    Design,
    Sampling,
    check_table_size,
    checked_integer,
    grid_design,
    sampled_design,
)
from chain_impact.study_data.sweep.runs import columns_of
from chain_impact.study_data.sweep.variation import Values, variations_of
from chain_impact.system import cores
from chain_impact.variables.prepared import PreparedScene

# From this number of missing runs on, a kernel is compiled for exactly the counts of the scene, if there is a
# compiler, and neither a cluster nor a derivative is asked for. The compilation takes about 15 s; the kernel
# is kept. With this kernel, runs of a scene with moving walls take about half the time, other runs about nine
# tenths.
OWN_KERNEL_FROM = 300_000


def sweep(
    scene: SceneSource,
    vary: Mapping[str, Values],
    *,
    samples: int | None = None,
    sampling: Sampling = "lhs",
    seed: int = 0,
    outputs: Sequence[str] = (),
    path: str | Path | None = None,
    threads: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Simulate a scene many times, each time with different values of some parameters.

    Every run gives the same bits as ``simulate`` with the values of the run. The row of a run that fails has
    a word for the fault; the sweep continues.

    Args:
        scene: a scene, or an argument of ``load_scene``.
        vary: name of a parameter of the scene's FMU, or ``simulation.stop_time`` → its values: numbers or
            names of choices, or text as on the command line: ``"0.1:0.9:9"`` for nine values from 0.1 to 0.9,
            ``"1e6:1e9:4:log"`` for four values that are equally spaced in the logarithm,
            ``"flores,zhang_sharf"``, and with ``samples`` an interval, ``"0.1:0.9"`` or ``"1e6:1e9:log"``. A
            value acts as in the FMU: an inertia that the scene derives changes with the length of the link, a
            given inertia does not.
        samples: number of runs, whose values then fill the space of the variations evenly. By default all
            combinations of the values are run.
        sampling: ``lhs``, a Latin hypercube, or ``sobol``, a scrambled Sobol' sequence.
        seed: random seed of the samples; the same seed gives the same samples.
        outputs: names of further FMU outputs, whose values at the end of each run are columns of the table.
        path: file for the table, CSV or Parquet; or a folder, which ends in ``/`` or has no suffix. Rows are
            written to the folder as they are computed, to Parquet files of some runs each, and are not kept
            in memory. After an interruption, the same call continues with the missing runs: the folder, or
            the file with the suffix ``.partial`` in the folder of the table, has the finished runs.
        threads: number of runs at the same time on this machine; the number of cores by default.
        scheduler: address of a dask.distributed scheduler, ``tcp://host:port``, whose workers compute the
            runs instead of this machine. Workers need the same version of this package, and must be able to
            write to the folder of the table, if ``path`` is a folder.
        progress: called with the finished fraction, 0 to 1, if given.

    Raises:
        SceneError: when an argument is not allowed, which is reported before any run; or when the path
            belongs to another sweep, or another sweep is writing to it.
        MissingExtraError: when a library for Parquet or a cluster is not installed.
        RunError: when the cluster cannot finish the sweep.
        OSError: when a file cannot be read or written.
        BuildError: when the kernel cannot be compiled.
    """
    scene, progress = scene_of(scene), progress or no_progress
    threads = cores() if threads is None else checked_integer(scene.name, "threads", threads)
    prepared_scene = PreparedScene(scene)
    variations = variations_of(prepared_scene, vary)
    job = job_of(prepared_scene, variations, (outputs,) if isinstance(outputs, str) else outputs)
    if samples is None:
        design = grid_design(variations, scene.name)
    else:
        design = sampled_design(variations, scene.name, count=samples, sampling=sampling, seed=seed)
    target = None if path is None else table_path(path)
    streamed = path is not None and is_folder(path)
    check_table_size(design, len(variations) + len(job.dtype.names or ()), scene.name, streamed=streamed)
    rows = np.zeros(0 if streamed else design.runs, job.dtype)
    with ExitStack() as stack:
        dataset = stack.enter_context(locked_dataset(target, job, design)) if target and streamed else None
        head = sweep_identity(job, design)
        finished_spans: list[Span] = []
        if dataset:
            finished_spans = list(dataset.files.values())
        elif target:
            finished_spans = restore_runs(target, head, rows)
        spans = missing_spans(finished_spans, design.runs)
        run_count = sum(end - first for first, end in spans)
        if target and run_count < design.runs:
            finished_text = f"{design.runs - run_count} of {design.runs} runs are kept in {target}"
            log.info("%s, %s are left", finished_text, run_count)
        if target and not dataset:
            stack.enter_context(_store_when_interrupted(target, head, rows, finished_spans, design))
        is_many = scheduler is None and run_count >= OWN_KERNEL_FROM
        own_kernel = is_many and not missing_compilers() and has_own_kernel(job)
        computation = Computation(job, design, dataset.path.resolve() if dataset else None, own_kernel)
        if scheduler is None or not spans:
            batches = run_in_threads(computation, spans, threads)
        else:
            batches = run_on_cluster(computation, spans, scheduler)
        stack.enter_context(closing(batches))
        for batch, batch_rows in batches:
            if dataset and isinstance(batch_rows, str):
                dataset.add(batch, batch_rows)
            else:
                rows[slice(*batch)] = batch_rows
                finished_spans.append(batch)
            run_count -= batch[1] - batch[0]
            progress(1.0 - run_count / design.runs)
    result = Sweep(scene, design, dataset or rows, job.outputs)
    if target and not dataset:
        result.save(target)
        partial_path(target).unlink(missing_ok=True)
    return result


@contextmanager
def _store_when_interrupted(
    table: Path, head: Mapping[str, Any], rows: np.ndarray, finished_spans: list[Span], design: Design
) -> Iterator[None]:
    """If an exception ends the ``with`` block, write the finished runs beside the table, or in it.

    Without a finished run, nothing is written. A complete table of an earlier sweep stays as it is.

    Args:
        table: the path of the table.
        head: the data that identify the sweep (``sweep_identity``).
        rows: the rows of all runs, which the block fills.
        finished_spans: the spans of the finished runs, to which the block adds.
        design: the varied values of each run.
    """
    was_complete = is_complete(table)
    try:
        yield
    except BaseException:
        if finished_spans:
            store_finished_runs(table, head, rows, finished_spans, is_complete_table=was_complete)
        if finished_spans and not was_complete:
            write_table(
                table, (columns_of(design, rows[slice(*batch)], batch[0]) for batch in sorted(finished_spans))
            )
        raise

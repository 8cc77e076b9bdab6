"""Many runs of one scene, each with other values of some parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from chain_impact.progress import Progress, log, silent
from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import SceneSource, scene_of
from chain_impact.studies.sweep.cluster import run_on_cluster
from chain_impact.studies.sweep.design import Sampling, grid, sampled
from chain_impact.studies.sweep.job import job_of
from chain_impact.studies.sweep.pieces import missing
from chain_impact.studies.sweep.resume import kept, partial_path
from chain_impact.studies.sweep.table import Sweep, table_path
from chain_impact.studies.sweep.threads import run_in_threads
from chain_impact.studies.sweep.variation import Values, variations_of
from chain_impact.system import cores
from chain_impact.variables.model import Model


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
    """Simulate a scene many times, each time with other values of some parameters.

    Every run is what ``simulate`` gives for these values, bit by bit. A run that fails is a row that says
    so; it does not end the sweep.

    Args:
        scene: what is varied: a scene, or what ``load_scene`` takes.
        vary: name of a parameter of the scene's FMU, or ``simulation.stop_time`` → its values: numbers or
            names of choices, or text as on the command line: ``"0.1:0.9:9"`` for nine values from 0.1 to
            0.9, ``"1e6:1e9:4:log"`` for four that are even in the logarithm, ``"flores,zhang_sharf"``, and
            with ``samples`` an interval, ``"0.1:0.9"`` or ``"1e6:1e9:log"``. A value replaces that
            one parameter only, as in the FMU: the inertia of a link does not follow its length.
        samples: how many runs, with values that fill the space of the variations evenly; without, all
            combinations of the values are run.
        sampling: ``lhs``, a Latin hypercube, or ``sobol``, a scrambled Sobol' sequence.
        seed: of the samples; the same seed gives the same samples.
        outputs: names of further FMU outputs for the table, as they are at the end of each run.
        path: file for the table, CSV or Parquet. Until it is whole, what is done is kept beside it, in a
            file with ``.partial`` after its name: after an interruption, the same call goes on from there.
        threads: how many runs are made at the same time; as many as there are cores by default.
        scheduler: address of a dask.distributed scheduler, ``tcp://host:port``, whose workers do the runs in
            place of this machine. They need the same version of this package.
        progress: called with the fraction done, if given.

    Raises:
        SceneError: when an argument is not allowed, which is said before any run; or when another sweep has
            left a partial table at the path, or writes one there now.
        MissingExtraError: when a library is not installed that samples, Parquet or a cluster need.
        RunError: when the cluster cannot finish the sweep.
        OSError: when a file cannot be read or written.
        BuildError: when the kernel cannot be compiled.
    """
    scene, progress = scene_of(scene), progress or silent
    threads = cores() if threads is None else threads
    if not isinstance(threads, int) or threads < 1:
        raise SceneError(f"{scene.name}: threads = {threads} must be a whole number >= 1")
    model = Model(scene)
    variations = variations_of(model, vary)
    job = job_of(model, variations, outputs)
    columns = len(variations) + len(job.dtype.names or ())
    if samples is None:
        design = grid(variations, columns, scene.name)
    else:
        design = sampled(variations, columns, scene.name, count=samples, sampling=sampling, seed=seed)
    rows = np.zeros(len(design), job.dtype)
    target = table_path(path) if path else None
    with kept(target, job, design, rows) as book:
        spans = missing(book.done, len(rows))
        left = sum(end - first for first, end in spans)
        if target and left < len(rows):
            there = f"{len(rows) - left} of {len(rows)} runs are kept in {partial_path(target)}"
            log.info("%s, %s are left", there, left)
        if scheduler is None:
            pieces = run_in_threads(job, design, spans, threads)
        else:
            pieces = run_on_cluster(job, design, spans, scheduler)
        with closing(pieces):
            for first, block in pieces:
                rows[first : first + len(block)] = block
                book.keep(first, block)
                left -= len(block)
                progress(1.0 - left / len(rows))
        found = Sweep(scene, design, rows, job.outputs)
        if target:
            found.save(target)
        book.remove()
    return found

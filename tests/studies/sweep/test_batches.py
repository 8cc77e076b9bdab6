"""Batches of a sweep cover the missing runs exactly once, and are sized by their expected time.

The rows do not depend on the number of threads and the sizes of batches.
"""

# Tests: studies/sweep/job.py, studies/sweep/computation.py

import threading
from concurrent.futures import CancelledError

import numpy as np
import pytest

from chain_impact.compilation.errors import BuildError
from chain_impact.kernel.status import OK
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene, with_values
from chain_impact.simulation import kernels
from chain_impact.studies.sweep.batches import (
    LONGEST_BATCH,
    LONGEST_BATCH_TIME,
    SHORTEST_BATCH_TIME,
    Batches,
    missing_spans,
    run_in_threads,
)
from chain_impact.studies.sweep.computation import Computation
from chain_impact.studies.sweep.job import Runner, job_of
from chain_impact.studies.sweep.sweep import sweep
from chain_impact.study_data.sweep.design import grid_design
from chain_impact.study_data.sweep.variation import variations_of


@pytest.mark.parametrize(
    ("finished_spans", "expected"),
    [
        ([], [(0, 100)]),
        ([(0, 100)], []),
        ([(40, 60), (0, 10)], [(10, 40), (60, 100)]),
        ([(90, 100), (20, 30), (20, 30), (25, 40)], [(0, 20), (40, 90)]),
    ],
)
def test_missing_runs_are_those_between_finished_ones(finished_spans, expected):
    assert missing_spans(finished_spans, 100) == expected


def taken(batches, seconds_a_run):
    while batch := batches.take():
        batches.record_time(batch, (batch[1] - batch[0]) * seconds_a_run)
        yield batch


@pytest.mark.parametrize("seconds_a_run", [0.0, 1e-5, 1e-3, 10.0])
def test_batches_cover_the_spans(seconds_a_run):
    spans = [(3, 10), (20, 20_000)]
    batches = list(taken(Batches(spans, 2), seconds_a_run))
    runs = [run for first, end in batches for run in range(first, end)]
    assert runs == [run for first, end in spans for run in range(first, end)]


def test_batches_take_a_part_of_the_time_so_far():
    batches = list(taken(Batches([(0, 1_000_000)], 2), 1e-3))
    sizes = [end - first for first, end in batches]
    for (first, _), size in zip(batches[2:], sizes[2:], strict=True):
        assert size <= max(1000 * SHORTEST_BATCH_TIME, 0.11 * first)
    assert max(sizes) == 1000 * LONGEST_BATCH_TIME
    assert len(sizes) < 150
    assert sizes[-1] < 0.1 * max(sizes)  # at the end, all threads get a share
    assert max(end - first for first, end in taken(Batches([(0, 10**7)], 2), 1e-9)) == LONGEST_BATCH


SCENE = with_values(
    load_scene("four_link_box"), {("simulation", "stop_time"): 0.6, ("solver", "tolerance"): 1e-6}
)


def parts(vary):
    variations = variations_of(SCENE, vary)
    return job_of(SCENE, variations, ()), grid_design(variations, SCENE.name)


@pytest.mark.full("takes long")
def test_rows_do_not_depend_on_threads():
    # more rows than the kernel computes in one call, so that it pauses within a run and continues
    vary = {"contact.restitution": "0.3:0.7:15000"}
    job, design = parts(vary)
    at_once = Runner(job).run(design.values(0, 15000))
    for threads in (1, 2, 5):
        assert sweep(SCENE, vary, threads=threads).rows.tobytes() == at_once.tobytes()


@pytest.mark.full("takes long")
def test_the_kernel_pauses_within_a_second():
    job, design = parts({"contact.restitution": "0.3:0.7:15000"})
    runner, calls = Runner(job), []

    def goes_on():
        calls.append(1)
        return len(calls) < 2

    with pytest.raises(CancelledError):
        runner.run(design.values(0, 15000), goes_on)
    assert len(calls) == 2


@pytest.mark.full("compiles a kernel")
def test_a_kernel_for_the_sizes_of_a_scene_gives_the_same_bits():
    scene = load_scene("bouncing_table")
    variations = variations_of(scene, {"contact.restitution": "0.3:0.7:100"})
    job, values = job_of(scene, variations, ()), grid_design(variations, scene.name).values(0, 100)
    assert Runner(job, own_kernel=True).run(values).tobytes() == Runner(job).run(values).tobytes()


@pytest.mark.parametrize(("runs", "has_own"), [(9, False), (10, True)])
def test_a_sweep_of_many_runs_asks_for_a_kernel_of_its_own(monkeypatch, runs, has_own):
    scopes = []

    def kernel_for(scene, *, derivatives, scope):
        scopes.append(scope)
        return kernels.kernel_for(scene, derivatives=derivatives)

    monkeypatch.setattr("chain_impact.studies.sweep.job.kernel_for", kernel_for)
    monkeypatch.setattr("chain_impact.studies.sweep.sweep.OWN_KERNEL_FROM", 10)
    monkeypatch.setattr("chain_impact.studies.sweep.sweep.missing_compilers", list)
    sweep(SCENE, {"contact.restitution": f"0.3:0.7:{runs}"})
    assert scopes[0] == ((4, 20, 0, 0, 0, 0, 0, 0, 0, 0) if has_own else None)


def test_a_sweep_goes_on_with_a_general_kernel_where_a_compiler_fails(monkeypatch, caplog):
    def kernel_for(scene, *, derivatives, scope):
        if scope:
            raise BuildError("could not compile the kernel: zig said no")
        return kernels.kernel_for(scene, derivatives=derivatives)

    monkeypatch.setattr("chain_impact.studies.sweep.job.kernel_for", kernel_for)
    monkeypatch.setattr("chain_impact.studies.sweep.sweep.OWN_KERNEL_FROM", 10)
    monkeypatch.setattr("chain_impact.studies.sweep.sweep.missing_compilers", list)
    runs = sweep(SCENE, {"contact.restitution": "0.3:0.7:40"}, threads=2)
    assert (runs["solver.status"] == OK).all()
    (warning,) = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert "zig said no" in warning
    assert SCENE.name in warning


def test_a_caller_that_stops_listening_gets_all_threads_back():
    thread_count = threading.active_count()
    batches = run_in_threads(Computation(*parts({"contact.restitution": "0.3:0.7:100000"})), [(0, 100000)], 2)
    _, rows = next(batches)
    assert rows["solver.steps"].all()
    batches.close()
    assert threading.active_count() == thread_count


def test_an_error_in_a_thread_is_raised_here(monkeypatch):
    work = Computation(*parts({"contact.restitution": "0.3:0.7:100"}))

    def broken(*_):
        raise MemoryError("no room")

    monkeypatch.setattr(Runner, "run", broken)
    with pytest.raises(MemoryError, match="no room"):
        list(run_in_threads(work, [(0, 100)], 2))


@pytest.mark.parametrize("threads", [0, 1.5, True])
def test_threads_are_checked(threads):
    with pytest.raises(SceneError, match=f"threads = {threads} must be a whole number >= 1"):
        sweep(SCENE, {"contact.restitution": [0.5]}, threads=threads)


def test_whole_numbers_of_numpy_are_those_of_python():
    vary = {"contact.restitution": "0.3:0.7"}
    runs = sweep(SCENE, vary, samples=4, seed=1, threads=2)
    numpy_runs = sweep(SCENE, vary, samples=np.int64(4), seed=np.int8(1), threads=np.int64(2))
    assert numpy_runs.to_dataframe().equals(runs.to_dataframe())


def test_progress_ends_at_one():
    fractions = []
    sweep(SCENE, {"contact.restitution": "0.3:0.7:100"}, progress=fractions.append)
    assert fractions[-1] == 1.0
    assert (np.diff(fractions) > 0.0).all()

"""A sweep on a real dask scheduler with two workers gives the rows of a local sweep."""

import os
import re
import subprocess
import sys
import time
from functools import partial

import pytest

from chain_impact.compilation.errors import BuildError
from chain_impact.extras import MissingExtraError
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.errors import RunError
from chain_impact.studies.sweep import cluster
from chain_impact.studies.sweep.computation import Computation
from chain_impact.studies.sweep.sweep import sweep
from tests.tiers import needs_interop

SCENE = load_scene("four_link_box").with_values({"simulation.stop_time": 0.6, "solver.tolerance": 1e-6})
VARY = {"contact.restitution": "0.3:0.7:500", "contact.model": "flores,newton_impact"}
pytestmark = needs_interop


class Cluster:
    """A scheduler and its workers, each a process."""

    def __init__(self, folder):
        self.folder, self.processes = folder, []
        log = self.start("scheduler", "--port", "0", "--no-dashboard")
        self.address = self.wait_for(log, r"(tcp://127\.0\.0\.1:\d+)")

    def start(self, kind, *arguments, **environment):
        log = self.folder / f"{kind}-{len(self.processes)}.log"
        command = [sys.executable, "-m", "dask", kind, *arguments, "--host", "127.0.0.1"]
        with log.open("w") as file:
            self.processes.append(
                subprocess.Popen(
                    command, cwd=self.folder, env=os.environ | environment, stdout=file, stderr=file
                )
            )
        return log

    def worker(self, **environment):
        options = ("--nthreads", "1", "--no-dashboard", "--no-nanny", "--local-directory", str(self.folder))
        log = self.start("worker", self.address, *options, **environment)
        self.wait_for(log, r"(Registered to)")
        return self.processes[-1]

    def wait_for(self, log, pattern):
        deadline = time.monotonic() + 600.0
        while not (match := re.search(pattern, log.read_text(encoding="utf-8"))):
            assert time.monotonic() < deadline, log.read_text(encoding="utf-8")
            time.sleep(0.05)
        return match[1]

    def end(self):
        for process in reversed(self.processes):
            process.kill()
            process.wait()


@pytest.fixture
def scheduler(tmp_path):
    started = Cluster(tmp_path)
    yield started
    started.end()


def test_a_sweep_on_a_cluster_has_the_rows_of_a_local_one(scheduler, tmp_path):
    scheduler.worker()
    scheduler.worker()
    fractions = []
    path = tmp_path / "out.csv"
    runs = sweep(SCENE, VARY, scheduler=scheduler.address, path=path, progress=fractions.append)
    assert runs.rows.tobytes() == sweep(SCENE, VARY).rows.tobytes()
    assert fractions[-1] == 1.0
    assert len(fractions) > 4
    assert path.read_text(encoding="utf-8").count("\n") == 1001


def test_a_lost_worker_is_replaced_by_the_others(scheduler):
    scheduler.worker()
    doomed = scheduler.worker()
    vary = {"contact.restitution": "0.3:0.7:8000"}

    def progress(part):
        if part > 0.2:
            doomed.kill()

    runs = sweep(SCENE, vary, scheduler=scheduler.address, progress=progress)
    assert runs.rows.tobytes() == sweep(SCENE, vary).rows.tobytes()
    assert doomed.poll() is not None


def test_a_cluster_without_workers_is_refused(scheduler):
    with pytest.raises(
        SceneError, match=r"scheduler tcp://.*: it has no workers; start some with: dask worker"
    ):
        sweep(SCENE, VARY, scheduler=scheduler.address)


def test_no_workers_left(scheduler, monkeypatch):
    monkeypatch.setattr(cluster, "CHECK_INTERVAL", 0.5)
    worker = scheduler.worker()
    with pytest.raises(RunError, match="it has no workers left"):
        sweep(
            SCENE,
            {"contact.restitution": "0.3:0.7:100000"},
            scheduler=scheduler.address,
            progress=lambda _: worker.kill(),
        )


def test_a_worker_without_the_package(scheduler, tmp_path):
    package = tmp_path / "without" / "chain_impact"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("raise ImportError('not installed here')\n")
    scheduler.worker(PYTHONPATH=str(package.parent))
    with pytest.raises(SceneError, match=r"the worker tcp://.* cannot import chain-impact \(.*\); install"):
        sweep(SCENE, VARY, scheduler=scheduler.address)


def test_a_worker_with_another_version(scheduler, monkeypatch):
    scheduler.worker()
    monkeypatch.setattr(cluster, "version_and_kernel_hash", Other())
    with pytest.raises(SceneError, match=r"must have 9\.9 \(kernel abc\) as here"):
        sweep(SCENE, VARY, scheduler=scheduler.address)


class Other:
    """A version other than that of the workers: pickled as a name, it is their own function there."""

    def __call__(self):
        return "9.9", "abc"

    def __reduce__(self):
        return "version_and_kernel_hash"

    __module__, __qualname__ = cluster.__name__, "version_and_kernel_hash"


@pytest.mark.parametrize(
    "address", ["tcp:", "tls://127.0.0.1:9", "inproc://127.0.0.1/1/1", "tcp://127.0.0.1:9"]
)
def test_a_client_that_could_not_connect_is_closed(address, monkeypatch):
    """Otherwise the garbage collector would close the client, and could wait forever while another starts."""
    monkeypatch.setattr(cluster, "CONNECT", 0.5)
    from distributed import Client

    clients, initialize = [], Client.__init__
    monkeypatch.setattr(
        Client, "__init__", lambda self, *a, **k: (clients.append(self), initialize(self, *a, **k))[1]
    )
    with pytest.raises(SceneError, match="no dask scheduler answers there"):
        sweep(SCENE, VARY, scheduler=address)
    assert [client.status for client in clients] == ["closed"]


def test_without_distributed_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match=r"^distributed.*pip install '.*(\[cluster\]|distributed)"):
        sweep(SCENE, VARY, scheduler="tcp://127.0.0.1:9")


def test_a_worker_that_can_keep_no_kernel(scheduler):
    scheduler.worker(CHAIN_IMPACT_CACHE="/dev/null/kernels")
    with pytest.raises(BuildError, match=r"no kernel can be stored in /dev/null/kernels \(Not a directory\)"):
        sweep(SCENE, VARY, scheduler=scheduler.address)


def test_a_batch_that_a_worker_cannot_do(scheduler, monkeypatch):
    scheduler.worker()
    monkeypatch.setattr(Computation, "run_batch", property(lambda _: partial(int, "odd")))
    with pytest.raises(RunError, match="FourLinkBox: the cluster could not do a part of the sweep: TypeErr"):
        sweep(SCENE, VARY, scheduler=scheduler.address)


def test_the_scheduler_dies(scheduler):
    scheduler.worker()

    def progress(_):
        scheduler.processes[0].kill()

    with pytest.raises(RunError, match="the connection was lost"):
        sweep(
            SCENE, {"contact.restitution": "0.3:0.7:100000"}, scheduler=scheduler.address, progress=progress
        )

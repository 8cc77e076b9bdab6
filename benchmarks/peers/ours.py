"""Our contenders: the kernel, the function ``simulate()``, and the steps of the FMU."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from ctypes import c_double, c_uint
from functools import cache
from typing import Any

import fmpy.fmi2
import numpy as np

from benchmarks.peers import Contender, Outcome
from benchmarks.problems import PROBLEMS, Onsets, Problem
from chain_impact import build_fmu
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.simulate import simulate
from tests.helpers.kernel.kernel_calls import kernel_of

STEP = 1e-3  # [s] communication step of the FMU


class OnInstance:
    """One instance, reset to its start for each run."""

    def __init__(self, scene: Scene, stop: float) -> None:
        self.instance, self.stop = Instance(scene), stop
        # the record is copied as bytes, because a copy of a record copies its fields one by one
        self.block = self.instance.words.view(np.uint8)
        self.fresh = self.block.copy()
        self.kernel, self.address = kernel_of(self.instance), self.block.ctypes.data

    def observed(self) -> tuple[np.ndarray, Onsets]:
        """Return the state, and candidate and time of each onset that the log has, in order of time."""
        self.kernel.observe_now(self.address)
        record = self.instance.record
        out, candidate = record["output"], record["candidate"]
        state = np.concatenate(
            [out["point_position"][0], out["angle"], out["point_velocity"][0], out["angular_velocity"]]
        )
        pairs = list(zip(candidate["point"], candidate["wall"], strict=True))
        # ``count`` counts all contacts, but the log has only the latest, so ``count`` is cut to its rows
        log = record["contact_log"]
        log["count"] = min(log["count"], len(log["point"]))
        rows = np.concatenate([self.instance.collect(), self.instance.open_contacts()])
        onsets = [(pairs.index((row["point"], row["wall"])), float(row["onset"])) for row in rows]
        return state, sorted(onsets, key=lambda row: row[1])


class Kernel(OnInstance):
    """The kernel functions ``initialize`` and ``advance_to`` as a contender."""

    def run(self) -> Any:
        """Run from the parameters to the end; return the status, a whole number."""
        self.block[:] = self.fresh
        self.kernel.initialize(self.address, 0.0)
        return self.kernel.advance_to(self.address, self.stop)

    def outcome(self) -> Outcome:
        """Return state, onsets and the counts of the statistics."""
        status, counts = self.run(), self.instance.statistics
        failed = STATUS_TEXT[int(status)] if status else ""
        return Outcome(*self.observed(), counts["steps"], counts["rhs_evaluations"], failed)


class Simulate(Kernel):
    """``simulate()`` of a scene with another tolerance, and a row of outputs for each millisecond."""

    def __init__(self, problem: Problem, tolerance: float, stop: float) -> None:
        super().__init__(problem.scene(tolerance), stop)
        self.base, self.values = problem.base, {"solver.tolerance": tolerance}

    def run(self) -> None:
        """Call ``simulate`` once."""
        simulate(self.base.with_values(self.values), stop_time=self.stop)

    def outcome(self) -> Outcome:
        """Return the outcome of the kernel, which ``simulate`` runs."""
        return Kernel.outcome(Kernel(self.base.with_values(self.values), self.stop))


class Fmu(Simulate):
    """The native FMU in FMPy: a reset, then steps of 1 ms, each with a reading of the tip."""

    def __init__(self, problem: Problem, tolerance: float, stop: float) -> None:
        super().__init__(problem, tolerance, stop)
        folder = unpacked(problem.name)
        description = fmpy.read_model_description(folder)
        numbers = {variable.name: variable.valueReference for variable in description.modelVariables}
        tip = f"point[{len(problem.base.chain.links)}]"
        self.read = (c_uint * 2)(numbers[f"{tip}.x"], numbers[f"{tip}.y"])
        self.place = (c_double * 2)()
        self.tolerance = [numbers["solver.tolerance"]], [tolerance]
        self.fmu = fmpy.fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.fmu.instantiate()

    def run(self) -> None:
        """Run from the parameters to the end."""
        self.fmu.reset()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.setReal(*self.tolerance)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        step, get = self.fmu._functions["fmi2DoStep"], self.fmu._functions["fmi2GetReal"]
        bad = 0
        for k in range(round(self.stop / STEP)):
            bad |= step(self.fmu.component, k * STEP, STEP, 1)
            bad |= get(self.fmu.component, self.read, 2, self.place)
        assert bad == 0


@cache
def unpacked(name: str) -> str:
    """Return the folder of a problem's FMU, which is removed when the process ends."""
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return str(fmpy.extract(build_fmu(PROBLEMS[name].base, folder, target="native"), folder))


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Return the functions that users call, and the kernel alone."""
    return {
        "chain-impact": Simulate(problem, tolerance, stop),
        "chain-impact, FMU": Fmu(problem, tolerance, stop),
        "kernel alone": Kernel(problem.scene(tolerance), stop),
    }

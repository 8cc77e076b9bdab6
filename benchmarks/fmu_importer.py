"""The importing side of fmu_cost.py and fmu_native.py: fmpy and pythonfmu, and nothing of this project.

A process of its own: ``fmu_importer.py run OUTPUTS NAME=FMU …`` times FMUs in turn, ``fmu_importer.py start
OUTPUTS NAME=FMU`` one from cold. Either prints JSON.
"""

from __future__ import annotations

import json
import shutil
import sys
import time
from collections.abc import Callable
from ctypes import c_double, c_uint

import common
import fmpy
from fmpy.fmi2 import FMU2Slave

STOP, STEP = 2.0, 1e-3
ROUNDS = 15


class Importer:
    """One FMU, unzipped, and one instance at a time of it."""

    def __init__(self, path: str, outputs: int) -> None:
        self.description = fmpy.read_model_description(path)
        self.folder = fmpy.extract(path)
        # positions, velocities and accelerations of the points: the first Real outputs
        reals = [v for v in self.description.modelVariables if v.causality == "output" and v.type == "Real"]
        self.names = [variable.name for variable in reals[:outputs]]
        self.references = (c_uint * outputs)(*(v.valueReference for v in reals[:outputs]))
        self.values = (c_double * outputs)()
        self.count = outputs

    def start(self) -> None:
        """Instantiate and initialise."""
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0, stopTime=STOP)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def run(self) -> float:
        """Every step of the scenario through the C functions; returns CPU seconds."""
        step, get = self.fmu._functions["fmi2DoStep"], self.fmu._functions["fmi2GetReal"]
        component, references, values, count = self.fmu.component, self.references, self.values, self.count
        bad = 0
        begin = time.process_time()
        for k in range(round(STOP / STEP)):
            bad |= step(component, k * STEP, STEP, 1)
            bad |= get(component, references, count, values)
        seconds = time.process_time() - begin
        assert bad == 0
        return seconds

    def end(self) -> None:
        """Free the instance."""
        self.fmu.terminate()
        self.fmu.freeInstance()

    def whole(self) -> float:
        """The same scenario through fmpy.simulate_fmu; returns CPU seconds."""
        begin = time.process_time()
        fmpy.simulate_fmu(
            self.folder, validate=False, stop_time=STOP, step_size=STEP, output_interval=STEP,
            output=self.names, model_description=self.description,
        )  # fmt: skip
        return time.process_time() - begin


def turns(contenders: dict[str, Callable[[], float]]) -> common.Timings:
    """Each contender's own seconds, in turn."""
    timings: common.Timings = {name: [] for name in contenders}
    for _ in range(ROUNDS):
        for name, call in contenders.items():
            timings[name].append(call())
    return timings


def once(importer: Importer) -> float:
    """One scenario in a new instance."""
    importer.start()
    seconds = importer.run()
    importer.end()
    return seconds


def later_start(importer: Importer) -> float:
    """Instantiate and initialise, when the process has done so before."""
    begin = time.process_time()
    importer.start()
    seconds = time.process_time() - begin
    importer.end()
    return seconds


TASKS = {
    "raw": (once, "microseconds a step", 1e6 * STEP / STOP),
    "simulate_fmu": (Importer.whole, "milliseconds", 1e3),
    "later instance": (later_start, "milliseconds", 1e3),
}
"""What is timed: a function, the unit, and how many of it a second is."""


def compare(importers: dict[str, Importer]) -> dict:
    """The FMUs in turn, and the ratios of the first to the others."""
    results: dict = {}
    first, *others = importers
    for name, (function, unit, scale) in TASKS.items():
        for importer in importers.values():
            function(importer)
        timings = turns({who: lambda f=function, i=importer: f(i) for who, importer in importers.items()})
        results[name] = {
            unit: {who: common.median([scale * value for value in row]) for who, row in timings.items()},
            **{f"{first} / {other}": common.ratio(timings, first, other) for other in others},
        }
    return results


def cold(importer: Importer) -> float:
    """Milliseconds to start the first instance of a process."""
    begin = time.perf_counter()
    importer.start()
    return 1e3 * (time.perf_counter() - begin)


def main() -> None:
    """Measure what the command line says."""
    task, outputs, *fmus = sys.argv[1:]
    importers = {name: Importer(path, int(outputs)) for name, path in (fmu.split("=", 1) for fmu in fmus)}
    results = compare(importers) if task == "run" else cold(*importers.values())
    assert not {"chain_impact", "numba", "scipy"} & set(sys.modules)
    print(json.dumps(results))
    for importer in importers.values():
        shutil.rmtree(importer.folder, ignore_errors=True)


if __name__ == "__main__":
    main()

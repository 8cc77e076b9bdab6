"""The importing side of fmu_native.py: fmpy and pythonfmu, and nothing of this project.

A process of its own: ``fmu_importer.py OUTPUTS NAME=FMU …`` times FMUs in turn, and prints JSON.
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


TASKS = {"a step [µs]": (once, 1e6 * STEP / STOP), "instance [ms]": (later_start, 1e3)}
"""What is timed: a function, and how many of its unit a second is."""


def main() -> None:
    """Time the FMUs that the command line names in turn; the ratio is that of the second to the first."""
    outputs, *fmus = sys.argv[1:]
    importers = {name: Importer(path, int(outputs)) for name, path in (fmu.split("=", 1) for fmu in fmus)}
    first, second = importers
    results = {}
    for name, (function, scale) in TASKS.items():
        for importer in importers.values():
            function(importer)
        timings = turns({who: lambda f=function, i=importer: f(i) for who, importer in importers.items()})
        results[name] = {who: common.median([scale * value for value in row]) for who, row in timings.items()}
        results[name][f"{second} / {first}"] = common.ratio(timings, second, first)
    assert not {"chain_impact", "numba", "scipy"} & set(sys.modules)
    print(json.dumps(results))
    for importer in importers.values():
        shutil.rmtree(importer.folder, ignore_errors=True)


if __name__ == "__main__":
    main()

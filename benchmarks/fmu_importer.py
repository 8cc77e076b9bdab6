"""The importing side of fmu_cost.py, a process of its own: fmpy and pythonfmu, and nothing of this project.

``fmu_importer.py run OURS EMPTY BARE OUTPUTS`` times all three in turn, ``fmu_importer.py start FMU OUTPUTS``
one from cold. Either prints JSON.
"""

from __future__ import annotations

import json
import resource
import shutil
import sys
import time
from collections.abc import Callable
from ctypes import c_double, c_uint
from pathlib import Path

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


def compare(**importers: Importer) -> dict:
    """The FMUs in turn."""
    results, steps = {}, round(STOP / STEP)
    for name, function, unit, scale in (
        ("raw", once, "microseconds a step", 1e6 / steps),
        ("simulate_fmu", Importer.whole, "milliseconds", 1e3),
        ("later instance", later_start, "milliseconds", 1e3),
    ):
        for importer in importers.values():
            function(importer)
        timings = turns({who: lambda f=function, i=importer: f(i) for who, importer in importers.items()})
        results[name] = {
            unit: {who: common.median([scale * value for value in row]) for who, row in timings.items()},
            "ours / empty": common.ratio(timings, "ours", "empty"),
            "ours / bare": common.ratio(timings, "ours", "bare"),
        }
    return results


def cold(importer: Importer) -> dict:
    """Start and memory of the first instance of a process, and of ten more."""
    before, begin = memory(), time.perf_counter()
    importer.start()
    seconds = time.perf_counter() - begin
    importer.run()
    first = memory()
    kept = []
    for _ in range(10):
        importer.start()
        kept.append(importer.fmu)
    return {
        "instantiate and initialise [ms]": 1e3 * seconds,
        "memory of the first instance and its run [kB]": first - before,
        "memory of each further instance [kB]": (memory() - first) / 10,
        "peak memory of the process [kB]": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
    }


def memory() -> float:
    """Resident memory [kB]."""
    return (
        int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1]) * resource.getpagesize() / 1024
    )


def main() -> None:
    """Measure what the command line says."""
    task, *paths, outputs = sys.argv[1:]
    importers = [Importer(path, int(outputs)) for path in paths]
    if task == "run":
        results = compare(**dict(zip(("ours", "empty", "bare"), importers, strict=True)))
    else:
        results = cold(*importers)
    assert not {"chain_impact", "numba", "scipy"} & set(sys.modules)
    print(json.dumps(results))
    for importer in importers:
        shutil.rmtree(importer.folder, ignore_errors=True)


if __name__ == "__main__":
    main()

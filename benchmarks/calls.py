"""The cost of a call without its run: ``python -m benchmarks calls [--quick]``.

The CPU time of a call of ``simulate()`` for the default scene to 1.2 s is divided by that of a run in a sweep
with one thread. FMUs take steps of 1 ms in FMPy, with one output; an FMU without content shows the time of
FMPy and pythonfmu themselves. All contenders take turns, so that other work on the machine slows all of them.
"""

from __future__ import annotations

import math
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import fmpy

import chain_impact
from benchmarks import common
from chain_impact import build_fmu, load_scene, simulate, sweep

STOP, ROW = 1.2, 1e-3  # [s] stop time; time between two rows, and step of FMUs
TOLERANCES = (1e-4, 1e-8)
NAME = "contact.restitution"
ROUNDS, RUNS = 9, 500
EMPTY = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Empty(Fmi2Slave):
    """Does nothing."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x = 1.0
        self.register_variable(Real("x", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        return True
'''


def calls(tolerance: float) -> dict[str, Callable[[], object]]:
    """Return the calls of ``simulate()``, and the runs in a sweep that they are compared with."""
    settings = {"solver.tolerance": tolerance, "simulation.stop_time": STOP}
    scene = load_scene("four_link_box").with_values(settings)
    value = scene.values[NAME]
    values = [value + 1e-9 * k for k in range(RUNS)]
    other_values = iter(values * RUNS)
    return {
        "sweep": lambda: sweep(scene, {NAME: values}, threads=1),
        "a row each ms, all outputs": lambda: simulate(scene, output_step=ROW),
        "a row each ms, one output": lambda: simulate(scene, output_step=ROW, output="point[4].x"),
        "a row each ms, no output": lambda: simulate(scene, output_step=ROW, output=[]),
        "two rows": lambda: simulate(scene, output_step=math.inf),
        "two rows of with_values": lambda: simulate(
            scene.with_values({NAME: next(other_values)}), output_step=math.inf
        ),
    }


def steps(folder: Path) -> dict[str, Callable[[], object]]:
    """Return runs of FMUs in FMPy."""
    (folder / "empty.py").write_text(EMPTY, encoding="utf-8")
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "empty.py"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    built = {kind: build_fmu("four_link_box", folder / kind, target=kind) for kind in ("pythonfmu", "native")}
    run: dict[str, Callable[[], object]] = {}
    for name, fmu in {"empty": folder / "Empty.fmu", **built}.items():
        place, description = fmpy.extract(str(fmu)), fmpy.read_model_description(str(fmu))
        instance = fmpy.instantiate_fmu(place, description, "CoSimulation")

        def call(place: str = place, description: Any = description, instance: Any = instance) -> object:
            instance.reset()
            read = next(v.name for v in description.modelVariables if v.causality == "output")
            options = {"model_description": description, "fmu_instance": instance, "output_interval": ROW}
            options["output"] = [read]
            return fmpy.simulate_fmu(place, stop_time=STOP, terminate=False, **options)

        run[name] = call
    return run


def lengths(names: Sequence[str] | None) -> tuple[int, int]:
    """Return how many functions of the package a call of ``simulate()`` calls, and its changes of file.

    ``names`` are the parameters of the derivatives. Few of both mean a short way for a reader of the code.
    """
    scene, root = load_scene("four_link_box"), str(Path(chain_impact.__file__).parent)
    simulate(scene, sensitivities=names)
    functions, files, changes = set[CodeType](), [""], 0

    def note(frame: FrameType, event: str, _: object) -> None:
        nonlocal changes
        code, caller = frame.f_code, frame.f_back and frame.f_back.f_code.co_filename
        if event == "call" and code.co_filename.startswith(root):
            functions.add(code)
            changes += code.co_filename != files[-1]
            files.append(code.co_filename)
        elif event == "return" and code.co_filename.startswith(root) and caller:
            files.append(caller)

    sys.setprofile(note)
    try:
        simulate(scene, sensitivities=names)
    finally:
        sys.setprofile(None)
    return len(functions), changes


def main() -> None:
    """Time all calls and steps, print the results and save them."""
    rounds, started, results = common.rounds(__doc__, ROUNDS), common.environment(), {}
    for tolerance in TOLERANCES:
        timings = common.interleave(calls(tolerance), rounds)
        timings["sweep"] = [seconds / RUNS for seconds in timings["sweep"]]
        ratios = {name: common.ratio(timings, name, "sweep") for name in timings if name != "sweep"}
        results[f"times a run in a sweep, tolerance {tolerance:g}"] = ratios
    with tempfile.TemporaryDirectory() as folder:
        timings = common.interleave(steps(Path(folder)), rounds)
    count = round(STOP / ROW)
    results["CPU microseconds a step in FMPy"] = {
        name: common.spread([1e6 * seconds / count for seconds in times]) for name, times in timings.items()
    }
    for name, value in results.items():
        print(f"{name}: {value}")
    for names in (None, [NAME]):
        print("functions and changes of file of a call, with derivatives by", names, lengths(names))
    common.save("calls", started, {"stop [s]": STOP, "row [s]": ROW, "rounds": rounds, "runs": RUNS}, results)


if __name__ == "__main__":
    main()

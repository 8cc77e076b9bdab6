"""What the FMU costs an importer, against an empty pythonfmu slave: ``python benchmarks/fmu_cost.py``.

Builds the FMUs, then measures in processes that have fmpy and pythonfmu and do not import this project's
package (fmu_importer.py). The empty slave has the same variables, registered as pythonfmu's documentation
shows, and a do_step that returns True. The bare one also answers fmi2GetReal with zeros at once: the floor
of what can be done with pythonfmu.
"""

from __future__ import annotations

import common  # isort: skip

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from looks import GREY, OURS, headline

from chain_impact.fmu.build import build_fmu
from chain_impact.scene.scene import Scene, load_scene
from chain_impact.variables.model import Model

OUTPUTS = 30
START = "instantiate and initialise [ms]"
PROCESSES = 9  # fresh ones for each of the two FMUs

EMPTY = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

VARIABLES = {variables}


class {name}(Fmi2Slave):
    """Nothing happens here."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for vr, (kind, causality, variability) in enumerate(VARIABLES):
            name = f"v{{vr}}"
            setattr(self, name, 1.0 if kind == "real" else 1)
            options = dict(causality=Fmi2Causality[causality], variability=Fmi2Variability[variability])
            self.register_variable((Real if kind == "real" else Integer)(name, **options))

    def do_step(self, current_time, step_size):
        return True
'''
BARE = """
    def get_real(self, vrs):
        return [0.0] * len(vrs)
"""


def build_empty(scene: Scene, folder: Path, name: str, more: str = "") -> Path:
    """An FMU of an empty slave with as many variables of each kind."""
    rows = [(v.type, v.causality, v.variability) for v in Model(scene).variables]
    script = folder / f"{name.lower()}_slave.py"
    script.write_text(EMPTY.format(name=name, variables=rows) + more, encoding="utf-8")
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(script), "-d", str(folder)]
    subprocess.run(
        [*command, "--no-external-tool", "--handle-state", "--serialize-state"],
        check=True,
        capture_output=True,
    )
    return folder / f"{name}.fmu"


def importer(task: str, outputs: int, fmus: dict[str, Path]) -> Any:
    """What fmu_importer.py prints, run in a process that knows nothing of this project."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    script = Path(__file__).with_name("fmu_importer.py")
    named = (f"{name}={path}" for name, path in fmus.items())
    command = [sys.executable, str(script), task, str(outputs), *named]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


def cold_starts(fmus: dict[str, Path]) -> dict[str, dict[str, float]]:
    """What each FMU takes as the first one of a process, in turn."""
    found: dict[str, list[float]] = {name: [] for name in fmus}
    for _ in range(PROCESSES):
        for name, path in fmus.items():
            found[name].append(importer("start", OUTPUTS, {name: path}))
    return {name: {START: common.median(values)} for name, values in found.items()}


SIZE = (10.5, 4.0)  # inches, of the chart


def draw(page, record) -> None:
    """Cost of a step on the left, start of an instance on the right."""
    results, steps = record["results"], page.subplots(1, 3)
    raw, whole, start = results["raw"], results["simulate_fmu"], results["cold start"]
    groups = (
        ("1 ms doStep + 30 outputs\nthrough C pointers", "µs a step", raw["microseconds a step"]),
        ("2 s scenario, 2000 steps\nthrough fmpy.simulate_fmu", "ms", whole["milliseconds"]),
        ("first instance of a process\ninstantiate and initialise", "ms",
         {name: start[name][START] for name in ("empty", "ours")}),
    )  # fmt: skip
    for axes, (title, unit, values) in zip(steps, groups, strict=True):
        names = [name for name in ("bare", "empty", "ours") if name in values]
        colours = {"bare": "0.85", "empty": GREY, "ours": OURS}
        bars = axes.bar(names, [values[name] for name in names], 0.6, color=[colours[name] for name in names])
        axes.bar_label(bars, fmt="%.3g", padding=2)
        axes.set(ylabel=unit, ylim=(0, 1.1 * max(values.values())))
        axes.set_title(title, fontsize=10)
        labels = {"bare": "bare slave", "empty": "empty slave", "ours": "chain-impact"}
        axes.set_xticks(range(len(names)), [labels[name] for name in names])
        axes.grid(axis="x", visible=False)
    factor = results["raw"]["ours / empty"]["median"]
    headline(
        page,
        f"A step of the FMU with all its outputs costs {factor:.2g} times a step that computes nothing",
        f"{record['settings']['scene']}  ·  through pythonfmu  ·  the empty slave has the same variables",
    )


def main() -> None:
    """Build, measure and draw."""
    started, scene = common.environment(), load_scene("four_link_box")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        fmus = {"ours": build_fmu(scene, folder), "empty": build_empty(scene, folder, "Empty")}
        bare = build_empty(scene, folder, "Bare", BARE)
        results = importer("run", OUTPUTS, fmus | {"bare": bare})
        results["cold start"] = cold_starts(fmus)
    print(json.dumps(results, indent=1))
    settings = {
        "scene": "four_link_box, 2 s in steps of 1 ms, tolerance 1e-8", "outputs read": OUTPUTS,
        "variables": len(Model(scene).variables), "processes": PROCESSES,
    }  # fmt: skip
    common.save("fmu_cost", started, settings, results)
    common.picture("fmu_cost", draw, SIZE)


if __name__ == "__main__":
    main()

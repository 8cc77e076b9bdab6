"""Which masters keep all impacts, at which communication step: ``python benchmarks/importers.py``.

Each master runs a scene's FMU and records its outputs; ``impacts_of`` makes a table of impacts of the record,
which is held against that of ``simulate()``. FMPy, libcosim and Ecos run in a process each
(``importers.py record FMU MASTER STEPS STEP``), the master in C is that of the tests.
"""

from __future__ import annotations

import common  # isort: skip

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import read_model_description, simulate_fmu

from chain_impact import impacts_of, load_scene, simulate
from chain_impact.compilation.compilers import INCLUDES
from chain_impact.fmu.build import build_fmu

sys.path.insert(0, str(common.ROOT / "models" / "controlled_arm"))

import masters

from tests.fmu.conftest import KINDS
from tests.fmu.interface import unpacked
from tests.fmu.zig import zig

STEPS = (1e-3, 1e-2, 1e-1)  # s
CASES = (("four_link_box", 8), ("rod_drop", 8), ("rod_drop", 16))
"""Scenes, and how many impacts their FMU shows: 8 by default."""
SHARED = ("onset", "impact_speed", "peak_force", "impulse")
Record = dict[str, Any]


def by_process(master: str) -> Callable[[Path, int, float], Record]:
    """A master of models/controlled_arm, in a process of its own: their libraries do not get on."""

    def record(fmu: Path, count: int, step: float) -> Record:
        command = [sys.executable, __file__, "record", str(fmu), master, str(count), repr(step)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return json.loads(done.stdout.splitlines()[-1])

    return record


def in_c(fmu: Path, count: int, step: float) -> Record:
    """A master in C; it does not read the start, where nothing has happened."""
    description = read_model_description(str(fmu))
    wanted = [v for v in description.modelVariables if v.name.startswith("impact")]
    letters = {"Real": "", "Integer": "i"}
    with tempfile.TemporaryDirectory() as scratch:
        folder, place = Path(scratch), unpacked(str(fmu), str(Path(scratch, "fmu")))
        headers = [one for include in INCLUDES for one in ("-I", include)]
        zig(folder, *headers, common.ROOT / "tests" / "fmu" / "host.c", "-ldl", "-o", folder / "host")
        library = place / "binaries" / "linux64" / f"{description.modelName}.so"
        command = [folder / "host", library, description.guid, f"file://{place}/resources", repr(step), count]
        command += [f"{letters[v.type]}{v.valueReference}" for v in wanted]
        done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=True)
    rows = np.array([line.split() for line in done.stdout.splitlines()], float)
    times = {"time": step * np.arange(1, count + 1)}
    return times | dict(zip([v.name for v in wanted], rows.T, strict=True))


def in_fmi_3(events: bool) -> Callable[[Path, int, float], Record]:
    """FMPy with an FMU for FMI 3.0, with event mode or without."""

    def record(fmu: Path, count: int, step: float) -> Record:
        variables = read_model_description(str(fmu)).modelVariables
        wanted = [v.name for v in variables if v.name.startswith("impact") and not v.dimensions]
        rows = simulate_fmu(
            str(fmu),
            output=wanted,
            output_interval=step,
            stop_time=count * step,
            early_return_allowed=events,
            use_event_mode=events,
        )
        return {name: rows[name] for name in ("time", *wanted)}

    return record


MASTERS = {
    "FMPy, FMI 2.0, pythonfmu": ("pythonfmu", by_process("fmpy")),
    "FMPy, FMI 2.0, native": ("native", by_process("fmpy")),
    "libcosim, FMI 2.0, native": ("native", by_process("libcosim")),
    "Ecos, FMI 2.0, native": ("native", by_process("ecos")),
    "C, FMI 2.0, native": ("native", in_c),
    "FMPy, FMI 3.0": ("fmi3", in_fmi_3(events=False)),
    "FMPy, FMI 3.0, event mode": ("fmi3", in_fmi_3(events=True)),
}
"""What runs which kind of FMU."""


def compared(found: np.ndarray, expected: np.ndarray) -> dict[str, Any]:
    """How many impacts of a table are there, and how far those are off, forces and impulses as a share."""
    row = {"found": len(found), "expected": len(expected)}
    # of each impact that was expected, the one that was found at the same point, wall and time
    pairs = [
        (one, other)
        for one in expected
        for other in found
        if (one["point"], one["wall"]) == (other["point"], other["wall"])
        and abs(one["onset"] - other["onset"]) < 1e-6
    ]
    row["matched"] = len(pairs)
    for name in SHARED:
        a, b = (np.array([pair[side][name] for pair in pairs]) for side in (0, 1))
        scale = np.abs(a) if name in ("peak_force", "impulse") else 1.0
        row[name] = float(np.max(np.abs(a - b) / scale, initial=0.0))
    return row


def measured() -> list[dict[str, Any]]:
    """A row for each case, master and step."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, shown in CASES:
            scene = load_scene(name).with_values({"outputs.impacts": shown})
            stop, expected = scene.simulation.stop_time, simulate(scene).impacts
            fmus = {
                kind: build_fmu(scene, Path(folder, name, str(shown), kind), **options)
                for kind, options in KINDS.items()
            }
            for master, (kind, record) in MASTERS.items():
                for step in STEPS:
                    found = impacts_of(record(fmus[kind], round(stop / step), step))
                    row = {"scene": name, "shown": shown, "master": master, "step": step}
                    rows.append(row | compared(found, expected))
                    print(rows[-1], flush=True)
    return rows


def record_one(fmu: str, master: str, count: str, step: str) -> None:
    """Print what a master of models/controlled_arm records of an FMU."""
    time = np.arange(int(count) + 1) * float(step)
    outputs = {"time": time, **masters.MASTERS[master]([fmu], time)}
    shown = {k: np.asarray(v).tolist() for k, v in outputs.items() if k.startswith(("time", "impact"))}
    print("\n" + json.dumps(shown))


if __name__ == "__main__":
    if sys.argv[1:2] == ["record"]:
        record_one(*sys.argv[2:])
    else:
        started = common.environment(("libcosimpy", "ecospy"))
        common.save("importers", started, {"steps": STEPS, "cases": CASES}, measured())

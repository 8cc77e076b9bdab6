"""Answers of the oracle of derivatives, kept in files: some fifty, each of which takes a second or more.

The name of a file is a hash of all that its answer follows from: the scene, the parameters, the times, the
inputs, the tolerance, and the sources of the oracle. An answer that has no file is worked out, and kept.
``python -m tests.kept_answers`` works all of them out anew; the new files are to be committed.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene, scene_to_dict
from tests.derivatives import FIELDS, Derivatives

HERE = Path(__file__).parent
FOLDER = HERE / "oracle_answers"
TESTS = ("test_derivatives.py", "test_friction_derivatives.py", "test_sensitivity_accuracy.py")
IDLE = ("solver", "simulation", "outputs")  # tables of a scene that the oracle does not read


def kept(
    work_out: Callable[..., Derivatives],
    scene: Scene,
    parameters: Sequence[str],
    times: Sequence[float],
    *,
    inputs: Mapping[str, float],
    tolerance: float,
) -> Derivatives:
    """The answer of the oracle to these arguments, which ``work_out`` takes."""
    tables = {name: table for name, table in scene_to_dict(scene).items() if name not in IDLE}
    given = json.dumps([tables, parameters, times, dict(inputs), tolerance, sources()], sort_keys=True)
    file = FOLDER / f"{hashlib.sha256(given.encode()).hexdigest()[:16]}.npz"
    if not file.exists():
        write(file, work_out(scene, parameters, times, inputs=inputs, tolerance=tolerance))
    return read(file)


@cache
def sources() -> str:
    """A hash of the sources of the oracle."""
    files = [HERE / "derivatives.py", *sorted(HERE.glob("complex_*.py"))]
    # as text, which is the same however lines end
    return hashlib.sha256("".join(file.read_text("utf-8") for file in files).encode()).hexdigest()


def write(file: Path, answer: Derivatives) -> None:
    file.parent.mkdir(exist_ok=True)
    unfinished = file.with_suffix(f".{os.getpid()}")
    with unfinished.open("wb") as stream:
        np.savez_compressed(
            stream,
            names=list(answer.values),
            **{name: np.array([*getattr(answer, name).values()]) for name in DICTIONARIES},
            points=answer.points,
            walls=answer.walls,
            steps=answer.steps,
            modes=np.array(answer.modes, float).reshape(-1, 3),
        )
    unfinished.replace(file)


def read(file: Path) -> Derivatives:
    with np.load(file) as data:
        names = {"values": data["names"].tolist(), "impacts": FIELDS}
        tables: dict[str, Any] = {
            name: dict(zip(names[of], data[name], strict=True)) for name, of in DICTIONARIES.items()
        }
        modes = [(time, int(element), int(mode)) for time, element, mode in data["modes"].tolist()]
        return Derivatives(
            **tables, points=data["points"], walls=data["walls"], steps=int(data["steps"]), modes=modes
        )


# a dictionary of an answer → the one whose names it has
DICTIONARIES = {"values": "values", "slopes": "values", "impacts": "impacts", "impact_slopes": "impacts"}


if __name__ == "__main__":
    for old in FOLDER.iterdir():
        old.unlink()
    sys.exit(subprocess.call([sys.executable, "-m", "pytest", *(str(HERE / name) for name in TESTS)]))

"""Answers of independent models that are stored in files, because each takes seconds to compute.

The name of a file is a hash of the model's arguments and of the model's sources in the tests. The hash
contains the scene that was read, but not the sources of chain_impact.scene, which reads scenes. An answer
without a file is computed and stored. ``python -m tests.helpers.kept_answers`` computes all answers again;
the new files must be committed.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene, scene_to_dict

TESTS_FOLDER = Path(__file__).parents[1]
FOLDER = TESTS_FOLDER / "oracle_answers"
ROOM = "tests.helpers"
TESTS = (
    *("scenarios/test_body_motions.py", "scenarios/test_derivatives.py", "scenarios/test_models.py"),
    *("scenarios/test_derivative_limits.py", "kernel/ode/test_collocation.py"),
)
IDLE = ("solver", "simulation", "outputs")  # tables of a scene that no independent model uses
LATER = (
    *("joint_armature", "joint_torque_limit", "joint_targets", "base_motion", "wall_motion"),
    *("center_of_mass_offset", "slider_force", "slider_velocity"),
)
"""Keys that are newer than these answers: a scene without these keys has the same hash."""
Arrays = dict[str, np.ndarray]


def kept(work_out: Callable[[], Arrays], module: str, scene: Scene, *given: Any) -> Arrays:
    """Return the answer of a model, from its file if there is one.

    Args:
        work_out: function that computes the answer.
        module: the module of the model, such as "tests.helpers.textbook".
        scene: the scene of the model.
        given: further arguments: numbers, names, and sequences and dictionaries of these.
    """
    tables = {name: table for name, table in scene_to_dict(scene, derived=True).items() if name not in IDLE}
    text = json.dumps(
        [without_later(tables), *given, sources(module)], sort_keys=True, default=np.ndarray.tolist
    )
    file = FOLDER / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.npz"
    if not file.exists():
        write(file, work_out())
    with np.load(file) as data:
        return dict(data)


def without_later(data: Any) -> Any:
    """Return the tables of a scene without keys of LATER that have no effect."""
    if isinstance(data, dict):
        return {key: without_later(one) for key, one in data.items() if one or key not in LATER}
    return [without_later(one) for one in data] if isinstance(data, list) else data


@cache
def sources(module: str) -> str:
    """Return a hash of the sources of a test module and of the test modules that it imports."""
    found: dict[str, str] = {}
    left = [module]
    while left:
        name = left.pop()
        # this module has no influence on an answer
        if name not in found and name != "tests.helpers.kept_answers":
            found[name] = TESTS_FOLDER.parent.joinpath(*name.split(".")).with_suffix(".py").read_text("utf-8")
            left += imported(found[name])
    return hashlib.sha256("".join(found[name] for name in sorted(found)).encode()).hexdigest()


def imported(source: str) -> list[str]:
    """Return the test modules that a source imports."""
    arrows = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.ImportFrom)]
    assert "import tests" not in source, "only `from tests… import` is followed"
    inside = [node.module for node in arrows if (node.module or "").startswith(f"{ROOM}.")]
    return inside + [f"{ROOM}.{one.name}" for node in arrows if node.module == ROOM for one in node.names]


def write(file: Path, answer: Arrays) -> None:
    file.parent.mkdir(exist_ok=True)
    unfinished = file.with_suffix(f".{os.getpid()}")
    with unfinished.open("wb") as stream:
        np.savez_compressed(stream, **answer)
    unfinished.replace(file)


if __name__ == "__main__":
    for old in FOLDER.iterdir():
        old.unlink()
    sys.exit(subprocess.call([sys.executable, "-m", "pytest", *(str(TESTS_FOLDER / name) for name in TESTS)]))

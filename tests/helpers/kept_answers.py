"""Answers of independent models, kept in files: some eighty, each of which takes seconds.

The name of a file is a hash of what the model was given and of the sources of the model in the tests. Those
of chain_impact.scene, which reads scenes, are not in it, but the scene as it was read. An answer that has no
file is worked out, and kept. ``python -m tests.helpers.kept_answers`` works all of them out anew; the new
files are to be committed.
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
    "kernel/ode/test_collocation.py",
)
IDLE = ("solver", "simulation", "outputs")  # tables of a scene that no independent model reads
LATER = (
    *("joint_armature", "joint_torque_limit", "joint_targets", "base_motion", "wall_motion"),
    *("center_of_mass_offset", "slider_force", "slider_velocity"),
)
"""Keys that came after these answers: a scene that leaves them out is the same."""
Arrays = dict[str, np.ndarray]


def kept(work_out: Callable[[], Arrays], module: str, scene: Scene, *given: Any) -> Arrays:
    """The answer of a model.

    Args:
        work_out: the model.
        module: where its source is, as "tests.helpers.textbook".
        scene: what it was given, …
        given: … besides numbers, names, and sequences and dictionaries of these.
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
    """The tables of a scene without keys that came later, where they have no effect."""
    if isinstance(data, dict):
        return {key: without_later(one) for key, one in data.items() if one or key not in LATER}
    return [without_later(one) for one in data] if isinstance(data, list) else data


@cache
def sources(module: str) -> str:
    """A hash of the sources of a module of the tests and of those that it imports, however lines end."""
    found: dict[str, str] = {}
    left = [module]
    while left:
        name = left.pop()
        if name not in found and name != "tests.helpers.kept_answers":  # which has no part in an answer
            found[name] = TESTS_FOLDER.parent.joinpath(*name.split(".")).with_suffix(".py").read_text("utf-8")
            left += imported(found[name])
    return hashlib.sha256("".join(found[name] for name in sorted(found)).encode()).hexdigest()


def imported(source: str) -> list[str]:
    """The modules of the tests that a source imports."""
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

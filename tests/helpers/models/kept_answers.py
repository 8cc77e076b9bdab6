"""Answers of independent models that are stored in files, because each takes seconds to compute.

The name of a file is a hash of the model's arguments and of the model's sources in the tests, without words
and without imports from this repository: a docstring may change, and a module may move. The hash contains
the scene that was read, but not the sources of chain_impact.scene, which reads scenes. An answer without a
file is computed and stored. ``python -m tests.helpers.models.kept_answers`` computes all answers again; the
new files must be committed.
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

from chain_impact.scene.contents import SceneContents
from chain_impact.scene.reading import keys_of
from chain_impact.scene.scene import Scene, scene_to_dict

TESTS_FOLDER = Path(__file__).parents[2]
FOLDER = TESTS_FOLDER / "oracle_answers"
ROOM, PACKAGE = "tests.helpers", "chain_impact"
OWN_NAME = f"{ROOM}.models.kept_answers"
TESTS = (
    *("scenarios/test_body_motions.py", "scenarios/test_derivatives.py", "scenarios/test_models.py"),
    *("scenarios/test_derivative_limits.py", "kernel/ode/test_collocation.py"),
)
IDLE = ("solver", "simulation", "outputs")  # tables of a scene that no independent model uses
OPTIONAL = {entry.name for _, entry in keys_of(SceneContents) if entry.default is None}
"""Names of keys that may be missing from a scene, which then differs from a scene with the value 0."""
Arrays = dict[str, np.ndarray]


def kept(work_out: Callable[[], Arrays], module: str, scene: Scene, *given: Any) -> Arrays:
    """Return the answer of a model, from its file if there is one; otherwise work it out and write the file.

    Args:
        work_out: function that computes the answer.
        module: the module of the model, such as "tests.helpers.models.textbook".
        scene: the scene of the model.
        given: further arguments: numbers, names, and sequences and dictionaries of these.
    """
    tables = {name: table for name, table in scene_to_dict(scene, derived=True).items() if name not in IDLE}
    text = json.dumps(
        [without_zeros(tables), *given, sources(module)], sort_keys=True, default=np.ndarray.tolist
    )
    file = FOLDER / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.npz"
    if not file.exists():
        write(file, work_out())
    with np.load(file) as data:
        return dict(data)


def without_zeros(data: Any) -> Any:
    """Return the tables of a scene without values that are 0, false or empty, except those of OPTIONAL keys.

    So a scene has the same hash before and after a new key whose default is such a value, or no value.
    """
    if isinstance(data, dict):
        return {key: without_zeros(value) for key, value in data.items() if value or key in OPTIONAL}
    return [without_zeros(value) for value in data] if isinstance(data, list) else data


@cache
def sources(module: str) -> str:
    """Return a hash of the code of a test module, and of the helpers that it and they import."""
    codes: dict[str, str] = {}
    left = [module]
    while left:
        name = left.pop()
        stem = name.rpartition(".")[2]
        if stem not in codes and name != OWN_NAME:  # this module has no influence on an answer
            source = file_of(name).read_text("utf-8")
            codes[stem] = code(source)
            left += imported(source)
    return hashlib.sha256("".join(codes[stem] for stem in sorted(codes)).encode()).hexdigest()


def file_of(module: str) -> Path:
    return TESTS_FOLDER.parent.joinpath(*module.split(".")).with_suffix(".py")


def imported(source: str) -> list[str]:
    """Return the helpers that a source imports."""
    assert "import tests" not in source, "only `from tests… import` is followed"
    modules = []
    for arrow in (node for node in ast.walk(ast.parse(source)) if imports_from(node, ROOM)):
        exists = file_of(arrow.module).exists()
        modules += [arrow.module] if exists else [f"{arrow.module}.{name.name}" for name in arrow.names]
    return modules


def imports_from(node: ast.AST, *packages: str) -> bool:
    return isinstance(node, ast.ImportFrom) and f"{node.module}.".startswith(
        tuple(f"{package}." for package in packages)
    )


def code(source: str) -> str:
    """Return the lines of a source without docstrings, comment lines, and imports from this repository."""
    lines = source.splitlines()
    for node in ast.walk(ast.parse(source)):
        if imports_from(node, ROOM, PACKAGE) or is_docstring(node):
            lines[node.lineno - 1 : node.end_lineno] = [""] * (node.end_lineno - node.lineno + 1)
    return "\n".join(line for line in lines if line and not line.lstrip().startswith("#"))


def is_docstring(node: ast.AST) -> bool:
    value = node.value if isinstance(node, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


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

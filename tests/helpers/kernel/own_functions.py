"""The kernel's own functions of real numbers: arguments, plain Python, and a program for any platform."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.compilation import compilers
from chain_impact.kernel.mathematics import angles, exponentials, logarithms, powers
from chain_impact.system import PLATFORMS
from tests.helpers.tools.zig import zig

FUNCTIONS: dict[str, Callable[..., float]] = {
    "exp": lambda x, _: exponentials.exp(x),
    "expm1": lambda x, _: exponentials.expm1(x),
    "log": lambda x, _: logarithms.log(x),
    "log1p": lambda x, _: logarithms.log1p(x),
    "pow": powers.power,
    "sin": lambda x, _: angles.sine(x),
    "cos": lambda x, _: angles.cosine(x),
}
NAMES = tuple(FUNCTIONS)
LAW = """import math

def functions(penetration, rate, impact_speed):
    if impact_speed < 0.5:
        return math.exp(penetration)
    if impact_speed < 1.5:
        return math.expm1(penetration)
    if impact_speed < 2.5:
        return math.log(penetration)
    if impact_speed < 3.5:
        return math.log1p(penetration)
    if impact_speed < 4.5:
        return penetration ** rate
    if impact_speed < 5.5:
        return math.sin(penetration)
    return math.cos(penetration)
"""
PROGRAM = """
#include <stdio.h>
double user_law_force(double, double, double, double, double, double, double);
int main(int count, char **names) {
    FILE *from = fopen(names[1], "rb"), *to = fopen(names[2], "wb");
    double x[3];
    while (fread(x, sizeof x, 1, from) == 1) {
        double y = user_law_force(x[0], x[1], x[2], 0.0, 0.0, 0.0, 0.0);
        fwrite(&y, sizeof y, 1, to);
    }
    return fclose(from) || fclose(to);
}
"""


def arguments(name: str, count: int) -> np.ndarray:
    """Return arguments over the whole range, and where the function is small; shape (count, 2)."""
    chance = np.random.default_rng(NAMES.index(name))
    sign, small = chance.choice([-1.0, 1.0], count), 10.0 ** chance.uniform(-18.0, 0.5, count)
    wide, far = chance.uniform(-745.1, 709.7, count), 10.0 ** chance.uniform(-307.0, 308.0, count)
    half = np.arange(count) % 2 == 0
    x = {
        "exp": np.where(half, wide, sign * small),
        "expm1": np.where(half, 0.05 * wide, sign * small),
        "log": np.where(half, far, np.abs(1.0 + sign * small)),
        "log1p": np.where(half, far, np.maximum(sign * small, -1.0 + 1e-9 * small)),
        "pow": np.where(half, far, np.abs(1.0 + sign * small)),
    }.get(name, sign * np.where(half, 2.0 ** chance.uniform(-5.0, 1023.0, count), 100.0 * small))
    with np.errstate(divide="ignore"):
        span = wide / np.log(x) if name == "pow" else x
    y = np.where(np.isfinite(span) & (np.arange(count) % 4 < 2), span, chance.uniform(-4.0, 4.0, count))
    return np.column_stack([x, y])


def in_plain_python(name: str, given: np.ndarray) -> np.ndarray:
    """Return the results of plain Python."""
    return np.array([FUNCTIONS[name](x, y) for x, y in given.tolist()])


def lowered(folder: Path) -> Path:
    """Return a file with the functions as those of a user's law, in LLVM's language."""
    file, law = folder / "functions.ll", folder / "functions.py"
    law.write_text(LAW, encoding="utf-8")
    compilers.lower(file, "law", law)
    return file


def program(law: Path, platform: str, folder: Path) -> Path:
    """Compile the file ``law`` of ``lowered`` to a program for a platform, and return its path.

    The program reads a file of arguments and writes a file of results.
    """
    source, executable = folder / "functions.c", folder / f"functions-{platform}.exe"
    source.write_text(PROGRAM, encoding="utf-8")
    target = PLATFORMS[platform]
    zig(
        folder,
        "-target",
        target.target,
        f"-mcpu={target.cpu}",
        *compilers.C_FLAGS,
        source,
        law,
        "-o",
        executable,
    )
    return executable


def run(command: Callable[[Path, Path], Any], folder: Path, **given: np.ndarray) -> list[np.ndarray]:
    """Return the results for arguments of some functions; ``command`` runs the program with two files."""
    numbered = [np.insert(two, 2, NAMES.index(name), axis=1) for name, two in given.items()]
    np.concatenate(numbered).tofile(folder / "given.bin")
    command(folder / "given.bin", folder / "found.bin")
    return np.split(np.fromfile(folder / "found.bin"), np.cumsum([len(two) for two in numbered])[:-1])

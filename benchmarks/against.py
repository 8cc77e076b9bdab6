"""The kernel compared with the kernel of another commit: ``python -m benchmarks against REVISION``.

The package of each commit makes instances of the same scenes, and its own kernel (against_side.py). Both
kernels then run in this process, in turn, and the records ``output`` and ``statistics`` after a run are
compared byte by byte. A run begins with the initialization; if a kernel does not reset all of a used record,
its runs begin with a copy of a new record before that.

``evaluations`` is the new number of evaluations of the equations in this run divided by the old one, and ``of
many`` the median of this ratio over runs that begin with slightly different angles. A different rounding
changes ``evaluations`` by some percent, and ``of many`` hardly. If only ``evaluations`` differs from 1, the
times differ by chance.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks import common

ROUNDS = 15
WORD = 8  # [byte] size of an integer in a record
# [byte] LINE: size of a line of the processor's cache; PLACE: distance of NumPy's large arrays from the start
# of a line
LINE, PLACE = 64, 16


class Run:
    """A kernel on an instance of a scene."""

    def __init__(self, side: dict[str, Any]) -> None:
        self.fresh = np.frombuffer(side["instance"], np.uint8)
        room = np.empty(len(self.fresh) + LINE, np.uint8)
        first = (PLACE - room.ctypes.data) % LINE
        self.block = room[first : first + len(self.fresh)]
        self.address, self.stop, self.compared = self.block.ctypes.data, side["stop"], side["compared"]
        self.varied, self.count = side["varied"], side["evaluations"]
        kernel, pointer, double = ctypes.CDLL(side["library"]), ctypes.c_void_p, ctypes.c_double
        self.initialize, self.advance, self.observe = (kernel[name] for name in side["functions"])
        self.initialize.argtypes = self.advance.argtypes = [pointer, double]
        self.observe.argtypes = [pointer]
        self.copies = True
        self.expected = self.outcome()
        self.copies = False
        self.copies = any(self.outcome() != self.expected for _ in range(2))
        assert self() == 0
        assert self.outcome() == self.expected

    def __call__(self) -> int:
        """Run from the parameters to the end; return the status."""
        if self.copies:
            self.block[:] = self.fresh
        self.initialize(self.address, 0.0)
        return int(self.advance(self.address, self.stop))

    def outcome(self) -> list[bytes]:
        """Return the compared records as bytes, after one more run."""
        self()
        self.observe(self.address)
        return [self.block[start:end].tobytes() for start, end in self.compared]

    def evaluations(self) -> int:
        """Return the number of evaluations of the last run."""
        return int(self.block[self.count : self.count + WORD].view(np.int64)[0])

    def evaluations_of_many(self) -> Iterator[int]:
        """Yield the number of evaluations of each run with other angles at the start."""
        for instance in self.varied:
            self.block[:] = np.frombuffer(instance, np.uint8)
            self.initialize(self.address, 0.0)
            self.advance(self.address, self.stop)
            yield self.evaluations()


@contextmanager
def worktree(revision: str) -> Iterator[Path]:
    """Yield a temporary folder with the files of a commit."""
    with TemporaryDirectory() as scratch:
        folder = Path(scratch, "tree")
        git("worktree", "add", "--quiet", "--detach", str(folder), revision)
        try:
            yield folder
        finally:
            git("worktree", "remove", "--force", str(folder))


def git(*arguments: str) -> str:
    """Return the output of git in this repository."""
    process = subprocess.run(
        ["git", *arguments], cwd=common.ROOT, stdout=subprocess.PIPE, text=True, check=True
    )
    return process.stdout.strip()


def sides(root: Path) -> dict[str, dict[str, Any]]:
    """Return the kernels and instances of a tree's package; a kernel that is not cached is compiled."""
    environment = {**os.environ, "PYTHONPATH": str(root / "fmu_src")}
    command = [sys.executable, str(Path(__file__).with_name("against_side.py"))]
    process = subprocess.run(command, cwd=root, env=environment, stdout=subprocess.PIPE, check=True)
    sides_by_scene: dict[str, dict[str, Any]] = pickle.loads(process.stdout)
    return sides_by_scene


def compare(scene: str, new_side: dict[str, Any], old_side: dict[str, Any]) -> None:
    """Time both kernels on a scene, and print a row."""
    runs = {"new": Run(new_side), "old": Run(old_side)}
    equal = runs["new"].expected == runs["old"].expected
    timings = common.interleave(runs, ROUNDS)
    ratios = common.ratio(timings, "new", "old")
    times = {name: common.median([1e6 * value for value in timings[name]]) for name in runs}
    evaluations = runs["new"].evaluations() / runs["old"].evaluations()
    pairs = zip(runs["new"].evaluations_of_many(), runs["old"].evaluations_of_many(), strict=True)
    many = common.median([new_count / old_count for new_count, old_count in pairs])
    row_text = (
        f"{scene:15}{times['old']:9.1f}{times['new']:9.1f}{ratios['median']:9.3f}{ratios['least']:9.3f}"
    )
    row_text += f"{ratios['largest']:9.3f}{evaluations:13.3f}{many:9.3f}"
    print(f"{row_text}  {'equal' if equal else 'different'}", flush=True)


def main() -> None:
    """Compare the kernels on all scenes, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("revision", help="any name that git has for a commit")
    commit = git("rev-parse", "--verify", f"{parser.parse_args().revision}^{{commit}}")
    with worktree(commit) as tree:
        old_sides = sides(tree)
    new_sides = sides(common.ROOT)
    titles = f"{'old [µs]':>9}{'new [µs]':>9}{'new/old':>9}{'least':>9}{'largest':>9}"
    titles += f"{'evaluations':>13}{'of many':>9}"
    print(f"{'scene':15}{titles}  bytes")
    for scene in new_sides:
        compare(scene, new_sides[scene], old_sides[scene])


if __name__ == "__main__":
    main()

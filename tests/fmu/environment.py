"""A clean Python, made without a download, and processes of it that have imported a module already."""

from __future__ import annotations

import json
import subprocess
import textwrap
import venv
from collections.abc import Callable
from importlib.metadata import distribution
from inspect import getsource
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement

HERE = Path(__file__).parent


def make_environment(folder: Path, *names: str) -> None:
    """A virtual environment that holds some distributions of this one and what they need, and no more."""
    venv.create(folder, symlinks=True)
    (packages,) = folder.glob("lib/python*/site-packages")
    wanted, known = [*names], set()
    while wanted:
        name = wanted.pop()
        if name in known:
            continue
        known.add(name)
        found = distribution(name)
        for part in {file.parts[0] for file in found.files or ()} - {"..", "__pycache__"}:
            if not (packages / part).exists():
                (packages / part).symlink_to(Path(found.locate_file(part)))
        needed = [Requirement(text) for text in found.requires or ()]
        wanted += [one.name for one in needed if not one.marker or one.marker.evaluate({"extra": ""})]


class Processes:
    """Runs functions, each in a process of its own, in a Python that holds what an importer needs.

    The processes are forked from one that has imported a module and done nothing else, since the import takes
    longer than most of the functions.
    """

    def __init__(self, python: Path, folder: Path) -> None:
        """Those of a Python; ``folder`` is for what they print."""
        self.python, self.folder = python, folder
        self.parents: dict[str, subprocess.Popen[str]] = {}

    def run(self, function: Callable[..., Any], *arguments: Any, module: str = "importer") -> Any:
        """``function(*arguments)``; all that it uses is what it imports and the module.

        Arguments and result pass as JSON, which keeps doubles to the last bit.
        """
        parent = self.parents.get(module) or self.start(module)
        printed, errors = self.folder / "printed", self.folder / "errors"
        source = textwrap.dedent(getsource(function))
        call = (source, function.__name__, arguments, str(printed), str(errors))
        print(json.dumps(call), file=parent.stdin, flush=True)
        answer = parent.stdout.readline()
        said = printed.read_text(errors="replace")
        assert answer == "0\n", said[-2000:] + errors.read_text(errors="replace")[-4000:]
        return json.loads(said.splitlines()[-1])

    def start(self, module: str) -> subprocess.Popen[str]:
        """The process that has imported a module."""
        command = [self.python, "-I", "-X", "faulthandler", HERE / "forks.py", str(HERE), module]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self.parents[module] = subprocess.Popen(command, **pipes, text=True)
        return self.parents[module]

    def end(self) -> None:
        """End the processes that have imported something."""
        for parent in self.parents.values():
            parent.communicate()

"""Processes that have already imported a module, and a clean Python for them, made without a download."""

from __future__ import annotations

import json
import re
import select
import subprocess
import venv
from collections.abc import Callable
from contextlib import suppress
from importlib.metadata import distribution
from inspect import getsource
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement

FORKS = Path(__file__).with_name("forks.py")
PATIENCE = 600.0  # [s] time for a function to end, even on a slow machine


def make_environment(folder: Path, *names: str) -> None:
    """Make a virtual environment with only some distributions of this one, and those that they need."""
    venv.create(folder, symlinks=True)
    (packages,) = folder.glob("lib/python*/site-packages")
    missing_names, added = [*names], set()
    while missing_names:
        name = missing_names.pop()
        if name in added:
            continue
        added.add(name)
        installed = distribution(name)
        for part in {file.parts[0] for file in installed.files or ()} - {"..", "__pycache__"}:
            if not (packages / part).exists():
                (packages / part).symlink_to(Path(installed.locate_file(part)))
        needed = [Requirement(text) for text in installed.requires or ()]
        missing_names += [
            requirement.name
            for requirement in needed
            if not requirement.marker or requirement.marker.evaluate({"extra": ""})
        ]


class Processes:
    """Runs functions, each in a separate process.

    The processes are forked from a process that has only imported a module, because the import takes longer
    than most of the functions.
    """

    def __init__(
        self, folder: Path, modules: Path, python: str | Path, *options: str, **settings: Any
    ) -> None:
        """Prepare processes of a Python, with some options and settings of ``Popen``.

        ``folder`` is for the printed output, ``modules`` contains the modules that the processes import.
        """
        self.folder, self.command, self.settings = folder, [python, *options, FORKS, modules], settings
        self.parents: dict[str, subprocess.Popen[str]] = {}

    def run(self, function: Callable[..., Any], *arguments: Any, module: str) -> Any:
        """Return ``function(*arguments)``; the function may only use its own imports and the module.

        Arguments and result are sent as JSON, which keeps all bits of doubles.
        """
        source = re.sub(r"\A.*?^(?=def )", "", getsource(function), flags=re.MULTILINE | re.DOTALL)
        code, printed, errors = self.call([source, function.__name__, arguments], module)
        assert code == 0, printed[-2000:] + errors[-4000:]
        return json.loads(printed.splitlines()[-1])

    def call(self, call: list[Any], module: str) -> tuple[int, str, str]:
        """Run ``call``, which holds source, name and arguments of a function (forks.py).

        Return the exit code, or minus the number of a signal, and the texts of standard output and error.
        Fail if the process that has imported the module dies, or does not answer in time.
        """
        parent = self.parents.get(module) or self.start(module)
        files = [self.folder / name for name in ("printed", "errors")]
        with suppress(BrokenPipeError):  # the process has died, which is reported below
            print(json.dumps([*call, *map(str, files)]), file=parent.stdin, flush=True)
        ready, _, _ = select.select([parent.stdout], [], [], PATIENCE)
        answer = parent.stdout.readline() if ready else ""
        assert answer, self.failure(module, "has died" if ready else f"gave no answer in {PATIENCE:g} s")
        return int(answer), *(file.read_text(encoding="utf-8", errors="replace") for file in files)

    def failure(self, module: str, fault: str) -> str:
        """End the process that imports a module; return a sentence with its fault, and its standard error.

        The next call starts another process.
        """
        parent = self.parents.pop(module)
        parent.kill()
        with suppress(BrokenPipeError):
            parent.communicate()
        return (
            f"the process that imports {module} {fault}:\n{self.errors(module).read_text(errors='replace')}"
        )

    def errors(self, module: str) -> Path:
        """Return the file with the text that the process of a module has written to standard error."""
        return self.folder / f"{module}.errors"

    def start(self, module: str) -> subprocess.Popen[str]:
        """Start a process that imports a module and waits for calls, and return it."""
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        with self.errors(module).open("w") as errors:
            self.parents[module] = subprocess.Popen(
                [*self.command, module], **pipes, **self.settings, stderr=errors, text=True
            )
        return self.parents[module]

    def end(self) -> None:
        """End the processes that have imported modules, after their last calls."""
        for parent in self.parents.values():
            parent.communicate()

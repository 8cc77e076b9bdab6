"""The C compiler of the project, for programs of the tests."""

import os
import subprocess
import sys
from pathlib import Path

from chain_impact.compilation.cache import linker_folder
from chain_impact.compilation.compilers import ZIG_TARGETS
from chain_impact.system import HOST

WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror", "-Wno-unused-parameter")


def zig(folder: Path, *arguments: object) -> None:
    """Run zig's C compiler in a folder, where it keeps its scratch files; what it says is an error.

    A program ends at a trap where its behaviour is undefined.
    The usual target, and some optimisation, spare it to make its own libraries once more, which takes 15 s.
    """
    folders = {"ZIG_GLOBAL_CACHE_DIR": str(linker_folder()), "ZIG_LOCAL_CACHE_DIR": str(folder / "zig")}
    command = [sys.executable, "-m", "ziglang", "cc", "-std=c11", "-D_POSIX_C_SOURCE=200809L", "-O1"]
    command += ["-fsanitize=undefined", "-fsanitize-trap=undefined"]
    if "-target" not in arguments:
        command += ["-target", ZIG_TARGETS[HOST][0]]
    done = subprocess.run(
        [*command, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, **folders},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr

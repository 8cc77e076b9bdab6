"""The project's C compiler for test programs."""

import os
import subprocess
import sys
from pathlib import Path

from chain_impact.compilation.cache import linker_folder
from chain_impact.system import HOST, PLATFORMS

WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror", "-Wno-unused-parameter")


def zig(folder: Path, *arguments: object) -> None:
    """Run zig's C compiler in a folder, which also gets its scratch files; with WARNINGS warnings are errors.

    A program ends at a trap where its behaviour is undefined.
    With the default target and the optimised build, zig's own libraries, whose build takes 15 s, are reused.
    """
    folders = {"ZIG_GLOBAL_CACHE_DIR": str(linker_folder()), "ZIG_LOCAL_CACHE_DIR": str(folder / "zig")}
    command = [sys.executable, "-m", "ziglang", "cc", "-std=c11", "-D_POSIX_C_SOURCE=200809L", "-O1"]
    command += ["-fsanitize=undefined", "-fsanitize-trap=undefined"]
    if "-target" not in arguments:
        command += ["-target", PLATFORMS[HOST].target]
    process = subprocess.run(
        [*command, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, **folders},
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 0, process.stderr

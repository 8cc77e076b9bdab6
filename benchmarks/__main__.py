"""Run a benchmark in a process with the settings of a release: ``python -m benchmarks NAME [option …]``."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from benchmarks.common import ROOT
from chain_impact.compilation.compilers import PORTABLE_CPU
from chain_impact.compilation.prebuilt import RELEASE

# numpy and numba read these variables when they are imported
SETTINGS = {
    "NUMBA_CPU_NAME": PORTABLE_CPU,
    "NUMBA_CPU_FEATURES": "",
    "OPENBLAS_NUM_THREADS": "1",
    RELEASE: "1",
}


def programs() -> dict[str, str]:
    """Return the name of each benchmark → the first line of its text."""
    files = sorted(Path(__file__).parent.glob("[!_]*.py"))
    texts = {file.stem: file.read_text(encoding="utf-8") for file in files if not file.stem.endswith("_side")}
    return {name: text.splitlines()[0].strip('"') for name, text in texts.items() if "__main__" in text}


if __name__ == "__main__":
    name, *arguments = sys.argv[1:] or [""]
    descriptions = programs()
    if name not in descriptions:
        fault = f"NAME is {name!r}; must be one of:" if name else "NAME is missing; must be one of:"
        print(
            fault,
            *(f"{program:16} {text}" for program, text in descriptions.items()),
            sep="\n",
            file=sys.stderr,
        )
        sys.exit(2)
    command = [sys.executable, "-m", f"benchmarks.{name}", *arguments]
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    sys.exit(subprocess.call(command, env={**os.environ, **SETTINGS, "PYTHONPATH": path}))

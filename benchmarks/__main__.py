"""Run a benchmark in a process with the settings of a release: ``python -m benchmarks NAME [option …]``."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from benchmarks.common import ROOT
from chain_impact.compilation.compilers import PORTABLE_CPU
from chain_impact.compilation.ready import RELEASE

# numpy and numba read these variables when they are imported
SETTINGS = {
    "NUMBA_CPU_NAME": PORTABLE_CPU,
    "NUMBA_CPU_FEATURES": "",
    "OPENBLAS_NUM_THREADS": "1",
    RELEASE: "1",
}

if __name__ == "__main__":
    programs = sorted(
        file.stem for file in Path(__file__).parent.glob("[!_]*.py") if "__main__" in file.read_text("utf-8")
    )
    name, *arguments = sys.argv[1:] or [""]
    if name not in programs:
        given = repr(name) if name else "missing"
        print(f"NAME is {given}; must be one of {', '.join(programs)}", file=sys.stderr)
        sys.exit(2)
    command = [sys.executable, "-m", f"benchmarks.{name}", *arguments]
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    sys.exit(subprocess.call(command, env={**os.environ, **SETTINGS, "PYTHONPATH": path}))

#!/usr/bin/env python3
"""Write .ci/constraints.txt: one version of each package of the extra dev, for each Python and system.

Versions that still fit stay. With ``--upgrade`` the newest ones are taken.
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
FILE = ROOT / ".ci" / "constraints.txt"
HEAD = "# The versions with which .ci/run and the workflows test; users install what pyproject.toml allows.\n"
UV = Path(sys.executable).with_name("uv")

if __name__ == "__main__":
    options = ["--universal", "--no-header", "--no-annotate", "--extra", "dev", *sys.argv[1:]]
    command: list[str | Path] = [
        UV,
        "pip",
        "compile",
        "--quiet",
        *options,
        "--output-file",
        FILE,
        "pyproject.toml",
    ]
    subprocess.run(command, cwd=ROOT, check=True)
    FILE.write_text(HEAD + FILE.read_text(encoding="utf-8"), encoding="utf-8")

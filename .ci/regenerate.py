#!/usr/bin/env python3
"""Write all files again that are made from the sources, and print which files differ from the last commit.

The references of the models stay: they change only if a motion is meant to change.
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROGRAMS = (
    "-m docs.tools.generate",  # tables in the docs, the schema of scene files
    "packaging/c_header.py",  # shared.h
    "tests/repository/test_public_api.py",  # public_api.txt, __init__.pyi
)
"""The programs that write such files."""

if __name__ == "__main__":
    for program in PROGRAMS:
        subprocess.run([sys.executable, *program.split()], cwd=ROOT, check=True)
    subprocess.run(["git", "status", "--short"], cwd=ROOT, check=True)

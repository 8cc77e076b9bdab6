"""What commands print and write, read for comparisons; and the program as a process."""

import csv
import re
import subprocess
import sys

PNG = b"\x89PNG\r\n\x1a\n"


def impact_lines(text):
    return [line.split() for line in text.splitlines() if re.match(r"\s*\d+ +\d+\.\d{6} ", line)]


def read_csv(path):
    with path.open(newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    return names, [[float(cell) for cell in row] for row in rows]


def program(*arguments, **settings):
    """Run ``chain-impact`` in a process of its own; return the completed process."""
    command = [sys.executable, "-m", "chain_impact.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, **settings)

"""`chain-impact validate`: an FMU against the FMI standard."""

from __future__ import annotations

import argparse
from pathlib import Path

from chain_impact.cli.options import Verbs
from chain_impact.cli.progress import out


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    validate = verbs.add_parser("validate", help="check an FMU against the FMI standard")
    validate.add_argument("fmu", metavar="FMU", type=Path)
    validate.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check an FMU; the exit code is 1 if something is wrong."""
    from chain_impact.export.fmu import validate_fmu

    options.fmu.stat()  # a file that is not there is no FMU with problems
    problems = validate_fmu(options.fmu)
    for problem in problems:
        out.print(f"{options.fmu}: {problem}", markup=False, soft_wrap=True)
    if not problems:
        out.print(f"{options.fmu}: no problems found", markup=False, soft_wrap=True)
    return 1 if problems else 0

"""`chain-impact validate`: an FMU against the FMI standard and its own reference results."""

from __future__ import annotations

import argparse
from pathlib import Path

from chain_impact.cli.options import Verbs
from chain_impact.cli.progress import say


def add(verbs: Verbs) -> None:
    """Add the verb to the grammar."""
    validate = verbs.add_parser(
        "validate", help="check an FMU against the FMI standard, and run its experiments"
    )
    validate.add_argument("fmu", metavar="FMU", type=Path)
    validate.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check an FMU; the exit code is 1 if something is wrong."""
    from chain_impact.fmu.build import validate_fmu
    from chain_impact.fmu.check_references import check_references

    options.fmu.stat()  # a file that is not there is no FMU with problems
    problems = validate_fmu(options.fmu)
    # what is no valid FMU is not run
    outcomes = [] if problems else check_references(options.fmu)
    for line in [*(problems or ["no problems found"]), *(outcome.text for outcome in outcomes)]:
        say(f"{options.fmu}: {line}")
    return 0 if not problems and all(outcome.passed for outcome in outcomes) else 1

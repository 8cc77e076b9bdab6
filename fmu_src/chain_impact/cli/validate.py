"""`chain-impact validate`: check an FMU against the FMI standard, and test its binary."""

from __future__ import annotations

import argparse
import json
import zipfile
from dataclasses import asdict
from pathlib import Path

from chain_impact.cli.options import UsageError, Verbs, add_verb
from chain_impact.cli.progress import say
from chain_impact.fmu.findings import Finding, finding_lines
from chain_impact.fmu.validate import TIMEOUT, Validation, validation
from chain_impact.scene.models import scene_path


def add(verbs: Verbs) -> None:
    """Add the verb ``validate``, with its arguments and options, to the parser of the command line."""
    validate = add_verb(
        verbs,
        "validate",
        "check an FMU against the FMI standard, and run it, with its reference results",
        "build/FourLinkBox.fmu --json",
    )
    validate.add_argument("fmu", metavar="FMU", type=Path)
    validate.add_argument("--json", action="store_true", help="print findings and notes as JSON")
    validate.add_argument(
        "--timeout",
        metavar="SECONDS",
        type=float,
        default=TIMEOUT,
        help="longest time of the binary of the FMU, in a separate process; default: %(default)g",
    )
    validate.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check an FMU, and print its faults; return the exit code, 1 if there is a fault."""
    if not 0.0 < options.timeout < float("inf"):
        raise UsageError(f"--timeout {options.timeout} must be a finite number > 0 [s]")
    scene = scene_path(options.fmu)
    if scene != options.fmu or scene.suffix == ".toml":
        raise UsageError(
            f"{options.fmu} is a scene, must be an FMU: chain-impact info {options.fmu} checks a scene, "
            f"and chain-impact build {options.fmu} makes its FMU"
        )
    try:
        result = validation(options.fmu, options.timeout)
    except zipfile.BadZipFile as error:
        result = Validation([Finding(f"not a readable FMU: {error}", file="")], [])
    if options.json:
        findings = [asdict(finding) for finding in result.findings]
        text = {"fmu": str(options.fmu), "findings": findings, "notes": list(result.notes)}
        say(json.dumps(text, indent=2))
    else:
        lines = finding_lines(result.findings) or ["no problems found"]
        for line in [*lines, *result.notes]:
            say(f"{options.fmu}: {line}")
    return 1 if result.findings else 0

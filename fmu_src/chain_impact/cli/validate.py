"""`chain-impact validate`: check an FMU against the FMI standard, and test its binary."""

from __future__ import annotations

import argparse
import json
import zipfile
from dataclasses import asdict
from pathlib import Path

from chain_impact.cli.options import UsageError, Verbs, add_verb
from chain_impact.cli.printing import complain, out, say
from chain_impact.fmu.findings import Finding, finding_lines
from chain_impact.fmu.validate import TIMEOUT, Validation, validate_and_run
from chain_impact.scene.files.models import scene_file_path


def add(verbs: Verbs) -> None:
    """Add the verb ``validate``, with its arguments and options, to the parser of the command line."""
    validate = add_verb(
        verbs,
        "validate",
        "check an FMU against the FMI standard, test its binary, and compare its reference results",
        "build/FourLinkBox.fmu --json",
    )
    validate.add_argument("fmus", metavar="FMU", type=Path, nargs="+")
    validate.add_argument(
        "--json",
        action="store_true",
        help="print findings and notes as JSON: an object, or for several FMUs a list of objects",
    )
    validate.add_argument(
        "--timeout",
        metavar="SECONDS",
        type=float,
        default=TIMEOUT,
        help="time limit of the FMU's binary, which runs in a process of its own; default: %(default)g",
    )
    validate.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check FMUs, print their faults, and return the exit code: 1 if an FMU has a fault, else 0."""
    if not 0.0 < options.timeout < float("inf"):
        raise UsageError(f"--timeout {options.timeout} must be a finite number > 0 [s]")
    for path in options.fmus:
        _refuse_scene(path)
        path.open("rb").close()  # a file that cannot be read ends the command before any check
    checked = [
        (path, validate_and_report(path, options.timeout, report=not options.json)) for path in options.fmus
    ]
    if options.json:
        texts = [
            {
                "fmu": str(path),
                "findings": [asdict(finding) for finding in result.findings],
                "notes": list(result.notes),
            }
            for path, result in checked
        ]
        say(json.dumps(texts if len(texts) > 1 else texts[0], indent=2))
    return 1 if any(result.findings for _, result in checked) else 0


def _refuse_scene(path: Path) -> None:
    scene = scene_file_path(path)
    if scene != path or scene.suffix == ".toml":
        raise UsageError(
            f"{path} is a scene, must be an FMU: chain-impact info {path} checks a scene, "
            f"and chain-impact build {path} makes its FMU"
        )


def validate_and_report(path: Path, timeout: float, *, report: bool) -> Validation:
    """Check an FMU, whose binary may run for ``timeout`` [s], and return the result.

    If ``report`` is true, print the faults and notes; with ``--quiet``, print only the faults, on standard
    error.
    """
    try:
        result = validate_and_run(path, timeout)
    except zipfile.BadZipFile as error:
        result = Validation([Finding(f"not a readable FMU: {error}", file="")], [])
    if report:
        faults = finding_lines(result.findings)
        for line in faults if out.quiet else []:
            complain(f"{path}: {line}")
        for line in [*(faults or ["no problems found"]), *result.notes]:
            say(f"{path}: {line}")
    return result

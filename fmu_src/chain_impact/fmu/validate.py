"""The validation of an FMU: its zip, its model description, its binary and its reference results."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from chain_impact.fmu.check_description import description_findings
from chain_impact.fmu.findings import DESCRIPTION, END_MARK, Finding
from chain_impact.fmu.platforms import binary_of
from chain_impact.fmu.versions import is_fmi_2

TIMEOUT = 300.0
"""[s] Default time limit for the test run of an FMU's binary."""
_UNTRIED = "ScheduledExecution"


@dataclass(frozen=True, slots=True)
class Validation:
    """The result of a validation.

    Attributes:
        findings: the faults.
        notes: sentences on checks that passed, and on checks that could not be made.
        has_run: whether the binary was run.
    """

    findings: Sequence[Finding]
    notes: Sequence[str]
    has_run: bool = False


def validate_fmu(path: str | os.PathLike[str], *, run: bool = False) -> list[str]:
    """Check an FMU against the FMI standard; return a sentence for each fault.

    Args:
        path: an FMU of any tool, for co-simulation or model exchange, of FMI 2.0 or 3.0.
        run: whether the FMU's binary is also run, as ``chain-impact validate`` does. For an FMU that has only
            scheduled execution, the last sentence says that it is not run.

    Raises:
        OSError: when the file cannot be read.
    """
    try:
        result = validate_and_run(path) if run else Validation(description_findings(Path(path)), [])
    except zipfile.BadZipFile as error:
        return [f"not an FMU: {error}"]
    return [*map(str, result.findings), *([] if result.has_run else result.notes)]


def validate_and_run(path: str | os.PathLike[str], timeout: float = TIMEOUT) -> Validation:
    """Check an FMU; run its binary, if it can be run, in another process, which may crash or hang.

    Args:
        path: an FMU of any tool, for co-simulation or model exchange, of FMI 2.0 or 3.0.
        timeout: how long the binary may run [s].

    Raises:
        OSError: when the file cannot be read.
        zipfile.BadZipFile: when the file is not a zip.
    """
    path = Path(path)
    findings = description_findings(path)
    if any(not finding.variable and finding.attribute == "" for finding in findings):
        return Validation(findings, [])
    with zipfile.ZipFile(path) as fmu:
        names = set(fmu.namelist())
        root = ElementTree.fromstring(fmu.read(DESCRIPTION))
    modes = [mode for kind in ("CoSimulation", "ModelExchange") for mode in root.iterfind(kind)]
    if not modes:
        reason = f"not run: it has no CoSimulation or ModelExchange, only {_UNTRIED}"
        return Validation(findings, [reason] if root.find(_UNTRIED) is not None else [])
    identifier = modes[0].get("modelIdentifier", "")
    binary, missing_text = binary_of(identifier, names, is_fmi_2=is_fmi_2(root.get("fmiVersion")))
    if missing_text:
        return Validation([*findings, missing_text], [])
    test_result = _try_binary(path, binary, timeout, references=not findings)
    return Validation([*findings, *test_result.findings], test_result.notes, has_run=True)


def _try_binary(path: Path, binary: str, timeout: float, *, references: bool) -> Validation:
    """Run the binary of an FMU in a process of its own (check_run.py); return the findings and notes.

    ``references`` tells whether the reference results are compared, too.
    """
    with tempfile.TemporaryDirectory(prefix="chain-impact-", ignore_cleanup_errors=True) as folder:
        report, errors = Path(folder, "report"), Path(folder, "errors")
        command = [sys.executable, "-P", "-m", "chain_impact.fmu.check_run", str(path), str(report), binary]
        with errors.open("wb") as stream:
            process = subprocess.Popen(
                [*command, *(["--references"] if references else [])],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=stream,
                # temporary files that a crashed FMU leaves behind are removed together with this folder
                env={**os.environ, "TMPDIR": folder, "TEMP": folder},
            )
            try:
                code = process.wait(timeout)
                end_text = _end(code, errors.read_text(encoding="utf-8", errors="replace"))
            except subprocess.TimeoutExpired:
                end_text = f"did not return within {timeout:.9g} s"
            finally:
                process.kill()
                process.wait()
        lines: list[dict[str, Any]] = []
        if report.is_file():
            # what follows the last end of a line is incomplete, as the process may have been killed while it
            # wrote
            whole_lines = report.read_text(encoding="utf-8").rpartition("\n")[0]
            lines = [json.loads(line) for line in whole_lines.splitlines()]
    # a fault that occurs in several calls is listed once
    findings = list(dict.fromkeys(Finding(**line["finding"]) for line in lines if "finding" in line))
    calls = [line["call"] for line in lines if "call" in line]
    if END_MARK not in calls:
        findings.append(Finding(f"{calls[-1] if calls else 'the test run'} {end_text}", binary))
    return Validation(findings, [line["passed"] for line in lines if "passed" in line])


def _end(code: int, output: str) -> str:
    """Return words for how a process ended: by a signal, or with an exit code and its last line on stderr.

    ``code`` is −1 times the signal's number, or the exit code; ``output`` is the text on stderr.
    """
    if code < 0:
        return f"crashes the process: {signal.Signals(-code).name}"
    last = output.strip().splitlines()[-1:]
    exit_text = f"0x{code:X}" if code > 2**16 else str(code)
    return f"ends the process, exit code {exit_text}" + "".join(f": {line}" for line in last)

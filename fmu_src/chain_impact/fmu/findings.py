"""Findings: the faults of an FMU, each a sentence with the file and the variable in which it is.

This module also finds the faults of the zip, before the zip is unpacked.
"""

from __future__ import annotations

import posixpath
import re
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from chain_impact.text import names_text

DESCRIPTION = "modelDescription.xml"
# The test run of an FMU reports this word as its last call; if it is missing, the process ended too early.
END_MARK = "complete"
# [byte] The largest sum of the sizes of an FMU's unpacked files.
# An FMU with a larger sum is refused, as it could fill the disk. The sizes are those that the zip declares;
# Python never unpacks more than the declared size of a file.
LARGEST_SUM = 2**30
# largest number of variables that one line names; the line only counts further variables: "and 3 more"
NAMED_VARIABLES = 5
# if more findings than this differ only in the variable, they share one line
MOST_ALIKE_FINDINGS = 10


@dataclass(frozen=True, slots=True)
class Finding:
    """A fault of an FMU.

    Attributes:
        text: a sentence that describes the fault; its subject is the file, variable or attribute.
        file: the file in the FMU that has the fault; "" for the FMU as a whole.
        variable: the name of the variable with the fault; "" if the fault is not that of a variable.
        attribute: the attribute or element of the model description with the fault; "" for any other fault.
    """

    text: str
    file: str = DESCRIPTION
    variable: str = ""
    attribute: str = ""

    def __str__(self) -> str:
        """Return file, variable, attribute and sentence in one line."""
        return ": ".join([part for part in (self.file, self.variable, self.attribute) if part] + [self.text])


def finding_lines(findings: Iterable[Finding]) -> list[str]:
    """Return a line for each finding; findings that differ only in the variable may share a line.

    They share a line if they are more than MOST_ALIKE_FINDINGS.
    """
    alike_findings: dict[Finding, list[Finding]] = {}
    for finding in findings:
        # fmpy writes the variable's name and line into the text; without them, the texts of equal faults are
        # equal
        text = re.sub(rf'"{re.escape(finding.variable)}" \(line \d+\)', "", finding.text)
        alike_findings.setdefault(replace(finding, text=text, variable=""), []).append(finding)
    lines = []
    for first, *other_findings in alike_findings.values():
        if len(other_findings) < MOST_ALIKE_FINDINGS:
            lines += [str(first), *map(str, other_findings)]
        else:
            names = names_text([finding.variable for finding in (first, *other_findings)], NAMED_VARIABLES)
            lines.append(str(replace(first, variable=names)))
    return lines


def archive_findings(path: Path) -> list[Finding]:
    """Return the faults for which an FMU is not unpacked, such as unsafe paths and a size above LARGEST_SUM.

    Two files of the same name with different contents and a missing model description are such faults, too.

    Raises:
        OSError: when the file cannot be read.
        zipfile.BadZipFile: when the file is not a zip.
    """
    with zipfile.ZipFile(path) as fmu:
        entries = fmu.infolist()
    findings = [finding for entry in entries for finding in _entry_findings(entry)]
    size = sum(entry.file_size for entry in entries)
    if size > LARGEST_SUM:
        entry = max(entries, key=lambda entry: entry.file_size)
        findings.append(
            Finding(
                f"has {entry.file_size / 1e9:.3g} GB, and the whole FMU {size / 1e9:.3g} GB: an FMU of "
                f"more than {LARGEST_SUM / 1e9:.3g} GB is not unpacked",
                entry.filename,
            )
        )
    contents = {(entry.filename, entry.file_size, entry.CRC) for entry in entries}
    names = Counter(name for name, *_ in contents)
    if DESCRIPTION not in names:
        findings.append(Finding("is missing: the file is no FMU"))
    return findings + [
        Finding(f"is in the FMU {count} times, with different contents", name)
        for name, count in names.items()
        if count > 1
    ]


def _entry_findings(entry: zipfile.ZipInfo) -> Iterator[Finding]:
    name = entry.orig_filename.replace("\0", "")
    if "\\" in name:
        yield Finding("the path contains a backslash: it must have slashes only", name)
    elif name.startswith("/") or re.match(r"[^/]*:", name) or posixpath.normpath(name).startswith(".."):
        yield Finding("the path leaves the folder that the FMU is unpacked to", name)
    if entry.flag_bits & 1:
        yield Finding("is encrypted", name)

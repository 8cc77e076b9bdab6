"""The faults of planted_faults.txt, and FMUs that contain one of the faults."""

import re
import zipfile
from pathlib import Path
from typing import NamedTuple

from chain_impact.fmu.validate import validate_and_run
from chain_impact.system import HOST, PLATFORMS

XML = "modelDescription.xml"
SUFFIX = PLATFORMS[HOST].suffix
BINARIES = {"fmi3": f"binaries/{PLATFORMS[HOST].fmi3}/RodDrop{SUFFIX}"}
BINARY = f"binaries/{HOST}/RodDrop{SUFFIX}"
REPORTED, MISSED, BROKEN = "+-!"  # FMPy's result: found, missed, or an exception in FMPy
WHOLE = ["another GUID", "no binary", "a binary that is none", "no resources"]
"""Faults of the FMU as a whole, which are planted in FMUs of each kind; FMPy finds none of these faults."""


class Fault(NamedTuple):
    """A fault: FMPy's result, whether only a run shows the fault, the expected message, and the changes."""

    by_fmpy: str
    runs: bool
    sentence: str
    pairs: list[tuple[str, str]]


def within(name, pattern, new):
    """Return pattern and replacement for a change within the element of a variable of FMI 2.0 or 3.0."""
    inner = r"[^\n]*(?:\n *<(?:Real|Integer|Enumeration)[^\n]*)?"
    return rf'(name="{re.escape(name)}"{inner}){pattern}', rf"\1{new}"


def independent(without, name):
    """Return pattern and replacement that change a parameter into an independent variable.

    If ``without`` is true, they also remove the variable's start value.
    """
    head = (
        rf'(name="{re.escape(name)}"[^\n]*)causality="parameter" variability="\w+" initial="exact"(>\s*<\w+)'
    )
    new = r'\1causality="independent" variability="continuous"\2'
    return (rf"{head}([^\n]*) start=\S+", rf"{new}\3") if without else (head, new)


def _faults():
    """Return version of FMI → name → fault."""
    faults = {"2": {}, "3": {}}
    for block in re.split(r"\n(?=[23])", Path(__file__).with_suffix(".txt").read_text(encoding="utf-8"))[1:]:
        head, *changes = block.splitlines()
        kinds, name, sentence = head.split(" | ")
        versions, verdict, *run = kinds.split()
        fault = Fault(verdict, bool(run), sentence, [_pair(*line.split(" ⇒")) for line in changes])
        for version in versions:
            faults[version][name] = fault
    return faults


def _pair(pattern, new=""):
    """Return pattern and replacement, for the text of a model description, of a line in planted_faults.txt.

    ``pattern`` and ``new`` are the parts of the line before and after " ⇒".
    """
    if whole := re.fullmatch(r" *independent( without start)?: (.*)", pattern):
        return independent(*whole.groups())
    inner, new = re.fullmatch(r"    in (\S+): (.*)", pattern), new.removeprefix(" ")
    return within(*inner.groups(), new) if inner else (pattern[4:], new)


FAULTS = _faults()


def spoiled(fmu, target, change):
    """Write an FMU with changed files to ``target``, and return this path.

    ``change`` gets name and content of each file. It returns the new content, or None to leave the file out.
    """
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = change(name, old.read(name))
            if content is not None:
                new.writestr(name, content)
    return target


def edited(*pairs, alone=False):
    """Return a function ``change`` for ``spoiled``, which changes the model description.

    It makes the replacements of ``pairs`` (pattern, replacement); each pattern must occur. ``alone`` leaves
    out all other files.
    """

    def change(name, content):
        if name != XML:
            return None if alone else content
        text = content.decode()
        for pattern, new in pairs:
            text, count = re.subn(pattern, new, text, flags=re.DOTALL)
            assert count, pattern
        return text.encode()

    return change


def by_fmpy(path, *, names):
    """Return REPORTED, MISSED or BROKEN: FMPy's result for an FMU with a fault.

    ``names`` switches the check of variables' names on, which takes 10 ms for each name.
    """
    from fmpy.model_description import ValidationError, read_model_description

    try:
        read_model_description(str(path), validate_variable_names=names, validate_model_structure=True)
    except ValidationError:
        return REPORTED
    except Exception as error:
        return REPORTED if type(error) is Exception else BROKEN  # FMPy has no other class for its reports
    return MISSED


def finding_texts(path, **options):
    return [str(finding) for finding in validate_and_run(path, **options).findings]

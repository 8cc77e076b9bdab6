"""The model description of an FMU against the FMI standard: fmpy's checks, and those it lacks."""

from __future__ import annotations

import json
import re
import zipfile
import zlib
from pathlib import Path
from xml.etree import ElementTree

from chain_impact.fmu.check_lists import TERMINALS, list_findings, terminal_findings
from chain_impact.fmu.check_structure import Structure
from chain_impact.fmu.check_variables import variable_findings, variables_of
from chain_impact.fmu.findings import DESCRIPTION, Finding, archive_findings

TABLE = "resources/model.json"
VERSIONS = ("2.0", "3.0")
_NAMED = re.compile(r'[Vv]ariable (?:name )?"([^"]+)"')  # in fmpy's sentences
_TWICE = ("unit", "displayUnit", "valueReference", "declaredType")  # what fmpy looks at, too


def description_findings(path: Path) -> list[Finding]:
    """What is wrong with the zip and with the model description of an FMU. Nothing of it is run.

    Raises:
        OSError: when there is no such file.
        zipfile.BadZipFile: when it is no zip.
    """
    if found := archive_findings(path):
        return found
    with zipfile.ZipFile(path) as fmu:
        try:
            root = ElementTree.fromstring(fmu.read(DESCRIPTION))
            terminals = {
                name: ElementTree.fromstring(fmu.read(name)) for name in TERMINALS if name in fmu.namelist()
            }
            own_guid = _own_guid(fmu)
        except (ElementTree.ParseError, LookupError) as error:  # of an encoding that is not known
            return [Finding(f"is no XML: {error}")]
        except (zipfile.BadZipFile, zlib.error, RuntimeError, ValueError, EOFError) as error:
            return [Finding(f"cannot be unpacked: {error}")]
    version = root.get("fmiVersion", "")
    if not version.startswith(VERSIONS):
        said = f"fmiVersion = {version!r} must be one of {', '.join(VERSIONS)}: nothing else was checked"
        return [Finding(said, attribute="fmiVersion")]
    variables = variables_of(root)
    own = [*list_findings(root, variables), *variable_findings(root, variables)]
    names = {one.name for one in variables} | {alias.get("name", "") for alias in root.iter("Alias")}
    for file, content in terminals.items():
        own += terminal_findings(content, names, file)
    if own_guid not in (None, root.get("guid")):
        own.append(Finding(f"guid = {root.get('guid')} is not that of {TABLE}, {own_guid}", attribute="guid"))
    # fmpy ends in an IndexError or a KeyError where a reference leads nowhere
    structure = Structure(root, variables)
    if lost := list(structure.lost()):
        return lost + own
    own += structure.findings()
    return own + _of_fmpy(path, own)


def _own_guid(fmu: zipfile.ZipFile) -> str | None:
    """The GUID that an FMU of the kind pythonfmu was made with: its binary compares none."""
    table = json.loads(fmu.read(TABLE)) if TABLE in fmu.namelist() else None
    return table.get("guid") if isinstance(table, dict) else None


def _of_fmpy(path: Path, known: list[Finding]) -> list[Finding]:
    """What fmpy finds, but for what is known of the same variable."""
    from fmpy.model_description import ValidationError, read_model_description  # takes a second

    try:
        read_model_description(str(path))
    except ValidationError as error:
        problems = [str(problem) for problem in error.problems]
    except Exception as error:
        # fmpy has no class for its own sentences; others come of what the schema lets pass
        plain = type(error) is Exception
        if known and not plain:
            return []
        problems = [str(error) if plain else f"fmpy cannot read it: {type(error).__name__}: {error}"]
    else:
        return []
    found = []
    for problem in problems:
        named = _NAMED.search(problem)
        name = named[1] if named else ""
        if not any(one.variable == name and one.attribute in _TWICE for one in known if name):
            found.append(Finding(" ".join(problem.split()), variable=name))
    return found

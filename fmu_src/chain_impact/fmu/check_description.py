"""The model description of an FMU against the FMI standard: fmpy's checks, and those it lacks."""

from __future__ import annotations

import json
import re
import zipfile
import zlib
from pathlib import Path
from xml.etree import ElementTree

from chain_impact.fmu.archive import archive_findings
from chain_impact.fmu.check_structure import structure_findings
from chain_impact.fmu.check_variables import variable_findings, variables_of
from chain_impact.fmu.findings import DESCRIPTION, Finding

TABLE = "resources/model.json"
VERSIONS = ("2.0", "3.0")
_PART = r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?"
PLAIN_NAME = re.compile(rf"{_PART}(\.{_PART})*", re.ASCII)
"""Names of the structured convention; but for derivatives and what is quoted, which are allowed, too."""
_NAMED = re.compile(r'[Vv]ariable (?:name )?"([^"]+)"')  # in fmpy's sentences
_TWICE = ("unit", "displayUnit", "valueReference")  # what fmpy looks at, too


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
            own_guid = _own_guid(fmu)
        except ElementTree.ParseError as error:
            return [Finding(f"is no XML: {error}")]
        except (zipfile.BadZipFile, zlib.error, RuntimeError, ValueError, EOFError) as error:
            return [Finding(f"cannot be unpacked: {error}")]
    version = root.get("fmiVersion", "")
    if not version.startswith(VERSIONS):
        said = f"fmiVersion = {version!r} must be one of {', '.join(VERSIONS)}: nothing else was checked"
        return [Finding(said, attribute="fmiVersion")]
    variables = variables_of(root)
    # fmpy ends in an IndexError or a KeyError where a reference leads nowhere
    if broken := structure_findings(root, variables):
        return broken
    own = variable_findings(root, variables)
    if own_guid not in (None, root.get("guid")):
        own.append(Finding(f"guid = {root.get('guid')} is not that of {TABLE}, {own_guid}", attribute="guid"))
    return own + _of_fmpy(path, own)


def _own_guid(fmu: zipfile.ZipFile) -> str | None:
    """The GUID that an FMU of the kind pythonfmu was made with: its binary compares none."""
    table = json.loads(fmu.read(TABLE)) if TABLE in fmu.namelist() else None
    return table.get("guid") if isinstance(table, dict) else None


def _of_fmpy(path: Path, known: list[Finding]) -> list[Finding]:
    """What fmpy finds, but for what is known of the same variable.

    fmpy takes 10 ms for the grammar of each name, so it is asked for what is wrong only.
    """
    from fmpy.model_description import ValidationError, read_model_description  # takes a second

    try:
        description = read_model_description(str(path), validate_model_structure=True)
        if description.variableNamingConvention == "structured" and all(
            PLAIN_NAME.fullmatch(variable.name) for variable in description.modelVariables
        ):
            return []
        read_model_description(str(path), validate_variable_names=True)
    except ValidationError as error:
        found = []
        for problem in map(str, error.problems):
            named = _NAMED.search(problem)
            name = named[1] if named else ""
            if not any(one.variable == name and one.attribute in _TWICE for one in known if name):
                found.append(Finding(" ".join(problem.split()), variable=name))
        return found
    except Exception as error:  # of lxml, or of what the schema lets pass
        if known:
            return []
        return [Finding(f"fmpy cannot read it: {type(error).__name__}: {error}")]
    return []

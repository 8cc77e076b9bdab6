"""The check of an FMU's model description against the FMI standard.

fmpy checks the description by the XML schema and some rules; this module adds rules that fmpy does not check.
"""

from __future__ import annotations

import re
import zipfile
import zlib
from collections.abc import Container, Iterator, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from chain_impact.fmu.check_structure import ModelStructure, repeated_findings
from chain_impact.fmu.check_variables import (
    DescribedVariable,
    limit_findings,
    types_of,
    variable_findings,
    variables_of,
)
from chain_impact.fmu.findings import DESCRIPTION, Finding, archive_findings
from chain_impact.fmu.versions import VERSIONS

FMI_VERSIONS = tuple(f"{version}.0" for version in VERSIONS)
TERMINALS = ("terminalsAndIcons/terminalsAndIcons.xml", "icons/terminalsAndIcons.xml")
FMI_MODES = ("CoSimulation", "ModelExchange", "ScheduledExecution")
# Paths of elements whose children must all have different names, and different values in an enumeration.
LISTS = (
    "UnitDefinitions",
    "UnitDefinitions/Unit",
    "TypeDefinitions",
    "TypeDefinitions/SimpleType/Enumeration",
    "TypeDefinitions/EnumerationType",
    "LogCategories",
    "VendorAnnotations",
    "ModelVariables/ScalarVariable/Annotations",
    *(f"{mode}/SourceFiles" for mode in FMI_MODES),
)
_PART = r"""([A-Za-z_]\w*|'([ !#-&(-\[\]-_a-~]|\\['"?\\abfnrtv])+')(\[\d+(,\d+)*\])?"""
_NAME = rf"{_PART}(\.{_PART})*"
# Naming convention → regular expression that matches the allowed names.
# See FMI 2.0.4, section 2.2.9, and FMI 3.0, section 2.4.7.5.1.
NAME_PATTERNS = {
    "structured": re.compile(rf"{_NAME}|der\({_NAME}(,\d+)?\)", re.ASCII),
    "flat": re.compile(r"[^\r\n\t]+"),
}
# matches the beginning of fmpy's sentence on a fault against the XML schema; the group is the line's number
_SCHEMA_ERROR = re.compile(r"^ERROR \(line (\d+), column \d+\): ")
# matches the words in fmpy's sentence on a fault that name a variable; the group is the name
_NAME_IN_FAULT = re.compile(r'[Vv]ariable (?:name )?"([^"]+)"')


def description_findings(path: Path) -> list[Finding]:
    """Return the faults of an FMU's zip, model description and terminals, without running the FMU.

    Raises:
        OSError: when the file cannot be read.
        zipfile.BadZipFile: when the file is not a zip.
    """
    if findings := archive_findings(path):
        return findings
    roots: dict[str, Element] = {}
    with zipfile.ZipFile(path) as fmu:
        for name in (DESCRIPTION, *(name for name in TERMINALS if name in fmu.namelist())):
            try:
                roots[name] = ElementTree.fromstring(fmu.read(name))
            # ElementTree raises LookupError for an encoding that Python does not know
            except (ElementTree.ParseError, LookupError) as error:
                return [Finding(f"is no XML: {error}", name)]
            except (zipfile.BadZipFile, zlib.error, RuntimeError, ValueError, EOFError) as error:
                return [Finding(f"cannot be unpacked: {error}", name)]
    root = roots.pop(DESCRIPTION)
    version = root.get("fmiVersion", "")
    if not version.startswith(FMI_VERSIONS):
        fault = f"fmiVersion = {version!r} must be one of {', '.join(FMI_VERSIONS)}: nothing else was checked"
        return [Finding(fault, attribute="fmiVersion")]
    variables = variables_of(root)
    faults = [*list_findings(root, variables), *variable_findings(root, variables)]
    names = {variable.name for variable in variables} | {
        alias.get("name", "") for alias in root.iter("Alias")
    }
    for file, content in roots.items():
        faults += terminal_findings(content, names, file)
    structure = ModelStructure(root, variables)
    # fmpy (in ``_fmpy_faults``) would raise IndexError or KeyError for a reference to a missing variable
    if not (lost_faults := list(structure.missing_variable_faults())):
        faults += structure.findings()
        # a fault that the XML schema refuses causes other faults, so it is listed first
        faults = _fmpy_faults(path, is_known=bool(faults)) + faults
    # two references to the same variable may give the same finding, which is listed once
    return list(dict.fromkeys(lost_faults + faults))


def _fmpy_faults(path: Path, *, is_known: bool) -> list[Finding]:
    """Return the faults that fmpy finds in the model description.

    ``is_known`` tells whether a fault of the FMU is already known. If fmpy then fails with an unexpected
    error, the known fault is probably the cause, and the error of fmpy is not reported.
    """
    # imported here, because the import takes a second
    from fmpy.model_description import ValidationError, read_model_description

    try:
        read_model_description(str(path))
    except ValidationError as error:
        problems = [str(problem) for problem in error.problems]
    except Exception as error:
        # fmpy raises Exception itself for a fault that it looks for. Another class, such as KeyError, means
        # that fmpy has failed at a fault for which it does not look.
        is_plain = type(error) is Exception
        if is_known and not is_plain:
            return []
        problems = [str(error) if is_plain else f"fmpy cannot read it: {type(error).__name__}: {error}"]
    else:
        return []
    problems = [_SCHEMA_ERROR.sub(r"line \1: ", " ".join(problem.split())) for problem in problems]
    name_matches = [_NAME_IN_FAULT.search(problem) for problem in problems]
    return [
        Finding(problem, variable=name[1] if name else "")
        for problem, name in zip(problems, name_matches, strict=True)
    ]


def list_findings(root: Element, variables: Sequence[DescribedVariable]) -> list[Finding]:
    """Return the faults of lists, FMI modes, types, names of variables, and the default experiment.

    The FMI modes are co-simulation, model exchange and scheduled execution.
    """
    repeated_names = (
        finding
        for path in LISTS
        for parent in root.iterfind(path)
        for key in ("name", "value")
        for finding in repeated_findings(
            (child.attrib[key] for child in parent if key in child.attrib), key, path
        )
    )
    name_findings = _name_faults(root.get("variableNamingConvention", "flat"), variables)
    return [
        *repeated_names,
        *_mode_faults(root),
        *_type_faults(root, variables),
        *name_findings,
        *_experiment_faults(root),
    ]


def _mode_faults(root: Element) -> Iterator[Finding]:
    """Yield a fault if a description has no FMI mode, and for each model identifier that is no name in C."""
    modes = [mode for kind in FMI_MODES for mode in root.iterfind(kind)]
    if not modes:
        yield Finding(f"has none of {', '.join(FMI_MODES)}: it cannot be run", attribute="CoSimulation")
    for mode in modes:
        name = mode.get("modelIdentifier", "")
        if not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
            fault = f"modelIdentifier = {name!r} must be a name of C: letters, digits and _, no digit first"
            yield Finding(fault, attribute=mode.tag)


def _type_faults(root: Element, variables: Sequence[DescribedVariable]) -> Iterator[Finding]:
    """Yield the faults of declared types: of limits, of units, and of names that a variable has, too."""
    names = {variable.name for variable in variables}
    units = {
        unit.get("name", ""): {display.get("name") for display in unit.iterfind("DisplayUnit")}
        for unit in root.iterfind("UnitDefinitions/Unit")
    }
    for definition in types_of(root):
        type_path = f"TypeDefinitions/{definition.name}"
        for attribute, text in limit_findings(definition):
            yield Finding(text, attribute=f"{type_path}/{attribute}")
        yield from _unit_faults(definition, units, type_path)
        if definition.name in names:
            yield Finding("a variable has the same name", attribute=type_path)


def _name_faults(convention: str, variables: Sequence[DescribedVariable]) -> Iterator[Finding]:
    """Yield a fault if there are several independent variables, and for each name that is not allowed.

    ``convention`` is the naming convention that the model description claims to follow.
    """
    times = [variable.name for variable in variables if variable.causality == "independent"]
    if len(times) > 1:
        fault = f"{', '.join(times)} are independent variables: only one is allowed"
        yield Finding(fault, attribute="ModelVariables")
    allowed_pattern = NAME_PATTERNS.get(convention, NAME_PATTERNS["flat"])
    for variable in variables:
        if not allowed_pattern.fullmatch(variable.name):
            fault = f"{variable.name!r} is not a name of the naming convention {convention!r}"
            yield Finding(fault, variable=variable.name, attribute="name")


def _unit_faults(
    variable: DescribedVariable, units: Mapping[str, Container[str | None]], attribute: str
) -> Iterator[Finding]:
    """Yield a fault if the unit or the display unit of a declared type is not defined.

    ``variable`` is the type in the form of a variable, ``units`` has for each unit the names of its display
    units, and ``attribute`` is the path of the type, for the finding. fmpy checks the units of variables.
    """
    unit, display = (variable.attributes.get(key) for key in ("unit", "displayUnit"))
    if unit is not None and unit not in units:
        yield Finding(f"unit = {unit!r} must be in UnitDefinitions", attribute=f"{attribute}/unit")
    elif display is not None and display not in units.get(unit or "", ()):
        text = f"displayUnit = {display!r} must be a DisplayUnit of the type's unit in UnitDefinitions"
        yield Finding(text, attribute=f"{attribute}/displayUnit")


def _experiment_faults(root: Element) -> Iterator[Finding]:
    node, attribute = root.find("DefaultExperiment"), "DefaultExperiment"
    given_values = {"startTime": "0"} | (dict(node.items()) if node is not None else {})
    try:
        start_time, stop_time, step, tolerance = (
            float(given_values.get(key, "nan")) for key in ("startTime", "stopTime", "stepSize", "tolerance")
        )
    except ValueError:  # fmpy's check by the XML schema reports an attribute that is not a number
        return
    if stop_time < start_time:
        yield Finding(
            f"stopTime = {stop_time:.9g} must not be before startTime = {start_time:.9g}", attribute=attribute
        )
    if step <= 0.0 or step > stop_time - start_time > 0.0:
        yield Finding(f"stepSize = {step:.9g} must be > 0 and fit into the experiment", attribute=attribute)
    if tolerance < 0.0:
        yield Finding(f"tolerance = {tolerance:.9g} must not be negative", attribute=attribute)


def terminal_findings(root: Element, names: set[str], file: str) -> Iterator[Finding]:
    """Yield the faults of terminals: names of variables that do not exist, and names that occur twice.

    ``names`` are the names and aliases of all variables, ``file`` is the path of the terminals in the FMU.
    See FMI 3.0, section 2.4.9.2.
    """
    for parent in root.iter():
        for tag, key in (("Terminal", "name"), ("TerminalMemberVariable", "memberName")):
            for repeated_finding in repeated_findings(
                filter(None, (node.get(key) for node in parent.findall(tag))), key, tag
            ):
                yield Finding(repeated_finding.text, file, attribute=parent.get("name", parent.tag))
        for key, name in parent.items():
            if key.lower().endswith("variablename") and name not in names:
                yield Finding(f"{key} = {name!r} must be the name of a variable", file, attribute=parent.tag)

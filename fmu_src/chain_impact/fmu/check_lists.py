"""What a model description says besides its variables: names, types, kinds of use, experiment, terminals."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element

from chain_impact.fmu.check_structure import twice
from chain_impact.fmu.check_variables import Variable, limit_findings, types_of
from chain_impact.fmu.findings import Finding

TERMINALS = ("terminalsAndIcons/terminalsAndIcons.xml", "icons/terminalsAndIcons.xml")
MODES = ("CoSimulation", "ModelExchange", "ScheduledExecution")
LISTS = (
    "UnitDefinitions",
    "UnitDefinitions/Unit",
    "TypeDefinitions",
    "TypeDefinitions/SimpleType/Enumeration",
    "TypeDefinitions/EnumerationType",
    "LogCategories",
    "VendorAnnotations",
    "ModelVariables/ScalarVariable/Annotations",
    *(f"{mode}/SourceFiles" for mode in MODES),
)
"""Lists in which each name, and each value of an enumeration, stands once."""
_PART = r"""([A-Za-z_]\w*|'([ !#-&(-\[\]-_a-~]|\\['"?\\abfnrtv])+')(\[\d+(,\d+)*\])?"""
_NAME = rf"{_PART}(\.{_PART})*"
NAMES = {
    "structured": re.compile(rf"{_NAME}|der\({_NAME}(,\d+)?\)", re.ASCII),
    "flat": re.compile(r"[^\r\n\t]+"),
}
"""What a variable may be called by a naming convention: FMI 2.0.4, 2.2.9; FMI 3.0, 2.4.7.5.1."""


def list_findings(root: Element, variables: Sequence[Variable]) -> list[Finding]:
    """What is wrong in the lists, and with the kinds of use and the default experiment."""
    found = [
        finding
        for path in LISTS
        for parent in root.iterfind(path)
        for key in ("name", "value")
        for finding in twice((child.attrib[key] for child in parent if key in child.attrib), key, path)
    ]
    modes = [mode for kind in MODES for mode in root.iterfind(kind)]
    if not modes:
        found.append(Finding(f"has none of {', '.join(MODES)}: it cannot be run", attribute="CoSimulation"))
    for mode in modes:
        name = mode.get("modelIdentifier", "")
        if not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
            said = f"modelIdentifier = {name!r} must be a name of C: letters, digits and _"
            found.append(Finding(said, attribute=mode.tag))
    times = [one.name for one in variables if one.causality == "independent"]
    if len(times) > 1:
        said = f"{', '.join(times)} are independent variables: there can be one"
        found.append(Finding(said, attribute="ModelVariables"))
    names = {one.name for one in variables}
    for one in types_of(root):
        place = f"TypeDefinitions/{one.name}"
        found += [Finding(text, attribute=f"{place}/{attribute}") for attribute, text in limit_findings(one)]
        if one.name in names:
            found.append(Finding("a variable has the same name", attribute=place))
    convention = root.get("variableNamingConvention", "flat")
    allowed = NAMES.get(convention, NAMES["flat"])
    for one in variables:
        if not allowed.fullmatch(one.name):
            said = f"{one.name!r} is no name of the naming convention {convention!r}"
            found.append(Finding(said, variable=one.name, attribute="name"))
    return [*found, *_of_experiment(root)]


def _of_experiment(root: Element) -> Iterator[Finding]:
    node, place = root.find("DefaultExperiment"), "DefaultExperiment"
    given = {"startTime": "0"} | (dict(node.items()) if node is not None else {})
    try:
        start, stop, step, tolerance = (
            float(given.get(key, "nan")) for key in ("startTime", "stopTime", "stepSize", "tolerance")
        )
    except ValueError:  # the schema tells
        return
    if stop < start:
        yield Finding(f"stopTime = {stop:.9g} must not be before startTime = {start:.9g}", attribute=place)
    if step <= 0.0 or step > stop - start > 0.0:
        yield Finding(f"stepSize = {step:.9g} must be > 0 and fit into the experiment", attribute=place)
    if tolerance < 0.0:
        yield Finding(f"tolerance = {tolerance:.9g} must not be negative", attribute=place)


def terminal_findings(root: Element, names: set[str], file: str) -> Iterator[Finding]:
    """Variables of terminals that are not there, and names that two have: FMI 3.0, 2.4.9.2."""
    for parent in root.iter():
        for tag, key in (("Terminal", "name"), ("TerminalMemberVariable", "memberName")):
            for found in twice(filter(None, (node.get(key) for node in parent.findall(tag))), key, tag):
                yield Finding(found.text, file, attribute=parent.get("name", parent.tag))
        for key, name in parent.items():
            if key.lower().endswith("variablename") and name not in names:
                yield Finding(f"{key} = {name!r} must be the name of a variable", file, attribute=parent.tag)

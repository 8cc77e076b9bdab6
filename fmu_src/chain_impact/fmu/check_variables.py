"""The variables of a model description: what their attributes say of each other."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from chain_impact.fmu.findings import Finding

REALS = ("Real", "Float32", "Float64")
TEXTS = ("String", "Binary", "Clock")
Value = float | bool | str


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable as its FMU describes it.

    Attributes:
        name: its name.
        reference: its value reference, as it is written.
        type: the tag of its element, as ``Real`` or ``Float64``.
        attributes: its own and those of its declared type.
        choices: the values of its enumeration, if it is one.
        node: its element.
        size: the number of its values, or None if that cannot be told.
    """

    name: str
    reference: str
    type: str
    attributes: Mapping[str, str]
    choices: Sequence[int]
    node: Element
    size: int | None

    @property
    def start(self) -> list[str]:
        """The start values as they are written; none if there are none."""
        if given := [entry.get("value", "") for entry in self.node.iter("Start")]:
            return given
        text = self.attributes.get("start")
        if text is None:
            return []
        return [text] if self.type in TEXTS or (self.size == 1 and " " not in text.strip()) else text.split()

    @property
    def exact(self) -> bool:
        """Whether its start is its value at the start, not a guess."""
        causality, initial = (self.attributes.get(name, "") for name in ("causality", "initial"))
        given = causality in ("parameter", "structuralParameter", "input")
        return initial == "exact" or (
            not initial and (given or self.attributes.get("variability") == "constant")
        )

    def value(self, text: str) -> Value:
        """A value of this variable as a number, a truth value or a text; NaN if it is none."""
        if self.type in TEXTS:
            return text
        if self.type == "Boolean":
            return text in ("true", "1")
        try:
            return float(text) if self.type in REALS else int(text)
        except ValueError:
            return math.nan

    def bound(self, name: str) -> float:
        """Its attribute ``min`` or ``max``; infinite if it has none."""
        text = self.attributes.get(name)
        if text is None or self.type in (*TEXTS, "Boolean"):
            return math.inf if name == "max" else -math.inf
        return float(self.value(text))


def variables_of(root: Element) -> list[Variable]:
    """The variables of a model description, in its order."""
    types = {}
    for node in root.iterfind("TypeDefinitions/*"):
        inner = node[0] if node.tag == "SimpleType" and len(node) else node
        shared = {key: text for key, text in inner.attrib.items() if key not in ("name", "description")}
        values = [item.get("value", "") for item in inner.iter("Item")]
        choices = [int(value) for value in values if re.fullmatch(r"-?[0-9]+", value)]
        types[node.get("name", "")] = shared, choices
    nodes = root.findall("ModelVariables/*")
    starts = {node.get("valueReference"): node.get("start", "") for node in nodes}
    found = []
    for node in nodes:
        inner = next((child for child in node if child.tag != "Annotations"), node)
        inner = inner if node.tag == "ScalarVariable" else node
        own = {**node.attrib, **inner.attrib}
        shared, choices = types.get(own.get("declaredType", ""), ({}, []))
        found.append(
            Variable(
                name=node.get("name", ""),
                reference=node.get("valueReference", ""),
                type=inner.tag,
                attributes={**shared, **own},
                choices=choices,
                node=inner,
                size=_size(inner, starts),
            )
        )
    return found


def _size(node: Element, starts: Mapping[str | None, str]) -> int | None:
    """The number of the values of a variable; a dimension is a number or the start of a parameter."""
    texts = [
        dimension.get("start") or starts.get(dimension.get("valueReference"), "")
        for dimension in node.iter("Dimension")
    ]
    return math.prod(map(int, texts)) if all(text.isdecimal() for text in texts) else None


def variable_findings(root: Element, variables: Sequence[Variable]) -> list[Finding]:
    """Starts, limits and units that do not fit, and values that two variables own."""
    found = [
        Finding(text, variable=variable.name, attribute=attribute)
        for variable in variables
        for attribute, text in (*_of_limits(variable), *_of_start(variable))
    ]
    found += _units(root, variables)
    return found + (_aliases(variables) if root.get("fmiVersion") == "2.0" else [])


def _of_limits(variable: Variable) -> Iterator[tuple[str, str]]:
    low, high = variable.bound("min"), variable.bound("max")
    if low > high:
        yield "min", f"min = {low:.9g} must not be above max = {high:.9g}"


def _of_start(variable: Variable) -> Iterator[tuple[str, str]]:
    start, low, high = variable.start, variable.bound("min"), variable.bound("max")
    if (
        start
        and variable.size is not None
        and variable.type not in TEXTS
        and len(start) not in {1, variable.size}
    ):
        yield "start", f"there are {len(start)} values, and the dimensions make {variable.size}"
    for text in start if variable.type not in (*TEXTS, "Boolean") else ():
        value = float(variable.value(text))
        if low <= high and (value < low or value > high):
            side, limit = ("below min", low) if value < low else ("above max", high)
            yield "start", f"start = {text} is {side} = {limit:.9g}"
        elif variable.choices and value not in variable.choices:
            yield "start", f"start = {text} is none of the values of the enumeration"


def _units(root: Element, variables: Sequence[Variable]) -> Iterator[Finding]:
    """Units that are not defined, of variables and of their types."""
    units = {
        node.get("name", ""): {shown.get("name") for shown in node.iter("DisplayUnit")}
        for node in root.iterfind("UnitDefinitions/Unit")
    }
    for one in variables:
        unit, shown = one.attributes.get("unit"), one.attributes.get("displayUnit")
        if unit is not None and unit not in units:
            said = f"unit = {unit!r} must be defined in UnitDefinitions"
            yield Finding(said, variable=one.name, attribute="unit")
        elif shown is not None and shown not in units.get(unit or "", ()):
            said = f"displayUnit = {shown!r} must be defined in UnitDefinitions for the unit {unit!r}"
            yield Finding(said, variable=one.name, attribute="displayUnit")


def _aliases(variables: Sequence[Variable]) -> list[Finding]:
    """Variables of FMI 2.0 that share a value but cannot: FMI 2.0, 2.2.7.

    What is shared may be set by one of them only, and has one unit and one start value.
    """
    first: dict[tuple[str, str], Variable] = {}
    found = []
    for one in variables:
        base = "Integer" if one.type == "Enumeration" else one.type
        other = first.setdefault((base, one.reference), one)
        if other is one:
            continue
        pairs = [
            (one.attributes.get(key), other.attributes.get(key)) for key in ("causality", "unit", "start")
        ]
        reason = ""
        if all(causality in ("parameter", "input") for causality in pairs[0]):
            reason = "both can be set"
        elif None not in pairs[1] and pairs[1][0] != pairs[1][1]:
            reason = f"their units differ, {pairs[1][0]} and {pairs[1][1]}"
        elif None not in pairs[2] and one.value(str(pairs[2][0])) != other.value(str(pairs[2][1])):
            reason = f"their start values differ, {pairs[2][0]} and {pairs[2][1]}"
        if reason:
            said = f"valueReference = {one.reference} is that of {other.name}, too, and {reason}"
            found.append(Finding(said, variable=one.name, attribute="valueReference"))
    return found

"""The check of the variables in a model description: whether each variable's attributes fit together."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from chain_impact.fmu.findings import Finding
from chain_impact.fmu.versions import is_fmi_2

REALS = ("Real", "Float32", "Float64")
TEXTS = ("String", "Binary", "Clock")
Value = float | bool | str


@dataclass(frozen=True, slots=True)
class DescribedVariable:
    """A variable, or a declared type, as a model description has it.

    Attributes:
        name: the name.
        reference: the value reference, as text.
        type: the kind of value: the element's tag without "Type", such as ``Real`` or ``Float64``.
        attributes: the variable's own attributes, and those of its declared type that it does not have
            itself.
        choices: the values of an enumeration; empty for other types.
        node: the element with the attributes of the type, such as ``Real``.
        size: the number of values, 1 for a scalar; None if it cannot be determined.
    """

    name: str
    reference: str
    type: str
    attributes: Mapping[str, str]
    choices: Sequence[int]
    node: Element
    size: int | None

    @property
    def causality(self) -> str:
        """The attribute ``causality``, or FMI's default ``local``."""
        return self.attributes.get("causality", "local")

    @property
    def start(self) -> list[str]:
        """The texts of the start values: one, or one for each element of an array; empty without any."""
        if given_values := [entry.get("value", "") for entry in self.node.iter("Start")]:
            return given_values
        text = self.attributes.get("start")
        if text is None:
            return []
        return [text] if self.type in TEXTS or (self.size == 1 and " " not in text.strip()) else text.split()

    @property
    def is_exact(self) -> bool:
        """Whether the start value holds at the start of a run, and is not only a guess for a computation."""
        initial_text = self.attributes.get("initial", "")
        is_given = self.causality in ("parameter", "structuralParameter", "input")
        return initial_text == "exact" or (
            not initial_text and (is_given or self.attributes.get("variability") == "constant")
        )

    def value(self, text: str) -> Value:
        """Return the value that a text stands for: a number, a bool or a text, by the type of the variable.

        The result is NaN for a text that is no number of the type; a bool is True only for "true" or "1".
        """
        if self.type in TEXTS:
            return text
        if self.type == "Boolean":
            return text in ("true", "1")
        try:
            return float(text) if self.type in REALS else int(text)
        except ValueError:
            return math.nan

    def bound(self, name: str) -> float:
        """Return the limit ``min`` or ``max`` (``name``); −∞ or ∞ if the variable or its type has none.

        The result is NaN if the limit is no number of the type.
        """
        text = self.attributes.get(name)
        if text is None or self.type in (*TEXTS, "Boolean"):
            return math.inf if name == "max" else -math.inf
        return float(self.value(text))

    def passed_limit(self, value: float) -> str:
        """Return words for the limit that ``value`` is beyond; "" within the limits, or if min > max."""
        low, high = self.bound("min"), self.bound("max")
        if low > high:  # limits in the wrong order are a fault of their own, which ``limit_findings`` reports
            return ""
        return f"below min = {low:.9g}" if value < low else f"above max = {high:.9g}" if value > high else ""


def types_of(root: Element) -> list[DescribedVariable]:
    """Return the declared types of a model description, each in the form of a variable."""
    return [_variable(node, {}, 1) for node in root.iterfind("TypeDefinitions/*")]


def variables_of(root: Element) -> list[DescribedVariable]:
    """Return the variables of a model description, in the order of the description."""
    types = {definition.name: definition for definition in types_of(root)}
    nodes = root.findall("ModelVariables/*")
    starts = {node.get("valueReference"): node.get("start", "") for node in nodes}
    return [_variable(node, types, _size(node, starts)) for node in nodes]


def _variable(node: Element, types: Mapping[str, DescribedVariable], size: int | None) -> DescribedVariable:
    """Return the variable of an element; attributes that the element lacks come from the declared type.

    ``types`` has the declared types by name; ``size``: number of the variable's values, None if unknown.
    """
    is_nested = node.tag in ("ScalarVariable", "SimpleType")
    inner_node = next((child for child in node if is_nested and child.tag != "Annotations"), node)
    declared_type = types.get(inner_node.get("declaredType", ""))
    values = [item.get("value", "") for item in inner_node.iter("Item")]
    choices = [int(value) for value in values if re.fullmatch(r"-?[0-9]+", value)]
    return DescribedVariable(
        name=node.get("name", ""),
        reference=node.get("valueReference", ""),
        type=inner_node.tag.removesuffix("Type"),
        attributes={
            **(declared_type.attributes if declared_type else {}),
            **node.attrib,
            **inner_node.attrib,
        },
        choices=declared_type.choices if declared_type else choices,
        node=inner_node,
        size=size,
    )


def _size(node: Element, starts: Mapping[str | None, str]) -> int | None:
    """Return the number of values of a variable or array; None if it cannot be determined.

    A dimension is given as a number, or as the value reference of a variable whose start value is the number;
    ``starts`` has the start value of each reference.
    """
    texts = [
        dimension.get("start") or starts.get(dimension.get("valueReference"), "")
        for dimension in node.iter("Dimension")
    ]
    return math.prod(map(int, texts)) if all(text.isdecimal() for text in texts) else None


def variable_findings(root: Element, variables: Sequence[DescribedVariable]) -> list[Finding]:
    """Return the faults of attributes, start values, limits and types.

    For FMI 2.0, return also the faults of variables that share a value reference.
    """
    types = {definition.name: definition.type for definition in types_of(root)}
    findings = [
        Finding(text, variable=variable.name, attribute=attribute)
        for variable in variables
        for attribute, text in (
            *limit_findings(variable),
            *_start_pairs(variable),
            *_type_pairs(variable, types),
            *_attribute_pairs(variable, root),
        )
    ]
    return findings + (_aliases(variables) if is_fmi_2(root.get("fmiVersion")) else [])


def limit_findings(variable: DescribedVariable) -> Iterator[tuple[str, str]]:
    """Yield the fault of a variable whose min is above its max, as a pair of an attribute and a sentence."""
    low, high = variable.bound("min"), variable.bound("max")
    if low > high:
        yield "min", f"min = {low:.9g} must not be above max = {high:.9g}"


def _type_pairs(variable: DescribedVariable, types: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    declared_type = variable.attributes.get("declaredType", "")
    if types.get(declared_type, variable.type) != variable.type:
        fault = f"is a type of {types[declared_type]}, and the variable is of {variable.type}"
        yield "declaredType", f"declaredType = {declared_type!r} {fault}"


def _attribute_pairs(variable: DescribedVariable, root: Element) -> Iterator[tuple[str, str]]:
    """Yield a pair, attribute and sentence, for each attribute that a variable must not have.

    The reason is the variable's causality or, in FMI 2.0, that the FMU is not for model exchange.
    """
    of_fmi_2, causality = is_fmi_2(root.get("fmiVersion")), variable.causality
    if of_fmi_2 and causality in ("input", "independent") and "initial" in variable.attributes:
        yield "initial", f"initial must not be given where causality = {causality!r}"
    capability = "canHandleMultipleSetPerTimeInstant"
    if capability in variable.attributes and causality != "input":
        yield capability, f"{capability} is for inputs only"
    for name in (capability, "reinit"):
        if of_fmi_2 and name in variable.attributes and root.find("ModelExchange") is None:
            yield name, f"{name} is for model exchange only"


def _start_pairs(variable: DescribedVariable) -> Iterator[tuple[str, str]]:
    start = variable.start
    if (
        start
        and variable.size is not None
        and variable.type not in TEXTS
        and len(start) not in {1, variable.size}
    ):
        yield "start", f"there are {len(start)} values, and the dimensions make {variable.size}"
    for text in start if variable.type not in (*TEXTS, "Boolean") else ():
        value = float(variable.value(text))
        if side := variable.passed_limit(value):
            yield "start", f"start = {text} is {side}"
        elif variable.choices and value not in variable.choices:
            yield "start", f"start = {text} is not a value of the enumeration"


def _aliases(variables: Sequence[DescribedVariable]) -> list[Finding]:
    """Return the faults of aliases, variables with the same value reference (FMI 2.0, 2.2.7).

    Of the variables with one reference, only one may be set from outside, and all must have the same unit.
    Either all are constants of the same value; or none is constant, and at most one has a start value. Each
    variable is compared with the first one of its reference only.
    """
    first: dict[tuple[str, str], DescribedVariable] = {}
    findings = []
    for variable in variables:
        base = "Integer" if variable.type == "Enumeration" else variable.type
        alias = first.setdefault((base, variable.reference), variable)
        if alias is variable:
            continue
        causality, unit, start, variability = [
            (variable.attributes.get(key), alias.attributes.get(key))
            for key in ("causality", "unit", "start", "variability")
        ]
        reason = ""
        if all(kind in ("parameter", "input", "independent") for kind in causality):
            reason = "both are set from outside"
        elif unit[0] != unit[1]:
            units_text = " and ".join(name or "none" for name in unit)
            reason = (
                f"their units differ, {units_text}: variables of an alias set have one unit (FMI 2.0, 2.2.7)"
            )
        elif (variability[0] == "constant") != (variability[1] == "constant"):
            reason = "one is constant, and one is not"
        elif None not in start and variability[0] != "constant":
            reason = "both have a start value"
        elif None not in start and variable.value(str(start[0])) != alias.value(str(start[1])):
            reason = f"their start values differ, {start[0]} and {start[1]}"
        if reason:
            fault = (
                f"valueReference = {variable.reference} is also the reference of {alias.name}, and {reason}"
            )
            findings.append(Finding(fault, variable=variable.name, attribute="valueReference"))
    return findings

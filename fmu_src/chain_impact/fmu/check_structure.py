"""The references within a model description: each must lead to what is there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element

from chain_impact.fmu.check_variables import Variable
from chain_impact.fmu.findings import Finding


def structure_findings(root: Element, variables: Sequence[Variable]) -> list[Finding]:
    """References of a model description that lead nowhere."""
    second = root.get("fmiVersion") == "2.0"
    known = {str(i) for i in range(1, len(variables) + 1)} if second else {one.reference for one in variables}
    what = f"an index from 1 to {len(variables)}" if second else "the value reference of a variable"
    found = [*_types(root, variables)]
    for one in variables:
        target = one.attributes.get("derivative")
        if target is not None and target not in known:
            found.append(
                Finding(f"derivative = {target!r} must be {what}", variable=one.name, attribute="derivative")
            )
        for dimension in one.node.iter("Dimension"):
            size = dimension.get("valueReference")
            if size is not None and size not in known:
                said = f"valueReference = {size!r} must be {what}"
                found.append(Finding(said, variable=one.name, attribute="Dimension"))
    found += _unknowns(root, "index" if second else "valueReference", known, what)
    return found


def _unknowns(root: Element, key: str, known: set[str], what: str) -> Iterator[Finding]:
    """References of the model structure."""
    structure = root.find("ModelStructure")
    groups: dict[str, list[Element]] = {}
    for node in structure.iter() if structure is not None else ():
        if key == "index":
            if node.tag != "Unknown" and len(node):
                groups[node.tag] = list(node.iter("Unknown"))
        elif node.get(key) is not None:
            groups.setdefault(node.tag, []).append(node)
    groups.pop("ModelStructure", None)
    for tag, nodes in groups.items():
        place = f"ModelStructure/{tag}"
        for target, count in Counter(node.get(key, "") for node in nodes).items():
            if target not in known:
                yield Finding(f"{key} = {target!r} must be {what}", attribute=place)
            elif count > 1:
                yield Finding(f"{key} = {target!r} stands there {count} times", attribute=place)
        for node in nodes:
            depends = (node.get("dependencies") or "").split()
            place_of = f"{place}, {key} {node.get(key)}, dependencies"
            for target in sorted({one for one in depends if one not in known}):
                yield Finding(f"{target!r} must be {what}", attribute=place_of)
            kinds = node.get("dependenciesKind")
            if kinds is not None and len(kinds.split()) != len(depends):
                said = f"there are {len(depends)} dependencies, and {len(kinds.split())} in dependenciesKind"
                yield Finding(said, attribute=place_of)


def _types(root: Element, variables: Sequence[Variable]) -> Iterator[Finding]:
    types = {node.get("name") for node in root.iterfind("TypeDefinitions/*")}
    for one in variables:
        declared = one.attributes.get("declaredType")
        if declared is not None and declared not in types:
            said = f"declaredType = {declared!r} must be defined in TypeDefinitions"
            yield Finding(said, variable=one.name, attribute="declaredType")

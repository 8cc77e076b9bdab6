"""The terminalsAndIcons.xml of an FMU for FMI 3.0 (section 2.4.9): variables that belong together."""

from __future__ import annotations

import re
from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from chain_impact.variables.variable import Variable

FILE = "terminalsAndIcons/terminalsAndIcons.xml"
OWNERS = re.compile(r"((?:joint|point)\[\d+\]|base|tip|wall\.\w+)\.(.+)")
"""Whose variables make a terminal, which has the owner's name; and the member's name."""
EDGES = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
"""Of the icon in its coordinate system."""


def terminals_and_icons(variables: Iterable[Variable]) -> bytes:
    """A terminal for each joint and point, the base, the tip and each wall, with its inputs and outputs.

    The terminals of walls are in one called ``wall``, so that its path is the first part of the variables'
    names. All members are signals; members of equal names are to be connected ("bus").
    """
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    looks = SubElement(root, "GraphicalRepresentation")
    SubElement(looks, "CoordinateSystem", EDGES, suggestedScalingFactorTo_mm="0.1")
    SubElement(looks, "Icon", EDGES)
    terminals = Element("Terminals")
    made: dict[str, Element] = {}

    def terminal(path: str) -> Element:
        if path not in made:
            above, _, name = path.rpartition(".")
            parent = terminal(above) if above else terminals
            made[path] = SubElement(parent, "Terminal", name=name, matchingRule="bus")
        return made[path]

    for variable in variables:
        found = OWNERS.fullmatch(variable.name)
        if found and variable.causality in ("input", "output"):
            owner, member = found.groups()
            SubElement(
                terminal(owner),
                "TerminalMemberVariable",
                variableName=variable.name,
                memberName=member,
                variableKind="signal",
            )
    if made:
        root.append(terminals)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root)

"""Documents inside an FMU: documentation, licenses and icon for people, and the terminals of FMI 3.0."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib.metadata import distribution
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from chain_impact.compilation.errors import BuildError
from chain_impact.fmu.versions import FMI_2, FMI_3
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.unit_text import unit_text
from chain_impact.text import html_table
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.variable import Variable

ICONS = {FMI_2: "model.png", FMI_3: "terminalsAndIcons/icon.png"}
"""Version of FMI → path of the icon in the FMU (FMI 2.0, 2.3; FMI 3.0, 2.5.1)."""
STYLE = (
    "body{font-family:sans-serif;max-width:70em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse}td,th{border:1px solid #8888;padding:.2em .6em;text-align:left}"
    "summary{cursor:pointer;font-size:1.5em;font-weight:bold;margin:.8em 0}:root{color-scheme:light dark}"
    "svg{max-width:100%;height:auto}"
)
KINDS = "Variables by kind"

INTRODUCTION = (
    "<p>A planar chain of rigid links that hits {walls}. FMI {version}, co-simulation. Quantities "
    "are in SI units. The solver finds impacts within communication steps: with constant inputs, the results "
    "do not depend on these steps.</p>",
    "<p>Torques, forces and targets are held constant over a communication step. Fixed parameters can be set "
    "until the end of initialization, tunable ones and inputs at any time. The state can be saved, restored "
    "and serialized. The tolerance that counts is the parameter solver.tolerance.</p>",
)

MOTIONS = (
    "<p>Position, velocity and acceleration of a base or wall that moves are given at communication points. "
    "In between, the base or wall follows a cubic with a continuous position and velocity. The cubic ends at "
    "the position and velocity to which the given acceleration, if uniform, leads from the given position "
    "and velocity. The speed of a belt changes at a uniform rate.</p>"
)
EVENTS = (
    "<p>With event mode and early return, a step ends at each onset of a contact. The impact takes effect in "
    "fmi3UpdateDiscreteStates; before this call, inputs and tunable parameters can be changed. Some outputs "
    "exist as arrays, too, such as point.position.</p>"
)
TERMINALS_FILE = "terminalsAndIcons/terminalsAndIcons.xml"
EDGES = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
"""The corners of the icon in FMI's coordinate system of icons, from −100 to 100 in both directions."""


def documents(prepared_scene: PreparedScene, fmi: int) -> dict[str, bytes]:
    """Return the documents by their paths in an FMU of version 2 or 3 of FMI.

    Raises:
        BuildError: when chain-impact is installed without its licence.
    """
    # imported here, because the import takes a second
    from chain_impact.pictures.chain_at_start import icon

    license_text = distribution("chain-impact").read_text("licenses/LICENSE")
    if license_text is None:
        raise BuildError("chain-impact is installed without its license: install the package again")
    return {
        "documentation/index.html": documentation_page(prepared_scene, fmi).encode(),
        "documentation/licenses/license.txt": license_text.encode(),
        ICONS[fmi]: icon(prepared_scene.scene),
        **({TERMINALS_FILE: terminals_and_icons(prepared_scene.variables)} if fmi == FMI_3 else {}),
    }


# --- the page --------------------------------------------------------------------------------------------


def documentation_page(prepared_scene: PreparedScene, fmi: int) -> str:
    """Return the documentation of an FMU as a page of HTML."""
    from chain_impact.pictures.chain_at_start import SIGNS, drawing

    scene, variables = prepared_scene.scene, prepared_scene.variables

    def variables_with(causality: str) -> list[Variable]:
        return [variable for variable in variables if variable.causality == causality]

    settable = [
        (v.name, prepared_scene.start_text(v), unit_text(v.unit), v.variability, v.allowed, v.description)
        for v in variables_with("parameter")
    ]
    inputs = [(v.name, unit_text(v.unit), v.description) for v in variables_with("input")]
    outputs = [(v.name, unit_text(v.unit), v.variability, v.description) for v in variables_with("output")]
    choices = [
        (v.name, str(number), item.name, item.description)
        for v in variables
        for number, item in enumerate(v.items, 1)
    ]
    walls_text = "walls with dry friction" if scene.has_contact_friction else "frictionless walls"
    codes = [(str(n), text) for n, text in STATUS_TEXT.items()]
    parts = [
        f"<h1>{escape(scene.name)}</h1><p>{escape(scene.description)}</p>",
        authorship(scene),
        *(paragraph.format(version=f"{fmi}.0", walls=walls_text) for paragraph in INTRODUCTION),
        *([MOTIONS] if scene.inputs.base_motion or scene.moving_walls else []),
        *([EVENTS] if fmi == FMI_3 else []),
        f"<h2>Points, angles and signs</h2>{drawing(scene)}<p>{SIGNS}</p>",
        f"<h2>{KINDS}</h2>{html_table(('name', 'how many', 'what', 'unit', 'meaning'), kinds(variables))}",
        folded_table("Parameters", ("name", "start", "unit", "variability", "allowed", "meaning"), settable),
        folded_table("Inputs", ("name", "unit", "meaning"), inputs),
        folded_table("Outputs", ("name", "unit", "variability", "meaning"), outputs),
        folded_table("Choices", ("parameter", "number", "name", "meaning"), choices),
        folded_table("Status of the solver", ("code", "meaning"), codes),
        '<p><a href="licenses/license.txt">License of the solver</a></p>',
    ]
    head_text = f"<meta charset='utf-8'><title>{escape(scene.name)}</title><style>{STYLE}</style>"
    return (
        f"<!DOCTYPE html>\n<html lang='en'><head>{head_text}</head><body>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def authorship(scene: Scene) -> str:
    """Return a paragraph with the scene's author, version, copyright and license; "" if none is given."""
    keys = ("author", "version", "copyright", "license")
    facts = [f"{key.capitalize()}: {escape(text)}" for key in keys if (text := getattr(scene, key))]
    return f"<p>{'; '.join(facts)}</p>" if facts else ""


def kinds(variables: Sequence[Variable]) -> list[Sequence[str]]:
    """Return the rows of a table with the kinds of variables, ordered by the first variable of each kind."""
    variables_of_kind: dict[str, list[Variable]] = {}
    for variable in variables:
        variables_of_kind.setdefault(variable.kind.pattern, []).append(variable)
    return [
        (
            kind,
            str(len(variables_of_kind_listed)),
            variables_of_kind_listed[0].causality,
            unit_text(variables_of_kind_listed[0].unit),
            variables_of_kind_listed[0].kind_description,
        )
        for kind, variables_of_kind_listed in variables_of_kind.items()
    ]


def folded_table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return the HTML of a table that is folded, so that only the title is seen; "" without rows."""
    return f"<details><summary>{title}</summary>{html_table(head, rows)}</details>" if rows else ""


# --- the terminals ---------------------------------------------------------------------------------------


def terminals_and_icons(variables: Iterable[Variable]) -> bytes:
    """Return ``terminalsAndIcons.xml``, with the terminals and the frame of the icon.

    Each joint, each point, the base, the slider, the tip and each wall has a terminal with the inputs and
    outputs that it owns; an owner without these has no terminal. The terminals of walls are inside a terminal
    ``wall``, so that the path of a terminal is the first part of its variables' names. All members are
    signals. The matching rule of each terminal is "bus": an importer that connects two terminals connects the
    members with equal names. Without any terminal, the list of terminals is missing.
    """
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    looks = SubElement(root, "GraphicalRepresentation")
    SubElement(looks, "CoordinateSystem", EDGES, suggestedScalingFactorTo_mm="0.1")
    SubElement(looks, "Icon", EDGES)
    terminals = Element("Terminals")
    elements: dict[str, Element] = {}

    def terminal(path: str) -> Element:
        if path not in elements:
            parent_path, _, name = path.rpartition(".")
            parent = terminal(parent_path) if parent_path else terminals
            elements[path] = SubElement(parent, "Terminal", name=name, matchingRule="bus")
        return elements[path]

    for variable in variables:
        if variable.terminal:
            SubElement(
                terminal(variable.terminal),
                "TerminalMemberVariable",
                variableName=variable.name,
                memberName=variable.name.removeprefix(f"{variable.terminal}."),
                variableKind="signal",
            )
    if elements:
        root.append(terminals)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root)

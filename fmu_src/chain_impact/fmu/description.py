"""What the model descriptions of FMI 2.0 and 3.0 have in common."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from chain_impact.scene.angles import DEGREES
from chain_impact.scene.names import Place
from chain_impact.scene.scene import Scene
from chain_impact.scene.tables import Stops
from chain_impact.variables.model import Model
from chain_impact.variables.units import in_order, unit_of
from chain_impact.variables.variable import OBSERVED, Variable

RATES = {
    "point_velocity": "point_position",
    "point_acceleration": "point_velocity",
    "angular_velocity": "angle",
    "angular_acceleration": "angular_velocity",
    "joint_angular_velocity": "joint_angle",
}
"""Fields of the output record, and those that they are the derivatives of."""

OF_A_FIELD = 3  # steps of a place: the part of the record, the field and an index
DATE = "1980-01-01T00:00:00Z"  # the earliest that a zip can hold: equal scenes make equal FMUs
LOG_CATEGORIES = {
    "logStatusWarning": "Warnings",
    "logStatusDiscard": "Steps that were not taken",
    "logStatusError": "Errors",
    "logStatusFatal": "Errors after which the instance cannot go on",
    "logAll": "All messages",
}


def about(scene: Scene, tool: str) -> dict[str, str]:
    """The attributes of the root, but for the GUID and FMI's version. ``tool`` is what has made the FMU.

    Whose the model is only its scene can say.
    """
    said = {name: getattr(scene, name) for name in ("author", "version", "copyright", "license")}
    return {
        "modelName": scene.name,
        "description": scene.description,
        **{name: text for name, text in said.items() if text},
        "generationTool": tool,
        "generationDateAndTime": DATE,
        "variableNamingConvention": "structured",
    }


def add_units(root: Element, variables: Sequence[Variable]) -> None:
    """Add the definitions of the units that are used."""
    used, units = {variable.unit for variable in variables}, SubElement(root, "UnitDefinitions")
    for name in in_order(used):
        powers, definition = unit_of(name).powers, SubElement(units, "Unit", name=name)
        if powers is not None:
            SubElement(definition, "BaseUnit", {base: str(power) for base, power in powers.items()})
        if name in DEGREES:
            SubElement(definition, "DisplayUnit", name=DEGREES[name], factor=repr(180.0 / math.pi))


def quantities(variables: Sequence[Variable]) -> dict[str, dict[str, str]]:
    """The types of reals: name → attributes."""
    used, types = {variable.unit for variable in variables}, {}
    for name in in_order(used):
        quantity = unit_of(name).quantity
        types[quantity] = {"quantity": quantity, "unit": name}
        if name in DEGREES:
            types[quantity]["displayUnit"] = DEGREES[name]
    return types


def add_items(choice: Element, variable: Variable) -> None:
    """Add the choices of an enumeration to its type."""
    for number, item in enumerate(variable.items, 1):
        SubElement(choice, "Item", name=item.name, value=str(number), description=item.description)


def add_categories_and_experiment(root: Element, scene: Scene) -> None:
    """Add the categories of messages and the default experiment."""
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(scene.simulation.stop_time),
        tolerance=repr(scene.solver.tolerance),
        stepSize=repr(scene.simulation.step_size),
    )


def attributes_of(variable: Variable, reference: int) -> dict[str, str]:
    """What a variable is."""
    attributes = {"name": variable.name, "valueReference": str(reference)}
    attributes |= {"description": variable.description, "causality": variable.causality}
    attributes["variability"] = variable.variability
    if variable.initial is not None:
        attributes["initial"] = variable.initial
    return attributes


def values_of(model: Model) -> list[dict[str, str]]:
    """What the values of each variable are: type, unit, range, start and nominal value."""
    nominal, found = nominal_values(model.scene), []
    for variable in model.variables:
        value = {}
        if variable.type == "real":
            value = {"declaredType": unit_of(variable.unit).quantity, "unit": variable.unit}
            of_stop = variable.name.startswith("joint[") and len(variable.place) == OF_A_FIELD
            key = f"stop_{variable.field}" if of_stop else variable.field
            if variable.place[0] in OBSERVED and key in nominal:
                value["nominal"] = repr(nominal[key])
        elif variable.items:
            value = {"declaredType": type_name(variable)}
        # an open limit is written as a closed one, which is all that FMI knows; the FMU keeps it open
        low = variable.above if variable.minimum is None else variable.minimum
        limits = {"min": low, "max": variable.maximum}
        value |= {name: repr(limit) for name, limit in limits.items() if limit is not None}
        if variable.causality != "output":
            value["start"] = model.start_text(variable)
        found.append(value)
    return found


def rate_of(variable: Variable) -> Place | None:
    """The place of the variable that this one is the derivative of, if any."""
    record, field, *index = variable.place
    return (record, RATES[str(field)], *index) if record == "output" and field in RATES else None


def nominal_values(scene: Scene) -> dict[str, float]:
    """Magnitudes of the outputs: field of what is observed → value, in the unit of the field.

    Those of the motion are the absolute scales of the solver (``model.size``, ``model.energy``): the longest
    link L, L in a second, and M L²/s² for the whole mass M. Those of contacts are what a collision of all the
    mass at v = L/s compresses the wall to, without damping, K δⁿ⁺¹/(n+1) = M v²/2, and its momentum M v.
    """
    links, contact = scene.chain.links, scene.contact
    size, mass = max(link.length for link in links), sum(link.mass for link in links)
    energy = mass * size * size
    depth = _depth(contact.stiffness, contact.exponent, energy)
    motion = dict.fromkeys(
        ("point_position", "point_velocity", "point_acceleration", "penetration_rate"), size
    )
    energies = dict.fromkeys(("kinetic", "potential", "elastic", "dissipated", "supplied", "total"), energy)
    force = contact.stiffness * depth**contact.exponent
    contacts = {"penetration": depth, "force": force, "impulse": mass * size}
    dry = {"force": force, "impulse": mass * size, "joint_moment": energy, "dissipated": energy}
    friction = {f"friction.{field}": value for field, value in dry.items()}
    loads = dict.fromkeys(("x", "y", "impulse_x", "impulse_y", "peak"), mass * size) | {"moment": energy}
    impacts = {"speed": size, "separation_speed": size, "peak_force": force, "max_penetration": depth}
    loaded = {f"load.{field}": value for field, value in loads.items()}
    return motion | energies | contacts | friction | loaded | impacts | _of_stops(scene.stops, energy)


def _of_stops(stops: Stops, energy: float) -> dict[str, float]:
    """The same of stops, for all the mass at the end of the longest link, at 1 rad/s."""
    if stops.stiffness is None or stops.exponent is None:
        return {}
    depth = _depth(stops.stiffness, stops.exponent, energy)
    moment = stops.stiffness * depth**stops.exponent
    return {"stop_penetration": depth, "stop_force": moment, "stop_impulse": energy}


def _depth(stiffness: float, n: float, energy: float) -> float:
    depth: float = ((n + 1.0) * energy / (2.0 * stiffness)) ** (1.0 / (n + 1.0))
    return depth


def type_name(variable: Variable) -> str:
    """ContactModel for contact.model."""
    return "".join(part.capitalize() for part in variable.name.split("."))

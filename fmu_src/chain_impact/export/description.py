"""The modelDescription.xml of a scene's FMU (FMI 2.0, section 2.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib.metadata import version
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from chain_impact.instance import new_instance
from chain_impact.scene import Scene
from chain_impact.units import UNITS
from chain_impact.variable import OBSERVED, Variable
from chain_impact.variables import fmu_variables, word_index

DEGREES = {"rad": "deg", "rad/s": "deg/s", "rad/s2": "deg/s2"}
"""Units, and those in which a tool may show them."""
RATES = {
    "point_velocity": "point_position",
    "point_acceleration": "point_velocity",
    "angular_velocity": "angle",
    "angular_acceleration": "angular_velocity",
}
"""Fields of the output record, and those that they are the derivatives of."""

DATE = "1980-01-01T00:00:00Z"  # the earliest that a zip can hold: equal scenes make equal FMUs
LOG_CATEGORIES = {
    "logStatusWarning": "Warnings",
    "logStatusDiscard": "Steps that were not taken",
    "logStatusError": "Errors",
    "logStatusFatal": "Errors after which the instance cannot go on",
    "logAll": "All messages",
}
CAPABILITIES = {
    "needsExecutionTool": "false",
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}


def model_description(scene: Scene, tool: str, **capabilities: str) -> Element:
    """The model description, with the start values of the scene's instance and without a guid.

    Value references are positions in ``fmu_variables(scene)``. ``tool`` is what has made the FMU;
    ``capabilities`` are attributes of CoSimulation in place of the usual ones.
    """
    variables = fmu_variables(scene)
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=scene.name,
        guid="",
        description=scene.description,
        author="The chain-impact developers",
        version=version("chain-impact"),
        copyright="Copyright 2026 The chain-impact developers",
        license="MIT, see documentation/licenses",
        generationTool=tool,
        generationDateAndTime=DATE,
        variableNamingConvention="structured",
    )
    SubElement(root, "CoSimulation", {"modelIdentifier": scene.name, **CAPABILITIES, **capabilities})
    _add_units_and_types(root, variables)
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
    _add_variables(root, variables, scene)
    _add_structure(root, variables)
    return root


def _add_units_and_types(root: Element, variables: Sequence[Variable]) -> None:
    used = {variable.unit for variable in variables}
    units, types = SubElement(root, "UnitDefinitions"), SubElement(root, "TypeDefinitions")
    for name, unit in UNITS.items():
        if name in used:
            definition = SubElement(units, "Unit", name=name)
            if unit.powers is not None:
                SubElement(definition, "BaseUnit", {base: str(power) for base, power in unit.powers.items()})
            simple = SubElement(types, "SimpleType", name=unit.quantity)
            real = SubElement(simple, "Real", quantity=unit.quantity, unit=name)
            if name in DEGREES:
                SubElement(definition, "DisplayUnit", name=DEGREES[name], factor=repr(180.0 / math.pi))
                real.set("displayUnit", DEGREES[name])
    for variable in variables:
        if variable.items:
            text = variable.description
            choice = SubElement(types, "SimpleType", name=_type_name(variable), description=text)
            items = SubElement(choice, "Enumeration")
            for number, item in enumerate(variable.items, 1):
                SubElement(items, "Item", name=item.name, value=str(number), description=item.description)


def _add_variables(root: Element, variables: Sequence[Variable], scene: Scene) -> None:
    instance, nominal = new_instance(scene), nominal_values(scene)
    reals, integers = instance.view(np.float64), instance.view(np.int64)
    indices = {variable.place: str(index) for index, variable in enumerate(variables, 1)}
    nodes = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        attributes = {"name": variable.name, "valueReference": str(reference)}
        attributes |= {"description": variable.description, "causality": variable.causality}
        attributes["variability"] = variable.variability
        if variable.initial is not None:
            attributes["initial"] = variable.initial
        node = SubElement(nodes, "ScalarVariable", attributes)

        value = SubElement(node, variable.type.capitalize())
        if variable.type == "real":
            value.set("declaredType", UNITS[variable.unit].quantity)
            value.set("unit", variable.unit)
            record, field, *index = variable.place
            if record in OBSERVED and field in nominal:
                value.set("nominal", repr(nominal[str(field)]))
            if record == "output" and field in RATES:
                value.set("derivative", indices[(record, RATES[str(field)], *index)])
        elif variable.items:
            value.set("declaredType", _type_name(variable))
        # an open limit is written as a closed one, which is all that FMI knows; the FMU keeps it open
        low = variable.above if variable.minimum is None else variable.minimum
        for name, limit in (("min", low), ("max", variable.maximum)):
            if limit is not None:
                value.set(name, repr(limit))
        if variable.causality != "output":
            words = reals if variable.type == "real" else integers
            # repr of a float is the shortest text that reads back as the same number
            value.set("start", repr(words[word_index(instance.dtype, variable.place)].item()))


def nominal_values(scene: Scene) -> dict[str, float]:
    """Magnitudes of the outputs: field of what is observed → value, in the unit of the field.

    Those of the motion are the absolute scales of the solver (``model.size``, ``model.energy``): the longest
    link L, L in a second, and M L²/s² for the whole mass M. Those of contacts are what a collision of all the
    mass at v = L/s compresses the wall to, without damping, K δⁿ⁺¹/(n+1) = M v²/2, and its momentum M v.
    """
    links, contact = scene.chain.links, scene.contact
    size, mass = max(link.length for link in links), sum(link.mass for link in links)
    energy = mass * size * size
    depth = ((contact.exponent + 1.0) * energy / (2.0 * contact.stiffness)) ** (
        1.0 / (contact.exponent + 1.0)
    )
    motion = dict.fromkeys(
        ("point_position", "point_velocity", "point_acceleration", "penetration_rate"), size
    )
    energies = dict.fromkeys(("kinetic", "potential", "elastic", "dissipated", "supplied", "total"), energy)
    force = contact.stiffness * depth**contact.exponent
    contacts = {"penetration": depth, "force": force, "impulse": mass * size}
    impacts = {"speed": size, "separation_speed": size, "peak_force": force, "max_penetration": depth}
    return motion | energies | contacts | impacts


def _add_structure(root: Element, variables: Sequence[Variable]) -> None:
    inputs = " ".join(str(n) for n, variable in enumerate(variables, 1) if variable.causality == "input")
    structure = SubElement(root, "ModelStructure")
    outputs, unknowns = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for number, variable in enumerate(variables, 1):
        if variable.causality == "output":
            dependencies = inputs if variable.feedthrough else ""
            SubElement(outputs, "Unknown", index=str(number), dependencies=dependencies)
            # at the start they depend on all that is known then, which is what no list means
            SubElement(unknowns, "Unknown", index=str(number))


def _type_name(variable: Variable) -> str:
    """ContactModel for contact.model."""
    return "".join(part.capitalize() for part in variable.name.split("."))

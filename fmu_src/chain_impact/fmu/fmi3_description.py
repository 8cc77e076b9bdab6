"""The modelDescription.xml of a scene's FMU for FMI 3.0 (sections 2.4 and 4.4 of the standard)."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

from chain_impact.fmu.arrays import Array, array_variables
from chain_impact.fmu.description import (
    about,
    add_categories_and_experiment,
    add_items,
    add_units,
    attributes_of,
    quantities,
    rate_of,
    type_name,
    values_of,
)
from chain_impact.scene.names import Place
from chain_impact.variables.model import Model
from chain_impact.variables.units import UNITS
from chain_impact.variables.variable import Variable

CAPABILITIES = {
    "needsExecutionTool": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canGetAndSetFMUState": "true",
    "canSerializeFMUState": "true",
    "canHandleVariableCommunicationStepSize": "true",
    "mightReturnEarlyFromDoStep": "true",
    "hasEventMode": "true",
}
TYPES = {"real": "Float64", "integer": "Int64", "enumeration": "Enumeration"}


def model_description(model: Model, tool: str) -> Element:
    """The model description, with the start values of the model's instance and without a token.

    Value references are those of FMI 2.0, then that of the time, then those of ``array_variables(model)``.
    ``tool`` is what has made the FMU.
    """
    scene, variables, arrays = model.scene, model.variables, array_variables(model)
    token = {"fmiVersion": "3.0", "instantiationToken": ""}
    root = Element("fmiModelDescription", {**token, **about(scene, tool)})
    SubElement(root, "CoSimulation", {"modelIdentifier": scene.name, **CAPABILITIES})
    add_units(root, variables)
    types = SubElement(root, "TypeDefinitions")
    for name, attributes in quantities(variables).items():
        SubElement(types, "Float64Type", {"name": name, **attributes})
    for variable in variables:
        if variable.items:
            name, text = type_name(variable), variable.description
            add_items(SubElement(types, "EnumerationType", name=name, description=text), variable)
    add_categories_and_experiment(root, scene)
    _add_variables(root, model, arrays)
    _add_structure(root, variables, arrays)
    return root


def _add_variables(root: Element, model: Model, arrays: Sequence[Array]) -> None:
    variables = model.variables
    nodes, values = SubElement(root, "ModelVariables"), values_of(model)
    references = {variable.place: reference for reference, variable in enumerate(variables)}
    first = len(variables) + 1
    of_arrays = {array.variable.place: reference for reference, array in enumerate(arrays, first)}

    def add(variable: Variable, reference: int, value: dict[str, str], places: dict[Place, int]) -> Element:
        rate = rate_of(variable)
        derivative = {"derivative": str(places[rate])} if rate else {}
        attributes = attributes_of(variable, reference) | value | derivative
        return SubElement(nodes, TYPES[variable.type], attributes)

    for reference, (variable, value) in enumerate(zip(variables, values, strict=True)):
        add(variable, reference, value, references)
    time = {"name": "time", "valueReference": str(len(variables)), "description": "time of the simulation"}
    time |= {"causality": "independent", "variability": "continuous"}
    SubElement(nodes, "Float64", time, declaredType=UNITS["s"].quantity, unit="s")
    for reference, array in enumerate(arrays, first):
        value = values[references[array.variable.place]]
        node = add(array.variable, reference, value, of_arrays)
        for size in array.shape:
            SubElement(node, "Dimension", start=str(size))


def _add_structure(root: Element, variables: Sequence[Variable], arrays: Sequence[Array]) -> None:
    inputs = " ".join(str(n) for n, variable in enumerate(variables) if variable.causality == "input")
    outputs = [(n, variable) for n, variable in enumerate(variables) if variable.causality == "output"]
    outputs += enumerate((array.variable for array in arrays), len(variables) + 1)
    structure = SubElement(root, "ModelStructure")
    for reference, variable in outputs:
        dependencies = inputs if variable.feedthrough else ""
        SubElement(structure, "Output", valueReference=str(reference), dependencies=dependencies)
    for reference, _ in outputs:
        # at the start they depend on all that is known then, which is what no list means
        SubElement(structure, "InitialUnknown", valueReference=str(reference))

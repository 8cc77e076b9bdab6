"""The modelDescription.xml of a scene's FMU for FMI 2.0 (section 2.2)."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

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
from chain_impact.variables.model import Model
from chain_impact.variables.variable import Variable

CAPABILITIES = {
    "needsExecutionTool": "false",
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
}


def model_description(model: Model, tool: str, **capabilities: str) -> Element:
    """The model description, with the start values of the model's instance and without a guid.

    Value references are positions in ``model.variables``. ``tool`` is what has made the FMU;
    ``capabilities`` are attributes of CoSimulation in place of the usual ones.
    """
    scene, variables = model.scene, model.variables
    root = Element("fmiModelDescription", {"fmiVersion": "2.0", "guid": "", **about(scene, tool)})
    SubElement(root, "CoSimulation", {"modelIdentifier": scene.name, **CAPABILITIES, **capabilities})
    add_units(root, variables)
    types = SubElement(root, "TypeDefinitions")
    for name, attributes in quantities(variables).items():
        SubElement(SubElement(types, "SimpleType", name=name), "Real", attributes)
    for variable in variables:
        if variable.items:
            text = variable.description
            choice = SubElement(types, "SimpleType", name=type_name(variable), description=text)
            add_items(SubElement(choice, "Enumeration"), variable)
    add_categories_and_experiment(root, scene)
    _add_variables(root, model)
    _add_structure(root, variables)
    return root


def _add_variables(root: Element, model: Model) -> None:
    variables = model.variables
    indices = {variable.place: str(index) for index, variable in enumerate(variables, 1)}
    nodes, values = SubElement(root, "ModelVariables"), values_of(model)
    for reference, (variable, value) in enumerate(zip(variables, values, strict=True)):
        node = SubElement(nodes, "ScalarVariable", attributes_of(variable, reference))
        rate = rate_of(variable)
        derivative = {"derivative": indices[rate]} if rate else {}
        SubElement(node, variable.type.capitalize(), value | derivative)


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

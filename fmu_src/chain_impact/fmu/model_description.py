"""The modelDescription.xml of a scene's FMU, for FMI 2.0 (section 2.2) and FMI 3.0 (sections 2.4 and 4.4)."""

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

TOKEN = {2: "guid", 3: "instantiationToken"}
"""Version of FMI → the attribute of the root that tells one FMU from another."""
CAPABILITIES = {
    2: {
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    },
    3: {
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "canHandleVariableCommunicationStepSize": "true",
        "mightReturnEarlyFromDoStep": "true",
        "hasEventMode": "true",
    },
}
TYPES = {"real": "Float64", "integer": "Int64", "enumeration": "Enumeration"}
"""Of FMI 3.0."""


def model_description(model: Model, tool: str, fmi: int, **capabilities: str) -> Element:
    """The model description, with the start values of the model's instance and an empty token.

    Value references are positions in ``model.variables``; in FMI 3.0 then come that of the time and those of
    ``array_variables(model)``. ``tool`` is what has made the FMU; ``capabilities`` are attributes of
    CoSimulation in place of the usual ones.
    """
    root = Element(
        "fmiModelDescription", {"fmiVersion": f"{fmi}.0", TOKEN[fmi]: "", **about(model.scene, tool)}
    )
    name = {"modelIdentifier": model.scene.name}
    SubElement(root, "CoSimulation", {**name, **CAPABILITIES[fmi], **capabilities})
    add_units(root, model.variables)
    add_types, add_variables = (
        (_add_types_2, _add_variables_2) if fmi == 2 else (_add_types_3, _add_variables_3)  # noqa: PLR2004
    )
    add_types(SubElement(root, "TypeDefinitions"), model.variables)
    add_categories_and_experiment(root, model.scene)
    add_variables(root, model)
    return root


def _add_types_2(types: Element, variables: Sequence[Variable]) -> None:
    for name, attributes in quantities(variables).items():
        SubElement(SubElement(types, "SimpleType", name=name), "Real", attributes)
    for variable in variables:
        if variable.items:
            text = variable.description
            choice = SubElement(types, "SimpleType", name=type_name(variable), description=text)
            add_items(SubElement(choice, "Enumeration"), variable)


def _add_variables_2(root: Element, model: Model) -> None:
    """The variables, and which outputs depend on inputs; all are known by their positions from 1."""
    variables, nodes = model.variables, SubElement(root, "ModelVariables")
    indices = {variable.place: str(index) for index, variable in enumerate(variables, 1)}
    for reference, (variable, value) in enumerate(zip(variables, values_of(model), strict=True)):
        node = SubElement(nodes, "ScalarVariable", attributes_of(variable, reference))
        rate = rate_of(variable)
        derivative = {"derivative": indices[rate]} if rate else {}
        SubElement(node, variable.type.capitalize(), value | derivative)
    structure = SubElement(root, "ModelStructure")
    outputs, unknowns = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for index, dependencies in _dependencies(list(enumerate(variables, 1))):
        SubElement(outputs, "Unknown", index=index, dependencies=dependencies)
        SubElement(unknowns, "Unknown", index=index)


def _add_types_3(types: Element, variables: Sequence[Variable]) -> None:
    for name, attributes in quantities(variables).items():
        SubElement(types, "Float64Type", {"name": name, **attributes})
    for variable in variables:
        if variable.items:
            name, text = type_name(variable), variable.description
            add_items(SubElement(types, "EnumerationType", name=name, description=text), variable)


def _add_variables_3(root: Element, model: Model) -> None:
    """The variables, the time and the arrays, and which outputs depend on inputs."""
    variables, arrays, values = model.variables, array_variables(model), values_of(model)
    nodes, first = SubElement(root, "ModelVariables"), len(variables) + 1
    references = {variable.place: reference for reference, variable in enumerate(variables)}
    of_arrays = {array.variable.place: reference for reference, array in enumerate(arrays, first)}

    def add(variable: Variable, reference: int, value: dict[str, str], places: dict[Place, int]) -> Element:
        rate = rate_of(variable)
        derivative = {"derivative": str(places[rate])} if rate else {}
        attributes = attributes_of(variable, reference) | value | derivative
        return SubElement(nodes, TYPES[variable.type], attributes)

    for reference, (variable, value) in enumerate(zip(variables, values, strict=True)):
        add(variable, reference, value, references)
    time = {"name": "time", "valueReference": str(first - 1), "description": "time of the simulation"}
    time |= {"causality": "independent", "variability": "continuous"}
    SubElement(nodes, "Float64", time, declaredType=UNITS["s"].quantity, unit="s")
    for reference, array in enumerate(arrays, first):
        value = values[references[array.variable.place]]
        node = add(array.variable, reference, value, of_arrays)
        for size in array.shape:
            SubElement(node, "Dimension", start=str(size))
    _add_structure_3(SubElement(root, "ModelStructure"), variables, arrays)


def _add_structure_3(structure: Element, variables: Sequence[Variable], arrays: Sequence[Array]) -> None:
    of_arrays = enumerate((array.variable for array in arrays), len(variables) + 1)
    found = _dependencies([*enumerate(variables), *of_arrays])
    for reference, dependencies in found:
        SubElement(structure, "Output", valueReference=reference, dependencies=dependencies)
    for reference, _ in found:
        SubElement(structure, "InitialUnknown", valueReference=reference)


def _dependencies(numbered: Sequence[tuple[int, Variable]]) -> list[tuple[str, str]]:
    """The number of each output, and those of the inputs that act on it at once.

    At the start an output depends on all that is known then, which is what no list means.
    """
    inputs = " ".join(str(number) for number, variable in numbered if variable.causality == "input")
    return [
        (str(number), inputs if variable.feedthrough else "")
        for number, variable in numbered
        if variable.causality == "output"
    ]

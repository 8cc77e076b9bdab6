"""The file modelDescription.xml of a scene's FMU: FMI 2.0, section 2.2; FMI 3.0, sections 2.4 and 4.4."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

from chain_impact.fmu.versions import FMI_2, FMI_3
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.angles import DEGREES
from chain_impact.scene.texts.names import DataPath
from chain_impact.variables.nominal_values import nominal_values
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.units import UNITS, sorted_units, unit_of
from chain_impact.variables.variable import Variable

# Version of FMI → the attribute of the root element that tells one FMU from another.
TOKEN = {FMI_2: "guid", FMI_3: "instantiationToken"}
CAPABILITIES = {
    FMI_2: {
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    },
    FMI_3: {
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "canHandleVariableCommunicationStepSize": "true",
        "mightReturnEarlyFromDoStep": "true",
        "hasEventMode": "true",
    },
}
# Type of a variable in this package → type in FMI 3.0.
TYPES = {"real": "Float64", "integer": "Int64", "enumeration": "Enumeration"}
# the earliest date that a zip can store; every FMU gets this date, so that equal scenes give equal FMUs
DATE = "1980-01-01T00:00:00Z"
LOG_CATEGORIES = {
    "logStatusWarning": "Warnings",
    "logStatusDiscard": "Steps that were not taken",
    "logStatusError": "Errors",
    "logStatusFatal": "Errors after which the instance cannot go on",
    "logAll": "All messages",
}


def model_description(prepared_scene: PreparedScene, tool: str, fmi: int, **capabilities: str) -> Element:
    """Return the model description, with the start values of a new instance, and an empty GUID.

    The value reference of a variable is its position in ``prepared_scene.variables``. In FMI 3.0, the
    references of the time and of ``array_variables(prepared_scene)`` follow.

    Args:
        prepared_scene: the scene.
        tool: name and version of the program that makes the FMU.
        fmi: the version of FMI.
        capabilities: attributes of the element CoSimulation that replace or add to CAPABILITIES.
    """
    root = Element(
        "fmiModelDescription",
        {"fmiVersion": f"{fmi}.0", TOKEN[fmi]: "", **root_attributes(prepared_scene.scene, tool)},
    )
    name = {"modelIdentifier": prepared_scene.scene.name}
    SubElement(root, "CoSimulation", {**name, **CAPABILITIES[fmi], **capabilities})
    add_units(root, prepared_scene.variables)
    _add_types(root, prepared_scene.variables, fmi)
    add_categories_and_experiment(root, prepared_scene.scene)
    add_variables = _add_variables_2 if fmi == FMI_2 else _add_variables_3
    add_variables(root, prepared_scene)
    return root


def _add_types(root: Element, variables: Sequence[Variable], fmi: int) -> None:
    """Add the declared types of real numbers (``declared_types``) and of enumerations.

    FMI 2.0 encloses each type in a SimpleType.
    """
    types = SubElement(root, "TypeDefinitions")
    for name, attributes in declared_types(variables).items():
        if fmi == FMI_2:
            SubElement(SubElement(types, "SimpleType", name=name), "Real", attributes)
        else:
            SubElement(types, "Float64Type", {"name": name, **attributes})
    for variable in variables:
        if variable.items:
            about_it = {"name": type_name(variable), "description": variable.description}
            choice = SubElement(types, "SimpleType" if fmi == FMI_2 else "EnumerationType", about_it)
            choice = SubElement(choice, "Enumeration") if fmi == FMI_2 else choice
            for number, item in enumerate(variable.items, 1):
                SubElement(choice, "Item", name=item.name, value=str(number), description=item.description)


def _add_variables_2(root: Element, prepared_scene: PreparedScene) -> None:
    """Add the variables of FMI 2.0, and the structure: outputs with dependencies.

    FMI 2.0 refers to variables by index, which counts from 1.
    """
    variables, nodes = prepared_scene.variables, SubElement(root, "ModelVariables")
    indices = {variable.record_path: str(index) for index, variable in enumerate(variables, 1)}
    for reference, (variable, value) in enumerate(
        zip(variables, value_attributes(prepared_scene), strict=True)
    ):
        node = SubElement(nodes, "ScalarVariable", attributes_of(variable, reference))
        rate = rate_of(variable)
        derivative = {"derivative": indices[rate]} if rate in indices else {}
        SubElement(node, variable.type.capitalize(), value | derivative)
    structure = SubElement(root, "ModelStructure")
    outputs, unknowns = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for index, dependencies in _dependencies(list(enumerate(variables, 1))):
        SubElement(outputs, "Unknown", index=index, dependencies=dependencies)
        SubElement(unknowns, "Unknown", index=index)


def _add_variables_3(root: Element, prepared_scene: PreparedScene) -> None:
    """Add the variables of FMI 3.0, the time, the arrays, and the structure: outputs with dependencies."""
    variables, arrays, values = (
        prepared_scene.variables,
        array_variables(prepared_scene),
        value_attributes(prepared_scene),
    )
    nodes, first = SubElement(root, "ModelVariables"), len(variables) + 1
    references = {variable.record_path: reference for reference, variable in enumerate(variables)}
    of_arrays = {array.variable.record_path: reference for reference, array in enumerate(arrays, first)}

    def add(
        variable: Variable, reference: int, value: dict[str, str], known_references: dict[DataPath, int]
    ) -> Element:
        rate = rate_of(variable)
        derivative = {"derivative": str(known_references[rate])} if rate in known_references else {}
        attributes = attributes_of(variable, reference) | value | derivative
        return SubElement(nodes, TYPES[variable.type], attributes)

    for reference, (variable, value) in enumerate(zip(variables, values, strict=True)):
        add(variable, reference, value, references)
    time = {"name": "time", "valueReference": str(first - 1), "description": "time of the simulation"}
    time |= {"causality": "independent", "variability": "continuous"}
    SubElement(nodes, "Float64", time, declaredType=UNITS["s"].quantity, unit="s")
    for reference, array in enumerate(arrays, first):
        value = values[references[array.variable.record_path]]
        node = add(array.variable, reference, value, of_arrays)
        for size in array.shape:
            SubElement(node, "Dimension", start=str(size))
    _add_structure_3(SubElement(root, "ModelStructure"), variables, arrays)


def _add_structure_3(structure: Element, variables: Sequence[Variable], arrays: Sequence[Array]) -> None:
    of_arrays = enumerate((array.variable for array in arrays), len(variables) + 1)
    of_unknowns = _dependencies([*enumerate(variables), *of_arrays])
    for reference, dependencies in of_unknowns:
        SubElement(structure, "Output", valueReference=reference, dependencies=dependencies)
    for reference, _ in of_unknowns:
        SubElement(structure, "InitialUnknown", valueReference=reference)


def _dependencies(numbered_outputs: Sequence[tuple[int, Variable]]) -> list[tuple[str, str]]:
    """Return for each output a pair of texts: its number; the numbers of the inputs that it depends on.

    The numbers of inputs have spaces between them; only direct dependencies count. The number of a variable
    is its index in FMI 2.0, and its value reference in FMI 3.0. The dependencies hold after the start. For
    the start none are given: FMI then assumes that an output may depend on all known values.
    """
    inputs_text = " ".join(
        str(number) for number, variable in numbered_outputs if variable.causality == "input"
    )
    return [
        (str(number), inputs_text if variable.feedthrough else "")
        for number, variable in numbered_outputs
        if variable.causality == "output"
    ]


# --- parts that FMI 2.0 and FMI 3.0 have in common -------------------------------------------------------


def root_attributes(scene: Scene, tool: str) -> dict[str, str]:
    """Return the attributes of the root element, except the GUID and the version of FMI.

    ``tool`` is the program that makes the FMU. Author, version, copyright and license are those of the scene.
    """
    given_attributes = {name: getattr(scene, name) for name in ("author", "version", "copyright", "license")}
    return {
        "modelName": scene.name,
        "description": scene.description,
        **{name: text for name, text in given_attributes.items() if text},
        "generationTool": tool,
        "generationDateAndTime": DATE,
        "variableNamingConvention": "structured",
    }


def add_units(root: Element, variables: Sequence[Variable]) -> None:
    """Add the definition of each unit that a variable has."""
    used_units, units = {variable.unit for variable in variables}, SubElement(root, "UnitDefinitions")
    for name in sorted_units(used_units):
        powers, definition = unit_of(name).powers, SubElement(units, "Unit", name=name)
        if powers is not None:
            SubElement(definition, "BaseUnit", {base: str(power) for base, power in powers.items()})
        if name in DEGREES:
            SubElement(definition, "DisplayUnit", name=DEGREES[name], factor=repr(180.0 / math.pi))


def declared_types(variables: Sequence[Variable]) -> dict[str, dict[str, str]]:
    """Return the declared types of real numbers, one for each unit: name of the quantity → attributes."""
    used_units, types = {variable.unit for variable in variables}, {}
    for name in sorted_units(used_units):
        quantity = unit_of(name).quantity
        types[quantity] = {"quantity": quantity, "unit": name}
        if name in DEGREES:
            types[quantity]["displayUnit"] = DEGREES[name]
    return types


def add_categories_and_experiment(root: Element, scene: Scene) -> None:
    """Add the categories of log messages, and the default experiment."""
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
    """Return a variable's name, reference, description, causality, variability and, if any, initial."""
    attributes = {"name": variable.name, "valueReference": str(reference)}
    attributes |= {"description": variable.description, "causality": variable.causality}
    attributes["variability"] = variable.variability
    if variable.initial is not None:
        attributes["initial"] = variable.initial
    return attributes


def value_attributes(prepared_scene: PreparedScene) -> list[dict[str, str]]:
    """Return for each variable the attributes of its value: type, unit, limits, start and nominal value.

    Outputs have no start.
    """
    nominal, values = nominal_values(prepared_scene.scene), []
    for variable in prepared_scene.variables:
        value = {}
        if variable.type == "real":
            value = {"declaredType": unit_of(variable.unit).quantity, "unit": variable.unit}
            if variable.kind.nominal:
                value["nominal"] = repr(nominal[variable.kind.nominal])
        elif variable.items:
            value = {"declaredType": type_name(variable)}
        # FMI knows only limits that are allowed values. A limit that is not allowed itself is written all the
        # same, and the FMU refuses a value equal to this limit.
        low = variable.exclusive_minimum if variable.minimum is None else variable.minimum
        limits = {"min": low, "max": variable.maximum}
        value |= {name: repr(limit) for name, limit in limits.items() if limit is not None}
        if variable.causality != "output":
            value["start"] = prepared_scene.start_text(variable)
        values.append(value)
    return values


def rate_of(variable: Variable) -> DataPath | None:
    """Return the record path of the variable whose derivative ``variable`` is.

    The result is None if ``variable`` is not the derivative of another variable.
    """
    record, field, *index = variable.record_path
    if field == variable.kind.rate_of == "signal":
        return (*variable.record_path[:-1], int(index[-1]) - 1)
    return (record, variable.kind.rate_of, *index) if variable.kind.rate_of else None


def type_name(variable: Variable) -> str:
    """Return the name of an enumeration's declared type, such as ContactModel for contact.model."""
    return "".join(part.capitalize() for part in variable.name.split("."))


# --- the arrays, which FMI 3.0 has beside the scalars of FMI 2.0 -----------------------------------------


class Array(NamedTuple):
    """An array of FMI 3.0, whose elements are also scalar variables.

    Attributes:
        variable: the array in the form of a variable, with the record path of its first element.
        shape: the sizes of the dimensions; in the record, the elements follow each other in such an order
            that the last index changes fastest.
    """

    variable: Variable
    shape: tuple[int, ...]

    @property
    def length(self) -> int:
        """The number of elements of the array."""
        return math.prod(self.shape)


def array_variables(prepared_scene: PreparedScene) -> list[Array]:
    """Return the arrays of a scene's outputs, in the order of their value references."""
    groups: dict[str, list[Variable]] = {}
    for variable in prepared_scene.outputs:
        if variable.kind.array:
            groups.setdefault(variable.kind.array, []).append(variable)
    return [_array(name, elements) for name, elements in groups.items()]


def _array(name: str, elements: Sequence[Variable]) -> Array:
    indices = [variable.index for variable in elements]
    shape = tuple(1 + max(index[axis] for index in indices) for axis in range(len(indices[0])))
    text = f"{elements[0].name} to {elements[-1].name}" if len(elements) > 1 else elements[0].name
    return Array(replace(elements[0], name=name, description=f"array of {text}", base_at_rest=False), shape)

"""The variables of a scene's FMU: of each kind, one for each owner that meets the conditions of the kind."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SOLVER_METHODS
from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.scene.derived import rule_at
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import DataPath, is_like, sensitivity_name
from chain_impact.user_laws.law_file import read_law
from chain_impact.variables.description_texts import owner_texts, scene_texts
from chain_impact.variables.kind import Block, VariableKind, owner_path
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.owners import Owner
from chain_impact.variables.parameters import LAWS, METHODS, PARAMETERS
from chain_impact.variables.structure import Structure, structure_of
from chain_impact.variables.units import unit_of_derivative
from chain_impact.variables.variable import Item, Variable

KEPT_STRUCTURES = 64  # largest number of structures of scenes whose lists of outputs are cached
TANGENTS = "tangent_instances"
"""The field of a record's type with the tangent instances, records of dual numbers that come after an
instance in memory (filling.py)."""
_METHODS = tuple(
    Item(name, "as each phase needs" if name == "auto" else f"{name} steps only") for name in SOLVER_METHODS
)


def parameters_of(scene: Scene, structure: Structure) -> Iterator[Variable]:
    """Yield the parameters of the FMU, in the order of their value references.

    A parameter is left out if the scene has no value for it or, for a kind with ``only_if_in_file``, if the
    scene derives its value.
    """
    derived, choices = frozenset(scene.derived_paths), choices_of(scene)
    for kind, owner, texts in _owned_kinds(PARAMETERS, structure):
        path = owner_path(kind.scene_path or (), owner.values)
        value = value_at_path(scene, path)
        if value is not None and not (kind.only_if_in_file and path in derived):
            rule = (
                rule_at(kind.derived, path, scene.chain.links) if kind.derived and path in derived else None
            )
            given_numbers = (
                kind.given_path
                if not kind.stores_given_if or owner.conditions[kind.stores_given_if]
                else None
            )
            yield Variable.from_kind(
                kind,
                owner,
                texts,
                variability="tunable" if kind.tunable and owner.conditions[kind.tunable] else "fixed",
                scene_path=path,
                given_path=given_numbers and owner_path(given_numbers, owner.values),
                rule=rule,
                items=choices.get(kind.choices, ()),
            )


def undriven_inputs(structure: Structure) -> Iterator[Variable]:
    """Return the inputs that scenes with this structure ask for, without those that signals determine."""
    signal_names = structure.signal_quantities
    return (variable for variable in requested_inputs_of(structure) if variable.name not in signal_names)


def requested_inputs_of(structure: Structure) -> Iterator[Variable]:
    """Return the inputs that scenes with this structure ask for, also those that signals determine."""
    return (
        Variable.from_kind(*arguments, variability="continuous")
        for arguments in _owned_kinds(INPUTS, structure)
    )


def outputs_of_scene(scene: Scene) -> dict[str, Variable]:
    """Return name → output for all outputs that the scene asks for, without derivatives."""
    return outputs_of(structure_of(scene))


@lru_cache(KEPT_STRUCTURES)
def outputs_of(structure: Structure) -> dict[str, Variable]:
    """Return name → output for all outputs of scenes with this structure, without derivatives.

    The results for the KEPT_STRUCTURES structures used last are cached, because to make one takes as long as
    a short simulation. All callers share such a dict, so nothing may change it.
    """
    variables = (Variable.from_kind(*arguments) for arguments in _owned_kinds(OUTPUTS, structure))
    return {variable.name: variable for variable in (*_signal_outputs(structure), *variables)}


def _signal_outputs(structure: Structure) -> Iterator[Variable]:
    """Yield outputs with the names of inputs, for the inputs that signals determine.

    Such an input is not an input of the FMU; the output shows its value.
    """
    rows = structure.signal_quantities
    for kind, owner, texts in _owned_kinds(INPUTS, structure) if rows else ():
        signal_row = rows.get(kind.name.format_map(texts))
        if signal_row is not None:
            row, order = signal_row
            rate_of = "signal" if order > 0 and structure.signals[row].outputs[order - 1] else ""
            output = replace(
                kind, causality="output", record_path=("output", "signal", *signal_row), rate_of=rate_of
            )
            yield Variable.from_kind(output, owner, texts)


def derivatives_of(outputs: Sequence[Variable], variables: Sequence[Variable]) -> Iterator[Variable]:
    """Yield the derivatives of all ``outputs`` with respect to the first of ``variables``, then to the next.

    ``variables`` are parameters and inputs; the one with index k has direction k of the tangent instances.
    """
    for number, parameter in enumerate(variables):
        tangent, direction = divmod(number, DIRECTIONS)
        kinds: dict[str, VariableKind] = {}
        for output in outputs:
            if output.kind.name not in kinds:
                kinds[output.kind.name] = output.kind.derivative(parameter.kind)
            yield Variable(
                kind=kinds[output.kind.name],
                name=sensitivity_name(output.name, parameter.name),
                variability="continuous",
                unit=unit_of_derivative(output.unit, parameter.unit),
                description=f"derivative of {output.name} with respect to {parameter.name}",
                record_path=(TANGENTS, tangent, *output.record_path, "slope", direction),
                base_at_rest=output.base_at_rest,
            )


def value_at_path(scene: Any, path: DataPath) -> Any:
    """Return the value at a path of a scene, or of a part of a scene; None if this value is not given.

    All tables and all entries of lists on the path must exist.
    """
    for step in path:
        if isinstance(step, int):
            scene = scene[step]
        else:
            scene = scene[step] if isinstance(scene, Mapping) else getattr(scene, step)
    return scene


def absent_hint(name: str) -> str | None:
    """Return a hint how a scene gets the parameter ``name``, if only some scenes have this parameter.

    The result is None for any other name.
    """
    kinds = (kind for block in PARAMETERS for kind in block.kinds if kind.hint)
    return next((kind.hint for kind in kinds if is_like(name, kind.name)), None)


def _owned_kinds(
    blocks: Iterable[Block], structure: Structure
) -> Iterator[tuple[VariableKind, Owner, dict[str, Any]]]:
    """Yield (kind, owner, texts) for each kind and each owner that meets the conditions of the kind.

    ``texts`` is word in braces → the text or number of this scene and owner that replaces the word.
    """
    scene = scene_texts(structure)
    for owner_kind, kinds in blocks:
        for owner in structure.owners(owner_kind):
            texts = {**scene, **owner.values, **owner_texts(owner_kind, structure, owner.values)}
            for kind in kinds:
                if all(owner.conditions[condition] for condition in kind.when):
                    yield kind, owner, texts


def choices_of(scene: Scene) -> dict[str, tuple[Item, ...]]:
    """Return name of an enumeration (LAWS, METHODS) → its choices: contact laws, and methods of the solver.

    If the scene has a file ``contact.law_file``, the law of this file comes last.
    """
    laws = [Item(law.id, law.source) for law in CONTACT_LAWS.values()]
    if scene.contact.law_file:
        law = read_law(Path(scene.contact.law_file))
        laws.append(Item(law.id, law.summary))
    return {LAWS: tuple(laws), METHODS: _METHODS}

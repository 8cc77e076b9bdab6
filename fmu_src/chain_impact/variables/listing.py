"""The variables of a scene's FMU: each kind of variables gives one for each of its owners in the scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.laws.law_file import read_law
from chain_impact.scene.derived import rule_at
from chain_impact.scene.names import DataPath, is_like, sensitivity_name
from chain_impact.scene.scene import Scene
from chain_impact.variables.kind import Block, Kind, filled
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.owners import Owner
from chain_impact.variables.parameters import LAWS, METHODS, PARAMETERS
from chain_impact.variables.structure import Structure, structure_of
from chain_impact.variables.units import quotient
from chain_impact.variables.variable import Item, Variable
from chain_impact.variables.words import owner_words, scene_words

KEPT_STRUCTURES = 64  # largest number of structures of scenes whose lists of outputs are cached
BEHIND = "behind"
"""The name of the tangent instances among the fields of a record's type: these are records of dual numbers,
which follow an instance in memory (filling.py)."""
_METHODS = tuple(
    Item(name, "as each phase needs" if name == "auto" else f"{name} steps only") for name in SOLVER_METHODS
)


def parameters(scene: Scene, structure: Structure) -> Iterator[Variable]:
    """Yield the parameters of the FMU: the variables whose value the scene has.

    A parameter of a kind with ``if_given`` is left out if the scene derives its value.
    """
    derived, choices = frozenset(scene.derived_paths), choices_of(scene)
    for kind, owner, words in _owned_kinds(PARAMETERS, structure):
        path = filled(kind.path or (), owner.values)
        value = value_at(scene, path)
        if value is not None and not (kind.if_given and path in derived):
            rule = (
                rule_at(kind.derived, path, scene.chain.links) if kind.derived and path in derived else None
            )
            given = kind.given if not kind.given_if or owner.conditions[kind.given_if] else None
            yield Variable.of(
                kind,
                owner,
                words,
                variability="tunable" if kind.tunable and owner.conditions[kind.tunable] else "fixed",
                scene_path=path,
                given_path=given and filled(given, owner.values),
                rule=rule,
                items=choices.get(kind.choices, ()),
            )


def inputs(structure: Structure) -> Iterator[Variable]:
    """Return the inputs that the scenes of a structure ask for, without quantities that signals determine."""
    driven = structure.driven_quantities
    return (variable for variable in inputs_asked(structure) if variable.name not in driven)


def inputs_asked(structure: Structure) -> Iterator[Variable]:
    """Return the inputs that the scenes of a structure ask for, also quantities that signals determine."""
    return (
        Variable.of(*arguments, variability="continuous") for arguments in _owned_kinds(INPUTS, structure)
    )


def all_outputs(scene: Scene) -> dict[str, Variable]:
    """Return name → output for all outputs that the scene asks for, without derivatives."""
    return outputs_of(structure_of(scene))


@lru_cache(KEPT_STRUCTURES)
def outputs_of(structure: Structure) -> dict[str, Variable]:
    """Return name → output for all outputs of a scene with this structure.

    Outputs that are derivatives are left out.

    The outputs of the KEPT_STRUCTURES structures used last are cached, because making them takes as long as a
    short simulation.
    """
    variables = (Variable.of(*arguments) for arguments in _owned_kinds(OUTPUTS, structure))
    return {variable.name: variable for variable in (*_driven(structure), *variables)}


def _driven(structure: Structure) -> Iterator[Variable]:
    """Yield the quantities that signals determine, as outputs with the names of inputs.

    Such a quantity is no input of the FMU; the output with its name shows its value.
    """
    rows = structure.driven_quantities
    for kind, owner, words in _owned_kinds(INPUTS, structure) if rows else ():
        driven = rows.get(kind.name.format_map(words))
        if driven is not None:
            row, order = driven
            rate_of = "signal" if order > 0 and structure.signals[row].outputs[order - 1] else ""
            output = replace(
                kind, causality="output", record_path=("output", "signal", *driven), rate_of=rate_of
            )
            yield Variable.of(output, owner, words)


def derivatives(outputs: Sequence[Variable], varied: Sequence[Variable]) -> Iterator[Variable]:
    """Yield the derivatives of all ``outputs`` with respect to each parameter or input in ``varied``."""
    for number, parameter in enumerate(varied):
        tangent, direction = divmod(number, DIRECTIONS)
        kinds: dict[str, Kind] = {}
        for of in outputs:
            if of.kind.name not in kinds:
                kinds[of.kind.name] = of.kind.derivative(parameter.kind)
            yield Variable(
                kind=kinds[of.kind.name],
                name=sensitivity_name(of.name, parameter.name),
                variability="continuous",
                unit=quotient(of.unit, parameter.unit),
                description=f"derivative of {of.name} with respect to {parameter.name}",
                record_path=(BEHIND, tangent, *of.record_path, "slope", direction),
                base_at_rest=of.base_at_rest,
            )


def value_at(scene: Any, path: DataPath) -> Any:
    """Return the value at a path of a scene, or of a part of a scene.

    The result is None if the scene leaves the value out.
    """
    for step in path:
        if isinstance(step, int):
            scene = scene[step]
        else:
            scene = scene[step] if isinstance(scene, Mapping) else getattr(scene, step)
    return scene


def absent_hint(name: str) -> str | None:
    """Return a hint how to get into the FMU a parameter that only some scenes have.

    The result is None for any other name.
    """
    kinds = (kind for block in PARAMETERS for kind in block.kinds if kind.hint)
    return next((kind.hint for kind in kinds if is_like(name, kind.name)), None)


def _owned_kinds(
    blocks: Iterable[Block], structure: Structure
) -> Iterator[tuple[Kind, Owner, dict[str, Any]]]:
    """Yield (kind, owner, words) for each kind and each of its owners that meets the kind's conditions.

    ``words``: word in braces in templates → the text or number of this scene and owner that replaces it.
    """
    scene = scene_words(structure)
    for of, kinds in blocks:
        for owner in structure.owners(of):
            words = {**scene, **owner.values, **owner_words(of, structure, owner.values)}
            for kind in kinds:
                if all(owner.conditions[condition] for condition in kind.when):
                    yield kind, owner, words


def choices_of(scene: Scene) -> dict[str, tuple[Item, ...]]:
    """Return the choices of the FMU's two enumerations: contact laws and methods of the solver.

    The last contact law is the one in the file ``contact.law_file``, if the scene has one.
    """
    laws = [Item(law.id, law.source) for law in CONTACT_LAWS.values()]
    if scene.contact.law_file:
        law = read_law(Path(scene.contact.law_file))
        laws.append(Item(law.id, law.summary))
    return {LAWS: tuple(laws), METHODS: _METHODS}

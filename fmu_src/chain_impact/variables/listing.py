"""The variables of a scene's FMU: one of each kind for each element that the scene has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from chain_impact.compilation.law_file import read_law
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.scene.derived import rule_at
from chain_impact.scene.names import Place, is_like, sensitivity_name
from chain_impact.scene.scene import Scene
from chain_impact.variables.kind import Block, Kind, filled
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.parameters import LAWS, METHODS, PARAMETERS
from chain_impact.variables.shape import ELEMENTS, Element, Shape, shape_of
from chain_impact.variables.units import quotient
from chain_impact.variables.variable import Item, Variable

SHAPES = 64  # of scenes, whose outputs are kept
BEHIND = "behind"
"""The field of the instances of dual numbers behind an instance (model.py)."""
_METHODS = tuple(
    Item(name, "as each phase needs" if name == "auto" else f"{name} steps only") for name in SOLVER_METHODS
)


def parameters(scene: Scene) -> Iterator[Variable]:
    """The parameters of the scene's FMU: those that it has a value for."""
    derived, choices = frozenset(scene.derived_places), choices_of(scene)
    for kind, element, known in _each(PARAMETERS, shape_of(scene)):
        path = filled(kind.path or (), element)
        value = value_at(scene, path)
        if value is not None and value != kind.trivial:
            rule = (
                rule_at(kind.derived, path, scene.chain.links) if kind.derived and path in derived else None
            )
            given = kind.given if not kind.given_if or known[kind.given_if] else None
            yield Variable.of(
                kind,
                element,
                known,
                variability="tunable" if kind.tunable and known[kind.tunable] else "fixed",
                scene_path=path,
                given_place=given and filled(given, element),
                rule=rule,
                items=choices.get(kind.choices, ()),
            )


def inputs(scene: Scene) -> Iterator[Variable]:
    """The inputs that the scene asks for, but for those that signals drive."""
    shape = shape_of(scene)
    return (variable for variable in inputs_asked(shape) if variable.name not in shape.of_signals)


def inputs_asked(shape: Shape) -> Iterator[Variable]:
    """The inputs that a scene of a shape asks for, whether signals drive them or not."""
    return (Variable.of(*found, variability="continuous") for found in _each(INPUTS, shape))


def all_outputs(scene: Scene) -> dict[str, Variable]:
    """The outputs that the scene asks for, by their names, those of its candidates too. They are kept."""
    return outputs_of(shape_of(scene))


@lru_cache(SHAPES)
def outputs_of(shape: Shape) -> dict[str, Variable]:
    """The outputs of all scenes of a shape, made once: that takes as long as a short simulation."""
    made = (Variable.of(*found) for found in _each(OUTPUTS, shape))
    return {variable.name: variable for variable in (*_driven(shape), *made)}


def _driven(shape: Shape) -> Iterator[Variable]:
    """What signals drive, under the names of the inputs that it would be without them."""
    for kind, element, known in _each(INPUTS, shape) if shape.signals else ():
        place = shape.of_signals.get(kind.name.format_map(known))
        if place is not None:
            row, order = place
            rate_of = "signal" if order > 0 and shape.signals[row].outputs[order - 1] else ""
            output = replace(kind, causality="output", place=("output", "signal", *place), rate_of=rate_of)
            yield Variable.of(output, element, known)


def derivatives(outputs: Sequence[Variable], varied: Sequence[Variable]) -> Iterator[Variable]:
    """The derivatives of some outputs with respect to some parameters and inputs."""
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
                place=(BEHIND, tangent, *of.place, "slope", direction),
                held=of.held,
            )


def value_at(scene: Any, path: Place) -> Any:
    """The value at a path of a scene, or of a part of it; None where there is none."""
    for step in path:
        if isinstance(step, int):
            scene = scene[step]
        else:
            scene = scene[step] if isinstance(scene, Mapping) else getattr(scene, step)
    return scene


def absent_hint(name: str) -> str | None:
    """What to do about the name of a parameter that only the FMU of a scene with such a part has."""
    kinds = (kind for block in PARAMETERS for kind in block.kinds if kind.hint)
    return next((kind.hint for kind in kinds if is_like(name, kind.name)), None)


def _each(blocks: Iterable[Block], shape: Shape) -> Iterator[tuple[Kind, Element, dict[str, Any]]]:
    """Each kind that each element has, with the element and all that is known of it and of its scene."""
    scene = shape.known()
    for of, kinds in blocks:
        for element in ELEMENTS[of](shape):
            known = {**scene, **element}
            for kind in kinds:
                if all(known[condition] for condition in kind.when):
                    yield kind, element, known


def choices_of(scene: Scene) -> dict[str, tuple[Item, ...]]:
    """The lists of choices: of the laws in the order of their numbers, a user's last, and of the methods."""
    laws = [Item(law.id, law.source) for law in CONTACT_LAWS.values()]
    if scene.contact.law_file:
        own = read_law(Path(scene.contact.law_file))
        laws.append(Item(own.id, own.summary))
    return {LAWS: tuple(laws), METHODS: _METHODS}

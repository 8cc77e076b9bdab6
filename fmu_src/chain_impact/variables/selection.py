"""Finds the variables of a prepared scene that a user names, and makes the hints of errors on other names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from chain_impact.scene.asked_inputs import request_hint
from chain_impact.scene.contents import named_point_hint
from chain_impact.scene.errors import find_names, names_matching
from chain_impact.scene.keys.tables import Outputs
from chain_impact.scene.rules.key_rules import key_fields
from chain_impact.scene.scene import Scene, fixed_hint
from chain_impact.scene.texts.input_table import input_key
from chain_impact.scene.texts.names import DataPath
from chain_impact.scene.texts.parameter_hints import parameter_hint
from chain_impact.variables.output_hints import Hint, output_hint, parts_hint, series_hint
from chain_impact.variables.peaks import JOINT_FORCE, PEAKS
from chain_impact.variables.scene_variables import absent_hint, outputs_of_scene
from chain_impact.variables.variable import Variable


class SceneVariables(Protocol):
    """The properties of ``PreparedScene`` that the functions of this module need."""

    scene: Scene

    @property
    def inputs(self) -> list[Variable]: ...  # noqa: D102

    @property
    def outputs_without_derivatives(self) -> dict[str, Variable]: ...  # noqa: D102

    @property
    def parameter_paths(self) -> dict[str, DataPath]: ...  # noqa: D102

    @property
    def differentiable(self) -> dict[str, Variable]: ...  # noqa: D102

    @property
    def output_index(self) -> dict[str, int]: ...  # noqa: D102


def differentiable_named(prepared_scene: SceneVariables, names: str | Iterable[str]) -> list[Variable]:
    """Return the parameters and inputs with the names or patterns ``names``, each once, for derivatives.

    They are in the order of ``names``. In a pattern, ``*`` stands for any text.

    Raises:
        UnknownNameError: when a name is not that of a variable with respect to which there are derivatives,
            or a pattern matches none.
    """
    scene = prepared_scene.scene

    def hint(name: str) -> str | None:
        if name in prepared_scene.output_index:
            return "it is an output: derivatives of it are with respect to parameters and inputs"
        if name in prepared_scene.parameter_paths:
            return "it is a choice, or a setting of the solver, of which the motion is not a smooth function"
        if input_key(name):
            return request_hint(scene, name)
        hint = parameter_hint(name, len(scene.chain.links), scene.signals)
        return absent_hint(name) or hint or fixed_hint(scene, name)

    wanted_names = (names,) if isinstance(names, str) else tuple(names)
    if not wanted_names:
        return []
    variables = prepared_scene.differentiable
    found_names = _matching_names(
        scene.name, wanted_names, variables, "not a parameter with derivatives", hint
    )
    return [variables[name] for name in found_names]


def outputs_named(prepared_scene: SceneVariables, wanted_names: str | Iterable[str]) -> list[Variable]:
    """Return the outputs, none of them a derivative, with the names or patterns ``wanted_names``.

    They are in the order of ``wanted_names``, each once.

    Raises:
        UnknownNameError: when a name is not that of an output, or a pattern matches no output.
    """
    if not wanted_names:
        return []
    outputs, hint = prepared_scene.outputs_without_derivatives, _hint_on_outputs(prepared_scene)
    return [
        outputs[name]
        for name in _matching_names(prepared_scene.scene.name, wanted_names, outputs, "not an output", hint)
    ]


def columns_named(prepared_scene: SceneVariables, wanted_names: str | Iterable[str]) -> dict[str, int]:
    """Return the entries of ``PreparedScene.output_index`` for names or patterns, in this order.

    Raises:
        UnknownNameError: when a name is not that of a column, or a pattern matches no column.
    """
    columns, hint = prepared_scene.output_index, series_hint(_hint_on_outputs(prepared_scene))
    names = _matching_names(prepared_scene.scene.name, wanted_names, columns, "not an output", hint)
    return {name: columns[name] for name in names}


def missing_output_hint(prepared_scene: SceneVariables, name: str) -> str | None:
    """Return a hint why ``name`` matches no wanted output; None without a hint."""
    inputs, outputs = (
        [variable.name for variable in prepared_scene.inputs],
        prepared_scene.outputs_without_derivatives,
    )
    advice = "a signal in the scene, inputs={…} in Python or --inputs FILE on the command line"
    if hint := output_hint(name, inputs, prepared_scene.parameter_paths, advice):
        return hint
    if input_key(name):
        return request_hint(prepared_scene.scene, name)
    if find_names(name, outputs):
        return None
    scene = prepared_scene.scene
    if name == JOINT_FORCE and not scene.outputs.loads:
        return "it needs outputs.loads = true"
    if name in (JOINT_FORCE, *PEAKS):
        return "it is one value of a whole run: a column of each sweep, and a quantity of a ranking"
    hint = named_point_hint(scene, name, outputs) or parts_hint(name, outputs) or _hint_on_more(scene, name)
    return hint or _hint_on_joint(prepared_scene, name)


def _hint_on_joint(prepared_scene: SceneVariables, name: str) -> str | None:
    """Return the hint for the output of a joint if ``name`` is that of the link behind it; else None."""
    # forces and moments on a link are those of its joint
    of_joint = name.replace("link[", "joint[", 1)
    hint = missing_output_hint(prepared_scene, of_joint) if of_joint != name else None
    return hint and (hint if of_joint in hint else f"take {of_joint}: {hint}")


def _hint_on_outputs(prepared_scene: SceneVariables) -> Hint:
    return lambda name: missing_output_hint(prepared_scene, name)


def _hint_on_more(scene: Scene, name: str) -> str | None:
    """Return a hint if the scene would have the output ``name``, or outputs of this owner; else None.

    That is, with one of the keys of [outputs] that are false in the scene set to true.
    """
    for key in key_fields(Outputs):
        if getattr(scene.outputs, key.name) is False:
            asked_text = f"outputs.{key.name} = true"
            more_names = outputs_of_scene(scene.with_values({f"outputs.{key.name}": True}))
            if find_names(name, more_names):
                return f"it needs {asked_text}"
            if parts := parts_hint(name, more_names):
                return f"with {asked_text} {parts}"
    return None


def _matching_names(
    source: str, wanted_names: str | Iterable[str], available_names: Mapping[str, Any], fault: str, hint: Hint
) -> dict[str, None]:
    """Return a dict whose keys are the ``available_names`` that the names or patterns ``wanted_names`` match.

    The keys are in the order of ``wanted_names``. ``source``, ``fault`` and ``hint`` are for the error if a
    name or pattern matches none (``names_matching``).
    """
    names = (wanted_names,) if isinstance(wanted_names, str) else wanted_names
    return {
        match: None for name in names for match in names_matching(source, name, available_names, fault, hint)
    }

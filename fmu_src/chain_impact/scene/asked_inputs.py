"""The inputs that a scene asks for in [inputs], and a table file that drives inputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, count
from pathlib import Path
from typing import Any

from chain_impact.scene.contents import SceneContents
from chain_impact.scene.errors import SceneError
from chain_impact.scene.facts import SceneFacts
from chain_impact.scene.files.table_file import read_table, samples_of
from chain_impact.scene.texts.input_table import INPUT_KINDS, exclusive_inputs, input_key, input_request
from chain_impact.scene.texts.similar_names import nearest_name


def inputs_of(scene: SceneContents, *, are_asked: bool = True) -> Iterator[str]:
    """Yield the names of the inputs that the keys of [inputs] add to the scene, driven by signals or not.

    If ``are_asked`` is False, also yield the inputs that other keys of [inputs] than ``wall_motion`` would
    add. The inputs of the joints come first, one joint after the other; then come those of the slider, the
    tip, the base and the walls.
    """
    templates = [name for name, row in INPUT_KINDS.items() if getattr(scene.inputs, row.key) or not are_asked]
    if not templates:
        return
    facts = SceneFacts(scene)
    owners: dict[str, Sequence[dict[str, Any]]] = {
        "joint[{n}]": [{"n": n} for n, link in enumerate(facts["link_facts"], 1) if link["jointed"]],
        "slider": [{}] * facts["has_slider"],
        "tip": [{}],
        "base": [{}] * facts["pinned"],
        "wall": facts["moving_walls"],
    }
    for head, owner_parts in owners.items():
        of_head = [template for template in templates if template.startswith(f"{head}.")]
        for word in owner_parts:
            yield from (template.format(**word) for template in of_head)


def _lacking_owner(scene: SceneContents, name: str) -> str:
    """Return why the scene cannot have the input ``name``; "" if none of the following reasons applies.

    The reasons are: there is no such wall, no point can touch a wall, or a free base has no joint 1.
    """
    wall = name.split(".")[1] if input_key(name) == "wall_motion" else ""
    if wall and wall not in scene.half_planes:
        return f"there is no wall {wall}"
    if wall and not scene.may_touch:
        return "no point can touch a wall"
    if scene.chain.base == "free" and name.startswith("joint[1]."):
        return 'there is no joint 1: the base is free (chain.base = "free")'
    return ""


def request_hint(scene: SceneContents, name: str) -> str:
    """Return the end of an error on the input ``name``, which the scene lacks.

    The end tells why the scene cannot have the input, or how to add the input; else it names the input with
    the most similar name or, if no name is similar, all inputs that the scene has, or "it has none".
    """
    key, possible_inputs = input_key(name), list(inputs_of(scene))
    possible = [
        *possible_inputs,
        *(
            asked_name
            for asked_name in inputs_of(scene, are_asked=False)
            if asked_name not in possible_inputs
        ),
    ]
    if lacking := _lacking_owner(scene, name):
        return lacking
    if key == "wall_motion" or name in possible:
        return f"set {input_request(name)}"
    if key and (base := {"slider": "slider", "base": "pinned"}.get(name.partition(".")[0])):
        return f'only a chain with chain.base = "{base}" has it'
    if near_name := nearest_name(name, possible):
        return f"the nearest is {near_name}" + (
            "" if near_name in possible_inputs else f"; set {input_request(near_name)}"
        )
    return f"it has {', '.join(possible_inputs)}" if possible_inputs else "it has none"


def with_inputs(scene: Any, file: Path, interpolation: str | None = None) -> Any:
    """Return the scene with one more signal: a table file whose columns drive the inputs of the same names.

    The name of the signal is ``inputs`` or, if the scene has this, ``inputs_2`` and so on.

    Args:
        scene: the scene, which must have these inputs.
        file: CSV or Parquet, with the column ``time`` [s] and at least one column for an input.
        interpolation: ``hold``, ``linear`` or ``spline``; by default ``spline`` for a motion of the base or a
            wall, and ``hold`` for any other input.

    Raises:
        SceneError: when the table is not valid, or the scene lacks an input or already drives it.
        OSError: when the file cannot be read.
        MissingExtraError: for Parquet, when pyarrow is not installed.
    """
    _, columns = samples_of(read_table(file), scene.simulation.stop_time)
    numbered_names = (f"inputs_{k}" for k in count(2))
    name = next(
        free_name for free_name in chain(("inputs",), numbered_names) if free_name not in scene.signals
    )
    owners = {
        quantity: owner
        for owner, signal in scene.signals.items()
        for column in signal.input
        for quantity in exclusive_inputs(column)
    }
    for column in columns:
        for quantity in exclusive_inputs(column):
            if quantity in owners:
                driver_text = f"signals.{owners[quantity]} of {scene.name} drives {quantity}"
                raise SceneError(f"{file}: column {column} must be left out: {driver_text}")
        if column not in inputs_of(scene):
            raise SceneError(
                f"{file}: column {column} is not an input of {scene.name}; {request_hint(scene, column)}"
            )
    table = {"input": list(columns), "form": "table", "file": str(file.absolute())}
    table |= {"interpolation": interpolation} if interpolation else {}
    return scene.with_values({("signals", name): table})

"""The inputs that a scene asks for in [inputs], and a table file that drives inputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, count
from pathlib import Path
from typing import Any

from chain_impact.scene.contents import Contents
from chain_impact.scene.facts import SceneFacts
from chain_impact.scene.names import INPUTS_OF, input_asked, input_key
from chain_impact.scene.reading import SceneError
from chain_impact.scene.signals import driven_alone
from chain_impact.scene.similar_names import nearest
from chain_impact.scene.table_file import read_table, samples_of


def inputs_of(scene: Contents, *, asked: bool = True) -> Iterator[str]:
    """Yield the names of the inputs that the keys of [inputs] add to the scene.

    A signal may drive such an input or not. If ``asked`` is False, the names are those of all inputs that the
    keys of [inputs] could add to this scene, but not of walls that ``inputs.wall_motion`` does not name.
    """
    templates = [
        name for key, names in INPUTS_OF.items() if getattr(scene.inputs, key) or not asked for name in names
    ]
    if not templates:
        return
    facts = SceneFacts(scene)
    owners: dict[str, Sequence[dict[str, Any]]] = {
        "joint[{n}]": [{"n": n} for n, link in enumerate(facts["links"], 1) if link["jointed"]],
        "slider": [{}] * facts["slider"],
        "tip": [{}],
        "base": [{}] * facts["pinned"],
        "wall": facts["moving_walls"],
    }
    for head, words in owners.items():
        of_head = [template for template in templates if template.startswith(f"{head}.")]
        for word in words:
            yield from (template.format(**word) for template in of_head)


def _lacking_owner(scene: Contents, name: str) -> str:
    """Return why the wall or the joint of an input cannot be driven; "" if it can, or for another input."""
    wall = name.split(".")[1] if input_key(name) == "wall_motion" else ""
    if wall and wall not in scene.half_planes:
        return f"there is no wall {wall}"
    if wall and not scene.may_touch:
        return "no point can touch a wall"
    if scene.chain.base == "free" and name.startswith("joint[1]."):
        return 'there is no joint 1: the base is free (chain.base = "free")'
    return ""


def how_asked(scene: Contents, name: str) -> str:
    """Return advice for an error on an input that the scene lacks: how to add it, or which inputs exist."""
    key, there = input_key(name), list(inputs_of(scene))
    possible = [*there, *(other for other in inputs_of(scene, asked=False) if other not in there)]
    if lacking := _lacking_owner(scene, name):
        return lacking
    if key == "wall_motion" or name in possible:
        return f"{input_asked(name)} makes it"
    if key and (base := {"slider": "slider", "base": "pinned"}.get(name.partition(".")[0])):
        return f'only a chain with chain.base = "{base}" has it'
    if near := nearest(name, possible):
        return f"the nearest is {near}" + ("" if near in there else f", and {input_asked(near)} makes it")
    return f"it has {', '.join(there)}" if there else "it has none"


def with_inputs(scene: Any, file: Path, interpolation: str | None = None) -> Any:
    """Return the scene with one more signal: a table file, each column of which drives an input.

    Args:
        scene: the scene, which must have these inputs.
        file: CSV or Parquet, with the column ``time`` [s].
        interpolation: ``hold``, ``linear`` or ``spline``; by default the usual interpolation of each input.

    Raises:
        SceneError: when the table cannot drive the scene.
        OSError: when the file cannot be read.
    """
    _, columns = samples_of(read_table(file), scene.simulation.stop_time)
    numbered = (f"inputs_{k}" for k in count(2))
    name = next(free for free in chain(("inputs",), numbered) if free not in scene.signals)
    owners = {
        driven: owner
        for owner, signal in scene.signals.items()
        for column in signal.input
        for driven in driven_alone(column)
    }
    for column in columns:
        for driven in driven_alone(column):
            if driven in owners:
                by = f"signals.{owners[driven]} of {scene.name} drives {driven}"
                raise SceneError(f"{file}: column {column} must be left out: {by}")
        if column not in inputs_of(scene):
            raise SceneError(
                f"{file}: column {column} is not an input of {scene.name}; {how_asked(scene, column)}"
            )
    table = {"input": list(columns), "form": "table", "file": str(file.absolute())}
    table |= {"interpolation": interpolation} if interpolation else {}
    return scene.with_values({("signals", name): table})

"""What the page knows of all scenes: the keys of a scene file, the variables, and their words in a record.

The page has scenes of any number of links, walls and stops, as its reader edits them or opens a file. The
variables are therefore templates. They are made of the variables of one scene that has everything once, so
that names, units, ranges and meanings are those of the FMU. In a template ``{n}`` stands for a number that
is shown, ``{name}`` for the name of a wall, and ``{at}`` for an index. Where a word is in the record is a
list of seven numbers: a + bN + cC + dF + eL + fK + g·index (kernel/record/instance.py).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, is_dataclass, replace
from functools import cache
from itertools import groupby
from typing import Any, get_args, get_origin

import numpy as np

from chain_impact.compilation.affine import SAMPLES, affine
from chain_impact.kernel.chain.inertia import DERIVED
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.ode.sundman import NO_CONTACT
from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATUS_TEXT
from chain_impact.results.impacts import LOG_DTYPE
from chain_impact.results.joint_stops import OPEN
from chain_impact.scene.limits import Derived, allowed, keys, without_none
from chain_impact.scene.names import Place
from chain_impact.scene.reading import entry_type
from chain_impact.scene.scene import Scene, scene_from_dict, scene_keys
from chain_impact.variables.model import Model
from chain_impact.variables.places import layout_of
from chain_impact.variables.table import UNLESS_SET, WORD, word_index
from chain_impact.variables.variable import Item, Variable, variable_row

TIMES = ("simulation.stop_time", "simulation.step_size")
"""What can be changed beside the FMU's parameters."""
WALL = "probe"
"""The wall of the scene that has everything."""
AT = "{at}"
GROUPS = {
    "link": r"link\[2\]\..*",
    "angle": r"initial\.angle\[2\]",
    "rate": r"initial\.angular_velocity\[2\]",
    "wall": rf"wall\.{WALL}\.(x|y|angle)",
    "material": rf"wall\.{WALL}\.(stiffness|restitution|friction|static_friction)",
    "torque": r"joint\[2\]\.torque",
    "target": r"joint\[2\]\.target_.*",
    "point": r"point\[2\]\..*",
    "contact": rf"contact\[2\]\.{WALL}\..*",
    "moved": rf"wall\.{WALL}\.(belt_)?position",
    "stop": r"joint\[2\]\.stop_.*",
    "rubbing": r"joint\[2\]\.(friction_moment|sticking)",
    "joint": r"joint\[2\]\.(angle|angular_velocity)",
    "joint load": r"joint\[2\]\..*",
    "wall load": rf"wall\.{WALL}\.load.*",
    "latest": r"impact\[1\]\..*",
    "energy": r"energy\..*",
    "solver": r"solver\..*",
}
"""What there are many of, or none → the names of its variables in the scene that has everything."""
PLACES: dict[str, Place] = {
    **{name: (name,) for name in ("links", "candidates", "elements", "loads", "channels")},
    "regularized": ("step", "regularized"),
    **{key: ("model", key) for key in ("pinned", "driven", "followed", "base_moves")},
    **{key: ("model", key, AT) for key in ("joint_min", "joint_max", "joint_torque_limit")},
    **{f"candidate_{key}": ("candidate", AT, key) for key in ("point", "wall", "stop")},
    "follows": ("motion", "follows"),
    "belt": ("motion", "belt", AT),
    "moved": ("motion", "position", AT),
    "channel": ("shift", AT, "channel"),
    "kept": ("latest", "kept"),
    "impulses": ("quadrature", "wanted"),
    **{f"wall_{key}": ("walls", key, AT) for key in ("restitution", "friction", "static_friction")},
    "stop_law": ("stops", "law"),
}
"""What of a record is no parameter, and depends on what a scene has."""


def kit(scene: Scene) -> dict[str, Any]:
    """All of it, as JSON can hold it, for the contact laws of a scene."""
    full = _full(scene)
    model, base = Model(full), Model(_moving(full))
    free = Model(replace(full, inputs=replace(full.inputs, joint_targets=False)))
    return {
        "keys": _keys(Scene, full),
        "lawFile": scene.contact.law_file,
        "laws": [_law(name) for name in scene.law_names],
        "parameters": _groups(_parameter(one) for one in free.parameters),
        "inputs": _groups(_parameter(one) for one in model.inputs if one.place[0] != "motion"),
        "still": {
            "base": [one.name for one in base.inputs if one.name.startswith("base.")],
            "wall": [_general(one)[1] for one in model.inputs if one.place[0] == "motion"],
        },
        "times": [_time(key) for key in TIMES],
        "outputs": _groups(_output(one) for one in model.outputs),
        "places": {name: {"word": words(place), "real": _is_real(place)} for name, place in PLACES.items()},
        "size": _affine(lambda record: record.itemsize // WORD),
        "layout": _layout(),
        "points": [words(("output", "point_position", AT, axis)) for axis in (0, 1)],
        "constants": {"derived": DERIVED, "noContact": NO_CONTACT, "openArc": OPEN},
        "boxWalls": WALLS,
        "rigidWithFriction": FRICTION_WITH_RIGID_WALLS,
        "statuses": {str(status): text for status, text in STATUS_TEXT.items()},
    }


def _full(scene: Scene) -> Scene:
    """A scene that has everything once, with the law file of another one."""
    own = {"law_file": scene.contact.law_file} if scene.contact.law_file else {}
    joint = {"joint_friction": 1.0, "joint_armature": 1.0, "joint_torque_limit": 1.0}
    link = {"length": 1.0, "mass": 1.0}
    data = {
        "name": "full",
        "chain": {"links": [link, link | joint | {"joint_min": -1.0, "joint_max": 1.0}]},
        "box": dict.fromkeys(("x_min", "y_min"), -9.0) | dict.fromkeys(("x_max", "y_max"), 9.0),
        "walls": [{"name": WALL, "point": [0.0, -8.0], "angle": 0.0}],
        "contact": own
        | {"friction": 0.1}
        | {"wall": {WALL: {"stiffness": 1e8, "restitution": 0.5, "friction": 0.1, "static_friction": 0.1}}},
        "inputs": {"joint_torques": True, "joint_targets": True, "tip_force": True, "wall_motion": [WALL]},
        "initial": {"angles": [0.0, 0.0]},
        "outputs": {"loads": True, "impacts": 1},
    }
    return scene_from_dict(data, "the scene that has everything")


def _moving(scene: Scene) -> Scene:
    """The same with a base that moves."""
    base = replace(scene.chain, base="pinned")
    return replace(scene, chain=base, inputs=replace(scene.inputs, base_motion=True))


def _keys(table: Any, full: Scene) -> dict[str, Any]:
    """The keys of a table of the scene file, by their names."""
    return {entry.name: _key(entry.type, entry.metadata, full) for entry in keys(table)}


def _key(kind: Any, rule: Mapping[str, Any], full: Scene) -> dict[str, Any]:
    """What a key may hold: a table, tables in a list or by name, a list, or a value."""
    inner = entry_type(kind := without_none(kind))
    if is_dataclass(inner):
        kinds = {tuple: "tables", Mapping: "named"}
        return {
            "kind": kinds.get(get_origin(kind), "table"),
            "keys": _keys(inner, full),
            **({"entries": rule["entries"], "needed": rule["description"]} if rule.get("entries") else {}),
        }
    item, *rest = get_args(kind) or (kind,)
    found = _value(item, rule)
    if rest:
        length = "links" if rule["per_link"] else None if ... in rest else 1 + len(rest)
        found = {"kind": "list", "length": length, "each": found, "orTrue": rule["or_true"]}
    default = rule["default"]
    if isinstance(default, Derived):
        # what is derived from no other value is a number that stops have, or a zero for each link
        given = default.value({"chain": full.chain}) if default.constant else None
        return found | ({"ofStops": given} if isinstance(given, float) else {})
    return found | ({"needed": rule["description"]} if default is MISSING else {"default": default})


def _value(kind: Any, rule: Mapping[str, Any]) -> dict[str, Any]:
    """What a value may be."""
    limits = {
        name: rule[name] for name in ("minimum", "above", "maximum", "choices") if rule[name] is not None
    }
    pattern = {"pattern": f"^(?:{rule['matching'][0]})$"} if rule["matching"] else {}
    return limits | pattern | {"kind": kind.__name__, "unit": rule["unit"], "allowed": allowed(kind, rule)}


def _groups(templates: Iterable[tuple[str, dict[str, Any]]]) -> list[dict[str, Any]]:
    """Templates in their order, those together that follow each other and are of the same."""
    return [
        {"of": group, "rows": [one for _, one in rows]}
        for group, rows in groupby(templates, key=lambda pair: pair[0])
        if group != "another"
    ]


def _general(variable: Variable) -> tuple[str, str, Place]:
    """What a variable is of, its name with places for numbers and names, and its place likewise."""
    name, place = variable.name, variable.place
    group = next((group for group, names in GROUPS.items() if re.fullmatch(names, name)), "one")
    if group == "one" and re.search(r"\[|^wall\.", name):
        group = "another"  # link, point or wall, of which the last one stands for all
    if group in ("one", "energy", "solver"):
        return group, name, place
    name = re.sub(r"\[\d+\]", "[{n}]", name).replace(WALL, "{name}")
    return group, name, _indexed(place)


def _indexed(place: Place) -> Place:
    """A place with an index in the place of its first number; of a channel the number is added to it."""
    first = next((k for k, step in enumerate(place) if isinstance(step, int)), None)
    return place if first is None else (*place[:first], AT, *place[first + 1 :])


def _output(variable: Variable) -> tuple[str, dict[str, Any]]:
    group, name, place = _general(variable)
    belt = int(name.endswith("belt_position"))  # the channel behind that of its wall
    word = words(place, belt)
    return group, {"name": name, "unit": variable.unit, "integer": variable.type != "real", "word": word}


def _parameter(variable: Variable) -> tuple[str, dict[str, Any]]:
    """A parameter or an input: its words, its range and what it means."""
    group, name, place = _general(variable)
    _, _, _, _, low, high, _, _ = variable_row(variable, 0, 0)
    text = variable.description.partition(UNLESS_SET)[0]
    if group != "one":
        text = re.sub(r"\b(link|joint) 2\b", r"\1 {n}", text).replace(WALL, "{name}")
        text = text.replace("link 1", "{before}")
    given = variable.given_place
    rule = variable.rule and {
        "factors": [
            re.sub(r"^(?=\w+$)", f"{name.rpartition('.')[0]}.", key) for key in variable.rule.factors
        ],
        "divisor": variable.rule.divisor,
        "text": UNLESS_SET + variable.rule.text,
    }
    return group, {
        "name": name,
        "unit": variable.unit,
        "path": _path(variable.scene_path or ()),
        "type": variable.type,
        "low": low,
        "high": high,
        "allowed": variable.allowed,
        "text": text,
        "items": [[item.name, _sentence(item)] for item in variable.items],
        "rule": rule,
        "word": words(place),
        "given": words(_indexed(given) if group != "one" else given) if given else None,
    }


def _path(path: Place) -> list[str | int]:
    """The path of a parameter in a scene file."""
    general = (
        path
        if path[:1] in (("gravity",), ("box",)) or path[1:2] in (("position",), ("velocity",))
        else _indexed(path)
    )
    return ["{name}" if step == WALL else step for step in general]


def _sentence(item: Item) -> str:
    """What a choice is; of a contact law its range of use and its source."""
    law = CONTACT_LAWS.get(item.name)
    return f"{law.limits} {law.source}." if law else item.description


def _time(key: str) -> dict[str, Any]:
    """A time of the run, which is no parameter of an FMU."""
    rule = dict(scene_keys())[key].metadata
    return {
        "name": key,
        "unit": rule["unit"],
        "path": key.split("."),
        "type": "real",
        "low": float(np.nextafter(0.0, 1.0)),
        "high": 1e9,
        "allowed": allowed(float, rule),
        "text": rule["description"],
        "items": [],
        "rule": None,
        "word": None,
        "given": None,
    }


def _law(name: str) -> dict[str, Any]:
    """What decides whether a contact law goes with a scene."""
    law = CONTACT_LAWS.get(name)
    return {"name": name, "impulsive": bool(law and law.impulsive)}


def _layout() -> dict[str, Any]:
    """Where in the record the page reads what a run has found."""
    record = layout_of(*SAMPLES[0])
    statistics = record["statistics"].names or ()
    return {
        "status": words(("statistics", "status")),
        "time": words(("step", "time")),
        "impulses": words(("quadrature", "wanted")),
        "loads": words(("loads",)),
        "finished": {
            "count": words(("finished", "count")),
            "collected": words(("finished", "collected")),
            "room": _affine(lambda record: record["finished"]["point"].shape[0]),
            "fields": {name: words(("finished", name, 0)) for name in LOG_DTYPE.names or ()},
        },
        "changes": words(("changes", "count")),
        "active": words(("touch", "active_count")),
        "statistics": {name: words(("statistics", name)) for name in statistics},
    }


def _is_real(place: Place) -> bool:
    """Whether the numbers of a place are real."""
    kind = layout_of(*SAMPLES[0])
    for step in place:
        kind = kind[step] if isinstance(step, str) and step != AT else kind.base
    return kind.base == np.float64


@cache
def words(place: Place, first: int = 0) -> list[int]:
    """Where in any record the word of a place is; ``first`` is what the index 0 stands for."""

    def word(record: np.dtype, index: int) -> int:
        return word_index(record, tuple(first + index if step == AT else step for step in place))

    found = _affine(lambda record: word(record, 0))[:-1]
    stride = word(layout_of(*SAMPLES[0]), 1) - word(layout_of(*SAMPLES[0]), 0) if AT in place else 0
    return [*found, stride]


def _affine(number: Callable[[np.dtype], int]) -> list[int]:
    """a, b, c, d, e, f and 0 of a number that the record of N, C, F, L and K has."""
    return [*affine([number(layout_of(*sizes)) for sizes in SAMPLES]), 0]

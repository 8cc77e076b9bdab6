"""The variables of the FMU: one table of their names, kinds, units and places in the instance record.

From it come the modelDescription.xml, the table that the FMU carries, the columns of a CSV file and the names
that the command line's ``--set`` takes. What a parameter means, its unit and its range are in the fields of
``scene/tables.py``; this module adds only where they are found. A scene has the variables that it needs: no
wall, no candidate and no input that is not in it.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.compilation.law_file import read_law
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.kernel.tangent.duals import DIRECTIONS
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.limits import keys
from chain_impact.scene.names import AXES, Place, name_of, sensitivity_name
from chain_impact.scene.scene import Scene
from chain_impact.scene.tables import Box, Contact, Initial, Link, Material, Solver, Stops, Wall
from chain_impact.variables.units import quotient
from chain_impact.variables.variable import Item, Variable

WORD = 8  # bytes of every scalar in the record
BASE_INPUTS = {"": "m", "v": "m/s", "a": "m/s2"}
"""What the names of the base's position, velocity and acceleration begin with, and their units."""
WALL_INPUTS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s2"}
"""Those of a wall, likewise."""
MOTION = "motion"
"""The part of the record with what is given of motions."""
MOTIONS = ("position", "velocity", "acceleration")
"""Where the record has what is given of motions."""
BEHIND = "behind"
"""The field of the instances of dual numbers behind an instance (model.py)."""

GIVEN_PLACES: dict[Place, Place] = {
    **{("model", key): ("model", f"given_{key}") for key in ("center_of_mass", "inertia")},
    ("stops", "exponent"): ("stops", "given_exponent"),
    ("stops", "restitution"): ("given", "stop_restitution"),
}
"""Where the value in use of a parameter that may be derived is, and where what is given of it."""
GIVEN_OF_JOINTS = {
    "joint_damping": "joint_damping",
    "joint_stiffness": "joint_stiffness",
    "joint_rest_angle": "joint_target_angle",
}
"""Keys of a link whose values have their places among what can be set at any time."""
UNLESS_SET = "; unless set: "
"""In the description of a parameter that the scene derives: the rule stands behind it."""
FRICTION = ("friction", "static_friction")
"""The coefficients of dry friction."""
_METHODS = tuple(
    Item(name, "as each phase needs" if name == "auto" else f"{name} steps only") for name in SOLVER_METHODS
)


def derivatives(outputs: Sequence[Variable], varied: Sequence[Variable]) -> Iterator[Variable]:
    """The derivatives of some outputs with respect to some parameters and inputs."""
    for number, parameter in enumerate(varied):
        tangent, direction = divmod(number, DIRECTIONS)
        for of in outputs:
            yield Variable(
                name=sensitivity_name(of.name, parameter.name),
                type="real",
                causality="output",
                variability="continuous",
                unit=quotient(of.unit, parameter.unit),
                description=f"derivative of {of.name} with respect to {parameter.name}",
                place=(BEHIND, tangent, *of.place, "slope", direction),
                held=of.held,
            )


def word_index(dtype: np.dtype, place: Place) -> int:
    """The index of a scalar of a record, counted in 8-byte words from the record's start."""
    offset = 0
    for step in place:
        if isinstance(step, str):
            dtype, start = dtype[step], dtype.fields[step][1]  # type: ignore[index]
        else:
            item, (length, *rest) = dtype.base, dtype.shape
            if not 0 <= step < length:
                raise IndexError(f"{place}: {step} is not below {length}")
            dtype = np.dtype((item, tuple(rest)))
            start = step * dtype.itemsize
        offset += start
    if dtype.fields or dtype.itemsize != WORD:
        raise KeyError(f"{place} is not a scalar")
    return offset // WORD


def first_word(dtype: np.dtype, part: str) -> int:
    """The index of the first word of a part of a record."""
    offset: int = dtype.fields[part][1]  # type: ignore[index]
    return offset // WORD


@cache
def _rules(table: type) -> dict[str, Mapping[str, Any]]:
    """The metadata of each key of a table of the scene."""
    return {entry.name: entry.metadata for entry in keys(table) if not entry.metadata.get("file_only")}


def _parameter(
    rule: Mapping[str, Any],
    place: Place,
    path: Place,
    description: str = "{}",
    walls: Sequence[str] = (),
    *,
    derived: Container[Place] = (),
    **changes: Any,
) -> Variable:
    """The parameter that sets the value at ``path``, by the ``rule`` of its key; {} is its description.

    ``derived`` are the paths of what the scene derives.
    """
    limits = {limit: rule[limit] for limit in ("minimum", "above", "maximum")}
    given = GIVEN_PLACES.get(place[:2])
    given_place = changes.pop("given_place", given and (*given, *place[2:]))
    entries = {"type": "real", "variability": "fixed", "unit": rule["unit"], **limits, **changes}
    # the attributes of FMI have closed limits only
    open_limit = "" if rule["above"] is None else f"; must be > {rule['above']:g}"
    follows = rule["default"] if path in derived else None
    return Variable(
        name=name_of(path, walls),
        causality="parameter",
        description=description.format(rule["description"])
        + open_limit
        + (f"{UNLESS_SET}{follows.text}" if given and follows else ""),
        place=place,
        given_place=given_place,
        rule=follows if given else None,
        scene_path=path,
        **entries,
    )


def parameters(scene: Scene) -> Iterator[Variable]:
    """The parameters of the scene's FMU."""
    rules, rubbing = _rules(Scene) | _rules(Box), scene.friction_joints
    derived = frozenset(scene.derived_places)
    for j, axis in enumerate(AXES):
        path: Place = ("gravity", j)
        yield _parameter(rules["gravity"], ("model", *path), path, f"{axis} of the {{}}")
    for i in range(len(scene.chain.links)):
        for key, rule in _rules(Link).items():
            value = getattr(scene.chain.links[i], key)
            if value is None or (key == "joint_armature" and value == 0.0):
                continue
            if key == "joint_friction" and i + 1 not in rubbing:
                continue
            follows = scene.inputs.joint_targets and (i > 0 or scene.chain.base == "pinned")
            if key == "joint_rest_angle" and follows:
                continue  # the start value of an input
            path, place = ("chain", "links", i, key), ("model", key, i)
            if key in GIVEN_OF_JOINTS:
                place = ("given", GIVEN_OF_JOINTS[key], i)
            variability = "tunable" if follows and key in GIVEN_OF_JOINTS else "fixed"
            of_link = f"link {i + 1}: {{}}"
            yield _parameter(rule, place, path, of_link, derived=derived, variability=variability)
    for w, wall in enumerate(WALLS):
        if getattr(scene.box, wall) is not None:
            yield _parameter(rules[wall], ("model", "wall", w), ("box", wall), "position of the {}")
    if point_wall_pairs(scene):
        yield from _wall_parameters(scene)
        yield from _contact_parameters(scene)
        yield from _material_parameters(scene)
    if scene.stops.exponent is not None:
        yield from _stop_parameters(scene)
    yield from _initial_values(scene)
    for key, rule in _rules(Solver).items():
        path = ("solver", key)
        choice: dict[str, Any] = {"type": "enumeration", "items": _METHODS} if key == "method" else {}
        yield _parameter(rule, path, path, **choice)


def _wall_parameters(scene: Scene) -> Iterator[Variable]:
    rules, names = _rules(Wall), [wall.name for wall in scene.walls]
    for w, name in enumerate(names):
        for j, axis in enumerate(AXES):
            path: Place = ("walls", w, "point", j)
            text = f"wall {name}: {axis} of {{}}"
            yield _parameter(rules["point"], ("walls", axis, w), path, text, names)
        path = ("walls", w, "angle")
        yield _parameter(rules["angle"], ("walls", "angle", w), path, f"wall {name}: {{}}", names)


def _laws(scene: Scene) -> tuple[Item, ...]:
    """The laws in the order of their numbers, a user's last."""
    items = [Item(law.id, law.source) for law in CONTACT_LAWS.values()]
    if scene.contact.law_file:
        own = read_law(Path(scene.contact.law_file))
        items.append(Item(own.id, own.summary))
    return tuple(items)


def _contact_parameters(scene: Scene) -> Iterator[Variable]:
    rules = _rules(Contact)
    yield _law_parameter(scene)
    keys = ("stiffness", "exponent", "restitution", "radius", "minimum_impact_speed")
    for key in (*keys, *(FRICTION if scene.has_contact_friction else ())):
        path = ("contact", key)
        if key in ("stiffness", "restitution", *FRICTION):
            yield _parameter(rules[key], ("given", key), path, variability="tunable")
        else:
            yield _parameter(rules[key], path, path)


def _law_parameter(scene: Scene) -> Variable:
    path, rule = ("contact", "model"), _rules(Contact)["model"]
    return _parameter(
        rule, ("given", "law"), path, variability="tunable", type="enumeration", items=_laws(scene)
    )


def _material_parameters(scene: Scene) -> Iterator[Variable]:
    """What the scene gives of the material of single walls."""
    for name, material in scene.contact.wall.items():
        w = scene.wall_names.index(name)
        for key, rule in _rules(Material).items():
            if getattr(material, key) is not None:
                path = ("contact", "wall", name, key)
                text = f"at wall {name}: {{}}"
                yield _parameter(rule, ("walls", key, w), path, text, variability="tunable")


def _stop_parameters(scene: Scene) -> Iterator[Variable]:
    if scene.stops.model is None and not point_wall_pairs(scene):
        yield _law_parameter(scene)
    derived = frozenset(scene.derived_places)
    for key, rule in _rules(Stops).items():
        path = ("stops", key)
        if key == "stiffness":
            yield _parameter(rule, ("given", "stop_stiffness"), path, variability="tunable")
        elif key == "restitution":
            yield _parameter(rule, path, path, derived=derived, variability="tunable")
        elif key != "model":
            yield _parameter(rule, path, path, derived=derived)


def _initial_values(scene: Scene) -> Iterator[Variable]:
    rules = _rules(Initial)
    # the velocity of a pinned base can only be zero
    for key in ("position",) if scene.chain.base == "pinned" else ("position", "velocity"):
        for j, axis in enumerate(AXES):
            path: Place = ("initial", key, j)
            # an initial position is that of a base that moves, too
            moves = (MOTION, "position", j) if scene.inputs.base_motion else None
            yield _parameter(rules[key], path, path, f"initial {axis} of the {{}}", given_place=moves)
    for key, name in (("angles", "angle"), ("angular_velocities", "angular_velocity")):
        text = "initial " + rules[key]["description"]
        for i in range(len(scene.chain.links)):
            of_link = text.replace("each link", f"link {i + 1}")
            yield _parameter(rules[key], ("initial", name, i), ("initial", key, i), of_link)


def inputs(scene: Scene) -> Iterator[Variable]:
    """The inputs that the scene asks for."""

    def entry(name: str, unit: str, description: str, *place: str | int, part: str = "given") -> Variable:
        return Variable(
            name=name,
            type="real",
            causality="input",
            variability="continuous",
            unit=unit,
            description=description,
            place=(part, *place),
        )

    joints = range(0 if scene.chain.base == "pinned" else 1, len(scene.chain.links))
    if scene.inputs.joint_torques:
        for i in joints:
            of = f"torque on link {i + 1} from " + (f"link {i}" if i > 0 else "the base")
            yield entry(f"joint[{i + 1}].torque", "N.m", of, "joint_torque", i)
    if scene.inputs.joint_targets:
        for i in joints:
            name, of = f"joint[{i + 1}].target", f"that the spring of joint {i + 1} follows"
            yield entry(f"{name}_angle", "rad", f"angle {of}", "joint_target_angle", i)
            of = f"that the damper of joint {i + 1} follows"
            yield entry(f"{name}_velocity", "rad/s", f"angular velocity {of}", "joint_target_velocity", i)
    if scene.inputs.tip_force:
        for j, axis in enumerate(AXES):
            yield entry(f"tip.force.{axis}", "N", f"{axis} of the force on the tip", "tip_force", j)
    if scene.inputs.base_motion:
        for (prefix, unit), field in zip(BASE_INPUTS.items(), MOTIONS, strict=True):
            for j, axis in enumerate(AXES):
                text = f"{axis} of the {field} of the base"
                yield entry(f"base.{prefix}{axis}", unit, text, field, j, part=MOTION)
    channel = 2 if scene.inputs.base_motion else 0
    for wall in scene.moving_walls:
        for (key, unit), field in zip(WALL_INPUTS.items(), MOTIONS, strict=True):
            text = f"at wall {wall}: its {key} along its inward normal n"
            yield entry(f"wall.{wall}.{key}", unit, text, field, channel, part=MOTION)
        text = f"at wall {wall}: speed of its belt along t = (n_y, -n_x)"
        yield entry(f"wall.{wall}.belt_speed", "m/s", text, "velocity", channel + 1, part=MOTION)
        channel += 2

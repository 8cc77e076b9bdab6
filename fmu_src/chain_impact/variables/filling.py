"""The parameters of a scene in their places of a new record.

The record of a scene is kept: of another one that differs from it in numbers of some tables only, as one that
``with_values`` has made, only these tables are written anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chain_impact.kernel.chain.inertia import DERIVED
from chain_impact.kernel.forces.contact_law import USER_LAW
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.kernel.ode.sundman import NO_CONTACT
from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.kernel.tangent.duals import DIRECTIONS, tangent_dtype
from chain_impact.scene.names import Place
from chain_impact.scene.scene import Scene
from chain_impact.variables.places import layout_of
from chain_impact.variables.table import BEHIND, GIVEN_OF_JOINTS, WORD

LINK_PARAMETERS = (
    *("length", "mass", "center_of_mass", "inertia"),
    *("joint_friction", "joint_armature"),
)
Sizes = tuple[int, int, int, int, int]


@dataclass(frozen=True)
class _Kept:
    """A scene and the words of its record, not to be written to."""

    scene: Scene
    words: np.ndarray


_kept: dict[Sizes, _Kept] = {}
"""The last scene of each size, with its record."""
MOST_KEPT = 16


def new_record(scene: Scene, pairs: Sequence[tuple[int, int]], sizes: Sizes) -> np.ndarray:
    """An instance with the parameters of a scene, an array with one record, not yet initialized.

    Args:
        scene: what it is of.
        pairs: the candidates.
        sizes: of the record: links, candidates, elements, loads, channels.
    """
    layout, before = layout_of(*sizes), _kept.get(sizes)
    changes = None if before is None else changed_numbers(before.scene, scene)
    if before is None or changes is None:
        words = np.zeros(layout.itemsize // WORD)
        # a view would compare the types first, which takes longer than all else here
        block = np.ndarray(1, layout, words)
        _fill(block[0], scene, pairs)
        if len(_kept) >= MOST_KEPT:
            _kept.clear()
        _kept[sizes] = _Kept(scene, words.copy())
    else:
        block = np.ndarray(1, layout, before.words.copy())
        for write in changes:
            write(block[0], scene)
    return block


def changed_numbers(before: Scene, scene: Scene) -> list[Callable[[Any, Scene], None]] | None:
    """What writes the tables anew by which two scenes differ; None if all of the record has to be written.

    That is where scenes differ in more than numbers, or in numbers on which the layout of the record or the
    variables depend. A table that is the same object in both has not changed.
    """
    for name in ("box", "walls", "stops", "inputs", "outputs", "derived_places"):
        if getattr(before, name) is not getattr(scene, name):
            return None
    if before.contact is not scene.contact and _kind_of_contact(before) != _kind_of_contact(scene):
        return None
    if before.chain is not scene.chain and _kind_of_chain(before) != _kind_of_chain(scene):
        return None
    return [write for name, write in _WRITERS.items() if getattr(before, name) is not getattr(scene, name)]


def _kind_of_contact(scene: Scene) -> tuple[Any, ...]:
    """Values on which the layout of the record or the variables depend."""
    contact = scene.contact
    return id(contact.wall), contact.points, contact.law_file, contact.friction, contact.static_friction


def _kind_of_chain(scene: Scene) -> tuple[Any, ...]:
    """Values on which the layout of the record or the variables depend."""
    links = scene.chain.links
    names = ("joint_friction", "joint_armature", "joint_torque_limit", "joint_min", "joint_max")
    return scene.chain.base, [[getattr(link, name) for name in names] for link in links]


def _fill(d: Any, scene: Scene, pairs: Sequence[tuple[int, int]]) -> None:
    """Put the parameters of a scene, and its candidates, in their places in a new instance."""
    d["links"], d["candidates"] = len(scene.chain.links), len(pairs)
    d["elements"], d["loads"] = len(d["element"]["mode"]), len(d["transmitted"]["peak"])
    d["channels"] = len(d["motion"]["position"])
    d["step"]["regularized"] = NO_CONTACT
    model = d["model"]
    model["joint_min"], model["joint_max"] = -math.inf, math.inf
    for w, name in enumerate(WALLS):  # the position of a wall that is not there is never read
        model["wall"][w] = getattr(scene.box, name) or 0.0
    if pairs:
        d["candidate"]["point"], d["candidate"]["wall"] = np.transpose(pairs)
    model["pinned"] = scene.chain.base == "pinned"
    model["driven"], model["followed"] = scene.inputs.any, scene.inputs.joint_targets
    _fill_motion(d, scene, pairs)

    d["latest"]["kept"] = scene.outputs.impacts
    asked = scene.outputs
    rubbed = scene.has_friction and asked.energies
    d["quadrature"]["wanted"] = asked.contacts or asked.impacts > 0 or asked.loads or rubbed
    _fill_walls(d, scene)
    if scene.stops.exponent is not None:
        _fill_stops(d, scene)
    _fill_given_stops(d, scene)
    for write in _WRITERS.values():
        write(d, scene)


def _write_gravity(d: Any, scene: Scene) -> None:
    d["model"]["gravity"] = scene.gravity


def _write_links(d: Any, scene: Scene) -> None:
    """Put the numbers of the links in their places, and what is given of those that may be derived."""
    model, links, derived = d["model"], scene.chain.links, scene.derived_places
    for name in LINK_PARAMETERS:
        model[name] = [getattr(link, name) for link in links]
    for name, place in GIVEN_OF_JOINTS.items():
        d["given"][place] = [getattr(link, name) for link in links]
    limits = [link.joint_torque_limit for link in links]
    model["joint_torque_limit"] = [math.inf if limit is None else limit for limit in limits]
    for name in ("center_of_mass", "inertia"):
        model[f"given_{name}"] = [
            DERIVED if ("chain", "links", i, name) in derived else getattr(link, name)
            for i, link in enumerate(links)
        ]


def _write_contact(d: Any, scene: Scene) -> None:
    for name in ("exponent", "radius", "minimum_impact_speed"):
        d["contact"][name] = getattr(scene.contact, name)
    given = d["given"]
    given["law"] = _law_number(scene.contact.model)
    for name in ("stiffness", "restitution", "friction", "static_friction"):
        given[name] = getattr(scene.contact, name)


def _write_initial(d: Any, scene: Scene) -> None:
    initial = d["initial"]
    initial["position"], initial["velocity"] = scene.initial.position, scene.initial.velocity
    initial["angle"] = scene.initial.angles
    if scene.inputs.base_motion:
        d["motion"]["position"][:2] = scene.initial.position
    initial["angular_velocity"] = scene.initial.angular_velocities


def _write_solver(d: Any, scene: Scene) -> None:
    d["solver"]["method"] = SOLVER_METHODS.index(scene.solver.method) + 1
    for name in ("tolerance", "work_limit"):
        d["solver"][name] = getattr(scene.solver, name)


_WRITERS: dict[str, Callable[[Any, Scene], None]] = {
    "gravity": _write_gravity,
    "chain": _write_links,
    "contact": _write_contact,
    "initial": _write_initial,
    "solver": _write_solver,
}
"""Table of the scene → what writes its numbers."""


def _fill_motion(d: Any, scene: Scene, pairs: Sequence[tuple[int, int]]) -> None:
    """Put which channels move the base and the walls in its places."""
    d["model"]["base_moves"], d["motion"]["follows"] = scene.inputs.base_motion, 1
    first = 2 if scene.inputs.base_motion else 0
    moving = {scene.wall_names.index(name): first + 2 * w for w, name in enumerate(scene.moving_walls)}
    d["motion"]["belt"][first + 1 :: 2] = 1
    d["shift"]["channel"] = [moving.get(wall, -1) for _, wall in pairs]


def _fill_walls(d: Any, scene: Scene) -> None:
    """Put the walls at any angle, and the materials of all walls, in their places."""
    for name in ("restitution", "friction", "static_friction"):
        d["walls"][name] = -1.0  # that of `contact`
    if not scene.contact.points:  # the record has room for walls only where points may touch them
        return
    for w, wall in enumerate(scene.walls):
        for name, value in (("x", wall.point[0]), ("y", wall.point[1]), ("angle", wall.angle)):
            d["walls"][name][w] = value
    for w, wall_name in enumerate(scene.wall_names):
        material = scene.contact.wall.get(wall_name)
        for name in ("stiffness", "restitution", "friction", "static_friction"):
            if material and (value := getattr(material, name)) is not None:
                d["walls"][name][w] = value


def _fill_stops(d: Any, scene: Scene) -> None:
    """Put the stops in joints in their places."""
    stops, found = scene.stops, scene.chain.stops
    for joint, ends in scene.chain.joint_ranges.items():
        d["model"]["joint_min"][joint - 1], d["model"]["joint_max"][joint - 1] = ends
    d["candidate"]["stop"][-len(found) :] = [1 if stop == "joint_min" else -1 for _, stop in found]
    d["stops"]["law"] = _law_number(stops.model) if stops.model else 0
    for name in ("exponent", "restitution", "minimum_impact_speed"):
        d["stops"][name] = getattr(stops, name)
    d["given"]["stop_stiffness"] = stops.stiffness


def _fill_given_stops(d: Any, scene: Scene) -> None:
    """Put what is given of the stops that may be derived in its place; see kernel/chain/inertia.py."""
    derived = scene.derived_places
    places = {"exponent": ("stops", "given_exponent"), "restitution": ("given", "stop_restitution")}
    for name, (part, field) in places.items():
        d[part][field] = DERIVED if ("stops", name) in derived else getattr(scene.stops, name) or 0.0


def _law_number(name: str) -> int:
    law = CONTACT_LAWS.get(name)
    return law.number if law else USER_LAW


def with_tangents(block: np.ndarray, places: Sequence[Place]) -> np.ndarray:
    """An instance, and behind it those of dual numbers, each parameter of these places with a direction."""
    layout, count = block.dtype, -(-len(places) // DIRECTIONS)
    names = layout.names or ()
    behind = (BEHIND, tangent_dtype(layout), (count,))
    whole = np.zeros(1, np.dtype([*((name, layout[name]) for name in names), behind]))
    block["tangents"] = count
    for name in names:
        whole[name] = block[name]
    _copy_values(block[0], whole[0][BEHIND])
    for number, place in enumerate(places):
        field: Any = whole[0][BEHIND][number // DIRECTIONS]
        for step in place:
            field = field[step]
        field["slope"][number % DIRECTIONS] = 1.0
    return whole


def _copy_values(source: Any, target: np.ndarray) -> None:
    """Copy the values of a record to each of some records of dual numbers."""
    for name in source.dtype.names:
        part = target[name]
        if source.dtype[name].base.names:
            _copy_values(source[name], part)
        else:
            (part["value"] if part.dtype.names else part)[...] = source[name]

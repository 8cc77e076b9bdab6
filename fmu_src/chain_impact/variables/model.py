"""From a scene to an instance, with its parameters in their places (kernel/record.py)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from chain_impact.kernel.integration.methods import SOLVER_METHODS
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.model.contact_force import USER_LAW
from chain_impact.kernel.model.geometry import WALLS
from chain_impact.kernel.record import instance_dtype
from chain_impact.kernel.tangent.directions import DIRECTIONS, tangent_dtype
from chain_impact.scene.candidates import candidates
from chain_impact.scene.names import Place
from chain_impact.scene.scene import Scene
from chain_impact.variables.table import BEHIND, parameters_of

LINK_PARAMETERS = (
    *("length", "mass", "center_of_mass", "inertia"),
    *("joint_damping", "joint_stiffness", "joint_rest_angle"),
)


def new_instance(scene: Scene) -> np.ndarray:
    """An instance with the parameters of the scene, not yet initialized; an array with one record.

    Behind the instance, in the same record, are those of dual numbers that the scene's sensitivities need.

    Raises:
        UnknownNameError: when there are no derivatives with respect to one of them.
    """
    pairs = candidates(scene)
    links = scene.chain.links
    block = np.zeros(1, _layout(len(links), len(pairs)))
    d = block[0]
    d["links"], d["candidates"] = len(links), len(pairs)

    model = d["model"]
    model["gravity"] = scene.gravity
    for name in LINK_PARAMETERS:
        model[name] = [getattr(link, name) for link in links]
    # the position of a wall that is not there is never looked at
    model["wall"] = [getattr(scene.box, name) or 0.0 for name in WALLS]
    if pairs:
        d["candidate"]["point"], d["candidate"]["wall"] = np.transpose(pairs)
        for w, wall in enumerate(scene.walls):
            for name, value in (("x", wall.point[0]), ("y", wall.point[1]), ("angle", wall.angle)):
                d["walls"][name][w] = value
    model["pinned"] = scene.chain.base == "pinned"
    model["driven"] = scene.inputs.joint_torques or scene.inputs.tip_force

    contact = d["contact"]
    law = CONTACT_LAWS.get(scene.contact.model)
    contact["law"] = law.number if law else USER_LAW
    for name in ("stiffness", "exponent", "restitution", "radius", "minimum_impact_speed"):
        contact[name] = getattr(scene.contact, name)

    given = d["given"]
    for name in ("law", "stiffness", "restitution"):
        given[name] = contact[name]

    initial = d["initial"]
    initial["position"], initial["velocity"] = scene.initial.position, scene.initial.velocity
    initial["angle"] = scene.initial.angles
    initial["angular_velocity"] = scene.initial.angular_velocities

    d["latest"]["kept"] = scene.outputs.impacts
    d["impulse"]["wanted"] = scene.outputs.contacts or scene.outputs.impacts > 0
    d["solver"]["method"] = SOLVER_METHODS.index(scene.solver.method) + 1
    for name in ("tolerance", "work_limit"):
        d["solver"][name] = getattr(scene.solver, name)
    varied = parameters_of(scene, scene.outputs.sensitivities)
    return _with_tangents(block, [variable.place for variable in varied]) if varied else block


_layout = cache(instance_dtype)  # which takes as long as all else of a new instance


def _with_tangents(block: np.ndarray, places: Sequence[Place]) -> np.ndarray:
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
        if source.dtype[name].names:
            _copy_values(source[name], part)
        else:
            (part["value"] if part.dtype.names else part)[...] = source[name]

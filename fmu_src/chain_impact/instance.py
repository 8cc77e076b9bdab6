"""From a scene to an instance, with its parameters in their places (layout.py)."""

from __future__ import annotations

import numpy as np

from chain_impact.kernel.integration.methods import SOLVER_METHODS
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.model.contact_force import USER_LAW
from chain_impact.kernel.model.geometry import WALLS
from chain_impact.layout import instance_dtype
from chain_impact.scene import Scene

LINK_PARAMETERS = (
    *("length", "mass", "center_of_mass", "inertia"),
    *("joint_damping", "joint_stiffness", "joint_rest_angle"),
)


def candidates(scene: Scene) -> list[tuple[int, int]]:
    """The pairs (point, index into ``scene.wall_names``) that can touch: listed points, existing walls."""
    there = scene.half_planes
    walls = [w for w, name in enumerate(scene.wall_names) if name in there]
    return [(point, wall) for point in scene.contact.points for wall in walls]


def candidate_count(scene: Scene) -> int:
    """How many candidates there are."""
    box = sum(getattr(scene.box, name) is not None for name in WALLS)
    return len(scene.contact.points) * (box + len(scene.walls))


def new_instance(scene: Scene) -> np.ndarray:
    """An instance with the parameters of the scene, not yet initialized; an array with one record."""
    pairs = candidates(scene)
    links = scene.chain.links
    block = np.zeros(1, instance_dtype(len(links), len(pairs)))
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
    return block

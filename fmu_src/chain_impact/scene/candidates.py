"""The candidates of a scene: pairs of a point and a wall that can touch, and stops of joints and slider."""

from __future__ import annotations

from itertools import product

from chain_impact.kernel.record.constants import WALLS
from chain_impact.scene.contents import SceneContents


def candidates_of(scene: SceneContents) -> list[tuple[int, int]]:
    """Return the candidates as pairs: a number, and an index in ``scene.wall_names``.

    First come the pairs of a point and an existing wall that can touch: number of the point, index of the
    wall. Then come the existing stops of joints: number of the joint, index of the stop. Last come the
    existing stops of a slider: 0, index of the stop.
    """
    pairs, names = point_wall_pairs(scene), scene.wall_names
    joints = stop_pairs(scene)
    return [*pairs, *joints, *((0, names.index(stop)) for stop in scene.slider_stops)]


def part_texts(scene: SceneContents) -> list[str]:
    """Return words for each part of a scene that can be the cause of a fault of a run.

    The record's field ``fault.part`` has the number of a part in this list, from 1; 0 if no part is known.
    The list has, in this order: the candidates; the links; the joint of each link; the slider, if there is
    one; and, for each pair of a point and a wall that can touch, the base, which may be beyond this wall.
    """
    names, points = scene.wall_names, len(point_wall_pairs(scene))
    pairs = candidates_of(scene)
    candidate_texts = [
        f"{scene.point_label(point)} at the wall {names[wall]}" for point, wall in pairs[:points]
    ]
    stops = [
        f"joint {joint} at its {names[wall]}" if joint else f"the slider at its {names[wall]}"
        for joint, wall in pairs[points:]
    ]
    numbers = range(1, len(scene.chain.links) + 1)
    owners = [form.format(i) for form in ("link[{}]", "joint {}") for i in numbers]
    owners += ["the slider"] * (scene.chain.slider is not None)
    bases = [f"the base at the wall {names[wall]}" for _, wall in pairs[:points]]
    return [*candidate_texts, *stops, *owners, *bases]


def stop_pairs(scene: SceneContents) -> list[tuple[int, int]]:
    """Return the existing stops of joints as pairs: number of the joint, index in ``scene.wall_names``.

    One joint comes after the other, and of each joint first ``joint_min``.
    """
    names = scene.wall_names
    return [(joint, names.index(stop)) for joint, stop in scene.chain.stops]


def wall_numbers(scene: SceneContents) -> dict[str, int]:
    """Return name of a wall of the box, or of an entry of ``walls``, → its number; some may touch nothing."""
    return {name: w for w, name in enumerate((*WALLS, *(wall.name for wall in scene.walls)))}


def point_wall_pairs(scene: SceneContents) -> list[tuple[int, int]]:
    """Return the pairs of a point and an existing wall that can touch each other.

    A pair has the number of the point and the index of the wall in ``scene.wall_names``. All pairs of a point
    come together, in the order of the walls; the points are in the order of ``scene.touching_points``.
    """
    numbers, pairs = wall_numbers(scene), product(scene.touching_points, scene.half_planes.items())
    return [(k, numbers[name]) for k, (name, plane) in pairs if not scene.keeps_distance(k, plane)]

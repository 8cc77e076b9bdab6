"""Checks of a scene across several keys, and warnings of valid values that are probably mistakes.

The twin in JavaScript is pages/browser/scene/scene_file.js.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

from chain_impact.kernel.chain.inertia import find_loose_links
from chain_impact.kernel.constraints.geometry import ALLOWED_OVERLAP
from chain_impact.kernel.record.constants import WALLS
from chain_impact.scene.checks.rule_checks import check_entry_rules, check_file_rules
from chain_impact.scene.checks.signal_checks import check_signals
from chain_impact.scene.contents import SceneContents
from chain_impact.scene.errors import SceneError, error_at, no_wall_error, value_text
from chain_impact.scene.files.table_file import gap_hints
from chain_impact.scene.kernel_view import chain_view
from chain_impact.scene.keys.chain_tables import ChainTable, Link
from chain_impact.scene.texts.angles import radians_hint, turns_hint
from chain_impact.scene.texts.names import AXES, path_text

# LONG_LINK [m], LIGHT_LINK [kg/m]: The length of a link is probably given in mm if it is above LONG_LINK and
# the mass per length is below LIGHT_LINK: in metres, only a long rope would be so light.
LONG_LINK, LIGHT_LINK = 20.0, 0.2
GRAVITY_IN_MM = (9e3, 1.05e4)  # [m/s²] range of a gravity that is probably the earth's gravity in mm/s²
# [1] the coordinates of a point of a link are probably in mm if the distance of this point from the link's
# proximal joint is above FAR_POINT times the sum of the lengths of all links
FAR_POINT = 30.0


def check_scene(scene: SceneContents) -> None:
    """Raise a SceneError if the scene fails a check of this module, of rule_checks.py or of signal_checks.py.

    ``check_given_rules`` is left out: it checks a scene before its completion. The fault of the error ends
    with the sentences of ``angle_hints``, because an angle in degrees by mistake is often the cause.
    """
    try:
        check_together(scene)
        check_signals(scene)
        check_start(scene)
        check_joint_angles(scene)
    except SceneError as error:
        error.fault = "; ".join([error.fault, *angle_hints(scene)])
        raise


def check_masses(chain: ChainTable) -> None:
    """Refuse links without inertia that can turn, in some position of the chain, without moving any mass.

    Nothing would determine the angular acceleration of such links. ``find_loose_links`` in
    kernel/chain/inertia.py finds them. The carriage of a slider counts as movable mass only if its own mass
    is > 0.
    """
    (first, last), other_text = find_loose_links(chain_view(chain), False), ""
    if first < 0 and chain.slider is not None and chain.slider.mass == 0.0:
        (first, last), other_text = find_loose_links(chain_view(chain), True), ", or slider.mass,"
    if first < 0:
        return
    if first == last:
        link = chain.links[first]
        link_text = (
            f"its centre of mass is {link.center_of_mass:g} m of {link.length:g} m from the proximal joint"
        )
        reason = f"the link could turn about its centre of mass without moving any mass ({link_text})"
        path = ("chain", "links", first, "inertia")
        raise error_at(path, f"{other_text} must be > 0: {reason}".lstrip(), str(link.inertia))
    path, end = (("chain", "links", i, "inertia") for i in (first, last))
    reason = "on one line, these links could turn about their centres of mass without moving any mass"
    raise error_at(path, f"to {path_text(end)} = 0.0; one of them{other_text} must be > 0: {reason}")


def check_together(scene: SceneContents) -> None:
    """Refuse keys whose values are valid alone, but contradict each other, except signals and the start."""
    check_masses(scene.chain)
    check_entry_rules(scene)
    check_file_rules(scene)
    check_moved_walls(scene)


def check_moved_walls(scene: SceneContents) -> None:
    """Refuse a name in inputs.wall_motion that is neither that of an existing wall nor "*" (all walls)."""
    walls = [*scene.half_planes]
    for i, name in enumerate(scene.inputs.wall_motion):
        if name != "*" and name not in walls:
            raise no_wall_error(("inputs", "wall_motion", i), walls, f"= {value_text(name)} ")


def check_start(scene: SceneContents) -> None:
    """Refuse a start in which a point penetrates an existing wall by more than ALLOWED_OVERLAP.

    Checked are the points in ``contact.points``, and the additional points of links, with their radii.
    """
    walls, start, links = scene.walls_at_start, scene.start, len(scene.chain.links)
    candidates = {k: start[k] for k in start if k > links or k in scene.contact.points}
    for point, (x, y, radius) in candidates.items():
        for name, wall in walls.items():
            depth = radius - wall.clearance(x, y)
            if depth > ALLOWED_OVERLAP:
                point_text = scene.point_label(point)
                subject = f"{point_text} at {_position(x, y)} is {depth:.6g} m deep in"
                is_beyond = name not in WALLS and all(
                    wall.clearance(*position) < 0.0 for *position, _ in candidates.values()
                )
                questions = ["all points are inside: turn its normal?"] * (
                    is_beyond and not angle_hints(scene)
                )
                question_text = "".join(f"; {question}" for question in [*questions, *length_hints(scene)])
                raise SceneError(f"initial: {subject} the wall {name}; must be outside{question_text}")


def _position(x: float, y: float) -> str:
    """Return the text "(x, y) m" of a position [m]; a coordinate up to ±ALLOWED_OVERLAP is written as 0."""
    x, y = (0.0 if abs(coordinate) <= ALLOWED_OVERLAP else coordinate for coordinate in (x, y))
    return f"({x:.6g}, {y:.6g}) m"


def check_joint_angles(scene: SceneContents) -> None:
    """Refuse a start in which the angle of a joint is more than ALLOWED_OVERLAP [rad] beyond its stop."""
    angles = (0.0, *scene.initial.angles)
    for i, (low, high) in scene.chain.joint_ranges.items():
        joint = angles[i] - angles[i - 1]
        excess = max(low - joint, joint - high)
        if excess > ALLOWED_OVERLAP:
            stop_text = f"joint_min = {low:.6g}" if joint < low else f"joint_max = {high:.6g}"
            joint_text = f"joint {i} at {joint:.6g} rad is {excess:.6g} rad beyond its {stop_text} rad"
            raise SceneError(f"initial: {joint_text}; must be within{turns_hint(joint, low, high)}")


def angle_hints(scene: SceneContents) -> list[str]:
    """Return a sentence for each angle of more than one turn: this angle may be in degrees by mistake.

    The angles are those of the start, of springs at rest, of stops, of the slider's line and of walls [rad].
    """
    links, name, angles = enumerate(scene.chain.links, 1), "angle", scene.initial.angles
    if scene.has_joint_angles:
        name = "joint_angles"
        angles = tuple(second_angle - first_angle for first_angle, second_angle in pairwise((0.0, *angles)))
    suspicious_angles = {f"initial.{name}[{i}]": angle for i, angle in enumerate(angles, 1)}
    suspicious_angles |= {f"link[{i}].joint_rest_angle": link.joint_rest_angle for i, link in links}
    suspicious_angles |= {
        f"link[{i}].{key}": getattr(scene.chain.links[i - 1], key) for i, key in scene.chain.stops
    }
    if scene.chain.slider:
        suspicious_angles["slider.angle"] = scene.chain.slider.angle
    suspicious_angles |= {f"wall.{wall.name}.angle": wall.angle or 0.0 for wall in scene.walls}
    return [hint for name, angle in suspicious_angles.items() if (hint := radians_hint(name, angle, "rad"))]


def scene_hints(scene: SceneContents) -> list[str]:
    """Return sentences on values of a scene that are allowed, but are probably mistakes of the user."""
    texts = angle_hints(scene)
    for i, link in enumerate(scene.chain.links, 1):
        if link.center_of_mass > link.length:
            subject = f"link[{i}].center_of_mass = {link.center_of_mass:g} m"
            texts.append(f"{subject} lies beyond the end of the link, which is {link.length:g} m long")
    stop_time, step = scene.simulation.stop_time, scene.simulation.step_size
    if step > stop_time:
        step_text = f"simulation.step_size = {step:g} s is longer than simulation.stop_time = {stop_time:g} s"
        texts.append(f"{step_text}: there are two rows only, the start and the end")
    for name, signal in scene.signals.items():
        if signal.samples:
            subject = f"signal.{name}: {signal.file}"
            texts += [f"{subject}: {hint}" for hint in gap_hints(signal.samples.times)]
    return [*texts, *size_hints(scene), *base_hints(scene), *start_hints(scene)]


def size_hints(scene: SceneContents) -> list[str]:
    """Return the questions of ``length_hints``, and a question on gravity if it is probably in mm/s²."""
    texts, pull = length_hints(scene), math.hypot(*scene.gravity)
    if GRAVITY_IN_MM[0] < pull < GRAVITY_IN_MM[1]:
        gravity_text = f"gravity = {list(scene.gravity)} m/s² is a thousand times as strong as on earth"
        texts.append(f"{gravity_text}: is it in mm/s²?")
    return texts


def is_long_for_its_mass(link: Link) -> bool:
    """Return whether the length of a link is probably given in mm (LONG_LINK, LIGHT_LINK)."""
    return link.length > LONG_LINK and link.mass < LIGHT_LINK * link.length


def length_hints(scene: SceneContents) -> list[str]:
    """Return at most two questions whether a length is in mm.

    One is on the first link that is long for its mass, one on the first point of a link that is far from the
    proximal joint of the link (FAR_POINT).
    """
    links, total = scene.chain.links, sum(link.length for link in scene.chain.links)
    long_links = [
        f"link[{i}].length = {link.length:g} m is long for link[{i}].mass = {link.mass:g} kg: is it in mm?"
        for i, link in enumerate(links, 1)
        if is_long_for_its_mass(link)
    ]
    far_points = [
        f"point {number} is {distance:g} m from the joint of its link, far for a chain of {total:g} m: "
        "are x and y in mm?"
        for number, (_, site) in enumerate(scene.chain.sites, len(links) + 1)
        if (distance := math.hypot(site.x, site.y)) > FAR_POINT * total
    ]
    return long_links[:1] + far_points[:1]


def start_hints(scene: SceneContents) -> list[str]:
    """Return a sentence for each coordinate in which a pinned base does not start at initial.position.

    If a signal gives a coordinate of the base, the base starts at the value of the signal at t = 0, and
    initial.position has no effect.
    """
    if scene.chain.base != "pinned":
        return []
    starts = zip(AXES, scene.base_at_start, scene.initial.position, strict=True)
    return [
        base_start_hint(axis, start, given_value)
        for axis, start, given_value in starts
        if abs(start - given_value) > ALLOWED_OVERLAP
    ]


def base_start_hint(axis: str, start: float, given_value: float) -> str:
    """Return the sentence of ``start_hints`` on the coordinate ``axis``, "x" or "y".

    ``start`` [m] is the coordinate at which the base starts, ``given_value`` [m] that in initial.position.
    """
    return f"base.{axis} starts at {start:.6g} m, and initial.{axis} = {given_value:.6g} m is not used"


def base_hints(scene: SceneContents) -> list[str]:
    """Return a sentence for each wall behind which the base is at the start; its radius does not count.

    Only walls that cannot touch the base are checked. A pinned base touches no wall; a base that slides does
    not touch walls parallel to its line, of which those that may move are checked. Such a start is allowed,
    but the wall is probably misplaced.
    """
    x, y = scene.base_at_start
    walls = {
        name: wall
        for name, wall in scene.walls_at_start.items()
        if scene.chain.base == "pinned"
        or (scene.keeps_distance(0, wall) and {"*", name} & {*scene.inputs.wall_motion})
    }
    depths = {name: -wall.clearance(x, y) for name, wall in walls.items()}
    base_text = f"initial: the {'pinned ' * (scene.chain.base == 'pinned')}base at {_position(x, y)} is"
    return [
        f"{base_text} {depth:.6g} m beyond the wall {name}, which it cannot touch: is the wall misplaced?"
        for name, depth in depths.items()
        if depth > ALLOWED_OVERLAP
    ]


def turning_hints(scene: SceneContents, changes: Iterable[Any]) -> list[str]:
    """Return a list with one sentence if ``changes`` set the start angle of a link, but not of the next link.

    ``changes`` are names of parameters; paths are ignored. Angles are absolute, so the next link does not
    turn with the link. A user who gives ``initial.joint_angles`` in the scene's file may expect that the
    further links turn, too; the list is empty for any other file, and if there is no such link.
    """
    if not scene.has_joint_angles:
        return []
    names, given_names = [f"initial.angle[{i}]" for i in range(1, len(scene.chain.links) + 1)], {*changes}
    lone_names = [
        name for name, next_name in pairwise(names) if name in given_names and next_name not in given_names
    ]
    effect_text = "is set, and the absolute angles of the links behind it stay"
    return [f"{lone_names[0]} {effect_text}; initial.joint_angles turns these, too"] if lone_names else []


def law_hints(scene: SceneContents) -> list[str]:
    """Return a list with one sentence if the scene does not use the law of ``contact.law_file``, else []."""
    if not scene.contact.law_file:
        return []
    law, model = Path(scene.contact.law_file).stem, scene.contact.model
    if law in (model, scene.stops.model):
        return []
    return [f'contact.law_file gives the law {law}, but contact.model is "{model}"']

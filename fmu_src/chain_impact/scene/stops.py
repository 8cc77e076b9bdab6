"""What the stops of joints must be; see scene.py, whose functions call these."""

from __future__ import annotations

import math

from chain_impact.scene.checks import START_TOLERANCE, check_law
from chain_impact.scene.contents import Contents
from chain_impact.scene.limits import keys
from chain_impact.scene.names import STOPS
from chain_impact.scene.reading import SceneError, shown
from chain_impact.scene.tables import Chain, Stops


def check_stops(scene: Contents) -> None:
    """Refuse stops that cannot be, and a table for them where there are none."""
    if not scene.chain.stops:
        _refuse_table(scene)
        return
    _check_links(scene.chain)
    for number, wall in enumerate(scene.walls, 1):
        if wall.name in STOPS:
            needed = f"must be none of {', '.join(STOPS)}, as joints have stops"
            raise SceneError(f"walls[{number}].name = {wall.name!r} {needed}")
    check_law(scene.stops.model or scene.contact.model, "stops", scene.stops)


def _refuse_table(scene: Contents) -> None:
    for entry in keys(Stops):
        if (value := getattr(scene.stops, entry.name)) is not None:
            needed = "must be left out: no link has a joint_min or joint_max"
            raise SceneError(f"stops.{entry.name} = {shown(value)} {needed}")


def _check_links(chain: Chain) -> None:
    joint, key = chain.stops[0]
    if joint == 1 and chain.base == "free":
        needed = (
            "must be left out: a free base has no joint 1; of equal links, link 1 needs an entry of its own"
        )
        raise SceneError(f"link[1].{key} = {getattr(chain.links[0], key)} {needed}")
    for i, (low, high) in chain.joint_ranges.items():
        if not low < high:
            raise SceneError(
                f"link[{i}].joint_max = {high} must be > {low} [rad], which is link[{i}].joint_min"
            )


def check_joint_angles(scene: Contents) -> None:
    """Refuse a start in which a joint is beyond one of its stops."""
    angles = (0.0, *scene.initial.angles)
    for i, (low, high) in scene.chain.joint_ranges.items():
        joint = angles[i] - angles[i - 1]
        beyond = max(low - joint, joint - high)
        if beyond > START_TOLERANCE:
            stop = f"joint_min = {low:.6g}" if joint < low else f"joint_max = {high:.6g}"
            where = f"joint {i} at {joint:.6g} rad is {beyond:.6g} rad beyond its {stop} rad"
            raise SceneError(f"initial: {where}; must be within{_turns_hint(joint, low, high)}")


def _turns_hint(joint: float, low: float, high: float) -> str:
    """What to say of a joint that is within its stops but for whole turns; else nothing."""
    turns = math.ceil((low - joint) / math.tau) if joint < low else math.floor((high - joint) / math.tau)
    same = joint + turns * math.tau
    return (
        f"; angles are not reduced to one turn, and {same:.6g} rad is the same direction"
        if low <= same <= high
        else ""
    )

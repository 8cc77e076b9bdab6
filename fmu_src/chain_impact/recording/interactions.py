"""The contacts and the dry friction of a recording over time."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from chain_impact.scene.texts.names import STOPS

Quantities = Mapping[str, np.ndarray]
"""Name of a quantity of an owner, such as "force" → its values, shape (T,)."""
WALL, SLIDER_STOP, JOINT_STOP, FRICTION = "wall", "stop of a slider", "stop of a joint", "friction"
"""The kinds of ``Interaction``; FRICTION is dry friction in a joint or on a slider."""


@dataclass(frozen=True, slots=True, eq=False)
class Interaction:
    """A contact with a wall or with a stop of a joint or slider; or dry friction in a joint or on a slider.

    Attributes:
        point: the number of the point; for a joint the number of the joint, 1…N; for a slider 0.
        wall: the name of the wall; for a stop joint_min, joint_max, slider_min or slider_max; "" for dry
            friction in a joint or on a slider.
        force: the normal force of the wall, shape (T,) [N]; for a stop of a joint the absolute value of
            its moment [N·m]; None for dry friction in a joint or on a slider.
        penetration: the penetration, shape (T,) [m]; None if unknown, as always at a stop of a joint.
        rate: the rate of penetration, shape (T,) [m/s]; None if unknown, as always at a stop of a joint.
        friction: the force of dry friction on the point, shape (T,) [N]; it is positive along t = (n_y,
            −n_x), for the wall's normal n. For a joint it is the moment of dry friction [N·m], for a slider
            the force of dry friction on the carriage [N]; both are positive where they push the angle or the
            position to larger values. None without dry friction, or if unknown.
        sticking: shape (T,); above 0 in the rows in which the contact, joint or slider sticks, else 0. None
            without dry friction, or if unknown.
        kind: WALL, SLIDER_STOP, JOINT_STOP or FRICTION; ``wall`` does not tell it, because a wall may have
            the name of a stop if the chain has no such stop.
    """

    point: int
    wall: str
    force: np.ndarray | None
    penetration: np.ndarray | None = None
    rate: np.ndarray | None = None
    friction: np.ndarray | None = None
    sticking: np.ndarray | None = None
    kind: str = WALL

    @classmethod
    def contacts_of_stops(cls, joint: int, moment: np.ndarray) -> Iterator[Interaction]:
        """Yield the contact of a joint's link with joint_min and the contact with joint_max.

        ``moment`` is the output that both share: the moment of the stops on the link, shape (T,) [N·m]. It is
        positive while the link touches joint_min, and negative while the link touches joint_max.
        """
        for stop, sign in zip(STOPS, (1.0, -1.0), strict=True):
            yield cls(joint, stop, np.maximum(sign * moment, 0.0), kind=JOINT_STOP)


def contacts_in(
    columns: Mapping[tuple[int, str], Quantities], slider_stops: Container[str]
) -> Iterator[Interaction]:
    """Yield the contacts with a known force at walls and at stops of a slider.

    ``columns`` has the quantities of each contact by the number of its point and the name of its wall,
    ``slider_stops`` the names of walls that are stops of a slider.
    """
    for (point, wall), values in columns.items():
        if "force" in values:
            yield Interaction(
                *(point, wall, values["force"]),
                *(values.get("penetration"), values.get("penetration_rate")),
                *(values.get("friction_force"), values.get("sticking")),
                SLIDER_STOP if wall in slider_stops else WALL,
            )


def interactions_in_joints(columns: Mapping[tuple[int, str], Quantities]) -> Iterator[Interaction]:
    """Yield the contacts at stops of joints and the dry friction in joints.

    ``columns`` has the quantities of each joint by its number and "".
    """
    for (joint, _), values in columns.items():
        if "stop_moment" in values:
            yield from Interaction.contacts_of_stops(joint, values["stop_moment"])
        yield from friction_of(joint, values, "friction_moment")


def friction_of(joint: int, values: Quantities, name: str) -> Iterator[Interaction]:
    """Yield the dry friction in a joint, or that on a slider as joint 0, if ``values`` has "sticking".

    ``name`` is the name of its force or moment in ``values``.
    """
    if "sticking" in values:
        friction, sticking = values.get(name), values["sticking"]
        yield Interaction(joint, "", None, friction=friction, sticking=sticking, kind=FRICTION)

"""The stops of joints in results: the ranges of joints, and the lines that show them in drawn chains."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, takewhile
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import STOPS

# [1] radius of the arc that shows the range of a joint, relative to the length of the joint's link
RANGE_RADIUS = 0.25
OPEN_ANGLE = 0.5 * math.pi  # [rad] angle that the arc spans for a joint with only one stop
RANGE_TICK = 0.3  # [1] length of the mark of a stop, relative to the radius of the arc
RANGE_POINTS = 33  # number of points of the line that is drawn as an arc


@dataclass(frozen=True, slots=True)
class JointRange:
    """The range of angles of a joint that has one stop or two.

    Attributes:
        low: joint_min [rad]; −∞ without this stop.
        high: joint_max [rad]; ∞ without this stop.
        length: the length of the joint's link [m].
    """

    low: float
    high: float
    length: float

    @property
    def arc(self) -> tuple[float, float]:
        """The angles [rad] of the arc's ends in a picture, from the previous link; for joint 1, from +x.

        The arc spans at most one turn, from ``low`` on.
        """
        low = self.low if math.isfinite(self.low) else self.high - OPEN_ANGLE
        high = self.high if math.isfinite(self.high) else self.low + OPEN_ANGLE
        return low, min(high, low + math.tau)


def ranges_of(values: Mapping[str, Any]) -> dict[int, JointRange]:
    """Return joint → its range, for the joints with stops; ``values`` has the parameters by name."""
    ranges = {}
    for joint in takewhile(lambda n: f"link[{n}].length" in values, count(1)):
        low, high = (values.get(f"link[{joint}].{stop}") for stop in STOPS)
        if low is not None or high is not None:
            ends = (-math.inf if low is None else low, math.inf if high is None else high)
            ranges[joint] = JointRange(*ends, values[f"link[{joint}].length"])
    return ranges


def is_scene_joint_stop(scene: Scene, wall: int) -> bool:
    """Return whether ``scene.wall_names[wall]`` is a stop of joints: joint_min or joint_max."""
    return is_joint_stop(wall, scene.wall_names, bool(scene.chain.stops))


def is_joint_stop(wall: int, wall_names: Sequence[str], has_stops: bool) -> bool:
    """Return whether ``wall_names[wall]`` is a stop of joints, joint_min or joint_max.

    If no joint has stops, the result is False: a real wall may then have the name of a stop.
    """
    return has_stops and wall_names[wall] in STOPS


def range_lines(points: np.ndarray, ranges: Mapping[int, JointRange]) -> Iterator[np.ndarray]:
    """Yield the lines that show the ranges of joints at one time: an arc per joint, a mark per stop.

    Args:
        points: positions of the points 0…N, shape (N+1, 2) [m].
        ranges: joint → range of the joint.
    """
    for joint, limits in ranges.items():
        centre = points[joint - 1]
        x, y = centre - points[joint - 2] if joint > 1 else (1.0, 0.0)
        link_angle, radius = math.atan2(y, x), RANGE_RADIUS * limits.length
        yield centre + radius * _directions(np.linspace(*limits.arc, RANGE_POINTS) + link_angle)
        for stop in (limits.low, limits.high):
            if math.isfinite(stop):
                ends = radius * np.array([[1.0 - 0.5 * RANGE_TICK], [1.0 + 0.5 * RANGE_TICK]])
                yield centre + ends * _directions(np.array([stop + link_angle]))


def _directions(angles: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def stop_mark(points: np.ndarray, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where a joint's link crosses the arc of the joint's range [m], and the link's unit vector.

    Args:
        points: positions of the points 0…N, shape (N+1, 2) [m].
        joint: the number of the joint, 1…N.
    """
    link = points[joint] - points[joint - 1]
    return points[joint - 1] + RANGE_RADIUS * link, link / np.hypot(*link)

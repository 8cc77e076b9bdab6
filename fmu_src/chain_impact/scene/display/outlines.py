"""The shapes that drawings show: outlines of links that have points besides their ends; a slider's rail.

The twin in JavaScript is pages/browser/scene/bodies.js.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from itertools import count, takewhile
from typing import Any

import numpy as np

from chain_impact.kernel.chain.inertia import corner_of_box
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.keys.chain_tables import BOX_CORNERS
from chain_impact.scene.texts.names import SLIDER_STOPS

CIRCLE_CORNERS = 24  # number of corners of the polygon that is drawn for each circle
# half the length of the drawn carriage, and half the length of the mark of a slider's stop, both divided by
# ``Rail.size``
STOP_MARK = 0.06
# on a side of the slider's line without a stop: length of the drawn line beyond the outermost position of the
# base, divided by ``Rail.size``
FREE_END = 0.12
# [1] corners of the drawn carriage relative to the base, shape (4, 2): coordinates along the slider's line
# and to the left of the line, divided by ``Rail.half``
CARRIAGE = np.array([[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]])
Disc = tuple[float, float, float]
"""A disc as three numbers [m]: the coordinates of the centre along a link and to the left of the link, from
the proximal end of the link; and the radius."""


def outline_of_discs(discs: Iterable[Disc]) -> np.ndarray:
    """Return the corners of the convex hull of discs, anticlockwise, shape (C, 2) [m] (Andrew, 1979).

    Each disc counts as a regular polygon with CIRCLE_CORNERS corners on its rim, or as a point if its radius
    is not > 0. A single point is its own hull.
    """
    turn = math.tau / CIRCLE_CORNERS
    rims = [
        (x + radius * math.cos(k * turn), y + radius * math.sin(k * turn))
        for x, y, radius in discs
        for k in range(CIRCLE_CORNERS if radius > 0.0 else 1)
    ]
    corners = sorted(set(rims))
    return np.array([*_half_hull(corners), *_half_hull(corners[::-1])] or corners)


def _half_hull(corners: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the corners of a convex hull, anticlockwise from the first to the last of ``corners``.

    ``corners`` are sorted by x, and by y for equal x, both rising or both falling. The result lacks the last
    corner, because the other half of the hull begins with it.
    """
    hull: list[tuple[float, float]] = []
    for x, y in corners:
        while len(hull) > 1:
            (a_x, a_y), (b_x, b_y) = hull[-2:]
            if (b_x - a_x) * (y - a_y) - (b_y - a_y) * (x - a_x) > 0.0:
                break
            hull.pop()
        hull.append((x, y))
    return hull[:-1]


def discs_of_links(values: Mapping[str, Any]) -> dict[int, list[Disc]]:
    """Return number of a link → discs of the points of this link, for each link with additional points.

    ``values`` has value by name of a parameter. The discs are in the order of the numbers of the points, so
    the corners of a box come first; these have the radius ``contact.radius``.
    """
    discs_of: dict[int, list[Disc]] = {}
    for link in takewhile(lambda n: f"link[{n}].length" in values, count(1)):
        discs: list[Disc] = []
        if (height := values.get(f"link[{link}].height")) is not None:
            length = values[f"link[{link}].length"]
            corners = (corner_of_box(n, length, height) for n in range(1, BOX_CORNERS + 1))
            discs = [(x, y, values.get("contact.radius", 0.0)) for x, y in corners]
        names = (f"link[{link}].point[{n}]" for n in count(len(discs) + 1))
        for point_name in takewhile(lambda site: f"{site}.x" in values, names):
            x, y, radius = (float(values[f"{point_name}.{key}"]) for key in ("x", "y", "radius"))
            discs.append((x, y, radius))
        if discs:
            discs_of[link] = discs
    return discs_of


def outlines_from(values: Mapping[str, Any], contact_points: Container[int]) -> dict[int, np.ndarray]:
    """Return number of a link → outline of the link, for each link that has additional points.

    An outline has the corners of a polygon, shape (C, 2) [m]: x along the link from its proximal end, y to
    the left.

    Args:
        values: name of a parameter → value.
        contact_points: the numbers of the points that can touch a wall. An end of a link has the radius
            ``contact.radius`` if its number is one of these, else 0.
    """
    radius, outlines = values.get("contact.radius", 0.0), {}
    for n, discs in discs_of_links(values).items():
        near_radius, far_radius = (radius if end in contact_points else 0.0 for end in (n - 1, n))
        outlines[n] = outline_of_discs(
            [(0.0, 0.0, near_radius), (float(values[f"link[{n}].length"]), 0.0, far_radius), *discs]
        )
    return outlines


def placed_corners(corners: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the positions in space, shape (C, 2) [m], of corners that are given in the axes of a link.

    Args:
        corners: x along the link from ``start``, and y to the left of the link, shape (C, 2) [m].
        start: position of the proximal end of the link, shape (2,) [m].
        end: position of the far end of the link, shape (2,) [m].
    """
    axis = (end - start) / np.hypot(*(end - start))
    return np.asarray(start + corners @ [axis, [-axis[1], axis[0]]])


def size_of_motion(points: np.ndarray) -> float:
    """Return the longer side [m] of the smallest rectangle along x and y that contains all ``points``.

    ``points`` are the positions of P points at T times, shape (T, P, 2) [m].
    """
    return float(np.ptp(points, axis=(0, 1)).max())


@dataclass(frozen=True, slots=True)
class Rail:
    """The line along which a base slides; a position on it is the signed distance [m] from ``origin``.

    Attributes:
        origin: the point of the line with the position 0, shape (2,) [m].
        angle: direction in which positions grow, from +x [rad].
        low: position of the stop ``slider_min`` [m]; −∞ without this stop.
        high: position of the stop ``slider_max`` [m]; ∞ without this stop.
        size: the result of ``size_of_motion`` for all points [m]; the lengths of the drawn carriage and of
            the marks of stops are in proportion to ``size``.
    """

    origin: np.ndarray
    angle: float
    low: float
    high: float
    size: float

    @classmethod
    def with_stops(
        cls, origin: np.ndarray, angle: float, low: float | None, high: float | None, size: float
    ) -> Rail:
        """Return the line with stops at ``low`` and ``high`` [m]; None stands for a stop that is missing."""
        ends = (-math.inf if low is None else low, math.inf if high is None else high)
        return cls(origin, angle, *ends, size)

    @property
    def direction(self) -> np.ndarray:
        """The unit vector along the rail in which the slider's position grows, shape (2,)."""
        return np.array([math.cos(self.angle), math.sin(self.angle)])

    @property
    def half(self) -> float:
        """Half the length of the carriage that is drawn [m]."""
        return STOP_MARK * self.size

    @property
    def stops(self) -> dict[str, HalfPlane]:
        """Name of each existing stop → the half-plane in which the drawn carriage lies.

        ``low`` and ``high`` are positions of the middle of the carriage, so the edge of a half-plane is half
        the length of the carriage beyond ``low`` or ``high``.
        """
        (x, y), start = self.direction, float(self.origin @ self.direction)
        low, high = start + self.low - self.half, start + self.high + self.half
        planes = (HalfPlane((x, y), low), HalfPlane((-x, -y), -high))
        stops = zip(SLIDER_STOPS, planes, strict=True)
        return {name: plane for name, plane in stops if math.isfinite(plane.offset)}

    def lines(self, bases: np.ndarray) -> list[np.ndarray]:
        """Return the line segments to draw: the slider's line, then a mark across it for each existing stop.

        Each segment is an array with the positions of its two ends, shape (2, 2) [m].

        Args:
            bases: the positions of the base at T times, shape (T, 2) [m]. On a side without a stop, the line
                ends FREE_END · ``size`` beyond the outermost of these positions.
        """
        axis, normal = self.direction, np.array([-math.sin(self.angle), math.cos(self.angle)])
        base_positions = (bases - self.origin) @ axis
        free_length = FREE_END * self.size
        ends = [
            (self.low - self.half, base_positions.min() - free_length),
            (self.high + self.half, base_positions.max() + free_length),
        ]
        positions = [
            self.origin + (stop if math.isfinite(stop) else free_end) * axis for stop, free_end in ends
        ]
        ticks = [
            end + self.half * np.array([-normal, normal])
            for end, (stop, _) in zip(positions, ends, strict=True)
            if math.isfinite(stop)
        ]
        return [np.array(positions), *ticks]

    def carriage(self, base: np.ndarray) -> np.ndarray:
        """Return the corners of the drawn carriage, shape (4, 2) [m], for a position of the base [m]."""
        axis, normal = self.direction, np.array([-math.sin(self.angle), math.cos(self.angle)])
        return np.asarray(base + self.half * CARRIAGE @ [axis, normal])


def rail_from(points: np.ndarray, positions: np.ndarray | None, values: Mapping[str, Any]) -> Rail | None:
    """Return the line of a slider.

    The result is None if ``values`` has no ``slider.angle`` and ``positions`` is None: then there is no
    slider, or the direction of its line is unknown.

    Args:
        points: the positions of all points at T times, the base first, shape (T, P, 2) [m].
        positions: the output ``slider.position`` at these times, shape (T,) [m]; None if it is unknown. The
            slider is then at the position 0 at the first time.
        values: name of a parameter → value.
    """
    bases = points[:, 0]
    if "slider.angle" in values:
        angle = float(values["slider.angle"])
    # without slider.angle, the line is taken to point from the base's position at the time of the least
    # ``slider.position`` to that at the time of the largest one
    elif positions is not None:
        x, y = bases[positions.argmax()] - bases[positions.argmin()]
        angle = math.atan2(y, x)
    else:
        return None
    axis = np.array([math.cos(angle), math.sin(angle)])
    first = 0.0 if positions is None else float(positions[0])
    stops = values.get("slider.min"), values.get("slider.max")
    return Rail.with_stops(bases[0] - first * axis, angle, *stops, size_of_motion(points))

"""The view, a rectangle, that a picture of a motion shows, and the walls near the motion.

A rectangle is given by its lower left and its upper right corner, shape (2, 2) [m].

The twins in JavaScript are pages/browser/recording/view.js, pages/browser/recording/free_region.js.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping
from typing import TypeVar

import numpy as np

from chain_impact.recording.recording import Recording
from chain_impact.scene.display.outlines import size_of_motion
from chain_impact.scene.half_planes import HalfPlane

# [1] a wall at a larger distance from the motion is not near; the distance is relative to the longer side of
# the rectangle around the motion
WALL_DISTANCE = 0.2
# [1] if walls enclose a room that ends within this distance from the motion, an animation shows the whole
# room; relative to the size of the motion
ROOM_DISTANCE = 1.0
FILM_MARGIN = 0.06  # [1] margin around the view of a film, relative to its longer side or LEAST_VIEW
LEAST_VIEW = 1e-6  # [m] least longer side of a view for which the margin of a film is computed
# a wall bounds the view along an axis if the component of its unit normal along this axis is larger than this
# in absolute value; the component's sign tells on which side
LEAST_NORMAL_COMPONENT = 0.5
# [1] points are drawn without circles if their largest radius is at most this, relative to the motion's size
LEAST_SEEN_RADIUS = 1e-3
# [1] two lengths are equal if their difference is at most this, relative to the link's length: round-off
SAME_LENGTH = 1e-9
PIN_HEIGHT = 0.08  # [1] height of the ground mark of a pinned base, relative to the size of the motion
# [1] corners of the ground mark's triangle, relative to the mark's height: the base is at (0, 0), y points to
# the ground
SUPPORT = np.array([[0.0, 0.0], [-0.4, 0.65], [0.4, 0.65], [0.0, 0.0]])
GROUND = np.array([[-0.75, 0.65], [0.75, 0.65]])
HATCHES = [np.array([[x, 0.65], [x + 0.25, 1.0]]) for x in (-0.7, -0.35, 0.0, 0.35)]
PIN_LINES = [SUPPORT, GROUND, *HATCHES]
# LONGEST_ARROW: in films and pages, length of the arrow of the largest force, relative to the shorter side of
# the view; DECADES: largest number of powers of ten on the ruler of forces
LONGEST_ARROW, DECADES = 0.26, 6
Key = TypeVar("Key", bound=Hashable)
"""The type of the keys of a dict of walls: a wall's name or, for a wall that moves, one key for each of
several positions."""


def pin_lines(points: np.ndarray) -> list[np.ndarray]:
    """Return the lines of the ground mark of a pinned base, a support on hatched ground, at the first time.

    If the mean height of all other points is below that of the base, the mark is above the base, else below.
    A mean is over all times.

    Args:
        points: positions of the points 0…N over time, shape (T, N+1, 2) [m].

    Returns:
        The lines, each of shape (n, 2) [m].
    """
    base = points[0, 0]
    side = 1.0 if points[:, 1:, 1].mean() < points[:, 0, 1].mean() else -1.0
    size = PIN_HEIGHT * size_of_motion(points)
    return [base + size * line * [1.0, side] for line in PIN_LINES]


def view_corners(
    points: np.ndarray,
    walls: Mapping[Key, HalfPlane],
    radius: float = 0.0,
    *,
    near_distance: float = WALL_DISTANCE,
    room: float = 0.0,
    is_pinned: bool = False,
) -> tuple[np.ndarray, dict[Key, HalfPlane]]:
    """Return the rectangle that a picture of a motion shows, and the walls near the motion.

    The rectangle contains the motion, the ground mark of a pinned base, and a part of each near wall. The
    size of the motion is the longer side of the rectangle around the points with their radius.

    Args:
        points: positions of the points, shape (T, N+1, 2) [m].
        walls: name → free side of a wall; a moving wall has one entry, with a name of its own, for each of
            several positions.
        radius: the radius of each point [m].
        near_distance: the largest distance of a near wall from the motion, relative to the size of the
            motion. A wall that a part of the motion is beyond by more than this size is not near.
        room: a distance, relative to the size of the motion. If the walls enclose a room that ends within
            this distance of the motion, the rectangle contains the whole room, and all walls are near. If
            ``room`` is 0, no room is looked for.
        is_pinned: whether the base has a ground mark, which moves with the base.

    Returns:
        The rectangle, and the near walls.
    """
    reach = np.array([points.min(axis=(0, 1)) - radius, points.max(axis=(0, 1)) + radius])
    width = np.ptp(reach, axis=0).max()
    shown_points = np.concatenate(reach[:, None])
    if is_pinned:
        ways = points[:, 0] - points[0, 0]
        lines = [line + way for line in pin_lines(points) for way in (ways.min(axis=0), ways.max(axis=0))]
        shown_points = np.concatenate([shown_points, *lines])
    if corners := enclosure_of(walls, reach + room * width * np.array([[-1.0], [1.0]])) if room else []:
        shown_points = np.concatenate([shown_points, corners])
    view, visible_walls = (
        np.array([shown_points.min(axis=0), shown_points.max(axis=0)]),
        dict(walls) if corners else {},
    )
    for name, wall in () if corners else walls.items():
        # the corner of the rectangle around the motion that has the least clearance from the wall
        corner = np.where(np.array(wall.normal) > 0.0, *reach)
        gap = wall.clearance(*corner)
        if -width <= gap <= near_distance * width:
            met_point = corner - max(0.0, gap) * np.array(wall.normal)
            view = np.array([np.minimum(view[0], met_point), np.maximum(view[1], met_point)])
            visible_walls[name] = wall
    return view, visible_walls


def film_view(
    points: np.ndarray, walls: Mapping[str, HalfPlane], radius: float, *, is_pinned: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the view of a film: the rectangle of ``view_corners`` with ROOM_DISTANCE, and a margin.

    Returns:
        The view with its margin, and ``anchor_of`` the near walls.
    """
    view, near_walls = view_corners(points, walls, radius, room=ROOM_DISTANCE, is_pinned=is_pinned)
    margin = FILM_MARGIN * max(np.ptp(view, axis=0).max(), LEAST_VIEW)
    return view + margin * np.array([[-1.0], [1.0]]), anchor_of(near_walls.values())


def anchor_of(walls: Iterable[HalfPlane]) -> np.ndarray:
    """Return, for x and for y, the fraction of an extension of a view that goes to the left or down.

    It is 1 if only this side has no wall, 0 if only the opposite side has none, 0.5 if both sides have a
    wall, or none.
    """
    open_sides = _open_sides(walls)
    shares: np.ndarray = 0.5 + 0.5 * (open_sides[0] - open_sides[1])
    return shares


def has_open_side(walls: Iterable[HalfPlane]) -> np.ndarray:
    """Return, for x and for y, whether at least one of the two sides of a view has no wall."""
    is_open: np.ndarray = _open_sides(walls).max(axis=0) > 0.0
    return is_open


def _open_sides(walls: Iterable[HalfPlane]) -> np.ndarray:
    """Return 1 for a side without a wall, else 0: [[left, below], [right, above]]."""
    open_sides: np.ndarray = np.ones((2, 2))
    for wall in walls:
        normal = np.array(wall.normal)
        open_sides[0][normal > LEAST_NORMAL_COMPONENT] = open_sides[1][normal < -LEAST_NORMAL_COMPONENT] = 0.0
    return open_sides


def positions_of(recording: Recording) -> np.ndarray:
    """Return the positions of all points and, if there is a carriage, of its corners, shape (T, M, 2) [m]."""
    if recording.rail is None:
        return recording.all_points
    corners = recording.rail.carriage(np.zeros(2))
    return np.concatenate([recording.all_points, recording.points[:, :1] + corners], axis=1)


def radius_of(recording: Recording) -> float:
    """Return the largest radius [m] of the points that can touch.

    The result is 0 if no point can touch, or if the radius is too small to be seen (LEAST_SEEN_RADIUS).
    """
    radius = max(recording.touching_radii.values(), default=0.0)
    return radius if radius > LEAST_SEEN_RADIUS * size_of_motion(recording.all_points) else 0.0


def enclosure_of(walls: Mapping[Key, HalfPlane], view: np.ndarray) -> list[np.ndarray]:
    """Return the corners of the free region between walls, if all of it lies inside a rectangle; else [].

    Args:
        walls: name → free side.
        view: the rectangle.
    """
    corners = free_region_within(walls.values(), view)
    is_inside = all(((view[0] < corner) & (corner < view[1])).all() for corner in corners)
    return corners if is_inside else []


def free_region_within(walls: Iterable[HalfPlane], view: np.ndarray) -> list[np.ndarray]:
    """Return the corners of the part of the rectangle ``view`` on the free sides of all walls; [] if none."""
    corners = [view[[i, j], [0, 1]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for wall in walls:
        corners = list(_clipped(corners, wall))
    return corners


def _clipped(corners: list[np.ndarray], wall: HalfPlane) -> Iterator[np.ndarray]:
    """Yield the corners of the part of a polygon on a wall's free side (Sutherland & Hodgman, 1974)."""
    clearances = [wall.clearance(*corner) for corner in corners]
    for k, (polygon_corner, gap) in enumerate(zip(corners, clearances, strict=True)):
        clearance_before = clearances[k - 1]
        if clearance_before * gap < 0.0:
            yield corners[k - 1] + clearance_before / (clearance_before - gap) * (
                polygon_corner - corners[k - 1]
            )
        if gap >= 0.0:
            yield polygon_corner


def ball_of(recording: Recording) -> int | None:
    """Return the number (0 or 1) of the point at the centre of a ball; None if the chain is no ball.

    A ball is a free chain of one link that has no points except its two ends. Exactly one end can touch.
    Either this end is the centre of mass, or the end's radius is at least the length of the link, so that the
    circle around the end contains the link.
    """
    if recording.link_count != 1 or recording.pinned or recording.rail or recording.outlines:
        return None
    if len(recording.touching_radii) != 1:
        return None
    ((end, radius),) = recording.touching_radii.items()
    length = float(np.hypot(*(recording.points[0, 1] - recording.points[0, 0])))
    centre = float(recording.parameters.get("link[1].center_of_mass", np.nan))
    offset = float(recording.parameters.get("link[1].center_of_mass_offset", 0.0))
    is_centre = np.hypot(centre - end * length, offset) <= SAME_LENGTH * length
    return end if is_centre or radius >= length * (1.0 - SAME_LENGTH) else None

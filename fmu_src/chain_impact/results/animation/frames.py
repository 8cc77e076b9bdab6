"""The motion that an animation shows: a recording at the times of its frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from chain_impact.results.animation.contacts import Contact, contacts, slow_spans, stop_moments, wall_forces
from chain_impact.results.animation.pacing import IMPACT_TIME, frame_times
from chain_impact.results.joint_stops import JointRange
from chain_impact.results.recording import Recording
from chain_impact.results.stick_slip import friction_columns
from chain_impact.results.view import ROOM, pin_mark, seen
from chain_impact.scene.half_planes import HalfPlane

ENERGIES = ("kinetic", "potential", "elastic", "dissipated", "friction", "supplied", "total")
NUMBERS = 2_000_000  # coordinates in an animation at most: a long chain has fewer frames
FEWEST = 200  # frames, however long the chain
MARGIN = 0.06  # of the size of what is seen, around it
LEAST = 1e-6  # m, size of a motion that does not move
UPRIGHT = 0.5  # of a wall's normal along an axis, from which the wall bounds the view along it
ALONE = 1e-3  # of the size of the motion: a smaller radius is not drawn


@dataclass(frozen=True)
class Motion:
    """What there is to see in an animation.

    Attributes:
        name: the model's name.
        time: simulated time of each frame, shape (F,) [s].
        frame_rate: frames in a second on the screen, at the speed 1.
        points: positions of the points 0…N, shape (F, N+1, 2) [m].
        forces: (point, wall) → force over the frames, shape (F,) [N], of the pairs that touch.
        moments: (joint, stop) → size of the moment over the frames, shape (F,) [N·m], of those that touch.
        stops: the joints with stops, and their ranges.
        energies: name → over the frames, shape (F,) [J].
        contacts: in order of their onset.
        walls: name → free side.
        view: lower left and upper right corner of what is to be seen, shape (2, 2) [m].
        anchor: where there is more room than for the view, how much of it lies left of it and below, 0…1.
        radius: of the points that can touch [m].
        pin: the lines of a pinned base's ground mark, each of shape (n, 2) [m]; none of a base that moves.
        friction: (point, wall) → dry friction over the frames, along t = (n_y, −n_x), shape (F,) [N].
        sticking: (point, wall), or (joint, "") → whether it sticks in each frame, shape (F,).
    """

    name: str
    time: np.ndarray
    frame_rate: float
    points: np.ndarray
    forces: dict[tuple[int, str], np.ndarray]
    moments: dict[tuple[int, str], np.ndarray]
    stops: Mapping[int, JointRange]
    energies: dict[str, np.ndarray]
    contacts: list[Contact]
    walls: Mapping[str, HalfPlane]
    view: np.ndarray
    anchor: tuple[float, float]
    radius: float
    pin: list[np.ndarray]
    friction: dict[tuple[int, str], np.ndarray] = field(default_factory=dict)
    sticking: dict[tuple[int, str], np.ndarray] = field(default_factory=dict)

    @property
    def touching(self) -> list[int]:
        """The points that touch a wall."""
        contacts = {contact.point for contact in self.contacts if contact.arm is None}
        return sorted({point for point, _ in self.forces} | contacts)


def motion_of(recording: Recording, impact_time: float = IMPACT_TIME) -> Motion:
    """The motion in a recording, at frames that are close in time where it is shown slowly.

    Args:
        recording: what to show.
        impact_time: what an impact takes on the screen [s], 0 for no slow motion.
    """
    found = contacts(recording)
    links = recording.points.shape[1]
    most = max(FEWEST, NUMBERS // (2 * links))
    spans = slow_spans([((c.onset, c.impact_end), c.end_speed) for c in found if c.end_speed is not None])
    start, stop = (float(recording.time[row]) for row in (0, -1))
    time, frame_rate = frame_times(start, stop, spans, impact_time, most)

    def at_frames(column: np.ndarray) -> np.ndarray:
        return np.asarray(np.interp(time, recording.time, column))

    rows = np.searchsorted(recording.time, time, side="right") - 1
    points = np.stack(
        [
            np.stack([at_frames(recording.columns[f"point[{k}].{axis}"]) for axis in "xy"], axis=-1)
            for k in range(links)
        ],
        axis=1,
    )
    energies = {name: recording.columns.get(f"energy.{name}") for name in ENERGIES}
    radius = _radius(recording)
    view, anchor = _view(points, recording.walls, radius)
    return Motion(
        name=recording.name,
        time=time,
        frame_rate=frame_rate,
        points=points,
        forces={(k, wall): at_frames(f) for k, wall, f in wall_forces(recording) if (f > 0.0).any()},
        moments={(i, stop): at_frames(m) for i, stop, m in stop_moments(recording) if (m > 0.0).any()},
        stops=recording.stops,
        energies={name: at_frames(e) for name, e in energies.items() if e is not None and e.any()},
        contacts=found,
        walls=recording.walls,
        view=view,
        anchor=anchor,
        radius=radius,
        pin=pin_mark(recording.points),
        friction={
            at: at_frames(force)
            for at, force in friction_columns(recording.columns, "friction_force").items()
        },
        sticking={
            at: held > 0.0
            for at, column in friction_columns(recording.columns, "sticking").items()
            if (held := column[rows]).any()
        },
    )


def _radius(recording: Recording) -> float:
    """The radius of the points that can touch [m]: how far a point is from a wall that it touches."""
    for point, wall, force in wall_forces(recording):
        for row in np.flatnonzero(force > 0.0)[:1]:
            x, y = (recording.columns[f"point[{point}].{axis}"][row] for axis in "xy")
            depth = recording.columns.get(f"contact[{point}].{wall}.penetration", np.zeros(row + 1))[row]
            radius = recording.walls[wall].clearance(float(x), float(y)) + float(depth)
            return radius if radius > ALONE * np.ptp(recording.points, axis=(0, 1)).max() else 0.0
    return 0.0


def _view(
    points: np.ndarray, walls: Mapping[str, HalfPlane], radius: float
) -> tuple[np.ndarray, tuple[float, float]]:
    """The corners of what is to be seen: the motion, the walls near it, a closed room; and the ``anchor``."""
    view, near = seen(points, walls, radius, ROOM)
    open_sides = np.ones((2, 2))  # left and below, right and above
    for wall in near:
        normal = np.array(wall.normal)
        open_sides[0][normal > UPRIGHT] = open_sides[1][normal < -UPRIGHT] = 0.0
    margin = MARGIN * max(np.ptp(view, axis=0).max(), LEAST)
    # what is left of room goes to the side without a wall
    below = 0.5 + 0.5 * (open_sides[0] - open_sides[1])
    return view + margin * np.array([[-1.0], [1.0]]), (float(below[0]), float(below[1]))

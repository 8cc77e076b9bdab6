"""A recording: what an FMU or `simulate()` gave over time, under the FMU's variable names."""

from __future__ import annotations

import csv
import math
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from errno import EIO
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.results.equality import same
from chain_impact.results.impacts import impacts_of, names_of
from chain_impact.results.joint_stops import JointRange, touching_place
from chain_impact.results.sensitivity import Sensitivities
from chain_impact.results.stick_slip import NO_PHASES
from chain_impact.results.summary import plural
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.names import STOPS

ROWS_AT_ONCE = 10_000  # that are written
NO_STOPS: Mapping[int, JointRange] = {}


@dataclass(frozen=True, slots=True)
class Impact:
    """The onset of one contact.

    Attributes:
        time: of the onset [s].
        point: 0…N.
        wall: name of the wall.
        speed: normal approach speed [m/s].
        end: of the contact [s]; NaN if it is unknown, or of one that lasts.
        peak_force: the largest force [N], 0 for an impulse of a rigid wall; NaN if it is unknown.
        arm: at a stop of a joint, the length of the joint's link [m]; None at a wall. The point is the
            joint there, 1…N, the speed is in rad/s, the peak force is a moment in N·m, and the penetration
            is an angle in rad.
        max_penetration: the largest penetration [m], 0 at a rigid wall; NaN if it is unknown.
    """

    time: float
    point: int
    wall: str
    speed: float
    end: float = field(default=math.nan, compare=False)
    peak_force: float = field(default=math.nan, compare=False)
    arm: float | None = field(default=None, compare=False)
    max_penetration: float = field(default=math.nan, compare=False)

    @property
    def at_stop(self) -> bool:
        """Whether it is at a stop of a joint."""
        return self.arm is not None

    @property
    def end_speed(self) -> float:
        """The speed [m/s]; at a stop that of the link's end about the joint, so that all can be compared."""
        return self.speed * (1.0 if self.arm is None else self.arm)


@dataclass(frozen=True, repr=False, eq=False)
class Recording:
    """A simulation over time, of a scene or an FMU.

    Attributes:
        name: the model's name.
        time: communication points, shape (T,) [s].
        columns: FMU variable name → values, shape (T,).
        impacts: in order of time; of an FMU, those that its outputs have shown.
        walls: name → free side of the walls that are there.
        parameters: FMU variable name → value at the start, of a choice its name; none where they are unknown.
        sensitivities: the derivatives that were asked for, if any.
        stops: the joints with stops, and their ranges.
        stop_law: the contact law of the stops, if the scene names one in `stops.model`; "" if it names none,
            or if that is unknown, as of an FMU.
        stick_slip: the phases of dry friction, see ``STICK_SLIP_DTYPE``; of an FMU to within a communication
            step.
        wall_names: the names of all walls, by the numbers in ``stick_slip``.
    """

    __eq__ = same
    __hash__ = None  # type: ignore[assignment]

    name: str
    time: np.ndarray
    columns: dict[str, np.ndarray]
    impacts: list[Impact]
    walls: dict[str, HalfPlane]
    parameters: dict[str, Any] = field(default_factory=dict)
    sensitivities: Sensitivities | None = None
    stops: dict[int, JointRange] = field(default_factory=dict)
    stop_law: str = ""
    stick_slip: np.ndarray = field(default_factory=lambda: NO_PHASES)
    wall_names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """What it is of, and how much there is."""
        end = f"{self.time[-1]:g}" if len(self.time) else "0"
        return (
            f"Recording({self.name})  0 … {end} s, {plural(self.impact_count, 'impact')}, "
            f"{plural(len(self.time), 'row')} of {plural(len(self.columns), 'column')}"
        )

    @property
    def impact_count(self) -> int:
        """How many impacts there were, listed or not."""
        counted = self.columns.get("impact.count", np.zeros(1))
        return max(len(self.impacts), int(counted[-1]))

    @property
    def points(self) -> np.ndarray:
        """Positions of the points 0…N, shape (T, N+1, 2) [m]."""
        count = sum(name.startswith("point[") and name.endswith("].x") for name in self.columns)
        return np.stack(
            [np.stack([self.columns[f"point[{k}].{axis}"] for axis in "xy"], axis=-1) for k in range(count)],
            axis=1,
        )

    def point_at(self, point: int, time: float) -> tuple[float, float]:
        """Position [m] of a point at a time [s], interpolated between communication points."""
        x, y = (np.interp(time, self.time, self.columns[f"point[{point}].{axis}"]) for axis in "xy")
        return float(x), float(y)

    def pose_at(self, time: float) -> np.ndarray:
        """Positions of the points in the row nearest to a time [s], shape (N+1, 2) [m].

        Between rows a link is not straight: interpolated, it would be too short.
        """
        pose: np.ndarray = self.points[int(np.abs(self.time - time).argmin())]
        return pose

    def spot(self, impact: Impact) -> tuple[float, float]:
        """Where [m] an impact hit its wall, a radius away from the point; of a stop, its mark."""
        if impact.at_stop:
            x, y = touching_place(self.pose_at(impact.time), impact.point)[0]
            return float(x), float(y)
        x, y = self.point_at(impact.point, impact.time)
        wall = self.walls[impact.wall]
        gap, (nx, ny) = wall.clearance(x, y), wall.normal
        return x - gap * nx, y - gap * ny

    def save_csv(self, path: Path) -> None:
        """Write time and columns as CSV, numbers in full precision."""
        with written_whole(path) as fresh, fresh.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["time", *self.columns])
            columns = [self.time, *self.columns.values()]
            for start in range(0, max(map(len, columns)), ROWS_AT_ONCE):  # lists take four times the room
                values = (column[start : start + ROWS_AT_ONCE].tolist() for column in columns)
                writer.writerows(zip(*values, strict=True))


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Yield a path to write to; what is written there appears at ``path`` when it is whole, or not at all."""
    try:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            yield path  # /dev/stdout and its like cannot be replaced
            return
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as scratch:
            fresh = Path(scratch, path.name)
            yield fresh
            fresh.replace(path)
    except OSError as error:
        if error.filename and f".{path.name}-" not in str(error.filename):
            raise
        # the user knows nothing of the scratch folder, and some libraries give no number
        raise type(error)(error.errno or EIO, error.strerror or str(error), str(path)) from None


def impacts_from_outputs(
    record: Any, walls: Sequence[str], stops: Mapping[int, JointRange] = NO_STOPS
) -> list[Impact]:
    """The impacts that a record of an FMU's outputs shows, with its walls' names by their numbers.

    From an FMU with `outputs.impacts = 0` it is only the last one in each communication step.
    """
    if "impact[1].time" in names_of(record):
        return impact_list(impacts_of(record), walls, stops)
    rows = np.flatnonzero(np.diff(record["impact.count"], prepend=0))
    last = {name: record[f"impact.last_{name}"] for name in ("time", "point", "wall", "speed")}
    found = []
    for row in rows:
        point, wall = int(last["point"][row]), walls[int(last["wall"][row]) - 1]
        arm = _arm(point, wall, stops)
        found.append(Impact(float(last["time"][row]), point, wall, float(last["speed"][row]), arm=arm))
    return found


def _arm(point: int, wall: str, stops: Mapping[int, JointRange]) -> float | None:
    """See ``Impact.arm``."""
    return stops[point].length if wall in STOPS and point in stops else None


def impact_list(table: np.ndarray, walls: Sequence[str], stops: Mapping[int, JointRange]) -> list[Impact]:
    """The impacts of a table as `Result.impacts`, with the names of the walls, and the joints with stops."""
    return [
        Impact(
            time=float(row["onset"]),
            point=int(row["point"]),
            wall=walls[row["wall"]],
            speed=float(row["impact_speed"]),
            end=float(row["end"]),
            peak_force=float(row["peak_force"]),
            arm=_arm(int(row["point"]), walls[row["wall"]], stops),
            max_penetration=float(row["max_penetration"]),
        )
        for row in table
    ]

"""A recording: what an FMU or `simulate()` gave over time, under the FMU's variable names."""

from __future__ import annotations

import csv
import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from errno import EIO
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.results.impacts import impacts_of, names_of
from chain_impact.results.sensitivity import Sensitivities
from chain_impact.results.summary import plural
from chain_impact.scene.half_planes import HalfPlane

ROWS_AT_ONCE = 10_000  # that are written


@dataclass(frozen=True, slots=True)
class Impact:
    """The onset of one contact.

    Attributes:
        time: of the onset [s].
        point: 0…N.
        wall: name of the wall.
        speed: normal approach speed [m/s].
        end: of the contact [s]; NaN if it is unknown, or of one that lasts.
        peak_force: the largest force [N], infinite between rigid walls; NaN if it is unknown.
    """

    time: float
    point: int
    wall: str
    speed: float
    end: float = field(default=math.nan, compare=False)
    peak_force: float = field(default=math.nan, compare=False)


@dataclass(frozen=True, repr=False)
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
    """

    name: str
    time: np.ndarray
    columns: dict[str, np.ndarray]
    impacts: list[Impact]
    walls: dict[str, HalfPlane]
    parameters: dict[str, Any] = field(default_factory=dict)
    sensitivities: Sensitivities | None = None

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

    def spot(self, impact: Impact) -> tuple[float, float]:
        """Where [m] an impact hit its wall, at a distance of the radius from the point."""
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


def impacts_from_outputs(record: Any, walls: Sequence[str]) -> list[Impact]:
    """The impacts that a record of an FMU's outputs shows, with its walls' names by their numbers.

    From an FMU with `outputs.impacts = 0` it is only the last one in each communication step.
    """
    if "impact[1].time" in names_of(record):
        return impact_list(impacts_of(record), walls)
    rows = np.flatnonzero(np.diff(record["impact.count"], prepend=0))
    return [
        Impact(
            time=float(record["impact.last_time"][row]),
            point=int(record["impact.last_point"][row]),
            wall=walls[int(record["impact.last_wall"][row]) - 1],
            speed=float(record["impact.last_speed"][row]),
        )
        for row in rows
    ]


def impact_list(table: np.ndarray, walls: Sequence[str]) -> list[Impact]:
    """The impacts of a table as `Result.impacts`, with the names of the walls."""
    return [
        Impact(
            time=float(row["onset"]),
            point=int(row["point"]),
            wall=walls[row["wall"]],
            speed=float(row["impact_speed"]),
            end=float(row["end"]),
            peak_force=float(row["peak_force"]),
        )
        for row in table
    ]

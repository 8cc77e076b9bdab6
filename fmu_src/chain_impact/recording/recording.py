"""A recording: the outputs of an FMU or of `simulate()` over time, as arrays by the FMU's variable names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import chain, count, takewhile
from pathlib import Path
from typing import Any, Self

import numpy as np

from chain_impact.recording.bodies import site_radii
from chain_impact.recording.equality import have_equal_fields
from chain_impact.recording.impact_texts import touching_part_name
from chain_impact.recording.impacts import NO_IMPACTS
from chain_impact.recording.interactions import (
    WALL,
    Interaction,
    contacts_in,
    friction_of,
    interactions_in_joints,
)
from chain_impact.recording.joint_stops import JointRange, is_joint_stop
from chain_impact.recording.older_names import OlderNames
from chain_impact.recording.recorded_attributes import RecordedAttributes
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.recording.stick_slip import NO_PHASES
from chain_impact.recording.tables import save_columns, save_impacts
from chain_impact.scene.display.outlines import Rail, outlines_from, rail_from
from chain_impact.scene.errors import names_matching
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.texts.names import AXES, SLIDER_STOPS, grouped_by_owner
from chain_impact.text import count_text
from chain_impact.variables.output_hints import output_hint


class Recording(RecordedAttributes, OlderNames):
    """A simulation over time, of a scene or of an FMU: a ``Result``, or stored data.

    The call ``Recording(name, time, columns, …)`` makes a recording that stores its arguments: the attributes
    of ``RecordedAttributes``, in this order or by name. Attributes that are left out are empty.
    """

    __eq__ = have_equal_fields
    __hash__ = None  # type: ignore[assignment]

    def __new__(cls, *_arguments: Any, **_named: Any) -> Self:
        """Return a new recording: a ``StoredRecording`` if the class ``Recording`` itself is called."""
        return object.__new__(StoredRecording if cls is Recording else cls)  # type: ignore[return-value]

    def __init__(self, *_arguments: Any, **_named: Any) -> None:
        """Refuse to make an object of a subclass of ``Recording`` that stores no attributes.

        A class that stores them must derive from ``StoredRecording``.
        """
        raise TypeError(f"{type(self).__name__} stores no attributes: derive it from StoredRecording")

    @cached_property
    def _quantities(self) -> dict[tuple[str, int, str], dict[str, np.ndarray]]:
        """The columns by (owner, number, name of a wall or signal), and then by quantity."""
        return grouped_by_owner(self.columns)

    def columns_of(self, owner: str) -> dict[tuple[int, str], dict[str, np.ndarray]]:
        """Return the columns of owners of a kind, such as ``contact``: (number, name) → quantity → values.

        The number is that of the point, joint or link, or 0 for an owner without a number. The name is that
        of the wall or the signal, or "" for an owner without a name.
        """
        return {
            (n, wall): quantities for (kind, n, wall), quantities in self._quantities.items() if kind == owner
        }

    @property
    def duration(self) -> float:
        """The time from the first row to the last row [s]."""
        return float(self.time[-1] - self.time[0])

    @cached_property
    def link_count(self) -> int:
        """The number N of links: the largest number of a link or joint in the names of columns.

        If no column is of a link or joint, all points count as link ends: N is the number of points minus 1.
        """
        numbers = [n for owner in ("link", "joint") for n, _ in self.columns_of(owner)]
        return max(numbers, default=self.all_points.shape[1] - 1)

    @property
    def points(self) -> np.ndarray:
        """Positions of the points 0…N, the ends of the links, shape (T, N+1, 2) [m]."""
        return self.all_points[:, : self.link_count + 1]

    @property
    def sites(self) -> np.ndarray:
        """Positions of the points that are not link ends, numbered from N + 1, shape (T, P, 2) [m]."""
        return self.all_points[:, self.link_count + 1 :]

    @cached_property
    def all_points(self) -> np.ndarray:
        """Positions of the points by their numbers, up to the first unknown one, shape (T, N+1+P, 2) [m]."""
        points = self.columns_of("point")
        complete_points = takewhile(
            lambda number: points.get(number, {}).keys() >= {"x", "y"}, ((k, "") for k in count())
        )
        point_arrays = [
            np.stack([points[number][axis] for axis in "xy"], axis=-1) for number in complete_points
        ]
        return np.stack(point_arrays, axis=1) if point_arrays else np.zeros((len(self.time), 0, 2))

    def output_hint(self, name: str) -> str | None:
        """Return a hint if ``name``, which no column has, is an input or a parameter; else None."""
        return output_hint(name, self.inputs, self.parameters)

    def row_of_other_run(self, values: Mapping[str, Any], time: float) -> Recording | None:  # noqa: ARG002
        """Return the row at a time [s] of a run with other values of parameters; None if that is unknown."""
        return None

    @property
    def points_through_walls(self) -> list[str]:
        """Sentences on points that pass through walls without touching them; empty if this is unknown."""
        return []

    def walls_at(self, time: float) -> dict[str, HalfPlane]:
        """Return name → free side of each wall, in its position at a time [s]."""
        walls = dict(self.walls)
        for name, wall_motion in self.moved_walls.items():
            wall = walls[name]
            walls[name] = replace(wall, offset=wall.offset + float(np.interp(time, self.time, wall_motion)))
        return walls

    def sides_at(self, time: float) -> dict[str, HalfPlane]:
        """Return name → free side of each wall and each drawn stop of a slider at a time [s]."""
        return self.walls_at(time) | (self.rail.stops if self.rail else {})

    @cached_property
    def moved_walls(self) -> dict[str, np.ndarray]:
        """Name → displacement along the normal, shape (T,) [m], for each wall with a column of it."""
        columns = {name: self.columns.get(f"wall.{name}.position") for name in self.walls}
        return {name: wall_motion for name, wall_motion in columns.items() if wall_motion is not None}

    @cached_property
    def pinned(self) -> bool:
        """Whether the base is pinned, so that link 1 turns about joint 1; an input may move a pinned base.

        The columns tell whether joint 1 exists. If there are no columns of any joint, a base without a
        slider counts as pinned if there are several rows, and its position is the same in all rows, or
        unknown.
        """
        joints, bases = self.columns_of("joint"), self.points[:, :1]
        if self.rail is not None:
            return False
        return (1, "") in joints if joints else len(bases) > 1 and bool((bases == bases[0]).all())

    @cached_property
    def rail(self) -> Rail | None:
        """The line of a sliding base; None for another base."""
        return rail_from(self.all_points, self.columns.get("slider.position"), self.parameters)

    @cached_property
    def outlines(self) -> dict[int, np.ndarray]:
        """Number of a link with points → its outline in the link's axes, shape (C, 2) [m].

        Points are those other than the link's ends. The dict is empty if the parameters do not tell their
        positions.
        """
        return outlines_from(self.parameters, self.touching_radii)

    @cached_property
    def touching_radii(self) -> dict[int, float]:
        """Number of each point whose force at a wall is recorded → its radius [m], 0 if unknown."""
        radius, radii = float(self.parameters.get("contact.radius", 0.0)), site_radii(self.parameters)
        points = sorted({interaction.point for interaction in self.interactions if interaction.kind == WALL})
        radius_of = dict(enumerate(radii, self.link_count + 1))
        return {point: radius_of.get(point, radius) for point in points}

    @property
    def knows_points(self) -> bool:
        """Whether the positions of the points are known."""
        return bool(self.all_points.size)

    @property
    def energies(self) -> Mapping[str, np.ndarray]:
        """Name of a known energy, such as kinetic → its values, shape (T,) [J]."""
        return self.columns_of("energy").get((0, ""), {})

    @property
    def detailed_energies(self) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """Times [s], shape (T,), and ``energies`` at these times; a subclass may have times between rows."""
        return self.time, self.energies

    @cached_property
    def joint_forces(self) -> dict[int, np.ndarray]:
        """Joint i with a known force → the force on link i at this joint, x and y, shape (T, 2) [N]."""
        return {
            joint: np.stack([parts[f"force.{axis}"] for axis in AXES], axis=-1)
            for (joint, _), parts in self.columns_of("joint").items()
            if parts.keys() >= {"force.x", "force.y"}
        }

    @cached_property
    def knows_joint_forces(self) -> bool:
        """Whether any impact has a known largest force in a joint, which needs the outputs ``loads``."""
        return bool(np.isfinite(self.impacts["joint_force"]).any())

    @cached_property
    def interactions(self) -> list[Interaction]:
        """The known contacts at walls and stops, and joints and sliders with dry friction, over time."""
        stops = SLIDER_STOPS if self._has_slider else ()
        return [
            *contacts_in(self.columns_of("contact"), stops),
            *interactions_in_joints(self.columns_of("joint")),
            *friction_of(0, self.columns_of("slider").get((0, ""), {}), "friction_force"),
        ]

    @property
    def contact_forces(self) -> dict[tuple[int, str], np.ndarray | None]:
        """(Point or joint, name of the wall or stop) → the force [N] or moment [N·m] there, shape (T,).

        Dry friction in a joint or on a slider has the name "" and the force None.
        """
        return {(interaction.point, interaction.wall): interaction.force for interaction in self.interactions}

    def __repr__(self) -> str:
        """Return the name, the end time [s], and the numbers of impacts, rows and columns."""
        end_text = f"{self.time[-1]:g}" if len(self.time) else "0"
        return (
            f"Recording({self.name})  0 … {end_text} s, {count_text(self.impact_count, 'impact')}, "
            f"{count_text(len(self.time), 'row')} of {count_text(len(self.columns), 'column')}"
        )

    @property
    def impact_count(self) -> int:
        """The number of impacts, also of impacts that an FMU did not list."""
        counts = self.columns.get("impact.count", np.zeros(1))
        return max(len(self.impacts), int(counts[-1]))

    def is_joint_stop(self, wall: int) -> bool:
        """Return whether ``wall_names[wall]`` is a stop of joints: joint_min or joint_max."""
        return is_joint_stop(wall, self.wall_names, bool(self.stops))

    def touching_part(self, impact: np.void) -> str:
        """Return words for what touches in an impact: "point 2", "point 5 (heel)", "joint 2" or "slider"."""
        wall = self.wall_names[impact["wall"]]
        stop = wall if self._is_slider_stop(wall) or self.is_joint_stop(impact["wall"]) else ""
        return touching_part_name(int(impact["point"]), stop, self.point_names)

    def _is_slider_stop(self, wall: str) -> bool:
        """Return whether ``wall`` is a stop of a slider; without a slider, a wall may have such a name."""
        return self._has_slider and wall in SLIDER_STOPS

    @property
    def _has_slider(self) -> bool:
        """Whether the base is on a slider."""
        return "slider.angle" in self.parameters or "slider.position" in self.columns

    @cached_property
    def is_at_joint_stop(self) -> np.ndarray:
        """Whether each impact is at a stop of a joint, shape (I,)."""
        return np.array([self.is_joint_stop(wall) for wall in self.impacts["wall"]], bool)

    @cached_property
    def linear_impact_speeds(self) -> np.ndarray:
        """The impact speeds, shape (I,) [m/s]; at a joint's stop the angular speed times the link length."""
        arms = [
            self.stops[point].length if is_at_stop else 1.0
            for point, is_at_stop in zip(self.impacts["point"].tolist(), self.is_at_joint_stop, strict=True)
        ]
        speeds: np.ndarray = self.impacts["impact_speed"] * np.array(arms)
        return speeds

    def with_rows(self, rows: np.ndarray) -> Recording:
        """Return the recording with the rows of the given indices only, without derivatives.

        All impacts stay.
        """
        parts = {field.name: getattr(self, field.name) for field in fields(StoredRecording)}
        columns = {name: values[rows] for name, values in self.columns.items()}
        parts |= {"time": self.time[rows], "columns": columns, "sensitivities": None}
        return StoredRecording(**parts)

    def point_at(self, point: int, time: float) -> np.ndarray:
        """Return the position [m] of a point at a time [s], interpolated between rows, shape (2,)."""
        return np.array([np.interp(time, self.time, self.all_points[:, point, axis]) for axis in (0, 1)])

    def pose_at(self, time: float) -> np.ndarray:
        """Return the positions of points 0…N in the row nearest to a time [s], shape (N+1, 2) [m].

        They are not interpolated between rows, because interpolation would shorten the links.
        """
        pose: np.ndarray = self.points[self.row_at(time)]
        return pose

    def row_at(self, time: float) -> int:
        """Return the index of the row that is nearest to a time [s]."""
        return int(np.abs(self.time - time).argmin())

    def impact_position(self, impact: np.void) -> np.ndarray:
        """Return the position [m] at which an impact is drawn.

        At a wall, the position is that of the impact's point, projected onto the wall; at a stop of a joint,
        that of the joint; at a stop of a slider, that of the drawn stop, half a carriage beyond the base.
        """
        if self.is_joint_stop(impact["wall"]):
            return np.asarray(self.pose_at(impact["onset"])[impact["point"] - 1])
        position, wall = self.point_at(impact["point"], impact["onset"]), self.wall_of(impact)
        return np.asarray(position - wall.clearance(*position) * np.array(wall.normal))

    def wall_of(self, row: np.void) -> HalfPlane:
        """Return the free side of the wall, or of the slider's stop, of an impact or a phase of dry friction.

        The argument ``row`` is the impact or the phase; a wall that moves is in its position at the onset or
        start.
        """
        time = row["onset" if "onset" in (row.dtype.names or ()) else "start"]
        return self.sides_at(float(time))[self.wall_names[row["wall"]]]

    def save_impacts(self, path: Path | str) -> None:
        """Write the list of impacts, with the names of walls; the file's suffix says CSV, JSON or Parquet.

        Raises:
            ValueError: when the file has another suffix.
            MissingExtraError: for Parquet, when pyarrow (the extra ``sweep``) is not installed.
            OSError: when the file cannot be written.
        """
        save_impacts(Path(path), self.impacts, self.wall_names)

    def save_csv(self, path: Path | str, output: str | Iterable[str] | None = None) -> None:
        """Write time, columns and derivatives as CSV, with all digits of the numbers.

        Args:
            path: the file.
            output: the names of the columns and derivatives to write after the time; ``*`` stands for any
                text; by default all.

        Raises:
            UnknownNameError: when a column does not exist.
            OSError: when the file cannot be written.
        """
        slopes = self.sensitivities.named if self.sensitivities else {}
        columns = {"time": self.time, **self.columns, **slopes}
        if output is not None:
            wanted_names = [output] if isinstance(output, str) else list(output)
            matching_names = (
                names_matching(self.name, pattern, columns, "not a column", self.output_hint)
                for pattern in wanted_names
            )
            columns = {name: columns[name] for name in ("time", *chain.from_iterable(matching_names))}
        save_columns(Path(path), columns)


@dataclass(frozen=True, repr=False, eq=False)
class StoredRecording(Recording):
    """A recording that stores the attributes of ``RecordedAttributes``, as for an FMU or a file."""

    # a required attribute has ``field()``, because a dataclass takes an inherited attribute for a default
    name: str = field()
    time: np.ndarray = field()
    columns: Mapping[str, np.ndarray] = field()
    impacts: np.ndarray = field(default_factory=lambda: NO_IMPACTS)
    walls: Mapping[str, HalfPlane] = field(default_factory=dict)
    wall_names: tuple[str, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    sensitivities: Sensitivities | None = None
    stops: Mapping[int, JointRange] = field(default_factory=dict)
    point_names: Mapping[int, str] = field(default_factory=dict)
    stop_law: str = ""
    stick_slip: np.ndarray = field(default_factory=lambda: NO_PHASES)
    inputs: tuple[str, ...] = ()

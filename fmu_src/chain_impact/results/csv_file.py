"""A recording from a table that `simulate --csv` wrote, or another tool under the FMU's names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from chain_impact.results.animation.contacts import impacts_from_forces, wall_forces
from chain_impact.results.joint_stops import JointRange
from chain_impact.results.recording import NO_STOPS, Recording, impacts_from_outputs
from chain_impact.results.stick_slip import phases_from_columns
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.names import SENSITIVITY
from chain_impact.scene.reading import SceneError
from chain_impact.scene.text_file import check_separator, text_of

NEEDED = ("time", "point[0].x", "point[0].y", "point[1].x", "point[1].y")


def read_csv(
    path: Path,
    walls: Mapping[str, HalfPlane] | None,
    wall_names: tuple[str, ...] = (),
    stops: Mapping[int, JointRange] = NO_STOPS,
) -> Recording:
    """Read a table with a head line.

    Args:
        path: the file; columns ``time`` [s] and outputs of the FMU, at least the positions of the points.
        walls: name → free side of the scene's walls, which a table does not hold; None if they are unknown.
        wall_names: names of the walls by their numbers in the columns ``impact.*``.
        stops: the joints with stops, and their ranges.

    Returns:
        The recording, named as the file is. Its impacts come from the columns ``impact.*`` if they are there;
        else they are estimated from the forces.

    Raises:
        SceneError: when the file is no such table, or has a wall that is not among ``walls``.
        OSError: when the file cannot be read.
    """
    try:
        head, *text = text_of(path).splitlines() or [""]
        check_separator(head)
        names = [name.strip().strip('"') for name in head.split(",")]
        rows = np.loadtxt(text, delimiter=",", ndmin=2) if text else np.zeros((0, len(names)))
    except ValueError as error:  # of a cell that is no number, a row that is too long, or another encoding
        raise SceneError(f"{path}: not a table of numbers: {error}") from None
    missing = [name for name in NEEDED if name not in names]
    if missing:
        raise SceneError(
            f"{path}: the column {missing[0]} is missing; `chain-impact simulate --csv` writes it"
        )
    if rows.shape[0] < 2 or rows.shape[1] != len(names):  # noqa: PLR2004
        raise SceneError(
            f"{path}: {rows.shape[0]} rows of {rows.shape[1]} numbers; must be at least 2 of {len(names)}"
        )
    # a derivative need not exist
    slopes = [name.startswith(SENSITIVITY) for name in names]
    for row in np.flatnonzero(~(np.isfinite(rows) | slopes).all(axis=1))[:1]:
        raise SceneError(f"{path}: line {row + 2} has a number that is not finite")
    columns = dict(zip(names, rows.T.copy(), strict=True))
    time = columns.pop("time")
    for row in np.flatnonzero(np.diff(time) <= 0.0)[:1]:
        raise SceneError(
            f"{path}: line {row + 3}: time = {time[row + 1]:g} must be later than in the line before"
        )
    recording = Recording(
        path.stem,
        time,
        columns,
        [],
        dict(walls or {}),
        stops=dict(stops),
        stick_slip=phases_from_columns(time, columns, wall_names),
        wall_names=wall_names,
    )
    _check_walls(path, recording, walls)
    listed = "impact.count" in columns and walls is not None
    impacts = (
        impacts_from_outputs({"time": time, **columns}, wall_names, stops)
        if listed
        else impacts_from_forces(recording)
    )
    recording.impacts.extend(impacts)
    return recording


def _check_walls(path: Path, recording: Recording, walls: Mapping[str, HalfPlane] | None) -> None:
    for point, wall, _ in wall_forces(recording):
        if walls is None:
            raise SceneError(
                f"{path}: it has contact[{point}].{wall}.force, but a table does not hold where walls are: "
                "give its scene with --scene"
            )
        if wall not in walls:
            known = ", ".join(walls) or "none"
            raise SceneError(
                f"{path}: contact[{point}].{wall}.force: the scene has no wall {wall}; it has {known}"
            )

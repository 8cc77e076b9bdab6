"""Reads a table of an FMU's outputs, which `simulate --csv` or another tool has written, as a recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from chain_impact.recording.bodies import is_of_body
from chain_impact.recording.impacts import NO_IMPACTS, shown_impacts
from chain_impact.recording.interactions import WALL
from chain_impact.recording.joint_stops import ranges_of
from chain_impact.recording.recording import Recording, StoredRecording
from chain_impact.recording.stick_slip import phases_from
from chain_impact.scene.errors import SceneError
from chain_impact.scene.files.text_file import comma_separated_text, likely_time, text_of
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import SENSITIVITY, SLIDER_STOPS

NEEDED_COLUMNS = ("time", "point[0].x", "point[0].y", "point[1].x", "point[1].y")


class NeedsSceneError(SceneError):
    """Raised when a table has contacts with walls whose positions are unknown, because no scene is given."""


def read_csv(path: Path, scene: Scene | None = None) -> Recording:
    """Read a recording from a CSV file, whose first line has the names of the columns.

    Args:
        path: the file. It has the column ``time`` [s] and columns for outputs of the FMU, at least for the
            positions of the points 0 and 1.
        scene: the scene, which gives walls, stops, names of points and parameters of bodies; the file has
            none of these.

    Returns:
        The recording, with the name of the file. The recording has impacts only if a scene is given and the
        file has the column ``impact.count``.

    Raises:
        SceneError: when the file is not such a table, or has a contact with a wall that the scene lacks.
        NeedsSceneError: when the table has contacts with walls, and no scene is given.
        OSError: when the file cannot be read.
    """
    columns = _columns(path)
    time = columns.pop("time")
    for row in np.flatnonzero(np.diff(time) <= 0.0)[:1]:
        raise SceneError(
            f"{path}: line {row + 3}: time = {time[row + 1]:g} must be later than in the line before"
        )
    walls, names = (scene.half_planes, scene.wall_names) if scene else ({}, ())
    values = scene.values if scene else {}
    bare_recording = StoredRecording(
        path.stem,
        time,
        columns,
        walls=walls,
        wall_names=names,
        parameters={name: value for name, value in values.items() if is_of_body(name)},
        stops=ranges_of(values),
        point_names=scene.point_names if scene else {},
    )
    for contact in bare_recording.interactions:
        # without a scene, a wall with the name of a slider's stop counts as the stop
        if contact.kind != WALL or (scene is None and contact.wall in SLIDER_STOPS):
            continue
        if scene is None:
            raise NeedsSceneError(
                f"{path}: it has contact[{contact.point}].{contact.wall}.force, but a CSV file has no "
                "positions of walls: give its scene"
            )
        if contact.wall not in walls:
            raise SceneError(
                f"{path}: contact[{contact.point}].{contact.wall}.force: the scene has no wall "
                f"{contact.wall}; it has {', '.join(walls) or 'none'}"
            )
    has_impact_list = "impact.count" in columns and scene is not None
    impacts = shown_impacts({"time": time, **columns}, names) if has_impact_list else NO_IMPACTS
    return replace(
        bare_recording, impacts=impacts, stick_slip=phases_from(time, bare_recording.interactions, names)
    )


def _columns(path: Path) -> dict[str, np.ndarray]:
    """Return the columns of a table of numbers, by their names; refuse a file that is no such table."""
    try:
        head, *text = comma_separated_text(text_of(path)).splitlines() or [""]
        names = [name.strip().strip('"') for name in head.split(",")]
        if "time" not in names and {"onset", "wall"} <= {*names}:
            raise ValueError("it is a list of impacts, not a motion; `simulate --csv` writes a motion")
        rows = _numbers(names, text)
    # the text is a list of impacts, has a cell that is no number or a line with a wrong number of cells, or
    # has a wrong encoding
    except ValueError as error:
        raise SceneError(f"{path}: not a table of numbers: {error}") from None
    missing_names = [name for name in NEEDED_COLUMNS if name not in names]
    if missing_names:
        likely_hint = likely_time(names) if missing_names[0] == "time" else ""
        raise SceneError(
            f"{path}: the column {missing_names[0]} is missing{likely_hint or '; `simulate --csv` writes it'}"
        )
    if rows.shape[0] <= 1 or rows.shape[1] != len(names):
        raise SceneError(
            f"{path}: {rows.shape[0]} rows of {rows.shape[1]} numbers; must be at least 2 of {len(names)}"
        )
    # a column of derivatives is NaN at times without derivatives; any other column must have finite numbers
    slopes = [name.startswith(SENSITIVITY) for name in names]
    for row in np.flatnonzero(~(np.isfinite(rows) | slopes).all(axis=1))[:1]:
        raise SceneError(f"{path}: line {row + 2} has a number that is not finite")
    return dict(zip(names, rows.T.copy(), strict=True))


def _numbers(names: list[str], text: list[str]) -> np.ndarray:
    """Return the numbers in ``text``, the lines below the head line, shape (rows, cells).

    If the number of cells is the same in all lines, it may still differ from that of ``names``; the caller
    checks this.

    Raises:
        ValueError: when a cell is not a number, or the lines differ in their numbers of cells; the message
            names the line.
    """
    try:
        return np.loadtxt(text, delimiter=",", ndmin=2) if text else np.zeros((0, len(names)))
    except ValueError:
        for number, line in enumerate(text, start=2):
            if line.strip():
                _check_line(f"line {number}", names, [cell.strip() for cell in line.split(",")])
        raise


def _check_line(line_text: str, names: list[str], cells: list[str]) -> None:
    """Refuse a line with a cell that is not a number, or with too few or too many cells."""
    for name, cell in zip(names, cells, strict=False):
        try:
            float(cell)
        except ValueError:
            cell_text = f"= {cell!r}" if cell else "is empty;"
            hint = "; a number has no quotes, and a decimal point" if '"' in cell else ""
            raise ValueError(f"{line_text}: {name} {cell_text} must be a number{hint}") from None
    if len(cells) != len(names):
        raise ValueError(f"{line_text} has {len(cells)} cells, must have {len(names)} as the head line")

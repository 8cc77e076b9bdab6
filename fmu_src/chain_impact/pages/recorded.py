"""The page that shows a recording: one file, which needs no other file.

The page's program, the player, makes the frames.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from chain_impact.pages.assembly import assemble_page, browser_text, program_text, script_data, style_texts
from chain_impact.pages.drawn_outputs import IMPACT_QUANTITIES, drawn_entries
from chain_impact.pages.encoding import base64_text
from chain_impact.pages.shared import FINEST
from chain_impact.recording.joint_stops import JointRange
from chain_impact.recording.pacing import frame_rate, frame_times, slow_spans
from chain_impact.recording.recording import Recording
from chain_impact.recording.view import ball_of, radius_of
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.texts.names import SLIDER_STOPS

RECORDED_PROGRAM = "player/recorded_page.js"
MOST_PAGE_ROWS = 80_000  # of a recording with more rows, a page leaves out some (``thin_rows``)


def recorded_page(recording: Recording, speed: float, impact_time: float) -> str:
    """Return the page's HTML.

    Args:
        recording: the recording to show.
        speed: the speed at which the recording plays at first; 1 is real time.
        impact_time: the time [s] that an impact takes on the screen; 0 for no slow motion.
    """
    shown_data = data_of_page(thin_rows(recording, impact_time)) | {"speed": speed, "impactTime": impact_time}
    template = browser_text("player/recorded_page.html")
    return assemble_page(
        template, recording.name, style_texts(), program_text(RECORDED_PROGRAM), data=script_data(shown_data)
    )


def thin_rows(recording: Recording, impact_time: float) -> Recording:
    """Return a recording without some of its rows, if it has more than MOST_PAGE_ROWS.

    These rows stay: MOST_PAGE_ROWS rows with equally spaced indices, the rows next to a frame that the page
    shows at the speed 1, with slow motion, and the rows next to the onset or the end of an impact.
    ``impact_time``: the time [s] that an impact takes on the screen.
    """
    time, impacts = recording.time, recording.impacts
    if len(time) <= MOST_PAGE_ROWS:
        return recording
    start, end_time, usual_rate = float(time[0]), float(time[-1]), frame_rate(recording)
    frames, _ = frame_times(start, end_time, slow_spans(recording), impact_time, usual_rate=usual_rate)
    shown_times = np.concatenate([frames, impacts["onset"], impacts["end"]])
    later_rows = np.searchsorted(time, shown_times[np.isfinite(shown_times)])
    even = np.linspace(0, len(time) - 1, MOST_PAGE_ROWS).astype(int)
    return recording.with_rows(
        np.unique(np.concatenate([even, later_rows - 1, later_rows]).clip(0, len(time) - 1))
    )


def data_of_page(recording: Recording) -> dict[str, Any]:
    """Return the data that ``player/packed_recording.js`` reads, with the accuracy that the screen needs."""
    points = recording.all_points
    return {
        "name": recording.name,
        "links": recording.link_count,
        "pointCount": points.shape[1],
        "time": base64_text(recording.time.astype("<f8").tobytes()),
        "x": _packed_numbers(points[:, :, 0]),
        "y": _packed_numbers(points[:, :, 1]),
        "drawn": {
            group: [
                entry | packed_entry for entry in entries if (packed_entry := _column_data(entry["columns"]))
            ]
            for group, entries in drawn_entries(recording.columns).items()
        },
        "impacts": impacts_of_page(recording),
        "walls": free_sides(recording.walls),
        "gravity": {name: recording.parameters.get(name) for name in ("gravity.x", "gravity.y")},
        "moved": {name: _packed_numbers(wall_motion) for name, wall_motion in recording.moved_walls.items()},
        "stops": [_range(joint, limits) for joint, limits in recording.stops.items()],
        "radius": radius_of(recording),
        "ball": ball_of(recording),
        "touching": [*recording.touching_radii.items()],
        "pointNames": [*recording.point_names.items()],
        "bodies": [[link, corners.tolist()] for link, corners in recording.outlines.items()],
        "rail": _rail(recording),
        "pinned": recording.pinned,
        "frameRate": frame_rate(recording),
    }


def impacts_of_page(recording: Recording) -> list[dict[str, Any]]:
    """Return the impacts of a recording in the form of the page; unknown values are None."""
    rows = zip(
        recording.impacts,
        recording.linear_impact_speeds.tolist(),
        recording.is_at_joint_stop.tolist(),
        strict=True,
    )
    return [
        {
            "point": int(impact["point"]),
            "what": recording.touching_part(impact),
            "wall": recording.wall_names[impact["wall"]],
            "linearSpeed": linear_speed,
            "joint": int(impact["joint"]),
            **{name: _number_or_none(impact[name]) for name in IMPACT_QUANTITIES},
            "atStop": at_stop,
        }
        for impact, linear_speed, at_stop in rows
    ]


def _number_or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def free_sides(walls: Mapping[str, HalfPlane]) -> dict[str, Any]:
    """Return name of a wall → unit normal and offset [m] of its free side n·p ≥ offset, for the page."""
    return {name: {"normal": wall.normal, "offset": wall.offset} for name, wall in walls.items()}


def _range(joint: int, limits: JointRange) -> dict[str, Any]:
    """Return a joint with stops in the form of the page: its number, from 1, and angles [rad].

    The angles, of the arc's ends and of each stop, count from the previous link or, for joint 1, from +x.
    """
    marks = [stop for stop in (limits.low, limits.high) if math.isfinite(stop)]
    return {"joint": joint, "arc": limits.arc, "marks": marks}


def _rail(recording: Recording) -> dict[str, Any] | None:
    """Return a slider for the page: lines, positions at its stops, carriage, and free sides of its stops.

    The lines are the rail and the marks of the stops. The corners of the carriage are relative to the base.
    The result is None if the recording has no ``rail``.
    """
    rail = recording.rail
    return (
        None
        if rail is None
        else {
            "lines": [line.tolist() for line in rail.lines(recording.points[:, 0])],
            "limits": {
                name: limit
                for name, limit in zip(SLIDER_STOPS, (rail.low, rail.high), strict=True)
                if math.isfinite(limit)
            },
            "carriage": rail.carriage(np.zeros(2)).tolist(),
            "stops": free_sides(rail.stops),
        }
    )


def _column_data(columns: Mapping[str, np.ndarray]) -> dict[str, Any] | None:
    """Return the rows in which any column is not 0, and the values of all columns in these rows only.

    The values are packed in 16 bits. The result is None if there are no such rows.
    """
    rows = np.flatnonzero(np.any([*columns.values()], axis=0))
    if not len(rows):
        return None
    packed_columns = {name: _packed_numbers(column[rows]) for name, column in columns.items()}
    return {"rows": base64_text(rows.astype("<u4").tobytes()), "columns": packed_columns}


def _packed_numbers(values: np.ndarray) -> dict[str, Any]:
    """Return numbers packed in 16 bits: ``low``, ``high``, and as ``values``, in base64, integers k.

    The numbers are low + (high − low) k / FINEST, up to the rounding of k.
    """
    low, high = float(values.min()), float(values.max())
    integers = np.rint((values - low) * (FINEST / ((high - low) or 1.0)))
    return {"low": low, "high": high, "values": base64_text(integers.astype("<u2").tobytes())}

"""Names of points: the panels of a picture shorten long names, and the foot has the full names."""

from __future__ import annotations

import numpy as np

from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.recording.recording import Recording
from chain_impact.recording.view import ball_of
from chain_impact.scene.texts.names import point_label

LONGEST_NAME = 16  # the largest number of characters of a name that is not shortened
POINT = "point "  # the beginning of the name of each point
KEPT_CHARACTERS = 7  # the number of characters that are kept at each end of a shortened name


def short_names(recording: Recording, text: str) -> str:
    """Return a text in which long names of points, in brackets, are shortened: "(left_fo…phere_0)"."""
    for name in recording.point_names.values():
        text = text.replace(f"({name})", f"({shortened_name(name)})")
    return text


def shortened_name(name: str) -> str:
    """Return a name; a name longer than LONGEST_NAME has "…" in place of its middle."""
    return name if len(name) <= LONGEST_NAME else f"{name[:KEPT_CHARACTERS]}…{name[-KEPT_CHARACTERS:]}"


def number_of(name: str) -> str:
    """Return "point 5" for "point 5 (heel)"; any other name stays."""
    return name.partition(" (")[0]


def what_touches(recording: Recording, impact: np.void) -> str:
    """Return words for what touches in an impact: "ball" for a ball at a wall, else the touching part."""
    is_ball = ball_of(recording) == impact["point"] and not recording.is_joint_stop(impact["wall"])
    return "ball" if is_ball else recording.touching_part(impact)


def brief_hit(recording: Recording, impact: np.void) -> str:
    """Return words for an impact, with short names, and no number of a named point: "heel hits y_min"."""
    touching_part, point = what_touches(recording, impact), int(impact["point"])
    is_point = touching_part == point_label(point, recording.point_names)
    name = recording.point_names.get(point, "") if is_point else ""
    return (
        f"{shortened_name(name) or touching_part} hits {shortened_name(recording.wall_names[impact['wall']])}"
    )


def full_names(recording: Recording) -> str:
    """Return the numbers and full names of the points whose names the panels shorten, as text; or "".

    The panels name the points with impacts at walls or with phases of dry friction at walls, and shorten a
    name that is longer than LONGEST_NAME.
    """
    shown_points = {*recording.impacts["point"][~recording.is_at_joint_stop].tolist()}
    shown_points |= {int(phase["point"]) for phase in recording.stick_slip if phase["wall"] >= 0}
    names = recording.point_names
    return SEPARATOR.join(
        f"point {k}: {names[k]}" for k in sorted(shown_points & names.keys()) if len(names[k]) > LONGEST_NAME
    )

"""Names of the points that touch walls, beside the chain at the start in the picture of a motion."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from chain_impact.pictures.drawing.colours import TIME_COLOURS
from chain_impact.pictures.drawing.labels import Label, place_labels
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.texts.point_names import POINT, shortened_name
from chain_impact.recording.recording import Recording
from chain_impact.recording.view import ball_of

NAME = "point"  # the matplotlib identifier (gid) of the name of a point
MOST_NAMED_POINTS = 8  # with more points that touch, no point has a name


def touching_points(recording: Recording) -> list[int]:
    """Return the points that touch a wall, ascending; [] for a ball, which has no name."""
    if ball_of(recording) is not None:
        return []
    hits = [
        int(impact["point"])
        for impact in recording.impacts[~recording.is_at_joint_stop]
        if recording.touching_part(impact) != "slider"
    ]
    return sorted({*hits})


def name_points(axes: Axes, recording: Recording, used_pixels: UsedPixels) -> None:
    """Write the names of points that touch beside the chain at the start, in its colour, on free pixels.

    A point without a name is "point 2" or, without room and after the first one, only "2". A name without a
    leader stands nearer to its own point than to any other point of the chain.
    """
    points, positions = touching_points(recording), recording.all_points[0]
    if len(points) > MOST_NAMED_POINTS:
        return
    middle, is_first = positions.mean(axis=0), True
    for point in points:
        way = positions[point] - middle
        length = float(np.hypot(*way))
        x, y = (way / length if length > 0.0 else np.array([0.0, 1.0])).tolist()
        other_positions = [(float(px), float(py)) for px, py in np.delete(positions, point, axis=0)]
        name = recording.point_names.get(point, "")
        text, short = (shortened_name(name), "") if name else (f"{POINT}{point}", f"{point}")
        position = (float(positions[point][0]), float(positions[point][1]))
        label = Label(text, position, (x, y), short="" if is_first else short, other_marks=other_positions)
        look = {"fontsize": "small", "color": TIME_COLOURS(0.0), "gid": NAME}
        if not place_labels(axes, [label], used_pixels, lines=True, **look) and not name:
            is_first = False

"""Pictures of a chain at the start: the drawing in an FMU's documentation, and the icon of an FMU."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from html import escape
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon

from chain_impact.pictures.drawing.colours import BLUE, INK, VERMILLION
from chain_impact.pictures.drawing.style import COLOURS, STYLE
from chain_impact.pictures.motion.bodies import body_look
from chain_impact.pictures.motion.poses import draw_chain
from chain_impact.pictures.motion.walls import draw_pin, draw_room
from chain_impact.recording.view import pin_lines
from chain_impact.scene.display.outlines import outlines_from, placed_corners, rail_from
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.scene import Scene

DRAWING_SIZE, ICON_SIZE = (7.6, 4.6), (1.28, 1.28)  # [inch] width and height of the drawing, and of the icon
# [inch] in the drawing and in the icon: the least free width, left plus right, which is also the least free
# height, top plus bottom
DRAWING_MARGIN, ICON_MARGIN = 1.4, 0.3
ARROW_LENGTH = 30.0  # [points]
ARC_RADIUS = 18.0  # [points] the radius of the arc of an angle
REFERENCE_LENGTH = 32.0  # [points] the length of the line from which an angle is measured
# the largest number of links with which all points and angles have labels; with more links, only some points
# and the first angle have a label
MOST_LABELLED_LINKS = 8
SIGNS = (
    "This is the start. Link i ends at point i. Angles, angular velocities and torques are positive "
    "anticlockwise. link[i].angle, θi, is measured from the x axis, and joint[i].angle from the link before. "
    "joint[i].torque acts on link i, and its opposite on the link before. The force of a wall is positive "
    "along n, its friction along t, which is n turned by a right angle clockwise."
)


@contextmanager
def draw_repeatably() -> Iterator[None]:
    """Let a ``with`` block draw equal pictures of equal scenes, whatever matplotlib's settings are.

    Files are equal if the block leaves the date and the version of matplotlib out of their metadata.
    """
    style = STYLE | COLOURS | {"svg.hashsalt": "chain-impact"}
    with matplotlib.style.context("default"), matplotlib.rc_context(style):
        yield


@draw_repeatably()
def drawing(scene: Scene) -> str:
    """Return a drawing of the chain at the start as SVG: points, angles, walls and positive directions."""
    axes, joints, unit = _chain_figure(scene, DRAWING_SIZE, DRAWING_MARGIN, linewidth=5.0, markersize=8.0)
    low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
    for name, plane in scene.walls_at_start.items():
        has_friction = scene.has_contact_friction or name in scene.moving_walls
        _name_wall(axes, name, plane, "nt" if has_friction else "n")
    label_step = math.ceil(len(scene.chain.links) / MOST_LABELLED_LINKS)
    for i, angle in enumerate(scene.initial.angles[: None if label_step == 1 else 1]):
        _draw_angle(axes, joints[i], f"θ{i + 1} = {math.degrees(angle):.3g}°", angle, unit)
    for k, joint in enumerate(joints):
        if k == 0:
            _text(axes, "point 0", joint, (-8.0, 0.0), ha="right")
        elif k % label_step == 0 or k == len(joints) - 1:
            _text(axes, str(k), joint, (0.0, 10.0))
    if label_step == 1:
        for k, (x, y, _) in [*scene.start.items()][len(joints) :]:
            _text(axes, scene.point_names.get(k, str(k)), np.array([x, y]), (6.0, -7.0), ha="left")
    corner = low + 14.0 * unit
    _arrow(axes, "x", corner, (1.0, 0.0))
    _arrow(axes, "y", corner, (0.0, 1.0))
    turn = {"arrowstyle": "<-", "connectionstyle": "arc3,rad=0.4"}
    _text(axes, "+", corner + unit * np.array([20.0, 0.0]), (-2.0, 22.0), arrowprops=turn)
    if pull := math.hypot(*scene.gravity):
        _arrow(axes, "g", high - 25.0 * unit, np.array(scene.gravity) / pull)
    stream = io.StringIO()
    axes.figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    svg = stream.getvalue().partition("<svg")[2]
    return f"<svg role='img' aria-label='{escape(scene.name)} at its start'{svg}"


@draw_repeatably()
def icon(scene: Scene) -> bytes:
    """Return a small picture of the chain at the start, with the walls, as PNG."""
    axes, *_ = _chain_figure(scene, ICON_SIZE, ICON_MARGIN, linewidth=4.0, markersize=6.0)
    stream = io.BytesIO()
    axes.figure.savefig(stream, format="png", dpi=100, metadata={"Software": None})
    return stream.getvalue()


def _chain_figure(
    scene: Scene, size: tuple[float, float], border: float, **style: float
) -> tuple[Any, np.ndarray, float]:
    """Draw the walls, and the chain at the start, into a new figure.

    The view contains the points of the chain and, of each wall, the point nearest to the mean of points 0…N.
    ``size``: width and height of the figure [inches]; ``border``: the least free width, left plus right, and
    least free height, top plus bottom [inches]; ``style``: linewidth and markersize of the chain [points].

    Returns the axes, the positions of the points 0…N, shape (N + 1, 2) [m], and the length in the scene [m]
    that is drawn as a typographic point (1/72 inch).
    """
    points = np.array([disc[:2] for disc in scene.start.values()])
    joints, sites = np.split(points, [len(scene.chain.links) + 1])
    planes, middle = list(scene.walls_at_start.values()), joints.mean(axis=0)
    positions = np.array([*points, *(_foot(plane, middle) for plane in planes)])
    scale = max(
        np.ptp(positions, axis=0) / (np.array(size) - border)
    )  # the scale [m per inch] of the drawing
    centre = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
    axes = Figure(figsize=size).add_axes((0.0, 0.0, 1.0, 1.0), xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    draw_room(axes, centre + 0.5 * scale * np.array([[-1.0], [1.0]]) * size, planes)
    draw_pin(axes, pin_lines(joints[None]) if scene.chain.base == "pinned" else [])
    outlines = outlines_from(scene.values, scene.contact.points)
    bodies = [placed_corners(corners, joints[n - 1], joints[n]) for n, corners in outlines.items()]
    if rail := rail_from(points[None], None, scene.values):
        lines = rail.lines(joints[:1])
        axes.add_collection(LineCollection(lines, colors=INK, linewidths=1.2, zorder=2.5))
        bodies.append(rail.carriage(joints[0]))
    for corners in bodies:
        axes.add_patch(Polygon(corners, **body_look(BLUE), zorder=3.4))
    draw_chain(axes, joints, color=BLUE, markerfacecolor=VERMILLION, **style)
    axes.plot(*sites.T, "o", color=BLUE, markersize=0.5 * style["markersize"], zorder=5)
    return axes, joints, float(scale / 72.0)


def _foot(plane: HalfPlane, point: np.ndarray) -> np.ndarray:
    """Return the point of a wall that is nearest to ``point`` [m]."""
    return np.asarray(point - plane.clearance(*point) * np.array(plane.normal))


def _name_wall(axes: Axes, name: str, plane: HalfPlane, letters: str) -> None:
    """Draw the line and the name of a wall, and arrows with ``letters`` along its normal and its tangent.

    With one letter, only the normal has an arrow. The arrows stand beside the point of the wall that is
    nearest to the middle of the view, because the chain may be at this point.
    """
    low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
    foot, normal = _foot(plane, 0.5 * (low + high)), np.array(plane.normal)
    tangent = np.array([normal[1], -normal[0]])
    (x, y), (dx, dy) = foot, tangent
    axes.axline((x, y), (x + dx, y + dy), color=INK, linewidth=0.6)
    shift = 0.22 * (high - low)[1] * tangent
    for letter, direction in zip(letters, (normal, tangent), strict=False):
        _arrow(axes, letter, foot + shift, direction)
    side = "right" if normal[0] > 0.5 else "left" if normal[0] < -0.5 else "center"  # noqa: PLR2004
    edge = 0.08 * (high - low)
    _text(axes, name, np.clip(foot - shift, low + edge, high - edge), -12.0 * normal, ha=side)


def _draw_angle(axes: Axes, joint: np.ndarray, text: str, angle: float, unit: float) -> None:
    """Draw the arc of a link's angle from the x axis, at the link's joint; full turns are left out.

    ``joint``: position of the joint [m]; ``text``: name and value of the angle; ``angle``: the angle [rad];
    ``unit``: the length in the scene [m] that is drawn as a typographic point.
    """
    x, y = joint
    degrees = math.degrees(math.remainder(angle, math.tau))
    axes.plot([x, x + REFERENCE_LENGTH * unit], [y, y], "--", color=INK, linewidth=0.8)
    ends = {"theta1": min(0.0, degrees), "theta2": max(0.0, degrees)}
    axes.add_patch(Arc((x, y), 2.0 * ARC_RADIUS * unit, 2.0 * ARC_RADIUS * unit, color=INK, **ends))
    # [points] text and link are on opposite sides of the line from which the angle is measured
    label_offset = -9.0 if degrees > 0.0 else 6.0
    _text(axes, text.replace("-", "−"), joint, (0.7 * REFERENCE_LENGTH, label_offset), ha="left")


def _arrow(axes: Axes, letter: str, start: np.ndarray, direction: Iterable[float]) -> None:
    """Draw an arrow from a point [m] along a unit vector, with a letter at the arrow's tip."""
    _text(
        axes,
        letter,
        start,
        ARROW_LENGTH * np.array(direction),
        arrowprops={"arrowstyle": "<-", "shrinkB": 0.0},
    )


def _text(axes: Axes, text: str, point: np.ndarray, offset: Iterable[float], **text_style: Any) -> None:
    """Draw a text at the distance ``offset``, x and y in typographic points, from a point [m]."""
    x, y = offset
    style: dict[str, Any] = {"ha": "center", "va": "center", "textcoords": "offset points", "zorder": 6}
    axes.annotate(text, (point[0], point[1]), (x, y), annotation_clip=False, **(style | text_style))

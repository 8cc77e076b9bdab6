"""Pictures of a chain at its start: the drawing in an FMU's documentation, and the icon of the FMU."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from html import escape

import numpy as np
from PIL import Image, ImageDraw

from chain_impact.results.view import pin_mark
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.scene.scene import Scene

# --- the drawing, in pixels ------------------------------------------------------------------------------
WIDTH, HEIGHT, BORDER = 760.0, 460.0, 70.0
ARC, REFERENCE = 26.0, 44.0  # radius of the arc of an angle, length of the line that it is measured from
AXIS, CORNER = 34.0, 20.0  # length of an arrow, and where the axes are, from the lower left corner
LABELLED = 8  # of a longer chain not every point has a label, and only the first angle
SHORTEST = 9.0  # an arc with an arrowhead
DOWN = np.array([0.0, 4.0])  # from the middle of a letter to its baseline
STYLE = (
    "svg{color:#222;max-width:100%;height:auto;font:13px sans-serif}"
    "svg text{fill:currentColor;paint-order:stroke;stroke:Canvas;stroke-width:3px;stroke-opacity:.7}"
    ".line{stroke:currentColor;fill:none;stroke-width:1.2}"
    ".thin{stroke:currentColor;fill:none;stroke-width:1;stroke-dasharray:4 3;opacity:.65}"
    ".wall{fill:currentColor;opacity:.13}.link{stroke:#3b8fd0;stroke-width:7;stroke-linecap:round}"
    ".point{fill:#d62728;stroke:none}"
    "@media(prefers-color-scheme:dark){svg{color:#ddd}}"
)
SIGNS = (
    "This is the start. Link i ends at point i. Angles, angular velocities and torques are positive "
    "anticlockwise. link[i].angle, θi, is measured from the x axis, and joint[i].angle from the link before. "
    "joint[i].torque acts on link i, and its opposite on the link before. The force of a wall is positive "
    "along n, its friction along t, which is n turned by a right angle clockwise."
)


def joints_of(scene: Scene) -> np.ndarray:
    """The points of the chain at its start, shape (N+1, 2) [m]."""
    directions = np.array([(math.cos(a), math.sin(a)) for a in scene.initial.angles])
    lengths = np.array([link.length for link in scene.chain.links])
    base = np.array(scene.initial.position)
    return np.vstack([base, base + np.cumsum(directions * lengths[:, None], 0)])


def extent(joints: np.ndarray, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The lower left and the upper right corner [m] of the chain and of the nearest points of all walls."""
    middle, room = joints.mean(0), 0.1 * max(link.length for link in scene.chain.links)
    planes = scene.half_planes.values()
    feet = [middle - plane.clearance(*middle) * np.array(plane.normal) for plane in planes]
    seen = np.vstack([joints - room, joints + room, *feet])
    return seen.min(0), seen.max(0)


def drawing(scene: Scene) -> str:
    """The chain with its points, angles and walls, and the directions that are positive, as SVG."""
    return "\n".join(
        [
            f"<svg viewBox='0 0 {WIDTH:g} {HEIGHT:g}' width='{WIDTH:g}' height='{HEIGHT:g}' role='img' "
            f"aria-label='{escape(scene.name)} at its start'>",
            "<defs><marker id='tip' viewBox='0 0 8 8' refX='7' refY='4' markerWidth='8' markerHeight='8' "
            "orient='auto'><path d='M0 0.5 8 4 0 7.5z' fill='currentColor'/></marker></defs>",
            *_parts(scene),
            "</svg>",
        ]
    )


def _parts(scene: Scene) -> Iterator[str]:
    joints = joints_of(scene)
    low, high = extent(joints, scene)
    room = np.array([WIDTH, HEIGHT]) - 2.0 * BORDER
    scale = float(min(room / np.maximum(high - low, 1e-12)))
    middle = 0.5 * (low + high)

    def pixels(points: np.ndarray) -> np.ndarray:
        return np.asarray(0.5 * np.array([WIDTH, HEIGHT]) + scale * (points - middle) * [1.0, -1.0])

    for name, plane in scene.half_planes.items():
        rubs = scene.has_contact_friction or name in scene.moving_walls
        yield from _wall(name, plane, pixels(plane.offset * np.array(plane.normal)), rubs)
    still = np.array([joints, joints])
    for line in pin_mark(still) if scene.chain.base == "pinned" else ():
        yield _path(pixels(line))
    places = pixels(joints)
    every = math.ceil(len(scene.chain.links) / LABELLED)
    for i, angle in enumerate(scene.initial.angles):
        if i == 0 or every == 1:
            yield from _angle(i + 1, angle, places[i])
    ends = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    yield f"<polyline class='link' points='{ends}' fill='none' stroke-linejoin='round'/>"
    for k, place in enumerate(places):
        yield f"<circle class='point' cx='{place[0]:.1f}' cy='{place[1]:.1f}' r='4.5'/>"
        if k == 0:
            yield _text("point 0", place + np.array([-9.0, 5.0]), "end")
        elif k % every == 0 or k == len(joints) - 1:
            yield _text(str(k), place + np.array([0.0, -10.0]), "middle")
    yield from _directions(scene)


def _wall(name: str, plane: HalfPlane, foot: np.ndarray, rubs: bool) -> Iterator[str]:
    """What lies beyond a wall, its line, its normal n, its tangent t if it rubs or moves, and its name."""
    normal = np.array(plane.normal) * [1.0, -1.0]
    along = np.array([plane.normal[1], -plane.normal[0]]) * [1.0, -1.0]
    centre = np.array([0.5 * WIDTH, 0.5 * HEIGHT])
    foot = centre - ((centre - foot) @ normal) * normal  # the nearest to the middle of the drawing
    far = 2.0 * WIDTH
    ends = np.array([foot - far * along, foot + far * along])
    outside = [*ends, *(ends[::-1] - far * normal)]
    yield f"<polygon class='wall' points='{' '.join(f'{x:.1f},{y:.1f}' for x, y in outside)}'/>"
    yield _path(ends)
    # beside the middle, where the chain is less likely to be
    start = foot + (0.22 * HEIGHT) * along
    for direction, letter in ((normal, "n"), *([(along, "t")] if rubs else [])):
        yield _path(np.array([start, start + AXIS * direction]), "marker-end='url(#tip)'")
        yield _text(letter, start + (AXIS + 9.0) * direction + DOWN, "middle")
    away = 16.0 + 4.0 * len(name) * abs(normal[0])  # half the width of the name, beside an upright wall
    yield _text(name, foot - 0.25 * HEIGHT * along - away * normal + DOWN, "middle")


def _angle(link: int, angle: float, place: np.ndarray) -> Iterator[str]:
    """The angle of a link, from the x axis, at its joint; -180° to 180° is drawn."""
    turned = math.remainder(angle, 2.0 * math.pi)
    yield _path(np.array([place, place + np.array([REFERENCE, 0.0])]), kind="thin")
    end = place + ARC * np.array([math.cos(turned), -math.sin(turned)])
    sweep = 1 if turned < 0.0 else 0
    start = f"{place[0] + ARC:.1f} {place[1]:.1f}"
    head = "marker-end='url(#tip)'" if abs(turned) * ARC > SHORTEST else ""
    yield (f"<path class='line' d='M{start} A{ARC:g} {ARC:g} 0 0 {sweep} {end[0]:.1f} {end[1]:.1f}' {head}/>")
    below = 13.0 if turned > 0.0 else -5.0  # where the link is not
    text = f"θ{link} = {math.degrees(angle):.3g}°".replace("-", "−")
    yield _text(text, place + np.array([0.8 * REFERENCE, below]), "start")


def _directions(scene: Scene) -> Iterator[str]:
    """The axes, the positive sense of rotation, and gravity."""
    origin = np.array([CORNER, HEIGHT - CORNER])
    for direction, letter in (([1.0, 0.0], "x"), ([0.0, -1.0], "y")):
        end = origin + AXIS * np.array(direction)
        yield _path(np.array([origin, end]), "marker-end='url(#tip)'")
        yield _text(letter, end + 10.0 * np.array(direction) + DOWN, "middle")
    turn = origin + np.array([0.5 * AXIS, 0.0])
    top = origin - np.array([0.0, 0.5 * AXIS])
    yield (
        f"<path class='line' d='M{turn[0]:g} {turn[1]:g} A{0.5 * AXIS:g} {0.5 * AXIS:g} 0 0 0 {top[0]:g} "
        f"{top[1]:g}' marker-end='url(#tip)'/>"
    )
    yield _text("+", origin + 0.55 * AXIS * np.array([1.0, -1.0]), "middle")
    pull = math.hypot(*scene.gravity)
    if pull > 0.0:
        down = np.array([scene.gravity[0], -scene.gravity[1]]) / pull
        start = np.array([WIDTH - 1.5 * CORNER - AXIS, HEIGHT - CORNER - AXIS])
        yield _path(np.array([start, start + AXIS * down]), "marker-end='url(#tip)'")
        yield _text("g", start + np.array([9.0, 4.0]), "start")


def _path(points: np.ndarray, more: str = "", kind: str = "line") -> str:
    return f"<path class='{kind}' d='M{' '.join(f'{x:.1f} {y:.1f}' for x, y in points)}' {more}/>"


def _text(text: str, place: np.ndarray, anchor: str) -> str:
    return f"<text x='{place[0]:.1f}' y='{place[1]:.1f}' text-anchor='{anchor}'>{escape(text)}</text>"


# --- the icon --------------------------------------------------------------------------------------------
SHOWN, FINER = 128, 4  # pixels, and how many times as many are drawn, for smooth edges
SIZE, MARGIN = SHOWN * FINER, 0.12  # pixels that are drawn, a part of the picture
EDGE, BAR, KNOB = 1.5 * FINER, 5 * FINER, 3.0 * FINER  # half a wall, a link, half a joint, in pixels
WALL, LINK, JOINT, PAPER = (150, 150, 150), (31, 119, 180), (214, 39, 40), (255, 255, 255)


def icon(scene: Scene) -> bytes:
    """The chain at its start and the walls, as PNG."""
    joints, planes = joints_of(scene), scene.half_planes.values()
    low, high = extent(joints, scene)
    scale = (1.0 - 2.0 * MARGIN) * SIZE / max(high - low)
    corner = 0.5 * (SIZE - scale * (high - low))

    image = np.full((SIZE, SIZE, 3), PAPER, np.uint8)
    y, x = np.mgrid[SIZE:0:-1, 0:SIZE] + np.array([-0.5, 0.5])[:, None, None]
    x, y = low[0] + (x - corner[0]) / scale, low[1] + (y - corner[1]) / scale
    if planes:
        # the edge of the room that is free of all walls
        clearance = np.min(
            [plane.normal[0] * x + plane.normal[1] * y - plane.offset for plane in planes], axis=0
        )
        image[np.abs(clearance) * scale <= EDGE] = WALL
    sketch = Image.fromarray(image)
    pen = ImageDraw.Draw(sketch)
    pixels = [(px, SIZE - py) for px, py in (corner + scale * (joints - low)).tolist()]
    pen.line(pixels, LINK, BAR)
    for px, py in pixels:
        pen.ellipse((px - KNOB, py - KNOB, px + KNOB, py + KNOB), JOINT)
    stream = io.BytesIO()
    sketch.resize((SHOWN, SHOWN)).save(stream, "png", optimize=True)
    return stream.getvalue()

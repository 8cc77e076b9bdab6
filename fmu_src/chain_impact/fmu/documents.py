"""What an FMU tells people: documentation/index.html, the licenses, and a picture."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from html import escape
from importlib.metadata import distribution

import numpy as np
from PIL import Image, ImageDraw

from chain_impact.compilation.errors import BuildError
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.scene import Scene
from chain_impact.variables.model import Model
from chain_impact.variables.variable import Variable

SHOWN, FINER = 128, 4  # of the picture: pixels, and how many times as many are drawn, for smooth edges
SIZE, MARGIN = SHOWN * FINER, 0.12  # pixels that are drawn, a part of the picture
EDGE, BAR, KNOB = 1.5 * FINER, 5 * FINER, 3.0 * FINER  # half a wall, a link, half a joint, in pixels
WALL, LINK, JOINT, PAPER = (150, 150, 150), (31, 119, 180), (214, 39, 40), (255, 255, 255)
PICTURES = {2: "model.png", 3: "terminalsAndIcons/icon.png"}
"""Version of FMI → where it wants the picture (2.3 of FMI 2.0, 2.5.1 of FMI 3.0)."""
STYLE = (
    "body{font-family:sans-serif;max-width:70em;margin:2em auto;padding:0 1em}"
    "table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.2em .6em;text-align:left}"
)

INTRODUCTION = (
    "<p>A planar chain of rigid links that hits {walls}. FMI {version}, co-simulation. Quantities "
    "are in SI units. The solver locates every impact: the results do not depend on the communication "
    "step.</p>",
    "<p>Torques, forces and targets are held constant over a communication step. Fixed parameters can be set "
    "until the end of initialization, tunable ones and inputs at any time. The state can be saved, restored "
    "and serialized. The tolerance that counts is the parameter solver.tolerance.</p>",
)

MOTIONS = (
    "<p>A base and walls that move are given at communication points: position, velocity and acceleration. "
    "In between they follow a cubic, with a continuous position and velocity, that aims at what uniform "
    "acceleration makes of what is given; the speed of a belt changes at a uniform rate.</p>"
)
EVENTS = (
    "<p>With event mode and early return, a step ends at each onset of a contact. There, inputs and tunable "
    "parameters can be changed before the impact takes effect, by fmi3UpdateDiscreteStates. The outputs are "
    "there as arrays, too, such as point.position.</p>"
)
FURTHER: dict[int, list[str]] = {2: [], 3: [EVENTS]}
"""Version of FMI → what is to be said of it besides."""


def documents(model: Model, fmi: int) -> dict[str, bytes]:
    """The files, by their names in an FMU of version 2 or 3 of FMI."""
    license_text = distribution("chain-impact").read_text("licenses/LICENSE")
    if license_text is None:
        raise BuildError("the license of chain-impact is not installed with it: install the package anew")
    return {
        "documentation/index.html": page(model, fmi).encode(),
        "documentation/licenses/license.txt": license_text.encode(),
        PICTURES[fmi]: picture(model.scene),
    }


# --- the page --------------------------------------------------------------------------------------------


def page(model: Model, fmi: int) -> str:
    """The documentation, as HTML."""
    scene, variables = model.scene, model.variables

    def of(causality: str) -> list[Variable]:
        return [variable for variable in variables if variable.causality == causality]

    settable = [
        (v.name, model.start_text(v), v.unit, v.variability, v.allowed, v.description)
        for v in of("parameter")
    ]
    inputs = [(v.name, v.unit, v.description) for v in of("input")]
    outputs = [(v.name, v.unit, v.variability, v.description) for v in of("output")]
    choices = [
        (v.name, str(number), item.name, item.description)
        for v in variables
        for number, item in enumerate(v.items, 1)
    ]
    walls = "walls with dry friction" if scene.has_contact_friction else "frictionless walls"
    parts = [
        f"<h1>{escape(scene.name)}</h1><p>{escape(scene.description)}</p>",
        *(paragraph.format(version=f"{fmi}.0", walls=walls) for paragraph in INTRODUCTION),
        *([MOTIONS] if scene.inputs.base_motion or scene.moving_walls else []),
        *FURTHER[fmi],
        table("Parameters", ("name", "start", "unit", "variability", "allowed", "meaning"), settable),
        table("Inputs", ("name", "unit", "meaning"), inputs),
        table("Outputs", ("name", "unit", "variability", "meaning"), outputs),
        table("Choices", ("parameter", "number", "name", "meaning"), choices),
        table(
            "Status of the solver", ("code", "meaning"), [(str(n), text) for n, text in STATUS_TEXT.items()]
        ),
        '<p><a href="licenses/license.txt">License</a></p>',
    ]
    head = f"<meta charset='utf-8'><title>{escape(scene.name)}</title><style>{STYLE}</style>"
    return (
        f"<!DOCTYPE html>\n<html lang='en'><head>{head}</head><body>\n"
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table with a title; nothing if it has no rows."""
    lines = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    if not lines:
        return ""
    names = "".join(f"<th>{name}</th>" for name in head)
    return (
        f"<h2>{title}</h2><table><tr>{names}</tr>\n"
        + "\n".join(f"<tr>{line}</tr>" for line in lines)
        + "</table>"
    )


# --- the picture -----------------------------------------------------------------------------------------


def picture(scene: Scene) -> bytes:
    """The chain at its start and the walls, as PNG."""
    directions = np.array([(np.cos(a), np.sin(a)) for a in scene.initial.angles])
    lengths = np.array([link.length for link in scene.chain.links])
    base, planes = np.array(scene.initial.position), scene.half_planes.values()
    joints = np.vstack([base, base + np.cumsum(directions * lengths[:, None], 0)])
    # the point of each wall that is nearest to the middle of the chain is in the picture
    middle = joints.mean(0)
    feet = [middle - plane.clearance(*middle) * np.array(plane.normal) for plane in planes]
    seen = np.vstack([joints - 0.1 * lengths.max(), joints + 0.1 * lengths.max(), *feet])
    low, high = seen.min(0), seen.max(0)
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
    drawing = Image.fromarray(image)
    pen = ImageDraw.Draw(drawing)
    pixels = [(px, SIZE - py) for px, py in (corner + scale * (joints - low)).tolist()]
    pen.line(pixels, LINK, BAR)
    for px, py in pixels:
        pen.ellipse((px - KNOB, py - KNOB, px + KNOB, py + KNOB), JOINT)
    stream = io.BytesIO()
    drawing.resize((SHOWN, SHOWN)).save(stream, "png", optimize=True)
    return stream.getvalue()

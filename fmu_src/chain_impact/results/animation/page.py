"""The animation as a page for a browser: one file, which needs nothing else."""

from __future__ import annotations

import base64
import html
import json
import math
import re
from collections.abc import Iterable, Mapping
from importlib import resources
from typing import Any

import numpy as np

from chain_impact.results.animation.frames import Motion
from chain_impact.scene.half_planes import HalfPlane

PAGE = resources.files("chain_impact.results.animation") / "browser"
STYLES = ("vendor/uPlot.min.css", "style.css", "panels.css")
LIBRARIES = ("vendor/uPlot.iife.min.js", "vendor/svg.min.js")
PLAYER = (
    *("dom", "recording", "clock", "format", "room", "trace"),
    *("scene", "charts", "impacts", "controls", "player"),
)
"""The modules that show a recording, each after those that it imports from."""
MODULES = (*PLAYER, "packed", "main")
FRAGMENTS = ("stage", "panels", "playback")
IMPORT = re.compile(r"^import [^;]+;\n", re.MULTILINE)
EXPORT = re.compile(r"^export (?=async|class|const|function)", re.MULTILINE)
SOURCE_MAP = re.compile(r"^//# sourceMappingURL=.*$", re.MULTILINE)
FINEST = 65535  # of 16 bits


def page(motion: Motion, speed: float = 1.0) -> str:
    """The page's HTML.

    Args:
        motion: what to show.
        speed: at which it plays at first, 1 for real time.
    """
    return assembled(
        _text("index.html"),
        motion.name,
        styles(),
        program(),
        data=script_data(data(motion, speed)),
    )


def assembled(template: str, title: str, styles: Iterable[str], modules: str, **parts: str) -> str:
    """A page with a player.

    Args:
        template: HTML with places to fill, ``{{ name }}``.
        title: what the page shows.
        styles: what style sheets hold.
        modules: the page's program, as ``joined`` gives it.
        parts: what to fill in at other places of the template.
    """
    scripts = "\n".join(f"<script>\n{SOURCE_MAP.sub('', _text(name))}</script>" for name in LIBRARIES)
    parts |= {"title": html.escape(title, quote=False), "style": "\n".join(styles)}
    parts |= {"libraries": scripts, "program": modules}
    parts |= {name: _text(f"{name}.html") for name in FRAGMENTS}
    # one pass: what is filled in may hold what looks like a place to fill
    return re.sub(r"\{\{ (\w+) \}\}", lambda found: parts[found[1]], template)


def styles() -> list[str]:
    """What the style sheets of a page with a player hold."""
    return [_text(name) for name in STYLES]


def program() -> str:
    """The page's modules one after the other, as one."""
    return joined(_text(f"{name}.js") for name in MODULES)


def player() -> str:
    """Those that show a recording, for another page."""
    return joined(_text(f"{name}.js") for name in PLAYER)


def joined(modules: Iterable[str]) -> str:
    """Modules one after the other, as one: without what they import from each other."""
    return "\n".join(EXPORT.sub("", IMPORT.sub("", text)) for text in modules)


def script_data(content: Any) -> str:
    """Data as text in a page."""
    return json.dumps(content, separators=(",", ":")).replace("<", "\\u003c")


def data(motion: Motion, speed: float) -> dict[str, Any]:
    """What the page's ``recording.js`` reads, numbers as small as the screen allows."""
    peaks = [c.peak_force for c in motion.contacts if c.peak_force is not None and c.arm is None]
    return {
        "name": motion.name,
        "speed": speed,
        "frameRate": motion.frame_rate,
        "time": _base64(motion.time.astype("<f8")),
        "links": motion.points.shape[1] - 1,
        "points": [_packed(motion.points[:, :, axis]) for axis in (0, 1)],
        "energies": {name: _packed(energy) for name, energy in motion.energies.items()},
        "forces": [
            {"point": point, "wall": wall, **_sparse(force), **_friction(motion, (point, wall), force)}
            for (point, wall), force in [*motion.forces.items(), *motion.moments.items()]
        ],
        "stuckJoints": [
            {"joint": joint, "spans": _spans(sticking)}
            for (joint, wall), sticking in motion.sticking.items()
            if not wall
        ],
        "peakForce": max(peaks, default=0.0),
        "contacts": [
            {
                "point": contact.point,
                "wall": contact.wall,
                "onset": contact.onset,
                "end": contact.end,
                "speed": contact.speed,
                "peak": contact.peak_force,
                "resolved": contact.resolved,
                "atStop": contact.arm is not None,
                "endSpeed": contact.end_speed,
            }
            for contact in motion.contacts
        ],
        "walls": free_sides(motion.walls),
        "stops": [
            {
                "joint": joint,
                "arc": one.arc,
                "marks": [stop for stop in (one.low, one.high) if math.isfinite(stop)],
            }
            for joint, one in motion.stops.items()
        ],
        "view": motion.view.tolist(),
        "anchor": motion.anchor,
        "pin": [line.tolist() for line in motion.pin],
        "radius": motion.radius,
        "touching": motion.touching,
    }


def free_sides(walls: Mapping[str, HalfPlane]) -> dict[str, Any]:
    """The free side of each wall, as the page draws it."""
    return {name: {"normal": wall.normal, "offset": wall.offset} for name, wall in walls.items()}


def _packed(values: np.ndarray) -> dict[str, Any]:
    """Numbers in 16 bits: low + (high − low) · integer / 65535."""
    low, high = float(values.min()), float(values.max())
    integers = np.rint((values - low) * (FINEST / ((high - low) or 1.0)))
    return {"low": low, "high": high, "values": _base64(integers.astype("<u2"))}


def _sparse(force: np.ndarray) -> dict[str, Any]:
    """A force that is mostly zero: the frames at which it is not, and its values there."""
    frames = np.flatnonzero(force > 0.0)
    return {"frames": _base64(frames.astype("<u4")), **_packed(force[frames] if len(frames) else np.zeros(1))}


def _friction(motion: Motion, place: tuple[int, str], force: np.ndarray) -> dict[str, Any]:
    """The dry friction of a contact at the frames of its force, and the spans in which it sticks; if any."""
    friction = motion.friction.get(place)
    if friction is None or not (force > 0.0).any():
        return {}
    found: dict[str, Any] = {"friction": _packed(friction[force > 0.0])}
    if place in motion.sticking:
        found["spans"] = _spans(motion.sticking[place])
    return found


def _spans(mask: np.ndarray) -> list[tuple[int, int]]:
    """The first and the last frame of each span of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return [(int(first), int(after) - 1) for first, after in edges.reshape(-1, 2)]


def _base64(array: np.ndarray) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")


def _text(name: str) -> str:
    return PAGE.joinpath(name).read_text(encoding="utf-8")

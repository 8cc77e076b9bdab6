"""A scene in some lines, as Python shows it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from chain_impact.kernel.model.geometry import WALLS

if TYPE_CHECKING:
    from chain_impact.scene.scene import Scene

LISTED = 6  # numbers of a list
WIDTH = 100  # characters of a line


def text(scene: Scene) -> str:
    """The scene in some lines: its name and what each table of the file holds, in short."""
    title = f"Scene {scene.name}" + (f": {' '.join(scene.description.split())}" if scene.description else "")
    lines = [title, *(f"  {word:9}{line}" for word, line in _lines(scene))]
    return "\n".join(line if len(line) <= WIDTH else f"{line[: WIDTH - 1]}…" for line in lines)


def _lines(scene: Scene) -> Iterator[tuple[str, str]]:
    links, contact, start, run = scene.chain.links, scene.contact, scene.initial, scene.simulation
    count = f"{len(links)} link{'s' * (len(links) != 1)}"
    length, mass = sum(link.length for link in links), sum(link.mass for link in links)
    yield "chain", f"{count}, {length:g} m, {mass:g} kg; base {scene.chain.base}"
    box = [f"{wall} = {at:g} m" for wall in WALLS if (at := getattr(scene.box, wall)) is not None]
    yield "walls", ", ".join([*box, *(wall.name for wall in scene.walls)]) or "none"
    law = f"{contact.model}, e = {contact.restitution:g}"
    stiffness = f"K = {contact.stiffness:g} N/m^{contact.exponent:g}"
    yield "contact", f"{law}, {stiffness}; points {_listed(contact.points)}"
    yield "start", f"base at {_listed(start.position)} m, angles {_listed(start.angles)} rad"
    solver = f"method {scene.solver.method}, tolerance {scene.solver.tolerance:g}"
    yield "run", f"{run.stop_time:g} s in steps of {run.step_size:g} s; {solver}"


def _listed(values: Iterable[float]) -> str:
    texts = [f"{value:g}" for value in values]
    return ", ".join(texts if len(texts) <= LISTED else [*texts[: LISTED - 2], "…", texts[-1]])

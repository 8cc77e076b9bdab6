"""A scene as a few lines of text, as Python shows it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from chain_impact.kernel.record.constants import WALLS
from chain_impact.scene.contents import SceneContents
from chain_impact.scene.facts import friction_joints
from chain_impact.scene.keys.tables import Material
from chain_impact.scene.texts.unit_text import stiffness_unit

# largest number of entries of a list of numbers or joints in the text of a scene; a longer list has its first
# entries, … and its last one
SHOWN_ENTRIES = 6
TEXT_WIDTH = 100  # largest number of characters in a line of the text of a scene; a longer line is cut


def scene_as_text(scene: SceneContents) -> str:
    """Return a scene in a few lines: name, chain, walls, contact, stops, signals, start and run."""
    title = f"Scene {scene.name}" + (f": {' '.join(scene.description.split())}" if scene.description else "")
    lines = [title, *(f"  {word:9}{line}" for word, line in _lines(scene))]
    return "\n".join(line if len(line) <= TEXT_WIDTH else f"{line[: TEXT_WIDTH - 1]}…" for line in lines)


def _lines(scene: SceneContents) -> Iterator[tuple[str, str]]:
    links, contact, start, run = scene.chain.links, scene.contact, scene.initial, scene.simulation
    count_text = f"{len(links)} link{'s' * (len(links) != 1)}"
    length, mass = sum(link.length for link in links), sum(link.mass for link in links)
    rubbing = friction_joints(scene)
    friction_text = f"; dry friction in joints {_values_text(rubbing)}" if rubbing else ""
    yield "chain", f"{count_text}, {length:g} m, {mass:g} kg; base {scene.chain.base}{friction_text}"
    box = [
        f"{wall} = {coordinate:g} m" for wall in WALLS if (coordinate := getattr(scene.box, wall)) is not None
    ]
    yield "walls", ", ".join([*box, *(wall.name for wall in scene.walls)]) or "none"
    law_text = f"{contact.model}, e = {contact.restitution:g}"
    stiffness_text = f"K = {contact.stiffness:g} {stiffness_unit('N/m', contact.exponent)}"
    mu = _friction(contact.friction or None, contact.static_friction or None)
    yield "contact", f"{', '.join([law_text, stiffness_text, *mu])}; points {_values_text(contact.points)}"
    materials = [line for name, material in contact.wall.items() if (line := _material(name, material))]
    if materials:
        yield "", "; ".join(materials)
    if scene.chain.stops:
        ends = scene.chain.joint_ranges.items()
        stops, law = scene.stops, scene.stops.model or contact.model
        stiffness_text = f"K = {stops.stiffness:g} {stiffness_unit('N·m/rad', stops.exponent)}"
        ranges = [f"joint {joint} {_range(low, high)}" for joint, (low, high) in ends]
        ranges = ranges if len(ranges) <= SHOWN_ENTRIES else [*ranges[: SHOWN_ENTRIES - 2], "…", ranges[-1]]
        yield "stops", f"{law}, e = {stops.restitution:g}, {stiffness_text}; {', '.join(ranges)}"
    if scene.signals:
        signal_texts = (f"{', '.join(signal.input)} by a {signal.form}" for signal in scene.signals.values())
        yield "signals", "; ".join(signal_texts)
    yield "start", f"base at {_values_text(start.position)} m, angles {_values_text(start.angles)} rad"
    solver_text = f"method {scene.solver.method}, tolerance {scene.solver.tolerance:g}"
    yield "run", f"{run.stop_time:g} s in steps of {run.step_size:g} s; {solver_text}"


def _material(name: str, material: Material) -> str:
    """Return a text such as "at y_min e = 0.5" with all values that ``material`` gives; "" without any."""
    parts = [] if material.restitution is None else [f"e = {material.restitution:g}"]
    parts += [] if material.stiffness is None else [f"K = {material.stiffness:g}"]
    parts += _friction(material.friction, material.static_friction)
    return f"at {name} {', '.join(parts)}" if parts else ""


def _friction(sliding_coefficient: float | None, static_coefficient: float | None) -> list[str]:
    """Return a text for each coefficient that is not None, such as "µ = 0.3" for sliding friction."""
    given_coefficients = {"µ": sliding_coefficient, "static µ": static_coefficient}
    return [f"{name} = {value:g}" for name, value in given_coefficients.items() if value is not None]


def _range(low: float, high: float) -> str:
    if math.isinf(low) or math.isinf(high):
        return f"≤ {high:g} rad" if math.isinf(low) else f"≥ {low:g} rad"
    return f"{low:g} to {high:g} rad"


def _values_text(values: Iterable[float]) -> str:
    texts = [f"{value:g}" for value in values]
    return ", ".join(texts if len(texts) <= SHOWN_ENTRIES else [*texts[: SHOWN_ENTRIES - 2], "…", texts[-1]])

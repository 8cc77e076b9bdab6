"""The list of the FMU's variables, and the codes of walls and statuses."""

from __future__ import annotations

import re
from collections.abc import Sequence

from chain_impact.kernel.record.constants import WALLS
from chain_impact.kernel.status import STATUS_NAME, STATUS_TEXT
from chain_impact.scene.facts import TRUE_FACT
from chain_impact.scene.scene import load_scene, scene_keys
from chain_impact.scene.texts.input_table import INPUT_KINDS
from chain_impact.scene.texts.names import AXES
from chain_impact.scene.texts.unit_text import unit_text
from chain_impact.variables.description_texts import GENERAL, LOSSES, STOP_TEXTS
from chain_impact.variables.kind import SLOPED_WALL, VariableKind
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.parameters import METHODS, PARAMETERS
from chain_impact.variables.scene_variables import choices_of
from docs.tools.markdown_text import code, short_description


def variable_patterns() -> str:
    """Return every kind of variable once, with letters in place of its indices."""
    key_meanings = {
        short_description(entry.metadata["description"]) for _, entry in scene_keys() if entry.metadata
    }
    sections = []
    for title, table_of in (("Parameters", PARAMETERS), ("Inputs", INPUTS), ("Outputs", OUTPUTS)):
        kinds_by_meaning: dict[str, list[VariableKind]] = {}
        for kind in (kind for of_one_owner in table_of for kind in of_one_owner.kinds):
            meaning = _meaning(kind)
            is_key = meaning in key_meanings and bool(kind.unit)
            tunable = "; tunable" if kind.tunable == TRUE_FACT else ""
            kinds_by_meaning.setdefault((SCENE_KEY if is_key else meaning) + tunable, []).append(kind)
        lines = (_variables(meaning, kinds) for meaning, kinds in kinds_by_meaning.items())
        sections.append(f"### {title}\n\n" + "\n".join(lines))
    return "\n\n".join(sections)


def _variables(meaning: str, kinds: Sequence[VariableKind]) -> str:
    """Return a line for kinds of one meaning: names, meaning and units; for scene keys the meaning first."""
    names = ", ".join(code(name) for name in dict.fromkeys(kind.pattern for kind in kinds))
    if meaning.startswith(SCENE_KEY):
        return f"- {meaning}: {names}"
    units = ", ".join(unit for unit in dict.fromkeys(unit_text(kind.unit) for kind in kinds) if unit)
    return f"- {names}: {meaning}" + (f" [{units}]" if units else "")


SCENE_KEY = "scene key"  # the list has these words for parameters that the page of the scene file explains
IN_GENERAL = {
    **STOP_TEXTS,
    **GENERAL,
    "axis": "x and y",
    "n": "i",
    "losses": LOSSES,
    "wall_numbers": "its [code](#codes)",
    "wall_numbers_if_any": "its [code](#codes)",
    "statuses": "see its [codes](troubleshooting.md#statuses-of-the-solver)",
}
"""Word in braces in descriptions → the text for it in the list."""
COMMON_MEANINGS = {
    "stops: least and largest angle": ("link[i].joint_min", "link[i].joint_max"),
    "position of the wall": tuple(f"box.{wall}" for wall in WALLS),
    "initial position and velocity of the base; a pinned base has no velocity": (
        *("initial.x", "initial.y", "initial.vx", "initial.vy"),
    ),
    "initial angle and angular velocity of link i, absolute, from +x": (
        *("initial.angle[i]", "initial.angular_velocity[i]"),
    ),
    "position, velocity and acceleration of the base": tuple(
        name for name, row in INPUT_KINDS.items() if row.key == "base_motion"
    ),
    "angle that the spring follows, and angular velocity that the damper follows": (
        *("joint[i].target_angle", "joint[i].target_velocity"),
    ),
    "motion along the inward normal n": (
        *("wall.<wall>.displacement", "wall.<wall>.velocity", "wall.<wall>.acceleration"),
    ),
    "position, velocity and acceleration": tuple(
        f"point[k].{prefix}{axis}" for prefix in ("", "v", "a") for axis in AXES
    ),
    "angle, angular velocity and angular acceleration, absolute, from +x": (
        *("link[i].angle", "link[i].angular_velocity", "link[i].angular_acceleration"),
    ),
    "moment of its stops, positive at joint_min, angle beyond a stop, and impulse since the start": (
        *("joint[i].stop_moment", "joint[i].stop_penetration", "joint[i].stop_impulse"),
    ),
    "distance moved along n, and by its belt along t = (n_y, -n_x)": (
        *("wall.<wall>.position", "wall.<wall>.belt_position"),
    ),
    "force, along its left normal, and moment of the line on the carriage": (
        *("slider.reaction", "slider.moment"),
    ),
    "angle and angular velocity, relative to the link before": (
        *("joint[i].angle", "joint[i].angular_velocity"),
    ),
    "position along the line, 0 at the start, velocity and acceleration": (
        *("slider.position", "slider.velocity", "slider.acceleration"),
    ),
    "position that the spring of the slider follows, and velocity that the damper follows": (
        *("slider.target_position", "slider.target_velocity"),
    ),
    "dry friction along t = (n_y, -n_x), and its impulse since the start": (
        *("contact[k].<wall>.friction_force", "contact[k].<wall>.friction_impulse"),
    ),
    "time, point, wall ([code](#codes)) and approach speed of the last impact; before the first "
    "the start, -1, 0 and 0; at a stop its joint, and rad/s": (
        *("impact.last_time", "impact.last_point", "impact.last_wall", "impact.last_speed"),
    ),
    "steps, rejected steps, evaluations of the equations, implicit steps": (
        *("solver.steps", "solver.rejected_steps", "solver.rhs_evaluations", "solver.implicit_steps"),
    ),
    "law of walls, and of stops without a law: its [number](contact_laws.md#the-laws)": ("contact.model",),
}
"""Meaning in the list → the variables that have this meaning in common."""
MEANINGS = {name: meaning for meaning, names in COMMON_MEANINGS.items() for name in names}


def _meaning(kind: VariableKind) -> str:
    """Return the description of a kind of variables for the list.

    The description leaves out what the variable's name or scene.md tells, and long lists of codes.
    """
    if kind.pattern in MEANINGS:
        return MEANINGS[kind.pattern]
    choices = choices_of(load_scene("four_link_box"))[METHODS] if kind.choices == METHODS else ()
    listed = ", ".join(f"{number} = {item.name}" for number, item in enumerate(choices, 1))
    heading = "wall at any angle: " if kind.heading == SLOPED_WALL else ""
    return heading + short_description(kind.text).format_map(IN_GENERAL) + (f": {listed}" if listed else "")


def walls() -> str:
    """Return the numbers of the walls in `impact.last_wall`."""
    box = ", ".join(f"{number} {code(wall)}" for number, wall in enumerate(WALLS, 1))
    return (
        f"0 none, {box}, {len(WALLS) + 1} and on the `[[walls]]` in their order, if a point can touch a "
        "wall; then `joint_min` and `joint_max`, if a joint has a stop: the point is then the joint; then "
        "the stops of a slider."
    )


def statuses() -> str:
    """Return the status codes of the solver; the messages themselves contain the remedies."""
    return "\n".join(
        f"- {n} {code(STATUS_NAME[n])}: {re.split(':|, as ', text)[0]}" for n, text in STATUS_TEXT.items()
    )

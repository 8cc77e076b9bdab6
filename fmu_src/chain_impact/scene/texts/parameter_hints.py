"""Hints on names that users set although they are no parameters: inputs, motions, and keys of signals."""

from __future__ import annotations

import re
from collections.abc import Collection

from chain_impact.scene.texts.input_table import input_key, without_drive
from chain_impact.scene.texts.names import has_form, is_like


def input_hint(name: str, advice: str) -> str:
    """Return a hint for the input ``name``, which the user sets like a parameter.

    ``advice`` are the words for how to give the input.
    """
    hint = f"it is an input: give it over time {advice}"
    if start := start_hint(name):
        return f"{hint}; {start}"
    parameter = without_drive(name)
    return f"{hint}; without, it is {parameter}, which can be set" if parameter else hint


POSITION_PARTS, ANGLE_PARTS = ("x", "y", "vx", "vy"), ("angle", "angular_velocity")
START_NAMES = {
    **{
        f"{owner}.{part}": f"initial.{part} sets it"
        for owner in ("base", "point[0]")
        for part in POSITION_PARTS
    },
    "base.position": "initial.x and initial.y set it",
    "base.velocity": "initial.vx and initial.vy set it",
    **{f"point[{{n}}].{part}": f"initial.{part} and initial.angle[1] … set it" for part in "xy"},
    **{f"link[{{n}}].{part}": f"initial.{part}[{{n}}] sets it" for part in ANGLE_PARTS},
    "joint[{n}].angle": "initial.angle[{n}] sets the absolute angle of link {n}",
    "joint[{n}].position": "initial.angle[{n}] sets the absolute angle of link {n}",
    "joint[{n}].angular_velocity": "initial.angular_velocity[{n}] sets that of link {n}, absolute,",
    "joint[{n}].velocity": "initial.angular_velocity[{n}] sets that of link {n}, absolute,",
    "slider.position": "with the base at initial.x and initial.y it is 0",
    "slider.velocity": "initial.slider_velocity sets it",
}
"""Quantity of a motion → words for the parameters that set its start value; {n} stands for the number of a
point, link or joint."""


def start_hint(name: str) -> str | None:
    """Return a hint which parameters set the start of a quantity in START_NAMES; None for another name."""
    for template, hint in START_NAMES.items():
        if is_like(name, template):
            return f"{hint.format(n=re.sub('[^0-9]', '', name))} at the start"
    return None


JOINT_ANGLES = "initial.joint_angles"


def parameter_hint(name: str, links: int, signals: Collection[str]) -> str | None:
    """Return a hint what to do in place of setting ``name``, which is not a parameter of the scene.

    The result is None if no hint is known.

    Args:
        name: the name that the user typed.
        links: the number of links.
        signals: the names of the scene's signals.
    """
    owner, _, key = name.partition(".")
    has_number = key and any(has_form(owner, form) for form in ("link[{n}]", "joint[{n}]"))
    if has_number and not 1 <= int(re.sub("[^0-9]", "", owner)) <= links:
        return f"{owner.partition('[')[0]}s count from 1 to {links}"
    if input_key(name):
        python_code = f'simulate(scene, inputs={{"{name}": 1.0}})'
        return input_hint(name, f"by a signal of the scene, by --inputs FILE, or in Python, {python_code}")
    if name.startswith(JOINT_ANGLES):
        return "set initial.angle[1] and so on: each is the sum of the joint angles up to it"
    start = start_hint(name)
    return f"it changes in the motion: {start}" if start else signal_hint(name, signals)


def signal_hint(name: str, signals: Collection[str]) -> str | None:
    """Return a hint how to make the signal that ``name``, of the form ``signal.<signal>.<key>``, needs.

    The result is None for a name of another form, and if ``signals`` has the signal.
    """
    table, _, key = name.partition(".")
    signal = key.partition(".")[0]
    if table not in ("signal", "signals") or not signal or signal in signals:
        return None
    return f"a signal is made in the scene file, in a table [signals.{signal}]: docs/drive.md tells how"

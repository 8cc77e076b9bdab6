"""The table of inputs: one row for each kind of input that a key of [inputs] adds to a scene.

A signal, a table file or a caller in Python drives an input over time. variables/outputs.py has the places of
the inputs in the record.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

from chain_impact.scene.texts.names import AXES, is_like, name_parts


class InputKind(NamedTuple):
    """One row of the table of inputs.

    In the templates, {n} stands for the number of a joint, and {name} for the name of a wall.

    Attributes:
        key: the key of [inputs] that adds the inputs.
        name: the template of the inputs' names.
        unit: the unit of the inputs.
        determined: the templates of the names of the quantities that a signal determines if it drives the
            input: integrals of the input over time, the input, and derivatives of the input, in this order;
            "" for an integral without a name.
        is_motion: whether the input is a position, velocity or acceleration of the base or of a wall. The
            speed of a belt is none of these.
        parameter: the template of the parameter that gives the input's value if nothing drives the input; ""
            if this value is 0.
    """

    key: str
    name: str
    unit: str
    determined: tuple[str, ...]
    is_motion: bool = False
    parameter: str = ""

    @property
    def exclusive(self) -> tuple[str, ...]:
        """The templates of the inputs that no other signal may drive if a signal drives the input.

        For a position, velocity or acceleration of the base along an axis, or of a wall, these are all three,
        because each determines the others; for any other input, only the input itself.
        """
        return self.determined if self.is_motion else (self.name,)


def _single(key: str, name: str, unit: str) -> InputKind:
    """Return the row of an input whose signal determines nothing else."""
    return InputKind(key, name, unit, (name,))


def _motion(key: str, *names: str, parameter: str = "") -> tuple[InputKind, ...]:
    """Return the rows of a motion, by the names of its position, velocity and acceleration."""
    position, velocity, acceleration = names
    return (
        InputKind(key, position, "m", names, is_motion=True, parameter=parameter),
        InputKind(key, velocity, "m/s", names, is_motion=True),
        InputKind(key, acceleration, "m/s2", names, is_motion=True),
    )


def _target(key: str, position: str, velocity: str, unit: str, parameter: str) -> tuple[InputKind, ...]:
    """Return the rows of the target of a drive: the position, in ``unit``, and the velocity."""
    return (
        InputKind(key, position, unit, (position, velocity), parameter=parameter),
        _single(key, velocity, f"{unit}/s"),
    )


_BELT_SPEED = "wall.{name}.belt_speed"
_ANGLE_TARGET = ("joint[{n}].target_angle", "joint[{n}].target_velocity", "rad", "link[{n}].joint_rest_angle")
_SLIDER_TARGET = ("slider.target_position", "slider.target_velocity", "m", "slider.rest_position")
_WALL_MOTION = ("wall.{name}.displacement", "wall.{name}.velocity", "wall.{name}.acceleration")
_BASE_MOTIONS = [
    _motion("base_motion", f"base.{axis}", f"base.v{axis}", f"base.a{axis}", parameter=f"initial.{axis}")
    for axis in AXES
]
_ROWS = (
    _single("joint_torques", "joint[{n}].torque", "N.m"),
    *_target("joint_targets", *_ANGLE_TARGET),
    *_target("joint_targets", *_SLIDER_TARGET),
    _single("slider_force", "slider.force", "N"),
    *(_single("tip_force", f"tip.force.{axis}", "N") for axis in AXES),
    *chain(*zip(*_BASE_MOTIONS, strict=True)),  # x and y of the position come first
    *_motion("wall_motion", *_WALL_MOTION),
    InputKind("wall_motion", _BELT_SPEED, "m/s", ("", _BELT_SPEED)),
)
INPUT_KINDS = {row.name: row for row in _ROWS}
"""Template of the names of inputs → the row of these inputs."""
INPUT_KEYS = tuple(dict.fromkeys(row.key for row in _ROWS))
"""The keys of [inputs]."""


@lru_cache(1024)
def input_kind(name: str) -> InputKind | None:
    """Return the row of the input ``name``; None if ``name`` has no form of an input."""
    return next((row for row in INPUT_KINDS.values() if is_like(name, row.name)), None)


def input_key(name: str) -> str | None:
    """Return the key of `[inputs]` that adds the input ``name``; None if ``name`` has no form of an input."""
    kind = input_kind(name)
    return kind.key if kind else None


def input_request(name: str) -> str | None:
    """Return the line of a scene file that adds the input ``name``; None if ``name`` has no form of an input.

    For example ``inputs.joint_torques = true`` for ``joint[2].torque``.
    """
    key = input_key(name)
    if key == "wall_motion":
        return f'inputs.wall_motion = ["{name.split(".")[1]}"]'
    return key and f"inputs.{key} = true"


def determined_quantities(name: str) -> tuple[str, ...]:
    """Return the names of the quantities that a signal determines if it drives the input ``name``.

    These are integrals of the input over time, the input, and derivatives of the input, in this order. All
    are names of inputs, except "" for the integral of a belt's speed, which has no name. A signal that drives
    a target velocity determines only this, not the target angle or position.
    """
    kind = input_kind(name)
    return tuple(_with_owner(template, name) for template in kind.determined) if kind else (name,)


def exclusive_inputs(name: str) -> tuple[str, ...]:
    """Return the inputs that no other signal may drive if a signal drives the input ``name``."""
    kind = input_kind(name)
    return tuple(_with_owner(template, name) for template in kind.exclusive) if kind else (name,)


def is_motion(name: str) -> bool:
    """Return whether the input ``name`` is a position, velocity or acceleration of the base or of a wall.

    The speed of a belt is none of these.
    """
    kind = input_kind(name)
    return kind is not None and kind.is_motion


def is_position(name: str) -> bool:
    """Return whether the input ``name`` is a coordinate of the base, or the displacement of a wall."""
    return is_motion(name) and determined_quantities(name)[0] == name


def without_drive(name: str) -> str | None:
    """Return the parameter that gives the value of the input ``name`` if nothing drives it.

    The result is None if this value is 0, and for any other name.
    """
    kind = input_kind(name)
    return _with_owner(kind.parameter, name) if kind and kind.parameter else None


def value_at_start(values: Mapping[str, Any], name: str) -> float:
    """Return the value of ``name`` at the start of a run; ``values`` is name → value of a scene.

    If ``values`` lacks the name, it is that of an input that nothing drives: the result is then the value of
    the input's parameter (``without_drive``), or 0 without one.
    """
    return float(values.get(name, values.get(without_drive(name) or "", 0.0)))


def _with_owner(template: str, name: str) -> str:
    """Return ``template`` with the number of the joint, or the name of the wall, of the input ``name``."""
    parts = name_parts(name)
    return template.format(n=parts.n, name=parts.name)

"""The inputs and outputs in the table of variables, a row for each kind; kind.py tells what a row says.

Their order is that of the value references.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from chain_impact.scene.names import AT, AXES, INPUTS_OF
from chain_impact.variables.kind import (
    CONTACT,
    IMPACT,
    JOINT,
    LINK,
    MOTION,
    MOTIONS,
    NEXT,
    POINT,
    WALL,
    Block,
    Kind,
    block,
)

ALONG = "along t = (n_y, -n_x)"


def _row(name: str, unit: str, text: str, field: str = "", **other: Any) -> Kind:
    """A row; the field of the record has the name unless it is given, with a dot for one in another."""
    steps = (int(step) if step.isdigit() else step for step in (field or name).split("."))
    return Kind(name=name, unit=unit, text=text, place=tuple(steps), **other)


def _block(
    part: str, of: str, owner: str, *rows: Kind, array: bool = False, terminal: bool = True, **other: Any
) -> Block:
    """A block of rows whose values are in one part of the record.

    Args:
        part: the part.
        of: the element.
        owner: what the names begin with.
        rows: the rows. The index of an element stands behind their fields, unless it stands there already.
        array: whether the values of all elements are an array, named after the element and the row.
        terminal: whether the variables of an owner make a terminal.
        other: attributes that all rows have.
    """
    kinds = []
    for row in rows:
        index = () if of == "one" or AT in row.place or NEXT in row.place else (AT,)
        name = row.array or (f"{of}.{row.name}" if array else "")
        kinds.append(replace(row, place=(part, *row.place, *index), array=name))
    return block(of, *kinds, owner=owner, terminal=terminal, **other)


def _inputs(
    part: str, of: str, owner: str, key: str, rows: Iterable[tuple[str, str, str, str]], **other: Any
) -> Block:
    """The inputs that a key of `[inputs]` makes: axis, unit, text and field, in the order of their names."""
    kinds = (
        _row(name.removeprefix(f"{owner}."), *row, axis=axis)
        for name, (axis, *row) in zip(INPUTS_OF[key], rows, strict=True)
    )
    return _block(part, of, owner, *kinds, causality="input", **other)


INPUTS = (
    _inputs(
        *("given", "joint", "joint[{n}]", "joint_torques"),
        [("", "N.m", "torque on link {n} from {before}", "joint_torque")],
        when=("inputs.joint_torques",),
    ),
    _inputs(
        *("given", "joint", "joint[{n}]", "joint_targets"),
        [
            ("", "rad", "angle that the spring of joint {n} follows", "joint_target_angle"),
            ("", "rad/s", "angular velocity that the damper of joint {n} follows", "joint_target_velocity"),
        ],
        when=("inputs.joint_targets",),
    ),
    _inputs(
        *("given", "one", "tip", "tip_force"),
        [(axis, "N", "{axis} of the force on the tip", f"tip_force.{j}") for j, axis in enumerate(AXES)],
        when=("inputs.tip_force",),
    ),
    _inputs(
        *(MOTION, "one", "base", "base_motion"),
        [
            (axis, unit, f"{{axis}} of the {field} of the base", f"{field}.{j}")
            for field, unit in zip(MOTIONS, ("m", "m/s", "m/s2"), strict=True)
            for j, axis in enumerate(AXES)
        ],
        when=("inputs.base_motion",),
    ),
    _inputs(
        *(MOTION, "moving wall", "wall.{name}", "wall_motion"),
        [
            ("", "m", "its displacement along its inward normal n", "position"),
            ("", "m/s", "its velocity along its inward normal n", "velocity"),
            ("", "m/s2", "its acceleration along its inward normal n", "acceleration"),
            ("", "m/s", f"speed of its belt {ALONG}", f"velocity.{NEXT}"),
        ],
        heading=WALL,
    ),
)
"""The inputs."""


def _points() -> Iterable[Kind]:
    rows: tuple[tuple[str, str, str, dict[str, Any]], ...] = (
        ("position", "", "m", {}),
        ("velocity", "v", "m/s", {"rate_of": "point_position"}),
        ("acceleration", "a", "m/s2", {"rate_of": "point_velocity", "at_once": True}),
    )
    for quantity, prefix, unit, other in rows:
        text, array = f"{{axis}} of the {quantity}", f"point.{quantity}"
        for j, axis in enumerate(AXES):
            field = f"point_{quantity}.{AT}.{j}"
            yield _row(f"{prefix}{axis}", unit, text, field, axis=axis, array=array, **other)


def _sticking(field: str) -> Kind:
    """Whether something sticks. It is a real number, which FMI lets change at any time."""
    text = "1 while it sticks by dry friction, else 0"
    return _row("sticking", "1", text, f"friction.{field}", minimum=0.0, maximum=1.0, at_once=True)


def _loads(name: str, unit: str, text: str, field: str, **other: Any) -> list[Kind]:
    """The components of a load."""
    return [
        _row(f"{name}.{axis}", unit, text, f"load.{field}{axis}", axis=axis, nominal="momentum", **other)
        for axis in AXES
    ]


OUTPUTS = (
    _block(
        *("output", "point", "point[{n}]"),
        *_points(),
        heading=POINT,
        when=("outputs.points",),
        nominal="size",
    ),
    _block(
        *("output", "link", "link[{n}]"),
        _row("angle", "rad", "angle, absolute, from +x"),
        _row("angular_velocity", "rad/s", "angular velocity, absolute", rate_of="angle"),
        _row(
            *("angular_acceleration", "rad/s2", "angular acceleration, absolute"),
            rate_of="angular_velocity",
            at_once=True,
        ),
        heading=LINK,
        when=("outputs.links",),
        array=True,
        terminal=False,
    ),
    _block(
        *("output", "joint", "joint[{n}]"),
        _row("angle", "rad", "angle of link {n} relative to {parent}{from_x}", "joint_angle"),
        _row(
            *("angular_velocity", "rad/s", "angular velocity of link {n} relative to {parent}{from_x}"),
            "joint_angular_velocity",
            rate_of="joint_angle",
        ),
        heading=JOINT,
    ),
    _block(
        *("output", "contact", "contact[{n}].{name}"),
        _row("force", "N", "force of the wall, along its normal", nominal="force", at_once=True),
        _row("penetration", "m", "penetration, 0 when apart", nominal="depth", minimum=0.0),
        _row(
            *("penetration_rate", "m/s", "rate of penetration, positive when closing, 0 when apart"),
            nominal="size",
        ),
        _row("impulse", "N.s", "impulse of the wall since the start, along its normal", nominal="momentum"),
        _row(
            *("friction_force", "N", f"dry friction of the wall, {ALONG} of its normal n", "friction.force"),
            nominal="force",
            at_once=True,
            when=("contact_friction",),
        ),
        _row(
            *("friction_impulse", "N.s", f"impulse of dry friction since the start, {ALONG} of its normal n"),
            "friction.impulse",
            nominal="momentum",
            when=("contact_friction",),
        ),
        replace(_sticking("sticking"), when=("contact_friction",)),
        heading=CONTACT,
        when=("outputs.contacts",),
        array=True,
        terminal=False,
    ),
    _block(
        *("output", "moving wall", "wall.{name}"),
        _row("position", "m", "how far it has moved along its inward normal n", "channel"),
        _row("belt_position", "m", f"how far its belt has moved {ALONG}", f"channel.{NEXT}"),
        heading=WALL,
        when=("outputs.contacts",),
    ),
    _block(
        *("output", "stop", "joint[{n}]"),
        _row(
            *("stop_moment", "N.m", "moment of its stops, positive at joint_min", "force"),
            nominal="stop moment",
            at_once=True,
        ),
        _row(
            *("stop_penetration", "rad", "angle beyond a stop, 0 when apart", "penetration"),
            nominal="stop depth",
            minimum=0.0,
        ),
        _row(
            *(
                "stop_impulse",
                "N.m.s",
                "impulse of its stops since the start, positive at joint_min",
                "impulse",
            ),
            nominal="energy",
        ),
        heading=JOINT,
        when=("outputs.contacts",),
    ),
    _block(
        *("output", "rubbing joint", "joint[{n}]"),
        _row(
            *("friction_moment", "N.m", "moment of dry friction on link {n}", "friction.joint_moment"),
            nominal="energy",
            at_once=True,
        ),
        _sticking("joint_sticking"),
        heading=JOINT,
        when=("outputs.contacts",),
    ),
    _block(
        *("output", "one", "energy"),
        _row("kinetic", "J", "kinetic energy", minimum=0.0),
        _row("potential", "J", "potential energy of gravity, zero at the origin"),
        _row("elastic", "J", "energy stored in the contacts and in the springs of joints"),
        _row("dissipated", "J", "energy lost in {losses} since the start"),
        _row(
            *("supplied", "J", "energy supplied by the inputs and by drives of joints since the start"),
            when=("driven",),
        ),
        _row("total", "J", "kinetic, potential and elastic energy"),
        _row(
            *("friction", "J", "energy lost in dry friction since the start, part of energy.dissipated"),
            "friction.dissipated",
            when=("friction",),
        ),
        when=("outputs.energies",),
        nominal="energy",
        terminal=False,
    ),
    _block(
        *("output", "joint", "joint[{n}]"),
        *_loads("force", "N", "{axis} of the force of {parent} on link {n}", "", at_once=True),
        _row(
            *("moment", "N.m", "moment of {parent} on link {n}: drive, spring, damper, friction and stops"),
            "load.moment",
            nominal="energy",
            at_once=True,
        ),
        *_loads(
            "impulse", "N.s", "{axis} of the impulse of {parent} on link {n} since the start", "impulse_"
        ),
        _row(
            *("peak_force", "N", "largest force of {parent} on link {n} since the start", "load.peak"),
            nominal="momentum",
            minimum=0.0,
        ),
        heading=JOINT,
        when=("outputs.loads",),
    ),
    _block(
        *("output", "touched wall", "wall.{name}"),
        *_loads("load", "N", "{axis} of the force of the chain on the wall", "", at_once=True),
        _row(
            *("load_moment", "N.m", "moment of the chain on the wall, about {about}", "load.moment"),
            nominal="energy",
            at_once=True,
        ),
        heading=WALL,
        when=("outputs.loads",),
    ),
    _block(
        *("impact", "one", "impact"),
        _row("count", "", "impacts since the start", minimum=0),
        _row("last_time", "s", "time of the last impact, of the start before the first"),
        _row(
            *("last_point", "", "point of the last impact, -1 before the first{its_joint}"),
            minimum=-1,
            maximum="links",
        ),
        _row("last_wall", "", "wall of the last impact: {wall_numbers}", minimum=0, maximum="walls"),
        _row(
            *("last_speed", "m/s", "approach speed at the last impact, 0 before the first{in_rad_s}"),
            minimum=0.0,
        ),
        terminal=False,
    ),
    _block(
        *("latest", "impact", "impact[{n}]"),
        _row("time", "s", "time of its onset, 0 if there is none"),
        _row("point", "", "point, -1 if there is none{its_joint}", minimum=-1, maximum="links"),
        _row("wall", "", "wall: {wall_numbers_if_any}", minimum=0, maximum="walls"),
        _row("speed", "m/s", "approach speed at its onset{in_rad_s}", nominal="size", minimum=0.0),
        _row("end", "s", "time of its end, the present time if it lasts"),
        _row(
            *("separation_speed", "m/s"),
            "speed from the wall at its end, the present one if it lasts{in_rad_s}",
            nominal="size",
        ),
        _row(
            *("peak_force", "N", "largest force so far, 0 for an impulse of a rigid wall{in_n_m}"),
            nominal="force",
            minimum=0.0,
            at_once=True,
        ),
        _row("max_penetration", "m", "largest penetration so far{in_rad}", nominal="depth", minimum=0.0),
        _row("impulse", "N.s", "impulse of the wall so far{in_n_m_s}", nominal="momentum"),
        heading=IMPACT,
        array=True,
        terminal=False,
    ),
    _block(
        *("statistics", "one", "solver"),
        _row("steps", "", "accepted steps of the solver"),
        _row("rejected_steps", "", "rejected steps of the solver"),
        _row("rhs_evaluations", "", "evaluations of the equations of motion by the solver"),
        _row("implicit_steps", "", "accepted implicit steps"),
        _row("status", "", "status of the solver: {statuses}", maximum="most_status"),
        when=("outputs.solver",),
        minimum=0,
        terminal=False,
    ),
)
"""The outputs, but for derivatives."""

"""The inputs and outputs in the table of variables, one row for each kind; kind.py explains the attributes.

The cells of a row are the name without the prefix, the unit, the description, and attributes. Attributes are
those of ``Kind``, and ``field``: the path of the record's field in its part, if it is not the name in the
row. Rows of inputs lack name and unit, which ``INPUTS_OF`` has. A row with {axis} stands for two rows: for x,
where {j} is 0, and for y, where {j} is 1. The value references follow the order of the rows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from chain_impact.scene.names import AT, AXES, INPUTS_OF
from chain_impact.variables.kind import (
    CONTACT,
    IMPACT,
    JOINT,
    LINK,
    MOTION,
    NEXT,
    POINT,
    SLIDER,
    WALL,
    Block,
    Kind,
    block,
)


def _block(
    *,
    part: str,
    owner_kind: str,
    prefix: str,
    rows: str,
    names: Mapping[str, str] = MappingProxyType({}),
    array: bool = False,
    **other: Any,
) -> Block:
    """Return a block of kinds whose values are in one part of the record.

    Args:
        part: the part of the record.
        owner_kind: the kind of owner.
        prefix: the first part of the names.
        rows: the rows of the table. ``{at}``, the index of the owner, is appended to the path of a field that
            has neither ``{at}`` nor ``{next}``, unless ``owner_kind`` is "one" or "slider".
        names: whole name → unit, for rows that lack name and unit: row k has the k-th name that begins with
            ``prefix``.
        array: whether the values of all owners form an array with the name <owner_kind>.<name in the row>.
        other: attributes that all kinds have, and further arguments of ``block``.
    """
    kinds, head = list[Kind](), f"{prefix}."
    given = [(name.removeprefix(head), unit) for name, unit in names.items() if name.startswith(head)]
    for number, (axis, cells) in enumerate(_rows(rows)):
        whole = (*given[number], *cells) if given else cells
        try:
            kinds.append(_kind(part, owner_kind, axis, array, whole))
        except (TypeError, ValueError) as error:
            raise ValueError(f"the row {' | '.join(whole)!r} of {prefix or part} is wrong: {error}") from None
    return block(owner_kind, *kinds, prefix=prefix, **{"is_terminal": True} | other)


def _kind(part: str, owner_kind: str, axis: str, array: bool, cells: Sequence[str]) -> Kind:
    """Return the kind that the cells of one row describe; wrong cells raise TypeError or ValueError."""
    name, unit, text, *more = cells
    attributes: dict[str, Any] = {"array": f"{owner_kind}.{name}" if array else "", "field": name}
    attributes |= dict(_attribute(attribute, unit) for cell in more for attribute in cell.split())
    name, field = (template.replace("{axis}", axis) for template in (name, attributes.pop("field")))
    steps = [int(step) if step.isdecimal() else step for step in field.split(".")]
    index = [] if owner_kind in ("one", "slider") or AT in steps or NEXT in steps else [AT]
    path = (part, *steps, *index)
    return Kind(name=name, unit=unit, text=text, record_path=path, axis=axis, **attributes)


def _rows(text: str) -> Iterator[tuple[str, list[str]]]:
    """Yield (axis, cells) for each row of the table ``text``.

    A row with {axis} is yielded for x and for y; the axis of any other row is "".
    """
    for line in text.strip().splitlines():
        for j, axis in enumerate(AXES if "{axis}" in line else ("",)):
            yield axis, [cell.strip().replace("{j}", str(j)) for cell in line.split("|")]


def _attribute(text: str, unit: str) -> tuple[str, Any]:
    """Return the name and value of an attribute that a row has as text, such as ``minimum=0``.

    An attribute without "=" has the value True. The value of ``minimum`` or ``maximum`` is a float if the row
    has a ``unit``, else an int, or the name of a number; that of ``when`` is a tuple. All others are texts.
    """
    name, _, value = text.partition("=")
    if name == "when":
        return name, (value,)
    if name in ("minimum", "maximum") and not value.isidentifier():
        return name, float(value) if unit else int(value)
    return name, value or True


INPUTS = (
    _block(
        part="given",
        owner_kind="joint",
        prefix="joint[{n}]",
        rows="torque on link {n} from {before} | field=motor",
        names=INPUTS_OF["joint_torques"],
        when=("inputs.joint_torques",),
        causality="input",
    ),
    _block(
        part="given",
        owner_kind="joint",
        prefix="joint[{n}]",
        rows="""
        angle that the spring of joint {n} follows            | field=target
        angular velocity that the damper of joint {n} follows | field=target_velocity
        """,
        names=INPUTS_OF["joint_targets"],
        when=("inputs.joint_targets",),
        causality="input",
    ),
    _block(
        part="given",
        owner_kind="slider",
        prefix="slider",
        rows="force on the carriage, along the line | field=motor.{at}",
        names=INPUTS_OF["slider_force"],
        heading=SLIDER,
        when=("inputs.slider_force",),
        causality="input",
    ),
    _block(
        part="given",
        owner_kind="slider",
        prefix="slider",
        rows="""
        position that the spring of the slider follows | field=target.{at}
        velocity that the damper of the slider follows | field=target_velocity.{at}
        """,
        names=INPUTS_OF["joint_targets"],
        heading=SLIDER,
        when=("inputs.joint_targets",),
        causality="input",
    ),
    _block(
        part="given",
        owner_kind="one",
        prefix="tip",
        rows="{axis} of the force on the tip | field=tip_force.{j}",
        names=INPUTS_OF["tip_force"],
        when=("inputs.tip_force",),
        causality="input",
    ),
    _block(
        part=MOTION,
        owner_kind="one",
        prefix="base",
        rows="""
        {axis} of the position of the base     | field=position.{j}
        {axis} of the velocity of the base     | field=velocity.{j}
        {axis} of the acceleration of the base | field=acceleration.{j}
        """,
        names=INPUTS_OF["base_motion"],
        when=("inputs.base_motion",),
        causality="input",
    ),
    _block(
        part=MOTION,
        owner_kind="moving wall",
        prefix="wall.{name}",
        rows="""
        its displacement along its inward normal n | field=position
        its velocity along its inward normal n     | field=velocity
        its acceleration along its inward normal n | field=acceleration
        speed of its belt along t = (n_y, -n_x)    | field=velocity.{next}
        """,
        names=INPUTS_OF["wall_motion"],
        heading=WALL,
        causality="input",
    ),
)
"""The kinds of all inputs that scenes can ask for."""

OUTPUTS = (
    _block(
        part="output",
        owner_kind="point",
        prefix="point[{n}]",
        rows="""
        {axis}  | m    | {axis} of the position     | field=point_position.{at}.{j} nominal=size array=point.position
        v{axis} | m/s  | {axis} of the velocity     | field=point_velocity.{at}.{j} nominal=size array=point.velocity rate_of=point_position
        a{axis} | m/s2 | {axis} of the acceleration | field=point_acceleration.{at}.{j} nominal=size array=point.acceleration rate_of=point_velocity feedthrough
        """,
        heading=POINT,
        when=("outputs.points",),
    ),
    _block(
        part="output",
        owner_kind="link",
        prefix="link[{n}]",
        rows="""
        angle                | rad    | angle, absolute, from +x
        angular_velocity     | rad/s  | angular velocity, absolute     | rate_of=angle
        angular_acceleration | rad/s2 | angular acceleration, absolute | rate_of=angular_velocity feedthrough
        """,
        heading=LINK,
        when=("outputs.links",),
        array=True,
        is_terminal=False,
    ),
    _block(
        part="output",
        owner_kind="joint",
        prefix="joint[{n}]",
        rows="""
        angle            | rad   | angle of link {n} relative to {parent}{from_x}            | field=joint_angle
        angular_velocity | rad/s | angular velocity of link {n} relative to {parent}{from_x} | field=joint_angular_velocity rate_of=joint_angle
        """,
        heading=JOINT,
    ),
    _block(
        part="output",
        owner_kind="slider",
        prefix="slider",
        rows="""
        position     | m    | position along the line, 0 at the start | field=slider_position nominal=size
        velocity     | m/s  | velocity along the line                 | field=slider_velocity nominal=size rate_of=slider_position
        acceleration | m/s2 | acceleration along the line             | field=slider_acceleration nominal=size rate_of=slider_velocity feedthrough
        """,
        heading=SLIDER,
    ),
    _block(
        part="output",
        owner_kind="slider",
        prefix="slider",
        rows="""
        friction_force | N | dry friction on the carriage, along the line | field=friction.drive_friction.{at} nominal=force feedthrough
        sticking       | 1 | 1 while it sticks by dry friction, else 0    | field=friction.drive_sticking.{at} feedthrough minimum=0 maximum=1
        """,
        heading=SLIDER,
        when=("outputs.contacts", "may_have_friction"),
    ),
    _block(
        part="output",
        owner_kind="contact",
        prefix="contact[{n}].{name}",
        rows="""
        force            | N   | force of the wall, along its normal                                            | nominal=force feedthrough
        penetration      | m   | penetration, 0 when apart                                                      | nominal=depth minimum=0
        penetration_rate | m/s | rate of penetration, positive when closing, 0 when apart                       | nominal=size
        impulse          | N.s | impulse of the wall since the start, along its normal                          | nominal=momentum
        friction_force   | N   | dry friction of the wall, along t = (n_y, -n_x) of its normal n                | field=friction.force nominal=force feedthrough when=may_have_friction
        friction_impulse | N.s | impulse of dry friction since the start, along t = (n_y, -n_x) of its normal n | field=friction.impulse nominal=momentum when=may_have_friction
        sticking         | 1   | 1 while it sticks by dry friction, else 0                                      | field=friction.sticking feedthrough when=may_have_friction minimum=0 maximum=1
        """,
        heading=CONTACT,
        when=("outputs.contacts",),
        array=True,
        is_terminal=False,
    ),
    _block(
        part="output",
        owner_kind="moving wall",
        prefix="wall.{name}",
        rows="""
        position      | m | distance moved along its inward normal n         | field=channel
        belt_position | m | how far its belt has moved along t = (n_y, -n_x) | field=channel.{next}
        """,
        heading=WALL,
        when=("outputs.contacts",),
    ),
    _block(
        part="output",
        owner_kind="stop",
        prefix="joint[{n}]",
        rows="""
        stop_moment      | N.m   | moment of its stops, positive at joint_min                  | field=force nominal=stop_moment feedthrough
        stop_penetration | rad   | angle beyond a stop, 0 when apart                           | field=penetration nominal=stop_depth minimum=0
        stop_impulse     | N.m.s | impulse of its stops since the start, positive at joint_min | field=impulse nominal=angular_momentum
        """,
        heading=JOINT,
        when=("outputs.contacts",),
    ),
    _block(
        part="output",
        owner_kind="joint with friction",
        prefix="joint[{n}]",
        rows="""
        friction_moment | N.m | moment of dry friction on link {n}        | field=friction.drive_friction nominal=inertial_moment feedthrough
        sticking        | 1   | 1 while it sticks by dry friction, else 0 | field=friction.drive_sticking feedthrough minimum=0 maximum=1
        """,
        heading=JOINT,
        when=("outputs.contacts",),
    ),
    _block(
        part="output",
        owner_kind="one",
        prefix="energy",
        rows="""
        kinetic    | J | kinetic energy                                                         | nominal=energy minimum=0
        potential  | J | potential energy of gravity, zero at the origin                        | nominal=energy
        elastic    | J | energy stored in the contacts and in the springs of joints             | nominal=energy
        dissipated | J | energy lost in {losses} since the start                                | nominal=energy
        supplied   | J | energy supplied by the inputs and by drives of joints since the start  | nominal=energy when=supply
        total      | J | kinetic, potential and elastic energy                                  | nominal=energy
        friction   | J | energy lost in dry friction since the start, part of energy.dissipated | field=friction.dissipated nominal=energy when=friction
        """,
        when=("outputs.energies",),
        is_terminal=False,
    ),
    _block(
        part="output",
        owner_kind="joint",
        prefix="joint[{n}]",
        rows="""
        force.{axis}   | N   | {axis} of the force of {parent} on link {n}                               | field=load.{axis} nominal=inertial_force feedthrough
        moment         | N.m | moment of {parent} on link {n}: drive, spring, damper, friction and stops | field=load.moment nominal=inertial_moment feedthrough
        impulse.{axis} | N.s | {axis} of the impulse of {parent} on link {n} since the start             | field=load.impulse_{axis} nominal=momentum
        peak_force     | N   | largest force of {parent} on link {n} since the start                     | field=load.peak nominal=inertial_force minimum=0
        peak_time      | s   | time of peak_force                                                        | field=load.peak_time
        """,
        heading=JOINT,
        when=("outputs.loads",),
    ),
    _block(
        part="output",
        owner_kind="slider",
        prefix="slider",
        rows="""
        reaction | N   | force of the line on the carriage, along its left normal | field=slider_reaction nominal=inertial_force feedthrough
        moment   | N.m | moment of the line on the carriage                       | field=slider_moment nominal=inertial_moment feedthrough
        """,
        heading=SLIDER,
        when=("outputs.loads",),
    ),
    _block(
        part="output",
        owner_kind="touched wall",
        prefix="wall.{name}",
        rows="""
        load.{axis} | N   | {axis} of the force of the chain on the wall   | field=load.{axis} nominal=inertial_force feedthrough
        load_moment | N.m | moment of the chain on the wall, about {about} | field=load.moment nominal=inertial_moment feedthrough
        """,
        heading=WALL,
        when=("outputs.loads",),
    ),
    _block(
        part="impact",
        owner_kind="one",
        prefix="impact",
        rows="""
        count      |     | impacts since the start                                         | minimum=0
        last_time  | s   | time of the last impact, of the start before the first
        last_point |     | point of the last impact, -1 before the first{its_joint}        | minimum=-1 maximum=points
        last_wall  |     | wall of the last impact: {wall_numbers}                         | minimum=0 maximum=walls
        last_speed | m/s | approach speed at the last impact, 0 before the first{in_rad_s} | minimum=0
        """,
        is_terminal=False,
    ),
    _block(
        part="latest",
        owner_kind="impact",
        prefix="impact[{n}]",
        rows="""
        time             | s   | time of its onset, 0 if there is none
        point            |     | point, -1 if there is none{its_joint}                                 | minimum=-1 maximum=points
        wall             |     | wall: {wall_numbers_if_any}                                           | minimum=0 maximum=walls
        speed            | m/s | approach speed at its onset{in_rad_s}                                 | nominal=size minimum=0
        end              | s   | time of its end, the present time if it lasts
        separation_speed | m/s | speed from the wall at its end, the present one if it lasts{in_rad_s} | nominal=size
        peak_force       | N   | largest force so far, 0 for an impulse of a rigid wall{in_n_m}        | nominal=force minimum=0 feedthrough
        max_penetration  | m   | largest penetration so far{in_rad}                                    | nominal=depth minimum=0
        impulse          | N.s | impulse of the wall so far{in_n_m_s}                                  | nominal=momentum
        """,
        heading=IMPACT,
        array=True,
        is_terminal=False,
    ),
    _block(
        part="statistics",
        owner_kind="one",
        prefix="solver",
        rows="""
        steps           |  | accepted steps of the solver                         | minimum=0
        rejected_steps  |  | rejected steps of the solver                         | minimum=0
        rhs_evaluations |  | evaluations of the equations of motion by the solver | minimum=0
        implicit_steps  |  | accepted implicit steps                              | minimum=0
        status          |  | status of the solver: {statuses}                     | minimum=0 maximum=most_status
        """,
        when=("outputs.solver",),
        is_terminal=False,
    ),
)
"""The kinds of all outputs that scenes can have, without derivatives."""

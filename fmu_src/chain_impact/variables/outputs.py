"""The inputs and outputs in the table of variables, one row for each kind; kind.py explains the columns.

A row has the name without the prefix, the unit, the description, the field of the record if its name differs,
the nominal magnitude, and further attributes. A row with {axis} stands for two rows, one for x and one for y;
{j} is then 0 and 1. The value references follow the order of the rows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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

COLUMNS = 6


def _block(
    *,
    part: str,
    of: str,
    prefix: str,
    rows: str,
    names: Mapping[str, str] = MappingProxyType({}),
    array: bool = False,
    **other: Any,
) -> Block:
    """Return a block of kinds whose values are in one part of the record.

    Args:
        part: the part of the record.
        of: the kind of owner.
        prefix: the first part of the names.
        rows: the rows of the table. The index of the owner is appended to each field without an index.
        names: full name → unit, if the rows have no names and no units; only names with the prefix count.
        array: whether the values of all owners form an array, named after the owner and the row.
        other: attributes that all kinds have; see also ``block``.
    """
    kinds, head = [], f"{prefix}."
    given = [(name.removeprefix(head), unit) for name, unit in names.items() if name.startswith(head)]
    for number, (name, its_unit, text, field, nominal, more, axis) in enumerate(_rows(rows)):
        member, unit = given[number] if given else (name, its_unit)
        steps = [int(step) if step.isdecimal() else step for step in (field or member).split(".")]
        index = [] if of in ("one", "slider") or AT in steps or NEXT in steps else [AT]
        attributes: dict[str, Any] = {"array": f"{of}.{member}" if array else "", "nominal": nominal}
        attributes |= dict(_attribute(attribute, unit) for attribute in more.split())
        path = (part, *steps, *index)
        kinds.append(Kind(name=member, unit=unit, text=text, record_path=path, axis=axis, **attributes))
    return block(of, *kinds, prefix=prefix, **{"is_terminal": True} | other)


def _rows(text: str) -> Iterator[list[str]]:
    """Yield the cells of each row, with empty text for a missing cell, and the axis."""
    for line in text.strip().splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        name, unit, said, *others = cells + [""] * (COLUMNS - len(cells))
        for j, axis in enumerate(AXES if "{axis}" in line else ("",)):
            filled = (cell.replace("{axis}", axis).replace("{j}", str(j)) for cell in others)
            yield [name.replace("{axis}", axis), unit, said, *filled, axis]


def _attribute(text: str, unit: str) -> tuple[str, Any]:
    """Return the name and value of an attribute in a row, such as ``minimum=0``.

    An attribute without a value is true.
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
        of="joint",
        prefix="joint[{n}]",
        rows=" | | torque on link {n} from {before} | joint_torque",
        names=INPUTS_OF["joint_torques"],
        when=("inputs.joint_torques",),
        causality="input",
    ),
    _block(
        part="given",
        of="joint",
        prefix="joint[{n}]",
        rows="""
        | | angle that the spring of joint {n} follows            | joint_target_angle
        | | angular velocity that the damper of joint {n} follows | joint_target_velocity
        """,
        names=INPUTS_OF["joint_targets"],
        when=("inputs.joint_targets",),
        causality="input",
    ),
    _block(
        part="given",
        of="slider",
        prefix="slider",
        rows=" | | force on the carriage, along the line | slider_force.0",
        names=INPUTS_OF["slider_force"],
        heading=SLIDER,
        when=("inputs.slider_force",),
        causality="input",
    ),
    _block(
        part="given",
        of="slider",
        prefix="slider",
        rows="""
        | | position that the spring of the slider follows | slider_target_position.0
        | | velocity that the damper of the slider follows | slider_target_velocity.0
        """,
        names=INPUTS_OF["joint_targets"],
        heading=SLIDER,
        when=("inputs.joint_targets",),
        causality="input",
    ),
    _block(
        part="given",
        of="one",
        prefix="tip",
        rows=" | | {axis} of the force on the tip | tip_force.{j}",
        names=INPUTS_OF["tip_force"],
        when=("inputs.tip_force",),
        causality="input",
    ),
    _block(
        part=MOTION,
        of="one",
        prefix="base",
        rows="""
        | | {axis} of the position of the base     | position.{j}
        | | {axis} of the velocity of the base     | velocity.{j}
        | | {axis} of the acceleration of the base | acceleration.{j}
        """,
        names=INPUTS_OF["base_motion"],
        when=("inputs.base_motion",),
        causality="input",
    ),
    _block(
        part=MOTION,
        of="moving wall",
        prefix="wall.{name}",
        rows="""
        | | its displacement along its inward normal n | position
        | | its velocity along its inward normal n     | velocity
        | | its acceleration along its inward normal n | acceleration
        | | speed of its belt along t = (n_y, -n_x)    | velocity.{next}
        """,
        names=INPUTS_OF["wall_motion"],
        heading=WALL,
        causality="input",
    ),
)
"""The inputs."""

OUTPUTS = (
    _block(
        part="output",
        of="point",
        prefix="point[{n}]",
        rows="""
        {axis}  | m    | {axis} of the position     | point_position.{at}.{j}     | size | array=point.position
        v{axis} | m/s  | {axis} of the velocity     | point_velocity.{at}.{j}     | size | array=point.velocity rate_of=point_position
        a{axis} | m/s2 | {axis} of the acceleration | point_acceleration.{at}.{j} | size | array=point.acceleration rate_of=point_velocity feedthrough
        """,
        heading=POINT,
        when=("outputs.points",),
    ),
    _block(
        part="output",
        of="link",
        prefix="link[{n}]",
        rows="""
        angle                | rad    | angle, absolute, from +x
        angular_velocity     | rad/s  | angular velocity, absolute     |  |  | rate_of=angle
        angular_acceleration | rad/s2 | angular acceleration, absolute |  |  | rate_of=angular_velocity feedthrough
        """,
        heading=LINK,
        when=("outputs.links",),
        array=True,
        is_terminal=False,
    ),
    _block(
        part="output",
        of="joint",
        prefix="joint[{n}]",
        rows="""
        angle            | rad   | angle of link {n} relative to {parent}{from_x}            | joint_angle
        angular_velocity | rad/s | angular velocity of link {n} relative to {parent}{from_x} | joint_angular_velocity |  | rate_of=joint_angle
        """,
        heading=JOINT,
    ),
    _block(
        part="output",
        of="slider",
        prefix="slider",
        rows="""
        position     | m    | position along the line, 0 at the start | slider_position     | size
        velocity     | m/s  | velocity along the line                 | slider_velocity     | size | rate_of=slider_position
        acceleration | m/s2 | acceleration along the line             | slider_acceleration | size | rate_of=slider_velocity feedthrough
        """,
        heading=SLIDER,
    ),
    _block(
        part="output",
        of="slider",
        prefix="slider",
        rows="""
        friction_force | N | dry friction on the carriage, along the line | friction.joint_or_slider_friction.{at}   | force | feedthrough
        sticking       | 1 | 1 while it sticks by dry friction, else 0    | friction.joint_or_slider_sticking.{at} |       | feedthrough minimum=0 maximum=1
        """,
        heading=SLIDER,
        when=("outputs.contacts", "rubs"),
    ),
    _block(
        part="output",
        of="contact",
        prefix="contact[{n}].{name}",
        rows="""
        force            | N   | force of the wall, along its normal                                            |                   | force    | feedthrough
        penetration      | m   | penetration, 0 when apart                                                      |                   | depth    | minimum=0
        penetration_rate | m/s | rate of penetration, positive when closing, 0 when apart                       |                   | size
        impulse          | N.s | impulse of the wall since the start, along its normal                          |                   | momentum
        friction_force   | N   | dry friction of the wall, along t = (n_y, -n_x) of its normal n                | friction.force    | force    | feedthrough when=rubs
        friction_impulse | N.s | impulse of dry friction since the start, along t = (n_y, -n_x) of its normal n | friction.impulse  | momentum | when=rubs
        sticking         | 1   | 1 while it sticks by dry friction, else 0                                      | friction.sticking |          | feedthrough when=rubs minimum=0 maximum=1
        """,
        heading=CONTACT,
        when=("outputs.contacts",),
        array=True,
        is_terminal=False,
    ),
    _block(
        part="output",
        of="moving wall",
        prefix="wall.{name}",
        rows="""
        position      | m | distance moved along its inward normal n         | channel
        belt_position | m | how far its belt has moved along t = (n_y, -n_x) | channel.{next}
        """,
        heading=WALL,
        when=("outputs.contacts",),
    ),
    _block(
        part="output",
        of="stop",
        prefix="joint[{n}]",
        rows="""
        stop_moment      | N.m   | moment of its stops, positive at joint_min                  | force       | stop moment | feedthrough
        stop_penetration | rad   | angle beyond a stop, 0 when apart                           | penetration | stop depth  | minimum=0
        stop_impulse     | N.m.s | impulse of its stops since the start, positive at joint_min | impulse     | energy
        """,
        heading=JOINT,
        when=("outputs.contacts",),
    ),
    _block(
        part="output",
        of="rubbing joint",
        prefix="joint[{n}]",
        rows="""
        friction_moment | N.m | moment of dry friction on link {n}        | friction.joint_or_slider_friction   | energy | feedthrough
        sticking        | 1   | 1 while it sticks by dry friction, else 0 | friction.joint_or_slider_sticking |        | feedthrough minimum=0 maximum=1
        """,
        heading=JOINT,
        when=("outputs.contacts",),
    ),
    _block(
        part="output",
        of="one",
        prefix="energy",
        rows="""
        kinetic    | J | kinetic energy                                                         |                     | energy | minimum=0
        potential  | J | potential energy of gravity, zero at the origin                        |                     | energy
        elastic    | J | energy stored in the contacts and in the springs of joints             |                     | energy
        dissipated | J | energy lost in {losses} since the start                                |                     | energy
        supplied   | J | energy supplied by the inputs and by drives of joints since the start  |                     | energy | when=supply
        total      | J | kinetic, potential and elastic energy                                  |                     | energy
        friction   | J | energy lost in dry friction since the start, part of energy.dissipated | friction.dissipated | energy | when=friction
        """,
        when=("outputs.energies",),
        is_terminal=False,
    ),
    _block(
        part="output",
        of="joint",
        prefix="joint[{n}]",
        rows="""
        force.{axis}   | N   | {axis} of the force of {parent} on link {n}                               | load.{axis}         | momentum | feedthrough
        moment         | N.m | moment of {parent} on link {n}: drive, spring, damper, friction and stops | load.moment         | energy   | feedthrough
        impulse.{axis} | N.s | {axis} of the impulse of {parent} on link {n} since the start             | load.impulse_{axis} | momentum
        peak_force     | N   | largest force of {parent} on link {n} since the start                     | load.peak           | momentum | minimum=0
        """,
        heading=JOINT,
        when=("outputs.loads",),
    ),
    _block(
        part="output",
        of="slider",
        prefix="slider",
        rows="""
        reaction | N   | force of the line on the carriage, along its left normal | slider_reaction | momentum | feedthrough
        moment   | N.m | moment of the line on the carriage                       | slider_moment   | energy   | feedthrough
        """,
        heading=SLIDER,
        when=("outputs.loads",),
    ),
    _block(
        part="output",
        of="touched wall",
        prefix="wall.{name}",
        rows="""
        load.{axis} | N   | {axis} of the force of the chain on the wall   | load.{axis} | momentum | feedthrough
        load_moment | N.m | moment of the chain on the wall, about {about} | load.moment | energy   | feedthrough
        """,
        heading=WALL,
        when=("outputs.loads",),
    ),
    _block(
        part="impact",
        of="one",
        prefix="impact",
        rows="""
        count      |     | impacts since the start                                         |  |  | minimum=0
        last_time  | s   | time of the last impact, of the start before the first
        last_point |     | point of the last impact, -1 before the first{its_joint}        |  |  | minimum=-1 maximum=points
        last_wall  |     | wall of the last impact: {wall_numbers}                         |  |  | minimum=0 maximum=walls
        last_speed | m/s | approach speed at the last impact, 0 before the first{in_rad_s} |  |  | minimum=0
        """,
        is_terminal=False,
    ),
    _block(
        part="latest",
        of="impact",
        prefix="impact[{n}]",
        rows="""
        time             | s   | time of its onset, 0 if there is none
        point            |     | point, -1 if there is none{its_joint}                                 |  |          | minimum=-1 maximum=points
        wall             |     | wall: {wall_numbers_if_any}                                           |  |          | minimum=0 maximum=walls
        speed            | m/s | approach speed at its onset{in_rad_s}                                 |  | size     | minimum=0
        end              | s   | time of its end, the present time if it lasts
        separation_speed | m/s | speed from the wall at its end, the present one if it lasts{in_rad_s} |  | size
        peak_force       | N   | largest force so far, 0 for an impulse of a rigid wall{in_n_m}        |  | force    | minimum=0 feedthrough
        max_penetration  | m   | largest penetration so far{in_rad}                                    |  | depth    | minimum=0
        impulse          | N.s | impulse of the wall so far{in_n_m_s}                                  |  | momentum
        """,
        heading=IMPACT,
        array=True,
        is_terminal=False,
    ),
    _block(
        part="statistics",
        of="one",
        prefix="solver",
        rows="""
        steps           |  | accepted steps of the solver                         |  |  | minimum=0
        rejected_steps  |  | rejected steps of the solver                         |  |  | minimum=0
        rhs_evaluations |  | evaluations of the equations of motion by the solver |  |  | minimum=0
        implicit_steps  |  | accepted implicit steps                              |  |  | minimum=0
        status          |  | status of the solver: {statuses}                     |  |  | minimum=0 maximum=most_status
        """,
        when=("outputs.solver",),
        is_terminal=False,
    ),
)
"""The outputs, without derivatives."""

"""The inputs and outputs in the table of variables, one row for each kind; row_text.py explains the rows.

The value references follow the order of the rows.
"""

from chain_impact.scene.words.names import INPUTS_OF
from chain_impact.variables.kind import CONTACT, IMPACT, JOINT, LINK, MOTION, POINT, SLIDER, WALL
from chain_impact.variables.row_text import rows_block

INPUTS = (
    rows_block(
        part="given",
        owner_kind="joint",
        prefix="joint[{n}]",
        rows="torque on link {n} from {before} | field=motor",
        names=INPUTS_OF["joint_torques"],
        when=("inputs.joint_torques",),
        causality="input",
    ),
    rows_block(
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
    rows_block(
        part="given",
        owner_kind="slider",
        prefix="slider",
        rows="force on the carriage, along the line | field=motor.{at}",
        names=INPUTS_OF["slider_force"],
        heading=SLIDER,
        when=("inputs.slider_force",),
        causality="input",
    ),
    rows_block(
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
    rows_block(
        part="given",
        owner_kind="one",
        prefix="tip",
        rows="{axis} of the force on the tip | field=tip_force.{j}",
        names=INPUTS_OF["tip_force"],
        when=("inputs.tip_force",),
        causality="input",
    ),
    rows_block(
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
    rows_block(
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
    rows_block(
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
    rows_block(
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
    rows_block(
        part="output",
        owner_kind="joint",
        prefix="joint[{n}]",
        rows="""
        angle            | rad   | angle of link {n} relative to {parent}{from_x}            | field=joint_angle
        angular_velocity | rad/s | angular velocity of link {n} relative to {parent}{from_x} | field=joint_angular_velocity rate_of=joint_angle
        """,
        heading=JOINT,
    ),
    rows_block(
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
    rows_block(
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
    rows_block(
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
    rows_block(
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
    rows_block(
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
    rows_block(
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
    rows_block(
        part="output",
        owner_kind="one",
        prefix="energy",
        rows="""
        kinetic    | J | kinetic energy                                                         | nominal=energy minimum=0
        potential  | J | potential energy of gravity, zero at the origin                        | nominal=energy
        elastic    | J | energy stored in contacts and springs                                  | nominal=energy
        dissipated | J | energy lost in {losses} since the start                                | nominal=energy
        supplied   | J | energy supplied by the inputs and by drives since the start            | nominal=energy when=supply
        total      | J | kinetic, potential and elastic energy                                  | nominal=energy
        friction   | J | energy lost in dry friction since the start, part of energy.dissipated | field=friction.dissipated nominal=energy when=friction
        """,
        when=("outputs.energies",),
        is_terminal=False,
    ),
    rows_block(
        part="output",
        owner_kind="joint",
        prefix="joint[{n}]",
        rows="""
        force.{axis}   | N   | {axis} of the force of {parent} on link {n}                         | field=transmitted.{axis} nominal=inertial_force feedthrough
        moment         | N.m | moment of {parent} on link {n}: of drive, dry friction and stops    | field=transmitted.moment nominal=inertial_moment feedthrough
        impulse.{axis} | N.s | {axis} of the impulse of {parent} on link {n} since the start       | field=transmitted.impulse_{axis} nominal=momentum
        peak_force     | N   | largest force of {parent} on link {n} since the start               | field=transmitted.peak nominal=inertial_force minimum=0
        peak_time      | s   | time of peak_force                                                  | field=transmitted.peak_time
        """,
        heading=JOINT,
        when=("outputs.loads",),
    ),
    rows_block(
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
    rows_block(
        part="output",
        owner_kind="touched wall",
        prefix="wall.{name}",
        rows="""
        load.{axis} | N   | {axis} of the force of the chain on the wall   | field=transmitted.{axis} nominal=inertial_force feedthrough
        load_moment | N.m | moment of the chain on the wall, about {about} | field=transmitted.moment nominal=inertial_moment feedthrough
        """,
        heading=WALL,
        when=("outputs.loads",),
    ),
    rows_block(
        part="impact",
        owner_kind="one",
        prefix="impact",
        rows="""
        count      |     | impacts since the start                                         | minimum=0
        last_time  | s   | time of the last impact; before the first one, time of the start
        last_point |     | point of the last impact, -1 before the first{its_joint}        | minimum=-1 maximum=points
        last_wall  |     | wall of the last impact: {wall_numbers}                         | minimum=0 maximum=walls
        last_speed | m/s | approach speed at the last impact, 0 before the first{in_rad_s} | minimum=0
        """,
        is_terminal=False,
    ),
    rows_block(
        part="latest",
        owner_kind="impact",
        prefix="impact[{n}]",
        rows="""
        time             | s   | time of its onset, 0 if there is none | field=onset
        point            |     | point, -1 if there is none{its_joint}                                 | minimum=-1 maximum=points
        wall             |     | wall: {wall_numbers_if_any}                                           | minimum=0 maximum=walls
        speed            | m/s | approach speed at its onset{in_rad_s}                                 | field=impact_speed nominal=size minimum=0
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
    rows_block(
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

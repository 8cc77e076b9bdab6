"""The inputs and outputs in the table of variables: one row for each kind; kind.py explains rows and blocks.

The value references follow the order of the rows.
"""

from chain_impact.variables.kind import (
    CONTACT,
    GIVEN_CHANNEL,
    IMPACT,
    JOINT,
    LINK,
    POINT,
    SLIDER,
    WALL,
    input_block,
    input_row,
    record_block,
    row,
)

# each row is one line of a table with columns
# fmt: off
INPUTS = (
    input_block(
        "given", "joint", "joint[{n}]",
        input_row("torque", "torque on link {n} from {before}", field="motor"),
    ),
    input_block(
        "given", "joint", "joint[{n}]",
        input_row("target_angle",    "angle that the spring of joint {n} follows",            field="target"),
        input_row("target_velocity", "angular velocity that the damper of joint {n} follows", field="target_velocity"),
    ),
    input_block(
        "given", "slider", "slider",
        input_row("force", "force on the carriage, along the line", field="motor.{at}"),
        heading=SLIDER,
    ),
    input_block(
        "given", "slider", "slider",
        input_row("target_position", "position that the spring of the slider follows", field="target.{at}"),
        input_row("target_velocity", "velocity that the damper of the slider follows", field="target_velocity.{at}"),
        heading=SLIDER,
    ),
    input_block(
        "given", "one", "tip",
        input_row("force.{axis}", "{axis} of the force on the tip", field="tip_force.{j}"),
    ),
    input_block(
        GIVEN_CHANNEL, "one", "base",
        input_row("{axis}",  "{axis} of the position of the base",     field="position.{j}"),
        input_row("v{axis}", "{axis} of the velocity of the base",     field="velocity.{j}"),
        input_row("a{axis}", "{axis} of the acceleration of the base", field="acceleration.{j}"),
    ),
    input_block(
        GIVEN_CHANNEL, "moving wall", "wall.{name}",
        input_row("displacement", "its displacement along its inward normal n", field="position"),
        input_row("velocity",     "its velocity along its inward normal n",     field="velocity"),
        input_row("acceleration", "its acceleration along its inward normal n", field="acceleration"),
        input_row("belt_speed",   "speed of its belt along t = (n_y, -n_x)",    field="velocity.{next}"),
        heading=WALL,
    ),
)
"""The kinds of all inputs that scenes can ask for."""

OUTPUTS = (
    record_block(
        "output", "point", "point[{n}]",
        row("{axis}",  "m",    "{axis} of the position",     field="point_position.{at}.{j}", nominal="size", array="point.position"),
        row("v{axis}", "m/s",  "{axis} of the velocity",     field="point_velocity.{at}.{j}", nominal="size", array="point.velocity", rate_of="point_position"),
        row("a{axis}", "m/s2", "{axis} of the acceleration", field="point_acceleration.{at}.{j}", nominal="size", array="point.acceleration", rate_of="point_velocity", feedthrough=True),
        heading=POINT, when=("outputs.points",),
    ),
    record_block(
        "output", "link", "link[{n}]",
        row("angle",                "rad",    "angle, absolute, from +x"),
        row("angular_velocity",     "rad/s",  "angular velocity, absolute",     rate_of="angle"),
        row("angular_acceleration", "rad/s2", "angular acceleration, absolute", rate_of="angular_velocity", feedthrough=True),
        heading=LINK, when=("outputs.links",), array=True, is_terminal=False,
    ),
    record_block(
        "output", "joint", "joint[{n}]",
        row("angle",            "rad",   "angle of link {n} relative to {parent}{from_x}",            field="joint_angle"),
        row("angular_velocity", "rad/s", "angular velocity of link {n} relative to {parent}{from_x}", field="joint_angular_velocity", rate_of="joint_angle"),
        heading=JOINT,
    ),
    record_block(
        "output", "slider", "slider",
        row("position",     "m",    "position along the line, 0 at the start", field="slider_position", nominal="size"),
        row("velocity",     "m/s",  "velocity along the line",                 field="slider_velocity", nominal="size", rate_of="slider_position"),
        row("acceleration", "m/s2", "acceleration along the line",             field="slider_acceleration", nominal="size", rate_of="slider_velocity", feedthrough=True),
        heading=SLIDER,
    ),
    record_block(
        "output", "slider", "slider",
        row("friction_force", "N", "dry friction on the carriage, along the line", field="friction.drive_friction.{at}", nominal="force", feedthrough=True),
        row("sticking",       "1", "1 while it sticks by dry friction, else 0",    field="friction.drive_sticking.{at}", feedthrough=True, minimum=0.0, maximum=1.0),
        heading=SLIDER, when=("outputs.contacts", "may_have_friction"),
    ),
    record_block(
        "output", "contact", "contact[{n}].{name}",
        row("force",            "N",   "force of the wall, along its normal",                                            nominal="force", feedthrough=True),
        row("penetration",      "m",   "penetration, 0 when apart",                                                      nominal="depth", minimum=0.0),
        row("penetration_rate", "m/s", "rate of penetration, positive when closing, 0 when apart",                       nominal="size"),
        row("impulse",          "N.s", "impulse of the wall since the start, along its normal",                          nominal="momentum"),
        row("friction_force",   "N",   "dry friction of the wall, along t = (n_y, -n_x) of its normal n",                field="friction.force", nominal="force", feedthrough=True, when="may_have_friction"),
        row("friction_impulse", "N.s", "impulse of dry friction since the start, along t = (n_y, -n_x) of its normal n", field="friction.impulse", nominal="momentum", when="may_have_friction"),
        row("sticking",         "1",   "1 while it sticks by dry friction, else 0",                                      field="friction.sticking", feedthrough=True, when="may_have_friction", minimum=0.0, maximum=1.0),
        heading=CONTACT, when=("outputs.contacts",), array=True, is_terminal=False,
    ),
    record_block(
        "output", "moving wall", "wall.{name}",
        row("position",      "m", "distance moved along its inward normal n",         field="channel"),
        row("belt_position", "m", "how far its belt has moved along t = (n_y, -n_x)", field="channel.{next}"),
        heading=WALL, when=("outputs.contacts",),
    ),
    record_block(
        "output", "stop", "joint[{n}]",
        row("stop_moment",      "N.m",   "moment of its stops, positive at joint_min",                  field="force", nominal="stop_moment", feedthrough=True),
        row("stop_penetration", "rad",   "angle beyond a stop, 0 when apart",                           field="penetration", nominal="stop_depth", minimum=0.0),
        row("stop_impulse",     "N.m.s", "impulse of its stops since the start, positive at joint_min", field="impulse", nominal="angular_momentum"),
        heading=JOINT, when=("outputs.contacts",),
    ),
    record_block(
        "output", "joint with friction", "joint[{n}]",
        row("friction_moment", "N.m", "moment of dry friction on link {n}",        field="friction.drive_friction", nominal="inertial_moment", feedthrough=True),
        row("sticking",        "1",   "1 while it sticks by dry friction, else 0", field="friction.drive_sticking", feedthrough=True, minimum=0.0, maximum=1.0),
        heading=JOINT, when=("outputs.contacts",),
    ),
    record_block(
        "output", "one", "energy",
        row("kinetic",    "J", "kinetic energy",                                                         nominal="energy", minimum=0.0),
        row("potential",  "J", "potential energy of gravity, zero at the origin",                        nominal="energy"),
        row("elastic",    "J", "energy stored in contacts and springs",                                  nominal="energy"),
        row("dissipated", "J", "energy lost in {losses} since the start",                                nominal="energy"),
        row("supplied",   "J", "energy supplied by the inputs and by drives since the start",            nominal="energy", when="has_supply"),
        row("total",      "J", "kinetic, potential and elastic energy",                                  nominal="energy"),
        row("friction",   "J", "energy lost in dry friction since the start, part of energy.dissipated", field="friction.dissipated", nominal="energy", when="has_dry_friction"),
        when=("outputs.energies",), is_terminal=False,
    ),
    record_block(
        "output", "joint", "joint[{n}]",
        row("force.{axis}",   "N",   "{axis} of the force of {parent} on link {n}",                      field="transmitted.{axis}", nominal="inertial_force", feedthrough=True),
        row("moment",         "N.m", "moment of {parent} on link {n}: of drive, dry friction and stops", field="transmitted.moment", nominal="inertial_moment", feedthrough=True),
        row("impulse.{axis}", "N.s", "{axis} of the impulse of {parent} on link {n} since the start",    field="transmitted.impulse_{axis}", nominal="momentum"),
        row("peak_force",     "N",   "largest force of {parent} on link {n} since the start",            field="transmitted.peak", nominal="inertial_force", minimum=0.0),
        row("peak_time",      "s",   "time of peak_force",                                               field="transmitted.peak_time"),
        heading=JOINT, when=("outputs.loads",),
    ),
    record_block(
        "output", "slider", "slider",
        row("reaction", "N",   "force of the line on the carriage, along its left normal", field="slider_reaction", nominal="inertial_force", feedthrough=True),
        row("moment",   "N.m", "moment of the line on the carriage",                       field="slider_moment", nominal="inertial_moment", feedthrough=True),
        heading=SLIDER, when=("outputs.loads",),
    ),
    record_block(
        "output", "touched wall", "wall.{name}",
        row("load.{axis}", "N",   "{axis} of the force of the chain on the wall",   field="transmitted.{axis}", nominal="inertial_force", feedthrough=True),
        row("load_moment", "N.m", "moment of the chain on the wall, about {about}", field="transmitted.moment", nominal="inertial_moment", feedthrough=True),
        heading=WALL, when=("outputs.loads",),
    ),
    record_block(
        "impact", "one", "impact",
        row("count",      "",    "impacts since the start",                                          minimum=0),
        row("last_time",  "s",   "time of the last impact; before the first one, time of the start"),
        row("last_point", "",    "point of the last impact, -1 before the first{its_joint}",         minimum=-1, maximum="points"),
        row("last_wall",  "",    "wall of the last impact: {wall_numbers}",                          minimum=0, maximum="walls"),
        row("last_speed", "m/s", "approach speed at the last impact, 0 before the first{in_rad_s}",  minimum=0.0),
        is_terminal=False,
    ),
    record_block(
        "latest", "impact", "impact[{n}]",
        row("time",             "s",   "time of its onset, 0 if there is none",                                 field="onset"),
        row("point",            "",    "point, -1 if there is none{its_joint}",                                 minimum=-1, maximum="points"),
        row("wall",             "",    "wall: {wall_numbers_if_any}",                                           minimum=0, maximum="walls"),
        row("speed",            "m/s", "approach speed at its onset{in_rad_s}",                                 field="impact_speed", nominal="size", minimum=0.0),
        row("end",              "s",   "time of its end, the present time if it lasts"),
        row("separation_speed", "m/s", "speed from the wall at its end, the present one if it lasts{in_rad_s}", nominal="size"),
        row("peak_force",       "N",   "largest force so far, 0 for an impulse of a rigid wall{in_n_m}",        nominal="force", minimum=0.0, feedthrough=True),
        row("max_penetration",  "m",   "largest penetration so far{in_rad}",                                    nominal="depth", minimum=0.0),
        row("impulse",          "N.s", "impulse of the wall so far{in_n_m_s}",                                  nominal="momentum"),
        heading=IMPACT, array=True, is_terminal=False,
    ),
    record_block(
        "statistics", "one", "solver",
        row("steps",           "", "accepted steps of the solver",                         minimum=0),
        row("rejected_steps",  "", "rejected steps of the solver",                         minimum=0),
        row("rhs_evaluations", "", "evaluations of the equations of motion by the solver", minimum=0),
        row("implicit_steps",  "", "accepted implicit steps",                              minimum=0),
        row("status",          "", "status of the solver: {statuses}",                     minimum=0, maximum="most_status"),
        when=("outputs.solver",), is_terminal=False,
    ),
)
"""The kinds of all outputs that scenes can have, without derivatives."""
# fmt: on

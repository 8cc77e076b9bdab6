"""The parts of the record that the scene and the importer set, and the values derived from them."""

import numpy as np

from chain_impact.kernel.forces.inputs import DEGREE
from chain_impact.kernel.record.fields import (
    AT_ANY_TIME,
    AT_START,
    INTEGER,
    REAL,
    given,
    record,
    table,
    written_by,
)
from chain_impact.kernel.rows.geometry import WALLS


@given(AT_START)
@written_by("initialize.py")
def model_dtype(links: int) -> np.dtype:
    """Return the layout of the chain and its box; variables/model.py sets the values that are not derived."""
    return record(
        ("gravity", REAL, (2,)),  # m/s²
        ("length", REAL, (links,)),  # m
        ("mass", REAL, (links,)),  # kg
        # m from the proximal joint, and kg·m² about the centre of mass, as they are given; or DERIVED
        ("given_center_of_mass", REAL, (links,)),
        ("given_inertia", REAL, (links,)),
        ("height", REAL, (links,)),  # m, of a link that is a box; 0 for other links
        ("center_of_mass_offset", REAL, (links,)),  # m, to the left of the link's line
        ("joint_friction", REAL, (links,)),  # N·m, dry friction at the proximal joint
        ("joint_armature", REAL, (links,)),  # kg·m², acts on the relative rotation in the joint
        ("joint_torque_limit", REAL, (links,)),  # N·m, of motor, spring and damper together; ∞: none
        ("joint_min", REAL, (links,)),  # rad, stops of the joint's own angle; −∞ …
        ("joint_max", REAL, (links,)),  # rad, … and ∞ where there is none
        ("wall", REAL, (len(WALLS),)),  # m, position of x_min, x_max, y_min, y_max
        ("pinned", INTEGER),  # 1: link 1 hangs in a joint at the base, which cannot move or slides
        ("driven", INTEGER),  # 1: inputs act on the chain in flight
        ("followed", INTEGER),  # 1: all joints have servos, whose targets are inputs
        ("base_moves", INTEGER),  # 1: a pinned base moves with the first two channels (chain/motion.py)
        # derived at initialization
        ("center_of_mass", REAL, (links,)),  # m from the proximal joint
        ("inertia", REAL, (links,)),  # kg·m² about the centre of mass
        ("damped", INTEGER),  # 1: some joint has damping
        ("sprung", INTEGER),  # 1: some joint has a spring
        ("stopped", INTEGER),  # 1: some joint has a stop, …
        ("rubbing", INTEGER),  # … 1: some joint has dry friction, …
        ("jointed", INTEGER),  # … and 1: some has either, so that all joints have places
        ("geared", INTEGER),  # 1: some joint has an armature
        ("limited", INTEGER),  # 1: some joint has a limit of its torque
        ("resisting", INTEGER),  # 1: some joint has damping or a spring …
        ("joint_bound", REAL),  # 1/s, … and an upper bound on the rates of the motions that these cause
        ("center_of_mass_ratio", REAL, (links,)),  # centre of mass / length
        ("offset_ratio", REAL, (links,)),  # offset of the centre of mass / length
        ("proximal_inertia", REAL, (links,)),  # kg·m² about the proximal …
        ("distal_inertia", REAL, (links,)),  # kg·m² … and about the distal joint
        ("first_site", INTEGER, (links + 1,)),  # the first site of each link and, at N, the number of sites
        ("middle", INTEGER),  # joint at which the two arms of the elimination meet: the base if it is pinned
        ("gravity_size", REAL),  # m/s²
        ("reach", REAL),  # m, length of the stretched chain
        ("size", REAL),  # m, longest link: the absolute scale of positions
        ("energy", REAL),  # J, of the whole mass at one `size` a second: the absolute scale of energies
    )


@given(AT_START)
@written_by("forces/contact_law.py")
def contact_dtype() -> np.dtype:
    """Return the layout of the data that all contacts with walls share; the rest of their law is in `given`.

    variables/model.py sets the values that are not derived.
    """
    return record(
        ("exponent", REAL),
        ("radius", REAL),  # m
        ("minimum_impact_speed", REAL),  # m/s, lower limit of v0, which is latched at onset
        # derived
        ("any_force", INTEGER),  # 1: some candidate has a law with a force …
        ("any_rigid", INTEGER),  # … and one with impulses instead
        ("any_friction", INTEGER),  # 1: some candidate has dry friction
    )


@given(AT_START)
@written_by("initialize.py", restitution="forces/contact_law.py")
def stops_dtype() -> np.dtype:
    """Return the layout of the contact law of stops in joints.

    Given stiffness and restitution are in `given`.

    variables/model.py sets the values that are not derived.
    """
    return record(
        ("law", INTEGER),  # number of the contact law, from 1; 0: the law of the walls
        ("given_exponent", REAL),  # or DERIVED: the exponent of `contact`
        ("minimum_impact_speed", REAL),  # rad/s
        # derived
        ("exponent", REAL),
        ("restitution", REAL),  # for readers of the record; the laws have it for each candidate
    )


@given(AT_START)
@written_by("initialize.py", mode="events/saturation.py")
def slider_dtype() -> np.dtype:
    """Return the layout of the line on which the base slides, and of the carriage: kernel/chain/slider.py.

    variables/model.py sets the values that are not derived.
    """
    return record(
        ("angle", REAL),  # rad, direction of the line from +x
        ("mass", REAL),  # kg, mass of the carriage
        ("damping", REAL),  # N·s/m
        ("stiffness", REAL),  # N/m
        ("friction", REAL),  # N, dry friction
        ("min", REAL),  # m, stops; −∞ …
        ("max", REAL),  # m, … and ∞ where there is none
        ("force_limit", REAL),  # N, of motor, spring and damper together; ∞: none
        # derived
        ("ux", REAL),  # u, the unit vector along the line
        ("uy", REAL),
        ("mode", INTEGER),  # as `drive.mode`
        ("chosen", INTEGER),  # as `drive.chosen`
    )


@given(AT_START)
@written_by()
def initial_dtype(links: int) -> np.dtype:
    """Return the layout of the initial values, which variables/model.py sets."""
    return record(
        ("position", REAL, (2,)),  # m
        ("velocity", REAL, (2,)),  # m/s
        ("angle", REAL, (links,)),  # rad
        ("angular_velocity", REAL, (links,)),  # rad/s
        ("slider_velocity", REAL),  # m/s, along the line of a slider
    )


@given(AT_START)
@written_by()
def solver_dtype() -> np.dtype:
    """Return the layout of the settings of the solver, which variables/model.py sets."""
    return record(
        ("method", INTEGER),  # index into SOLVER_METHODS of kernel/ode/control.py, from 1
        ("tolerance", REAL),
        ("work_limit", REAL),  # 1/s, evaluations per second of simulated time
    )


def course_dtype(links: int) -> np.dtype:
    """Return the layout of the inputs as polynomials of time, piece by piece, see kernel/forces/inputs.py."""
    return record(
        ("order", INTEGER),  # 0: the inputs are constant
        ("middle", REAL),  # s, the time at which the argument x is 0 …
        ("scale", REAL),  # 1/s, … and its rate of change
        ("until", REAL),  # s, the end of the piece
        ("change_rate", REAL),  # 1/s, the rate at which the inputs change
        ("joint_torque", REAL, (DEGREE + 1, links)),  # N·m, coefficients of the powers of x
        ("joint_target_angle", REAL, (DEGREE + 1, links)),  # rad
        ("joint_target_velocity", REAL, (DEGREE + 1, links)),  # rad/s
        ("tip_force", REAL, (DEGREE + 1, 2)),  # N
        ("slider_force", REAL, (DEGREE + 1, 1)),  # N
        ("slider_target_position", REAL, (DEGREE + 1, 1)),  # m
        ("slider_target_velocity", REAL, (DEGREE + 1, 1)),  # m/s
    )


@given(AT_ANY_TIME)
@written_by(changed="forces/inputs.py", course="forces/inputs.py")
def given_dtype(links: int) -> np.dtype:
    """Return the layout of the values that an importer can set at any time.

    The values are applied at the next step, or when the output time is set.
    """
    return record(
        ("changed", INTEGER),  # AT_ONCE: a value was set since the last step; CONTINUES: only the course was
        ("law", INTEGER),  # number of the contact law, from 1
        ("stiffness", REAL),  # N/m^exponent
        ("restitution", REAL),
        ("friction", REAL),  # coefficient of sliding …
        ("static_friction", REAL),  # … and of static friction; 0 means the coefficient of sliding
        ("stop_stiffness", REAL),  # N·m/rad^exponent
        ("stop_restitution", REAL),  # or DERIVED: the restitution of the walls
        ("joint_damping", REAL, (links,)),  # as in `inputs`
        ("joint_stiffness", REAL, (links,)),
        ("joint_torque", REAL, (links,)),
        ("joint_target_angle", REAL, (links,)),
        ("joint_target_velocity", REAL, (links,)),
        ("tip_force", REAL, (2,)),
        ("slider_force", REAL),
        ("slider_target_position", REAL),
        ("slider_target_velocity", REAL),
        ("course", course_dtype(links)),
    )


@written_by("forces/inputs.py")
def inputs_dtype(links: int) -> np.dtype:
    """Return the layout of the inputs in use, and of the joint values that can be set at any time."""
    return record(
        ("joint_damping", REAL, (links,)),  # N·m·s/rad at the proximal joint
        ("joint_stiffness", REAL, (links,)),  # N·m/rad at the proximal joint
        ("joint_torque", REAL, (links,)),  # N·m
        ("joint_target_angle", REAL, (links,)),  # rad, at which the spring is slack: given, or an input
        ("joint_target_velocity", REAL, (links,)),  # rad/s, at which the damper is without moment
        ("tip_force", REAL, (2,)),  # N
        ("slider_force", REAL),  # N
        ("slider_target_position", REAL),  # m, at which the spring is slack: given, or an input
        ("slider_target_velocity", REAL),  # m/s, at which the damper has no force
        ("course", course_dtype(links)),
    )


@given(AT_ANY_TIME)
@written_by("forces/inputs.py")
def motion_dtype(channels: int) -> np.dtype:
    """Return the layout of the given motions of base and walls, see kernel/chain/motion.py.

    variables/model.py sets the values that the kernel does not write.
    """
    return record(
        ("follows", INTEGER),  # 1: the values at communication points are followed; 0: the course is set
        ("jumps", INTEGER),  # 1: the speed of a belt jumps where the piece of the course begins
        ("belt", INTEGER, (channels,)),  # 1: the channel is the travel of a belt
        ("position", REAL, (channels,)),  # m; 0 for a belt
        ("velocity", REAL, (channels,)),  # m/s
        ("acceleration", REAL, (channels,)),  # m/s²; 0 for a belt
        ("course", REAL, (DEGREE + 1, channels)),  # m, coefficients of the powers of x
    )


@written_by("forces/inputs.py", **dict.fromkeys(("position", "velocity", "acceleration"), "chain/motion.py"))
def moved_dtype(channels: int) -> np.dtype:
    """Return the layout of the motions in use, and of the values that they follow."""
    return record(
        ("began", REAL),  # s, the start of the run
        ("until", REAL),  # s, the communication point up to which the given values are followed
        # number of the first channel, from 1, whose positions and velocities contradict each other, or 0; …
        ("contradiction", INTEGER),
        ("distance", REAL),  # m, … the distance it has been moved, …
        ("lasted", REAL),  # s, … the time for it, …
        ("speed", REAL),  # m/s, … and the given velocity
        ("position", REAL, (channels,)),  # m, position at the time of the located points …
        ("velocity", REAL, (channels,)),  # m/s
        ("acceleration", REAL, (channels,)),  # m/s²
        ("course", REAL, (DEGREE + 1, channels)),  # m, coefficients of the powers of x
        # the given values when they changed last, …
        ("given_position", REAL, (channels,)),  # m
        ("given_velocity", REAL, (channels,)),  # m/s
        ("given_acceleration", REAL, (channels,)),  # m/s²
        ("given_at", REAL, (channels,)),  # s, … and the time of this change
        ("from_position", REAL, (channels,)),  # m, position from which the motion continues since then …
        ("from_velocity", REAL, (channels,)),  # m/s, … and its velocity
        ("anchored", INTEGER, (channels,)),  # 1: the position was given then; 0: it follows from the velocity
        ("mean", REAL, (channels,)),  # m/s, the mean velocity of a base without a given velocity
        # derivatives with respect to given values (tangent/replay.py); their values are 0
        ("added", REAL, (channels,)),  # m, added to the position, …
        ("added_rate", REAL, (channels,)),  # m/s, … to the velocity …
        ("added_push", REAL, (channels,)),  # m/s², … and to the acceleration
    )


@written_by("rows/geometry.py", offset=("rows/geometry.py", "chain/motion.py"))
def candidate_dtype(candidates: int) -> np.dtype:
    """Return the layout of the candidates: first the pairs of a point and a wall, then the stops in joints.

    variables/model.py sets the values that are not derived.
    """
    return table(
        candidates,
        ("point", INTEGER),  # 0…N, sites N+1…N+P; for a stop 1…N, the number of its joint
        # index into WALLS, or 4 plus the index into `walls`; stops have the numbers after these
        ("wall", INTEGER),
        ("stop", INTEGER),  # ±1: at joint_min, joint_max; ±2: at slider_min, slider_max; 0: at a wall
        # derived at initialization
        # the point; for a stop N plus the number of the joint; for a site N plus its number
        ("place", INTEGER),
        ("radius", REAL),  # m, of the point
        ("normal_x", REAL),  # n of the wall …
        ("normal_y", REAL),
        ("offset", REAL),  # m, … and n·p of the points on it
    )


@given(AT_START)
@written_by("initialize.py")
def site_dtype(sites: int) -> np.dtype:
    """Return the layout of the sites, points fixed to links beside the joints, in the order of the links.

    variables/model.py sets the values that are not derived.
    """
    return record(
        ("link", INTEGER, (sites,)),  # index of the link, from 0
        (
            "corner",
            INTEGER,
            (sites,),
        ),  # 1 to 4: corner of a box, which derives its place; 0: none
        ("x", REAL, (sites,)),  # m, along the link from its proximal joint, …
        ("y", REAL, (sites,)),  # m, … and to the left of its line
        ("given_radius", REAL, (sites,)),  # m, or DERIVED: the radius of `contact`
        # derived at initialization
        ("radius", REAL, (sites,)),  # m
        ("along", REAL, (sites,)),  # x / length …
        ("beside", REAL, (sites,)),  # … and y / length
    )


@written_by("chain/motion.py", rest="rows/geometry.py")
def shift_dtype(candidates: int) -> np.dtype:
    """Return the layout of the motion of each candidate's wall, in a scene in which some wall moves.

    variables/model.py sets the values that are not derived.
    """
    return table(
        candidates,
        ("channel", INTEGER),  # the wall's channel; the next one moves its belt; −1: the wall is at rest
        ("rest", REAL),  # m, offset of the wall if it had not moved
        ("rate", REAL),  # m/s, speed of the wall along n …
        ("push", REAL),  # m/s², … and its acceleration
        ("travel", REAL),  # m, travel of the belt along t, …
        ("belt_rate", REAL),  # m/s, … its speed …
        ("belt_push", REAL),  # m/s², … and its acceleration
    )


@written_by("forces/contact_law.py")
def law_dtype(candidates: int) -> np.dtype:
    """Return the layout of the contact law of each candidate."""
    return table(
        candidates,
        ("same_as", INTEGER),  # the first candidate with the same law
        ("number", INTEGER),  # number of the law, from 1; 0: not yet set
        ("stiffness", REAL),  # N/m^exponent
        ("exponent", REAL),
        ("restitution", REAL),
        ("minimum_impact_speed", REAL),  # m/s
        ("friction", REAL),  # coefficient of sliding …
        ("static_friction", REAL),  # … and of static friction, which is not less
        # derived
        ("damping_factor", REAL),  # f(e), λ of the Hunt–Crossley family
        ("rate_exponent", REAL),  # p of the damping d δᵖ δ̇
        ("approach_only", INTEGER),  # 1: damped during compression only
        ("impulsive", INTEGER),  # 1: rigid, with impulses instead of a force law
        ("harmless_depth", REAL),  # m, depth in the wall up to which a point is not in contact
    )


@given(AT_ANY_TIME)
@written_by()
def walls_dtype(candidates: int) -> np.dtype:
    """Return the layout of the walls at any angle, at most C, and of the materials of all walls.

    variables/model.py sets them; an importer may set stiffness and restitution, as those in `given`.
    """
    return record(
        ("x", REAL, (candidates,)),  # m, a point on each wall …
        ("y", REAL, (candidates,)),
        ("angle", REAL, (candidates,)),  # rad, … and its direction from +x: the free side is to its left
        # the walls of the box come first: N/m^exponent, 0 for the stiffness of `contact`, …
        ("stiffness", REAL, (len(WALLS) + candidates,)),
        # … and −1 for the restitution of `contact`; the other materials in the same way:
        ("restitution", REAL, (len(WALLS) + candidates,)),
        ("friction", REAL, (len(WALLS) + candidates,)),
        ("static_friction", REAL, (len(WALLS) + candidates,)),
    )

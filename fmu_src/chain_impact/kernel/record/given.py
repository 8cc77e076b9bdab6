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
    """The chain and its box. variables/model.py sets what is not derived."""
    return record(
        ("gravity", REAL, (2,)),  # m/s²
        ("length", REAL, (links,)),  # m
        ("mass", REAL, (links,)),  # kg
        # m from the proximal joint, and kg·m² about the centre of mass, as they are given; or DERIVED
        ("given_center_of_mass", REAL, (links,)),
        ("given_inertia", REAL, (links,)),
        ("height", REAL, (links,)),  # m, of a link that is a box; 0 of all others
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
        ("joint_bound", REAL),  # 1/s, … and an upper bound on the rates of the motions that this causes
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
    """What all contacts with walls have in common; the rest of their law is in `given`.

    variables/model.py sets what is not derived.
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
    """The contact law of the stops in joints; the given stiffness and restitution are in `given`.

    variables/model.py sets what is not derived.
    """
    return record(
        ("law", INTEGER),  # number of the contact law, from 1; 0: that of the walls
        ("given_exponent", REAL),  # or DERIVED: that of `contact`
        ("minimum_impact_speed", REAL),  # rad/s
        # derived
        ("exponent", REAL),
        ("restitution", REAL),  # for who reads it: the laws have it for each candidate
    )


@given(AT_START)
@written_by("initialize.py", mode="events/saturation.py")
def slider_dtype() -> np.dtype:
    """The line along which the base slides, and the carriage, see kernel/chain/slider.py.

    variables/model.py sets what is not derived.
    """
    return record(
        ("angle", REAL),  # rad, direction of the line from +x
        ("mass", REAL),  # kg, of the carriage
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
    """The initial values. variables/model.py sets them."""
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
    """The settings of the solver. variables/model.py sets them."""
    return record(
        ("method", INTEGER),  # index into SOLVER_METHODS of kernel/ode/control.py, from 1
        ("tolerance", REAL),
        ("work_limit", REAL),  # 1/s, evaluations per second of simulated time
    )


def course_dtype(links: int) -> np.dtype:
    """The inputs as polynomials of time, piece by piece, see kernel/forces/inputs.py."""
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
    """The values that an importer can set at any time.

    They are applied at the next step, or when the output time is set.
    """
    return record(
        ("changed", INTEGER),  # AT_ONCE: a value was set since the last step; CONTINUES: only the course was
        ("law", INTEGER),  # number of the contact law, from 1
        ("stiffness", REAL),  # N/m^exponent
        ("restitution", REAL),
        ("friction", REAL),  # coefficient of sliding …
        ("static_friction", REAL),  # … and of static friction; 0 for that of sliding
        ("stop_stiffness", REAL),  # N·m/rad^exponent
        ("stop_restitution", REAL),  # or DERIVED: that of the walls
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
    """The inputs in use, and what else of joints can be set at any time."""
    return record(
        ("joint_damping", REAL, (links,)),  # N·m·s/rad at the proximal joint
        ("joint_stiffness", REAL, (links,)),  # N·m/rad, likewise
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
    """What is given of the motions of base and walls, see kernel/chain/motion.py.

    variables/model.py sets what is not written by the kernel.
    """
    return record(
        ("follows", INTEGER),  # 1: what is given at communication points is followed; 0: the course is set
        ("jumps", INTEGER),  # 1: the speed of a belt jumps where the piece of the course begins
        ("belt", INTEGER, (channels,)),  # 1: the channel is the travel of a belt
        ("position", REAL, (channels,)),  # m; of a belt 0
        ("velocity", REAL, (channels,)),  # m/s
        ("acceleration", REAL, (channels,)),  # m/s²; of a belt 0
        ("course", REAL, (DEGREE + 1, channels)),  # m, coefficients of the powers of x
    )


@written_by("forces/inputs.py", **dict.fromkeys(("position", "velocity", "acceleration"), "chain/motion.py"))
def moved_dtype(channels: int) -> np.dtype:
    """The motions in use, and what they follow."""
    return record(
        ("began", REAL),  # s, the start of the run
        ("until", REAL),  # s, the communication point up to which they follow what is given
        # number of the first channel, from 1, whose positions and velocities contradict each other, or 0; …
        ("contradiction", INTEGER),
        ("distance", REAL),  # m, … how far it has been moved, …
        ("lasted", REAL),  # s, … in which time, …
        ("speed", REAL),  # m/s, … and the velocity given
        ("position", REAL, (channels,)),  # m, where it is at the time of the located points …
        ("velocity", REAL, (channels,)),  # m/s
        ("acceleration", REAL, (channels,)),  # m/s²
        ("course", REAL, (DEGREE + 1, channels)),  # m, coefficients of the powers of x
        # what is given, as it was when that changed last, …
        ("given_position", REAL, (channels,)),  # m
        ("given_velocity", REAL, (channels,)),  # m/s
        ("given_acceleration", REAL, (channels,)),  # m/s²
        ("given_at", REAL, (channels,)),  # s, … and when that was
        ("from_position", REAL, (channels,)),  # m, from where it goes on since then …
        ("from_velocity", REAL, (channels,)),  # m/s, … and with which velocity
        ("anchored", INTEGER, (channels,)),  # 1: the position was given then; 0: it follows from the velocity
        ("mean", REAL, (channels,)),  # m/s, the mean velocity of a base of which none is given
        # derivatives with respect to what is given (tangent/replay.py); their values are 0
        ("added", REAL, (channels,)),  # m, added to the position, …
        ("added_rate", REAL, (channels,)),  # m/s, … to the velocity …
        ("added_push", REAL, (channels,)),  # m/s², … and to the acceleration
    )


@written_by("rows/geometry.py", offset=("rows/geometry.py", "chain/motion.py"))
def candidate_dtype(candidates: int) -> np.dtype:
    """What may touch: the pairs of a point and a wall first, and then the stops in joints.

    variables/model.py sets what is not derived.
    """
    return table(
        candidates,
        ("point", INTEGER),  # 0…N, sites N+1…N+P; of a stop 1…N, the number of its joint
        ("wall", INTEGER),  # index into WALLS, or 4 and that into `walls`; of a stop the numbers after those
        ("stop", INTEGER),  # ±1: at joint_min, joint_max; ±2: at slider_min, slider_max; 0: at a wall
        # derived at initialization
        ("place", INTEGER),  # the point; of a stop N and the number of the joint; of a site N and its number
        ("radius", REAL),  # m, of the point
        ("normal_x", REAL),  # n of the wall …
        ("normal_y", REAL),
        ("offset", REAL),  # m, … and n·p of the points on it
    )


@given(AT_START)
@written_by("initialize.py")
def site_dtype(sites: int) -> np.dtype:
    """The sites: points that are fixed to links, in the order of the links, beside the joints.

    variables/model.py sets what is not derived.
    """
    return record(
        ("link", INTEGER, (sites,)),  # its index, from 0
        (
            "corner",
            INTEGER,
            (sites,),
        ),  # 1 to 4: of a box, which derives its place; 0: none
        ("x", REAL, (sites,)),  # m, along the link from its proximal joint, …
        ("y", REAL, (sites,)),  # m, … and to the left of its line
        ("given_radius", REAL, (sites,)),  # m, or DERIVED: that of `contact`
        # derived at initialization
        ("radius", REAL, (sites,)),  # m
        ("along", REAL, (sites,)),  # x / length …
        ("beside", REAL, (sites,)),  # … and y / length
    )


@written_by("chain/motion.py", rest="rows/geometry.py")
def shift_dtype(candidates: int) -> np.dtype:
    """How the wall of each candidate moves, in a scene in which any does.

    variables/model.py sets what is not derived.
    """
    return table(
        candidates,
        ("channel", INTEGER),  # with which it moves, and with the next one its belt; −1: it is at rest
        ("rest", REAL),  # m, its offset if it had not moved
        ("rate", REAL),  # m/s, its speed along n …
        ("push", REAL),  # m/s², … and its acceleration
        ("travel", REAL),  # m, how far its belt has moved along t, …
        ("belt_rate", REAL),  # m/s, … the speed of that …
        ("belt_push", REAL),  # m/s², … and its acceleration
    )


@written_by("forces/contact_law.py")
def law_dtype(candidates: int) -> np.dtype:
    """The contact law of each candidate."""
    return table(
        candidates,
        ("same_as", INTEGER),  # the first candidate with the same law
        ("number", INTEGER),  # of the law, from 1; 0: not yet set
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
        ("harmless_depth", REAL),  # m, how deep a point may be in the wall without being in contact
    )


@given(AT_ANY_TIME)
@written_by()
def walls_dtype(candidates: int) -> np.dtype:
    """The walls at any angle, of which there are at most C, and the materials of all walls.

    variables/model.py sets them; an importer may set stiffness and restitution, as those in `given`.
    """
    return record(
        ("x", REAL, (candidates,)),  # m, a point on each …
        ("y", REAL, (candidates,)),
        ("angle", REAL, (candidates,)),  # rad, … and its direction from +x: the free side is to its left
        # of the box's walls first: N/m^exponent, 0 for that of `contact`, …
        ("stiffness", REAL, (len(WALLS) + candidates,)),
        # … and −1 for that of `contact`; likewise:
        ("restitution", REAL, (len(WALLS) + candidates,)),
        ("friction", REAL, (len(WALLS) + candidates,)),
        ("static_friction", REAL, (len(WALLS) + candidates,)),
    )

"""The parts of the record that the scene or an importer sets, and the values derived from them."""

import numpy as np

from chain_impact.kernel.chain.input_fields import EACH_DRIVE, FIELDS, TARGET
from chain_impact.kernel.chain.inputs import DEGREE
from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.kernel.record.fields import (
    AT_ANY_TIME,
    AT_START,
    FINITE,
    INTEGER,
    LIMIT,
    NOT_NEGATIVE,
    POSITIVE,
    REAL,
    bounded,
    record,
    settable,
    table,
    written_by,
)
from chain_impact.kernel.rows.geometry import WALLS

# fields of `chain`, one for each effect that drives may have: 1 if some drive has this effect
FLAGS = (
    *("has_springs", "has_springs_or_dampers", "has_armatures"),
    *("has_joint_places", "has_drive_friction", "has_drive_limits"),
)


@settable(AT_START)
@written_by("initialize.py", **dict.fromkeys(FLAGS, "chain/drives.py"))
def chain_dtype(links: int, sites: int) -> np.dtype:
    """Return the layout of the chain's data, and of the walls of the box."""
    return record(
        ("gravity", REAL, (2,)),  # m/s², x and y of gravity
        ("length", POSITIVE, (links,)),  # m, length of each link
        ("mass", POSITIVE, (links,)),  # kg, mass of each link
        # m, centre of mass of each link, from the proximal joint; DERIVED (chain/inertia.py) if not given
        ("given_center_of_mass", REAL, (links,)),
        # kg·m², inertia of each link about the centre of mass; DERIVED if not given
        ("given_inertia", REAL, (links,)),
        ("height", NOT_NEGATIVE, (links,)),  # m, height of a link that is a box; 0 for other links
        # m, how far the centre of mass lies to the left of the link's line; < 0: to the right
        ("center_of_mass_offset", FINITE, (links,)),
        # kg·m², inertia of the rotor of each joint's drive, which acts on the relative rotation in the joint
        ("joint_armature", NOT_NEGATIVE, (links,)),
        ("wall", FINITE, (len(WALLS),)),  # m, positions of the walls x_min, x_max, y_min, y_max
        # 1: a joint connects link 1 with the base, which is pinned or slides; 0: the base is free
        ("has_base_joint", INTEGER),
        # 1: the chain has inputs other than prescribed motions; they act in flight, too
        ("has_inputs", INTEGER),
        ("has_servos", INTEGER),  # 1: all joints, and a slider, have servos, whose targets are inputs
        ("base_moves", INTEGER),  # 1: a pinned base moves with the first two channels (chain/motion.py)
        # ---- derived at initialization
        # m, centre of mass of each link in use, from the proximal joint
        ("center_of_mass", FINITE, (links,)),
        ("inertia", NOT_NEGATIVE, (links,)),  # kg·m², inertia of each link in use, about the centre of mass
        ("has_springs", INTEGER),  # 1: some drive has a spring
        ("has_springs_or_dampers", INTEGER),  # 1: some drive has damping or a spring
        ("has_joint_stops", INTEGER),  # 1: some joint has a stop; stops of the slider do not count
        ("has_drive_friction", INTEGER),  # 1: some joint, or the slider, has dry friction
        # 1: some joint has a stop or dry friction; then all joints have places
        ("has_joint_places", INTEGER),
        ("has_armatures", INTEGER),  # 1: some joint has an armature
        ("has_drive_limits", INTEGER),  # 1: some drive has a limit
        # 1/s, upper bound on the decay rates and angular frequencies that dampers and springs cause
        ("joint_rate_bound", REAL),
        # distance of each link's centre of mass from the proximal joint, divided by the link's length
        ("center_of_mass_ratio", REAL, (links,)),
        # offset of each link's centre of mass from the link's line, divided by the link's length
        ("offset_ratio", REAL, (links,)),
        ("proximal_inertia", REAL, (links,)),  # kg·m², inertia of each link about its proximal joint
        ("distal_inertia", REAL, (links,)),  # kg·m², inertia of each link about its distal joint
        # index of the first site of each link; entry N is the number of sites
        ("first_site", bounded(0, sites), (links + 1,)),
        # number of the point at which the two arms of the elimination meet; 0, the base, if the base has a
        # joint
        ("meeting_joint", bounded(0, links)),
        ("gravity_size", REAL),  # m/s², magnitude of gravity
        ("reach", REAL),  # m, largest distance of a point or site of the stretched chain from the base
        ("longest_link", REAL),  # m, length of the longest link, the scale of positions
        # J, the scale of energies: (M s² + Σ I_a) (1 rad/s)², with the mass M of chain and carriage, the
        # longest link s and the armatures I_a
        ("energy_scale", REAL),
    )


@settable(AT_START)
@written_by("forces/candidate_laws.py")
def contact_dtype() -> np.dtype:
    """Return the layout of the contact data common to all walls; the rest of the law is in `given`."""
    return record(
        ("exponent", POSITIVE),
        ("radius", NOT_NEGATIVE),  # m, radius of the points
        # m/s, lower limit of the impact speed v₀, which is latched at the onset
        ("minimum_impact_speed", POSITIVE),
        # ---- derived at initialization
        ("any_force", INTEGER),  # 1: some candidate has a law with a force
        ("any_rigid", INTEGER),  # 1: some candidate has a law with impulses instead of a force
        ("any_friction", INTEGER),  # 1: some candidate has dry friction
    )


@settable(AT_START)
@written_by("initialize.py", restitution="forces/candidate_laws.py")
def stops_dtype() -> np.dtype:
    """Return the layout of the contact law of stops in joints.

    `given` has the stiffness and the restitution of these stops.
    """
    return record(
        ("law", INTEGER),  # number of the contact law, from 1; 0: the law of the walls
        ("given_exponent", REAL),  # exponent of the stops' law; DERIVED: not given, `contact` has it
        ("minimum_impact_speed", POSITIVE),  # rad/s, least impact speed in the law of stops
        # ---- derived at initialization
        ("exponent", POSITIVE),
        # restitution of the stops in use, only to be read from outside: the kernel uses the values in `law`
        ("restitution", REAL),
    )


@settable(AT_START)
@written_by("initialize.py")
def slider_dtype() -> np.dtype:
    """Return the layout of the slider: the line of the base and the carriage, see kernel/chain/slider.py."""
    return record(
        ("angle", FINITE),  # rad, direction of the line from +x
        ("mass", NOT_NEGATIVE),  # kg, mass of the carriage
        # ---- derived at initialization
        ("ux", REAL),  # x component of u, the unit vector along the line
        ("uy", REAL),
    )


@settable(AT_START)
@written_by("events/saturation.py", event="events/marks.py", margin="equations.py")
def drive_dtype(links: int) -> np.dtype:
    """Return the layout of the drives, see kernel/chain/drives.py: a row for each joint, then for the slider.

    The row of a slider has N and m in place of N·m and rad.
    """
    rows = (links + 1,)
    return record(
        ("friction", NOT_NEGATIVE, rows),  # N·m, dry friction of the joint; N for the slider
        # N·m, limit of the sum of the torques of motor, spring and damper; ∞: no limit
        ("limit", LIMIT, rows),
        ("min", REAL, rows),  # rad, lower stop of the joint's own angle; −∞: no stop
        ("max", REAL, rows),  # rad, upper stop of the joint's own angle; ∞: no stop
        # ---- set during the run
        # ±1: the force is at its positive or negative limit; 0: it is below the limit
        ("mode", INTEGER, rows),
        ("chosen", INTEGER, rows),  # in a tangent instance: the mode that the primal instance has chosen
        ("event", INTEGER),  # 1: the last step ends where the mode of a drive ends
        # N·m, least margin of any drive to the end of its mode (`mode_margin`) in the stages of the tried
        # step; 0 if no margin is negative
        ("margin", REAL),
    )


@settable(AT_START)
@written_by()
def initial_dtype(links: int) -> np.dtype:
    """Return the layout of the initial values."""
    return record(
        ("position", REAL, (2,)),  # m, initial position of the base, x and y
        ("velocity", REAL, (2,)),  # m/s, initial velocity of the base, x and y
        ("angle", REAL, (links,)),  # rad, initial absolute angle of each link
        ("angular_velocity", REAL, (links,)),  # rad/s, initial angular velocity of each link
        ("slider_velocity", FINITE),  # m/s, initial velocity along the line of a slider
    )


@settable(AT_START)
@written_by()
def solver_dtype() -> np.dtype:
    """Return the layout of the settings of the solver."""
    return record(
        # number of the method: index into SOLVER_METHODS of kernel/ode/control.py, counted from 1
        ("method", bounded(1, len(SOLVER_METHODS))),
        ("tolerance", POSITIVE),
        ("work_limit", POSITIVE),  # 1/s, largest number of evaluations per second of simulated time
    )


def input_fields(links: int, *rows: int, target: object = REAL) -> list[tuple[object, ...]]:
    """Return a field for each input: an array of its values or, if ``rows`` is given, a table with such rows.

    ``target`` is the type of the targets of springs.
    """
    return [
        (name, target if k == TARGET else REAL, (*rows, links + 1 if size == EACH_DRIVE else size))
        for k, (name, size) in enumerate(FIELDS.items())
    ]


def piece_dtype(links: int) -> np.dtype:
    """Return the layout of one piece of the inputs, polynomials of time, see kernel/chain/inputs.py."""
    return record(
        ("order", bounded(0, DEGREE)),  # degree of the polynomials; 0: the inputs are constant
        # Row k of each table of coefficients belongs to the power xᵏ of the polynomials' argument x. Within
        # the piece x is between −1 and 1, so that the powers of x lose no digits in a short or late piece.
        ("middle", REAL),  # s, time at which the argument x of the polynomials is 0
        ("scale", REAL),  # 1/s, rate of the argument x in time
        ("until", REAL),  # s, end of the piece
        # rad/s, largest angular frequency of the inputs; for other functions a comparable rate
        ("change_rate", REAL),
        *input_fields(links, DEGREE + 1),  # coefficients of the polynomials of the inputs
    )


@settable(AT_ANY_TIME)
@written_by(changed="chain/inputs.py", piece="chain/inputs.py")
def given_dtype(links: int) -> np.dtype:
    """Return the layout of the values that an importer can set at any time.

    The kernel applies new values at the beginning of the next advance. A piece of the inputs that continues
    the last piece is applied at the start of a step.
    """
    return record(
        # what was set since the last step (chain/inputs.py). REINITIALIZE: a value; CONTINUES: only the next
        # piece of the inputs; 0: nothing
        ("changed", INTEGER),
        ("law", INTEGER),  # number of the contact law of walls, from 1
        ("stiffness", REAL),  # N/m^exponent, stiffness of walls
        ("restitution", REAL),  # restitution of walls
        ("friction", REAL),  # coefficient of sliding friction of walls
        # coefficient of static friction of walls; 0: equal to the coefficient of sliding friction
        ("static_friction", REAL),
        ("stop_stiffness", REAL),  # N·m/rad^exponent, stiffness of stops
        ("stop_restitution", REAL),  # restitution of stops; DERIVED: not given, that of walls is used
        # N·m·s/rad, damping of each joint's drive; the last one is the slider's, N·s/m
        ("drive_damping", NOT_NEGATIVE, (links + 1,)),
        # N·m/rad, stiffness of each joint's drive; the last one is the slider's, N/m
        ("drive_stiffness", NOT_NEGATIVE, (links + 1,)),
        *input_fields(links, target=FINITE),
        ("piece", piece_dtype(links)),
    )


@written_by("chain/inputs.py")
def inputs_dtype(links: int) -> np.dtype:
    """Return the layout of the values in use: the inputs, and the damping and stiffness of drives."""
    return record(
        # N·m·s/rad, damping of each joint's drive; the last one is the slider's, N·s/m
        ("drive_damping", REAL, (links + 1,)),
        # N·m/rad, stiffness of each joint's drive; the last one is the slider's, N/m
        ("drive_stiffness", REAL, (links + 1,)),
        *input_fields(links),
        ("piece", piece_dtype(links)),
    )


@settable(AT_ANY_TIME)
@written_by("chain/inputs.py")
def motion_dtype(channels: int) -> np.dtype:
    """Return the layout of the given motions of base and walls by channel, see kernel/chain/motion.py."""
    return record(
        # 1: the motions are cubics that follow the values given at communication points; 0: their polynomials
        # are given in ``piece``
        ("interpolates", INTEGER),
        ("jumps", INTEGER),  # 1: the speed of a belt jumps where the next piece of the inputs begins
        ("belt", INTEGER, (channels,)),  # 1: the channel is the travel of a belt
        ("position", REAL, (channels,)),  # m, given position of each channel; 0 for a belt
        ("velocity", REAL, (channels,)),  # m/s, given velocity of each channel
        ("acceleration", REAL, (channels,)),  # m/s², given acceleration of each channel; 0 for a belt
        # m, coefficients of each channel's position in the next piece of the inputs
        ("piece", REAL, (DEGREE + 1, channels)),
    )


@written_by("chain/inputs.py", **dict.fromkeys(("position", "velocity", "acceleration"), "chain/motion.py"))
def moved_dtype(channels: int) -> np.dtype:
    """Return the layout of the motions of base and walls in use, and of the given values behind them."""
    return record(
        ("began", REAL),  # s, time at which the run started
        ("until", REAL),  # s, the communication point at which the present cubics end
        # number, from 1, of the first channel whose given positions and velocities contradict each other; 0:
        # none. The next three fields tell the user how
        ("contradiction", INTEGER),
        ("distance", REAL),  # m, displacement of the contradictory channel since the previous given values
        ("lasted", REAL),  # s, time since the previous given values
        ("speed", REAL),  # m/s, given velocity of the contradictory channel
        ("position", REAL, (channels,)),  # m, position after the last `move_channels` (chain/motion.py)
        ("velocity", REAL, (channels,)),  # m/s, velocity after the last `move_channels`
        ("acceleration", REAL, (channels,)),  # m/s², acceleration after the last `move_channels`
        # m, coefficients of each channel's position in the present piece of the inputs
        ("piece", REAL, (DEGREE + 1, channels)),
        # ---- values that were given to each channel at their most recent change
        ("given_position", REAL, (channels,)),  # m, given position of each channel
        ("given_velocity", REAL, (channels,)),  # m/s, given velocity of each channel
        ("given_acceleration", REAL, (channels,)),  # m/s², given acceleration of each channel
        ("given_at", REAL, (channels,)),  # s, time of the most recent change of the given values
        # m, position of a channel at the last change, from which it goes on
        ("from_position", REAL, (channels,)),
        # m/s, velocity of a channel at the last change, with which it goes on
        ("from_velocity", REAL, (channels,)),
        # 1: the last change gave a position, which the motion follows; 0: it gave none, and the velocity is
        # integrated
        ("anchored", INTEGER, (channels,)),
        # m/s, mean velocity since the previous given position, of a base without a given velocity; else 0
        ("mean", REAL, (channels,)),
        # ---- numbers that are 0, but have derivatives with respect to given values (tangent/replay.py)
        ("added", REAL, (channels,)),  # m, added to `position`
        ("added_rate", REAL, (channels,)),  # m/s, added to `velocity`
        ("added_acceleration", REAL, (channels,)),  # m/s², added to `acceleration`
    )


@settable(AT_START)
@written_by("initialize.py")
def site_dtype(links: int, sites: int) -> np.dtype:
    """Return the layout of the sites, points fixed to links beside the joints, in the order of the links."""
    return record(
        ("link", bounded(0, links - 1), (sites,)),  # index of the site's link, from 0
        # 1 to 4: the site is a corner of a box, which determines its position; 0: not a corner
        ("corner", INTEGER, (sites,)),
        ("x", FINITE, (sites,)),  # m, position of the site along the link, from the proximal joint
        ("y", FINITE, (sites,)),  # m, position of the site beside the link's line, to the left
        ("given_radius", REAL, (sites,)),  # m, given radius; DERIVED: not given, `contact` has it
        # ---- derived at initialization
        ("radius", NOT_NEGATIVE, (sites,)),  # m, radius of the site in use
        ("along", REAL, (sites,)),  # position x of the site divided by the link's length
        ("beside", REAL, (sites,)),  # position y of the site divided by the link's length
    )


@written_by("chain/motion.py", unmoved_offset="rows/geometry.py")
def shift_dtype(candidates: int) -> np.dtype:
    """Return the layout of the present motion of each candidate's wall, in a scene with moving walls."""
    return table(
        candidates,
        # first channel of the wall; the next channel moves the wall's belt; −1: the wall does not move
        ("channel", INTEGER),
        ("unmoved_offset", REAL),  # m, offset of the wall at the displacement 0
        ("rate", REAL),  # m/s, speed of the wall along its normal n
        ("acceleration", REAL),  # m/s², acceleration of the wall along its normal n
        ("travel", REAL),  # m, distance that the belt has moved along its direction t
        ("belt_rate", REAL),  # m/s, speed of the belt along its direction t
        ("belt_acceleration", REAL),  # m/s², acceleration of the belt along its direction t
    )


@settable(AT_ANY_TIME)
@written_by()
def walls_dtype(candidates: int) -> np.dtype:
    """Return the layout of the walls at any angle, at most C, and of the materials of all walls.

    An importer may set the values of the materials at any time.
    """
    return record(
        ("x", FINITE, (candidates,)),  # m, x of a point on each wall
        ("y", FINITE, (candidates,)),  # m, y of the same point on each wall
        ("angle", FINITE, (candidates,)),  # rad, direction of each wall from +x; the free side is to the left
        # ---- materials of all walls; the walls of the box come first
        ("stiffness", REAL, (len(WALLS) + candidates,)),  # N/m^exponent, stiffness; 0: `given.stiffness`
        ("restitution", REAL, (len(WALLS) + candidates,)),  # restitution; −1: `given.restitution`
        ("friction", REAL, (len(WALLS) + candidates,)),  # coefficient of sliding; −1: `given.friction`
        # coefficient of static friction; −1: the static coefficient follows the wall's own sliding
        # coefficient or, without it, is `given.static_friction`
        ("static_friction", REAL, (len(WALLS) + candidates,)),
    )

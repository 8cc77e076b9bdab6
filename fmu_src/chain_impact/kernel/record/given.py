"""The parts of the record that the scene and an importer set, and the values that the kernel derives."""

import numpy as np

from chain_impact.kernel.record.constants import INPUT_DEGREE, SOLVER_METHODS, WALLS
from chain_impact.kernel.record.fields import (
    AT_ANY_TIME,
    AT_START,
    FINITE,
    INTEGER,
    LIMIT_REAL,
    NOT_NEGATIVE,
    POSITIVE,
    REAL,
    bounded_integer,
    layout,
    settable,
    written_by,
)
from chain_impact.kernel.record.input_fields import EACH_DRIVE, INPUT_SIZES, TARGET

# fields of `chain` that ``set_effect_flags`` (chain/drives.py) sets: which effects joints or slider have
EFFECT_FLAGS = (
    *("has_springs", "has_springs_or_dampers", "has_armatures"),
    *("has_joint_places", "has_drive_friction", "has_drive_limits"),
)


@settable(AT_START)
@written_by("initialize.py", **dict.fromkeys(EFFECT_FLAGS, "chain/drives.py"))
def chain_dtype(link_count: int, site_count: int) -> np.dtype:
    """Return the layout of the chain's data, and of the walls of the box."""
    return layout(
        ("gravity", REAL, (2,)),  # m/s², x and y of gravity
        ("length", POSITIVE, (link_count,)),  # m, length of each link
        ("mass", POSITIVE, (link_count,)),  # kg, mass of each link
        # m, given distance along each link from its proximal joint to its centre of mass; NOT_GIVEN
        # (constants.py): the middle of the link is used
        ("given_center_of_mass", REAL, (link_count,)),
        # kg·m², given inertia of each link about its centre of mass; NOT_GIVEN (constants.py): the inertia of
        # a uniform rod or box is used
        ("given_inertia", REAL, (link_count,)),
        # m, height, across the link, of a link that is a box; else 0
        ("height", NOT_NEGATIVE, (link_count,)),
        # m, how far the centre of mass lies to the left of the link's line; < 0: to the right
        ("center_of_mass_offset", FINITE, (link_count,)),
        # kg·m², inertia of the rotor of each joint's drive against the relative rotation in the joint
        ("joint_armature", NOT_NEGATIVE, (link_count,)),
        ("box_wall", FINITE, (len(WALLS),)),  # m, positions of the walls x_min, x_max, y_min, y_max
        # 1: a joint connects link 1 with the base, which is pinned or slides; 0: the base is free
        ("has_base_joint", INTEGER),
        # 1: the scene has inputs other than motions of walls (a wall acts on the chain only in a contact)
        ("has_inputs", INTEGER),
        ("has_targets", INTEGER),  # 1: all drives have targets, which are inputs; 0: no drive has one
        # 1: a pinned base moves with the first two channels (chain/prescribed_motion.py)
        ("base_moves", INTEGER),
        # ---- derived at initialization
        # m, distance along each link from its proximal joint to its centre of mass, given or derived
        ("center_of_mass", FINITE, (link_count,)),
        # kg·m², inertia of each link about its centre of mass, given or derived
        ("inertia", NOT_NEGATIVE, (link_count,)),
        ("has_springs", INTEGER),  # 1: some drive, of a joint or the slider, has a spring
        ("has_springs_or_dampers", INTEGER),  # 1: some drive has a damper or a spring
        ("has_joint_stops", INTEGER),  # 1: some joint has a stop; stops of the slider do not count
        ("has_drive_friction", INTEGER),  # 1: some joint, or the slider, has dry friction
        # 1: some joint has a stop or dry friction; then all joints have places
        ("has_joint_places", INTEGER),
        ("has_armatures", INTEGER),  # 1: some joint has an armature
        ("has_drive_limits", INTEGER),  # 1: some drive has a largest torque or force
        # 1/s, upper bound on the decay rates and angular frequencies that dampers and springs of drives cause
        ("joint_rate_bound", REAL),
        # distance along each link from its proximal joint to its centre of mass, divided by the link's length
        ("center_of_mass_ratio", REAL, (link_count,)),
        # distance of each link's centre of mass to the left of the link's line, divided by the link's length
        ("offset_ratio", REAL, (link_count,)),
        ("proximal_inertia", REAL, (link_count,)),  # kg·m², inertia of each link about its proximal joint
        ("distal_inertia", REAL, (link_count,)),  # kg·m², inertia of each link about its far end
        # index of the first site of each link, with links counted from 0: link i has the sites from
        # first_site[i] to first_site[i + 1] − 1; entry N is the number of sites
        ("first_site", bounded_integer(0, site_count), (link_count + 1,)),
        # number of the point at which the two arms of the elimination meet (chain/elimination.py): 0, the
        # base, if the base has a joint; else N/2, rounded down
        ("meeting_joint", bounded_integer(0, link_count)),
        ("gravity_magnitude", REAL),  # m/s², magnitude of the vector ``gravity``
        ("reach", REAL),  # m, largest distance from the base that a point or site can have
        # m, length of the longest link: the scale of positions, to which errors and round-off are relative
        ("longest_link", REAL),
        # J, (M s² + Σ I_a)/(1 s)², with the mass M of chain and carriage, the longest link s and the
        # armatures I_a: the least scale to which errors of energies are relative
        ("energy_scale", REAL),
    )


@settable(AT_START)
@written_by("forces/candidate_laws.py")
def contact_settings_dtype() -> np.dtype:
    """Return the layout of contact data common to all walls and the slider's stops.

    `given` and `walls` have the other data of the laws of these walls and stops.
    """
    return layout(
        ("exponent", POSITIVE),  # exponent n of the elastic force K δⁿ
        ("radius", NOT_NEGATIVE),  # m, radius of the points, and of sites without a radius of their own
        # m/s, least impact speed v₀ in the laws of walls and of the slider's stops: v₀ of a slower impact is
        # raised to this speed
        ("minimum_impact_speed", POSITIVE),
        # ---- derived at initialization
        ("any_force_law", INTEGER),  # 1: some candidate has a law with a force
        ("any_rigid", INTEGER),  # 1: some candidate has a law with impulses instead of a force
        ("any_friction", INTEGER),  # 1: some candidate has dry friction
    )


@settable(AT_START)
@written_by("initialize.py", restitution="forces/candidate_laws.py")
def stops_dtype() -> np.dtype:
    """Return the layout of the contact law of stops in joints; `given` has its stiffness and restitution."""
    return layout(
        ("law", INTEGER),  # number of the law of stops in joints, from 1; 0: the law of the walls is used
        # exponent n of the law of stops; NOT_GIVEN (constants.py): that of `contact_settings` is used
        ("given_exponent", REAL),
        ("minimum_impact_speed", POSITIVE),  # rad/s, least impact speed in the law of stops in joints
        # ---- derived at initialization
        ("exponent", POSITIVE),
        # restitution of stops in joints, given or `given.restitution`; the kernel only writes this field for
        # its callers, because `law` has the restitution of each candidate
        ("restitution", REAL),
    )


@settable(AT_START)
@written_by("initialize.py")
def slider_dtype() -> np.dtype:
    """Return the layout of the slider: the line along which the base slides, and its carriage."""
    return layout(
        ("angle", FINITE),  # rad, direction of the slider's line, from +x
        ("mass", NOT_NEGATIVE),  # kg, mass of the carriage, which moves with the base
        # ---- derived at initialization
        ("ux", REAL),  # x component of u, the unit vector along the slider's line
        ("uy", REAL),
    )


@settable(AT_START)
@written_by("events/saturation.py", event="events/marks.py", mode_margin="equations.py")
def drive_dtype(link_count: int) -> np.dtype:
    """Return the layout of the drives, see kernel/chain/drives.py: a row for each joint, then for the slider.

    The row of a slider has N and m in place of N·m and rad; without a slider, this row is not used.

    Other parts of the record have the other data of a drive: `given` has the values that can change during a
    run (damping, stiffness, targets and torque), `inputs` has those of these values that are in use, and
    `chain` has ``joint_armature``.
    """
    rows = (link_count + 1,)
    return layout(
        ("friction", NOT_NEGATIVE, rows),  # N·m, largest moment of dry friction in the joint
        # N·m, largest absolute value of the sum of the torques of motor, spring and damper; ∞: no limit
        ("limit", LIMIT_REAL, rows),
        ("min", REAL, rows),  # rad, angle of the joint at which the lower stop begins to act; −∞: no stop
        ("max", REAL, rows),  # rad, angle of the joint at which the upper stop begins to act; ∞: no stop
        # ---- set during the run
        # 1 or −1: the drive's torque is held at its positive or negative limit; 0: no limit holds the torque
        ("mode", INTEGER, rows),
        ("chosen_mode", INTEGER, rows),  # in a tangent instance: the drive's ``mode`` in the primal instance
        # 1: at the end of the last step the mode of some drive ends; 0: none ends
        ("event", INTEGER),
        # N·m, the least result of ``mode_margin`` (chain/drives.py) in the stages of the tried step, or 0 if
        # this is larger; a negative number says that a drive has passed the end of its mode
        ("mode_margin", REAL),
    )


@settable(AT_START)
@written_by()
def initial_dtype(link_count: int) -> np.dtype:
    """Return the layout of the positions and velocities at the start of a run."""
    return layout(
        ("position", REAL, (2,)),  # m, initial position of the base, x and y
        ("velocity", REAL, (2,)),  # m/s, initial velocity of the base, x and y; not used with a slider
        ("angle", REAL, (link_count,)),  # rad, initial absolute angle of each link
        ("angular_velocity", REAL, (link_count,)),  # rad/s, initial absolute angular velocity of each link
        ("slider_velocity", FINITE),  # m/s, initial velocity of the base along the line of a slider
    )


@settable(AT_START)
@written_by()
def solver_dtype() -> np.dtype:
    """Return the layout of the settings of the solver."""
    return layout(
        # number of the method of integration, from 1: its position in SOLVER_METHODS of constants.py
        ("method", bounded_integer(1, len(SOLVER_METHODS))),
        ("tolerance", POSITIVE),  # allowed error of a step, relative to the scales of ode/step_errors.py
        # 1/s, largest cost per second of simulated time, as a number of evaluations of ẏ (kernel/cost.py)
        ("work_limit", POSITIVE),
    )


def input_fields(link_count: int, *rows: int, target: object = REAL) -> list[tuple[object, ...]]:
    """Return a field for each input: an array of the input's values, such as the torque of each motor.

    With a number in ``rows``, the array has this number of rows, a row for each coefficient of a polynomial,
    and a column for each value. ``target`` is the type of targets, REAL or FINITE, a real in a checked range.
    """
    return [
        (name, target if k == TARGET else REAL, (*rows, link_count + 1 if size == EACH_DRIVE else size))
        for k, (name, size) in enumerate(INPUT_SIZES.items())
    ]


def piece_dtype(link_count: int) -> np.dtype:
    """Return the layout of one piece of the inputs: an interval in which they are polynomials of time.

    kernel/chain/inputs.py has the formula.
    """
    return layout(
        ("degree", bounded_integer(0, INPUT_DEGREE)),  # degree of the polynomials; 0: the inputs are constant
        # Row k of each table of coefficients belongs to the power xᵏ of the polynomials' argument x. In a
        # piece with an end, −1 ≤ x ≤ 1, so that the powers of x lose no digits in a short or late piece.
        ("middle", REAL),  # s, time at which the argument x of the polynomials is 0
        ("scale", REAL),  # 1/s, rate of the argument x in time
        ("end", REAL),  # s, end of the piece, up to round-off; without meaning if ``degree`` is 0
        # rad/s, how fast the inputs change in the piece: the angular frequency of a sine that is as fast
        ("change_rate", REAL),
        *input_fields(link_count, INPUT_DEGREE + 1),  # coefficients of the polynomials of the inputs
    )


@settable(AT_ANY_TIME)
@written_by(pending="chain/inputs.py", piece="chain/inputs.py")
def given_dtype(link_count: int) -> np.dtype:
    """Return the layout of the values that an importer can set at any time.

    The kernel applies new values at the start of the next call that advances the run. A piece of the inputs
    that continues the present piece without a jump is applied at the start of the next step.
    """
    return layout(
        # kind of the values that are set, but not in use yet, a constant of chain/inputs.py. REINITIALIZE: an
        # input or a parameter, so that the solver restarts; CONTINUES: only the next piece of the
        # inputs, without a jump; 0: no values
        ("pending", INTEGER),
        # number, from 1, of the contact law of walls and stops; stops in joints have `stops.law`, if > 0
        ("law", INTEGER),
        # N/m^exponent, stiffness K of the slider's stops, and of walls without a stiffness in `walls`
        ("stiffness", REAL),
        # restitution e of the slider's stops, of walls without a restitution in `walls`, and of stops in
        # joints without ``stop_restitution``
        ("restitution", REAL),
        ("friction", REAL),  # coefficient of sliding friction of walls without such a coefficient in `walls`
        # coefficient of static friction of walls without any coefficient in `walls`; 0: equal to ``friction``
        ("static_friction", REAL),
        ("stop_stiffness", REAL),  # N·m/rad^exponent, stiffness of stops in joints
        # restitution of stops in joints; NOT_GIVEN (constants.py): ``restitution`` is used
        ("stop_restitution", REAL),
        # N·m·s/rad, damping of each joint's drive; the last entry belongs to the slider, N·s/m
        ("drive_damping", NOT_NEGATIVE, (link_count + 1,)),
        # N·m/rad, stiffness of each joint's drive; the last entry belongs to the slider, N/m
        ("drive_stiffness", NOT_NEGATIVE, (link_count + 1,)),
        *input_fields(link_count, target=FINITE),
        ("piece", piece_dtype(link_count)),
    )


@written_by("chain/inputs.py")
def inputs_dtype(link_count: int) -> np.dtype:
    """Return the layout of the values in use of the inputs, and of the damping and stiffness of drives."""
    return layout(
        # N·m·s/rad, damping of each joint's drive; the last entry belongs to the slider, N·s/m
        ("drive_damping", REAL, (link_count + 1,)),
        # N·m/rad, stiffness of each joint's drive; the last entry belongs to the slider, N/m
        ("drive_stiffness", REAL, (link_count + 1,)),
        *input_fields(link_count),
        ("piece", piece_dtype(link_count)),
    )


@settable(AT_START)
@written_by("initialize.py")
def site_dtype(link_count: int, site_count: int) -> np.dtype:
    """Return the layout of the sites in the order of their links: points of links other than their ends."""
    return layout(
        ("link", bounded_integer(0, link_count - 1), (site_count,)),  # index of the site's link, from 0
        # 1 to 4: number of the box's corner at which the site lies (``corner_of_box``); 0: not a corner
        ("corner", INTEGER, (site_count,)),
        ("x", FINITE, (site_count,)),  # m, position of the site along the link, from the proximal joint
        ("y", FINITE, (site_count,)),  # m, distance of the site from the link's line; > 0: to the left
        # m, given radius; NOT_GIVEN (constants.py): `contact_settings.radius` is used
        ("given_radius", REAL, (site_count,)),
        # ---- derived at initialization
        ("radius", NOT_NEGATIVE, (site_count,)),  # m, radius of the site, given or that of the settings
        ("along", REAL, (site_count,)),  # position x of the site divided by the link's length
        ("beside", REAL, (site_count,)),  # position y of the site divided by the link's length
    )


@settable(AT_ANY_TIME)
@written_by()
def walls_dtype(candidate_count: int) -> np.dtype:
    """Return the layout of the walls at any angle, and of the materials of all walls.

    The arrays have room for a wall at an angle for each candidate. New values of materials take effect at any
    time, those of ``x``, ``y`` and ``angle`` at the start of the next run.
    """
    return layout(
        ("x", FINITE, (candidate_count,)),  # m, x of one point on the edge of each wall
        ("y", FINITE, (candidate_count,)),  # m, y of the same point
        # rad, direction of each wall, from +x; the free side is to the left of this direction
        ("angle", FINITE, (candidate_count,)),
        # ---- materials of all walls; the walls of the box come first
        # N/m^exponent, stiffness K of each wall; 0: the wall has no own stiffness, `given.stiffness` is used
        ("stiffness", REAL, (len(WALLS) + candidate_count,)),
        # restitution of each wall; −1: `given.restitution` is used
        ("restitution", REAL, (len(WALLS) + candidate_count,)),
        # coefficient of sliding friction of each wall; −1: `given.friction` is used
        ("friction", REAL, (len(WALLS) + candidate_count,)),
        # coefficient of static friction of each wall; 0: equal to the wall's coefficient of sliding; −1: not
        # given, so equal to this wall's own coefficient of sliding or, without one, `given.static_friction`
        ("static_friction", REAL, (len(WALLS) + candidate_count,)),
    )

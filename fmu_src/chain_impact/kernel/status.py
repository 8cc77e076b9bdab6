"""Status codes, and a sentence for users for each code ≥ 0."""

OK = 0
STEP_TOO_SMALL = 1
NOT_FINITE = 2
EVENT_STORM = 3
STARTS_INSIDE_WALL = 4
RESTITUTION_NOT_ALLOWED = 5
UNKNOWN_LAW = 6
UNKNOWN_METHOD = 7
PARAMETER_OUT_OF_RANGE = 8
TOO_MUCH_WORK = 9
EXPONENT_NOT_ALLOWED = 10
RIGID_WHILE_TOUCHING = 11
ENERGY_NOT_KEPT = 12
MASS_MATRIX_SINGULAR = 13
STEP_TOO_LONG = 14
FRICTION_WITH_RIGID_WALLS = 15
FORCES_NOT_FOUND = 16
STATIC_BELOW_SLIDING = 17
STOPS_REVERSED = 18
WALL_JUMPS = 19
BASE_BEYOND_WALL = 20
NO_ROOM = 21
SIGNAL_JUMPS = 22
# no fault: the log of ended contacts, or of changes of friction modes, is full; after the caller has
# collected the entries, the run may continue
LOG_FULL = -1
PAUSED = -2  # no fault: the call has returned so that the caller can stop or continue the run
ONSET_DUE = -3  # no fault: contacts begin at the time that was reached, and their onsets are not applied yet

WITHOUT_FRICTION = (
    "Newton's law of impact together with Coulomb's law of friction can add energy, and the motion of a "
    "rigid body that slides on a rigid wall need neither exist nor be unique"
)
"""The reason, told to users, why rigid walls have no friction."""
STATUS_TEXT = {
    OK: "no fault",
    STEP_TOO_SMALL: "the error control asks for a step smaller than the resolution of time: loosen "
    "solver.tolerance, or lower contact.stiffness or stop.stiffness",
    NOT_FINITE: "the state or its energy is not finite: initial values, parameters or inputs are too large",
    EVENT_STORM: "too many contacts begin and end in too short a time: for points at walls, raise "
    "contact.minimum_impact_speed or lower contact.restitution; for joints at stops, raise "
    "stop.minimum_impact_speed or lower stop.restitution; for walls that move, leave more room between them; "
    "for a joint at its joint_torque_limit, lower its joint_stiffness; for a slider at its force_limit, "
    "lower slider.stiffness",
    STARTS_INSIDE_WALL: "a contact point starts beyond a wall, or a joint or slider beyond a stop",
    RESTITUTION_NOT_ALLOWED: "the contact law does not allow this restitution",
    UNKNOWN_LAW: "contact.model is not the number of a law",
    UNKNOWN_METHOD: "solver.method is not the number of a method",
    PARAMETER_OUT_OF_RANGE: "a parameter is not finite or lies outside its range",
    TOO_MUCH_WORK: "a second of simulated time takes more evaluations than solver.work_limit allows: "
    "raise solver.work_limit, loosen solver.tolerance, or lower contact.stiffness or the joint_stiffness of "
    "links",
    EXPONENT_NOT_ALLOWED: "the contact law is defined for another exponent",
    RIGID_WHILE_TOUCHING: "contact.model can change to newton_impact only while nothing touches",
    ENERGY_NOT_KEPT: "the energy drifts in a second of simulated time by more than 100 times what "
    "solver.tolerance allows for a step, or in the whole run by a fifth of the energy: if solver.tolerance "
    "is above 1e-8, lower it, which makes errors of steps smaller; else raise it, because round-off is too "
    "large for it",
    MASS_MATRIX_SINGULAR: "links without inertia can turn while no mass moves: the inertia of one of them, "
    "or slider.mass, must be > 0",
    STEP_TOO_LONG: "the time to the next communication point takes more evaluations than 20 times "
    "solver.work_limit: take shorter communication steps or raise solver.work_limit",
    FRICTION_WITH_RIGID_WALLS: f"newton_impact has no contact friction: {WITHOUT_FRICTION}: choose a law "
    "with a force, or set the coefficients of friction to 0",
    FORCES_NOT_FOUND: "at an event, the solver finds no forces that satisfy the conditions of all contacts "
    "and all sticking elements together: change the initial state or solver.tolerance a little",
    STATIC_BELOW_SLIDING: "static_friction is below friction: it must be at least friction, or 0, which "
    "means equal to friction",
    STOPS_REVERSED: "the lower stop (min) is not below the upper stop (max)",
    WALL_JUMPS: "a wall is given another displacement without the velocity that leads there, as a jump would "
    "be an impact of unknown strength: give its velocity, too",
    BASE_BEYOND_WALL: "the base is beyond a wall: base and wall must not move through each other",
    NO_ROOM: "moving rigid walls, or a moving base, have squeezed the chain: let them stop before, or take a "
    "law with a force",
    SIGNAL_JUMPS: "a signal lets base or wall jump in position or velocity, which would be an impact of "
    "unknown strength: let it rise or begin smoothly",
}
# status ≥ 0 → its name in results of sweeps: the constant's name in lower case
STATUS_NAME = {code: name.lower() for name, code in globals().items() if name[0] != "_" and code in range(99)}
LAST_STATUS = max(STATUS_TEXT)


def set_status(d, status):
    """Set the status of the run in the record, and return the status."""
    d.statistics.status = status
    return status


# The kinds of parts of a scene that can cause a fault, in the order of the parts' numbers in `fault.part`:
# candidates, links, drives (of the joints, then of the slider), and the base at the wall of each candidate.
# ``part_texts`` in scene/candidates.py has the texts for these numbers.
CANDIDATE_PART, LINK_PART, DRIVE_PART, BASE_PART = range(4)


def refuse_part(d, kind, index, status):
    """Store the part of the scene that causes a fault; return the fault's status, which the caller sets.

    Args:
        d: the instance.
        kind: the kind of the part: CANDIDATE_PART, LINK_PART, DRIVE_PART or BASE_PART.
        index: the index of the part among the parts of its kind, from 0; for BASE_PART the index of the
            candidate at whose wall the base is.
        status: the status of the fault.
    """
    number = 1 + index
    if kind > CANDIDATE_PART:
        number += d.candidate_count
    if kind > LINK_PART:
        number += d.link_count
    if kind > DRIVE_PART:
        number += d.link_count + d.slides
    d.fault.part = number
    return status

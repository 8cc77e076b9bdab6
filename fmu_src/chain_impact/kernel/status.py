"""Status codes of the kernel, with the sentence that users read, and a name for tables."""

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
LOG_FULL = -1  # not a fault: collect the finished contacts, then continue
PAUSED = -2  # not a fault: the caller may continue
ONSET_DUE = -3  # not a fault: contacts begin at the time reached and are not yet applied

WITHOUT_FRICTION = (
    "Newton's law of impact together with Coulomb's law of friction can add energy, and the motion of a "
    "rigid body that slides on a rigid wall need neither exist nor be unique"
)
"""Why rigid walls have no friction."""
STATUS_TEXT = {
    OK: "no fault",
    STEP_TOO_SMALL: "the error control asks for a step smaller than the resolution of time: loosen "
    "solver.tolerance or lower contact.stiffness or stop.stiffness",
    NOT_FINITE: "the state or its energy is no longer finite: initial values, parameters or "
    "inputs are too large",
    EVENT_STORM: "too many contacts begin and end in too short a time: a larger contact.minimum_impact_speed "
    "or a smaller contact.restitution brings points to rest, and those of stops bring joints to rest",
    STARTS_INSIDE_WALL: "a contact point starts beyond a wall, or a joint beyond a stop",
    RESTITUTION_NOT_ALLOWED: "the contact law does not allow this restitution",
    UNKNOWN_LAW: "contact.model is not the number of a law",
    UNKNOWN_METHOD: "solver.method is not the number of a method",
    PARAMETER_OUT_OF_RANGE: "a parameter is not finite or lies outside its range",
    TOO_MUCH_WORK: "a second of simulated time takes more evaluations than solver.work_limit allows: "
    "raise it, loosen solver.tolerance, or lower contact.stiffness or the joint_stiffness of links",
    EXPONENT_NOT_ALLOWED: "the contact law is defined for another exponent",
    RIGID_WHILE_TOUCHING: "contact.model can change to newton_impact only while nothing touches",
    ENERGY_NOT_KEPT: "the energy drifts in a second of simulated time by more than 100 times what "
    "solver.tolerance allows for a step, or errors have added or taken a fifth of it: tighten it if it is "
    "above 1e-8, or else loosen it",
    MASS_MATRIX_SINGULAR: "links without inertia can turn about their centres of mass without moving any "
    "mass: the inertia of one of them must be > 0",
    STEP_TOO_LONG: "the time to the next communication point takes more evaluations than 20 times "
    "solver.work_limit: take shorter communication steps or raise it",
    FRICTION_WITH_RIGID_WALLS: f"newton_impact has no contact friction: {WITHOUT_FRICTION}: choose a law "
    "with a force, or set the coefficients of friction to 0",
    FORCES_NOT_FOUND: "at an event no forces have been found that agree with all that is held: change the "
    "initial state or solver.tolerance a little",
    STATIC_BELOW_SLIDING: "static_friction is below friction, the coefficient of sliding: it must be "
    "at least that, or 0 for the same",
    STOPS_REVERSED: "joint_min is not below joint_max",
}
# Status → its name in the tables of sweeps, that of the constant.
STATUS_NAME = {code: name.lower() for name, code in globals().items() if name[0] != "_" and code in range(99)}
LAST_STATUS = max(STATUS_TEXT)


def set_status(d, status):
    """Set the status of the run, and return it."""
    d.statistics.status = status
    return status


def clear_fault(d):
    """Forget where an earlier run was refused."""
    d.fault.place = 0


def refuse_candidate(d, c, status):
    """Note that candidate c is the reason for a status, and return it."""
    d.fault.place = 1 + c
    return status


def refuse_link(d, i, status):
    """Note that link i, counted from 0, or its joint is the reason for a status, and return it."""
    d.fault.place = 1 + d.candidates + i
    return status

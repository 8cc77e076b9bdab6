"""The parts of the record with the data of contacts."""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count
from chain_impact.kernel.ode.dense import DENSE_COEFFICIENTS
from chain_impact.kernel.ode.explicit import STAGES
from chain_impact.kernel.record.fields import INTEGER, REAL, record, written_by

CHANGES_OF_EACH = 4  # changes of a mode stored until they are collected, for each element
LOG_SIZE = 32  # finished contacts stored until they are collected, in addition to one for each candidate
LATEST = LOG_SIZE  # how many of the latest impacts are listed at most


def constraint_count(candidates: int, elements: int) -> int:
    """The largest number of constraints at one moment."""
    return candidates + elements


@written_by(
    "forces/contact.py",
    event="events/marks.py",
    gap_error="ode/control.py",
    **dict.fromkeys(("damping", "depth_scale", "kink_crossed", "kink_margin"), "forces/contact_force.py"),
)
def touch_dtype(candidates: int) -> np.dtype:
    """The data of each candidate; values that are latched, fixed at onset, hold until a new latch of v₀."""
    return record(
        ("listings", INTEGER),  # how often the active contacts were packed
        ("active_count", INTEGER),
        ("compliant_count", INTEGER),  # of them, with a force law: these come first
        ("stop_count", INTEGER),  # of them, stops
        ("active_index", INTEGER, (candidates,)),  # the candidates in contact, packed
        ("active", INTEGER, (candidates,)),  # 1: in contact
        ("event", INTEGER, (candidates,)),  # at `step.end` and not yet applied, see kernel/events/marks.py
        ("onset", REAL, (candidates,)),  # s
        ("onset_speed", REAL, (candidates,)),  # m/s, normal approach speed at onset
        ("impact_speed", REAL, (candidates,)),  # m/s, v0 of the force law
        ("effective_mass", REAL, (candidates,)),  # kg, 1/(J M⁻¹ Jᵀ) at onset
        ("depth_scale", REAL, (candidates,)),  # m, expected penetration
        ("damping", REAL, (candidates,)),  # N·s/m^(p+1), d of the force law
        ("speed", REAL, (candidates,)),  # m/s, δ̇ and …
        ("force_rate", REAL, (candidates,)),  # N/s, dF/dt at the start of the step, to find the peaks
        ("force", REAL, (candidates,)),  # N, of active ones at the last evaluation of the rate
        ("beyond_kink", INTEGER, (candidates,)),  # 1: δ̇ is beyond the kink of its force
        ("kink_margin", REAL, (candidates,)),  # m/s, by which δ̇ may be on the wrong side; else 0
        ("kink_crossed", INTEGER, (candidates,)),  # 1: a stage of the tried step was on its other side
        ("number", INTEGER, (candidates,)),  # of its onset among all onsets, counted from 1
        ("peak_force", REAL, (candidates,)),  # N
        ("max_penetration", REAL, (candidates,)),  # m
        ("joint_top", REAL, (candidates,)),  # N², the largest square of a force in a joint, …
        ("joint", INTEGER, (candidates,)),  # … and the joint, 1…N; 0 for none
        # m, of two error estimates of a tried step, in the clearances of the active contacts, packed
        ("gap_error", REAL, (2, candidates)),
    )


@written_by("events/saturation.py", event="events/marks.py", margin="equations.py")
def drive_dtype(links: int) -> np.dtype:
    """Whether the torques of drives are at their limits, see kernel/chain/joints.py."""
    return record(
        ("mode", INTEGER, (links,)),  # ±1: the torque is ± the limit, 0: it is below
        ("chosen", INTEGER, (links,)),  # of a tangent instance: the modes of the primal one
        ("event", INTEGER),  # 1: the last step ends where a mode does
        ("margin", REAL),  # N·m, the least of the tried step by which a torque is from such an end, or 0
    )


@written_by("forces/contact.py")
def impact_dtype() -> np.dtype:
    """The impacts so far."""
    return record(
        ("count", INTEGER),  # onsets since the start
        ("last_time", REAL),  # s
        ("last_point", INTEGER),  # 0…N, −1 before the first impact
        ("last_wall", INTEGER),  # 1 + index into the scene's wall_names, 0 before the first impact
        ("last_speed", REAL),  # m/s
    )


@written_by("events/contact_log.py")
def latest_dtype() -> np.dtype:
    """The latest impacts, the newest first, as they were when the outputs were last filled."""
    return record(
        ("kept", INTEGER),  # the number of them that is requested
        ("point", INTEGER, (LATEST,)),  # 0…N, −1 for none
        ("wall", INTEGER, (LATEST,)),  # 1 + index into the scene's wall_names, 0 for none
        ("time", REAL, (LATEST,)),  # s
        ("speed", REAL, (LATEST,)),  # m/s
        ("end", REAL, (LATEST,)),  # s, the present time while the contact lasts
        ("separation_speed", REAL, (LATEST,)),  # m/s
        ("peak_force", REAL, (LATEST,)),  # N
        ("max_penetration", REAL, (LATEST,)),  # m
        ("impulse", REAL, (LATEST,)),  # N·s
    )


@written_by(
    "rows/constraints.py",
    start="forces/holding.py",
    resistance="forces/holding.py",
    least_force="forces/holding.py",
    sample="events/contact_log.py",
)
def rigid_dtype(links: int, candidates: int, elements: int) -> np.dtype:
    """The constraints: the active contacts, packed, and after them what sticks by dry friction.

    Contacts with a force law are not in the active set.
    """
    rows = constraint_count(candidates, elements)
    return record(
        # m, m/s or m/s², rad …: the change of the coordinates by the impulses
        ("change", REAL, (coordinate_count(links),)),
        ("unsolved", INTEGER),  # since a step or a try of it began, see kernel/rows/constraints.py
        ("in_active_set", INTEGER, (rows,)),  # 1: its impulse may differ from 0
        ("violated", INTEGER, (rows,)),  # 1: its impulse or residual has the wrong sign
        ("start", REAL, (rows,)),  # normal or tangential motion without impulses, m, m/s or m/s², …
        ("reached", REAL, (rows,)),  # … with them, …
        ("target", REAL, (rows,)),  # … its least required value, …
        ("residual", REAL, (rows,)),  # … the missing part, later times the impedance
        ("impulse", REAL, (rows,)),  # N·s, or N
        ("impedance", REAL, (rows,)),  # kg, D
        ("resistance", REAL, (rows,)),  # kg, of the contacts with a force law to a projection; else 0
        ("sample", REAL, (2, candidates)),  # N, the last two sampled forces
        ("least_force", REAL, (candidates,)),  # N, smallest force in the stages of the step; not packed
    )


@written_by("rows/limits.py")
def share_dtype(links: int, elements: int) -> np.dtype:
    """The iteration to forces within the limits of friction, for the rows of `rigid`."""
    rows = 2 * elements  # no fewer than `rigid` has, and none without friction
    return record(
        ("change", REAL, (coordinate_count(links),)),  # of the coordinates' rates, m/s² or rad/s²
        ("inside", INTEGER, (rows,)),  # 1: its force is inside its limits, 0: it is one of them
        ("at_limit", INTEGER, (elements,)),  # ±1: the sign of a force at its limit, of what sticks, packed
        ("impulse", REAL, (rows,)),  # N, its force p⁺
        ("center", REAL, (rows,)),  # N, its force p before the iteration
        ("residual", REAL, (rows,)),  # m/s², the missing part of its motion with p
        ("wanted", REAL, (rows,)),  # N, p + D m⁺
        ("impedance", REAL, (rows,)),  # kg, D inside the limits, else 0
        ("push", REAL, (rows,)),  # N, D m inside the limits, else the change of p
    )


@written_by("events/contact_log.py")
def finished_dtype(candidates: int) -> np.dtype:
    """The contacts, a ring of rows: those that have ended, and behind them those that last.

    A caller that collects those that have ended sets ``collected`` to ``count``. The latest LATEST impacts
    are there: behind one of them are no more than the others, and one of each other candidate.
    """
    log = LOG_SIZE + candidates
    return record(
        ("count", INTEGER),  # contacts ended since the start
        ("collected", INTEGER),  # of these, when they were last collected
        ("point", INTEGER, (log,)),
        ("wall", INTEGER, (log,)),
        ("onset", REAL, (log,)),  # s
        ("end", REAL, (log,)),  # s, NaN while the contact lasts
        ("impact_speed", REAL, (log,)),  # m/s, approach speed at onset
        ("separation_speed", REAL, (log,)),  # m/s, NaN while it lasts
        ("peak_force", REAL, (log,)),  # N
        ("max_penetration", REAL, (log,)),  # m
        ("effective_mass", REAL, (log,)),  # kg
        ("impulse", REAL, (log,)),  # N·s
        ("joint_force", REAL, (log,)),  # N, the largest in a joint, …
        ("joint", INTEGER, (log,)),  # … and the joint, 1…N; 0 for none
        ("number", INTEGER, (log,)),  # of its onset, as in `touch`
    )


@written_by("events/contact_log.py")
def peaks_dtype() -> np.dtype:
    """The largest of all contacts that were logged since the start."""
    return record(
        ("force", REAL),  # N, of a wall on a point
        ("penetration", REAL),  # m
        ("moment", REAL),  # N·m, of a stop on a joint
        ("rotation", REAL),  # rad, of a joint beyond its stop
    )


@written_by("ode/dense.py", onset="forces/contact.py")
def quadrature_dtype(candidates: int, elements: int) -> np.dtype:
    """Integrals along the motion, each at its place, as ode/dense.py lists them.

    Those that are integrated are packed.
    """
    places = candidates + elements + 3
    return record(
        ("wanted", INTEGER),  # 1: they are integrated
        ("onset", REAL, (candidates,)),  # N·s, the impulse at the onset of the contact
        ("total", REAL, (places,)),  # since the start, when contacts last began or ended, …
        ("rate", REAL, (places,)),  # … and their rates then
        ("count", INTEGER),
        ("index", INTEGER, (places,)),  # the places of those that are integrated, packed
        ("state", REAL, (places,)),  # at the start of the last step …
        ("state_end", REAL, (places,)),  # … and at its end, …
        ("rate_end", REAL, (places,)),  # … with their rates there
        ("tried", REAL, (places,)),  # at the end of the tried step
        ("dense", REAL, (DENSE_COEFFICIENTS, places)),  # the interpolant of the last step
        ("stage", REAL, (STAGES, places)),  # dq/ds at the stages
    )


@written_by("forces/friction.py")
def friction_dtype() -> np.dtype:
    """Which elements, candidates and joints, have dry friction now."""
    return record(
        ("used", INTEGER),  # 1: some contact or joint has dry friction
        ("count", INTEGER),  # elements with friction now: active contacts first, then joints
        ("contact_count", INTEGER),  # of them, contacts
        ("stuck_count", INTEGER),  # of them, those that stick, …
        ("stuck_joints", INTEGER),  # … and of these the joints
        ("power", REAL),  # W, dissipated by dry friction at the last evaluation
    )


@written_by(
    "forces/friction.py",
    event="events/marks.py",
    **dict.fromkeys(("before", "slack", "undecided"), "events/friction_modes.py"),
)
def element_dtype(elements: int) -> np.dtype:
    """The data of each element: the candidates, and after them the joints 1…N."""
    return record(
        ("index", INTEGER, (elements,)),  # the elements with friction, packed
        ("stuck", INTEGER, (elements,)),  # those that stick, packed
        ("mode", INTEGER, (elements,)),  # 0: sticks, ±1: slides along ±t; 2: no friction now
        ("event", INTEGER, (elements,)),  # at `step.end` and not yet applied, see kernel/events/marks.py
        ("before", INTEGER, (elements,)),  # its mode before the last choice
        ("chosen", INTEGER, (elements,)),  # its mode in the primal run, for a tangent instance
        # 1: its mode is chosen by the forces; 2: see kernel/tangent/friction.py
        ("undecided", INTEGER, (elements,)),
        ("slack", REAL, (elements,)),  # m/s, by which sliding may be backward when its mode begins
        ("anchor", REAL, (elements,)),  # m, the tangential coordinate at which it sticks
        ("force", REAL, (elements,)),  # N along t, at the last evaluation of the rate
        # N, the largest static friction, at the last evaluation; of a joint constant
        ("limit", REAL, (elements,)),
        # m/s of sliding, N of sticking: how far its mode was from ending in the stages of the tried step
        ("margin", REAL, (elements,)),
    )


@written_by("events/friction_modes.py")
def changes_dtype(elements: int) -> np.dtype:
    """The log of changes between sticking and sliding. A caller that collects sets count to 0."""
    log = CHANGES_OF_EACH * elements
    return record(
        ("count", INTEGER),
        ("time", REAL, (log,)),  # s
        ("point", INTEGER, (log,)),  # or the joint
        ("wall", INTEGER, (log,)),  # index into the scene's wall_names, −1: dry friction in a joint
        ("mode", INTEGER, (log,)),  # as `element.mode`, from this time on
    )

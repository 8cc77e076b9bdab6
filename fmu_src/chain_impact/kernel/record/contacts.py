"""The parts of the record with the data of contacts."""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count
from chain_impact.kernel.ode.dense import DENSE_COEFFICIENTS
from chain_impact.kernel.ode.explicit import STAGES
from chain_impact.kernel.record.fields import INTEGER, REAL, record, written_by

CHANGES_OF_EACH = 4  # changes of a mode that are stored until they are collected, for each element
# finished contacts that are stored until they are collected, in addition to one for each candidate
LOG_SIZE = 32
LATEST = LOG_SIZE  # largest number of latest impacts that are listed


def constraint_count(candidates: int, elements: int) -> int:
    """Return the largest number of constraints at one moment."""
    return candidates + elements


@written_by(
    "forces/contact.py",
    event="events/marks.py",
    gap_error="ode/control.py",
    **dict.fromkeys(("damping", "depth_scale", "kink_crossed", "kink_margin"), "forces/contact_force.py"),
)
def touch_dtype(candidates: int) -> np.dtype:
    """Return the layout of each candidate's data.

    Latched values, fixed at onset, hold until v₀ is latched again.
    """
    return record(
        ("listings", INTEGER),  # number of times that the active contacts were packed
        ("active_count", INTEGER),
        ("compliant_count", INTEGER),  # number of active contacts with a force law, which come first
        ("stop_count", INTEGER),  # number of active stops
        ("active_index", INTEGER, (candidates,)),  # the candidates in contact, packed
        ("active", INTEGER, (candidates,)),  # 1: in contact
        # the event at `step.end` that is not yet applied, see kernel/events/marks.py
        ("event", INTEGER, (candidates,)),
        ("onset", REAL, (candidates,)),  # s
        ("onset_speed", REAL, (candidates,)),  # m/s, normal approach speed at onset
        ("impact_speed", REAL, (candidates,)),  # m/s, v0 of the force law
        ("effective_mass", REAL, (candidates,)),  # kg, 1/(J M⁻¹ Jᵀ) at onset
        ("depth_scale", REAL, (candidates,)),  # m, expected penetration
        ("damping", REAL, (candidates,)),  # N·s/m^(p+1), d of the force law
        ("speed", REAL, (candidates,)),  # m/s, δ̇ at the start of the step, to find the peaks
        ("force_rate", REAL, (candidates,)),  # N/s, dF/dt at the start of the step, to find the peaks
        ("force", REAL, (candidates,)),  # N, of active candidates at the last evaluation of the rate
        ("beyond_kink", INTEGER, (candidates,)),  # 1: the candidate is beyond the kink of its force
        ("kink_margin", REAL, (candidates,)),  # m/s, by which δ̇ may be on the wrong side; else 0
        # 1: a stage of the tried step was on the other side of the kink
        ("kink_crossed", INTEGER, (candidates,)),
        ("number", INTEGER, (candidates,)),  # number of the onset among all onsets, counted from 1
        ("peak_force", REAL, (candidates,)),  # N
        ("max_penetration", REAL, (candidates,)),  # m
        ("joint_top", REAL, (candidates,)),  # N², the largest square of a force in a joint …
        ("joint", INTEGER, (candidates,)),  # … and the joint, 1…N; 0 for none
        # m, two error estimates of a tried step in the clearances of the active contacts, packed
        ("gap_error", REAL, (2, candidates)),
    )


@written_by("events/saturation.py", event="events/marks.py", margin="equations.py")
def drive_dtype(links: int) -> np.dtype:
    """Return the layout of the data on drives at their limits, see kernel/chain/joints.py."""
    return record(
        ("mode", INTEGER, (links,)),  # ±1: the torque is ± the limit, 0: it is below
        ("chosen", INTEGER, (links,)),  # in a tangent instance: the modes of the primal instance
        ("event", INTEGER),  # 1: the last step ends where a mode ends
        # N·m, the least distance of a torque from the end of its mode in the tried step, or 0
        ("margin", REAL),
    )


@written_by("forces/contact.py")
def impact_dtype() -> np.dtype:
    """Return the layout of the impacts so far."""
    return record(
        ("count", INTEGER),  # onsets since the start
        ("last_time", REAL),  # s
        ("last_point", INTEGER),  # 0…N, −1 before the first impact
        ("last_wall", INTEGER),  # 1 + index into the scene's wall_names, 0 before the first impact
        ("last_speed", REAL),  # m/s
    )


@written_by("events/contact_log.py")
def latest_dtype() -> np.dtype:
    """Return the layout of the latest impacts, the newest first, as at the last filling of the outputs."""
    return record(
        ("kept", INTEGER),  # the number of impacts that is requested
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
    """Return the layout of the constraints: the active contacts, packed, and then the sticking elements.

    Contacts with a force law are not in the active set.
    """
    rows = constraint_count(candidates, elements)
    return record(
        # m, m/s or m/s², rad …: the change of the coordinates by the impulses
        ("change", REAL, (coordinate_count(links),)),
        ("unsolved", INTEGER),  # result since a step or its try began, see kernel/rows/constraints.py
        ("in_active_set", INTEGER, (rows,)),  # 1: the impulse may differ from 0
        ("violated", INTEGER, (rows,)),  # 1: the impulse or residual has the wrong sign
        ("start", REAL, (rows,)),  # normal or tangential motion without impulses, m, m/s or m/s², …
        ("reached", REAL, (rows,)),  # … with impulses, …
        ("target", REAL, (rows,)),  # … the least required motion, …
        ("residual", REAL, (rows,)),  # … the missing part, later times the impedance
        ("impulse", REAL, (rows,)),  # N·s, or N
        ("impedance", REAL, (rows,)),  # kg, D
        # kg, resistance of the contacts with a force law to a projection; else 0
        ("resistance", REAL, (rows,)),
        ("sample", REAL, (2, candidates)),  # N, the last two sampled forces
        ("least_force", REAL, (candidates,)),  # N, smallest force in the stages of the step; not packed
    )


@written_by("rows/limits.py")
def share_dtype(links: int, elements: int) -> np.dtype:
    """Return the layout of the iteration to forces within the limits of friction, for the rows of `rigid`."""
    rows = 2 * elements  # no fewer than `rigid` has, and none without friction
    return record(
        ("change", REAL, (coordinate_count(links),)),  # change of the coordinates' rates, m/s² or rad/s²
        ("inside", INTEGER, (rows,)),  # 1: the force is inside its limits, 0: it is at one of them
        ("at_limit", INTEGER, (elements,)),  # ±1: the sign of a sticking element's force at its limit, packed
        ("impulse", REAL, (rows,)),  # N, the force p⁺
        ("center", REAL, (rows,)),  # N, the force p before the iteration
        ("residual", REAL, (rows,)),  # m/s², the missing part of the motion with p
        ("wanted", REAL, (rows,)),  # N, p + D m⁺
        ("impedance", REAL, (rows,)),  # kg, D inside the limits, else 0
        ("push", REAL, (rows,)),  # N, D m inside the limits, else the change of p
    )


@written_by("events/contact_log.py")
def finished_dtype(candidates: int) -> np.dtype:
    """Return the layout of the contacts, a ring of rows: first the ended ones, then the active ones.

    A caller that collects the ended contacts sets ``collected`` to ``count``. The latest LATEST impacts are
    always there: after one of them come no more than the others, and one contact of each other candidate.
    """
    log = LOG_SIZE + candidates
    return record(
        ("count", INTEGER),  # contacts ended since the start
        ("collected", INTEGER),  # number of ended contacts when they were last collected
        ("point", INTEGER, (log,)),
        ("wall", INTEGER, (log,)),
        ("onset", REAL, (log,)),  # s
        ("end", REAL, (log,)),  # s, NaN while the contact lasts
        ("impact_speed", REAL, (log,)),  # m/s, approach speed at onset
        ("separation_speed", REAL, (log,)),  # m/s, NaN while the contact lasts
        ("peak_force", REAL, (log,)),  # N
        ("max_penetration", REAL, (log,)),  # m
        ("effective_mass", REAL, (log,)),  # kg
        ("impulse", REAL, (log,)),  # N·s
        ("joint_force", REAL, (log,)),  # N, the largest force in a joint …
        ("joint", INTEGER, (log,)),  # … and the joint, 1…N; 0 for none
        ("number", INTEGER, (log,)),  # number of the onset, as in `touch`
    )


@written_by("events/contact_log.py")
def peaks_dtype() -> np.dtype:
    """Return the layout of the largest values of all contacts that were logged since the start."""
    return record(
        ("force", REAL),  # N, of a wall on a point
        ("penetration", REAL),  # m
        ("moment", REAL),  # N·m, of a stop on a joint
        ("rotation", REAL),  # rad, of a joint beyond its stop
    )


@written_by("ode/dense.py", onset="forces/contact.py")
def quadrature_dtype(candidates: int, elements: int) -> np.dtype:
    """Return the layout of integrals along the motion, each at its place in the order of ode/dense.py.

    The integrated ones are packed.
    """
    places = candidates + elements + 3
    return record(
        ("wanted", INTEGER),  # 1: the integrals are computed
        ("onset", REAL, (candidates,)),  # N·s, the impulse at the onset of the contact
        ("total", REAL, (places,)),  # value since the start, when contacts last began or ended, …
        ("rate", REAL, (places,)),  # … and its rate then
        ("count", INTEGER),
        ("index", INTEGER, (places,)),  # the places of the integrated ones, packed
        ("state", REAL, (places,)),  # at the start of the last step …
        ("state_end", REAL, (places,)),  # … and at its end, …
        ("rate_end", REAL, (places,)),  # … with the rate there
        ("tried", REAL, (places,)),  # at the end of the tried step
        ("dense", REAL, (DENSE_COEFFICIENTS, places)),  # the interpolant of the last step
        ("stage", REAL, (STAGES, places)),  # dq/ds at the stages
    )


@written_by("forces/friction.py")
def friction_dtype() -> np.dtype:
    """Return the layout of the data on the elements with dry friction, candidates and joints."""
    return record(
        ("used", INTEGER),  # 1: some contact or joint has dry friction
        ("count", INTEGER),  # elements with friction now: active contacts first, then joints
        ("contact_count", INTEGER),  # number of contacts among them
        ("stuck_count", INTEGER),  # number of sticking elements …
        ("stuck_joints", INTEGER),  # … and of sticking joints among them
        ("power", REAL),  # W, dissipated by dry friction at the last evaluation
    )


@written_by(
    "forces/friction.py",
    event="events/marks.py",
    **dict.fromkeys(("before", "slack", "undecided"), "events/friction_modes.py"),
)
def element_dtype(elements: int) -> np.dtype:
    """Return the layout of each element's data: first the candidates, then the joints 1…N."""
    return record(
        ("index", INTEGER, (elements,)),  # the elements with friction, packed
        ("stuck", INTEGER, (elements,)),  # the sticking elements, packed
        ("mode", INTEGER, (elements,)),  # 0: sticks, ±1: slides along ±t; 2: no friction now
        # the event at `step.end` that is not yet applied, see kernel/events/marks.py
        ("event", INTEGER, (elements,)),
        ("before", INTEGER, (elements,)),  # the mode before the last choice
        ("chosen", INTEGER, (elements,)),  # in a tangent instance: the mode in the primal run
        # 1: the forces choose the mode; 2: see kernel/tangent/friction.py
        ("undecided", INTEGER, (elements,)),
        ("slack", REAL, (elements,)),  # m/s, by which sliding may be backward when its mode begins
        ("anchor", REAL, (elements,)),  # m, the tangential coordinate at which the element sticks
        ("force", REAL, (elements,)),  # N along t, at the last evaluation of the rate
        # N, the largest static friction, at the last evaluation; constant for a joint
        ("limit", REAL, (elements,)),
        # m/s for sliding, N for sticking: how far the mode was from its end in the stages of the tried step
        ("margin", REAL, (elements,)),
    )


@written_by("events/friction_modes.py")
def changes_dtype(elements: int) -> np.dtype:
    """Return the layout of the log of changes between sticking and sliding.

    A caller that collects the changes sets ``count`` to 0.
    """
    log = CHANGES_OF_EACH * elements
    return record(
        ("count", INTEGER),
        ("time", REAL, (log,)),  # s
        ("point", INTEGER, (log,)),  # or the joint
        ("wall", INTEGER, (log,)),  # index into the scene's wall_names, −1: dry friction in a joint
        ("mode", INTEGER, (log,)),  # as `element.mode`, from this time on
    )

"""The parts of the record with the data of contacts."""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count
from chain_impact.kernel.events.marks import NEIGHBOUR
from chain_impact.kernel.forces.friction import NO_FRICTION
from chain_impact.kernel.ode.dense import DENSE_COEFFICIENTS
from chain_impact.kernel.ode.explicit import STAGES
from chain_impact.kernel.record.fields import INTEGER, REAL, bounded, record, table, written_by

# number of changes of modes, for each element on average, that the log can store until they are collected
CHANGES_OF_EACH = 4
# number of finished contacts at which the run waits until they are collected; the log has one more row for
# each candidate, because all contacts may end in one step
LOG_SIZE = 32
LATEST = LOG_SIZE  # length of the list of the latest impacts; a scene may request fewer


@written_by("rows/geometry.py", offset=("rows/geometry.py", "chain/motion.py"))
def candidate_dtype(candidates: int) -> np.dtype:
    """Return the layout of the candidates: pairs of a point and a wall, stops of joints and of the slider."""
    return table(
        candidates,
        # number of the point, 0…N; N+1…N+P for sites; for a stop in a joint the number of the joint, 1…N; 0
        # for a stop of the slider
        ("point", INTEGER),
        # index in the scene's wall_names: of the box in WALLS (rows/geometry.py), 4 plus the index in
        # `walls`, or of the kind of stop after all walls
        ("wall", INTEGER),
        ("stop", INTEGER),  # which stop: AT_WALL or a value of STOP_CODES (rows/geometry.py)
        # ---- derived at initialization
        # index of the place: ``point``, but N + ``point`` for a stop of a joint and for a site
        ("place", INTEGER),
        ("radius", REAL),  # m, radius of the point
        ("normal_x", REAL),  # x of the inward normal n of the wall
        ("normal_y", REAL),
        ("offset", REAL),  # m, offset of the wall: n·p for the points p on the wall
    )


@written_by("forces/candidate_laws.py")
def law_dtype(candidates: int) -> np.dtype:
    """Return the layout of the contact law of each candidate.

    A stop in a joint has the law of a wall for the joint's place, at a lever arm (rows/geometry.py).
    """
    return table(
        candidates,
        ("same_as", INTEGER),  # the first candidate with the same law
        ("number", INTEGER),  # number of the law, from 1; 0: not set yet
        ("stiffness", REAL),  # N/m^exponent
        ("exponent", REAL),
        ("restitution", REAL),
        ("minimum_impact_speed", REAL),  # m/s
        ("friction", REAL),  # coefficient of sliding friction
        # coefficient of static friction, not less than the coefficient of sliding friction
        ("static_friction", REAL),
        # ---- derived from the parameters
        # factor f(e) of the damping, which is λ in the Hunt–Crossley family (forces/laws.py)
        ("damping_factor", REAL),
        ("rate_exponent", REAL),  # exponent p of the penetration in the damping d δᵖ δ̇
        ("approach_only", INTEGER),  # 1: damped during compression only
        ("impulsive", INTEGER),  # 1: the wall is rigid, with impulses instead of a force law
        ("harmless_depth", REAL),  # m, depth in the wall up to which a point counts as apart
    )


def most_constraints(candidates: int, elements: int) -> int:
    """Return the largest number of constraints that can be active at one moment."""
    return candidates + elements


@written_by(
    "forces/active_contacts.py",
    event="events/marks.py",
    gap_error="ode/control.py",
    **dict.fromkeys(("damping", "depth_scale", "kink_crossed", "kink_margin"), "forces/force_formula.py"),
)
def touch_dtype(candidates: int) -> np.dtype:
    """Return the layout of each candidate's data.

    The impact speed, the effective mass and the values that depend on them are latched: they are fixed at the
    onset, and stay until v₀ is latched again or the law changes. At a stop in a joint, lengths and speeds are
    those of its place: angles times a lever arm (rows/geometry.py).
    """
    return record(
        # how often the active contacts have been packed; stages from before the last packing do not predict
        # the stages of the next step
        ("listings", INTEGER),
        ("active_count", bounded(0, candidates)),
        # number of active contacts with a force law; these come first in ``active_index``
        ("compliant_count", INTEGER),
        ("joint_stop_count", INTEGER),  # number of active stops in joints
        # indices of the candidates with active contacts, packed: in the first ``active_count`` entries
        ("active_index", bounded(0, candidates - 1), (candidates,)),
        ("active", bounded(0, 1), (candidates,)),  # 1: in contact
        # the event of a candidate at `step.end` that is not applied yet, see kernel/events/marks.py
        ("event", bounded(0, NEIGHBOUR), (candidates,)),
        ("onset", REAL, (candidates,)),  # s, time of the onset
        # m/s, approach speed of the point along the normal at the onset
        ("onset_speed", REAL, (candidates,)),
        # m/s, impact speed v₀ in the law, at least ``minimum_impact_speed``
        ("impact_speed", REAL, (candidates,)),
        ("effective_mass", REAL, (candidates,)),  # kg, effective mass 1/(J M⁻¹ Jᵀ) at the onset
        ("depth_scale", REAL, (candidates,)),  # m, expected penetration; the longest link for a rigid wall
        ("damping", REAL, (candidates,)),  # N·s/m^(p+1), damping d of the force law
        # m/s, rate of the penetration at the start of the step, for the search for peaks
        ("speed", REAL, (candidates,)),
        # N/s, rate of the contact force at the start of the step; the search for peaks uses only its sign
        ("force_rate", REAL, (candidates,)),
        ("force", REAL, (candidates,)),  # N, force of an active candidate at the last evaluation of ẏ
        # side of the kink (forces/force_formula.py) whose force a step continues smoothly: 1 beyond the kink,
        # else 0
        ("beyond_kink", INTEGER, (candidates,)),
        # m/s, how far the rate of the penetration may be on the wrong side of the kink before this counts as
        # a crossing; 0 if the law damps in both directions
        ("kink_margin", REAL, (candidates,)),
        # 1: a stage of the tried step, or its end, was on the other side of the kink
        ("kink_crossed", INTEGER, (candidates,)),
        ("number", INTEGER, (candidates,)),  # number of the onset among all onsets, counted from 1
        ("peak_force", REAL, (candidates,)),  # N, peak force so far
        ("max_penetration", REAL, (candidates,)),  # m, largest penetration so far
        ("joint_square", REAL, (candidates,)),  # N², largest square of a joint force during the contact
        ("joint", INTEGER, (candidates,)),  # number of the joint with the largest force, 1…N; 0 for none
        # m, errors in the clearances of the active contacts, packed, for each of the two error estimates of a
        # tried step
        ("gap_error", REAL, (2, candidates)),
    )


@written_by("forces/active_contacts.py")
def impact_dtype() -> np.dtype:
    """Return the layout of the counts of impacts and of the data of the latest onset."""
    return record(
        ("count", INTEGER),  # onsets since the start
        ("last_time", REAL),  # s, time of the latest onset; the start of the run before the first one
        # point of the latest onset, as in `candidate.point`; −1 before the first impact
        ("last_point", INTEGER),
        # 1 + index of the wall of the latest onset in the scene's wall_names; 0 before the first impact
        ("last_wall", INTEGER),
        ("last_speed", REAL),  # m/s, impact speed of the latest onset; rad/s at a stop in a joint
    )


@written_by("events/contact_log.py")
def latest_dtype() -> np.dtype:
    """Return the layout of the list of the latest impacts, newest first, written whenever outputs are filled.

    If the wall is a stop in a joint, the values are angles and moments: rad/s, N·m, rad and N·m·s.
    """
    return record(
        ("requested", bounded(0, LATEST)),  # number of latest impacts that the scene requests
        ("listed", INTEGER),  # number of ended contacts when the list was made; −1: a contact was active then
        ("point", INTEGER, (LATEST,)),  # as in `candidate.point`; −1 for no impact
        ("wall", INTEGER, (LATEST,)),  # 1 + index of the wall in the scene's wall_names; 0 for no impact
        ("time", REAL, (LATEST,)),  # s
        ("speed", REAL, (LATEST,)),  # m/s
        ("end", REAL, (LATEST,)),  # s, end of the contact; the present time while the contact lasts
        ("separation_speed", REAL, (LATEST,)),  # m/s
        ("peak_force", REAL, (LATEST,)),  # N
        ("max_penetration", REAL, (LATEST,)),  # m
        ("impulse", REAL, (LATEST,)),  # N·s
    )


@written_by(
    "rows/constraints.py",
    start="forces/holding.py",
    resistance="forces/holding.py",
    refined="ode/folds.py",
    uneven="ode/folds.py",
    least_force="forces/holding.py",
    sample="events/contact_log.py",
)
def constraints_dtype(links: int, candidates: int, elements: int) -> np.dtype:
    """Return the layout of the constraints: the active contacts, then the sticking elements, packed.

    Contacts with a force law have rows, but are never in the active set. The function that states the problem
    decides what ``start``, ``target`` and ``reached`` are:

    - positions [m], with impulses in kg·m: release_contacts, and project_state in its first pass
    - speeds [m/s], with impulses in N·s: apply_impulses, and project_state in its second pass
    - accelerations [m/s²], with forces in N: add_constraint_forces, update_active_set, decide_onsets
    """
    rows = most_constraints(candidates, elements)
    return record(
        # how much the impulses change each coordinate: its position, speed or acceleration, as stated above
        ("change", REAL, (coordinate_count(links),)),
        # SOLVED, or why the search for forces has failed in this step, see kernel/rows/constraints.py
        ("unsolved", INTEGER),
        # 1: the first iteration of the last problem left more than FOLD_RESIDUAL (rows/constraints.py) of the
        # residual at rigid walls
        ("near_fold", INTEGER),
        ("in_active_set", INTEGER, (rows,)),  # 1: the impulse may differ from 0
        ("violated", INTEGER, (rows,)),  # 1: the impulse or residual has the wrong sign
        ("start", REAL, (rows,)),  # motion along the constraint without impulses
        ("reached", REAL, (rows,)),  # motion along the constraint with impulses
        ("target", REAL, (rows,)),  # the least required motion along the constraint
        # target − reached in the active set, else 0; during a correction this times the impedance
        ("residual", REAL, (rows,)),
        ("impulse", REAL, (rows,)),  # impulse or force of the constraint
        ("impedance", REAL, (rows,)),  # kg, impedance D of the constraint
        # kg, impedance with which a contact with a force law resists a projection; else 0
        ("resistance", REAL, (rows,)),
        # N, ``refined``: the force near a fold; ``uneven``: a difference of forces that is small if the force
        # is smooth (kernel/ode/folds.py)
        ("refined", REAL, (rows,)),
        ("uneven", REAL, (rows,)),
        ("sample", REAL, (2, candidates)),  # N, the last two samples of the force of a held candidate, packed
        # N, the least force of a rigid wall in the stages of the step; 0 if it never pulls; not packed
        ("least_force", REAL, (candidates,)),
    )


@written_by("rows/limits.py")
def limited_forces_dtype(links: int, elements: int) -> np.dtype:
    """Return the layout of the search for constraint forces within the limits of friction."""
    # at least the number of rows in `constraints`, as every candidate is an element; 0 without friction
    rows = 2 * elements
    return record(
        # m/s² or rad/s², accelerations of the coordinates by the forces
        ("change", REAL, (coordinate_count(links),)),
        ("inside", INTEGER, (rows,)),  # 1: the force is inside its limits, 0: it is at one of them
        # ±1: a sticking element's force is at its limit and has this sign; 0: it is below the limit; packed
        ("at_limit", INTEGER, (elements,)),
        ("force", REAL, (rows,)),  # N, force p⁺ of each constraint after an iteration of rows/limits.py
        ("center", REAL, (rows,)),  # N, force p of each constraint before the iteration
        ("residual", REAL, (rows,)),  # m/s², the missing part of the required motion with the forces p
        # N, the force p + D m⁺ before it is limited, with the impedance D and the residual m⁺ of the force p⁺
        ("unlimited", REAL, (rows,)),
        ("impedance", REAL, (rows,)),  # kg, the impedance D of a row inside the limits, else 0
        # N, impedance times residual of a row inside the limits, else the change of its force p
        ("correction", REAL, (rows,)),
    )


@written_by("events/contact_log.py")
def contact_log_dtype(candidates: int) -> np.dtype:
    """Return the layout of the log of contacts, a ring buffer: the ended contacts, then the active contacts.

    A caller that collects the ended contacts sets ``collected`` to ``count``. The log always contains the
    latest LATEST impacts: after the entry of such an impact come at most the other ones and, of each other
    candidate, one contact that began earlier. The row of a stop in a joint has angles and moments: rad/s for
    speeds, N·m for ``peak_force``, rad, kg·m² and N·m·s.
    """
    log = LOG_SIZE + candidates
    return record(
        ("count", INTEGER),  # number of contacts that have ended since the start
        # value of ``count`` when the caller most recently collected the ended contacts
        ("collected", INTEGER),
        ("point", INTEGER, (log,)),  # as in `candidate.point`
        ("wall", INTEGER, (log,)),  # as in `candidate.wall`
        ("onset", REAL, (log,)),  # s, time of the onset
        # s, end of the contact; of an active contact NaN or, after `latest` was written, the present time
        ("end", REAL, (log,)),
        ("impact_speed", REAL, (log,)),  # m/s, approach speed at the onset, `touch.onset_speed`
        ("separation_speed", REAL, (log,)),  # m/s, rate of the clearance at ``end``; NaN if ``end`` is NaN
        ("peak_force", REAL, (log,)),  # N, peak force
        ("max_penetration", REAL, (log,)),  # m, largest penetration
        ("effective_mass", REAL, (log,)),  # kg, effective mass at the onset
        ("impulse", REAL, (log,)),  # N·s, impulse of the wall on the point
        ("joint_force", REAL, (log,)),  # N, largest force in a joint during the contact
        ("joint", INTEGER, (log,)),  # number of the joint with the largest force, 1…N; 0 for none
        ("number", INTEGER, (log,)),  # number of the onset, as in `touch`
    )


@written_by("events/contact_log.py")
def peaks_dtype() -> np.dtype:
    """Return the layout of the largest values in the whole run, over all contacts that were ever logged."""
    return record(
        ("force", REAL),  # N, largest force of a wall on a point, or of a stop of the slider
        ("penetration", REAL),  # m, largest penetration at a wall or a stop of the slider
        ("moment", REAL),  # N·m, largest moment of a stop on a joint
        ("rotation", REAL),  # rad, largest rotation of a joint beyond its stop
    )


@written_by("ode/dense.py", impulse_at_onset="forces/active_contacts.py")
def quadrature_dtype(candidates: int, elements: int) -> np.dtype:
    """Return the layout of the quadratures: integrals along the motion, in the order of ode/dense.py.

    ``total`` and ``rate`` have an entry for each quadrature. In the fields after these, the quadratures that
    are integrated in a step are packed.
    """
    count = candidates + elements + 3
    return record(
        ("computed", INTEGER),  # 1: quadratures are integrated; 0: none, because no output needs them
        ("impulse_at_onset", REAL, (candidates,)),  # N·s, value of ``total`` at the onset of the contact
        # integral from the start of the run to the most recent event or re-initialization
        ("total", REAL, (count,)),
        # rate of each quadrature at this time; 0 if it was not integrated
        ("rate", REAL, (count,)),
        ("count", bounded(0, count)),
        # indices in ``total`` of the quadratures that are integrated, packed
        ("index", bounded(0, count - 1), (count,)),
        ("state", REAL, (count,)),  # values at the start of the last step
        ("state_end", REAL, (count,)),  # values at the end of the last step
        ("rate_end", REAL, (count,)),  # rates at the end of the last step
        ("tried", REAL, (count,)),  # values at the end of the tried step
        ("dense", REAL, (DENSE_COEFFICIENTS, count)),  # coefficients of the dense output of the last step
        ("stage", REAL, (STAGES, count)),  # rates dq/ds at the stages, in the step's variable s
    )


@written_by("forces/friction.py")
def friction_dtype(elements: int) -> np.dtype:
    """Return the layout of the data of dry friction in the whole scene; `element` has each element's data."""
    return record(
        ("used", INTEGER),  # 1: some wall, joint or slider has dry friction
        # number of elements with friction now: active contacts, then joints, then the slider
        ("count", bounded(0, elements)),
        ("contact_count", INTEGER),  # number of contacts among the elements with friction now
        ("stuck_count", INTEGER),  # number of sticking elements
        ("stuck_joints", INTEGER),  # number of joints, and the slider, among the sticking elements
        ("power", REAL),  # W, power that dry friction dissipates, at the last evaluation of ẏ
    )


@written_by(
    "forces/friction.py",
    event="events/marks.py",
    **dict.fromkeys(("before", "slack", "undecided"), "events/friction_modes.py"),
)
def element_dtype(elements: int) -> np.dtype:
    """Return the layout of each element's data: the candidates, then the joints 1…N, then the slider."""
    return record(
        ("index", bounded(0, elements - 1), (elements,)),  # indices of the elements with friction now, packed
        ("stuck", bounded(0, elements - 1), (elements,)),  # indices of the sticking elements, packed
        ("mode", bounded(-1, NO_FRICTION), (elements,)),  # 0: sticks; ±1: slides along ±t; 2: no friction now
        # the event of an element at `step.end` that is not applied yet, see kernel/events/marks.py
        ("event", INTEGER, (elements,)),
        ("before", INTEGER, (elements,)),  # the mode of an element before the last choice of modes
        ("chosen", INTEGER, (elements,)),  # in a tangent instance: the mode of an element in the primal run
        # 0: the motion has determined the mode; 1: the forces have; 2: STOPPED of kernel/tangent/friction.py
        ("undecided", INTEGER, (elements,)),
        # m/s, largest speed at which an element may move against its direction of sliding because of errors
        ("slack", REAL, (elements,)),
        ("anchor", REAL, (elements,)),  # m, the coordinate along t at which an element sticks
        ("force", REAL, (elements,)),  # N, friction force along t at the last evaluation of ẏ
        # N, the largest static friction at the last evaluation of ẏ; constant for a joint and the slider
        ("limit", REAL, (elements,)),
        # least margin to the end of the mode in the stages of the tried step, 0 if no stage is beyond the
        # end: m/s, speed in the direction of sliding; N, limit less size of the force of a sticking element
        ("margin", REAL, (elements,)),
    )


@written_by("events/friction_modes.py")
def changes_dtype(elements: int) -> np.dtype:
    """Return the layout of the log of changes of modes; friction that begins or ends is a change, too.

    A caller that collects the changes sets ``count`` to 0.
    """
    log = CHANGES_OF_EACH * elements
    return record(
        ("count", INTEGER),
        ("time", REAL, (log,)),  # s, time of the change
        ("point", INTEGER, (log,)),  # number of the point or joint; 0 for the slider
        # index of the wall in the scene's wall_names; −1: dry friction in a joint or of the slider
        ("wall", INTEGER, (log,)),
        ("mode", INTEGER, (log,)),  # mode from this time on, as in `element.mode`
    )

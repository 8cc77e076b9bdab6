"""The parts of the record with the data of contacts."""

import numpy as np

from chain_impact.kernel.record.constants import DENSE_COEFFICIENTS, NEIGHBOUR, STAGE_COUNT
from chain_impact.kernel.record.fields import INTEGER, REAL, bounded_integer, layout, table, written_by
from chain_impact.kernel.record.state import coordinate_count

# Number of ended contacts, not yet collected, in a full log. ``trajectory`` then returns, so that its caller
# can collect them, and ``run_each`` discards them; in other functions new entries overwrite the oldest. The
# log has one more row for each candidate, because all contacts may end in one step.
LOG_SIZE = 32
LATEST_COUNT = LOG_SIZE  # length of the list of the latest impacts; a scene requests this number or fewer


@written_by("constraints/geometry.py", offset=("constraints/geometry.py", "chain/prescribed_motion.py"))
def candidate_dtype(candidate_count: int) -> np.dtype:
    """Return the layout of the candidates: pairs of a point and a wall, stops of joints and of the slider."""
    return table(
        candidate_count,
        # number of the point, 0…N, or N+1…N+P for sites; at a stop in a joint the number of the joint, 1…N;
        # at a stop of the slider 0
        ("point", INTEGER),
        # index of the wall in the scene's wall_names: a wall of the box has its index in WALLS
        # (constraints/geometry.py), another wall 4 plus its index in `walls`; the kinds of stops follow all
        # walls
        ("wall", INTEGER),
        # kind of the stop: AT_WALL for a wall, or a value of STOP_CODES (constraints/geometry.py)
        ("stop", INTEGER),
        # ---- derived at initialization
        # index of the place: ``point``, but N + ``point`` for a stop of a joint and for a site
        ("place", INTEGER),
        ("radius", REAL),  # m, radius of the point: the distance from the wall at which the clearance is 0
        ("normal_x", REAL),  # x of the unit normal n of the wall, toward the free side
        ("normal_y", REAL),
        ("offset", REAL),  # m, present offset of the wall: n·p of the points p on the wall
    )


@written_by("forces/candidate_laws.py")
def law_dtype(candidate_count: int) -> np.dtype:
    """Return the layout of the contact law of each candidate.

    A stop in a joint has the law of a wall for the joint's place, at a lever arm (constraints/geometry.py).
    """
    return table(
        candidate_count,
        ("same_as", INTEGER),  # index of the first candidate with the same law, which can be this one
        ("number", INTEGER),  # number of the law, from 1; 0: no law has been set
        ("stiffness", REAL),  # N/m^exponent, stiffness K
        ("exponent", REAL),  # exponent n of the elastic force K δⁿ
        ("restitution", REAL),  # prescribed restitution e
        ("minimum_impact_speed", REAL),  # m/s, least impact speed v₀ in the law
        ("friction", REAL),  # coefficient of sliding friction
        # coefficient of static friction, not less than the coefficient of sliding friction
        ("static_friction", REAL),
        # ---- derived from the parameters
        # factor f(e) of the damping, which is λ in the Hunt–Crossley family (forces/laws.py)
        ("damping_factor", REAL),
        ("rate_exponent", REAL),  # exponent p of the penetration δ in the damping force d δᵖ δ̇
        ("approach_only", INTEGER),  # 1: the law damps only while δ grows; 0: in both directions
        ("rigid", INTEGER),  # 1: the wall or stop is rigid, and acts by impulses; 0: it has a force law
        # m, depth in the wall up to which a point counts as not touching; 0 at a rigid wall
        ("harmless_depth", REAL),
    )


def most_constraints(candidate_count: int, friction_element_count: int) -> int:
    """Return the largest number of constraints: one for each candidate and one for each element."""
    return candidate_count + friction_element_count


@written_by(
    "forces/active_contacts.py",
    event="events/marks.py",
    clearance_error="ode/step_errors.py",
    **dict.fromkeys(
        ("damping", "expected_penetration", "kink_crossed", "kink_margin"), "forces/force_formula.py"
    ),
)
def contacts_dtype(candidate_count: int) -> np.dtype:
    """Return the layout of the data of the contacts, one entry for each candidate.

    The speed v₀ of the law and the effective mass are latched at the onset, as are expected penetration and
    damping, which are computed anew if v₀ is raised or the law changes. At a stop in a joint, lengths and
    speeds are angles and their rates times a lever arm, and forces are moments over this lever arm.
    """
    return layout(
        # number of the present set of contacts: ``list_active_contacts`` adds 1. An implicit step with
        # another number may have entries of other contacts, and does not predict the next step
        ("contact_set", INTEGER),
        ("active_count", bounded_integer(0, candidate_count)),
        # number of active contacts with a force law; these come first in ``active_index``
        ("force_law_count", INTEGER),
        ("joint_stop_count", INTEGER),  # number of active stops in joints
        # indices of the candidates with active contacts; only the first ``active_count`` entries are used
        ("active_index", bounded_integer(0, candidate_count - 1), (candidate_count,)),
        ("active", bounded_integer(0, 1), (candidate_count,)),  # 1: the candidate is in contact; 0: it is not
        # the event of a candidate at `step.end`, which the next step applies: a value of record/constants.py,
        # from NO_EVENT to NEIGHBOUR
        ("event", bounded_integer(0, NEIGHBOUR), (candidate_count,)),
        ("onset", REAL, (candidate_count,)),  # s, onset of the candidate's latest contact
        ("impact_speed", REAL, (candidate_count,)),  # m/s, approach speed along the normal at the onset, ≥ 0
        # m/s, speed v₀ in the law: the impact speed, but at least `law.minimum_impact_speed`
        ("latched_speed", REAL, (candidate_count,)),
        ("effective_mass", REAL, (candidate_count,)),  # kg, effective mass 1/(J M⁻¹ Jᵀ) at the onset
        # m, expected penetration δ*; at a rigid wall the length of the longest link
        ("expected_penetration", REAL, (candidate_count,)),
        ("damping", REAL, (candidate_count,)),  # N·s/m^(p+1), damping d of the force law
        # m/s, rate of the penetration at the start of the step that is searched for peaks: a peak lies in the
        # step if the rate falls through 0
        ("penetration_rate", REAL, (candidate_count,)),
        # N/s, rate of the contact force at the start of the step that is searched for peaks; only the sign is
        # used, and after an event the number 1 stands for a force that may rise
        ("force_rate", REAL, (candidate_count,)),
        # N, force of an active candidate along the normal, > 0 for a push, at the last evaluation of ẏ
        ("force", REAL, (candidate_count,)),
        # side of the kink (forces/force_formula.py) whose smooth force a step uses on both sides; 1: the side
        # beyond the kink; 0: the side before the kink
        ("beyond_kink", INTEGER, (candidate_count,)),
        # m/s, a rate of the penetration counts as beyond the kink δ̇ = 0 only if its absolute value exceeds
        # this margin; 0 if the law damps in both directions
        ("kink_margin", REAL, (candidate_count,)),
        # 1: a stage or the end of the tried step lies on the side that ``beyond_kink`` does not name, by more
        # than ``kink_margin``
        ("kink_crossed", INTEGER, (candidate_count,)),
        ("impact_number", INTEGER, (candidate_count,)),  # `impact.count` after the candidate's latest onset
        ("peak_force", REAL, (candidate_count,)),  # N, peak force in the contact so far
        ("max_penetration", REAL, (candidate_count,)),  # m, largest penetration in the contact so far
        # N², largest squared force in any joint during the contact
        ("joint_square", REAL, (candidate_count,)),
        ("joint", INTEGER, (candidate_count,)),  # number of the joint with ``joint_square``, 1…N; 0 for none
        # m, errors of the clearances of the active contacts, in the order of ``active_index``; row 0 and row
        # 1 belong to the two error estimates of an explicit step
        ("clearance_error", REAL, (2, candidate_count)),
        ("x", REAL, (candidate_count,)),  # m, x of the position at the onset (``touching_position``)
        ("y", REAL, (candidate_count,)),
    )


@written_by("forces/active_contacts.py")
def impact_dtype() -> np.dtype:
    """Return the layout of the counts of impacts and of the data of the latest onset."""
    return layout(
        ("count", INTEGER),  # number of onsets since the start of the run
        ("last_time", REAL),  # s, time of the latest onset; the start of the run before the first one
        # point of the latest onset, as in `candidate.point`; −1 before the first impact
        ("last_point", INTEGER),
        # 1 + index of the latest onset's wall or stop in the scene's wall_names; 0 before the first onset
        ("last_wall", INTEGER),
        ("last_speed", REAL),  # m/s, approach speed at the latest onset; rad/s at a stop in a joint
    )


@written_by("events/contact_log.py")
def latest_dtype() -> np.dtype:
    """Return the layout of the output list of the latest impacts, newest first.

    The values of a stop in a joint belong to angles: rad/s for speeds, N·m for ``peak_force``, rad for
    ``max_penetration`` and N·m·s for ``impulse``.
    """
    return layout(
        # number of latest impacts that the scene requests
        ("requested_count", bounded_integer(0, LATEST_COUNT)),
        # number of ended contacts when the list was last written; −1: a contact was active at this time
        ("listed_count", INTEGER),
        # point of each impact, as in `candidate.point`; −1 for no impact
        ("point", INTEGER, (LATEST_COUNT,)),
        # 1 + index of the wall in the scene's wall_names; 0 for no impact
        ("wall", INTEGER, (LATEST_COUNT,)),
        ("onset", REAL, (LATEST_COUNT,)),  # s, onset of each impact
        ("impact_speed", REAL, (LATEST_COUNT,)),  # m/s, approach speed at the onset of each impact
        # s, end of each contact; the communication point while the contact lasts
        ("end", REAL, (LATEST_COUNT,)),
        ("separation_speed", REAL, (LATEST_COUNT,)),  # m/s, rate of the clearance at ``end``
        ("peak_force", REAL, (LATEST_COUNT,)),  # N, peak force of each contact
        ("max_penetration", REAL, (LATEST_COUNT,)),  # m, largest penetration of each contact
        ("impulse", REAL, (LATEST_COUNT,)),  # N·s, impulse of the wall on the point in each contact
    )


@written_by(
    "constraints/impulses.py",
    is_violated="constraints/complementarity.py",
    unforced_motion="forces/holding.py",
    added_mass="forces/holding.py",
    refined_force="ode/folds.py",
    force_difference="ode/folds.py",
    least_force="forces/holding.py",
    sampled_force="events/contact_log.py",
)
def constraints_dtype(link_count: int, candidate_count: int, friction_element_count: int) -> np.dtype:
    """Return the layout of the constraints: first the active contacts, then the sticking elements.

    Contacts with a force law have entries, but are never in the active set. The unit of ``unforced_motion``,
    ``target_motion`` and ``reached_motion`` depends on the function that sets up the problem:

    - positions [m], with impulses in kg·m: release_contacts, and project_state in its first pass
    - speeds [m/s], with impulses in N·s: find_impulses, project_state (second pass), clear_sticking_speeds
    - accelerations [m/s²], with forces in N: add_constraint_forces, update_active_set, decide_onsets
    """
    count = most_constraints(candidate_count, friction_element_count)
    return layout(
        # change that all impulses together cause: of each coordinate, or of its rate or its acceleration,
        # depending on the problem
        ("change", REAL, (coordinate_count(link_count),)),
        # SOLVED, or the reason why the search for constraint forces has failed in the tried step or at the
        # events before it: OUTCOME_FORCES_NOT_FOUND, MOVING or OUTCOME_NO_ROOM of constraints/impulses.py
        ("outcome", INTEGER),
        # 1: the last problem was near a fold: a rigid wall held a point, and the first iteration left more
        # than FOLD_RESIDUAL (constraints/impulses.py) of the residual
        ("near_fold", INTEGER),
        # 1: the constraint is in the active set, so its impulse may differ from 0; 0: its impulse is 0
        ("in_active_set", INTEGER, (count,)),
        # constraints of rigid walls in ``solve_lcp``: 1 if the impulse of one in the active set is a pull, or
        # if ``reached_motion`` of one outside the set is below ``target_motion``; else 0
        ("is_violated", INTEGER, (count,)),
        ("unforced_motion", REAL, (count,)),  # m, m/s or m/s² along the row, without any impulse
        ("reached_motion", REAL, (count,)),  # as ``unforced_motion``, with the impulses of all constraints
        # required value of ``reached_motion``; in ``solve_lcp`` the least allowed value
        ("target_motion", REAL, (count,)),
        # residual target − reached, in the unit of ``target_motion``, of a constraint in the active set, else
        # 0; during a correction the residual times the impedance
        ("residual", REAL, (count,)),
        # impulse [kg·m or N·s] or force [N] of the constraint along its row, see above; > 0: the wall pushes
        ("impulse", REAL, (count,)),
        ("impedance", REAL, (count,)),  # kg, impedance D of the constraint
        # kg, in ``project_state`` while an element sticks: mass with which a contact with a force law resists
        # (``contact_added_mass``); else 0
        ("added_mass", REAL, (count,)),
        # N, near a fold: force of the constraint, computed from its forces at earlier and later times
        ("refined_force", REAL, (count,)),
        # N, near a fold: sum of the constraint's forces at earlier and later times, with the weights
        # DIFFERENCE_WEIGHTS (ode/folds.py); small if the force is smooth
        ("force_difference", REAL, (count,)),
        # N, force of the rigid wall on each held point at the last two times that the search for peaks has
        # sampled, the earlier time first; the points are in the order of ``contacts.active_index``
        ("sampled_force", REAL, (2, candidate_count)),
        # N, least force of the rigid wall on each held candidate in the stages of a step; 0 if none is < 0
        ("least_force", REAL, (candidate_count,)),
    )


@written_by("constraints/friction_limits.py")
def limited_forces_dtype(link_count: int, friction_element_count: int) -> np.dtype:
    """Return the layout of the scratch memory of constraints/friction_limits.py.

    That module finds, by iterations, constraint forces within the limits of friction.
    """
    # at least the number of constraints, because every candidate is an element; 0 in a scene without friction
    count = 2 * friction_element_count
    return layout(
        # m/s² or rad/s², accelerations of the coordinates that the constraint forces cause
        ("change", REAL, (coordinate_count(link_count),)),
        # 1: the force is between its limits; 0: the force is at a limit
        ("inside_limits", INTEGER, (count,)),
        # ±1: the force of a sticking element is at its limit, with the sign of ``sign_at_limit``; 0: the
        # |force| is below the limit; the elements are in the order of ``friction_element.stuck_index``
        ("at_limit", INTEGER, (friction_element_count,)),
        ("force", REAL, (count,)),  # N, force p⁺ of each constraint after an iteration
        # N, force p of each constraint before the iteration: 0 before the first one, else the force p⁺ of the
        # iteration before
        ("force_before", REAL, (count,)),
        ("residual", REAL, (count,)),  # m/s², required acceleration minus the acceleration with the forces p
        # N, the force p + D m⁺, which may exceed its limits: p is the force before the iteration, D the
        # impedance, and m⁺ the residual after the iteration (constraints/friction_limits.py)
        ("unlimited_force", REAL, (count,)),
        ("impedance", REAL, (count,)),  # kg, the impedance D of a constraint inside the limits, else 0
        # N, impedance times residual of a constraint inside its limits, else the force at the limit minus p
        ("correction", REAL, (count,)),
    )


@written_by("events/contact_log.py")
def contact_log_dtype(candidate_count: int) -> np.dtype:
    """Return the layout of the log of contacts, a ring buffer: the ended contacts, then the active contacts.

    A caller that collects the ended contacts sets ``collected`` to ``count``. The log always contains the
    latest LATEST_COUNT impacts: after the entry of one of these impacts come at most the entries of the other
    ones and, for each other candidate, of one contact that began earlier. The row of a stop in a joint has
    angles and moments: rad/s for speeds, N·m for ``peak_force``, rad for ``max_penetration``, kg·m² for
    ``effective_mass`` and N·m·s for ``impulse``.
    """
    log = LOG_SIZE + candidate_count
    return layout(
        ("count", INTEGER),  # number of contacts that have ended since the start of the run
        # value of ``count`` when the caller last collected ended contacts
        ("collected", INTEGER),
        ("point", INTEGER, (log,)),  # point of the contact, as in `candidate.point`
        ("wall", INTEGER, (log,)),  # index of the wall or kind of stop, as in `candidate.wall`
        ("onset", REAL, (log,)),  # s, time of the contact's onset
        # s, end of the contact; for an active contact NaN, or in ``list_latest`` the communication point
        ("end", REAL, (log,)),
        ("impact_speed", REAL, (log,)),  # m/s, approach speed at the onset, `contacts.impact_speed`
        ("separation_speed", REAL, (log,)),  # m/s, rate of the clearance at ``end``; NaN if ``end`` is NaN
        ("peak_force", REAL, (log,)),  # N, peak force of the contact
        ("max_penetration", REAL, (log,)),  # m, largest penetration of the contact
        ("effective_mass", REAL, (log,)),  # kg, effective mass at the onset of the contact
        ("impulse", REAL, (log,)),  # N·s, impulse of the wall on the point in the contact
        # N, largest force in any joint during the contact; 0 if no transmitted forces are requested
        ("joint_force", REAL, (log,)),
        ("joint", INTEGER, (log,)),  # number of the joint with the largest force, 1…N; 0 for none
        ("x", REAL, (log,)),  # m, x of the position at which the candidate touched at the onset
        ("y", REAL, (log,)),
        ("impact_number", INTEGER, (log,)),  # number of the contact's onset, as in `contacts.impact_number`
    )


@written_by("events/contact_log.py")
def peaks_dtype() -> np.dtype:
    """Return the layout of the largest forces and depths over all contacts logged since the run's start."""
    return layout(
        ("force", REAL),  # N, largest force of a wall on a point, or of a stop of the slider
        ("penetration", REAL),  # m, largest penetration at a wall or a stop of the slider
        ("moment", REAL),  # N·m, largest moment of a stop on a joint
        ("rotation", REAL),  # rad, largest rotation of a joint beyond its stop
    )


@written_by("ode/quadratures.py", impulse_at_onset="forces/active_contacts.py")
def quadrature_dtype(candidate_count: int, friction_element_count: int) -> np.dtype:
    """Return the layout of the quadratures: integrals along the motion, in the order of ode/quadratures.py.

    ``integral`` and ``rate`` have an entry for each quadrature. The fields after ``index`` have entries only
    for the quadratures that steps integrate at present, in the order of ``index``.
    """
    count = candidate_count + friction_element_count + 3
    return layout(
        ("computed", INTEGER),  # 1: steps integrate quadratures; 0: no output needs a quadrature
        # N·s, value of ``integral`` at the onset of the candidate's latest contact
        ("impulse_at_onset", REAL, (candidate_count,)),
        # integral of each quadrature from the run's start to the last ``commit_quadratures`` or impact
        ("integral", REAL, (count,)),
        # rate of each quadrature at the last ``commit_quadratures``; 0 if the quadrature was not integrated
        ("rate", REAL, (count,)),
        ("count", bounded_integer(0, count)),  # number of quadratures that steps integrate at present
        # index in ``integral`` of each quadrature that steps integrate; only the first ``count`` entries are
        # used
        ("index", bounded_integer(0, count - 1), (count,)),
        ("state", REAL, (count,)),  # values of the integrated quadratures at the last step's start
        ("state_end", REAL, (count,)),  # values of the integrated quadratures at the last step's end
        ("rate_end", REAL, (count,)),  # rates of the integrated quadratures at the last step's end
        ("tried_state", REAL, (count,)),  # values of the quadratures at the end of the tried step
        # coefficients of the quadratures' dense output in the last step
        ("dense", REAL, (DENSE_COEFFICIENTS, count)),
        # derivatives dq/ds of the quadratures q by the step's integration variable s, at the stages
        ("stage", REAL, (STAGE_COUNT, count)),
    )

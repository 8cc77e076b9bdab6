"""The parts of the record with the solver's memory: data kept between steps, and scratch memory."""

import numpy as np

from chain_impact.kernel.record.constants import (
    ACCEPTED,
    DENSE_COEFFICIENTS,
    DISTANCE_KNOWN,
    DIVERGED,
    EXPLICIT,
    IMPLICIT,
    NO_CONTACT,
    PAIR_COUNT,
    RADAU_STAGES,
    SLOT_COUNT,
    SOLVER_READER,
    STAGE_COUNT,
)
from chain_impact.kernel.record.fields import (
    COMPLEX,
    INTEGER,
    REAL,
    applied_force_dtype,
    bounded_integer,
    impedance_dtype,
    layout,
    place_count,
    vectors_dtype,
    written_by,
)
from chain_impact.kernel.record.state import coordinate_count, state_length
from chain_impact.kernel.status import LAST_STATUS, OK


@written_by(
    "ode/last_step.py",
    dense=("ode/last_step.py", "ode/explicit.py", "ode/collocation.py"),
    **dict.fromkeys(("next_size", "flight_size"), "ode/step_control.py"),
    **dict.fromkeys(("method", "stiff_count", "switch_after", "other_method_size"), "ode/methods.py"),
)
def step_dtype(link_count: int, candidate_count: int) -> np.dtype:
    """Return the layout of the last accepted step, of its dense output, and of data for the next step."""
    state = state_length(link_count)
    return layout(
        ("communication_point", REAL),  # s, the communication point; between calls it lies in the last step
        ("start", REAL),  # s, time at which the last step starts
        # s, time added to the entry t of y: the start of the last or, after ``choose_variable``, of the next
        # step
        ("time_origin", REAL),
        ("end", REAL),  # s, time of the last step's end or, if the step was cut, of the cut
        # s, time from ``start`` to the event that begins the step: 0; in a tangent instance this 0 has
        # derivatives
        ("start_delay", REAL),
        # size of the whole step in its integration variable: time [s], or the fictitious time [s] of a
        # contact (kernel/ode/sundman.py)
        ("size", REAL),
        ("end_fraction", REAL),  # fraction of ``size`` at which the step ends; 1 if the step is not cut
        ("next_size", REAL),  # proposed size of the next step, in the integration variable of that step
        # value of ``next_size`` before the present contacts with a force law began; this size is proposed
        # again after these contacts have ended
        ("flight_size", REAL),
        ("state", REAL, (state,)),  # state y at `start`
        ("state_end", REAL, (state,)),  # state y at `end`
        # J, what the dissipated energy in y lacks by rounding, at ``start`` and at ``end``
        ("remainder", REAL),
        ("remainder_end", REAL),
        # J, what the dissipated energy in y lacks by rounding at the end of the whole step of ``size``
        ("remainder_whole", REAL),
        # J, what ode/falls.py has added to the dissipated energy up to ``start`` and up to ``end``
        ("energy_added", REAL),
        ("energy_added_end", REAL),
        # coefficients of the dense output, the interpolant of y over the whole step of ``size``
        ("dense", REAL, (DENSE_COEFFICIENTS, state)),
        ("rate_known", INTEGER),  # 1: `scratch.rate_end` is ẏ at ``end``; 0: ẏ at ``end`` is not known
        # for whom the dense output was completed, a reader of record/constants.py; 0: nobody
        ("dense_for", bounded_integer(0, SOLVER_READER)),
        # number of the method of the last step, see record/constants.py
        ("last_method", bounded_integer(EXPLICIT, IMPLICIT)),
        # number of breaks in the sequence of steps since the run's start; data that were derived from a step
        # before the last break, such as clearances, are not valid (ode/last_step.py)
        ("break_count", INTEGER),
        # index of the candidate of the regularized contact, in whose fictitious time the step runs; −1: the
        # integration variable is time
        ("regularized_candidate", bounded_integer(NO_CONTACT, candidate_count - 1)),
        ("method", bounded_integer(EXPLICIT, IMPLICIT)),  # number of the method of the tried or next step
        # s, size of the other method's steps when the method changed; 0: not known
        ("other_method_size", REAL),
        ("stiff_count", INTEGER),  # number of steps in a row that have suggested the other method
        ("switch_after", INTEGER),  # value of ``stiff_count`` at which the method changes
    )


@written_by("ode/step_control.py", state=("ode/collocation.py", "ode/last_step.py"))
def trial_dtype(link_count: int) -> np.dtype:
    """Return the layout of the outcome of the tried step."""
    return layout(
        ("size", REAL),  # size of the tried step in its integration variable: time [s] or fictitious time [s]
        ("state", REAL, (state_length(link_count),)),  # state y at the end of the tried step
        # ACCEPTED, or the reason why the tried step is rejected, such as INACCURATE
        # (kernel/ode/step_control.py)
        ("outcome", bounded_integer(ACCEPTED, DIVERGED)),
        # error of the tried step relative to the tolerance or, if larger, the energy that the step loses,
        # relative to the allowed loss; valid if ``outcome`` is ACCEPTED or INACCURATE
        ("error", REAL),
        # factor on the next size: < 1 after an implicit step, by the cost of its iteration; else 1
        ("cost_factor", REAL),
    )


@written_by("status.py")
def fault_dtype() -> np.dtype:
    """Return the layout of the cause of a fault status."""
    # number of the part of the scene that causes the fault: 1…C for the candidates, then the links, the
    # drives (of the N joints and of a slider) and, for each candidate, the base at this candidate's wall;
    # 0: no part
    return layout(("part", INTEGER))


@written_by("cost.py", status="status.py")
def statistics_dtype() -> np.dtype:
    """Return the layout of the run's status, and of counts of steps and evaluations since its start."""
    return layout(
        ("steps", INTEGER),  # number of accepted steps, explicit and implicit
        ("rejected_steps", INTEGER),  # number of tried steps that were rejected
        # number of evaluations of ẏ that the solver needs; evaluations for outputs do not count
        ("rhs_evaluations", INTEGER),
        ("implicit_steps", INTEGER),  # number of accepted implicit steps
        ("status", bounded_integer(OK, LAST_STATUS)),  # status of the run, see kernel/status.py
    )


@written_by("cost.py")
def budget_dtype() -> np.dtype:
    """Return the layout of the data that limit the number of events and the cost in windows of time."""
    return layout(
        ("event_start", REAL),  # s, start of the window in which events are counted
        ("event_count", INTEGER),  # number of events since ``event_start``
        ("cost_start", REAL),  # s, start of the window in which the cost is limited
        ("cost_at_window", INTEGER),  # cost from the start of the run to ``cost_start``, in evaluations
        # cost from the start of the run to the start of the present communication step, in evaluations;
        # UNLIMITED of cost.py: this step may have any cost
        ("cost_at_communication_step", INTEGER),
        # cost, from the start of the run, of calculations other than evaluations of ẏ (locating points,
        # finding responses to impulses), as a number of evaluations that cost as much
        ("other_cost", INTEGER),
    )


@written_by("ode/balance.py")
def balance_dtype() -> np.dtype:
    """Return the layout of the energy balance (equations.py) and its allowed changes (ode/balance.py)."""
    return layout(
        ("value_end", REAL),  # J, energy balance at the end of the last step
        ("value_start", REAL),  # J, energy balance at the start of the last step
        # value of `step.break_count` when the energy balance was last evaluated at the start of a step
        ("break_count", INTEGER),
        # s, start of the window of time in which the sum of the changes of the balance has a limit
        ("window_start", REAL),
        # J, energy balance at the start of the window, plus the later changes that new parameters cause
        ("window_value", REAL),
        ("allowed_change", REAL),  # J, the largest change allowed to any step in the window so far
        # J, the part of a step's allowed change of the balance that does not depend on the state
        ("least_allowed_change", REAL),
        ("run_start", REAL),  # s, time at which the run started
        # J, energy balance at the start of the run, plus the later changes that new parameters cause
        ("run_value", REAL),
        ("available_energy_start", REAL),  # J, ``available_energy`` before the last step
        # J, the largest energy that motion, springs, walls and heat together can have had at any time up to
        # the end of the last step
        ("available_energy", REAL),
        ("root_reference_energy", REAL),  # √J, √E₁ of ode/energy_scales.py
        ("reference_energy", REAL),  # J, M g (s + Σ L_i) + E₂ of ode/energy_scales.py
        ("weight", REAL),  # N, weight of chain and carriage
    )


def factors_dtype(link_count: int, scalar: type, slots: int) -> np.dtype:
    """Return the layout of the factors of ``slots`` matrices M + Jᵀ D J + K (chain/mass_matrix_solver.py)."""
    return layout(
        # factors of each link, with the inertia H and the coupling h of the link's rotation, and the
        # impedance κ of the link's inner joint: ``gain`` h/(H + κ), ``inverse`` 1/(H + κ), ``coupling`` σ =
        # κ/(H + κ) and ``complement`` 1 − σ = H/(H + κ)
        *(
            (name, scalar, (slots, link_count))
            for name in ("gain_x", "gain_y", "inverse", "coupling", "complement")
        ),
        # 1: joints transmit moments in the slot's matrix; 0: ``coupling`` and ``complement`` have no meaning
        ("coupled", INTEGER, (slots,)),
        # 1/kg, mobility of the joint where the arms meet: xx, xy, yy (``set_middle_mobility``)
        ("middle_mobility", scalar, (slots, 3)),
    )


def elimination_dtype(link_count: int) -> np.dtype:
    """Return the layout of the results of chain/elimination.py.

    For each link these are h/H (``gain_x``, ``gain_y``), 1/H (``inverse``) and h₀/H (``bias``). H is the
    moment of inertia about the link's joint on the side of ``meeting_joint``, h the coupling of the rotation
    about this joint with the joint's acceleration, and h₀ the moment about it without accelerations.
    """
    return layout(
        *((name, REAL, (link_count,)) for name in ("gain_x", "gain_y", "inverse", "bias")),
        # kg, articulated inertia at the joint where the arms of a free chain meet, or at a base on a slider;
        # not set with a pinned base
        *((name, REAL) for name in ("middle_xx", "middle_xy", "middle_yy")),
    )


@written_by(
    state="events/crossing.py",
    rate_start="advance.py",
    y_error="ode/collocation.py",
    applied_force=("forces/active_contacts.py", "constraints/constraint_response.py"),
    place_change="constraints/constraint_response.py",
    impedance="chain/joints.py",
    factors="chain/mass_matrix_solver.py",
    moment="equations.py",
    thrust="equations.py",
    elimination="chain/elimination.py",
    change="ode/friction_work.py",
    curvature="events/crossing.py",
    **dict.fromkeys(("position", "velocity", "acceleration", "located_at_end"), "chain/kinematics.py"),
)
def scratch_dtype(link_count: int, site_count: int) -> np.dtype:
    """Return the layout of the scratch memory; fields are valid only within a step, unless noted."""
    points, state = link_count + 1, state_length(link_count)
    places, applied_forces = (
        vectors_dtype(place_count(link_count, site_count)),
        applied_force_dtype(link_count, site_count),
    )
    impedance = impedance_dtype(link_count, site_count)
    return layout(
        ("stage", REAL, (STAGE_COUNT, state)),  # rates dy/ds at the stages of a step
        ("rate_start", REAL, (state,)),  # ẏ at the start of the step
        # ẏ at the end of the last step, if `step.rate_known` is 1; valid after the step, too
        ("rate_end", REAL, (state,)),
        ("state", REAL, (state,)),  # the state y that is being evaluated
        ("rate", REAL, (state,)),  # the rate ẏ of ``state``, for evaluations that are no stages of a step
        # a state at a time before or after that of ``state``, at which ode/folds.py finds forces near a fold
        ("nearby", REAL, (state,)),
        ("y_error", REAL, (2, state)),  # the two error estimates of a tried step, for each entry of y
        # m, link vectors L_i, from the proximal joint to the far end of each link; entry N is not used
        ("link_vector", vectors_dtype(points)),
        # forces or impulses that act on the chain: N or N·s at places, N·m or N·m·s in joints and on links
        ("applied_force", applied_forces),
        # N·m, sum of the moments on each link in its proximal and distal joint
        ("moment", REAL, (link_count,)),
        ("thrust", REAL),  # N, force of the slider's motor, spring and damper on the carriage
        ("impedance", impedance),  # impedance D of each place [kg], and impedance of each joint [kg·m²]
        # factors of the matrices M + Jᵀ D J + K, see kernel/chain/mass_matrix_solver.py
        ("factors", factors_dtype(link_count, REAL, SLOT_COUNT)),
        # results of the recursion for the accelerations, see kernel/chain/elimination.py
        ("elimination", elimination_dtype(link_count)),
        # m, positions of all places: points, sites and, if `chain.has_joint_places`, joints (with an angle
        # times the longest link as x)
        ("position", places),
        ("velocity", places),  # m/s, velocities of all places
        ("acceleration", places),  # m/s², accelerations of all places
        # 1: ``position``, ``velocity`` and ``acceleration`` are those at the end of the last step, and stay
        # valid after this step; 0: they may belong to another time
        ("located_at_end", INTEGER),
        # changes of all coordinates, of their rates or of their accelerations: the response of the chain
        ("change", REAL, (coordinate_count(link_count),)),
        ("place_change", places),  # motions of all places that changes of the coordinates cause
        # m/s², for each point, a bound on the second derivative of the position relative to the base, by the
        # integration variable of the step: time or fictitious time, both in seconds
        ("curvature", REAL, (points,)),
    )


@written_by(
    "events/event_exclusion.py",
    curvature=("events/crossing.py", "ode/collocation.py"),
    input_rate="events/search.py",
)
def search_dtype(candidate_count: int) -> np.dtype:
    """Return the layout of the search for events; events/event_exclusion.py defines φ."""
    return layout(
        # what is known of the candidates' φ (``phi_end``) at the last step's end: a value of
        # record/constants.py, from NOTHING_KNOWN to DISTANCE_KNOWN; the latter means that candidates without
        # contact have at least the clearance ``safe_distance``
        ("known_extent", bounded_integer(0, DISTANCE_KNOWN)),
        # value of `step.break_count` for which ``known_extent`` is valid; for other values nothing is known
        ("known_at_break", INTEGER),
        # m, lower bound on the clearances of candidates without contact, at the last step's end
        ("safe_distance", REAL),
        # rad/s, largest angular frequency at which an input changes in the searched step
        ("input_rate", REAL),
        ("speed_bound", REAL),  # m/s, bound on the speeds of places relative to walls at the last step's end
        # m/s², bound on the accelerations of places relative to walls at the last step's end
        ("acceleration_bound", REAL),
        # number of candidates that the search examines; other candidates have no event in the step
        ("suspect_count", INTEGER),
        # indices of the ``suspect_count`` candidates to be examined
        ("suspect_index", INTEGER, (candidate_count,)),
        # m/s², bound, for the whole step, on the second derivative, by the step's variable, of the clearance
        # of each candidate that the search examines
        ("curvature", REAL, (candidate_count,)),
        # φ of each candidate at the start and the end of the searched interval: the clearance [m]; in contact
        # the penetration [m], u of the regularized contact, or ∞ at a rigid wall (events/event_exclusion.py)
        ("phi_start", REAL, (candidate_count,)),
        ("phi_end", REAL, (candidate_count,)),
        # φ′ of each candidate at the start and the end of the interval: the derivative of φ by the step's
        # integration variable, time or fictitious time, both in seconds
        ("phi_start_rate", REAL, (candidate_count,)),
        ("phi_end_rate", REAL, (candidate_count,)),
        # φ″ of each candidate, the second derivative, at the start and the end of the whole step, which may
        # have several intervals
        ("phi_start_curvature", REAL, (candidate_count,)),
        ("phi_end_curvature", REAL, (candidate_count,)),
    )


@written_by(
    **dict.fromkeys(
        ("z_start", "rate_start", "link_vector", "contact_stiffness", "contact_damping"),
        "ode/extended_state.py",
    ),
    **dict.fromkeys(("drive_stiffness", "drive_damping", "shift", "pairs"), "ode/extended_state.py"),
    **dict.fromkeys(("iterations", "relative_correction", "convergence_rate"), "ode/radau.py"),
    **dict.fromkeys(("contact_set_of_step", "last_stages", "dense_corrections"), "ode/collocation.py"),
    **dict.fromkeys(("z_scratch", "stages"), ("ode/collocation.py", "ode/radau.py", "ode/friction_work.py")),
    friction_force="ode/friction_work.py",
    right_hand_sides=("ode/collocation.py", "ode/radau.py"),
    target_clearance=("ode/collocation.py", "ode/extended_state.py"),
    error_weight="ode/collocation.py",
)
def implicit_dtype(
    link_count: int, candidate_count: int, friction_element_count: int, site_count: int
) -> np.dtype:
    """Return the layout of the scratch memory of an implicit step, and of the data of the last implicit step.

    The extended state z consists of y without the last two entries, the clearances of active contacts with a
    force law, the rates of these clearances, and the quadratures (kernel/ode/extended_state.py).
    """
    state = state_length(link_count)
    extended = state + 3 * candidate_count + friction_element_count
    # Data of the linear systems with complex shifts s, one shift of each conjugate pair. ``factors`` has a
    # slot for each shift; the other fields serve one system at a time. For the real shift, `scratch` has such
    # data, and ``right_hand_sides`` has x.
    pairs = layout(
        ("factors", factors_dtype(link_count, COMPLEX, PAIR_COUNT)),
        ("impedance", impedance_dtype(link_count, site_count, COMPLEX)),
        ("applied_force", applied_force_dtype(link_count, site_count, COMPLEX)),
        ("place_change", vectors_dtype(place_count(link_count, site_count), COMPLEX)),
        ("change", COMPLEX, (coordinate_count(link_count),)),
        ("x", COMPLEX, (extended,)),  # right-hand side of the linear system, later its solution
    )
    return layout(
        ("z_start", REAL, (extended,)),  # extended state z at the start of a step
        ("rate_start", REAL, (extended,)),  # rate ż of the extended state at the start of a step
        # memory with an entry for each component of z: the extended state that is evaluated; after
        # ``correct_stages`` (ode/radau.py) the largest absolute change of each component
        ("z_scratch", REAL, (extended,)),
        # in an implicit step the weights 1/(tolerance × scale) of errors in z; in an explicit step the scales
        # of errors in y and in clearances
        ("error_weight", REAL, (extended,)),
        ("stages", REAL, (RADAU_STAGES, extended)),  # increments of z from the step's start to its nodes
        ("rates", REAL, (RADAU_STAGES, extended)),  # rate ż of the extended state at the nodes
        # N, force of dry friction on each element with friction, in a joint the moment over the longest link,
        # at the nodes
        ("friction_force", REAL, (RADAU_STAGES, friction_element_count)),
        # right-hand sides of the linear systems, later their solutions (kernel/ode/radau.py)
        ("right_hand_sides", REAL, (RADAU_STAGES, extended)),
        # increments of z from the start of the last step to its nodes
        ("last_stages", REAL, (RADAU_STAGES, extended)),
        # value of `contacts.contact_set` in the step of ``last_stages``; while `contacts.contact_set` has it,
        # the active contacts are the same, and ``last_stages`` can predict the stages of the next step
        ("contact_set_of_step", INTEGER),
        ("iterations", INTEGER),  # number of Newton iterations in the tried step
        # largest component of the last Newton correction, over the tolerated error
        ("relative_correction", REAL),
        # convergence rate θ of Newton's iteration, the ratio of its last two corrections; ∞ after a
        # correction above FAILED_CORRECTION (ode/radau.py)
        ("convergence_rate", REAL),
        # changes of y, at one third and at two thirds of the step, by which the dense output is corrected
        ("dense_corrections", REAL, (2, state)),
        # m, link vectors L_i in the state at which the Jacobian A was evaluated
        ("link_vector", vectors_dtype(link_count + 1)),
        # N/m, slope ∂F/∂δ of the force F of each active contact with a force law, by the penetration; in the
        # order of `contacts.active_index`
        ("contact_stiffness", REAL, (candidate_count,)),
        # N·s/m, slope ∂F/∂δ̇ of the force F of each active contact with a force law, by the rate of the
        # penetration; in the order of `contacts.active_index`
        ("contact_damping", REAL, (candidate_count,)),
        # N·m/rad, slope −∂F/∂ψ of the torque F of each joint's drive, by the joint's angle ψ; the last entry
        # belongs to the slider [N/m]
        ("drive_stiffness", REAL, (link_count + 1,)),
        # N·m·s/rad, slope −∂F/∂ψ̇ of the torque F of each joint's drive, by the joint's rate ψ̇; the last
        # entry belongs to the slider [N·s/m]
        ("drive_damping", REAL, (link_count + 1,)),
        # m or m/s, clearances or their rates to which ``project_coordinates`` (ode/extended_state.py) moves
        # the active contacts; in the order of `contacts.active_index`
        ("target_clearance", REAL, (candidate_count,)),
        # s, real shift s of the linear systems (1 − s A) x = r, for which `scratch.factors` contains the
        # elimination
        ("shift", REAL),
        ("pairs", pairs),
    )

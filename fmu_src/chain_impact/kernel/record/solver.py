"""The parts of the record with the solver's memory: data that last, and scratch memory."""

import numpy as np

from chain_impact.kernel.chain.response import SLOTS
from chain_impact.kernel.chain.state import coordinate_count, state_size
from chain_impact.kernel.events.exclusion import FAR
from chain_impact.kernel.ode.control import ACCEPTED, DIVERGED, EXPLICIT, IMPLICIT
from chain_impact.kernel.ode.dense import DENSE_COEFFICIENTS
from chain_impact.kernel.ode.explicit import STAGES
from chain_impact.kernel.ode.last_step import SOLVER
from chain_impact.kernel.ode.radau import PAIRS, RADAU_STAGES
from chain_impact.kernel.ode.sundman import NO_CONTACT
from chain_impact.kernel.record.fields import (
    COMPLEX,
    INTEGER,
    REAL,
    bounded,
    impedance_dtype,
    loads_dtype,
    place_count,
    record,
    vectors_dtype,
    written_by,
)
from chain_impact.kernel.status import LAST_STATUS, OK


@written_by(
    "ode/last_step.py",
    dense=("ode/last_step.py", "ode/explicit.py", "ode/collocation.py"),
    **dict.fromkeys(("next_size", "flight_size"), "ode/control.py"),
    **dict.fromkeys(("method", "stiff_count", "switch_hysteresis", "explicit_size"), "ode/methods.py"),
)
def step_dtype(links: int, candidates: int) -> np.dtype:
    """Return the layout of the last accepted step and its dense output, which covers `start` to `end`."""
    state = state_size(links)
    return record(
        ("time", REAL),  # s, the communication point; start ≤ time ≤ end
        ("start", REAL),  # s, start of the step
        # s, time since which t in the state y counts: the start of the last step or of the tried step
        ("clock", REAL),
        ("end", REAL),  # s, end of the whole step, or the event at which the step was truncated
        # s, delay of the event at `start`: 0, with derivatives in a tangent instance
        ("start_delay", REAL),
        # size of the step in its integration variable: seconds, or fictitious time (kernel/ode/sundman.py)
        ("size", REAL),
        ("end_fraction", REAL),  # fraction of `size` at which the step was truncated; 1: it was not
        ("next_size", REAL),  # the proposed size of the next step, in its integration variable
        # proposed size, stored when the first of the present contacts began, for the flight after them
        ("flight_size", REAL),
        ("state", REAL, (state,)),  # state y at `start`
        ("state_end", REAL, (state,)),  # state y at `end`
        # J, dissipated energy at `start` and at `end` that y lacks, because its rounding has lost it
        ("remainder", REAL),
        ("remainder_end", REAL),
        # J, the same at the end of the whole step of `size`, before it was truncated
        ("remainder_whole", REAL),
        # coefficients of the dense output, of the whole step of `size`
        ("dense", REAL, (DENSE_COEFFICIENTS, state)),
        ("rate_known", INTEGER),  # 1: `scratch.rate_end` is ẏ at `end`
        # for whom the dense output was computed; 0: it does not exist yet, see kernel/ode/last_step.py
        ("dense_for", bounded(0, SOLVER)),
        # number of the method of the last step, see kernel/ode/control.py
        ("last_method", bounded(EXPLICIT, IMPLICIT)),
        # number of breaks in the sequence of steps: a step has begun elsewhere than at the end of the step
        # before, or in another integration variable
        ("breaks", INTEGER),
        # candidate of the regularized contact, in whose fictitious time the step runs; −1: the step runs in
        # time
        ("regularized", bounded(NO_CONTACT, candidates - 1)),
        ("method", bounded(EXPLICIT, IMPLICIT)),  # number of the current method, see kernel/ode/control.py
        # s, length of the last explicit step before the present implicit steps; 0: unknown
        ("explicit_size", REAL),
        ("stiff_count", INTEGER),  # number of steps in a row that have favoured the other method
        ("switch_hysteresis", INTEGER),  # value of ``stiff_count`` at which the method changes
    )


@written_by("ode/control.py", state=("ode/collocation.py", "ode/last_step.py"))
def trial_dtype(links: int) -> np.dtype:
    """Return the layout of the outcome of the tried step."""
    return record(
        ("size", REAL),  # size of the tried step in its integration variable
        ("state", REAL, (state_size(links),)),  # state y at the end of the tried step
        # ACCEPTED, or the reason why the tried step is rejected, see kernel/ode/control.py
        ("outcome", bounded(ACCEPTED, DIVERGED)),
        # error of the step relative to the tolerance or, if this is larger, energy that it has lost relative
        # to the allowed loss; valid for a step that is ACCEPTED or INACCURATE (kernel/ode/control.py)
        ("error", REAL),
        ("cost_factor", REAL),  # factor on the next size, below 1 if shorter steps would cost less
    )


@written_by("status.py")
def fault_dtype() -> np.dtype:
    """Return the layout of the cause of a fault."""
    # the part of the scene that caused the fault, as a number: first the C candidates, from 1; then the N
    # links; then the drives, of N joints and a slider; then, for each candidate, the base at its wall; 0:
    # none
    return record(("part", INTEGER))


@written_by("cost.py", status="status.py")
def statistics_dtype() -> np.dtype:
    """Return the layout of the counts since the start, and of the status."""
    return record(
        ("steps", INTEGER),  # number of accepted steps
        ("rejected_steps", INTEGER),
        # number of evaluations of ẏ that the solver needs; evaluations for outputs do not count
        ("rhs_evaluations", INTEGER),
        ("implicit_steps", INTEGER),
        ("status", bounded(OK, LAST_STATUS)),  # status of the run, see kernel/status.py
    )


@written_by("cost.py")
def limits_dtype() -> np.dtype:
    """Return the layout of the counts of events and of cost, which are limited within windows of time."""
    return record(
        ("event_start", REAL),  # s, start of the window in which events are counted
        ("event_count", INTEGER),
        ("cost_start", REAL),  # s, start of the window in which the cost is limited
        ("cost_count", INTEGER),  # cost until `cost_start`, in evaluations
        # cost until the start of the communication step, in evaluations; cost.UNLIMITED: no limit
        ("call_count", INTEGER),
        # cost of calculations that are no evaluations (located points, responses to impulses), as a number of
        # evaluations of equal cost
        ("other_cost", INTEGER),
    )


@written_by("ode/balance.py")
def balance_dtype() -> np.dtype:
    """Return the layout of the energy balance, and of its allowed changes."""
    return record(
        ("at_end", REAL),  # J, energy balance at the end of the last step
        ("at_start", REAL),  # J, energy balance at the start of the last step
        # value of `step.breaks` when the energy balance was last evaluated at the start of a step
        ("breaks", INTEGER),
        ("start", REAL),  # s, start of the window of time in which changes are summed
        # J, energy balance at the start of the window, plus the later changes that new parameters cause
        ("reference", REAL),
        ("allowed", REAL),  # J, largest change that a step in the window was allowed so far
        # J, change of the energy balance that every step may have, in any state
        ("least_allowed", REAL),
        ("since", REAL),  # s, the start of the run
        # J, energy balance at the start of the run, plus the later changes that new parameters cause
        ("origin", REAL),
        # J, the largest available energy (kernel/ode/balance.py) up to the start of the last step
        ("available_at_start", REAL),
        ("available", REAL),  # J, the largest available energy up to the end of the last step
        ("unit_motion", REAL),  # √J, √E₁ in the scale S of the energy (kernel/ode/balance.py)
        ("unit_scale", REAL),  # J, M g (s + Σ L_i) + E₂ in the scale S of the energy (kernel/ode/balance.py)
        ("weight", REAL),  # N, weight of the chain
    )


def factors_dtype(links: int, scalar: type, slots: int) -> np.dtype:
    """Return the layout of the factors of ``slots`` matrices M + Jᵀ D J + K (chain/response.py)."""
    return record(
        # factors of each link: ``gain`` h/(H + κ), ``inverse`` 1/(H + κ), ``coupling`` σ = κ/(H + κ) and
        # ``complement`` 1 − σ = H/(H + κ)
        *(
            (name, scalar, (slots, links))
            for name in ("gain_x", "gain_y", "inverse", "coupling", "complement")
        ),
        # 1: joints transmit moments; 0: ``coupling`` and ``complement`` are not used
        ("coupled", INTEGER, (slots,)),
        # 1/kg, inverse articulated inertia at the joint where the arms meet: xx, xy, yy
        ("middle_mobility", scalar, (slots, 3)),
    )


def elimination_dtype(links: int) -> np.dtype:
    """Return the layout of the results h/H, 1/H and h₀/H of chain/elimination.py for each link."""
    return record(
        *((name, REAL, (links,)) for name in ("gain_x", "gain_y", "inverse", "bias")),
        # kg, articulated inertia at the joint where the arms of a free chain meet, or at the base of a
        # slider; not set with a pinned base
        *((name, REAL) for name in ("middle_xx", "middle_xy", "middle_yy")),
    )


@written_by(
    y="events/crossing.py",
    rate_start="advance.py",
    error="ode/collocation.py",
    load=("forces/active_contacts.py", "rows/compliance.py"),
    motion="rows/compliance.py",
    impedance="chain/joints.py",
    factors="chain/response.py",
    moment="equations.py",
    thrust="equations.py",
    elimination="chain/elimination.py",
    change="ode/friction_work.py",
    reach="events/crossing.py",
    **dict.fromkeys(("position", "velocity", "acceleration", "at_end"), "chain/kinematics.py"),
)
def scratch_dtype(links: int, sites: int) -> np.dtype:
    """Return the layout of the scratch memory; a field is valid within a step unless a comment says more."""
    points, state = links + 1, state_size(links)
    places, loads = vectors_dtype(place_count(links, sites)), loads_dtype(links, sites)
    impedance = impedance_dtype(links, sites)
    return record(
        ("stage", REAL, (STAGES, state)),  # rates dy/ds at the stages of a step
        ("rate_start", REAL, (state,)),  # ẏ at the start of the step
        ("rate_end", REAL, (state,)),  # ẏ at the end of the step; remains valid after the step
        ("y", REAL, (state,)),  # the state y that is being evaluated
        ("rate", REAL, (state,)),  # the rate ẏ of ``y``, for an evaluation that is not a stage of a step
        ("nearby", REAL, (state,)),  # a state some time before or after ``y``, see kernel/ode/folds.py
        ("error", REAL, (2, state)),  # the two error estimates of a step
        ("link", vectors_dtype(points)),  # m, link vectors L_i; entry N is not used
        # loads, as forces or impulses: N or N·s at each place, N·m or N·m·s in each joint and on each link
        ("load", loads),
        ("moment", REAL, (links,)),  # N·m, moment on each link from its joints
        ("thrust", REAL),  # N, force of the slider's motor, spring and damper on the carriage
        ("impedance", impedance),  # impedance D of each place [kg], and impedance of each joint [kg·m²]
        # factors of the matrices M + Jᵀ D J + K, see kernel/chain/response.py
        ("factors", factors_dtype(links, REAL, SLOTS)),
        # results of the recursion for the accelerations, see kernel/chain/elimination.py
        ("elimination", elimination_dtype(links)),
        # m, positions of all places: points, joints in a scene with stops or dry friction in joints, and
        # sites
        ("position", places),
        ("velocity", places),  # m/s, velocities of all places
        ("acceleration", places),  # m/s², accelerations of all places
        # 1: the places are located and accelerated at the end of the last step; valid after the step, too
        ("at_end", INTEGER),
        # a change of all coordinates or of their rates, such as the response to an impulse or a force
        ("change", REAL, (coordinate_count(links),)),
        ("motion", places),  # motions of all places that a change of the coordinates causes
        # m/s², for each point a bound: the part of the links in the second derivative of its position in the
        # step's variable
        ("reach", REAL, (points,)),
    )


@written_by("events/exclusion.py", curvature=("events/crossing.py", "ode/collocation.py"))
def search_dtype(candidates: int) -> np.dtype:
    """Return the layout of the search for events, with data at both ends of the searched interval."""
    return record(
        # which data of the clearances are known at the end of a step, see kernel/events/exclusion.py
        ("known", bounded(0, FAR)),
        # value of `step.breaks` for which ``known`` is valid; after another break nothing is known
        ("known_for", INTEGER),
        # m, lower bound on the clearances of candidates without contact at the end of a step
        ("safe_distance", REAL),
        ("speed", REAL),  # m/s, bound on the speeds of places relative to walls at the end of a step
        # m/s², bound on the accelerations of places relative to walls at the end of a step
        ("acceleration", REAL),
        # number of candidates that the search examines; other candidates have no event in the step
        ("suspect_count", INTEGER),
        ("suspect", INTEGER, (candidates,)),  # indices of the candidates that the search examines, packed
        # m/s², bound over the step on the second derivative of each suspect's clearance in the step's
        # variable
        ("curvature", REAL, (candidates,)),
        # φ of each candidate at the start of the interval: the clearance [m]; in contact the penetration [m],
        # u of the regularized contact, or ∞ at a rigid wall (events/exclusion.py)
        ("phi_start", REAL, (candidates,)),
        ("phi_end", REAL, (candidates,)),
        # derivative φ′ of each candidate in the step's variable at the start of the interval
        ("phi_start_rate", REAL, (candidates,)),
        ("phi_end_rate", REAL, (candidates,)),
        # second derivative φ″ of each candidate at the start of the whole step
        ("phi_start_curve", REAL, (candidates,)),
        ("phi_end_curve", REAL, (candidates,)),
    )


@written_by(
    **dict.fromkeys(("start", "start_rate", "link", "stiffness", "damping"), "ode/extended.py"),
    **dict.fromkeys(("drive_stiffness", "drive_damping", "shift", "pairs"), "ode/extended.py"),
    **dict.fromkeys(("iterations", "correction", "contraction"), "ode/radau.py"),
    **dict.fromkeys(("last", "listing", "thirds"), "ode/collocation.py"),
    **dict.fromkeys(("z", "stages"), ("ode/collocation.py", "ode/radau.py", "ode/friction_work.py")),
    friction="ode/friction_work.py",
    parts=("ode/collocation.py", "ode/radau.py"),
    normal=("ode/collocation.py", "ode/extended.py"),
    weight="ode/collocation.py",
)
def implicit_dtype(links: int, candidates: int, elements: int, sites: int) -> np.dtype:
    """Return the layout of the scratch memory of an implicit step, and of the data of the last implicit step.

    The vector z consists of y without its last two entries, the clearances of active contacts with a force
    law, the rates of these clearances, and the quadratures (kernel/ode/extended.py).
    """
    state = state_size(links)
    extended = state + 3 * candidates + elements
    # data of the linear systems for complex shifts, one shift of each conjugate pair; ``scratch`` has the
    # data for the real shift
    pairs = record(
        ("factors", factors_dtype(links, COMPLEX, PAIRS)),
        ("impedance", impedance_dtype(links, sites, COMPLEX)),
        ("load", loads_dtype(links, sites, COMPLEX)),
        ("motion", vectors_dtype(place_count(links, sites), COMPLEX)),
        ("change", COMPLEX, (coordinate_count(links),)),
        ("x", COMPLEX, (extended,)),  # right-hand side of a linear system, and later its solution
    )
    return record(
        ("start", REAL, (extended,)),  # extended state z at the start of a step
        ("start_rate", REAL, (extended,)),  # rate ż of the extended state at the start of a step
        # the extended state z that is evaluated; after `correct_stages` the largest |change| of each entry
        ("z", REAL, (extended,)),
        # in an implicit step the weights 1/(tolerance × scale) of errors in z; in an explicit step the scales
        # of errors in y and in clearances
        ("weight", REAL, (extended,)),
        ("stages", REAL, (RADAU_STAGES, extended)),  # increments of z from the start of the step to its nodes
        ("rates", REAL, (RADAU_STAGES, extended)),  # rate ż of the extended state at the nodes
        ("friction", REAL, (RADAU_STAGES, elements)),  # N, forces of dry friction at the nodes
        # right-hand sides of the linear systems, later their solutions (kernel/ode/radau.py)
        ("parts", REAL, (RADAU_STAGES, extended)),
        # increments of z from the start of the last step to its nodes
        ("last", REAL, (RADAU_STAGES, extended)),
        # value of `touch.listings` when ``last`` was stored: with another value, other contacts are active,
        # and ``last`` does not predict the next stages
        ("listing", INTEGER),
        ("iterations", INTEGER),  # number of Newton iterations in the tried step
        ("correction", REAL),  # largest component of the last Newton correction, relative to the tolerance
        ("contraction", REAL),  # last convergence rate θ of Newton's iteration
        # corrections of the dense output at one third and two thirds of the step
        ("thirds", REAL, (2, state)),
        ("link", vectors_dtype(links + 1)),  # m, link vectors L_i where the Jacobian A was evaluated
        ("stiffness", REAL, (candidates,)),  # N/m, ∂F/∂δ of the active contacts with a force law, packed
        ("damping", REAL, (candidates,)),  # N·s/m, ∂F/∂δ̇ of the active contacts with a force law, packed
        ("drive_stiffness", REAL, (links + 1,)),  # N·m/rad, −∂F/∂ψ of each drive; of the slider N/m
        ("drive_damping", REAL, (links + 1,)),  # N·m·s/rad, −∂F/∂ψ̇ of each drive; of the slider N·s/m
        # m or m/s, clearances or rates to which `project_coordinates` moves active contacts, packed
        ("normal", REAL, (candidates,)),
        # s, real shift s of the linear systems (1 − s A) x = r, for which `scratch.factors` contains the
        # elimination
        ("shift", REAL),
        ("pairs", pairs),
    )

"""The parts of the record that the solver remembers and works with."""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count, state_size
from chain_impact.kernel.integration.dense import DENSE_COEFFICIENTS
from chain_impact.kernel.integration.explicit import STAGES
from chain_impact.kernel.record.fields import INTEGER, REAL, impedance_dtype, record, vectors_dtype


def step_dtype(links: int) -> np.dtype:
    """The last accepted step and its dense output, valid from `start` to `end`.

    Owner: integration/last_step.py; of the method and its hysteresis, integration/switching.py; of the size
    that is proposed, whoever ends a step or a phase.
    """
    state = state_size(links)
    return record(
        ("time", REAL),  # s, the communication point; start ≤ time ≤ end
        ("start", REAL),  # s
        ("clock", REAL),  # s, when the time in the state is 0: the start of a step, or of one that is tried
        ("end", REAL),  # s, start + size, or the event that cut the step short
        ("size", REAL),  # s, of the variable that the step runs in, see kernel/integration/sundman.py
        ("kept", REAL),  # the fraction of `size` at which it ends
        ("next_size", REAL),  # … proposed, likewise
        ("cost_factor", REAL),  # … and what part of that its cost allows, of the step that is tried
        ("flight_size", REAL),  # s, of the last step before the first of the present contacts
        ("state", REAL, (state,)),  # y at `start`
        ("state_end", REAL, (state,)),  # y at `end`
        ("dense", REAL, (DENSE_COEFFICIENTS, state)),  # interpolant over `size`
        ("rate_known", INTEGER),  # 1: `work.rate_end` is ẏ at `end`
        ("dense_for", INTEGER),  # who has had the dense output so far, see kernel/integration/last_step.py
        ("last_method", INTEGER),  # the method of the last step, see kernel/integration/method.py
        ("breaks", INTEGER),  # how often the next step did not go on where the last one ended
        ("regularized", INTEGER),  # the candidate in whose fictitious time the step runs, −1: in time
        ("method", INTEGER),  # the method at work, see kernel/integration/method.py
        ("explicit_size", REAL),  # s, of the last explicit step before implicit ones; 0: not known
        ("stiff_count", INTEGER),  # steps in a row for which the other method would do better …
        ("switch_hysteresis", INTEGER),  # … and how many make the solver change
    )


def statistics_dtype() -> np.dtype:
    """Counts since the start, and the status. Owner: advance.py; of evaluations, who makes them."""
    return record(
        ("steps", INTEGER),  # accepted
        ("rejected_steps", INTEGER),
        ("rhs_evaluations", INTEGER),  # by the solver; looking at outputs is not counted
        ("implicit_steps", INTEGER),
        ("status", INTEGER),  # see kernel/status.py
    )


def limits_dtype() -> np.dtype:
    """Events and work are counted over windows of time, and must not be too many.

    Owner: work_limit.py; of other work, who does it.
    """
    return record(
        ("event_start", REAL),  # s
        ("event_count", INTEGER),
        ("work_start", REAL),  # s
        ("work_count", INTEGER),  # all work before `work_start`, in evaluations
        ("call_count", INTEGER),  # all work before the communication point
        ("other_work", INTEGER),  # besides evaluations: looks at points, responses to impulses
    )


def balance_dtype() -> np.dtype:
    """The ledger of energies. Owner: integration/balance.py."""
    return record(
        ("at_end", REAL),  # J, at the end of the last step …
        ("at_start", REAL),  # … and at its start
        ("breaks", INTEGER),  # of the steps, when it was taken anew
        ("start", REAL),  # s, of the present window
        ("reference", REAL),  # J, the ledger at its start, less what a parameter has changed since
        ("allowed", REAL),  # J, the most that a step in it was allowed to, …
        ("least_allowed", REAL),  # … and that any is
        ("since", REAL),  # s, the start of the run
        ("origin", REAL),  # J, the ledger then, likewise
        ("available", REAL),  # J, the most energy that there could be so far
        ("loss", REAL),  # by the last step, over what it might lose
        ("unit_motion", REAL),  # √J, √E₁
        ("unit_scale", REAL),  # J, the parts of S that do not change
        ("weight", REAL),  # N
    )


def elimination_dtype(links: int) -> np.dtype:
    """What the recursion keeps of each link. Owner: chain/recursion.py."""
    return record(*((name, REAL, (links,)) for name in ("gain_x", "gain_y", "bias")))


def factors_dtype(links: int) -> np.dtype:
    """M + Jᵀ D J, eliminated. Owner: ``factorize`` in chain/recursion.py."""
    return record(
        *((name, REAL, (links,)) for name in ("gain_x", "gain_y", "inverse")),
        ("middle", REAL, (3,)),  # 1/kg, A⁻¹ of the middle joint: xx, xy, yy
    )


def damped_dtype(links: int) -> np.dtype:
    """The same with joints that resist. Owner: chain/damped.py."""
    return record(
        *((name, REAL, (links,)) for name in ("gain_x", "gain_y", "inverse")),
        ("own", REAL, (links,)),  # kg·m², H
        ("damper", REAL, (links,)),  # kg·m², κ
        ("impulse", REAL, (links,)),  # N·m·s, μ
        ("base", REAL, (3,)),  # 1/kg, A⁻¹ of the base: xx, xy, yy
    )


def inner_dtype(links: int) -> np.dtype:
    """Arms from each joint inward. Owner: chain/joint_rate.py."""
    return record(
        *((name, REAL, (links,)) for name in ("gain_x", "gain_y", "inverse")),
        *((name, REAL, (links,)) for name in ("xx", "xy", "yy")),  # kg, Ā
    )


def work_dtype(links: int) -> np.dtype:
    """Work space: nothing in it outlasts a step but `rate_end`, and the points if `at_end` says so."""
    points, state = links + 1, state_size(links)
    vectors, impedance = vectors_dtype(points), impedance_dtype(points)
    return record(
        ("stage", REAL, (STAGES, state)),  # dy/ds at the stages
        ("rate_start", REAL, (state,)),  # ẏ at the start …
        ("rate_end", REAL, (state,)),  # … and the end of the step
        ("y", REAL, (state,)),  # a state that is tried or looked at …
        ("rate", REAL, (state,)),  # … and its ẏ, outside of a step
        ("error", REAL, (2, state)),  # the embedded error estimates
        ("link", vectors),  # m, L_i; entry N is not used
        ("load", vectors),  # N or N·s on each point
        ("moment", REAL, (links,)),  # N·m on each link, from its joints
        ("impedance", impedance),  # kg, D of each point
        ("elimination", elimination_dtype(links)),  # h/H and h₀/H of each link
        (
            "factors",
            factors_dtype(links),
        ),  # of an effective mass, or of a step
        ("position", vectors),  # m, of the points
        ("velocity", vectors),  # m/s
        ("acceleration", vectors),  # m/s²
        ("at_end", INTEGER),  # 1: these are the points at the end of the step
        ("change", REAL, (coordinate_count(links),)),  # 1/kg, of the coordinates' rates, by a unit impulse
        ("motion", vectors),  # of the points, for a given motion of the coordinates
        ("reach", REAL, (points,)),  # m/s², bound on what the links add to the acceleration of each point
        (
            "damped",
            damped_dtype(links),
        ),  # factors of an implicit step when joints resist, see kernel/chain/damped.py
        ("inner", inner_dtype(links)),
    )


def search_dtype(candidates: int) -> np.dtype:
    """For events, at the ends of the interval that is searched.

    Owner: events/exclusion.py; of the curvature, events/crossing.py.
    """
    return record(
        ("known", INTEGER),  # what is known at the end of a step, see kernel/events/exclusion.py, …
        ("known_for", INTEGER),  # … for so many breaks
        ("safe_distance", REAL),  # m, at least, from there to a touch, where nobody looked again …
        ("speed", REAL),  # m/s, of the fastest point there …
        ("acceleration", REAL),  # m/s², … and its largest
        ("curvature", REAL, (candidates,)),  # m/s², bound on |g̈| of each candidate over the step
        ("clear_start", REAL, (candidates,)),  # m, clearance of each candidate …
        ("clear_end", REAL, (candidates,)),
        ("clear_start_rate", REAL, (candidates,)),  # m/s … and its rate
        ("clear_end_rate", REAL, (candidates,)),
        ("clear_start_curve", REAL, (candidates,)),  # m/s², second derivative
        ("clear_end_curve", REAL, (candidates,)),
    )

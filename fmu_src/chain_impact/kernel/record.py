"""The layout of an instance: one flat record that holds everything a running simulation knows.

Parameters, inputs, the integrator's memory, statistics, outputs and work space are the fields of one NumPy
record without pointers, so the state of an FMU is a copy of its bytes. Every scalar takes eight bytes (a
double or an integer), so each has an index counted in doubles from the start of the record: the slave
needs no other knowledge of the layout.

N links, points 0…N (0 the base, N the tip), C candidates (pairs of a point and a wall), state vector y
(kernel/chain/state.py).

Every size and offset is a + bN + cC. The compiled kernel relies on it (compilation/record_type.py). What has
to do with candidates comes last, so that the places of all else do not depend on their number.
"""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count, state_size
from chain_impact.kernel.integration.dense import DENSE_COEFFICIENTS
from chain_impact.kernel.integration.explicit import STAGES
from chain_impact.kernel.model.geometry import WALLS
from chain_impact.kernel.model.inputs import DEGREE
from chain_impact.kernel.model.latest import LATEST
from chain_impact.kernel.record_implicit import (
    INTEGER,
    REAL,
    impedance_dtype,
    implicit_dtype,
    record,
    vectors_dtype,
)

LOG_SIZE = 32  # finished contacts kept until they are collected, besides one for each candidate


def output_dtype(links: int, candidates: int) -> np.dtype:
    """What an observer sees at the communication point; one row of a time series."""
    points = links + 1
    return record(
        ("point_position", REAL, (points, 2)),  # m
        ("point_velocity", REAL, (points, 2)),  # m/s
        ("point_acceleration", REAL, (points, 2)),  # m/s²
        ("angle", REAL, (links,)),  # rad, absolute, from +x
        ("angular_velocity", REAL, (links,)),  # rad/s
        ("angular_acceleration", REAL, (links,)),  # rad/s²
        ("force", REAL, (candidates,)),  # N, wall on point, along the inward normal
        ("penetration", REAL, (candidates,)),  # m, 0 when apart
        ("penetration_rate", REAL, (candidates,)),  # m/s, > 0 compressing, 0 when apart
        ("impulse", REAL, (candidates,)),  # N·s, of the wall on the point since the start
        ("kinetic", REAL),  # J
        ("potential", REAL),  # J, gravity, zero at the origin
        ("elastic", REAL),  # J, stored in the contacts and in the springs of joints
        ("dissipated", REAL),  # J, by contacts and joint damping since the start
        ("supplied", REAL),  # J, by the inputs since the start
        ("total", REAL),  # J, kinetic + potential + elastic
    )


def instance_dtype(links: int, candidates: int) -> np.dtype:
    """The record of an instance with N = ``links`` links and C = ``candidates`` candidates."""
    points = links + 1
    state = state_size(links)
    log = LOG_SIZE + candidates
    model = record(
        ("gravity", REAL, (2,)),  # m/s²
        ("length", REAL, (links,)),  # m
        ("mass", REAL, (links,)),  # kg
        ("center_of_mass", REAL, (links,)),  # m from the proximal joint
        ("inertia", REAL, (links,)),  # kg·m² about the centre of mass
        ("joint_damping", REAL, (links,)),  # N·m·s/rad at the proximal joint
        ("joint_stiffness", REAL, (links,)),  # N·m/rad, likewise
        ("joint_rest_angle", REAL, (links,)),  # rad, at which the spring is slack
        ("wall", REAL, (len(WALLS),)),  # m, position of x_min, x_max, y_min, y_max
        ("pinned", INTEGER),  # 1: the base cannot move
        ("driven", INTEGER),  # 1: there are inputs
        # derived at initialization
        ("damped", INTEGER),  # 1: some joint has damping
        ("sprung", INTEGER),  # 1: some joint has a spring
        ("resisting", INTEGER),  # 1: some joint has either …
        ("joint_bound", REAL),  # 1/s, … and bounds how fast the motions are that it makes
        ("center_of_mass_ratio", REAL, (links,)),  # centre of mass / length
        ("proximal_inertia", REAL, (links,)),  # kg·m² about the proximal …
        ("distal_inertia", REAL, (links,)),  # kg·m² … and about the distal joint
        ("middle", INTEGER),  # joint at which the two arms of the elimination meet: the base if it is pinned
        ("gravity_size", REAL),  # m/s²
        ("reach", REAL),  # m, length of the stretched chain
        ("size", REAL),  # m, longest link: the absolute scale of positions
        ("energy", REAL),  # J, of the whole mass at one `size` a second: the absolute scale of energies
    )
    contact = record(
        ("law", INTEGER),  # id of the force law, counted from 1
        ("stiffness", REAL),  # N/m^exponent
        ("exponent", REAL),
        ("restitution", REAL),
        ("radius", REAL),  # m
        ("minimum_impact_speed", REAL),  # m/s, floor of the latched impact speed
        # derived whenever law or restitution changes
        ("damping_factor", REAL),  # f(e), λ of the Hunt–Crossley family
        ("rate_exponent", REAL),  # p of the damping d δᵖ δ̇
        ("approach_only", INTEGER),  # 1: damped while compressing only
        ("derived_law", INTEGER),  # law and …
        ("derived_restitution", REAL),  # … restitution that these are for
        ("impulsive", INTEGER),  # 1: rigid walls, with impulses in place of a force law
    )
    initial = record(
        ("position", REAL, (2,)),  # m
        ("velocity", REAL, (2,)),  # m/s
        ("angle", REAL, (links,)),  # rad
        ("angular_velocity", REAL, (links,)),  # rad/s
    )
    solver = record(
        ("method", INTEGER),  # index into SOLVER_METHODS of kernel/integration/methods.py, from 1
        ("tolerance", REAL),
        ("work_limit", REAL),  # 1/s, evaluations for a second of simulated time
    )
    # polynomials that the inputs follow over time, see kernel/model/inputs.py
    course = record(
        ("order", INTEGER),  # 0: the inputs are constant
        ("middle", REAL),  # s, where x is 0 …
        ("scale", REAL),  # 1/s, … and how fast it grows
        ("until", REAL),  # s, the end of the piece
        ("pace", REAL),  # 1/s, how fast the inputs change
        ("joint_torque", REAL, (DEGREE + 1, links)),  # N·m, coefficients of the powers of x
        ("tip_force", REAL, (DEGREE + 1, 2)),  # N
    )
    # what an importer can set at any time; it is taken over at the next step or look
    given = record(
        ("changed", INTEGER),  # AT_ONCE: something was set since the last step; GOING_ON: only the course
        ("law", INTEGER),  # as in `contact`, …
        ("stiffness", REAL),
        ("restitution", REAL),
        ("joint_torque", REAL, (links,)),  # … and as in `inputs`
        ("tip_force", REAL, (2,)),
        ("course", course),
    )
    inputs = record(
        ("joint_torque", REAL, (links,)),  # N·m
        ("tip_force", REAL, (2,)),  # N
        ("course", course),
    )
    # the last accepted step and its dense output, valid from `start` to `end`
    step = record(
        ("time", REAL),  # s, the communication point; start ≤ time ≤ end
        ("start", REAL),  # s
        ("clock", REAL),  # s, when the time in the state is 0: the start of a step, or of one that is tried
        ("end", REAL),  # s, start + size, or the event that cut the step short
        ("size", REAL),  # s, of the variable that the step runs in, see kernel/integration/sundman.py
        ("kept", REAL),  # the fraction of `size` at which it ends
        ("next_size", REAL),  # … proposed, likewise
        ("ease", REAL),  # … and what part of that its cost allows, of the step that is tried
        ("flight_size", REAL),  # s, of the last step before the first of the present contacts
        ("state", REAL, (state,)),  # y at `start`
        ("state_end", REAL, (state,)),  # y at `end`
        ("dense", REAL, (DENSE_COEFFICIENTS, state)),  # interpolant over `size`
        ("rate_known", INTEGER),  # 1: `work.rate_end` is ẏ at `end`
        ("dense_for", INTEGER),  # who has had the dense output so far, see kernel/integration/last_step.py
        ("made_by", INTEGER),  # the method of the last step, see kernel/integration/method.py
        ("breaks", INTEGER),  # how often the next step did not go on where the last one ended
        ("regularized", INTEGER),  # the candidate in whose fictitious time the step runs, −1: in time
        ("method", INTEGER),  # the method at work, see kernel/integration/method.py
        ("explicit_size", REAL),  # s, of the last explicit step before implicit ones; 0: not known
        ("doubts", INTEGER),  # steps in a row for which the other method would do better …
        ("patience", INTEGER),  # … and how many make the solver change
    )
    impact = record(
        ("count", INTEGER),  # onsets since the start
        ("last_time", REAL),  # s
        ("last_point", INTEGER),  # 0…N, −1 before the first impact
        ("last_wall", INTEGER),  # 1 + index into the scene's wall_names, 0 before the first impact
        ("last_speed", REAL),  # m/s
    )
    statistics = record(
        ("steps", INTEGER),  # accepted
        ("rejected_steps", INTEGER),
        ("rhs_evaluations", INTEGER),  # by the solver; looking at outputs is not counted
        ("implicit_steps", INTEGER),
        ("status", INTEGER),  # see kernel/status.py
    )
    # events and work are counted over windows of time, and must not be too many
    limits = record(
        ("event_start", REAL),  # s
        ("event_count", INTEGER),
        ("work_start", REAL),  # s
        ("work_count", INTEGER),  # all work before `work_start`, in evaluations
        ("call_count", INTEGER),  # all work before the communication point
        ("other_work", INTEGER),  # besides evaluations: looks at points, responses to impulses
    )
    # the latest impacts, the newest first, see kernel/model/latest.py
    latest = record(
        ("kept", INTEGER),  # how many of them are wanted
        ("point", INTEGER, (LATEST,)),  # 0…N, −1 for none
        ("wall", INTEGER, (LATEST,)),  # 1 + index into the scene's wall_names, 0 for none
        ("time", REAL, (LATEST,)),  # s
        ("speed", REAL, (LATEST,)),  # m/s
        ("end", REAL, (LATEST,)),  # s, the present time for one that lasts
        ("separation_speed", REAL, (LATEST,)),  # m/s
        ("peak_force", REAL, (LATEST,)),  # N
        ("max_penetration", REAL, (LATEST,)),  # m
        ("impulse", REAL, (LATEST,)),  # N·s
    )
    # the ledger of energies, see kernel/integration/balance.py
    balance = record(
        ("ledger", REAL),  # J, at the end of the last step …
        ("before", REAL),  # … and at its start
        ("breaks", INTEGER),  # of the steps, when it was taken anew
        ("start", REAL),  # s, of the present window
        ("reference", REAL),  # J, the ledger at its start, less what a parameter has changed since
        ("allowed", REAL),  # J, the most that a step in it was allowed to, …
        ("least", REAL),  # … and that any is
        ("since", REAL),  # s, the start of the run
        ("origin", REAL),  # J, the ledger then, likewise
        ("there", REAL),  # J, the most energy that there could be so far
        ("loss", REAL),  # by the last step, over what it might lose
        ("unit_motion", REAL),  # √J, √E₁
        ("unit_scale", REAL),  # J, the parts of S that do not change
        ("weight", REAL),  # N
    )
    vectors, impedance = vectors_dtype(points), impedance_dtype(points)
    elimination = record(*((name, REAL, (links,)) for name in ("gain_x", "gain_y", "bias")))
    factors = record(
        *((name, REAL, (links,)) for name in ("gain_x", "gain_y", "inverse")),
        ("middle", REAL, (3,)),  # 1/kg, A⁻¹ of the middle joint: xx, xy, yy
    )
    damped = record(
        *((name, REAL, (links,)) for name in ("gain_x", "gain_y", "inverse")),
        ("own", REAL, (links,)),  # kg·m², H
        ("damper", REAL, (links,)),  # kg·m², κ
        ("impulse", REAL, (links,)),  # N·m·s, μ
        ("base", REAL, (3,)),  # 1/kg, A⁻¹ of the base: xx, xy, yy
    )
    inner = record(
        *((name, REAL, (links,)) for name in ("gain_x", "gain_y", "inverse")),
        *((name, REAL, (links,)) for name in ("xx", "xy", "yy")),  # kg, Ā
    )
    work = record(
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
        ("elimination", elimination),  # h/H and h₀/H of each link
        ("factors", factors),  # of an implicit step, kept over its stages, or of an effective mass
        ("position", vectors),  # m, of the points
        ("velocity", vectors),  # m/s
        ("acceleration", vectors),  # m/s²
        ("at_end", INTEGER),  # 1: these are the points at the end of the step
        ("change", REAL, (coordinate_count(links),)),  # 1/kg, of the coordinates' rates, by a unit impulse
        ("motion", vectors),  # of the points, for a given motion of the coordinates
        ("reach", REAL, (points,)),  # m/s², bound on what the links add to the acceleration of each point
        ("damped", damped),  # factors of an implicit step when joints resist, see kernel/chain/damped.py
        ("inner", inner),  # arms from each joint inward, see kernel/chain/joint_rate.py
    )
    # per candidate; what is latched at onset holds until the contact ends, or v₀ is latched anew
    touch = record(
        ("active_count", INTEGER),
        ("active_index", INTEGER, (candidates,)),  # the candidates in contact, packed
        ("active", INTEGER, (candidates,)),  # 1: in contact
        ("event", INTEGER, (candidates,)),  # at `step.end` and not yet applied, see kernel/events/kinds.py
        ("onset", REAL, (candidates,)),  # s
        ("onset_speed", REAL, (candidates,)),  # m/s, normal approach speed at onset
        ("impact_speed", REAL, (candidates,)),  # m/s, v0 of the force law
        ("effective_mass", REAL, (candidates,)),  # kg, 1/(J M⁻¹ Jᵀ) at onset
        ("depth_scale", REAL, (candidates,)),  # m, expected penetration
        ("damping", REAL, (candidates,)),  # N·s/m^(p+1), d of the force law
        ("speed", REAL, (candidates,)),  # m/s, δ̇ and …
        ("force_rate", REAL, (candidates,)),  # N/s, dF/dt at the start of the step, to find the peaks
        ("force", REAL, (candidates,)),  # N, where a rate was evaluated last, of the active …
        ("force_end", REAL, (candidates,)),  # N, … and at the end of the last step
        ("beyond", INTEGER, (candidates,)),  # 1: beyond the kink of its force, see kernel/events/kinks.py
        ("kink_margin", REAL, (candidates,)),  # m/s, of a δ̇ that need not be on its side
        ("crossed", INTEGER, (candidates,)),  # 1: a stage of the tried step was on the other side of it
        ("number", INTEGER, (candidates,)),  # of its onset, counted from 1
        ("peak_force", REAL, (candidates,)),  # N
        ("max_penetration", REAL, (candidates,)),  # m
        # m, of two error estimates of a tried step, in the clearances of the active contacts, packed
        ("gap_error", REAL, (2, candidates)),
    )
    candidate = record(
        ("point", INTEGER, (candidates,)),  # 0…N
        ("wall", INTEGER, (candidates,)),  # index into WALLS, or 4 and the index into `walls`
        # derived at initialization
        ("normal_x", REAL, (candidates,)),  # n of the wall …
        ("normal_y", REAL, (candidates,)),
        ("offset", REAL, (candidates,)),  # m, … and n·p of the points on it
    )
    # the walls at any angle: there are never more than candidates
    walls = record(
        ("x", REAL, (candidates,)),  # m, a point on each …
        ("y", REAL, (candidates,)),
        ("angle", REAL, (candidates,)),  # rad, … and its direction from +x: the free side is to its left
    )
    # for events, at the ends of the interval that is searched
    search = record(
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
    # the touching candidates of a rigid wall, packed, see kernel/model/constraints.py
    rigid = record(
        ("factors", factors),  # with an impedance at the pressed points
        (
            "change",
            REAL,
            (coordinate_count(links),),
        ),  # m, m/s or m/s², rad …, of the coordinates, by the impulses
        ("pressed", INTEGER, (candidates,)),  # 1: has an impulse
        ("wrong", INTEGER, (candidates,)),  # 1: of the wrong sign
        ("start", REAL, (candidates,)),  # normal motion without impulses, m, m/s or m/s², …
        ("reached", REAL, (candidates,)),  # … with them, …
        ("aim", REAL, (candidates,)),  # … as it shall be, at the least, …
        ("missing", REAL, (candidates,)),  # … what is missing, then that times the impedance
        ("impulse", REAL, (candidates,)),  # N·s, or N
        ("impedance", REAL, (candidates,)),  # kg, D
        ("sample", REAL, (2, candidates)),  # N, the last two forces looked at
        ("least", REAL, (candidates,)),  # N, smallest holding force in the stages of the step; not packed
    )
    finished = record(
        ("count", INTEGER),  # contacts ended since last collected
        ("point", INTEGER, (log,)),
        ("wall", INTEGER, (log,)),
        ("onset", REAL, (log,)),  # s
        ("end", REAL, (log,)),  # s
        ("impact_speed", REAL, (log,)),  # m/s, approach speed at onset
        ("separation_speed", REAL, (log,)),  # m/s
        ("peak_force", REAL, (log,)),  # N
        ("max_penetration", REAL, (log,)),  # m
        ("effective_mass", REAL, (log,)),  # kg
        ("impulse", REAL, (log,)),  # N·s
    )
    # ∫F dt of the walls on the points, packed but for what is said, see kernel/integration/impulse.py
    impulse = record(
        ("wanted", INTEGER),  # 1: followed
        ("total", REAL, (candidates,)),  # N·s since the start, not packed
        ("onset", REAL, (candidates,)),  # N·s, that at the onset of the contact, not packed
        ("state", REAL, (candidates,)),  # N·s, at the start of the last step …
        ("state_end", REAL, (candidates,)),  # … and at its end
        ("tried", REAL, (candidates,)),  # N·s, at the end of a step that is tried
        ("dense", REAL, (DENSE_COEFFICIENTS, candidates)),  # the interpolant of the last step
        ("stage", REAL, (STAGES, candidates)),  # dp/ds at the stages
    )
    return record(
        ("links", INTEGER),  # N
        ("candidates", INTEGER),  # C
        ("tangents", INTEGER),  # instances of dual numbers behind this one (kernel/tangent/)
        ("model", model),
        ("contact", contact),
        ("initial", initial),
        ("solver", solver),
        ("given", given),
        ("inputs", inputs),
        ("step", step),
        ("impact", impact),
        ("latest", latest),
        ("statistics", statistics),
        ("limits", limits),
        ("balance", balance),
        ("work", work),
        ("touch", touch),
        ("candidate", candidate),
        ("walls", walls),
        ("search", search),
        ("implicit", implicit_dtype(links, candidates)),
        ("rigid", rigid),
        ("finished", finished),
        ("impulse", impulse),
        ("output", output_dtype(links, candidates)),
    )

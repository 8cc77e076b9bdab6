"""The linearly implicit step of order 3, for sustained contact and stiff joints (its data: ros34pw2.py).

A point resting on a stiff wall makes the equations stiff: the contact's own motions are far faster than the
chain's, and decay. Their part of the Jacobian has the rank of the active contacts, and all else may be left
out of it, as the method keeps its order with any A.

As the links turn, a stage's coordinates leave the wall's tangent by ½ h² J̇ẏ. That is little, but soon more
than the penetration of a stiff wall. So the clearances g of the active contacts and their rates are
integrated beside y, z = (y, g, ġ, p), with g̈ the acceleration of the point along the normal. The forces are
those at g and ġ, in which the fast motions are linear but for the law of force.

Joints that resist make the equations stiff, too, and need nothing beside y: their moments −C v − S q, but for
constants, are linear in it, C = Σ c_i g_i g_iᵀ and S = Σ k_i g_i g_iᵀ with g_i the gradient of ω_i − ω_{i−1}.
The Jacobian is

    ∂v̇/∂(g, ġ, v, q) = −M⁻¹ (Jᵀk, Jᵀc, C, S),   g̈ likewise with −J M⁻¹,   ∂(ẋ, ġ)/∂(v, ġ) = 1,

k = ∂F/∂δ, c = ∂F/∂δ̇, J the gradient of the clearances. Solving (1 − hγA) x = r takes no linear algebra but
the recursion. With x_v = r_v − Δ the rows of v̇ are M Δ = hγ (Jᵀ (k x_g + c x_ġ) + C x_v + S x_q), hence

    (M + Jᵀ D J + K) Δ = Jᵀ (D r_ġ + hγ k r_g) + K r_v + hγ S r_q,   D = hγ c + (hγ)² k,   K = hγ C + (hγ)² S,
    x_v = r_v − Δ,   x_ġ = r_ġ − J Δ,   x_q = r_q + hγ x_v,   x_g = r_g + hγ x_ġ,

with Δ the response of the chain to impulses at the touching points and moments in the joints. The contacts'
impedance D adds to the articulated inertia at their points. κ_i = hγ (c_i + hγ k_i) is a damper in its joint,
which K r_v + hγ S r_q gives an impulse: chain/damped.py, which only chains with joints that resist need.

The coordinates of a result are moved to the g and ġ that came with it in the same way, and those of its dense
output in between. How far they had left them counts as an error.
"""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.springs import stiffness_of
from chain_impact.kernel.chain.state import (
    ANGLES,
    coordinate_count,
    dissipated_at,
    omega_at,
    root_at,
    time_at,
    velocity_at,
)
from chain_impact.kernel.integration import ros34pw2
from chain_impact.kernel.integration.combination import combination
from chain_impact.kernel.integration.dense import interpolate
from chain_impact.kernel.integration.errors import scaled_error
from chain_impact.kernel.integration.impulse import followed
from chain_impact.kernel.integration.method import Method
from chain_impact.kernel.model.compliance import give_way, give_way_damped, stiffen, stiffen_damped
from chain_impact.kernel.model.contact import apply_contact, clear_loads, contact_slopes
from chain_impact.kernel.model.equations import loaded_rate
from chain_impact.kernel.model.geometry import along_normal, clearance
from chain_impact.kernel.model.inputs import set_inputs

GAMMA = ros34pw2.GAMMA_DIAGONAL
# rows of implicit.stage, in which 1 to 4 are the stages k_i
START_RATE, RATE, CORRECTION, RIGHT, ZEROS, ERROR = 0, 5, 6, 7, 8, 9
ROWS = 10
STEP_EVALUATIONS = len(ros34pw2.B) - 1  # the first stage has f at the start of the step
# Of a penetration: by how much the coordinates may leave the clearance that is integrated beside them over a
# step. More makes the interpolant of the state wrong by as much; less bounds the step where links turn on a
# stiff wall.
APART = 0.03


def _stage(i, rate, solve_shifted):
    """Stage i > 1 of a step."""
    point = combination(ros34pw2.ALPHA[i])
    correction = combination({j: g / GAMMA for j, g in ros34pw2.GAMMA[i].items()})
    part = math.fsum(ros34pw2.ALPHA[i].values())  # of the step, at which the stage stands

    def stage(d, z_start, z, h):
        stages = d.implicit.stage
        point(stages, z_start, h, z)
        rate(d, z, h * part, stages[RATE])
        # (1 − hγA)(k + s) = f + s
        correction(stages, stages[ZEROS, : len(z)], 1.0, stages[CORRECTION])
        for j in range(len(z)):
            stages[RIGHT, j] = stages[RATE, j] + stages[CORRECTION, j]
        solve_shifted(d, h * GAMMA, stages[RIGHT], stages[i])
        for j in range(len(z)):
            stages[i, j] -= stages[CORRECTION, j]

    return stage


def linearly_implicit(rate, solve_shifted):
    """The stages and the result of a step, for a right-hand side and its linear solver.

    Args:
        rate: function (d, z, elapsed, out) for out = f(z), so long [s] after the start of the step. Its
            change with time is left out of A: the method keeps its order.
        solve_shifted: function (d, hγ, r, x) for (1 − hγA) x = r.

    Returns:
        A function (d, start, z, h): from z = ``start`` with its rate in the first row of
        ``implicit.stage``, to the result in ``z``, the error estimate in the last of these rows.
    """
    second, third, fourth = (_stage(i, rate, solve_shifted) for i in (2, 3, 4))
    result = combination(ros34pw2.B)
    difference = combination({i: b - ros34pw2.B_EMBEDDED[i] for i, b in ros34pw2.B.items()})

    def step(d, start, z, h):
        stages = d.implicit.stage
        solve_shifted(d, h * GAMMA, stages[START_RATE], stages[1])
        second(d, start, z, h)
        third(d, start, z, h)
        fourth(d, start, z, h)
        result(stages, start, h, z)
        difference(stages, stages[ZEROS, : len(z)], h, stages[ERROR])

    return step


def linearize(d):
    """Set z and its rate at the start of the step, where the slopes of the contact forces and J hold.

    Active contacts need the first stage evaluated.
    """
    work, n = d.work, d.links
    z, rate = d.implicit.start, d.implicit.stage[START_RATE]
    if not work.at_end:
        locate_points(d, d.step.state_end)
    accelerate_points(d, d.step.state_end, work.rate_start)
    for i in range(n):
        d.implicit.link.x[i] = work.link.x[i]
        d.implicit.link.y[i] = work.link.y[i]
    for j in range(root_at(n)):
        z[j] = d.step.state_end[j]
        rate[j] = work.rate_start[j]
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        d.implicit.stiffness[k], d.implicit.damping[k] = contact_slopes(d, c)
        z[gap_at(d, k)], z[rate_at(d, k)] = clearance(d, c)
    for k in range(followed(d)):
        z[impulse_at(d, k)] = d.impulse.state_end[k]
        rate[impulse_at(d, k)] = d.touch.force_end[d.touch.active_index[k]]
    clearance_rates(d, z, rate)


def gap_at(d, k):
    """Where the clearance of the k-th active contact stands in z: from the place of u on, which is 1."""
    return root_at(d.links) + k


def rate_at(d, k):
    """Where the rate of that clearance stands in z."""
    return gap_at(d, d.touch.active_count + k)


def impulse_at(d, k):
    """Where the impulse of that contact stands in z."""
    return gap_at(d, 2 * d.touch.active_count + k)


def clearance_rates(d, z, rate):
    """Set the rates of g and ġ, for accelerated points."""
    for k in range(d.touch.active_count):
        rate[gap_at(d, k)] = z[rate_at(d, k)]
        rate[rate_at(d, k)] = along_normal(d, d.touch.active_index[k], d.work.acceleration)


def extended_rate(d, z, elapsed, rate):
    """Set rate = ż, ``elapsed`` [s] after the start, with the contact forces at clearances and rates in z."""
    if d.inputs.course.order > 0:
        set_inputs(d, d.step.clock + elapsed)
    locate_points(d, z)
    clear_loads(d)
    dissipated = 0.0
    for k in range(d.touch.active_count):
        dissipated += apply_contact(d, d.touch.active_index[k], z[gap_at(d, k)], z[rate_at(d, k)])
    for k in range(followed(d)):
        rate[impulse_at(d, k)] = d.touch.force[d.touch.active_index[k]]
    loaded_rate(d, z, dissipated, rate)  # … and of u and time, in whose place are clearances here
    accelerate_points(d, z, rate)
    clearance_rates(d, z, rate)


def factorize_stiff(d, shift):
    """Eliminate M + Jᵀ D J + K for hγ = ``shift`` [s]."""
    own = d.implicit
    for k in range(d.touch.active_count):
        # D = hγ c + (hγ)² k
        own.impedance[k] = shift * (own.damping[k] + shift * own.stiffness[k])
    if d.model.resisting:
        stiffen_damped(d, own.link, own.impedance, shift)
    else:
        stiffen(d, own.link, own.impedance, d.work.factors)


def respond(d, change):
    """Solve (M + Jᵀ D J + K) Δ = Jᵀ p + K r for Δ = ``change`` and J Δ.

    p stands in ``normal``, and then J Δ; the impulses K r in the joints in ``work.damped.impulse``.
    """
    own = d.implicit
    if d.model.resisting:
        give_way_damped(d, own.link, own.normal, change)
    else:
        give_way(d, own.link, d.work.factors, own.normal, change)
    for k in range(d.touch.active_count):
        own.normal[k] = along_normal(d, d.touch.active_index[k], d.work.motion)


def solve_stiff(d, shift, r, x):
    """Solve (1 − hγA) x = r for hγ = ``shift`` [s]."""
    n, own, velocities = d.links, d.implicit, velocity_at(d.links)
    for k in range(d.touch.active_count):
        # D r_ġ + hγ k r_g
        own.normal[k] = own.impedance[k] * r[rate_at(d, k)] + shift * own.stiffness[k] * r[gap_at(d, k)]
    if d.model.resisting:
        load_joints(d, shift, r)
    respond(d, x[velocities : dissipated_at(n)])
    for j in range(coordinate_count(n)):
        x[velocities + j] = r[velocities + j] - x[velocities + j]
        x[j] = r[j] + shift * x[velocities + j]
    for k in range(d.touch.active_count):
        x[rate_at(d, k)] = r[rate_at(d, k)] - own.normal[k]
        x[gap_at(d, k)] = r[gap_at(d, k)] + shift * x[rate_at(d, k)]
    for k in range(followed(d)):
        slope = own.stiffness[k] * x[gap_at(d, k)] + own.damping[k] * x[rate_at(d, k)]
        x[impulse_at(d, k)] = r[impulse_at(d, k)] - shift * slope
    for j in range(dissipated_at(n), root_at(n)):
        x[j] = r[j]


def relative(r, first, i):
    """Entry i of those that begin at ``first``, from the one before; the base has 0."""
    return r[first + i] - (r[first + i - 1] if i > 0 else 0.0)


def load_joints(d, shift, r):
    """Set the impulses in the joints: K r_v + hγ S r_q."""
    damped = d.work.damped
    for i in range(d.links):
        turning, turned = relative(r, omega_at(d.links), i), relative(r, ANGLES, i)
        damped.impulse[i] = damped.damper[i] * turning + shift * stiffness_of(d, i) * turned


_step = linearly_implicit(extended_rate, solve_stiff)


def attempt(d, h):
    """Try a step of size h [s] from where it was linearized; the result stands in ``work.y``.

    Returns:
        The error relative to the tolerance: at most 1 for a step to accept; not finite when f was not.
    """
    work, active = d.work, d.touch.active_count
    length = gap_at(d, 2 * active + followed(d))
    factorize_stiff(d, h * GAMMA)
    _step(d, d.implicit.start[:length], d.implicit.z[:length], h)
    # the columns of the Jacobian count as evaluations
    d.statistics.rhs_evaluations += STEP_EVALUATIONS + active
    for j in range(root_at(d.links)):
        work.y[j] = d.implicit.z[j]
        work.error[0, j] = abs(d.implicit.stage[ERROR, j])
    work.y[root_at(d.links)], work.y[time_at(d.links)] = 1.0, h
    for k in range(active):
        d.touch.gap_error[0, k] = d.implicit.stage[ERROR, gap_at(d, k)]
    for k in range(followed(d)):
        d.impulse.tried[k] = d.implicit.z[impulse_at(d, k)]
    locate_points(d, work.y)
    apart, change = largest_mismatch(d), d.implicit.stage[RIGHT, : coordinate_count(d.links)]
    for derivative in range(2):
        for k in range(active):
            at = rate_at(d, k) if derivative else gap_at(d, k)
            d.implicit.normal[k] = d.implicit.z[at]
        first = meet(d, derivative, change)
        for j in range(len(change)):
            work.y[first + j] += change[j]
            work.error[0, first + j] += abs(change[j])
    return max(scaled_error(d, 0), apart / APART)


def largest_mismatch(d):
    """How far the located coordinates have left the clearances in z, in parts of the penetration."""
    worst = 0.0
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        gap, _ = clearance(d, c)
        depth = max(d.touch.depth_scale[c], -gap)
        worst = max(worst, abs(d.implicit.z[gap_at(d, k)] - gap) / depth)
    return worst


def meet(d, derivative, change):
    """Set the change of coordinates (for derivative 1: velocities) to the clearances (rates) in ``normal``.

    The coordinates that are integrated beside the clearances differ from them by little, which a stiff wall
    would feel as a blow. The points have to be located.

    Returns:
        Where the coordinates begin in y.
    """
    n, own = d.links, d.implicit
    for k in range(d.touch.active_count):
        gap, gap_rate = clearance(d, d.touch.active_index[k])
        own.normal[k] = own.impedance[k] * (own.normal[k] - (gap_rate if derivative else gap))
    for i in range(n):
        d.work.damped.impulse[i] = 0.0
    respond(d, change)
    return derivative * velocity_at(n)


def finish(d, h):
    """Keep a dense output of the step that was tried, for the state alone."""
    dense, stages = d.step.dense, d.implicit.stage
    for j in range(len(d.work.y)):
        for m in range(len(dense)):
            dense[m, j] = 0.0
    for i, (_, square, cube) in _DENSE:
        for j in range(root_at(d.links)):
            # c₁θ + c₂θ² + c₃θ³ = θ(F₀ + (1−θ)(F₁ + θF₂)) with F₂ = −c₃, F₁ = −c₂−c₃, F₀ = c₁+c₂+c₃
            dense[1, j] -= h * (square + cube) * stages[i, j]
            dense[2, j] -= h * cube * stages[i, j]
    for j in range(len(d.work.y)):
        dense[0, j] = d.step.state_end[j] - d.step.state[j]
    for k in range(followed(d)):
        keep_impulse(d, h, k)


def keep_impulse(d, h, k):
    """Keep a dense output of the k-th impulse, as of the state."""
    dense, at = d.impulse.dense, impulse_at(d, k)
    for m in range(len(dense)):
        dense[m, k] = 0.0
    for i, (_, square, cube) in _DENSE:
        dense[1, k] -= h * (square + cube) * d.implicit.stage[i, at]
        dense[2, k] -= h * cube * d.implicit.stage[i, at]
    dense[0, k] = d.impulse.state_end[k] - d.impulse.state[k]


def dense_output(d, _h):
    """Make the dense output keep the clearances in between, too, at thirds of the last step.

    F₃ and F₄ of dense.py, with θ²(1−θ)² and θ³(1−θ)², leave its ends as they are.
    """
    dense, change = d.step.dense, d.implicit.stage[RIGHT, : coordinate_count(d.links)]
    if d.touch.active_count == 0:
        return
    for third in range(1, 3):
        interpolate(d.step, third / 3.0, d.work.y)
        locate_points(d, d.work.y)
        for derivative in range(2):
            for k in range(d.touch.active_count):
                at = rate_at(d, k) if derivative else gap_at(d, k)
                d.implicit.normal[k] = interpolated(d, at, third / 3.0)
            first = meet(d, derivative, change)
            for j in range(len(change)):
                d.implicit.thirds[third - 1, first + j] = change[j]
    for j in range(dissipated_at(d.links)):
        one, two = d.implicit.thirds[0, j], d.implicit.thirds[1, j]
        # 4/81 F₃ + 4/243 F₄ and 4/81 F₃ + 8/243 F₄ are to be the changes
        dense[4, j] = 243.0 / 4.0 * (two - one)
        dense[3, j] = 81.0 / 4.0 * one - dense[4, j] / 3.0


def interpolated(d, j, theta):
    """Component j of z at the fraction θ of the last step."""
    own, total = d.implicit, 0.0
    for i, (linear, square, cube) in _DENSE:
        total += theta * (linear + theta * (square + theta * cube)) * own.stage[i, j]
    return own.start[j] + d.step.size * total


def clearance_curvature(d, k):
    """Bound on |g̈| [m/s²] of the k-th active contact over the last step."""
    square, cube = 0.0, 0.0
    for i, (_, b, c) in _DENSE:
        g = d.implicit.stage[i, gap_at(d, k)]
        square += b * g
        cube += c * g
    # g = g₀ + h (c₁θ + c₂θ² + c₃θ³)
    return (2.0 * abs(square) + 6.0 * abs(cube)) / d.step.size


_DENSE = tuple(ros34pw2.DENSE.items())


def prepare(d, h):
    """Linearize for a step, and leave its size as it is."""
    linearize(d)
    return h


METHOD = Method(
    name="implicit",
    order=ros34pw2.ORDER,
    safety=0.9,
    rate_at_end=False,
    dense_evaluations=0,
    prepare=prepare,
    attempt=attempt,
    finish=finish,
    dense_output=dense_output,
)

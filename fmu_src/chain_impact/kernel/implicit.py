"""The linearly implicit step of order 3, for sustained contact (the method's data: ros34pw2.py).

A point resting on a stiff wall makes the equations stiff: the contact's own motions are far faster than the
chain's, and decay. Their part of the Jacobian has the rank of the active contacts,

    A = ∂ẏ/∂y ≈ [0, 1; −M⁻¹ Jᵀ k J, −M⁻¹ Jᵀ c J],   k = ∂F/∂δ,  c = ∂F/∂δ̇,  J the gradient of the clearances,

and all else may be left out of it, as the method keeps its order with any A. So a stage needs no linear
algebra but the recursion: (1 − hγA) x = r is solved by

    x_v = r_v − (M + Jᵀ D J)⁻¹ Jᵀ (D J r_v + hγ k J r_q),   x_q = r_q + hγ x_v,   D = hγ c + (hγ)² k,

the response of the chain to impulses at the touching points, with the contacts' impedance D added to the
articulated inertia there.

As the links turn, so does J, and a point at rest against a wall needs the acceleration −J̇ẏ to stay there.
This slow drift acts on the stiff contact. It enters as the time derivative of f does in a Rosenbrock method,
as an impulse hγ_i (c + hγ k) J̇ẏ in stage i; without it errors grow while links that touch turn.
"""

from chain_impact.kernel import ros34pw2
from chain_impact.kernel.combination import combination
from chain_impact.kernel.contact import across_wall, add_across_wall, contact_slopes, locate_points, zero
from chain_impact.kernel.dense import extend
from chain_impact.kernel.equations import state_rate
from chain_impact.kernel.errors import scaled_error
from chain_impact.kernel.jit import jit
from chain_impact.kernel.recursion import factorize, move_points, solve

GAMMA = ros34pw2.GAMMA_DIAGONAL
# rows of work.stage, where rows 1 to 4 are the stages k_i: f of the stage, s_i, right side, zeros
RATE, CORRECTION, RIGHT, ZEROS = 5, 6, 7, 8
STEP_EVALUATIONS = len(ros34pw2.B) - 1  # the first stage has f at the start of the step
EXPONENT = -1.0 / ros34pw2.ORDER


def _stage(i, rate, solve_shifted):
    """Compile stage i > 1 of the step from ``step.state_end``."""
    point = combination(ros34pw2.ALPHA[i])
    drift = GAMMA + sum(ros34pw2.GAMMA[i].values())
    correction = combination({j: g / GAMMA for j, g in ros34pw2.GAMMA[i].items()})

    @jit
    def stage(d, h):
        stages = d.work.stage
        point(d.work, d.step.state_end, h, d.work.y)
        rate(d, d.work.y, stages[RATE])
        # (1 − hγA)(k + s) = f + s + h γ_i ∂f/∂t
        correction(d.work, stages[ZEROS], 1.0, stages[CORRECTION])
        for j in range(len(d.work.y)):
            stages[RIGHT, j] = stages[RATE, j] + stages[CORRECTION, j]
        solve_shifted(d, h * GAMMA, h * drift, stages[RIGHT], stages[i])
        for j in range(len(d.work.y)):
            stages[i, j] -= stages[CORRECTION, j]

    return stage


def linearly_implicit(rate, solve_shifted):
    """Compile the stages and the result of a step for a right-hand side and its linear solver.

    Args:
        rate: compiled function (d, y, out) for out = f(y).
        solve_shifted: compiled function (d, hγ, hγ_i, r, x) for (1 − hγA) x = r + hγ_i ∂f/∂t.

    Returns:
        A compiled function (d, h): from ``step.state_end`` with its rate in row 0 of ``work.stage``, to the
        result in ``work.y``, the error estimate in row 0 of ``work.error``.
    """
    second, third, fourth = (_stage(i, rate, solve_shifted) for i in (2, 3, 4))
    result = combination(ros34pw2.B)
    difference = combination({i: b - ros34pw2.B_EMBEDDED[i] for i, b in ros34pw2.B.items()})

    @jit
    def step(d, h):
        for j in range(len(d.work.y)):
            d.work.stage[ZEROS, j] = 0.0  # the explicit method's stages share the rows
        solve_shifted(d, h * GAMMA, h * GAMMA, d.work.stage[0], d.work.stage[1])
        second(d, h)
        third(d, h)
        fourth(d, h)
        result(d.work, d.step.state_end, h, d.work.y)
        difference(d.work, d.work.stage[ZEROS], h, d.work.error[0])

    return step


@jit
def linearize(d):
    """Set the slopes of the contact forces, link vectors and drift J̇ẏ at the start of the step."""
    work, n = d.work, len(d.model.length)
    locate_points(d.model, d.step.state_end, work)
    zero(work.drift)
    for i in range(n):
        work.start_link.x[i] = work.link.x[i]
        work.start_link.y[i] = work.link.y[i]
        w2 = d.step.state_end[n + 4 + i] * d.step.state_end[n + 4 + i]
        work.drift.x[i + 1] = work.drift.x[i] - w2 * work.link.x[i]
        work.drift.y[i + 1] = work.drift.y[i] - w2 * work.link.y[i]
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        work.slope[c, 0], work.slope[c, 1] = contact_slopes(d, c)


@jit
def factorize_contacts(d, shift):
    """Eliminate M + Jᵀ D J for hγ = ``shift`` [s]."""
    zero(d.work.impedance)
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        # D = hγ c + (hγ)² k
        impedance = shift * (d.work.slope[c, 1] + shift * d.work.slope[c, 0])
        add_across_wall(d, c, d.work.impedance, impedance)
    factorize(d.model, d.work.start_link, d.work.impedance, d.work.factors)


@jit
def solve_contacts(d, shift, drift, right, x):
    """Solve (1 − hγA) x = r + hγ_i ∂f/∂t for hγ = ``shift`` and hγ_i = ``drift`` [s]."""
    n = len(d.model.length)
    work, links = d.work, d.work.start_link
    zero(work.impulse)
    # Jᵀ D J r_v
    move_points(links, right[n + 2 : n + 4], right[n + 4 : 2 * n + 4], work.motion)
    add_impulses(d, work.motion, shift, shift * shift)
    # Jᵀ hγ k J r_q
    move_points(links, right[0:2], right[2 : n + 2], work.motion)
    add_impulses(d, work.motion, 0.0, shift)
    # Jᵀ hγ_i (c + hγ k) J̇ẏ
    add_impulses(d, work.drift, drift, drift * shift)
    solve(links, work.factors, work.impulse, x[n + 2 : n + 4], x[n + 4 : 2 * n + 4])
    for j in range(n + 2):
        x[n + 2 + j] = right[n + 2 + j] - x[n + 2 + j]
        x[j] = right[j] + shift * x[n + 2 + j]
    x[2 * n + 4] = right[2 * n + 4]
    x[2 * n + 5] = right[2 * n + 5]


@jit
def add_impulses(d, motion, by_damping, by_stiffness):
    """Add (by_damping c + by_stiffness k) times the motion of each touching point along its normal."""
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        factor = by_damping * d.work.slope[c, 1] + by_stiffness * d.work.slope[c, 0]
        add_across_wall(d, c, d.work.impulse, factor * across_wall(d, c, motion))


_step = linearly_implicit(state_rate, solve_contacts)


@jit
def attempt(d, h):
    """Try a step of size h [s] from ``step.state_end``; the result stands in ``work.y``.

    Returns:
        The error relative to the tolerance: at most 1 for a step to accept; not finite when f was not.
    """
    linearize(d)
    factorize_contacts(d, h * GAMMA)
    _step(d, h)
    # the columns of the Jacobian count as evaluations
    d.statistics.rhs_evaluations += STEP_EVALUATIONS + d.touch.active_count
    locate_points(d.model, d.work.y, d.work)
    return scaled_error(d, 0)


@jit
def accept(d, h):
    """Make the step that was tried the last accepted one, with its dense output."""
    extend(d.step, h, d.work.y)
    dense, stages = d.step.dense, d.work.stage
    for j in range(len(d.work.y)):
        for m in range(len(dense)):
            dense[m, j] = 0.0
    for i, (_, square, cube) in _DENSE:
        for j in range(len(d.work.y)):
            # c₁θ + c₂θ² + c₃θ³ = θ(F₀ + (1−θ)(F₁ + θF₂)) with F₂ = −c₃, F₁ = −c₂−c₃, F₀ = c₁+c₂+c₃
            dense[1, j] -= h * (square + cube) * stages[i, j]
            dense[2, j] -= h * cube * stages[i, j]
    for j in range(len(d.work.y)):
        dense[0, j] = d.step.state_end[j] - d.step.state[j]


_DENSE = tuple(ros34pw2.DENSE.items())

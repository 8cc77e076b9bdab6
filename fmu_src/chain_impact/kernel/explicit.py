"""The explicit step of order 8, for flight and impact (the method's data: dop853.py)."""

import math

import numpy as np

from chain_impact.kernel import dop853
from chain_impact.kernel.contact import clearance, locate_points, normal_component
from chain_impact.kernel.equations import state_rate
from chain_impact.kernel.jit import jit

STAGES = len(dop853.A)
LAST = dop853.STEP_STAGES  # the stage at the end of the step
DENSE_COEFFICIENTS = 3 + len(dop853.D)
STEP_EVALUATIONS = LAST - 1  # new right-hand sides of a step that is then rejected …
DENSE_EVALUATIONS = STAGES - LAST  # … and what an accepted one needs on top


def _combination(row):
    """Compile ``out = base + h Σ_j row[j] k_j``, unrolled over the non-zero coefficients."""
    stages, coefficients = tuple(row), tuple(row.values())
    count = len(row)

    @jit
    def combine(d, base, h, out):
        for j in range(len(d.work.y)):
            total = 0.0
            for m in range(count):
                total += coefficients[m] * d.work.stage[stages[m], j]
            out[j] = base[j] + h * total

    return combine


def _stage(i, base):
    """Compile stage i of the step from the state base(d): the point, and the rate there."""
    combine = _combination(dop853.A[i])

    @jit
    def stage(d, h):
        combine(d, base(d), h, d.work.y)
        state_rate(d, d.work.y, d.work.stage[i])

    return stage


def _sequence(first, *others):
    """Compile the call of several functions of (d, h) in turn."""
    if not others:
        return first
    rest = _sequence(*others)

    @jit
    def both(d, h):
        first(d, h)
        rest(d, h)

    return both


# a step is tried from the end of the last one; once accepted, that is its start
_from_end = jit(lambda d: d.step.state_end)
_from_start = jit(lambda d: d.step.state)
_stages = _sequence(*(_stage(i, _from_end) for i in range(1, LAST)))
_step_end = _combination(dop853.B)
_dense_stages = _sequence(*(_stage(i, _from_start) for i in range(LAST + 1, STAGES)))
_error_5 = _combination(dop853.E5)
_error_3 = _combination(dop853.E3)
_high_0, _high_1, _high_2, _high_3 = (_combination(row) for row in dop853.D)


@jit
def attempt(d, h):
    """Try a step of size h [s] from ``step.state_end``; the result stands in ``work.y``.

    Returns:
        The error relative to the tolerance: at most 1 for a step to accept; not finite when f was not.
    """
    _stages(d, h)
    d.statistics.rhs_evaluations += STEP_EVALUATIONS
    _step_end(d, d.step.state_end, h, d.work.y)
    for j in range(len(d.work.y)):
        d.work.error[0, j] = 0.0
        d.work.error[1, j] = 0.0
    _error_5(d, d.work.error[0], 1.0, d.work.error[0])
    _error_3(d, d.work.error[1], 1.0, d.work.error[1])
    return h * error_norm(d)


@jit
def error_norm(d):
    """Largest scaled error of a component per unit step, for the result in ``work.y``.

    The scales, times the tolerance: 1 rad for angles and one link length for positions, whatever their
    value (turning or shifting the scene changes nothing); speeds relative to themselves plus one of these a
    second; and the penetration of every active contact relative to itself or to the depth expected of
    it, which may be a millionth of a link length. Energies follow and are not controlled.
    """
    n = len(d.model.length)
    size = d.model.size
    worst_5, worst_3 = 0.0, 0.0
    for j in range(2 * n + 4):
        if j < 2:
            scale = size
        elif j < n + 2:
            scale = 1.0
        elif j < n + 4:
            scale = size + abs(d.work.y[j])
        else:
            scale = 1.0 + abs(d.work.y[j])
        worst_5 = max(worst_5, abs(d.work.error[0, j]) / scale)
        worst_3 = max(worst_3, abs(d.work.error[1, j]) / scale)
        # a NaN is lost in max(): the sum keeps it
        if not math.isfinite(d.work.error[0, j] + d.work.y[j]):
            return math.inf
    if d.touch.active_count > 0:
        locate_points(d.model, d.work.y, d.work)
        for k in range(d.touch.active_count):
            c = d.touch.active_index[k]
            gap, _ = clearance(d, c)
            scale = max(d.touch.depth_scale[c], -gap)
            error_5, error_3 = d.work.error[0], d.work.error[1]
            worst_5 = max(worst_5, abs(normal_component(d, c, error_5[0:2], error_5[2 : n + 2])) / scale)
            worst_3 = max(worst_3, abs(normal_component(d, c, error_3[0:2], error_3[2 : n + 2])) / scale)
    if worst_5 == 0.0 and worst_3 == 0.0:
        return 0.0
    # e₅²/√(e₅² + e₃²/100): behaves as order 8 (Hairer, Nørsett, Wanner)
    return worst_5 * worst_5 / math.sqrt(worst_5 * worst_5 + 0.01 * worst_3 * worst_3) / d.solver.tolerance


@jit
def accept(d, h):
    """Make the step that was tried the last accepted one, with its dense output."""
    step = d.step
    for j in range(len(d.work.y)):
        step.state[j] = step.state_end[j]
        step.state_end[j] = d.work.y[j]
    state_rate(d, step.state_end, d.work.stage[LAST])
    _dense_stages(d, h)
    d.statistics.rhs_evaluations += 1 + DENSE_EVALUATIONS
    for j in range(len(d.work.y)):
        # the interpolant is y₀ + θ(F₀ + (1−θ)(F₁ + θ(F₂ + (1−θ)(F₃ + θ(F₄ + (1−θ)(F₅ + θ F₆))))))
        change = step.state_end[j] - step.state[j]
        step.dense[0, j] = change
        step.dense[1, j] = h * d.work.stage[0, j] - change
        step.dense[2, j] = 2.0 * change - h * (d.work.stage[LAST, j] + d.work.stage[0, j])
        for m in range(3, DENSE_COEFFICIENTS):
            step.dense[m, j] = 0.0
    _high_0(d, step.dense[3], h, step.dense[3])
    _high_1(d, step.dense[4], h, step.dense[4])
    _high_2(d, step.dense[5], h, step.dense[5])
    _high_3(d, step.dense[6], h, step.dense[6])
    step.start = step.end
    step.size = h
    step.end = step.start + h
    step.rate_known = 1


@jit
def interpolate(step, theta, y):
    """Set y to the state at the fraction θ ∈ [0, 1] of the last step."""
    rest = 1.0 - theta
    for j in range(len(step.state)):
        high = step.dense[4, j] + rest * (step.dense[5, j] + theta * step.dense[6, j])
        low = step.dense[2, j] + rest * (step.dense[3, j] + theta * high)
        y[j] = step.state[j] + theta * (step.dense[0, j] + rest * (step.dense[1, j] + theta * low))


def _basis_bounds():
    """Largest size on [0, 1] of the interpolant's basis functions and of their slopes."""
    theta = np.linspace(0.0, 1.0, 10001)
    rest = 1.0 - theta
    powers = [(1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 3)]
    values = [theta**p * rest**q for p, q in powers]
    slopes = [p * theta ** (p - 1) * rest**q - q * theta**p * rest ** max(q - 1, 0) for p, q in powers]
    return (
        tuple(float(np.abs(v).max()) for v in values),
        tuple(float(np.abs(s).max()) for s in slopes),
    )


BASIS_BOUND, SLOPE_BOUND = _basis_bounds()


@jit
def rate_bounds(step, j):
    """Bounds on |y_j| and |ẏ_j| over the last step, from the interpolant's coefficients."""
    value, slope = abs(step.state[j]), 0.0
    for m in range(DENSE_COEFFICIENTS):
        f = abs(step.dense[m, j])
        value += BASIS_BOUND[m] * f
        slope += SLOPE_BOUND[m] * f
    return value, slope / step.size

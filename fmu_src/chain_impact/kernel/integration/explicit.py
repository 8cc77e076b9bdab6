"""The explicit step of order 8, for flight and impact (the method's data: dop853.py)."""

import math

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.state import dissipated_at, sundman_u_at
from chain_impact.kernel.dispatch import sequence
from chain_impact.kernel.integration import dop853
from chain_impact.kernel.integration.control import conclude
from chain_impact.kernel.integration.errors import scaled_errors, set_gap_errors
from chain_impact.kernel.integration.quadratures import set_quadrature_stage, set_quadrature_stage_at_end
from chain_impact.kernel.integration.sundman import (
    NO_CONTACT,
    regularize,
    regularized_rate,
    root_curve,
    runs_back,
)
from chain_impact.kernel.model.friction import any_sticking
from chain_impact.kernel.model.geometry import clearance, gap_acceleration
from chain_impact.kernel.work_limit import count_evaluations

STAGES = len(dop853.A)
LAST = dop853.STEP_STAGES  # the stage at the end of the step
# A step is lengthened by up to STRETCH if it then passes the end of a contact, to BEYOND times the predicted
# length to the end: the prediction has an error of some hundredths. Otherwise the step covers at most half of
# this length, so that no tiny step remains.
BEYOND, STRETCH = 1.04, 1.2
# Of a step: a contact that ends within it has practically no force left, and its penetration may be
# round-off. The search for events finds its end, and a step up to there could be lost in the time.
LEFT = 1e-6
HALVE = 50.0  # an error that makes the next try of a method of order 8 half as long
HUGE = 1e100  # an error whose square could overflow
STEP_EVALUATIONS = LAST - 1  # new right-hand sides of a step, without the one at its end
DENSE_EVALUATIONS = STAGES - LAST  # those of the dense output


def combination(row):
    """Return a function for ``out = base + h Σ_j row[j] k_j``, unrolled over the stages j in the row.

    The function takes (stages, base, h, out), with the stages k_j the rows of ``stages``, which may
    be longer than ``base`` and ``out``.
    """
    names, coefficients = tuple(row), tuple(row.values())
    count = len(row)

    def combine(stages, base, h, out):
        for j in range(len(base)):
            total = 0.0
            for m in range(count):
                total += coefficients[m] * stages[names[m], j]
            out[j] = base[j] + h * total

    return combine


def combinations(one, two):
    """Return a function for the sums h Σ_j row[j] k_j of two rows, which reads each k_j once for both.

    The function takes (stages, h, first, second), the last two for the results.
    """
    names = tuple(sorted({*one, *two}))
    row_1, row_2 = (tuple(row.get(name, 0.0) for name in names) for row in (one, two))
    count = len(names)

    def combine(stages, h, first, second):
        for j in range(len(first)):
            total_1, total_2 = 0.0, 0.0
            for m in range(count):
                stage = stages[names[m], j]
                total_1 += row_1[m] * stage
                total_2 += row_2[m] * stage
            first[j], second[j] = h * total_1, h * total_2

    return combine


def _stage(i, accepted):
    """Return the function for stage i of a step: its state, and the rate there.

    A step is tried from ``state_end`` of the last one. Once it is ``accepted``, it starts at ``state``.
    """
    combine = combination(dop853.A[i])

    def stage(d, h):
        combine(d.work.stage, d.step.state if accepted else d.step.state_end, h, d.work.y)
        regularized_rate(d, d.work.y, d.work.stage[i])
        set_quadrature_stage(d, i)

    return stage


_stages = sequence(*(_stage(i, accepted=False) for i in range(1, LAST)))
_step_end = combination(dop853.B)
_dense_stages = sequence(*(_stage(i, accepted=True) for i in range(LAST + 1, STAGES)))
_errors = combinations(dop853.E5, dop853.E3)
_high_01, _high_23 = combinations(*dop853.D[:2]), combinations(*dop853.D[2:])


def toward_end(d, h):
    """The size of the next step if the error control allows h: it passes an end of contact that is near."""
    if d.touch.compliant_count == 0:
        return h
    if d.step.regularized == NO_CONTACT:
        return toward_ends(d, h)
    root = sundman_u_at(d.links)
    u, slope = d.step.state_end[root], d.work.stage[0, root]
    if u + 2.0 * slope * h >= 0.0:
        return h
    accelerate_points(d, d.step.state_end, d.work.rate_start)
    # u + u′ s + ½ u″ s² = 0
    square = slope * slope - 2.0 * u * root_curve(d, u, slope)
    left = 2.0 * u / (math.sqrt(max(0.0, square)) - slope)
    return up_to(h, left)


def toward_ends(d, h):
    """As ``toward_end``, where the variable is time: for the first end of a contact with a force."""
    accelerate_points(d, d.step.state_end, d.work.rate_start)
    left = math.inf
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        gap, gap_rate = clearance(d, c)
        if gap < 0.0 < gap_rate:
            # g + ġ t + ½ g̈ t² = 0
            square = gap_rate * gap_rate - 2.0 * gap * gap_acceleration(d, c)
            left = min(left, -2.0 * gap / (gap_rate + math.sqrt(max(0.0, square))))
    return up_to(h, left)


def up_to(h, left):
    """The size of a step, if the error control allows h and a contact is predicted to end after ``left``."""
    if left < LEFT * h:
        return h
    if BEYOND * left < STRETCH * h:
        return BEYOND * left
    return min(h, 0.5 * left)


def attempt(d, h):
    """Try a step of size h from ``step.state_end``."""
    make(d, h)
    count_evaluations(d, STEP_EVALUATIONS)
    conclude(d, HALVE if runs_back(d, d.trial.state) else estimate(d, h), 1.0)


def estimate(d, h):
    """The error of the tried step, relative to the tolerance; not finite if f was not."""
    controlled = dissipated_at(d.links) + 1
    _errors(d.work.stage, h, d.work.error[0, :controlled], d.work.error[1, :controlled])
    if d.touch.active_count > 0 or any_sticking(d):
        locate_points(d, d.trial.state)
    set_gap_errors(d, 0)
    set_gap_errors(d, 1)
    error_5, error_3 = scaled_errors(d)
    if error_5 == 0.0:
        return 0.0
    if max(error_5, error_3) > HUGE:
        return math.inf
    # e₅²/√(e₅² + e₃²/100): of order 8, as e₅/e₃ is of order 2 (Hairer, Nørsett, Wanner)
    ratio = error_5 / math.sqrt(error_5 * error_5 + 0.01 * error_3 * error_3)
    return error_5 * ratio * (math.sqrt(ratio) if is_smooth(d) else 1.0)


def is_smooth(d):
    """Whether the error of the step is of order 9, as in a regularized contact.

    The estimate of order 8 is kept as a margin in flight, and where a force rises so steeply, as a root of u,
    that the step loses its order.
    """
    c = d.step.regularized
    return c != NO_CONTACT and not 0.0 < d.law.rate_exponent[c] < 0.5


def make(d, h):
    """Make a step of size h from ``step.state_end``, without an estimate of its error."""
    _stages(d, h)
    _step_end(d.work.stage, d.step.state_end, h, d.trial.state)
    own, count = d.quadrature, d.quadrature.count
    if count > 0:
        _step_end(own.stage, own.state_end[:count], h, own.tried[:count])


def dense_output(d, h):
    """Set the dense output of the last step, of size h."""
    locate_points(d, d.step.state_end)
    regularize(d, d.step.state_end, d.work.rate_end, d.work.stage[LAST])
    set_quadrature_stage_at_end(d, LAST)
    _dense_stages(d, h)
    _interpolant(d.step, d.work.stage, len(d.work.y), h)
    if d.quadrature.count > 0:
        _interpolant(d.quadrature, d.quadrature.stage, d.quadrature.count, h)


def _interpolant(step, stages, count, h):
    """Set the dense output of the first components of a state, or of quadratures, from their stages."""
    for j in range(count):
        # the interpolant is y₀ + θ(F₀ + (1−θ)(F₁ + θ(F₂ + (1−θ)(F₃ + θ(F₄ + (1−θ)(F₅ + θ F₆))))))
        change = step.state_end[j] - step.state[j]
        step.dense[0, j] = change
        step.dense[1, j] = h * stages[0, j] - change
        step.dense[2, j] = 2.0 * change - h * (stages[LAST, j] + stages[0, j])
    _high_01(stages, h, step.dense[3, :count], step.dense[4, :count])
    _high_23(stages, h, step.dense[5, :count], step.dense[6, :count])

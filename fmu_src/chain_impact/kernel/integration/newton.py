"""The simplified Newton iteration of a collocation step, in increments u_i = z_i − z_0 of the stages.

The stages of a step of size h solve U = h Q F(z_0 + U). With A one approximate Jacobian for all of them, an
iteration solves (1 − h Q ⊗ A) ΔU = R, R = h Q F − U. In the eigenvectors of Q, W = LEFT · R, these become
systems (1 − h μ A) w = w', one for the real eigenvalue and one for each pair of complex ones; ΔU = RIGHT · W.

The terms that A leaves out cost iterations, but no accuracy: successive corrections fall by a factor θ of
about h |∂f/∂z − A|. The iteration has converged when the remaining error, θ/(1 − θ) of the last correction,
is a small part of the tolerance.
"""

import math

from chain_impact.kernel.dispatch import sequence
from chain_impact.kernel.integration.radau import LEFT, NODES, RIGHT, STAGES, Q

LEFT_Q = tuple(
    tuple(math.fsum(left * row[j] for left, row in zip(one, Q, strict=True)) for j in range(STAGES))
    for one in LEFT
)
ITERATIONS = 10  # at most: a slower iteration costs more than shorter steps
ENOUGH = 0.1  # of the tolerance: the error that the iteration may leave
DIVERGES = 0.95  # θ above which the iteration is given up
FARTHEST = 1e20  # times the tolerance: the iteration fails if a correction is larger
# θ/(1 − θ) of the last step predicts that of the next, as max(θ/(1 − θ), TRUST)^POWER to be cautious
TRUST, POWER = 0.02, 0.8
UNKNOWN = 1e10  # θ/(1 − θ), if it is not known


def _transformed(i):
    """Row i of LEFT · R."""
    of_rates, of_stages = LEFT_Q[i], LEFT[i]

    def transformed(d, h, size):
        own = d.implicit
        for j in range(size):
            rates, stages = 0.0, 0.0
            for m in range(STAGES):
                rates += of_rates[m] * own.rates[m, j]
                stages += of_stages[m] * own.stages[m, j]
            own.parts[i, j] = h * rates - stages

    return transformed


def _corrected(i):
    """Correct stage i by row i of RIGHT · W; note its largest weighted component."""
    row = RIGHT[i]

    def corrected(d, _h, size):
        own, worst, total = d.implicit, d.implicit.correction, 0.0
        for j in range(size):
            change = 0.0
            for m in range(STAGES):
                change += row[m] * own.parts[m, j]
            own.stages[i, j] += change
            change = abs(change) * own.weight[j]
            total += change
            worst = max(worst, change)
        # max() can hide a NaN, a sum cannot
        own.correction = worst if math.isfinite(total) else math.inf

    return corrected


_transform = sequence(*(_transformed(i) for i in range(STAGES)))
_correct = sequence(*(_corrected(i) for i in range(STAGES)))


def simplified_newton(begin, rate, linearize, factorize, solve):
    """Return the iteration for a right-hand side and its linear systems.

    Args:
        begin: function (d) that is called before the stages are evaluated.
        rate: function (d, z, elapsed, out) for out = f(z), ``elapsed`` [s] after the start of the step.
        linearize: function (d, z) that evaluates the slopes in A where f was evaluated just now.
        factorize: function (d, h) that factorizes the systems.
        solve: function (d, h, size) that solves them in place, r and x being the rows of ``implicit.parts``.

    Returns:
        Functions (d, h, size): one for the right-hand sides of an iteration, one that corrects the stages in
        ``implicit.stages`` by the solutions, and one that iterates the stages to the tolerance, and returns
        whether the iteration has converged.
    """

    def find_residuals(d, h, size):
        own = d.implicit
        begin(d)
        for i in range(STAGES):
            # the middle one comes last
            stage = (i + STAGES // 2 + 1) % STAGES
            for j in range(size):
                own.z[j] = own.start[j] + own.stages[stage, j]
            rate(d, own.z, h * NODES[stage], own.rates[stage])
        _transform(d, h, size)

    def correct_stages(d, h, size):
        d.implicit.correction = 0.0
        _correct(d, h, size)

    def converge(d, h, size):
        own = d.implicit
        ratio, before, theta = max(own.slowness, TRUST) ** POWER, 0.0, 0.0
        for k in range(1, ITERATIONS + 1):
            find_residuals(d, h, size)
            if k == 1:
                linearize(d, own.z)
                factorize(d, h)
            solve(d, h, size)
            correct_stages(d, h, size)
            own.iterations = k
            if not own.correction < FARTHEST:
                own.contraction = math.inf
                return False
            if k > 1:
                theta = own.correction / before if before > 0.0 else 0.0
                ratio = min(1.0, theta / (1.0 - theta)) if theta < 1.0 else 1.0
            before, own.contraction = own.correction, theta
            if ratio * own.correction <= ENOUGH:
                own.slowness = ratio if k > 1 else own.slowness
                return True
            left = theta ** (ITERATIONS - k) / (1.0 - theta) * own.correction if theta < 1.0 else math.inf
            # it diverges, or will not converge in time
            if k > 2 and (theta > DIVERGES or left > ENOUGH):
                return False
        return False

    return find_residuals, correct_stages, converge

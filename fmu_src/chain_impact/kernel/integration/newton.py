"""The simplified Newton iteration of a collocation step, in increments u_i = z_i − z_0 of the stages.

The stages of a step of size h solve U = h Q F(z_0 + U). With A one approximate Jacobian for all of them, an
iteration solves (1 − h Q ⊗ A) ΔU = R, R = h Q F − U. In the eigenvectors of Q, W = LEFT · R, that are systems
(1 − h μ A) w = w', one for the real eigenvalue and one for each pair of complex ones, and ΔU = RIGHT · W.

What A leaves out costs iterations, and no accuracy: successive corrections fall by a factor θ of about
h |∂f/∂z − A|. The iteration has converged when what is left, θ/(1 − θ) of the last correction, is a small
part of the tolerance.
"""

import math

from chain_impact.kernel.integration.combination import sequence
from chain_impact.kernel.integration.radau import LEFT, NODES, RIGHT, STAGES, Q

LEFT_Q = tuple(
    tuple(math.fsum(left * row[j] for left, row in zip(one, Q, strict=True)) for j in range(STAGES))
    for one in LEFT
)
ITERATIONS = 10  # at most: slower ones cost more than shorter steps
ENOUGH = 0.1  # of the tolerance: what the iteration may leave of the error
DIVERGES = 0.95  # θ from which on it is given up
FARTHEST = 1e20  # times the tolerance: a correction beyond it is none
# θ/(1 − θ) of the last step foretells that of the next, but no better than this, and less than it says
TRUST, POWER = 0.02, 0.8
UNKNOWN = 1e10  # θ/(1 − θ), where there is none


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
        # a NaN is lost in max(), but not in a sum
        own.correction = worst if math.isfinite(total) else math.inf

    return corrected


_transform = sequence(*(_transformed(i) for i in range(STAGES)))
_correct = sequence(*(_corrected(i) for i in range(STAGES)))


def simplified_newton(begin, rate, linearize, factorize, solve):
    """The iteration for a right-hand side and its linear systems.

    Args:
        begin: function (d) that is called before the stages are evaluated.
        rate: function (d, z, elapsed, out) for out = f(z), so long [s] after the start of the step.
        linearize: function (d, z) that takes the slopes of A where f was evaluated just now.
        factorize: function (d, h) that makes the systems ready.
        solve: function (d, h) that solves them in place, r and x being the rows of ``implicit.parts``.

    Returns:
        Functions (d, h, size): one that makes an iteration, and one that iterates the stages in
        ``implicit.stages`` to the tolerance, and returns whether that has come about.
    """

    def evaluate(d, h, size):
        own = d.implicit
        begin(d)
        for i in range(STAGES):
            # the middle one comes last
            stage = (i + STAGES // 2 + 1) % STAGES
            for j in range(size):
                own.z[j] = own.start[j] + own.stages[stage, j]
            rate(d, own.z, h * NODES[stage], own.rates[stage])

    def iterate(d, h, size):
        evaluate(d, h, size)
        correct(d, h, size)

    def correct(d, h, size):
        _transform(d, h, size)
        solve(d, h)
        d.implicit.correction = 0.0
        _correct(d, h, size)

    def converge(d, h, size):
        own = d.implicit
        ratio, before, theta = max(own.slowness, TRUST) ** POWER, 0.0, 0.0
        for k in range(1, ITERATIONS + 1):
            evaluate(d, h, size)
            if k == 1:
                linearize(d, own.z)
                factorize(d, h)
            correct(d, h, size)
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
            # it diverges, or will not come in time
            if k > 2 and (theta > DIVERGES or left > ENOUGH):
                return False
        return False

    return iterate, converge

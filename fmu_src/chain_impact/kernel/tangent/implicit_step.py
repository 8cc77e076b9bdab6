"""An implicit step in dual numbers: the same iteration, from the stages that d has found.

A is of no consequence for what the iteration converges to, so it is that of d. The derivatives of the
stages converge as the stages have, by the factor θ each time, but begin with what the last step foretells of
them. They are no part of the tolerance, so they are iterated further.
"""

import math

from chain_impact.kernel.integration.collocation import factorize, foretell, iterate, set_result
from chain_impact.kernel.integration.extended import compliant, extend_start, extended_size
from chain_impact.kernel.integration.projection import meet_clearances
from chain_impact.kernel.integration.radau import STAGES
from chain_impact.kernel.tangent.directions import carried

LEFT_OVER = 1e-9  # of what the derivatives of the stages are off at first
FEWEST, MOST = 3, 20  # iterations


def make_implicit(d, t, h):
    """Make the step of size h that d has made last; the result stands in ``work.y`` of t."""
    extend_start(t)
    size = extended_size(t)
    foretell(t, h, size)
    take_stages(d, t, size)
    take_slopes(d, t)
    factorize(t, h)
    for _ in range(iterations(d)):
        iterate(t, h, size)
        take_stages(d, t, size)
    set_result(t, h)
    if compliant(t) > 0:
        meet_clearances(t, t.implicit.z, t.work.y)


def take_stages(d, t, size):
    """Let the values of the stages be those of d."""
    for i in range(STAGES):
        for j in range(size):
            t.implicit.stages[i, j] = carried(d.implicit.last[i, j], 1.0, t.implicit.stages[i, j])


def take_slopes(d, t):
    """Let A be that of d."""
    one, own = d.implicit, t.implicit
    for i in range(d.links):
        own.link.x[i], own.link.y[i] = one.link.x[i], one.link.y[i]
    for k in range(d.touch.active_count):
        own.stiffness[k], own.damping[k] = one.stiffness[k], one.damping[k]


def iterations(d):
    """How many iterations the derivatives need, as fast as those of d have converged."""
    slowness = d.implicit.slowness
    # θ/(1 − θ)
    theta = min(0.5, max(1e-6, slowness / (1.0 + slowness)))
    return max(FEWEST, min(MOST, math.ceil(math.log(LEFT_OVER) / math.log(theta))))

"""An implicit step in dual numbers: the same iteration, started from the stages that d has found.

The result of the iteration does not depend on A, so each direction of the derivatives is solved for with the
linear systems of d, in its work space. The derivatives of the stages are
first extrapolated from the last step, and converge by a factor θ of their own: where d is at rest its
iteration converges at once, however long the step is, but that of the derivatives does not. So they are
iterated until they have converged themselves, relative to the state's derivatives in the same direction.
"""

import math

from chain_impact.kernel.chain.state import dissipated_at, velocity_at
from chain_impact.kernel.integration.collocation import (
    LAST,
    correct_stages,
    extrapolate_stages,
    find_residuals,
    set_residual,
    set_result,
    solve,
)
from chain_impact.kernel.integration.extended import compliant, extend_start, extended_size
from chain_impact.kernel.integration.linear_system import factorize_real
from chain_impact.kernel.integration.projection import project_clearances
from chain_impact.kernel.integration.radau import REAL_EIGENVALUE, STAGES
from chain_impact.kernel.model.compliance import mean_mass
from chain_impact.kernel.tangent.directions import DIRECTIONS, carried, slope, sloped
from chain_impact.kernel.tangent.trust import NO_IMPACT, NOT_SOLVED, TRUSTED, mark_untrusted

ENOUGH = 0.01  # of the tolerance: the largest last correction of the derivatives, relative to them
# The least correction has to fall by this factor within so many iterations. It may rise in between, as its
# direction changes. A correction that does not fall is round-off up to this relative value, else a failure.
FALLS, STALLED, ROUND_OFF = 0.7, 10, 1e-6
MOST = 100  # iterations: a θ of .8 reduces the error to some 1e-10
# Of the speed that the limits of static friction could give in the step: derivatives of the state that are
# less, with respect to what changes these limits only, are round-off.
LEAST = 1e-3
FAR_OFF = 1e300  # the relative correction if the derivatives are zero


def make_implicit(d, t, h):
    """Make the last step of d, of size h, in dual numbers; its end is the state of ``trial`` of t."""
    extend_start(t)
    size = extended_size(t)
    extrapolate_stages(t, h, size)
    take_stages(d, t, size)
    take_slopes(d, t)
    factorize_real(t, h * REAL_EIGENVALUE)
    # derivatives that have ended are not needed
    if t.trust.reason == TRUSTED and not iterate_slopes(d, t, h, size):
        mark_untrusted(t, NOT_SOLVED, NO_IMPACT, d.step.start)
    set_result(t, h)
    if compliant(t) > 0:
        project_clearances(t, t.implicit.z, t.trial.state)


def take_stages(d, t, size):
    """Set the values of the stages of t to those of d, and keep their derivatives."""
    for i in range(STAGES):
        for j in range(size):
            t.implicit.stages[i, j] = carried(d.implicit.last[i, j], 1.0, t.implicit.stages[i, j])


def take_slopes(d, t):
    """Set the data of A in t to those of d."""
    one, own = d.implicit, t.implicit
    for i in range(d.links):
        own.link.x[i], own.link.y[i] = one.link.x[i], one.link.y[i]
    for k in range(d.touch.active_count):
        own.stiffness[k], own.damping[k] = one.stiffness[k], one.damping[k]


def iterate_slopes(d, t, h, size):
    """Iterate the derivatives of the stages; returns whether they have converged."""
    least, stalled = math.inf, 0
    for _ in range(MOST):
        find_residuals(t, h, size)
        solve_slopes(d, t, h, size)
        correct_stages(t, h, size)
        take_stages(d, t, size)
        correction = last_correction(d, t, size)
        if correction <= ENOUGH * d.solver.tolerance:
            return True
        stalled += 1
        if correction < FALLS * least:
            least, stalled = correction, 0
        if stalled == STALLED:
            return correction <= ROUND_OFF
    return False


def solve_slopes(d, t, h, size):
    """Solve the linear systems of the step for the derivatives of its residuals, in place."""
    for k in range(DIRECTIONS):
        for i in range(STAGES):
            for j in range(size):
                set_residual(d, i, j, slope(t.implicit.parts[i, j], k))
        solve(d, h, size)
        for i in range(STAGES):
            for j in range(size):
                t.implicit.parts[i, j] = sloped(t.implicit.parts[i, j], k, d.implicit.parts[i, j])


def last_correction(d, t, size):
    """The last correction of the derivatives over those at the end of the step, in the worst direction."""
    own, weight, worst = t.implicit, d.implicit.weight, 0.0
    for k in range(DIRECTIONS):
        largest, whole, total = 0.0, LEAST * speed_by_friction(d, t, k), 0.0
        for j in range(size):
            whole = max(whole, weight[j] * abs(slope(own.start[j] + own.stages[LAST, j], k)))
            for i in range(STAGES):
                part = weight[j] * abs(slope(own.parts[i, j], k))
                largest = max(largest, part)
                total += part  # a NaN would be lost in the maximum
        if not math.isfinite(total + whole):
            return FAR_OFF
        if largest > worst * whole:
            worst = largest / whole if whole > 0.0 else FAR_OFF
    return worst


def speed_by_friction(d, t, direction):
    """The weighted derivative of a speed in a direction if the limits of what sticks acted in the step."""
    force, weight = 0.0, 0.0
    if d.friction.stuck_count == 0:
        return 0.0
    for i in range(d.friction.stuck_count):
        force = max(force, abs(slope(t.element.limit[d.element.stuck[i]], direction)))
    for j in range(velocity_at(d.links), dissipated_at(d.links)):
        weight = max(weight, d.implicit.weight[j])
    return force * d.step.size * weight / mean_mass(d)

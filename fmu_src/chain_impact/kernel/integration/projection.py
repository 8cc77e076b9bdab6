"""The coordinates of an implicit step, projected onto the clearances that are integrated with them.

The two differ by little, but on a stiff wall this would act as an impact. The difference before the
projection counts as an error of the step.
"""

from chain_impact.kernel.chain.elimination import SHIFTED
from chain_impact.kernel.chain.state import coordinate_count, velocity_at
from chain_impact.kernel.integration.extended import compliant, gap_at, rate_at
from chain_impact.kernel.integration.linear_system import contact_impedance
from chain_impact.kernel.model.compliance import solve_space
from chain_impact.kernel.model.geometry import (
    add_along,
    clear_loads_of,
    clearance,
    normal,
)

# Of a penetration: the allowed difference in a step between the coordinates and the clearance integrated with
# them. A larger value gives the interpolant of the state an error of this size; a smaller one limits the step
# where links turn on a stiff wall.
APART = 0.03


def project_coordinates(d, y, derivative, change):
    """Move the coordinates in y (for derivative 1: velocities) to the clearances (rates) in ``normal``.

    The points must be located for y. The ``change``, shape (N+2,), is a result.
    """
    own, first = d.implicit, derivative * velocity_at(d.links)
    clear_loads_of(d, d.work.load)
    for k in range(compliant(d)):
        c = d.touch.active_index[k]
        gap, gap_rate = clearance(d, c)
        impulse = contact_impedance(d, k, own.shift) * (own.normal[k] - (gap_rate if derivative else gap))
        add_along(normal(d, c), d.work.load, impulse)
    solve_space(d, own.link, d.work, SHIFTED, change)
    for j in range(coordinate_count(d.links)):
        y[first + j] += change[j]


def project_clearances(d, z, y):
    """Move y, whose points are located, to the clearances and rates in z.

    Returns:
        The largest weighted change, over the tolerance, and the difference between the coordinates and the
        clearances before it, relative to the allowed one.
    """
    own, change, worst = d.implicit, d.work.change, 0.0
    apart = largest_mismatch(d, z) / APART
    for derivative in range(2):
        for k in range(compliant(d)):
            own.normal[k] = z[rate_at(d, k) if derivative else gap_at(d, k)]
        project_coordinates(d, y, derivative, change)
        for j in range(coordinate_count(d.links)):
            worst = max(worst, abs(change[j]) * own.weight[derivative * velocity_at(d.links) + j])
    return worst, apart


def largest_mismatch(d, z):
    """The largest difference between located and integrated clearances, relative to the penetration."""
    worst = 0.0
    for k in range(compliant(d)):
        c = d.touch.active_index[k]
        gap, _ = clearance(d, c)
        depth = max(d.touch.depth_scale[c], -gap)
        worst = max(worst, abs(z[gap_at(d, k)] - gap) / depth)
    return worst

"""The force on a contact that sticks alone: the recursion that found the accelerations answers it, too.

It costs one more response of the chain. The constraints of constraints.py take several in general, and two
eliminations of their own.
"""

from chain_impact.kernel.chain.kinematics import accelerate_points
from chain_impact.kernel.chain.recursion import set_middle, solve
from chain_impact.kernel.chain.state import coordinate_count, velocity_at
from chain_impact.kernel.model.compliance import held_mobility
from chain_impact.kernel.model.geometry import (
    add_along,
    clear_loads_of,
    tangent,
    tangential_acceleration,
)


def sticks_alone(d):
    """Whether one contact with a force is all that sticks, and no rigid wall holds a point."""
    rigid = d.touch.active_count - d.touch.compliant_count
    return d.friction.stuck_count == 1 and d.friction.stuck_joints == 0 and rigid == 0


def add_sticking_force(d, y, rate):
    """As ``add_constraint_forces`` in holding.py, for a contact that ``sticks_alone``; returns its force.

    ``rate`` must be what ``accelerations`` has found last.
    """
    own, e, kept = d.rigid, d.element.stuck[0], d.work.elimination
    accelerate_points(d, y, rate)
    clear_loads_of(d, d.work.load)
    add_along(tangent(d, e), d.work.load, 1.0)
    set_middle(d, kept, kept.middle_xx, kept.middle_xy, kept.middle_yy)
    mobility = held_mobility(d, solve(d, d.work.link, kept, d.work.load, own.change))
    # λ = −a_t/W_tt
    force = -tangential_acceleration(d, e) / mobility
    for j in range(coordinate_count(d.links)):
        rate[velocity_at(d.links) + j] += force * own.change[j]
    return force

"""Forces of constraints within a step near a fold, where equal links lie on each other.

At a fold the mobility W of what constraints hold passes through 0. A force p = m/W may have a limit there,
but m also contains the error of the state, so close to the fold the error of p has any size. The motion
depends on W p only, and is right. A force in a row of outputs therefore follows from forces some way before
and after the row, if these show that the force passes the fold smoothly. A force that grows without bound
toward the fold is kept, because it is far larger than its error.
"""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import velocity_at
from chain_impact.kernel.equations import rate_and_points_from_state, true_rate_from_inputs
from chain_impact.kernel.forces.holding import add_change, keep_forces
from chain_impact.kernel.forces.inputs import ensure_inputs
from chain_impact.kernel.ode.dense import interpolate
from chain_impact.kernel.rows.constraints import replace_impulses
from chain_impact.kernel.rows.geometry import constraint_rows

# The least and the largest distance from a row, as a part of the step, at which the mobility is looked for
# that needs no larger impedance, and the distance of the forces relative to it. Closer forces would contain
# more of the error.
LEAST_OFFSET, LARGEST_OFFSET, WIDER = 2.0**-12, 2.0**-4, 4.0
# The four places of the forces in units of their distance, and the weights of the forces in the value of a
# cubic in the middle, and in a difference that is 0 for such a polynomial without its cubic term. A part c/ε
# of the force, with the distance ε from the fold, changes the difference by about 3 c over the distance.
OFFSETS, VALUE, DIFFERENCE = (-2.0, -1.0, 1.0, 2.0), (-1 / 6, 2 / 3, 2 / 3, -1 / 6), (-1.0, 2.0, -2.0, 1.0)
UNEVEN = 1e-3  # the largest such difference of a smooth force, relative to the largest force


def refine_rate(d, theta, y, rate):
    """Improve a rate ẏ at the fraction θ of the last step near a fold, and the forces of the constraints.

    The rate must have just been evaluated. Away from folds the function does nothing.
    """
    if d.constraints.raised == 0:
        return
    distance = LEAST_OFFSET
    while distance <= LARGEST_OFFSET and not leaves_fold(d, theta, distance, y, rate):
        distance *= 2.0
    smooth = distance <= LARGEST_OFFSET and find_forces(d, theta, WIDER * distance, y, rate)
    interpolate(d.step, theta, y)
    locate_points(d, y)
    ensure_inputs(d, y)
    true_rate_from_inputs(d, y, rate)
    if smooth:
        replace_impulses(d, d.constraints.refined)
        add_change(d, rate, velocity_at(d.links))
        keep_forces(d)


def leaves_fold(d, theta, distance, y, rate):
    """Return whether the places at a distance from θ are so far from the fold that forces are found there."""
    for side in range(2):
        interpolate(d.step, theta + (2 * side - 1) * distance, y)
        rate_and_points_from_state(d, y, rate)
        if d.constraints.raised > 0:
            return False
    return True


def find_forces(d, theta, distance, y, rate):
    """Set ``refined`` to the forces at θ that follow from four places; return whether they are smooth."""
    constraints, rows, largest, uneven = d.constraints, constraint_rows(d), 0.0, 0.0
    for k in range(rows):
        constraints.refined[k], constraints.uneven[k] = 0.0, 0.0
    for i in range(len(OFFSETS)):
        interpolate(d.step, theta + OFFSETS[i] * distance, y)
        rate_and_points_from_state(d, y, rate)
        for k in range(rows):
            constraints.refined[k] += VALUE[i] * constraints.impulse[k]
            constraints.uneven[k] += DIFFERENCE[i] * constraints.impulse[k]
    for k in range(rows):
        largest = max(largest, abs(constraints.refined[k]))
        uneven = max(uneven, abs(constraints.uneven[k]))
    return uneven <= UNEVEN * largest

"""Forces of constraints near a fold, where equal links lie on each other: a correction for outputs.

At a fold the mobility W of the held points, the acceleration per force, passes through 0. The constraint
force p = m/W may have a limit there, but the numerator m also contains the error of the state, so close to
the fold the error of p has any size. The motion depends on W p only, and stays right. For outputs near a
fold, a force is therefore computed from the forces some time before and after, if these show that the force
passes the fold smoothly. A force that grows without bound toward the fold is left unchanged, because it is
far larger than its error. Other toggle positions, where W is small, are treated in the same way.
"""

from chain_impact.kernel.chain.inputs import ensure_inputs
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import velocity_at
from chain_impact.kernel.cost import count_evaluations
from chain_impact.kernel.equations import rate_from_state, true_rate_from_inputs
from chain_impact.kernel.forces.holding import add_change, store_constraint_forces
from chain_impact.kernel.ode.dense import interpolate
from chain_impact.kernel.rows.constraints import any_point_held, replace_impulses
from chain_impact.kernel.rows.geometry import constraint_count

# The least and the largest time from an output to the two nearer samples of a force, relative to the step.
# Samples may lie outside the step, the farther ones by up to half its size: there the dense output is
# extrapolated, and an event at the end of the step has no effect on it.
LEAST_DISTANCE, LARGEST_DISTANCE = 2.0**-10, 2.0**-2
# OFFSETS: the times of the four samples of a force, relative to the output's time, in units of their
# distance. VALUE: the weights of the four forces with which a cubic polynomial through them gives the force
# at the output. DIFFERENCE: weights with which the sum of the four forces is 0 for a polynomial of degree 2.
# A part c/ε of the force, with the time ε since the fold, makes this sum about −3 c divided by the distance
# of the samples.
OFFSETS, VALUE, DIFFERENCE = (-1.0, 1.0, -2.0, 2.0), (2 / 3, 2 / 3, -1 / 6, -1 / 6), (2.0, -2.0, -1.0, 1.0)
# The forces of constraints pass a fold smoothly if the sum of the four samples of each force, with the
# weights DIFFERENCE, has a size of at most UNEVEN times the largest of all forces that VALUE gives at the
# output.
UNEVEN = 1e-3


def refine_rate(d, theta, y, rate):
    """Improve the rate ẏ of state y at the fraction θ of the last step, and the forces of constraints.

    The rate must have just been evaluated. The function acts only near a fold or another toggle position.
    There the rate is evaluated again with the true forces of contacts: a step uses beyond the kink of a force
    the smooth continuation of this force.
    """
    if not any_point_held(d) or d.constraints.near_fold == 0:
        return
    distance, found = LEAST_DISTANCE, False
    while distance <= LARGEST_DISTANCE and not found:
        found = find_forces(d, theta, distance, rate)
        distance *= 2.0
    smooth = found and passes_smoothly(d)
    locate_points(d, y)
    ensure_inputs(d, y)
    true_rate_from_inputs(d, y, rate)
    count_evaluations(d, 1)
    if smooth:
        replace_impulses(d, d.constraints.refined)
        add_change(d, rate, velocity_at(d.links))
        store_constraint_forces(d)


def find_forces(d, theta, distance, rate):
    """Compute the forces of constraints at the fraction θ of the last step from four samples at other times.

    ``distance`` is the distance of the two nearer samples from θ, relative to the step; ``rate`` is
    overwritten. The forces are stored in ``refined``, and their sums with the weights DIFFERENCE in
    ``uneven``. Return whether all samples are far enough from the fold; if one is near the fold, ``refined``
    is meaningless.
    """
    constraints, y = d.constraints, d.scratch.nearby
    for k in range(constraint_count(d)):
        constraints.refined[k], constraints.uneven[k] = 0.0, 0.0
    for i in range(len(OFFSETS)):
        interpolate(d.step, theta + OFFSETS[i] * distance, y)
        rate_from_state(d, y, rate)
        count_evaluations(d, 1)
        if constraints.near_fold > 0:
            return False
        for k in range(constraint_count(d)):
            constraints.refined[k] += VALUE[i] * constraints.impulse[k]
            constraints.uneven[k] += DIFFERENCE[i] * constraints.impulse[k]
    return True


def passes_smoothly(d):
    """Return whether the four samples of each force show that the forces pass the fold smoothly (UNEVEN)."""
    constraints, largest, uneven = d.constraints, 0.0, 0.0
    for k in range(constraint_count(d)):
        largest = max(largest, abs(constraints.refined[k]))
        uneven = max(uneven, abs(constraints.uneven[k]))
    return uneven <= UNEVEN * largest

"""Forces of constraints near a fold, where equal links lie on each other: a correction for outputs and peaks.

At a fold the mobility W of a held point, the acceleration per force, is 0. The constraint force p = m/W may
be finite there, but the numerator m also contains the error of the state, so the error of p grows without
bound toward the fold. The motion depends on W p only, and stays right. For outputs and peaks near a fold, a
force is therefore computed from the forces some time before and after, if these show that the force passes
the fold smoothly. A force that itself grows without bound toward the fold is left unchanged, because it is
far larger than its error. Other toggle positions, where W is small, are treated in the same way.
"""

from chain_impact.kernel.chain.inputs import ensure_inputs
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.geometry import constraint_count
from chain_impact.kernel.constraints.impulses import any_point_held, replace_impulses
from chain_impact.kernel.cost import count_evaluations
from chain_impact.kernel.equations import rate_from_state, true_rate_from_inputs
from chain_impact.kernel.forces.holding import add_change, store_constraint_forces
from chain_impact.kernel.ode.dense_output import interpolate_state
from chain_impact.kernel.record.state import velocity_at

# The least and the largest time from an output to each of the two nearer samples of a force, relative to the
# step. Samples may lie outside the step, the farther ones by up to half the step's size: there the dense
# output is extrapolated, as if no event ended the step.
LEAST_DISTANCE, LARGEST_DISTANCE = 2.0**-10, 2.0**-2
# the times of the four samples of a force, counted from the output's time, in units of the time to the nearer
# samples
SAMPLE_OFFSETS = (-1.0, 1.0, -2.0, 2.0)
# the weights of the four forces with which a cubic polynomial through them gives the force at the output
VALUE_WEIGHTS = (2 / 3, 2 / 3, -1 / 6, -1 / 6)
# Weights with which the sum of the four forces is 0 for a polynomial of degree 2. A part c/ε of the force,
# with the time ε since the fold, makes this sum about −3 c divided by the time to the nearer samples.
DIFFERENCE_WEIGHTS = (2.0, -2.0, -1.0, 1.0)
# The forces of constraints pass a fold smoothly if the sum of the four samples of each force, with the
# weights DIFFERENCE_WEIGHTS, has a size of at most UNEVEN_PART times the largest of all forces that
# VALUE_WEIGHTS gives at the output.
UNEVEN_PART = 1e-3


def correct_near_fold(d, theta, y, rate):
    """Correct ``rate``, ẏ of state y at the fraction θ of the last step, and constraint forces near a fold.

    Before the call, ``rate`` and the forces must have been evaluated for y. If y is not near a fold or
    another toggle position, nothing changes. Otherwise ``rate`` is evaluated again, with contact forces that
    are cut off at 0; if the constraint forces pass the fold smoothly, the forces that ``interpolate_forces``
    gives replace the evaluated constraint forces, and ``rate`` gets the accelerations that belong to these
    forces.
    """
    if not any_point_held(d) or d.constraints.near_fold == 0:
        return
    distance, has_forces = LEAST_DISTANCE, False
    while distance <= LARGEST_DISTANCE and not has_forces:
        has_forces = interpolate_forces(d, theta, distance, rate)
        distance *= 2.0
    is_smooth = has_forces and passes_smoothly(d)
    locate_points(d, y)
    ensure_inputs(d, y)
    true_rate_from_inputs(d, y, rate)
    count_evaluations(d, 1)
    if is_smooth:
        replace_impulses(d, d.constraints.refined_force)
        add_change(d, rate, velocity_at(d.link_count))
        store_constraint_forces(d)


def interpolate_forces(d, theta, distance, rate):
    """Compute the forces of constraints at the fraction θ of the last step from four samples at other times.

    ``distance`` is the distance of the two nearer samples from θ, relative to the step; ``rate`` is
    overwritten. The forces at θ are stored in ``refined_force``, and the sums of the four samples with the
    weights DIFFERENCE_WEIGHTS in ``force_difference``. Return whether all samples are far enough from the
    fold; if not, ``refined_force`` and ``force_difference`` are meaningless.
    """
    constraints, y = d.constraints, d.scratch.nearby
    for k in range(constraint_count(d)):
        constraints.refined_force[k], constraints.force_difference[k] = 0.0, 0.0
    for i in range(len(SAMPLE_OFFSETS)):
        interpolate_state(d.step, theta + SAMPLE_OFFSETS[i] * distance, y)
        rate_from_state(d, y, rate)
        count_evaluations(d, 1)
        if constraints.near_fold > 0:
            return False
        for k in range(constraint_count(d)):
            constraints.refined_force[k] += VALUE_WEIGHTS[i] * constraints.impulse[k]
            constraints.force_difference[k] += DIFFERENCE_WEIGHTS[i] * constraints.impulse[k]
    return True


def passes_smoothly(d):
    """Return whether the samples of ``interpolate_forces`` show that all forces pass the fold smoothly."""
    constraints, largest_force, largest_difference = d.constraints, 0.0, 0.0
    for k in range(constraint_count(d)):
        largest_force = max(largest_force, abs(constraints.refined_force[k]))
        largest_difference = max(largest_difference, abs(constraints.force_difference[k]))
    return largest_difference <= UNEVEN_PART * largest_force

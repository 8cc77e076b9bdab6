"""The energy that dry friction dissipates in an implicit step: the work along the motion that was found.

The last iteration corrects the motion after the rates have been evaluated. At rest the corrections are larger
than the motion itself, and the force of friction stays large although the speed is zero. Without this module,
the work of friction along the corrections would be an error of the energy balance that grows in every step.
"""

from chain_impact.kernel.chain.kinematics import locate_points_now, move_points
from chain_impact.kernel.chain.state import coordinate_count, dissipated_at, sundman_u_at
from chain_impact.kernel.forces.friction import STICKS, work_of_friction
from chain_impact.kernel.forces.inputs import set_inputs
from chain_impact.kernel.ode.radau import NODES, RADAU_STAGES, Q
from chain_impact.kernel.rows.geometry import along, any_sticking, tangent


def settle_friction(d, h):
    """Correct the dissipated energy in the stages of a step of size h [s], whose iteration has converged."""
    for i in range(RADAU_STAGES):
        d.implicit.stages[i, dissipated_at(d.links)] -= work_of_correction(d, h, i)
    if any_sticking(d):
        settle_holding(d, h)


def work_of_correction(d, h, i):
    """Return the work [J] of sliding friction along the part of stage i that the rates do not contain."""
    implicit, work, change = d.implicit, 0.0, d.work.change
    for j in range(coordinate_count(d.links)):
        by_rates = 0.0
        for m in range(RADAU_STAGES):
            by_rates += Q[i][m] * implicit.rates[m, j]
        change[j] = implicit.stages[i, j] - h * by_rates
    move_points(d, d.work.link, change, d.work.motion)
    for k in range(d.friction.count):
        e = d.element.index[k]
        if d.element.mode[e] != STICKS:
            work += d.element.force[e] * along(tangent(d, e), d.work.motion)
    return work


def settle_holding(d, h):
    """Count the work of sticking elements in the stages, whose motions from their anchors are errors.

    Where the step ends, a projection moves the elements back to their anchors, with the opposite work.
    """
    implicit = d.implicit
    before = holding_at(d, implicit.start, 0.0)
    for i in range(RADAU_STAGES):
        for j in range(sundman_u_at(d.links)):
            implicit.z[j] = implicit.start[j] + implicit.stages[i, j]
        implicit.stages[i, dissipated_at(d.links)] -= holding_at(d, implicit.z, h * NODES[i]) - before


def holding_at(d, z, elapsed):
    """Return the work [J] of the sticking elements in state z, ``elapsed`` [s] after a step's start."""
    if d.channels > 0:
        set_inputs(d, d.step.clock + elapsed)
    locate_points_now(d, z)
    return work_of_friction(d, True)

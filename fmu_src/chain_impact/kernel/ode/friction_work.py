"""The energy that dry friction dissipates in a step: the work along the step's final motion.

The last iteration of an implicit step corrects the motion after the rates have been evaluated; and round-off
and the projection onto constraints change the end of any step. At rest these changes are larger than the
motion itself, and the force of friction stays large although the speed is zero. Without this module, the work
of friction along these changes would be an error of the energy balance that grows in every step.
"""

from chain_impact.kernel.chain.inputs import set_inputs
from chain_impact.kernel.chain.kinematics import locate_points_now, move_points
from chain_impact.kernel.chain.state import coordinate_count, dissipated_at, sundman_u_at, velocity_at
from chain_impact.kernel.forces.friction import STICKS, work_of_holding
from chain_impact.kernel.ode import explicit
from chain_impact.kernel.ode.control import IMPLICIT
from chain_impact.kernel.ode.radau import NODES, RADAU_STAGES, Q
from chain_impact.kernel.rows.geometry import along, any_sticking, tangent_row


def store_friction_forces(d, stage):
    """Store the forces of dry friction at a stage of an implicit step, where the rate was just evaluated."""
    for k in range(d.friction.count):
        e = d.element.index[k]
        d.implicit.friction[stage, e] = d.element.force[e]


def correct_friction_energy(d, h):
    """Correct the dissipated energy in the stages of a step of size h [s] after the last iteration."""
    for m in range(RADAU_STAGES if d.friction.count > d.friction.stuck_count else 0):
        power = power_of_correction(d, m)
        for i in range(RADAU_STAGES):
            d.implicit.stages[i, dissipated_at(d.links)] -= h * Q[i][m] * power
    if any_sticking(d):
        count_holding_work(d, h)


def power_of_correction(d, m):
    """Return the power [W] of sliding friction at stage m, for the speeds that the last iteration added.

    The force is that of the evaluated rate. At rest the speeds in this rate may be far larger than the
    corrected speeds; the excess of their work is only taken back if the force is the same.
    """
    implicit, change, first = d.implicit, d.scratch.change, velocity_at(d.links)
    for j in range(coordinate_count(d.links)):
        change[j] = implicit.start[first + j] + implicit.stages[m, first + j] - implicit.rates[m, j]
    return work_of_sliding(d, change, implicit.friction[m])


def uncounted_work(d):
    """Return the work [J] of dry friction along the part of the tried step that is not counted yet.

    In an implicit step, the work up to the last stage is already counted. The points must be located at the
    end.
    """
    change, y, z = d.scratch.change, d.trial.state, d.implicit.z
    for j in range(coordinate_count(d.links)):
        if d.step.method == IMPLICIT:
            change[j] = y[j] - z[j]
        else:
            change[j] = (y[j] - d.step.state_end[j]) - explicit.step_increment(d, j)
    if d.step.method != IMPLICIT:
        return work_along(d, change)
    # the work of sticking elements follows from their positions, so the round-off of these cancels here
    work = work_of_sliding(d, change, d.element.force) + work_of_holding(d)
    work -= holding_at(d, z, d.trial.size)
    locate_points_now(d, y)
    return work


def change_in_step(d, j):
    """Return the change of component j of y in the tried step, without the round-off of the sum with y."""
    if d.step.method == IMPLICIT:
        return d.implicit.stages[RADAU_STAGES - 1, j]
    return explicit.step_increment(d, j)


def work_along(d, change):
    """Return the work [J] of dry friction along a change of the coordinates, for the located points."""
    work = work_of_sliding(d, change, d.element.force)
    for k in range(d.friction.stuck_count):
        e = d.element.stuck[k]
        work += d.element.force[e] * along(tangent_row(d, e), d.scratch.motion)
    return work


def work_of_sliding(d, change, force):
    """Return the work [J] of the given forces of the sliding elements along a change of the coordinates.

    The function also sets the motion of all places. If the change is a velocity, the result is a power [W].
    """
    work = 0.0
    move_points(d, d.scratch.link, change, d.scratch.motion)
    for k in range(d.friction.count):
        e = d.element.index[k]
        if d.element.mode[e] != STICKS:
            work += force[e] * along(tangent_row(d, e), d.scratch.motion)
    return work


def count_holding_work(d, h):
    """Count the work of the sticking elements since the start of the step as dissipated, in every stage.

    Sticking elements should not move: small motions away from their anchors are errors. At the end of the
    step a projection moves the elements back to their anchors, and does the opposite work.
    """
    implicit = d.implicit
    before = holding_at(d, implicit.start, 0.0)
    for i in range(RADAU_STAGES):
        for j in range(sundman_u_at(d.links)):
            implicit.z[j] = implicit.start[j] + implicit.stages[i, j]
        implicit.stages[i, dissipated_at(d.links)] -= holding_at(d, implicit.z, h * NODES[i]) - before


def holding_at(d, z, elapsed):
    """Return ``work_of_holding`` [J] for the extended state z, ``elapsed`` [s] after the start of a step."""
    if d.channels > 0:
        set_inputs(d, d.step.clock + elapsed)
    locate_points_now(d, z)
    return work_of_holding(d)

"""The energy that dry friction dissipates in a step: the work of friction along the step's final motion.

The rates of a step contain the power of friction. But two corrections change the motion of the step after its
rates have been evaluated. The first is the last iteration of an implicit step. The second is made at the end
of any step: round-off and the projection onto constraints. In a chain at rest these corrections may be larger
than the motion itself, and friction forces stay large although the speed is zero. If the work of friction
along the corrections were not counted, the energy balance would have an error that grows in every step.
"""

from chain_impact.kernel.chain.inputs import set_inputs
from chain_impact.kernel.chain.kinematics import locate_points_now, move_points
from chain_impact.kernel.constraints.geometry import dot, has_sticking, tangent_row
from chain_impact.kernel.forces.friction import work_of_holding
from chain_impact.kernel.ode import explicit
from chain_impact.kernel.ode.radau import RADAU_NODES, Q
from chain_impact.kernel.record.constants import RADAU_STAGES, STICKS
from chain_impact.kernel.record.method import is_implicit
from chain_impact.kernel.record.state import coordinate_count, dissipated_at, sundman_u_at, velocity_at


def store_friction_forces(d, stage):
    """Store the present forces of dry friction as those at a ``stage`` of an implicit step."""
    for k in range(d.friction.active_count):
        e = d.friction_element.index[k]
        d.implicit.friction_force[stage, e] = d.friction_element.force[e]


def correct_friction_energy(d, h):
    """Correct the dissipated energy of each stage for the last iteration of an implicit step of size h [s].

    The work that sliding friction does along the speeds that this iteration added is subtracted. The energy
    that the forces of sticking elements take from the chain is added (``count_holding_work``).
    """
    for m in range(RADAU_STAGES if d.friction.active_count > d.friction.stuck_count else 0):
        power = power_of_correction(d, m)
        for i in range(RADAU_STAGES):
            d.implicit.stages[i, dissipated_at(d.link_count)] -= h * Q[i][m] * power
    if has_sticking(d):
        count_holding_work(d, h)


def power_of_correction(d, m):
    """Return the power [W] of sliding friction at stage m along the speeds that the last iteration added.

    The power is negative if friction dissipates more along the corrected than along the uncorrected speeds.

    The friction forces are those of the evaluated rate. The dissipated energy contains the work of these
    forces along the uncorrected speeds, so the same forces must be used to take this work back. In a chain at
    rest the uncorrected speeds may be far larger than the corrected speeds.
    """
    implicit, change, first = d.implicit, d.scratch.change, velocity_at(d.link_count)
    for j in range(coordinate_count(d.link_count)):
        change[j] = implicit.z_start[first + j] + implicit.stages[m, first + j] - implicit.rates[m, j]
    return work_of_sliding(d, change, implicit.friction_force[m])


def uncounted_work(d):
    """Return the work [J] of dry friction along the part of the tried step that is not counted yet.

    In an implicit step, this part is the motion from the last stage to the projected end of the step; in an
    explicit step, the change of the end by round-off and by the projection. The points must be located at the
    projected end. The work is negative if friction dissipates energy.
    """
    change, y, z = d.scratch.change, d.trial.state, d.implicit.z_scratch
    for j in range(coordinate_count(d.link_count)):
        if is_implicit(d):
            change[j] = y[j] - z[j]
        else:
            change[j] = (y[j] - d.step.state_end[j]) - explicit.step_increment(d, j)
    if not is_implicit(d):
        return work_along(d, change)
    # the work of sticking elements is a difference of two functions of the positions, so the round-off of
    # positions cancels in it
    work = work_of_sliding(d, change, d.friction_element.force) + work_of_holding(d)
    work -= holding_work_at(d, z, d.trial.size)
    locate_points_now(d, y)
    return work


def change_in_step(d, j):
    """Return the change of component j of y in the tried step, without the round-off of its addition to y.

    The difference of the states at both ends would contain this round-off.
    """
    if is_implicit(d):
        return d.implicit.stages[RADAU_STAGES - 1, j]
    return explicit.step_increment(d, j)


def work_along(d, change):
    """Return the work [J] of all dry friction along a ``change`` of the coordinates, for located points."""
    work = work_of_sliding(d, change, d.friction_element.force)
    for k in range(d.friction.stuck_count):
        e = d.friction_element.stuck_index[k]
        work += d.friction_element.force[e] * dot(tangent_row(d, e), d.scratch.place_change)
    return work


def work_of_sliding(d, change, force):
    """Return the work [J] that sliding friction does on the chain in a ``change`` of the coordinates.

    The work is negative if friction dissipates energy. ``force`` has the friction force of every element; the
    forces of sticking elements are not used. If ``change`` is a velocity, the result is a power [W]. The
    points must be located. The function also sets ``scratch.place_change``, the motion of all places in this
    change.
    """
    work = 0.0
    move_points(d, d.scratch.link_vector, change, d.scratch.place_change)
    for k in range(d.friction.active_count):
        e = d.friction_element.index[k]
        if d.friction_element.mode[e] != STICKS:
            work += force[e] * dot(tangent_row(d, e), d.scratch.place_change)
    return work


def count_holding_work(d, h):
    """Add the energy that sticking forces take from the chain to the dissipated energy of each stage.

    The energy is counted from the start of the implicit step, of size h [s]. Sticking forces do work only
    along errors, because sticking elements should not move. At the end of the step a projection moves the
    elements back to their anchors, and does the opposite work.
    """
    implicit = d.implicit
    work_before = holding_work_at(d, implicit.z_start, 0.0)
    for i in range(RADAU_STAGES):
        for j in range(sundman_u_at(d.link_count)):
            implicit.z_scratch[j] = implicit.z_start[j] + implicit.stages[i, j]
        implicit.stages[i, dissipated_at(d.link_count)] -= (
            holding_work_at(d, implicit.z_scratch, h * RADAU_NODES[i]) - work_before
        )


def holding_work_at(d, z, elapsed):
    """Return the work [J] of the present sticking forces along the ways from the anchors to the elements.

    The elements are at their places in the extended state z, ``elapsed`` [s] after the step's start.
    """
    if d.channel_count > 0:
        set_inputs(d, d.step.time_origin + elapsed)
    locate_points_now(d, z)
    return work_of_holding(d)

"""Energies and impulses that an error lets fall in a step, although they never fall in the exact motion.

What the dissipated energy gains by a correction becomes a change of the energy balance. The checks of the
balance ignore this change: the motion had the error before.
"""

from chain_impact.kernel.forces.holding import project_state
from chain_impact.kernel.ode.balance import shift_balance
from chain_impact.kernel.ode.dense_output import correct_falling_quadratures, without_fall
from chain_impact.kernel.ode.last_step import count_dissipated
from chain_impact.kernel.record.state import dissipated_at


def correct_falls(d):
    """Correct integrals that fall in the last step, and return what the dissipated energy gains by it [J].

    They are the dissipated energy and those of ``correct_falling_quadratures``. The state at the end of the
    step must be final: a truncation after this call would undo the correction.
    """
    correct_falling_quadratures(d)
    return keep_dissipated(d, d.step.state[dissipated_at(d.link_count)])


def project_end(d):
    """Project the end of the last step onto the constraints, where the points are located.

    By an error of the state, the projection may let an element that sticks do work. Such work does not reduce
    the dissipated energy.
    """
    dissipated = d.step.state_end[dissipated_at(d.link_count)]
    project_state(d, d.step.state_end)
    keep_dissipated(d, dissipated)


def keep_dissipated(d, before):
    """Keep the dissipated energy at the end of the last step from falling below ``before`` [J].

    Return what is added [J]; ``without_fall`` says which fall is allowed.
    """
    energy = d.step.state_end[dissipated_at(d.link_count)]
    added = without_fall(d, before, energy) - energy
    count_dissipated(d, added)
    shift_balance(d, added)
    return added

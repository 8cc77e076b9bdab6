"""Energies and impulses that an error lets fall in a step, although they never fall in the exact motion.

What the dissipated energy gains by a correction becomes a change of the energy balance. The checks of the
balance (balance.py) ignore this change: the motion had the error before.
"""

from chain_impact.kernel.forces.holding import project_state
from chain_impact.kernel.ode.dense_output import without_fall
from chain_impact.kernel.ode.last_step import correct_dissipated
from chain_impact.kernel.ode.quadratures import correct_falling_quadratures
from chain_impact.kernel.record.state import dissipated_at


def correct_falls(d):
    """Correct integrals that fall in the last step: the dissipated energy, and quadratures.

    A truncation of the step undoes these corrections, so that they must be made again.
    """
    keep_dissipated(d, d.step.state[dissipated_at(d.link_count)])
    correct_falling_quadratures(d)


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

    ``without_fall`` says which fall is allowed.
    """
    energy = d.step.state_end[dissipated_at(d.link_count)]
    correct_dissipated(d, without_fall(d, before, energy) - energy)

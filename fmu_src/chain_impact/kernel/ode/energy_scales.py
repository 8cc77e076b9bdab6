"""The scales [J] of the errors and of the round-off of the energy balance (balance.py).

The scale S of the errors follows from the scales that step_errors.py has for the errors of the components
of the state. To first order S is

    S = (√(2T) + √E₁)² + M g (s + Σ L_i) + E₂ + Σ k |φ| r + Σ (K δⁿ s_δ + ½ m v₀²)
        + dissipated and supplied energy.

T is the kinetic energy, g gravity, M the mass of chain and carriage, L_i the length of link i and s the
longest of these lengths. E₁ is twice the kinetic energy of the stretched chain when it moves by s per second
and rotates by 1 rad per second, with that of the carriage. E₂ is M s², plus the inertias of armatures, per
second squared. The sum with k is over the springs: k |φ| is the moment or force of a spring, with r = 1 rad
at a joint and r = s at a slider. The sum with K is over the active contacts: K δⁿ is the elastic force, 0 at
a rigid wall, s_δ the scale of the penetration, m the effective mass and v₀ the latched speed.
"""

import math

from chain_impact.kernel.chain.drives import (
    coordinate_sum_of_drive,
    drive_count,
    moment_per_force,
    spring_tension,
)
from chain_impact.kernel.constraints.geometry import clearance_and_rate, coordinate_sum
from chain_impact.kernel.equations import mechanical_energy
from chain_impact.kernel.forces.force_formula import elastic_force
from chain_impact.kernel.ode.step_errors import impact_energy, penetration_scale
from chain_impact.kernel.record.state import dissipated_at, supplied_at


def energy_scales(d, y):
    """Return the scale S [J] of errors of the energy balance, and a sum [J] to which round-off is relative.

    ``allowed_change`` (balance.py) is STEP_CHANGE × tolerance × S plus round-off. The sum contains the sizes
    of all terms that enter the balance. Both results belong to state y, for which the points must be located.
    """
    kinetic, potential = mechanical_energy(d, y)
    # the potential energy may be a small difference of large energies, whose round-off counts
    summed = d.balance.weight * (abs(d.scratch.position.x[0]) + abs(d.scratch.position.y[0])) + abs(potential)
    summed += kinetic + abs(y[dissipated_at(d.link_count)]) + abs(y[supplied_at(d.link_count)])
    speed = math.sqrt(2.0 * kinetic) + d.balance.root_reference_energy
    scale = speed * speed + d.balance.reference_energy + impact_energy(d)
    scale += abs(y[dissipated_at(d.link_count)]) + abs(y[supplied_at(d.link_count)])
    if d.chain.has_springs:
        for i in range(drive_count(d)):
            force = abs(spring_tension(d, y, i))
            scale += force * moment_per_force(d, i)
            summed += force * (coordinate_sum_of_drive(d, y, i) + abs(d.inputs.target[i]))
    for k in range(d.contacts.force_law_count):
        c = d.contacts.active_index[k]
        clearance, _ = clearance_and_rate(d, c)
        force = elastic_force(d, c, max(0.0, -clearance))
        scale += force * penetration_scale(d, c)
        summed += force * coordinate_sum(d, c, y)
    return scale, summed

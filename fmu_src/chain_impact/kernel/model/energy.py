"""The energy of the chain, its springs and its contacts, and their balance, constant in the exact motion."""

from chain_impact.kernel.chain.joints import spring_energy
from chain_impact.kernel.chain.state import dissipated_at, omega_at, supplied_at
from chain_impact.kernel.model.contact_force import elastic_energy
from chain_impact.kernel.model.geometry import clearance


def energy_balance(d, y):
    """The energy balance [J], constant in the exact motion, for the located points.

    Kinetic, potential and elastic energy, plus the dissipated, minus the energy supplied by the inputs.
    """
    kinetic, potential = mechanical_energy(d, y)
    return kinetic + potential + other_energy(d, y)


def other_energy(d, y):
    """The energy balance without kinetic and potential energy [J], for the located points."""
    return stored_energy(d, y) + y[dissipated_at(d.links)] - y[supplied_at(d.links)]


def stored_energy(d, y):
    """Elastic energy [J] of the active contacts, for the located points, and of the joints' springs."""
    energy = spring_energy(d, y) if d.model.sprung else 0.0
    for k in range(d.touch.compliant_count):
        c = d.touch.active_index[k]
        gap, _ = clearance(d, c)
        if gap < 0.0:
            energy += elastic_energy(d, c, -gap)
    return energy


def mechanical_energy(d, y):
    """Kinetic and potential energy [J] of the chain, for the located points."""
    n = d.links
    kinetic, potential = 0.0, 0.0
    for i in range(n):
        m, ratio, omega = d.model.mass[i], d.model.center_of_mass_ratio[i], y[omega_at(n) + i]
        # centre of mass: p_C = p_i + c, v_C = v_i + ω c⊥
        vx = d.work.velocity.x[i] - omega * ratio * d.work.link.y[i]
        vy = d.work.velocity.y[i] + omega * ratio * d.work.link.x[i]
        kinetic += 0.5 * m * (vx * vx + vy * vy) + 0.5 * d.model.inertia[i] * omega * omega
        x = d.work.position.x[i] + ratio * d.work.link.x[i]
        y_ = d.work.position.y[i] + ratio * d.work.link.y[i]
        potential -= m * (d.model.gravity[0] * x + d.model.gravity[1] * y_)
    return kinetic, potential

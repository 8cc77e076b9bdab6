"""The equations of motion ẏ = f(y): the table of contents of the model. chain/state.py says what is in y."""

from chain_impact.kernel.chain.kinematics import link_vectors, locate_points
from chain_impact.kernel.chain.recursion import accelerations
from chain_impact.kernel.chain.state import (
    coordinate_count,
    dissipated_at,
    omega_at,
    root_at,
    supplied_at,
    time_at,
    velocity_at,
)
from chain_impact.kernel.model.constraints import hold
from chain_impact.kernel.model.contact import apply_contacts, clear_loads


def state_rate(d, y, rate):
    """Set rate = f(y) for the contacts that are active and the inputs that hold now."""
    # in free flight no point is located and no force evaluated
    if d.touch.active_count > 0 or d.model.driven:
        locate_points(d, y)
        located_rate(d, y, rate)
    else:
        link_vectors(d, y)
        loaded_rate(d, y, 0.0, rate)


def located_rate(d, y, rate):
    """As ``state_rate``, for the located points."""
    if d.contact.impulsive:
        free_rate(d, y, rate)
        if d.touch.active_count > 0:
            hold(d, y, rate)
    else:
        loaded_rate(d, y, apply_contacts(d), rate)


def free_rate(d, y, rate):
    """As ``located_rate``, as if the walls were not there."""
    clear_loads(d)
    loaded_rate(d, y, 0.0, rate)


def loaded_rate(d, y, dissipated, rate):
    """As ``state_rate``, under the present loads, which dissipate a power [W]."""
    n = d.links
    supplied = 0.0
    if d.model.damped or d.model.driven:
        damped, supplied = joint_moments(d, y)
        dissipated += damped

    for j in range(coordinate_count(n)):
        rate[j] = y[velocity_at(n) + j]
    accelerations(d, y, rate)
    rate[dissipated_at(n)] = dissipated
    rate[supplied_at(n)] = supplied
    rate[root_at(n)] = 0.0
    rate[time_at(n)] = 1.0


def joint_moments(d, y):
    """Set the net joint moment on each link; return the power [W] dissipated and supplied.

    The proximal joint of link i carries τ_i = u_i − c_i (ω_i − ω_{i−1}): +τ_i on link i, −τ_i on link
    i − 1. A free base has no joint to carry τ_1.
    """
    dissipated = 0.0
    # force on the tip
    tip = d.links
    supplied = d.inputs.tip_force[0] * d.work.velocity.x[tip] + d.inputs.tip_force[1] * d.work.velocity.y[tip]
    before = 0.0
    for i in range(d.links):
        torque, omega = 0.0, y[omega_at(d.links) + i]
        if i > 0 or d.model.pinned:
            relative = omega - before
            damping = d.model.joint_damping[i] * relative
            torque = d.inputs.joint_torque[i] - damping
            dissipated += damping * relative
            supplied += d.inputs.joint_torque[i] * relative
        d.work.moment[i] = torque
        if i > 0:
            d.work.moment[i - 1] -= torque
        before = omega
    return dissipated, supplied


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

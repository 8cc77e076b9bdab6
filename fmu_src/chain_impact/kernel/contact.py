"""Contact of points with walls: clearance, penetration, rate and the generalized force.

A candidate is a pair of a point and a wall. The clearance g of a candidate is positive when apart; the
penetration is δ = −g and its rate δ̇ > 0 while compressing. Walls are numbered x_min, x_max, y_min, y_max.
"""

from chain_impact.kernel.contact_laws import (
    elastic_depth,
    elastic_energy,
    elastic_force,
    force_over_elastic,
)
from chain_impact.kernel.jit import jit
from chain_impact.kernel.recursion import accelerations, link_vectors


@jit
def locate_points(model, y, work):
    """Positions [m] and velocities [m/s] of the points 0…N, and the link vectors, for the state y."""
    n = len(model.length)
    link_vectors(model, y[2 : 2 + n], work)
    x, y_, vx, vy = y[0], y[1], y[n + 2], y[n + 3]
    for i in range(n):
        work.x[i], work.y_[i], work.vx[i], work.vy[i] = x, y_, vx, vy
        omega = y[n + 4 + i]
        # p_{i+1} = p_i + L_i,  v_{i+1} = v_i + ω L⊥
        x += work.link_x[i]
        y_ += work.link_y[i]
        vx -= omega * work.link_y[i]
        vy += omega * work.link_x[i]
    work.x[n], work.y_[n], work.vx[n], work.vy[n] = x, y_, vx, vy


@jit
def accelerate_points(model, y, rate, work):
    """Accelerations [m/s²] of the located points 0…N, for the state y and its rate."""
    n = len(model.length)
    ax, ay = rate[n + 2], rate[n + 3]
    for i in range(n):
        work.ax[i], work.ay[i] = ax, ay
        alpha, w2 = rate[n + 4 + i], y[n + 4 + i] * y[n + 4 + i]
        # a_{i+1} = a_i + α L⊥ − ω² L
        ax -= alpha * work.link_y[i] + w2 * work.link_x[i]
        ay += alpha * work.link_x[i] - w2 * work.link_y[i]
    work.ax[n], work.ay[n] = ax, ay


@jit
def clearance(d, c):
    """Clearance g [m] and its rate ġ [m/s] of candidate c, from the located points."""
    point, wall = d.model.candidate_point[c], d.model.candidate_wall[c]
    position = d.work.x[point] if wall < 2 else d.work.y_[point]
    velocity = d.work.vx[point] if wall < 2 else d.work.vy[point]
    side = inward(wall)
    return side * (position - d.model.wall[wall]) - d.contact.radius, side * velocity


@jit
def inward(wall):
    """Sign of the inward normal of a wall along its axis: +1 for x_min and y_min, −1 for the others."""
    return 1.0 - 2.0 * (wall % 2)


@jit
def add_load(d, c, force):
    """Add a normal force [N] of candidate c to the load on its point."""
    point, wall = d.model.candidate_point[c], d.model.candidate_wall[c]
    if wall < 2:
        d.work.load_x[point] += inward(wall) * force
    else:
        d.work.load_y[point] += inward(wall) * force


@jit
def contact_force(d, c):
    """Force [N] of an active candidate, its penetration [m], rate [m/s] and dissipated power [W]."""
    gap, gap_rate = clearance(d, c)
    if gap >= 0.0:
        return 0.0, -gap, -gap_rate, 0.0
    elastic = elastic_force(d.contact, -gap)
    force = elastic * force_over_elastic(d.contact, -gap_rate, d.touch.impact_speed[c])
    # what the elastic part does not store is lost: (F − K δⁿ) δ̇ ≥ 0
    return force, -gap, -gap_rate, (elastic - force) * gap_rate


@jit
def clear_loads(d):
    """Set the loads on the points to the inputs alone."""
    for i in range(len(d.work.load_x)):
        d.work.load_x[i] = 0.0
        d.work.load_y[i] = 0.0
    tip = len(d.work.load_x) - 1
    d.work.load_x[tip] = d.inputs.tip_force[0]
    d.work.load_y[tip] = d.inputs.tip_force[1]


@jit
def apply_contacts(d):
    """Set the loads for the located points and return the power [W] dissipated by the contacts."""
    clear_loads(d)
    dissipated = 0.0
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        force, _, _, power = contact_force(d, c)
        add_load(d, c, force)
        dissipated += power
    return dissipated


@jit
def stored_energy(d):
    """Elastic energy [J] of the active contacts, for the located points."""
    energy = 0.0
    for k in range(d.touch.active_count):
        gap, _ = clearance(d, d.touch.active_index[k])
        if gap < 0.0:
            energy += elastic_energy(d.contact, -gap)
    return energy


@jit
def latch(d, c, y, rate, spare):
    """Begin the contact of candidate c in state y: fix v₀, the effective mass and the expected depth.

    Args:
        d: the instance; ``work`` holds the loads and link vectors that gave ``rate``.
        c: the candidate.
        y: the state at onset.
        rate: ẏ in that state.
        spare: work space of the size of the state.
    """
    n = len(d.model.length)
    _, gap_rate = clearance(d, c)
    touch = d.touch
    touch.onset[c] = d.step.end
    touch.onset_speed[c] = -gap_rate
    touch.impact_speed[c] = max(-gap_rate, d.contact.minimum_impact_speed)
    touch.force_rate[c] = 1.0  # rising
    touch.speed[c] = -gap_rate
    touch.peak_force[c] = 0.0
    touch.max_penetration[c] = 0.0
    # a unit force at the contact changes the acceleration of the point by 1/m_eff
    add_load(d, c, 1.0)
    accelerations(d.model, y[n + 4 : 2 * n + 4], d.work, spare[n + 2 : n + 4], spare[n + 4 : 2 * n + 4])
    add_load(d, c, -1.0)
    for j in range(n + 2, 2 * n + 4):
        spare[j] -= rate[j]
    touch.effective_mass[c] = 1.0 / normal_component(d, c, spare[n + 2 : n + 4], spare[n + 4 : 2 * n + 4])
    touch.depth_scale[c] = elastic_depth(d.contact, touch.effective_mass[c], touch.impact_speed[c])
    impact = d.impact
    impact.count += 1
    impact.last_time = d.step.end
    impact.last_point = d.model.candidate_point[c]
    impact.last_wall = d.model.candidate_wall[c] + 1
    impact.last_speed = -gap_rate


@jit
def normal_component(d, c, base, angular):
    """The part along the inward normal of candidate c of a change (base, angular) of position or velocity.

    With J the gradient of the clearance: J·(base, angular) = n·(base + Σ_{i<k} L⊥_i angular_i).
    """
    point, wall = d.model.candidate_point[c], d.model.candidate_wall[c]
    if wall < 2:
        total = base[0]
        for i in range(point):
            total -= d.work.link_y[i] * angular[i]
    else:
        total = base[1]
        for i in range(point):
            total += d.work.link_x[i] * angular[i]
    return inward(wall) * total

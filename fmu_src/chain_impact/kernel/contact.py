"""Contact of points with walls: clearance, penetration, rate and the generalized force.

A candidate is a pair of a point and a wall. The clearance g of a candidate is positive when apart; the
penetration is δ = −g and its rate δ̇ > 0 while compressing. Walls are numbered x_min, x_max, y_min, y_max.
"""

from chain_impact.kernel.contact_force import (
    elastic_depth,
    elastic_energy,
    latch_damping,
    law_force,
    law_slopes,
)
from chain_impact.kernel.jit import jit
from chain_impact.kernel.recursion import factorize, link_vectors, move_points, solve


@jit
def locate_points(model, y, work):
    """Positions [m] and velocities [m/s] of the points 0…N, and the link vectors, for the state y."""
    link_vectors(model, y, work)
    place_points(model, y, work)


@jit
def place_points(model, y, work):
    """As ``locate_points``, for the link vectors as they are."""
    n = len(model.length)
    work.at_end = 0
    x, y_, vx, vy = y[0], y[1], y[n + 2], y[n + 3]
    for i in range(n):
        work.position.x[i], work.position.y[i], work.velocity.x[i], work.velocity.y[i] = x, y_, vx, vy
        omega = y[n + 4 + i]
        # p_{i+1} = p_i + L_i,  v_{i+1} = v_i + ω L⊥
        x += work.link.x[i]
        y_ += work.link.y[i]
        vx -= omega * work.link.y[i]
        vy += omega * work.link.x[i]
    work.position.x[n], work.position.y[n], work.velocity.x[n], work.velocity.y[n] = x, y_, vx, vy


@jit
def accelerate_points(model, y, rate, work):
    """Accelerations [m/s²] of the located points 0…N, for the state y and its rate."""
    n = len(model.length)
    ax, ay = rate[n + 2], rate[n + 3]
    for i in range(n):
        work.acceleration.x[i], work.acceleration.y[i] = ax, ay
        alpha, w2 = rate[n + 4 + i], y[n + 4 + i] * y[n + 4 + i]
        # a_{i+1} = a_i + α L⊥ − ω² L
        ax -= alpha * work.link.y[i] + w2 * work.link.x[i]
        ay += alpha * work.link.x[i] - w2 * work.link.y[i]
    work.acceleration.x[n], work.acceleration.y[n] = ax, ay


@jit
def clearance(d, c):
    """Clearance g [m] and its rate ġ [m/s] of candidate c, from the located points."""
    wall = d.model.candidate_wall[c]
    position = across_wall(d, c, d.work.position)
    gap = inward(wall) * (position - d.model.wall[wall]) - d.contact.radius
    return gap, along_normal(d, c, d.work.velocity)


@jit
def inward(wall):
    """Sign of the inward normal of a wall along its axis: +1 for x_min and y_min, −1 for the others."""
    return 1.0 - 2.0 * (wall % 2)


@jit
def across_wall(d, c, vectors):
    """Of the vectors of all points, the component for candidate c along the axis that its wall stands on."""
    point = d.model.candidate_point[c]
    return vectors.x[point] if d.model.candidate_wall[c] < 2 else vectors.y[point]


@jit
def add_across_wall(d, c, vectors, amount):
    """Add to that component."""
    point = d.model.candidate_point[c]
    if d.model.candidate_wall[c] < 2:
        vectors.x[point] += amount
    else:
        vectors.y[point] += amount


@jit
def add_along_normal(d, c, vectors, amount):
    """Add to that component an amount along the inward normal."""
    add_across_wall(d, c, vectors, inward(d.model.candidate_wall[c]) * amount)


@jit
def along_normal(d, c, vectors):
    """The component along the inward normal of candidate c of the vectors of all points."""
    return inward(d.model.candidate_wall[c]) * across_wall(d, c, vectors)


@jit
def contact_force(d, c, gap, gap_rate):
    """Force [N] of an active candidate at a clearance [m] and its rate [m/s], and dissipated power [W]."""
    # at the onset the clearance is 0 to round-off, and a force that jumps there has jumped
    force, elastic = law_force(d, c, max(0.0, -gap), -gap_rate)
    # what the elastic part does not store is lost: (F − K δⁿ) δ̇ ≥ 0
    return force, (elastic - force) * gap_rate


@jit
def apply_contact(d, c, gap, gap_rate):
    """Add the force of an active candidate to the load on its point; return the dissipated power [W]."""
    force, power = contact_force(d, c, gap, gap_rate)
    add_along_normal(d, c, d.work.load, force)
    return power


@jit
def clear_loads(d):
    """Set the loads on the points to the inputs alone."""
    zero(d.work.load)
    tip = len(d.work.load.x) - 1
    d.work.load.x[tip] = d.inputs.tip_force[0]
    d.work.load.y[tip] = d.inputs.tip_force[1]


@jit
def apply_contacts(d):
    """Set the loads for the located points and return the power [W] dissipated by the contacts."""
    clear_loads(d)
    dissipated = 0.0
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        gap, gap_rate = clearance(d, c)
        dissipated += apply_contact(d, c, gap, gap_rate)
    return dissipated


@jit
def stored_energy(d):
    """Elastic energy [J] of the active contacts, for the located points."""
    energy = 0.0
    for k in range(d.touch.active_count):
        gap, _ = clearance(d, d.touch.active_index[k])
        if gap < 0.0 and not d.contact.impulsive:
            energy += elastic_energy(d.contact, -gap)
    return energy


@jit
def contact_slopes(d, c):
    """∂F/∂δ [N/m] and ∂F/∂δ̇ [N·s/m] of an active candidate, for the located points; 0 where F is."""
    gap, gap_rate = clearance(d, c)
    return law_slopes(d, c, max(0.0, -gap), -gap_rate)


@jit
def latch(d, c):
    """Begin the contact of candidate c at the located points: fix v₀, effective mass and expected depth."""
    _, gap_rate = clearance(d, c)
    touch = d.touch
    touch.onset[c] = d.step.end
    touch.onset_speed[c] = 0.0 - gap_rate  # not −0
    touch.impact_speed[c] = max(-gap_rate, d.contact.minimum_impact_speed)
    touch.speed[c] = -gap_rate
    touch.force_rate[c] = 1.0  # rising
    touch.peak_force[c] = 0.0
    touch.max_penetration[c] = 0.0
    touch.effective_mass[c] = effective_mass(d, c)
    if d.contact.impulsive:
        touch.depth_scale[c] = d.model.size  # no depth to be exact about
    else:
        touch.depth_scale[c] = elastic_depth(d.contact, touch.effective_mass[c], touch.impact_speed[c])
        latch_damping(d, c)
    d.impact.count += 1
    d.impact.last_time = d.step.end
    d.impact.last_point = d.model.candidate_point[c]
    d.impact.last_wall = d.model.candidate_wall[c] + 1
    d.impact.last_speed = touch.onset_speed[c]


@jit
def drop_events(touch):
    """Forget the events found in the last step."""
    for c in range(len(touch.event)):
        touch.event[c] = 0


@jit
def effective_mass(d, c):
    """1/(J M⁻¹ Jᵀ) [kg] of candidate c at the located points: what a blow along its normal has to move.

    Leaves the response M⁻¹ Jᵀ to a unit impulse in ``work.y``.
    """
    work = d.work
    n = len(d.model.length)
    zero(work.load)
    factorize(d.model, work.link, work.load, work.factors)
    add_along_normal(d, c, work.load, 1.0)
    solve(d.model, work.link, work.factors, work.load, work.y[0:2], work.y[2 : n + 2])
    move_points(work.link, work.y[0:2], work.y[2 : n + 2], work.motion)
    return 1.0 / along_normal(d, c, work.motion)


@jit
def zero(vectors):
    """Set the vectors of all points to zero."""
    for k in range(len(vectors.x)):
        vectors.x[k], vectors.y[k] = 0.0, 0.0

"""Contact of points with walls: clearance, penetration, rate and the generalized force.

A candidate is a pair of a point and a wall. The clearance g of a candidate is positive when apart; the
penetration is δ = −g and its rate δ̇ > 0 while compressing.
"""

from chain_impact.kernel.contact_force import (
    elastic_depth,
    elastic_energy,
    latch_damping,
    law_force,
    law_slopes,
)
from chain_impact.kernel.recursion import factorize, link_vectors, move_points, solve

WALLS = ("x_min", "x_max", "y_min", "y_max")
"""The walls in the order of their numbers, from 0."""


def locate_points(d, y):
    """Positions [m] and velocities [m/s] of the points 0…N, and the link vectors, for the state y."""
    link_vectors(d, y)
    place_points(d, y)


def place_points(d, y):
    """As ``locate_points``, for the link vectors as they are."""
    n, link, position, velocity = d.links, d.work.link, d.work.position, d.work.velocity
    d.work.at_end = 0
    x, y_, vx, vy = y[0], y[1], y[n + 2], y[n + 3]
    for i in range(n):
        position.x[i], position.y[i], velocity.x[i], velocity.y[i] = x, y_, vx, vy
        omega = y[n + 4 + i]
        # p_{i+1} = p_i + L_i,  v_{i+1} = v_i + ω L⊥
        x += link.x[i]
        y_ += link.y[i]
        vx -= omega * link.y[i]
        vy += omega * link.x[i]
    position.x[n], position.y[n], velocity.x[n], velocity.y[n] = x, y_, vx, vy


def accelerate_points(d, y, rate):
    """Accelerations [m/s²] of the located points 0…N, for the state y and its rate."""
    n, link, acceleration = d.links, d.work.link, d.work.acceleration
    ax, ay = rate[n + 2], rate[n + 3]
    for i in range(n):
        acceleration.x[i], acceleration.y[i] = ax, ay
        alpha, w2 = rate[n + 4 + i], y[n + 4 + i] * y[n + 4 + i]
        # a_{i+1} = a_i + α L⊥ − ω² L
        ax -= alpha * link.y[i] + w2 * link.x[i]
        ay += alpha * link.x[i] - w2 * link.y[i]
    acceleration.x[n], acceleration.y[n] = ax, ay


def clearance(d, c):
    """Clearance g [m] and its rate ġ [m/s] of candidate c, from the located points."""
    wall = d.candidate.wall[c]
    position = across_wall(d, c, d.work.position)
    gap = inward(wall) * (position - d.model.wall[wall]) - d.contact.radius
    return gap, along_normal(d, c, d.work.velocity)


def inward(wall):
    """Sign of the inward normal of a wall along its axis: +1 for x_min and y_min, −1 for the others."""
    return 1.0 - 2.0 * (wall % 2)


def across_wall(d, c, vectors):
    """Of the vectors of all points, the component for candidate c along the axis that its wall stands on."""
    point = d.candidate.point[c]
    return vectors.x[point] if d.candidate.wall[c] < 2 else vectors.y[point]


def add_across_wall(d, c, vectors, amount):
    """Add to that component."""
    point = d.candidate.point[c]
    if d.candidate.wall[c] < 2:
        vectors.x[point] += amount
    else:
        vectors.y[point] += amount


def add_along_normal(d, c, vectors, amount):
    """Add to that component an amount along the inward normal."""
    add_across_wall(d, c, vectors, inward(d.candidate.wall[c]) * amount)


def along_normal(d, c, vectors):
    """The component along the inward normal of candidate c of the vectors of all points."""
    return inward(d.candidate.wall[c]) * across_wall(d, c, vectors)


def contact_force(d, c, gap, gap_rate):
    """Force [N] of an active candidate at a clearance [m] and its rate [m/s], and dissipated power [W]."""
    # at the onset the clearance is 0 to round-off, and a force that jumps there has jumped
    force, elastic = law_force(d, c, max(0.0, -gap), -gap_rate)
    # what the elastic part does not store is lost: (F − K δⁿ) δ̇ ≥ 0
    return force, (elastic - force) * gap_rate


def apply_contact(d, c, gap, gap_rate):
    """Add the force of an active candidate to the load on its point; return the dissipated power [W]."""
    force, power = contact_force(d, c, gap, gap_rate)
    add_along_normal(d, c, d.work.load, force)
    return power


def clear_loads(d):
    """Set the loads on the points to the inputs alone."""
    zero(d.work.load)
    tip = len(d.work.load.x) - 1
    d.work.load.x[tip] = d.inputs.tip_force[0]
    d.work.load.y[tip] = d.inputs.tip_force[1]


def apply_contacts(d):
    """Set the loads for the located points and return the power [W] dissipated by the contacts."""
    clear_loads(d)
    dissipated = 0.0
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        gap, gap_rate = clearance(d, c)
        dissipated += apply_contact(d, c, gap, gap_rate)
    return dissipated


def stored_energy(d):
    """Elastic energy [J] of the active contacts, for the located points."""
    energy = 0.0
    for k in range(d.touch.active_count):
        gap, _ = clearance(d, d.touch.active_index[k])
        if gap < 0.0 and not d.contact.impulsive:
            energy += elastic_energy(d.contact, -gap)
    return energy


def contact_slopes(d, c):
    """∂F/∂δ [N/m] and ∂F/∂δ̇ [N·s/m] of an active candidate, for the located points; 0 where F is."""
    gap, gap_rate = clearance(d, c)
    return law_slopes(d, c, max(0.0, -gap), -gap_rate)


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
    d.impact.last_point = d.candidate.point[c]
    d.impact.last_wall = d.candidate.wall[c] + 1
    d.impact.last_speed = touch.onset_speed[c]


def drop_events(d):
    """Forget the events found in the last step."""
    for c in range(d.candidates):
        d.touch.event[c] = 0


def effective_mass(d, c):
    """1/(J M⁻¹ Jᵀ) [kg] of candidate c at the located points: what a blow along its normal has to move.

    Leaves the response M⁻¹ Jᵀ to a unit impulse in ``work.y``.
    """
    work = d.work
    n = d.links
    zero(work.load)
    factorize(d, work.link, work.load, work.factors)
    add_along_normal(d, c, work.load, 1.0)
    solve(d, work.link, work.factors, work.load, work.y[0:2], work.y[2 : n + 2])
    move_points(work.link, work.y[0:2], work.y[2 : n + 2], work.motion)
    return 1.0 / along_normal(d, c, work.motion)


def zero(vectors):
    """Set the vectors of all points to zero."""
    for k in range(len(vectors.x)):
        vectors.x[k], vectors.y[k] = 0.0, 0.0

"""Kinematics of the chain: positions, velocities and accelerations of its points.

Vectors of all places are records with ``x, y``, shape (2N+1+P,), for N links and P sites. The first N + 1
places are the points 0…N. The next N places belong to the joints 1…N and are used in scenes with stops or dry
friction in joints. The coordinate x of a joint's place is the joint's own angle θ_i − θ_{i−1} times a lever
arm, the length of the longest link, and y is 0. So other modules treat a stop like a wall that a point at
this place touches. The last P places are the sites (chain/sites.py).
"""

from chain_impact.kernel.chain.prescribed_motion import move_channels_to_state
from chain_impact.kernel.chain.sites import (
    accelerate_sites,
    clear_sites,
    joint_place,
    locate_sites,
    set_site_motions,
    site_place,
)
from chain_impact.kernel.function_marks import has_dual_rule, inlined
from chain_impact.kernel.mathematics.angles import LARGEST_ANGLE, cosine_and_sine, unit_vector
from chain_impact.kernel.record.state import FIRST_ANGLE, omega_at, relative_to_previous, velocity_at


@has_dual_rule
def set_polar(radius, y, first, horizontal, vertical):
    """Set ``horizontal`` to r cos φ and ``vertical`` to r sin φ, for pairs of a radius r and an angle φ.

    The radii are the entries of ``radius``, shape (N,). The angles [rad] are the N entries of y, such as
    the state, from index ``first`` on. The arrays of results have N or more entries.
    """
    count = len(radius)
    if not is_in_sine_range(y, first, count):
        for i in range(count):
            cosine, sine = unit_vector(y[first + i])
            horizontal[i] = radius[i] * cosine
            vertical[i] = radius[i] * sine
        return
    # For the compiler the results may lie in the memory of y. After the angles are copied to ``vertical``,
    # the compiler knows that no result overwrites an angle that is still to be read.
    copy_entries(y, first, count, vertical)
    # because the angles are copied, the compiler lets the processor compute several of them at once
    for i in range(count):
        cosine, sine = cosine_and_sine(vertical[i])
        horizontal[i] = radius[i] * cosine
        vertical[i] = radius[i] * sine


@inlined
def copy_entries(y, first, count, out):
    """Copy ``count`` numbers of y, from index ``first`` on, to the start of ``out``, several at once.

    Code that reads the copy as vectors would be slow if the numbers had just been written one by one. So the
    function reads a group of numbers before it writes the group.
    """
    fours, pairs = count - count % 4, count - count % 2
    for i in range(0, fours, 4):
        a, b, c, d = y[first + i], y[first + i + 1], y[first + i + 2], y[first + i + 3]
        out[i], out[i + 1], out[i + 2], out[i + 3] = a, b, c, d
    for i in range(fours, pairs, 2):
        a, b = y[first + i], y[first + i + 1]
        out[i], out[i + 1] = a, b
    for i in range(pairs, count):
        out[i] = y[first + i]


def is_in_sine_range(y, first, count):
    """Return whether ``count`` angles are surely in the range of ``cosine_and_sine``.

    The angles [rad] begin at index ``first`` of y. The result is True if the sum of their absolute values is
    below LARGEST_ANGLE, which is more than necessary, but quickly tested; it is False if an angle is NaN.
    """
    total = 0.0
    for i in range(count):
        total += abs(y[first + i])
    return total < LARGEST_ANGLE


def locate_points(d, y):
    """Locate the points in state y: set link vectors, and positions [m] and velocities [m/s] of all places.

    Prescribed motions of base, walls and belts are first set to those at the time that y contains.
    """
    if d.channel_count > 0:
        move_channels_to_state(d, y)
    locate_points_now(d, y)


def locate_points_now(d, y):
    """Locate the points as ``locate_points`` does, but leave the prescribed motions as they are."""
    set_link_vectors(d, y)
    locate_from_link_vectors(d, y)


def locate_from_link_vectors(d, y):
    """Locate the points for the state y, whose link vectors and prescribed motions have been set."""
    n, link, position, velocity = d.link_count, d.scratch.link_vector, d.scratch.position, d.scratch.velocity
    x, y_ = y[0], y[1]
    vx, vy = y[velocity_at(n)], y[velocity_at(n) + 1]
    if d.channel_count > 0 and d.chain.base_moves:
        channel = d.channel
        x, y_, vx, vy = channel.position[0], channel.position[1], channel.velocity[0], channel.velocity[1]
    for i in range(n):
        position.x[i], position.y[i], velocity.x[i], velocity.y[i] = x, y_, vx, vy
        omega = y[omega_at(n) + i]
        # position p and velocity v of the next joint i + 1, with the link vector L and the angular velocity
        # ω: p_{i+1} = p_i + L_i, v_{i+1} = v_i + ω L⊥
        x += link.x[i]
        y_ += link.y[i]
        vx -= omega * link.y[i]
        vy += omega * link.x[i]
    position.x[n], position.y[n], velocity.x[n], velocity.y[n] = x, y_, vx, vy
    if d.chain.has_joint_places:
        set_joint_places(d, y, FIRST_ANGLE, position)
        set_joint_places(d, y, omega_at(n), velocity)
    locate_sites(d, y, omega_at(n), position, velocity)


def set_joint_places(d, values, first, vectors):
    """Set x of each joint's place in ``vectors`` to the joint's angle times the length of the longest link.

    The absolute angles of the N links begin at index ``first`` of ``values``. If ``values`` has the rates,
    accelerations or changes of these angles, x gets the rate, acceleration or change of the joint's angle,
    times the length of the longest link.
    """
    for i in range(d.link_count):
        vectors.x[joint_place(d, i)] = d.chain.longest_link * relative_to_previous(values, first, i)


def accelerate_points(d, y, rate):
    """Set the accelerations [m/s²] of all places for the state y and its ``rate`` ẏ.

    A joint's place gets the acceleration of the joint's angle times the length of the longest link. The
    points must be located for y.
    """
    n, link, acceleration = d.link_count, d.scratch.link_vector, d.scratch.acceleration
    ax, ay = rate[velocity_at(n)], rate[velocity_at(n) + 1]
    if d.channel_count > 0 and d.chain.base_moves:
        ax, ay = d.channel.acceleration[0], d.channel.acceleration[1]
    for i in range(n):
        acceleration.x[i], acceleration.y[i] = ax, ay
        omega, alpha = y[omega_at(n) + i], rate[omega_at(n) + i]
        w2 = omega * omega
        # acceleration of the next joint, by ω, α and the vector L of the link: a_{i+1} = a_i + α L⊥ − ω² L
        ax -= alpha * link.y[i] + w2 * link.x[i]
        ay += alpha * link.x[i] - w2 * link.y[i]
    acceleration.x[n], acceleration.y[n] = ax, ay
    if d.chain.has_joint_places:
        set_joint_places(d, rate, omega_at(n), acceleration)
    accelerate_sites(d, y, rate, omega_at(n), acceleration)


def clear_vectors(d, vectors):
    """Set the vectors of all places in use to zero."""
    # in a kernel for one number of links, the count is a constant for the compiler, which unrolls this loop
    for k in range(d.link_count + 1):
        vectors.x[k], vectors.y[k] = 0.0, 0.0
    if d.chain.has_joint_places:
        for k in range(joint_place(d, 0), joint_place(d, d.link_count)):
            vectors.x[k], vectors.y[k] = 0.0, 0.0
    clear_sites(d, vectors)


def clear_joints(values):
    """Set to zero the moments, or the impedances, of all joints."""
    for i in range(len(values.joint)):
        values.joint[i] = 0.0


def set_link_vectors(d, y):
    """Set L_i [m], the vector from the proximal to the distal end of each link, for the state y.

    Afterwards the positions, velocities and accelerations in ``scratch`` count as out of date.
    """
    note_points_elsewhere(d)
    set_polar(d.chain.length, y, FIRST_ANGLE, d.scratch.link_vector.x, d.scratch.link_vector.y)


def note_points_at_end(d):
    """Record that positions, velocities and accelerations of points are those at the last step's end."""
    d.scratch.located_at_end = 1


def note_points_elsewhere(d):
    """Record that positions, velocities and accelerations of points may be those at another time."""
    d.scratch.located_at_end = 0


def move_points(d, link_vectors, change, response):
    """Set ``response`` to the motions of all places that the ``change`` of the coordinates causes.

    ``change`` has the entries of the coordinates in y: x and y of the base, then the angles. Link i, counted
    from 0, leads from point i to point i + 1. Its small rotation Δθ_i turns its link vector L_i, so the
    motion of point i gives that of point i + 1: Δp_{i+1} = Δp_i + Δθ_i L_i⊥. If ``change`` is a change of the
    coordinates' rates, ``response`` gets the changes of the places' velocities.
    """
    n = d.link_count
    x, y = change[0], change[1]
    for i in range(n):
        response.x[i], response.y[i] = x, y
        x -= change[FIRST_ANGLE + i] * link_vectors.y[i]
        y += change[FIRST_ANGLE + i] * link_vectors.x[i]
    response.x[n], response.y[n] = x, y
    if d.chain.has_joint_places:
        set_joint_places(d, change, FIRST_ANGLE, response)
    set_site_motions(d, link_vectors, change, FIRST_ANGLE, response)


def largest_component(d, vectors):
    """Return the largest absolute value of all components in the vectors of all places in use."""
    largest = 0.0
    for k in range(d.link_count + 1):
        largest = max(largest, abs(vectors.x[k]), abs(vectors.y[k]))
    if d.chain.has_joint_places:
        for k in range(joint_place(d, 0), joint_place(d, d.link_count)):
            largest = max(largest, abs(vectors.x[k]))
    for k in range(site_place(d, 0), site_place(d, d.site_count)):
        largest = max(largest, abs(vectors.x[k]), abs(vectors.y[k]))
    return largest


def vector_at_center_of_mass(d, vectors, i):
    """Return x and y of the position, velocity or acceleration of link i's centre of mass.

    Both follow from those of the two ends of the link, in ``vectors``.
    """
    # v_C = v_i + (c/ℓ) Δv + (o/ℓ) Δv⊥, with Δv = v_{i+1} − v_i, for a centre of mass at c along the link of
    # length ℓ, and o to the left of it
    ratio, x, y = d.chain.center_of_mass_ratio[i], vectors.x[i], vectors.y[i]
    dx, dy = vectors.x[i + 1] - x, vectors.y[i + 1] - y
    if d.skewed:
        beside = d.chain.offset_ratio[i]
        return x + ratio * dx - beside * dy, y + ratio * dy + beside * dx
    return x + ratio * dx, y + ratio * dy

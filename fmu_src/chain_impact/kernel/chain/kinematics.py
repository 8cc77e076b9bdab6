"""Kinematics of the chain: where its points are, how fast they move and how they accelerate.

Vectors of all places are records with ``x, y``, shape (2N+1,). The first N + 1 places are the points 0…N. A
scene with stops has N more, one for each joint 1…N. Their x is the joint's own angle θ_i − θ_{i−1} at a lever
arm, the longest link, and their y is 0. So a stop is to all other modules what a wall is to a point.
"""

from chain_impact.kernel.chain.sincos import polar
from chain_impact.kernel.chain.state import ANGLES, omega_at, velocity_at


def locate_points(d, y):
    """Positions [m] and velocities [m/s] of the points 0…N, and the link vectors, for the state y."""
    link_vectors(d, y)
    place_points(d, y)


def place_points(d, y):
    """As ``locate_points``, for link vectors that are already set."""
    n, link, position, velocity = d.links, d.work.link, d.work.position, d.work.velocity
    x, y_ = y[0], y[1]
    vx, vy = y[velocity_at(n)], y[velocity_at(n) + 1]
    for i in range(n):
        position.x[i], position.y[i], velocity.x[i], velocity.y[i] = x, y_, vx, vy
        omega = y[omega_at(n) + i]
        # p_{i+1} = p_i + L_i,  v_{i+1} = v_i + ω L⊥
        x += link.x[i]
        y_ += link.y[i]
        vx -= omega * link.y[i]
        vy += omega * link.x[i]
    position.x[n], position.y[n], velocity.x[n], velocity.y[n] = x, y_, vx, vy
    if d.model.jointed:
        place_joints(d, y, ANGLES, position)
        place_joints(d, y, omega_at(n), velocity)


def place_joints(d, values, first, vectors):
    """Set the vectors of the joints' places from values of the N links, which begin at the ``first``."""
    before, size = 0.0, d.model.size
    for i in range(d.links):
        vectors.x[d.links + 1 + i] = size * (values[first + i] - before)
        before = values[first + i]


def accelerate_points(d, y, rate):
    """Accelerations [m/s²] of the located points 0…N, for the state y and its rate."""
    n, link, acceleration = d.links, d.work.link, d.work.acceleration
    ax, ay = rate[velocity_at(n)], rate[velocity_at(n) + 1]
    for i in range(n):
        acceleration.x[i], acceleration.y[i] = ax, ay
        omega, alpha = y[omega_at(n) + i], rate[omega_at(n) + i]
        w2 = omega * omega
        # a_{i+1} = a_i + α L⊥ − ω² L
        ax -= alpha * link.y[i] + w2 * link.x[i]
        ay += alpha * link.x[i] - w2 * link.y[i]
    acceleration.x[n], acceleration.y[n] = ax, ay
    if d.model.jointed:
        place_joints(d, rate, omega_at(n), acceleration)


def zero(d, vectors):
    """Set the vectors of all places to zero."""
    # the compiler knows the number of links, and of points
    for k in range(d.links + 1):
        vectors.x[k], vectors.y[k] = 0.0, 0.0
    if d.model.jointed:
        for k in range(d.links + 1, 2 * d.links + 1):
            vectors.x[k], vectors.y[k] = 0.0, 0.0


def clear_joints(values):
    """Set the moments in, or the impedances of, all joints to zero."""
    for i in range(len(values.joint)):
        values.joint[i] = 0.0


def link_vectors(d, y):
    """Set L_i [m], the vector from the proximal to the distal joint of each link, for the state y."""
    note_points_elsewhere(d)
    polar(d.model.length, y, ANGLES, d.work.link.x, d.work.link.y)


def note_points_at_end(d):
    """Note that the points are located and accelerated at the end of the last step."""
    d.work.at_end = 1


def note_points_elsewhere(d):
    """Note that the points are not, or not any more, those at the end of the last step."""
    d.work.at_end = 0


def move_points(d, links, change, motion):
    """Motion of the places that follows from a change of the coordinates: Δp_{i+1} = Δp_i + Δθ_i L⊥."""
    n = d.links
    x, y = change[0], change[1]
    for i in range(n):
        motion.x[i], motion.y[i] = x, y
        x -= change[ANGLES + i] * links.y[i]
        y += change[ANGLES + i] * links.x[i]
    motion.x[n], motion.y[n] = x, y
    if d.model.jointed:
        place_joints(d, change, ANGLES, motion)


def largest(d, vectors):
    """The largest component of the vectors of all places."""
    most = 0.0
    for k in range(d.links + 1):
        most = max(most, abs(vectors.x[k]), abs(vectors.y[k]))
    if d.model.jointed:
        for k in range(d.links + 1, 2 * d.links + 1):
            most = max(most, abs(vectors.x[k]))
    return most

"""Kinematics of the chain: where its points are, how fast they move and how they accelerate.

Vectors of all points are records with ``x, y``, shape (N+1,). In a scene with stops they have also ``turn``,
shape (N+1,): for joint i = 1…N the motion of its own angle, θ_i − θ_{i−1}.
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
    if d.model.stopped:
        turn_joints(n, y, ANGLES, position.turn)
        turn_joints(n, y, omega_at(n), velocity.turn)


def turn_joints(n, values, first, turn):
    """Set ``turn`` to the differences of N values of links, from the ``first`` on; the base has 0."""
    before = 0.0
    for i in range(n):
        turn[i + 1] = values[first + i] - before
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
    if d.model.stopped:
        turn_joints(n, rate, omega_at(n), acceleration.turn)


def zero(vectors):
    """Set the vectors of all points to zero."""
    for k in range(len(vectors.x)):
        vectors.x[k], vectors.y[k] = 0.0, 0.0


def link_vectors(d, y):
    """Set L_i [m], the vector from the proximal to the distal joint of each link, for the state y."""
    d.work.at_end = 0
    polar(d.model.length, y, ANGLES, d.work.link.x, d.work.link.y)


def move_points(links, change, motion):
    """Motion of the points that follows from a change of the coordinates: Δp_{i+1} = Δp_i + Δθ_i L⊥."""
    n = len(motion.x) - 1
    x, y = change[0], change[1]
    for i in range(n):
        motion.x[i], motion.y[i] = x, y
        x -= change[ANGLES + i] * links.y[i]
        y += change[ANGLES + i] * links.x[i]
    motion.x[n], motion.y[n] = x, y


def largest(vectors):
    """The largest component of the vectors of all points."""
    most = 0.0
    for k in range(len(vectors.x)):
        most = max(most, abs(vectors.x[k]), abs(vectors.y[k]))
    return most

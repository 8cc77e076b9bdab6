"""Recursive Gibbs–Appell dynamics of a planar open chain, in O(N).

A revolute joint transmits a force and, apart from its known torque, no moment. The part of the chain
hanging from joint i therefore answers an acceleration ``a`` of that joint with the force ``A a + b``:
``A`` a symmetric 2×2 articulated inertia, ``b`` collecting ω², gravity, torques and contact forces.
Appell's equation for α_i, ∂S/∂α_i = Q_i with the Gibbs function S = Σ ½ m a_C·a_C + ½ I α², eliminates
α_i; repeated from the tip to the base it leaves two equations for the base, and the accelerations
follow from the base back out.

The absolute link angles θ_i are the coordinates and all vectors are in the world frame, so no rotation
matrix appears: L_i is the vector along link i, c_i the one to its centre of mass, x⊥ = ẑ × x.

Source: the recursion after Ahmadizadeh, Shafei, Fooladi, *A recursive algorithm for dynamics of multiple
frictionless impact-contacts in open-loop robotic mechanisms*, Mechanism and Machine Theory; the
elimination in this form is derived in docs/computation.md.
"""

import math

from chain_impact.kernel.jit import jit
from chain_impact.kernel.sincos import LARGEST, sine_cosine


@jit
def link_vectors(model, angle, work):
    """Set L_i [m], the vector from the proximal to the distal joint of each link."""
    total = 0.0
    for i in range(len(model.length)):
        total += abs(angle[i])
    if total < LARGEST:
        for i in range(len(model.length)):
            sine, cosine = sine_cosine(angle[i])
            work.link.x[i] = model.length[i] * cosine
            work.link.y[i] = model.length[i] * sine
    else:
        for i in range(len(model.length)):
            work.link.x[i] = model.length[i] * math.cos(angle[i])
            work.link.y[i] = model.length[i] * math.sin(angle[i])


@jit
def accelerations(model, omega, work, base_acceleration, alpha):
    """Solve the equations of motion for the accelerations.

    Args:
        model: the model record.
        omega: angular velocities ω_i, shape (N,) [rad/s].
        work: the work record; reads ``link`` (L_i), ``load`` (external force on each
            point 0..N) [N] and ``moment`` (net joint torque on each link) [N·m].
        base_acceleration: result, shape (2,) [m/s²]; zero for a pinned base.
        alpha: result, angular accelerations α_i, shape (N,) [rad/s²].
    """
    n = len(model.length)
    gx, gy = model.gravity[0], model.gravity[1]
    kept = work.elimination
    # beyond the tip there is only the load on it: A' = 0, b' = −f_N
    axx, axy, ayy = 0.0, 0.0, 0.0
    bx, by = -work.load.x[n], -work.load.y[n]

    # eliminate α_i from the tip to the base
    for i in range(n - 1, -1, -1):
        m = model.mass[i]
        lx, ly = work.link.x[i], work.link.y[i]
        ratio = model.center_of_mass_ratio[i]
        # m c, the first moment of mass about the proximal joint
        sx, sy = m * ratio * lx, m * ratio * ly
        w2 = omega[i] * omega[i]
        # A' L⊥
        px, py = axy * lx - axx * ly, ayy * lx - axy * ly
        # b' − ω² A' L : what the child asks of the distal joint for α_i = 0, a_i = 0
        dx = bx - w2 * (axx * lx + axy * ly)
        dy = by - w2 * (axy * lx + ayy * ly)
        # h = m c⊥ + A' L⊥
        hx, hy = px - sy, py + sx
        # H = I + m c² + L⊥·A' L⊥   (I + m c² is constant)
        inverse = 1.0 / (model.joint_inertia[i] + lx * py - ly * px)
        # h₀ = L⊥·(b' − ω² A' L) − m c⊥·g − τ
        h0 = lx * dy - ly * dx + sy * gx - sx * gy - work.moment[i]
        # A = A' + m 1 − h hᵀ/H
        kx, ky = hx * inverse, hy * inverse
        axx += m - hx * kx
        axy -= hx * ky
        ayy += m - hy * ky
        # b = b' − ω²(m c + A' L) − m g − h h₀/H, less the load on the proximal joint
        bx = dx - w2 * sx - m * gx - kx * h0 - work.load.x[i]
        by = dy - w2 * sy - m * gy - ky * h0 - work.load.y[i]
        kept.gain_x[i], kept.gain_y[i], kept.bias[i] = kx, ky, h0 * inverse

    # the base: A a₀ + b = 0 when free, a₀ = 0 when pinned
    ax, ay = 0.0, 0.0
    if not model.pinned:
        determinant = axx * ayy - axy * axy
        ax = (axy * by - ayy * bx) / determinant
        ay = (axy * bx - axx * by) / determinant
    base_acceleration[0] = ax
    base_acceleration[1] = ay

    # accelerations back out
    for i in range(n):
        # α = −(h·a + h₀)/H
        a = -(kept.gain_x[i] * ax + kept.gain_y[i] * ay + kept.bias[i])
        alpha[i] = a
        w2 = omega[i] * omega[i]
        # a_{i+1} = a_i + α L⊥ − ω² L
        ax -= a * work.link.y[i] + w2 * work.link.x[i]
        ay += a * work.link.x[i] - w2 * work.link.y[i]


@jit
def factorize(model, links, impedance, factors):
    """Eliminate M + Jᵀ D J, with D a diagonal impedance at the points, by the same recursion.

    Args:
        model: the model record.
        links: record with ``x, y``, shape (N+1,): the link vectors L_i [m] (entry N is not used).
        impedance: record with ``x, y``, shape (N+1,): added inertia of each point along the axes [kg].
        factors: record for the result, used by ``solve``.
    """
    n = len(model.length)
    axx, axy, ayy = impedance.x[n], 0.0, impedance.y[n]
    for i in range(n - 1, -1, -1):
        m = model.mass[i]
        lx, ly = links.x[i], links.y[i]
        first = m * model.center_of_mass_ratio[i]
        # h = m c⊥ + A' L⊥,  H = I + m c² + L⊥·A' L⊥
        px, py = axy * lx - axx * ly, ayy * lx - axy * ly
        hx, hy = px - first * ly, py + first * lx
        inverse = 1.0 / (model.joint_inertia[i] + lx * py - ly * px)
        # A = A' + m 1 + D − h hᵀ/H
        kx, ky = hx * inverse, hy * inverse
        axx += m - hx * kx + impedance.x[i]
        axy -= hx * ky
        ayy += m - hy * ky + impedance.y[i]
        factors.gain_x[i], factors.gain_y[i], factors.inverse[i] = kx, ky, inverse
    # A⁻¹ of the base, 0 when it is pinned
    scale = 0.0 if model.pinned else 1.0 / (axx * ayy - axy * axy)
    factors.base[0], factors.base[1], factors.base[2] = ayy * scale, -axy * scale, axx * scale


@jit
def solve(links, factors, load, base, angular):
    """Solve (M + Jᵀ D J) (base, angular) = Jᵀ load: the response to impulses on the points.

    Args:
        links: as for ``factorize``.
        factors: its result.
        load: record with ``x, y``, shape (N+1,): impulse on each point [N·s] (or force [N]).
        base: result, change of the base's velocity, shape (2,) [m/s] (or acceleration).
        angular: result, change of the angular velocities, shape (N,) [rad/s].
    """
    n = len(angular)
    bx, by = load.x[n], load.y[n]
    for i in range(n - 1, -1, -1):
        moment = links.x[i] * by - links.y[i] * bx
        angular[i] = moment * factors.inverse[i]
        bx += load.x[i] - factors.gain_x[i] * moment
        by += load.y[i] - factors.gain_y[i] * moment
    x = factors.base[0] * bx + factors.base[1] * by
    y = factors.base[1] * bx + factors.base[2] * by
    base[0], base[1] = x, y
    for i in range(n):
        a = angular[i] - factors.gain_x[i] * x - factors.gain_y[i] * y
        angular[i] = a
        x -= a * links.y[i]
        y += a * links.x[i]


@jit
def move_points(links, base, angular, motion):
    """Motion of the points that a motion (base, angular) of the coordinates makes: p_{i+1} = p_i + a L⊥."""
    x, y = base[0], base[1]
    for i in range(len(angular)):
        motion.x[i], motion.y[i] = x, y
        x -= angular[i] * links.y[i]
        y += angular[i] * links.x[i]
    motion.x[len(angular)], motion.y[len(angular)] = x, y

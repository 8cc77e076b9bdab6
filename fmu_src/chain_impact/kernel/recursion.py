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

from chain_impact.kernel.jit import jit
from chain_impact.kernel.sincos import cosines_sines


@jit
def link_vectors(model, angle, work):
    """Set L_i [m], the vector from the proximal to the distal joint of each link."""
    cosines_sines(angle, work.link.x, work.link.y)
    for i in range(len(model.length)):
        work.link.x[i] *= model.length[i]
        work.link.y[i] *= model.length[i]


@jit
def arm(model, link, i, outward):
    """Link i as its arm of the chain sees it, from the joint nearer to the middle.

    Returns:
        The vector to the other joint [m], that to the centre of mass times the mass [kg·m], and the
        inertia about the joint [kg·m²].
    """
    lx, ly = link.x[i], link.y[i]
    if outward:
        first = model.mass[i] * model.center_of_mass_ratio[i]
        return lx, ly, first * lx, first * ly, model.proximal_inertia[i]
    first = model.mass[i] * (1.0 - model.center_of_mass_ratio[i])
    return -lx, -ly, -first * lx, -first * ly, model.distal_inertia[i]


@jit
def gain(lx, ly, sx, sy, inertia, axx, axy, ayy):
    """Gain h/H of a link and h, for A' at its outer joint; also 1/H and A' L⊥."""
    # A' L⊥
    px, py = axy * lx - axx * ly, ayy * lx - axy * ly
    # h = m c⊥ + A' L⊥
    hx, hy = px - sy, py + sx
    # H = I + m c² + L⊥·A' L⊥
    inverse = 1.0 / (inertia + lx * py - ly * px)
    return hx * inverse, hy * inverse, hx, hy, inverse


@jit
def eliminate(model, work, omega, i, outward, joint, axx, axy, ayy, bx, by):
    """Eliminate α_i: from A' and b' at its outer joint to A and b at its inner one."""
    lx, ly, sx, sy, inertia = arm(model, work.link, i, outward)
    kx, ky, hx, hy, inverse = gain(lx, ly, sx, sy, inertia, axx, axy, ayy)
    m, gx, gy = model.mass[i], model.gravity[0], model.gravity[1]
    w2 = omega[i] * omega[i]
    # d = b' − f − ω² A' L : what the outer joint asks for α_i = 0, a_i = 0
    dx = bx - work.load.x[joint] - w2 * (axx * lx + axy * ly)
    dy = by - work.load.y[joint] - w2 * (axy * lx + ayy * ly)
    # h₀ = L⊥·d − m c⊥·g − τ
    h0 = lx * dy - ly * dx + sy * gx - sx * gy - work.moment[i]
    kept = work.elimination
    kept.gain_x[i], kept.gain_y[i], kept.bias[i] = kx, ky, h0 * inverse
    # A = A' + m 1 − h hᵀ/H,  b = d − ω² m c − m g − h h₀/H
    return (
        axx + m - hx * hx * inverse,
        axy - hx * hy * inverse,
        ayy + m - hy * hy * inverse,
        dx - w2 * sx - m * gx - hx * h0 * inverse,
        dy - w2 * sy - m * gy - hy * h0 * inverse,
    )


@jit
def accelerate(model, work, omega, i, outward, ax, ay, alpha):
    """Set α_i for the acceleration of its inner joint; return that of its outer one."""
    kept = work.elimination
    # α = −(h·a + h₀)/H
    a = -(kept.gain_x[i] * ax + kept.gain_y[i] * ay + kept.bias[i])
    alpha[i] = a
    w2 = omega[i] * omega[i]
    sign = 1.0 if outward else -1.0
    lx, ly = sign * work.link.x[i], sign * work.link.y[i]
    # a' = a + α L⊥ − ω² L
    return ax - (a * ly + w2 * lx), ay + (a * lx - w2 * ly)


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
    n, middle = len(model.length), model.middle
    axx, axy, ayy, bx, by = 0.0, 0.0, 0.0, 0.0, 0.0
    cxx, cxy, cyy, dx, dy = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(n - middle):
        i = n - 1 - k
        axx, axy, ayy, bx, by = eliminate(model, work, omega, i, True, i + 1, axx, axy, ayy, bx, by)
        if k < middle:
            cxx, cxy, cyy, dx, dy = eliminate(model, work, omega, k, False, k, cxx, cxy, cyy, dx, dy)

    # the middle joint: A a + b = 0 when the base is free; it is the base, and a = 0, when that is pinned
    ax, ay = 0.0, 0.0
    if not model.pinned:
        axx, axy, ayy = axx + cxx, axy + cxy, ayy + cyy
        bx, by = bx + dx - work.load.x[middle], by + dy - work.load.y[middle]
        determinant = axx * ayy - axy * axy
        ax = (axy * by - ayy * bx) / determinant
        ay = (axy * bx - axx * by) / determinant

    # accelerations back out
    cx, cy = ax, ay
    for k in range(n - middle):
        ax, ay = accelerate(model, work, omega, middle + k, True, ax, ay, alpha)
        if k < middle:
            cx, cy = accelerate(model, work, omega, middle - 1 - k, False, cx, cy, alpha)
    base_acceleration[0] = cx
    base_acceleration[1] = cy


@jit
def factorize(model, links, impedance, factors):
    """Eliminate M + Jᵀ D J, with D a diagonal impedance at the points, by the same recursion.

    Args:
        model: the model record.
        links: record with ``x, y``, shape (N+1,): the link vectors L_i [m] (entry N is not used).
        impedance: record with ``x, y``, shape (N+1,): added inertia of each point along the axes [kg].
        factors: record for the result, used by ``solve``.
    """
    n, middle = len(model.length), model.middle
    axx, axy, ayy = 0.0, 0.0, 0.0
    cxx, cxy, cyy = 0.0, 0.0, 0.0
    for k in range(n - middle):
        i = n - 1 - k
        axx, axy, ayy = factorize_link(model, links, impedance, factors, i, True, i + 1, axx, axy, ayy)
        if k < middle:
            cxx, cxy, cyy = factorize_link(model, links, impedance, factors, k, False, k, cxx, cxy, cyy)
    axx, axy, ayy = axx + cxx + impedance.x[middle], axy + cxy, ayy + cyy + impedance.y[middle]
    # A⁻¹ of the middle joint, 0 when that is a pinned base
    scale = 0.0 if model.pinned else 1.0 / (axx * ayy - axy * axy)
    factors.middle[0], factors.middle[1], factors.middle[2] = ayy * scale, -axy * scale, axx * scale


@jit
def factorize_link(model, links, impedance, factors, i, outward, joint, axx, axy, ayy):
    """As ``eliminate``, for A alone."""
    axx += impedance.x[joint]
    ayy += impedance.y[joint]
    lx, ly, sx, sy, inertia = arm(model, links, i, outward)
    kx, ky, hx, hy, inverse = gain(lx, ly, sx, sy, inertia, axx, axy, ayy)
    factors.gain_x[i], factors.gain_y[i], factors.inverse[i] = kx, ky, inverse
    m = model.mass[i]
    return axx + m - hx * hx * inverse, axy - hx * hy * inverse, ayy + m - hy * hy * inverse


@jit
def solve(model, links, factors, load, base, angular):
    """Solve (M + Jᵀ D J) (base, angular) = Jᵀ load: the response to impulses on the points.

    Args:
        model: the model record.
        links: as for ``factorize``.
        factors: its result.
        load: record with ``x, y``, shape (N+1,): impulse on each point [N·s] (or force [N]).
        base: result, change of the base's velocity, shape (2,) [m/s] (or acceleration).
        angular: result, change of the angular velocities, shape (N,) [rad/s].
    """
    n, middle = len(angular), model.middle
    bx, by, cx, cy = 0.0, 0.0, 0.0, 0.0
    for k in range(n - middle):
        i = n - 1 - k
        bx, by = gather(links, factors, load, i, 1.0, i + 1, bx, by, angular)
        if k < middle:
            cx, cy = gather(links, factors, load, k, -1.0, k, cx, cy, angular)
    bx, by = bx + cx + load.x[middle], by + cy + load.y[middle]
    x = factors.middle[0] * bx + factors.middle[1] * by
    y = factors.middle[1] * bx + factors.middle[2] * by
    cx, cy = x, y
    for k in range(n - middle):
        x, y = spread(links, factors, middle + k, 1.0, x, y, angular)
        if k < middle:
            cx, cy = spread(links, factors, middle - 1 - k, -1.0, cx, cy, angular)
    base[0], base[1] = cx, cy


@jit
def gather(links, factors, load, i, sign, joint, bx, by, angular):
    """Set α_i for an inner joint at rest, and return the impulse that arrives there."""
    bx += load.x[joint]
    by += load.y[joint]
    moment = sign * (links.x[i] * by - links.y[i] * bx)
    angular[i] = moment * factors.inverse[i]
    return bx - factors.gain_x[i] * moment, by - factors.gain_y[i] * moment


@jit
def spread(links, factors, i, sign, x, y, angular):
    """Correct α_i for the motion of its inner joint; return that of its outer one."""
    a = angular[i] - factors.gain_x[i] * x - factors.gain_y[i] * y
    angular[i] = a
    return x - sign * a * links.y[i], y + sign * a * links.x[i]


@jit
def move_points(links, base, angular, motion):
    """Motion of the points that a motion (base, angular) of the coordinates makes: p_{i+1} = p_i + a L⊥."""
    x, y = base[0], base[1]
    for i in range(len(angular)):
        motion.x[i], motion.y[i] = x, y
        x -= angular[i] * links.y[i]
        y += angular[i] * links.x[i]
    motion.x[len(angular)], motion.y[len(angular)] = x, y

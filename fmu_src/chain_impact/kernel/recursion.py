"""Recursive Gibbs–Appell dynamics of a planar open chain, in O(N).

A revolute joint transmits a force and, apart from its known torque, no moment. The part of the chain
hanging from a joint therefore answers an acceleration ``a`` of that joint with the force ``A a + b``:
``A`` a symmetric 2×2 articulated inertia, ``b`` collecting ω², gravity, torques and contact forces.
Appell's equation for α_i, ∂S/∂α_i = Q_i with the Gibbs function S = Σ ½ m a_C·a_C + ½ I α², eliminates α_i.

A free chain has two free ends. It is eliminated from both toward its middle joint, where two equations are
left, and the accelerations follow from there back out. The two arms do not wait for each other, which halves
the time of a short chain. A pinned base is an end that is not free: it takes the place of the middle.

The absolute link angles θ_i are the coordinates and all vectors are in the world frame, so no rotation
matrix appears: L is the vector along a link from the joint nearer to the middle, c that to its centre of
mass, x⊥ = ẑ × x. A' and b' belong to the joint farther out, A and b to the nearer one.

Source: the recursion after Ahmadizadeh, Shafei, Fooladi, *A recursive algorithm for dynamics of multiple
frictionless impact-contacts in open-loop robotic mechanisms*, Mechanism and Machine Theory; the
elimination in this form is derived in docs/computation.md.
"""

from chain_impact.kernel.jit import inlined, jit
from chain_impact.kernel.sincos import polar


@jit
def link_vectors(model, y, work):
    """Set L_i [m], the vector from the proximal to the distal joint of each link, for the state y."""
    polar(model.length, y, 2, work.link.x, work.link.y)


@jit
def arm(model, link, i, outward):
    """Link i as seen from its joint nearer to the middle: the proximal one if it points ``outward``.

    Returns:
        L [m], m c [kg·m] and I + m c² [kg·m²].
    """
    lx, ly = link.x[i], link.y[i]
    if outward:
        first = model.mass[i] * model.center_of_mass_ratio[i]
        return lx, ly, first * lx, first * ly, model.proximal_inertia[i]
    first = model.mass[i] * (1.0 - model.center_of_mass_ratio[i])
    return -lx, -ly, -first * lx, -first * ly, model.distal_inertia[i]


@jit
def hinge(lx, ly, sx, sy, inertia, axx, axy, ayy):
    """Return h and 1/H for L, m c, I + m c² and A'."""
    # h = m c⊥ + A' L⊥
    hx, hy = axy * lx - axx * ly - sy, ayy * lx - axy * ly + sx
    # H = I + m c² + L⊥·A' L⊥, on which all else waits
    return hx, hy, 1.0 / ((inertia + ayy * (lx * lx)) + (axx * (ly * ly) - axy * (2.0 * lx * ly)))


@jit
def eliminate(model, work, y, i, outward, axx, axy, ayy, bx, by):
    """Eliminate α_i: return A and b for A' and b'."""
    joint, omega = i + 1 if outward else i, y[len(model.length) + 4 + i]
    link = lx, ly, sx, sy, inertia = arm(model, work.link, i, outward)
    w2 = omega * omega
    # d = b' − f − ω² A' L : what the outer joint asks for α = 0 and a = 0
    dx = bx - work.load.x[joint] - w2 * (axx * lx + axy * ly)
    dy = by - work.load.y[joint] - w2 * (axy * lx + ayy * ly)
    hx, hy, inverse = hinge(lx, ly, sx, sy, inertia, axx, axy, ayy)
    return take_out(model, work, i, w2, link, hx, hy, inverse, axx, axy, ayy, dx, dy)


@jit
def eliminate_end(model, work, y, i, outward):
    """As ``eliminate``, for the link at a free end: A' = 0 and b' = 0, and no quotient to wait for."""
    joint, omega = i + 1 if outward else i, y[len(model.length) + 4 + i]
    link = _, _, sx, sy, inertia = arm(model, work.link, i, outward)
    dx, dy = -work.load.x[joint], -work.load.y[joint]
    w2 = omega * omega
    return take_out(model, work, i, w2, link, -sy, sx, 1.0 / inertia, 0.0, 0.0, 0.0, dx, dy)


@jit
def take_out(model, work, i, w2, link, hx, hy, inverse, axx, axy, ayy, dx, dy):
    """Return A and b for A' and d; keep what ``accelerate`` needs of link i."""
    lx, ly, sx, sy, _ = link
    m, gx, gy = model.mass[i], model.gravity[0], model.gravity[1]
    # h₀ = L⊥·d − m c⊥·g − τ
    h0 = (lx * dy - ly * dx) + (sy * gx - sx * gy - work.moment[i])
    kx, ky = hx * inverse, hy * inverse
    kept = work.elimination
    kept.gain_x[i], kept.gain_y[i], kept.bias[i] = kx, ky, h0 * inverse
    # A = A' + m 1 − h hᵀ/H,  b = d − ω² m c − m g − h h₀/H
    return (
        (axx + m) - hx * kx,
        axy - hx * ky,
        (ayy + m) - hy * ky,
        (dx - w2 * sx - m * gx) - kx * h0,
        (dy - w2 * sy - m * gy) - ky * h0,
    )


@jit
def accelerate(model, work, y, i, outward, ax, ay, rate):
    """Set α_i for the acceleration of its inner joint; return that of the outer one."""
    kept, own = work.elimination, len(model.length) + 4 + i
    # α = −(h·a + h₀)/H
    a = -(kept.gain_x[i] * ax + kept.gain_y[i] * ay + kept.bias[i])
    rate[own] = a
    w2 = y[own] * y[own]
    sign = 1.0 if outward else -1.0
    lx, ly = sign * work.link.x[i], sign * work.link.y[i]
    # a' = a + α L⊥ − ω² L
    return (ax - w2 * lx) - a * ly, (ay - w2 * ly) + a * lx


@jit
def accelerations(model, y, work, rate):
    """Solve the equations of motion for the accelerations.

    Args:
        model: the model record.
        y: state, of which the angular velocities ω_i [rad/s] are read.
        work: the work record; reads ``link`` (L_i), ``load`` (external force on each
            point 0..N) [N] and ``moment`` (net joint torque on each link) [N·m].
        rate: result, of which the accelerations of the base [m/s²], zero if it is pinned, and of the links
            [rad/s²] are set.
    """
    # twice, so that the compiler knows the middle joint
    if model.pinned:
        arms(model, y, work, rate, 0)
    else:
        arms(model, y, work, rate, len(model.length) // 2)


@inlined
def arms(model, y, work, rate, middle):
    """As ``accelerations``, for the joint at which the arms of the elimination meet."""
    n = len(model.length)
    axx, axy, ayy, bx, by = eliminate_end(model, work, y, n - 1, True)
    cxx, cxy, cyy, dx, dy = 0.0, 0.0, 0.0, 0.0, 0.0
    if middle > 0:
        cxx, cxy, cyy, dx, dy = eliminate_end(model, work, y, 0, False)
    for k in range(1, n - middle):
        i = n - 1 - k
        axx, axy, ayy, bx, by = eliminate(model, work, y, i, True, axx, axy, ayy, bx, by)
        if k < middle:
            cxx, cxy, cyy, dx, dy = eliminate(model, work, y, k, False, cxx, cxy, cyy, dx, dy)

    # the middle joint: A a + b = 0 when the base is free; it is the base, and a = 0, when that is pinned
    ax, ay = 0.0, 0.0
    if middle > 0 or not model.pinned:
        axx, axy, ayy = axx + cxx, axy + cxy, ayy + cyy
        bx, by = bx + dx - work.load.x[middle], by + dy - work.load.y[middle]
        determinant = axx * ayy - axy * axy
        ax = (axy * by - ayy * bx) / determinant
        ay = (axy * bx - axx * by) / determinant

    # accelerations back out
    cx, cy = ax, ay
    for k in range(n - middle):
        ax, ay = accelerate(model, work, y, middle + k, True, ax, ay, rate)
        if k < middle:
            cx, cy = accelerate(model, work, y, middle - 1 - k, False, cx, cy, rate)
    rate[n + 2] = cx
    rate[n + 3] = cy


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
        axx, axy, ayy = factorize_link(model, links, impedance, factors, i, True, axx, axy, ayy)
        if k < middle:
            cxx, cxy, cyy = factorize_link(model, links, impedance, factors, k, False, cxx, cxy, cyy)
    axx, axy, ayy = axx + cxx + impedance.x[middle], axy + cxy, ayy + cyy + impedance.y[middle]
    # A⁻¹ of the middle joint, 0 when that is a pinned base
    scale = 0.0 if model.pinned else 1.0 / (axx * ayy - axy * axy)
    factors.middle[0], factors.middle[1], factors.middle[2] = ayy * scale, -axy * scale, axx * scale


@jit
def factorize_link(model, links, impedance, factors, i, outward, axx, axy, ayy):
    """As ``eliminate``, for A alone."""
    joint = i + 1 if outward else i
    axx += impedance.x[joint]
    ayy += impedance.y[joint]
    lx, ly, sx, sy, inertia = arm(model, links, i, outward)
    hx, hy, inverse = hinge(lx, ly, sx, sy, inertia, axx, axy, ayy)
    factors.gain_x[i], factors.gain_y[i], factors.inverse[i] = hx * inverse, hy * inverse, inverse
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
        bx, by = gather(links, factors, load, i, True, bx, by, angular)
        if k < middle:
            cx, cy = gather(links, factors, load, k, False, cx, cy, angular)
    bx, by = bx + cx + load.x[middle], by + cy + load.y[middle]
    x = factors.middle[0] * bx + factors.middle[1] * by
    y = factors.middle[1] * bx + factors.middle[2] * by
    cx, cy = x, y
    for k in range(n - middle):
        x, y = spread(links, factors, middle + k, True, x, y, angular)
        if k < middle:
            cx, cy = spread(links, factors, middle - 1 - k, False, cx, cy, angular)
    base[0], base[1] = cx, cy


@jit
def gather(links, factors, load, i, outward, bx, by, angular):
    """Set the change of ω_i for an inner joint at rest; return the impulse that arrives there."""
    joint, sign = (i + 1, 1.0) if outward else (i, -1.0)
    bx += load.x[joint]
    by += load.y[joint]
    moment = sign * (links.x[i] * by - links.y[i] * bx)
    angular[i] = moment * factors.inverse[i]
    return bx - factors.gain_x[i] * moment, by - factors.gain_y[i] * moment


@jit
def spread(links, factors, i, outward, x, y, angular):
    """Correct the change of ω_i for that of its inner joint's velocity; return that of the outer one."""
    sign = 1.0 if outward else -1.0
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

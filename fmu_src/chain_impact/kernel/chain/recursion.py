"""Recursive Gibbs–Appell dynamics of a planar open chain, in O(N).

A revolute joint transmits a force and, apart from its known torque, no moment. The outer part of the chain at
a joint therefore needs the force ``A a + b`` for an acceleration ``a`` of that joint: ``A`` is a symmetric
2×2 articulated inertia, ``b`` collects the terms of ω², gravity, torques and contact forces. Appell's
equation for α_i, ∂S/∂α_i = Q_i with the Gibbs function S = Σ ½ m a_C·a_C + ½ I α², eliminates α_i.

A free chain has two free ends. It is eliminated from both toward its middle joint, where two equations are
left, and the accelerations follow from there back out. The two arms are independent, so a processor overlaps
their operations, which halves the time of a short chain. A pinned base is not a free end: it takes the place
of the middle.

The absolute link angles θ_i are the coordinates and all vectors are in the world frame, so no rotation
matrix appears: L is the vector along a link from the joint nearer to the middle, c that to its centre of
mass, x⊥ = ẑ × x. A' and b' belong to the joint farther out, A and b to the nearer one.

Source: the recursion after Ahmadizadeh, Shafei, Fooladi, *A recursive algorithm for dynamics of multiple
frictionless impact-contacts in open-loop robotic mechanisms*, Mechanism and Machine Theory; the
elimination in this form is derived in docs/computation.md.
"""

from chain_impact.kernel.chain.state import ANGLES, omega_at, velocity_at
from chain_impact.kernel.inlining import inlined


def arm(d, link, i, outward):
    """Link i as seen from its joint nearer to the middle: the proximal one if it points ``outward``.

    Returns:
        L [m], m c [kg·m] and I + m c² [kg·m²].
    """
    lx, ly = link.x[i], link.y[i]
    if outward:
        first = d.model.mass[i] * d.model.center_of_mass_ratio[i]
        return lx, ly, first * lx, first * ly, d.model.proximal_inertia[i]
    first = d.model.mass[i] * (1.0 - d.model.center_of_mass_ratio[i])
    return -lx, -ly, -first * lx, -first * ly, d.model.distal_inertia[i]


def hinge(lx, ly, sx, sy, inertia, axx, axy, ayy):
    """Return h and 1/H for L, m c, I + m c² and A'."""
    # h = m c⊥ + A' L⊥
    hx, hy = axy * lx - axx * ly - sy, ayy * lx - axy * ly + sx
    # H = I + m c² + L⊥·A' L⊥, first, as all other results depend on it
    return hx, hy, 1.0 / ((inertia + ayy * (lx * lx)) + (axx * (ly * ly) - axy * (2.0 * lx * ly)))


def eliminate(d, y, i, outward, axx, axy, ayy, bx, by):
    """Eliminate α_i: return A and b for A' and b'."""
    joint, omega = i + 1 if outward else i, y[omega_at(d.links) + i]
    link = lx, ly, sx, sy, inertia = arm(d, d.work.link, i, outward)
    w2 = omega * omega
    # d = b' − f − ω² A' L: the force at the outer joint for α = 0 and a = 0
    dx = bx - d.work.load.x[joint] - w2 * (axx * lx + axy * ly)
    dy = by - d.work.load.y[joint] - w2 * (axy * lx + ayy * ly)
    hx, hy, inverse = hinge(lx, ly, sx, sy, inertia, axx, axy, ayy)
    return eliminate_link(d, i, w2, link, hx, hy, inverse, axx, axy, ayy, dx, dy)


def eliminate_end(d, y, i, outward):
    """As ``eliminate``, for the link at a free end: A' = 0 and b' = 0, so 1/H depends on no other link."""
    joint, omega = i + 1 if outward else i, y[omega_at(d.links) + i]
    link = _, _, sx, sy, inertia = arm(d, d.work.link, i, outward)
    dx, dy = -d.work.load.x[joint], -d.work.load.y[joint]
    w2 = omega * omega
    return eliminate_link(d, i, w2, link, -sy, sx, 1.0 / inertia, 0.0, 0.0, 0.0, dx, dy)


def eliminate_link(d, i, w2, link, hx, hy, inverse, axx, axy, ayy, dx, dy):
    """Return A and b for A' and d; store what ``accelerate`` and ``solve`` need of link i."""
    lx, ly, sx, sy, _ = link
    m, gx, gy = d.model.mass[i], d.model.gravity[0], d.model.gravity[1]
    # h₀ = L⊥·d − m c⊥·g − τ
    h0 = (lx * dy - ly * dx) + (sy * gx - sx * gy - d.work.moment[i])
    kx, ky = hx * inverse, hy * inverse
    kept = d.work.elimination
    kept.gain_x[i], kept.gain_y[i], kept.inverse[i], kept.bias[i] = kx, ky, inverse, h0 * inverse
    # A = A' + m 1 − h hᵀ/H,  b = d − ω² m c − m g − h h₀/H
    return (
        (axx + m) - hx * kx,
        axy - hx * ky,
        (ayy + m) - hy * ky,
        (dx - w2 * sx - m * gx) - kx * h0,
        (dy - w2 * sy - m * gy) - ky * h0,
    )


def accelerate(d, y, i, outward, ax, ay, rate):
    """Set α_i for the acceleration of its inner joint; return that of the outer one."""
    kept, own = d.work.elimination, omega_at(d.links) + i
    # α = −(h·a + h₀)/H
    a = -(kept.gain_x[i] * ax + kept.gain_y[i] * ay + kept.bias[i])
    rate[own] = a
    w2 = y[own] * y[own]
    sign = 1.0 if outward else -1.0
    lx, ly = sign * d.work.link.x[i], sign * d.work.link.y[i]
    # a' = a + α L⊥ − ω² L
    return (ax - w2 * lx) - a * ly, (ay - w2 * ly) + a * lx


def accelerations(d, y, rate):
    """Solve the equations of motion for the accelerations.

    Args:
        d: the instance; reads ``work.link`` (L_i), ``work.load`` (external force on each point 0..N) [N] and
            ``work.moment`` (net joint torque on each link) [N·m].
        y: state, of which the angular velocities ω_i [rad/s] are read.
        rate: result, of which the accelerations of the base [m/s²], zero if it is pinned, and of the links
            [rad/s²] are set.

    What the recursion keeps in ``work.elimination`` serves ``solve``, too, after ``set_middle``.
    """
    # two calls, so that in the first the middle joint is a constant for the compiler
    if d.model.pinned:
        arms(d, y, rate, 0)
    else:
        arms(d, y, rate, d.links // 2)


@inlined
def arms(d, y, rate, middle):
    """As ``accelerations``, for the joint at which the arms of the elimination meet."""
    n = d.links
    axx, axy, ayy, bx, by = eliminate_end(d, y, n - 1, True)
    cxx, cxy, cyy, dx, dy = 0.0, 0.0, 0.0, 0.0, 0.0
    if middle > 0:
        cxx, cxy, cyy, dx, dy = eliminate_end(d, y, 0, False)
    for k in range(1, n - middle):
        i = n - 1 - k
        axx, axy, ayy, bx, by = eliminate(d, y, i, True, axx, axy, ayy, bx, by)
        if k < middle:
            cxx, cxy, cyy, dx, dy = eliminate(d, y, k, False, cxx, cxy, cyy, dx, dy)

    # the middle joint: A a + b = 0 when the base is free; it is the base, and a = 0, when that is pinned
    ax, ay = 0.0, 0.0
    if middle > 0 or not d.model.pinned:
        axx, axy, ayy = axx + cxx, axy + cxy, ayy + cyy
        bx, by = bx + dx - d.work.load.x[middle], by + dy - d.work.load.y[middle]
        determinant = axx * ayy - axy * axy
        ax = (axy * by - ayy * bx) / determinant
        ay = (axy * bx - axx * by) / determinant
        kept = d.work.elimination
        kept.middle_xx, kept.middle_xy, kept.middle_yy = axx, axy, ayy

    # accelerations back out
    cx, cy = ax, ay
    for k in range(n - middle):
        ax, ay = accelerate(d, y, middle + k, True, ax, ay, rate)
        if k < middle:
            cx, cy = accelerate(d, y, middle - 1 - k, False, cx, cy, rate)
    rate[velocity_at(n)] = cx
    rate[velocity_at(n) + 1] = cy


def no_impedance(d, impedance):
    """Set the impedances at all places to zero."""
    for k in range(d.links + 1):
        impedance.xx[k], impedance.xy[k], impedance.yy[k] = 0.0, 0.0, 0.0
    if d.model.jointed:
        for k in range(d.links + 1, 2 * d.links + 1):
            impedance.xx[k] = 0.0


def factorize(d, links, impedance, factors):
    """Eliminate M + Jᵀ D J, with D a symmetric 2×2 impedance at each point, by the same recursion.

    Args:
        d: the instance.
        links: record with ``x, y``, shape (N+1,): the link vectors L_i [m] (entry N is not used).
        impedance: record with ``xx, xy, yy``, shape (N+1,): added inertia of each point [kg].
        factors: record for the result, used by ``solve``.
    """
    n, middle = d.links, d.model.middle
    axx, axy, ayy = 0.0, 0.0, 0.0
    cxx, cxy, cyy = 0.0, 0.0, 0.0
    for k in range(n - middle):
        i = n - 1 - k
        axx, axy, ayy = factorize_link(d, links, impedance, factors, i, True, axx, axy, ayy)
        if k < middle:
            cxx, cxy, cyy = factorize_link(d, links, impedance, factors, k, False, cxx, cxy, cyy)
    axx = axx + cxx + impedance.xx[middle]
    axy = axy + cxy + impedance.xy[middle]
    ayy = ayy + cyy + impedance.yy[middle]
    set_middle(d, factors, axx, axy, ayy)


def set_middle(d, factors, axx, axy, ayy):
    """Set A⁻¹ of the middle joint, 0 when that is a pinned base."""
    scale = 0.0 if d.model.pinned else 1.0 / (axx * ayy - axy * axy)
    factors.middle_mobility[0], factors.middle_mobility[1], factors.middle_mobility[2] = (
        ayy * scale,
        -axy * scale,
        axx * scale,
    )


def factorize_link(d, links, impedance, factors, i, outward, axx, axy, ayy):
    """As ``eliminate``, for A alone."""
    joint = i + 1 if outward else i
    axx += impedance.xx[joint]
    axy += impedance.xy[joint]
    ayy += impedance.yy[joint]
    lx, ly, sx, sy, inertia = arm(d, links, i, outward)
    hx, hy, inverse = hinge(lx, ly, sx, sy, inertia, axx, axy, ayy)
    factors.gain_x[i], factors.gain_y[i], factors.inverse[i] = hx * inverse, hy * inverse, inverse
    m = d.model.mass[i]
    return axx + m - hx * hx * inverse, axy - hx * hy * inverse, ayy + m - hy * hy * inverse


def solve(d, links, factors, load, change):
    """Solve (M + Jᵀ D J) Δ = Jᵀ load: the response to impulses on the points.

    Args:
        d: the instance.
        links: as for ``factorize``.
        factors: its result.
        load: record with ``x, y``, shape (N+1,): impulse on each point [N·s] (or force [N]).
        change: result Δ, shape (N+2,): the change of the base's velocity [m/s] (or acceleration) and of the
            angular velocities [rad/s]; entries after these are not changed.

    Returns:
        The load times the motion J Δ of the points: of a unit load on one point, its mobility [1/kg].
    """
    n, middle = d.links, d.model.middle
    bx, by, cx, cy, work = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(n - middle):
        i = n - 1 - k
        bx, by, work = gather(links, factors, load, i, True, bx, by, work, change)
        if k < middle:
            cx, cy, work = gather(links, factors, load, k, False, cx, cy, work, change)
    bx, by = bx + cx + load.x[middle], by + cy + load.y[middle]
    x = factors.middle_mobility[0] * bx + factors.middle_mobility[1] * by
    y = factors.middle_mobility[1] * bx + factors.middle_mobility[2] * by
    work += bx * x + by * y
    cx, cy = x, y
    for k in range(n - middle):
        x, y = spread(links, factors, middle + k, True, x, y, change)
        if k < middle:
            cx, cy = spread(links, factors, middle - 1 - k, False, cx, cy, change)
    change[0], change[1] = cx, cy
    return work


def gather(links, factors, load, i, outward, bx, by, work, change):
    """Set the change of ω_i for an inner joint at rest; return the impulse on that joint, and the work."""
    joint, sign = (i + 1, 1.0) if outward else (i, -1.0)
    bx += load.x[joint]
    by += load.y[joint]
    moment = sign * (links.x[i] * by - links.y[i] * bx)
    turned = moment * factors.inverse[i]
    change[ANGLES + i] = turned
    return bx - factors.gain_x[i] * moment, by - factors.gain_y[i] * moment, work + moment * turned


def spread(links, factors, i, outward, x, y, change):
    """Correct the change of ω_i for that of its inner joint's velocity; return that of the outer one."""
    sign = 1.0 if outward else -1.0
    a = change[ANGLES + i] - factors.gain_x[i] * x - factors.gain_y[i] * y
    change[ANGLES + i] = a
    return x - sign * a * links.y[i], y + sign * a * links.x[i]

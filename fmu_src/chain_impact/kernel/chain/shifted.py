"""The elimination of damped.py for a complex time s: the same operations, with a + ib as two reals.

The shifts of an implicit step come in conjugate pairs (integration/linear_system.py). Both parts are written
out, as dual numbers have no complex form. No pivots are needed: with the largest argument of s below 61° all
quadratic forms lie in a sector of less than 122°, and no pivot can vanish.

Rows 2p and 2p + 1 of an array hold the real and the imaginary parts for the pair p.
"""

from chain_impact.kernel.chain.damped import joint_damping
from chain_impact.kernel.chain.recursion import arm
from chain_impact.kernel.chain.springs import spring_stiffness
from chain_impact.kernel.chain.state import ANGLES
from chain_impact.kernel.inlining import inlined


@inlined
def times(a, b, c, d):
    """(a + ib)(c + id)."""
    return a * c - b * d, a * d + b * c


@inlined
def reciprocal(a, b):
    """1/(a + ib), for numbers far from overflow."""
    size = 1.0 / (a * a + b * b)
    return a * size, -b * size


def factorize_shifted(d, links, impedance, reactance, pair, time_r, time_i, factors):
    """Eliminate M + Jᵀ D J + K, with D a symmetric 2×2 impedance at each point and κ_i for a complex time s.

    Args:
        d: the instance.
        links: record with ``x, y``, shape (N+1,): the link vectors L_i [m] (entry N is not used).
        impedance: record with ``xx, xy, yy``, shape (N+1,): the real part of D [kg]; and ``joint``,
            shape (N,), that of stops [kg·m²].
        reactance: its imaginary part, likewise.
        pair: of the factors, from 0.
        time_r: the real part of s [s].
        time_i: the imaginary part of s [s].
        factors: record for the result, used by ``solve_shifted``.
    """
    re, im = 2 * pair, 2 * pair + 1
    square_r, square_i = times(time_r, time_i, time_r, time_i)
    axx, axy, ayy, ex, ey, p = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    bxx, bxy, byy, fx, fy, q = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # their imaginary parts
    for k in range(d.links):
        i = d.links - 1 - k
        axx, bxx = axx + impedance.xx[i + 1], bxx + reactance.xx[i + 1]
        axy, bxy = axy + impedance.xy[i + 1], bxy + reactance.xy[i + 1]
        ayy, byy = ayy + impedance.yy[i + 1], byy + reactance.yy[i + 1]
        lx, ly, sx, sy, inertia = arm(d, links, i, True)
        # h = m c⊥ + A' L⊥ + e'
        ux, uy = axy * lx - axx * ly + ex, ayy * lx - axy * ly + ey
        vx, vy = bxy * lx - bxx * ly + fx, byy * lx - bxy * ly + fy
        hx, hy = ux - sy, uy + sx
        # H = I + m c² + L⊥·(A' L⊥ + e') + L⊥·e' + p'
        own_r = inertia + p + lx * (uy + ey) - ly * (ux + ex)
        own_i = q + lx * (vy + fy) - ly * (vx + fx)
        # κ = s c + s² k
        c, stiffness = joint_damping(d, i), spring_stiffness(d, i)
        damper_r = time_r * c + square_r * stiffness + impedance.joint[i]
        damper_i = time_i * c + square_i * stiffness + reactance.joint[i]
        inverse_r, inverse_i = reciprocal(own_r + damper_r, own_i + damper_i)
        share_r, share_i = times(damper_r, damper_i, inverse_r, inverse_i)
        gx_r, gx_i = times(hx, vx, inverse_r, inverse_i)
        gy_r, gy_i = times(hy, vy, inverse_r, inverse_i)
        factors.gain_x[re, i], factors.gain_x[im, i] = gx_r, gx_i
        factors.gain_y[re, i], factors.gain_y[im, i] = gy_r, gy_i
        factors.inverse[re, i], factors.inverse[im, i] = inverse_r, inverse_i
        factors.own[re, i], factors.own[im, i] = own_r, own_i
        factors.damper[re, i], factors.damper[im, i] = damper_r, damper_i
        m = d.model.mass[i]
        # A = A' + m 1 − h hᵀ/(H + κ),  e = σ h,  p = σ H
        less_r, less_i = times(hx, vx, gx_r, gx_i)
        axx, bxx = axx + m - less_r, bxx - less_i
        less_r, less_i = times(hx, vx, gy_r, gy_i)
        axy, bxy = axy - less_r, bxy - less_i
        less_r, less_i = times(hy, vy, gy_r, gy_i)
        ayy, byy = ayy + m - less_r, byy - less_i
        ex, fx = times(share_r, share_i, hx, vx)
        ey, fy = times(share_r, share_i, hy, vy)
        p, q = times(share_r, share_i, own_r, own_i)
    axx, bxx = axx + impedance.xx[0], bxx + reactance.xx[0]
    axy, bxy = axy + impedance.xy[0], bxy + reactance.xy[0]
    ayy, byy = ayy + impedance.yy[0], byy + reactance.yy[0]
    invert_base(d, axx, bxx, axy, bxy, ayy, byy, factors.base[re], factors.base[im])


def invert_base(d, axx, bxx, axy, bxy, ayy, byy, real, imaginary):
    """Set A⁻¹ of the base, 0 when that is pinned."""
    one_r, one_i = times(axx, bxx, ayy, byy)
    two_r, two_i = times(axy, bxy, axy, bxy)
    scale_r, scale_i = reciprocal(one_r - two_r, one_i - two_i)
    scale_r = 0.0 if d.model.pinned else scale_r
    scale_i = 0.0 if d.model.pinned else scale_i
    real[0], imaginary[0] = times(ayy, byy, scale_r, scale_i)
    real[1], imaginary[1] = times(-axy, -bxy, scale_r, scale_i)
    real[2], imaginary[2] = times(axx, bxx, scale_r, scale_i)


def solve_shifted(d, links, factors, pair, load, load_i, change):
    """Solve (M + Jᵀ D J + K) Δ = Jᵀ load + Σ μ_i g_i.

    Args:
        d: the instance.
        links: as for ``factorize_shifted``.
        factors: its result.
        pair: likewise.
        load: record with ``x, y``, shape (N+1,): the real part of an impulse on each point [N·s]; and
            ``joint``, shape (N,), that of μ_i [N·m·s].
        load_i: the imaginary part, likewise.
        change: both parts of the result Δ, shape (2, N+2) [m/s, rad/s].
    """
    n, re, im = d.links, 2 * pair, 2 * pair + 1
    bx, by, t, cx, cy, u = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(n):
        i = n - 1 - k
        bx, cx = bx + load.x[i + 1], cx + load_i.x[i + 1]
        by, cy = by + load.y[i + 1], cy + load_i.y[i + 1]
        inverse_r, inverse_i = factors.inverse[re, i], factors.inverse[im, i]
        # s = L⊥·b' + t'
        s_r, s_i = links.x[i] * by - links.y[i] * bx + t, links.x[i] * cy - links.y[i] * cx + u
        moment_r, moment_i = s_r + load.joint[i], s_i + load_i.joint[i]
        change[0, ANGLES + i], change[1, ANGLES + i] = times(moment_r, moment_i, inverse_r, inverse_i)
        # b = b' − h (s + μ)/(H + κ),  t = σ s − (1 − σ) μ
        less_r, less_i = times(factors.gain_x[re, i], factors.gain_x[im, i], moment_r, moment_i)
        bx, cx = bx - less_r, cx - less_i
        less_r, less_i = times(factors.gain_y[re, i], factors.gain_y[im, i], moment_r, moment_i)
        by, cy = by - less_r, cy - less_i
        one_r, one_i = times(factors.damper[re, i], factors.damper[im, i], s_r, s_i)
        two_r, two_i = times(factors.own[re, i], factors.own[im, i], load.joint[i], load_i.joint[i])
        t, u = times(inverse_r, inverse_i, one_r - two_r, one_i - two_i)
    bx, cx = bx + load.x[0], cx + load_i.x[0]
    by, cy = by + load.y[0], cy + load_i.y[0]
    one_r, one_i = times(factors.base[re, 0], factors.base[im, 0], bx, cx)
    two_r, two_i = times(factors.base[re, 1], factors.base[im, 1], by, cy)
    x, x_i = one_r + two_r, one_i + two_i
    one_r, one_i = times(factors.base[re, 1], factors.base[im, 1], bx, cx)
    two_r, two_i = times(factors.base[re, 2], factors.base[im, 2], by, cy)
    y, y_i = one_r + two_r, one_i + two_i
    change[0, 0], change[0, 1], change[1, 0], change[1, 1] = x, y, x_i, y_i
    spread_shifted(links, factors, re, im, change)


def spread_shifted(links, factors, re, im, change):
    """Correct the changes of ω_i for those of their inner joints' velocities and of the previous links."""
    x, y, x_i, y_i = change[0, 0], change[0, 1], change[1, 0], change[1, 1]
    before, before_i = 0.0, 0.0
    for i in range(len(factors.inverse[re])):
        # α = (s + μ − h·a + κ β)/(H + κ)
        one_r, one_i = times(factors.gain_x[re, i], factors.gain_x[im, i], x, x_i)
        two_r, two_i = times(factors.gain_y[re, i], factors.gain_y[im, i], y, y_i)
        share_r, share_i = times(
            factors.damper[re, i], factors.damper[im, i], factors.inverse[re, i], factors.inverse[im, i]
        )
        add_r, add_i = times(share_r, share_i, before, before_i)
        a = change[0, ANGLES + i] - one_r - two_r + add_r
        b = change[1, ANGLES + i] - one_i - two_i + add_i
        change[0, ANGLES + i], change[1, ANGLES + i] = a, b
        x, x_i = x - a * links.y[i], x_i - b * links.y[i]
        y, y_i = y + a * links.x[i], y_i + b * links.x[i]
        before, before_i = a, b

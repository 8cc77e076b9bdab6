"""The recursion with damped joints: solutions with M + Jᵀ D J + K, in O(N).

K = Σ κ_i g_i g_iᵀ with g_i the gradient of ω_i − ω_{i−1}: each joint resists a change of its relative angular
velocity by κ_i (Δ_i − Δ_{i−1}) − μ_i, with μ_i an impulse in the joint. The base has a damper only if it is
pinned. A spring k_i acts in an implicit step as a further damper (integration/linear_system.py): for a time s
κ_i = s c_i + s² k_i.

A damped joint transmits a moment. The response of the outer part of the chain therefore depends on the motion
a of the joint and on β, that of the previous link:

    Z = ½ a·A a + β e·a + ½ p β² − b·a − t β,

with A, e and p a symmetric 3×3 articulated inertia. To this, link i adds its own inertia and its damper,
and is eliminated, Δ_i = α. With L, m c, x⊥ as in recursion.py and primes for the part outside of link i,
whose β is α:

    h = m c⊥ + A' L⊥ + e',   H = I + m c² + L⊥·A' L⊥ + 2 L⊥·e' + p',   s = L⊥·b' + t',
    Z = ½ a·(A' + m 1) a + α h·a + ½ H α² − s α − b'·a + ½ κ (α − β)² − μ (α − β),
    α = (s + μ − h·a + κ β)/(H + κ).

The result has the coefficients, with σ = κ/(H + κ) between 0 and 1,

    A = A' + m 1 − h hᵀ/(H + κ),   e = σ h,   p = σ H,
    b = b' − h (s + μ)/(H + κ),    t = σ s − (1 − σ) μ,

in which nothing cancels, however large κ is. The elimination goes from the tip to the base, whose β is 0.
"""

from chain_impact.kernel.chain.recursion import arm
from chain_impact.kernel.chain.springs import spring_stiffness
from chain_impact.kernel.chain.state import ANGLES


def factorize_damped(d, links, impedance, shift, factors):
    """Eliminate M + Jᵀ D J + K, with D a symmetric 2×2 impedance at each point and κ_i for a time s.

    Args:
        d: the instance.
        links: record with ``x, y``, shape (N+1,): the link vectors L_i [m] (entry N is not used).
        impedance: record with ``xx, xy, yy``, shape (N+1,): added inertia of each point [kg]; and ``joint``,
            shape (N,), the resistance of stops, which adds to κ_i [kg·m²].
        shift: s [s].
        factors: record for the result, used by ``solve_damped``.
    """
    axx, axy, ayy, ex, ey, p = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(d.links):
        i = d.links - 1 - k
        axx += impedance.xx[i + 1]
        axy += impedance.xy[i + 1]
        ayy += impedance.yy[i + 1]
        lx, ly, sx, sy, inertia = arm(d, links, i, True)
        # h = m c⊥ + A' L⊥ + e'
        ux, uy = axy * lx - axx * ly + ex, ayy * lx - axy * ly + ey
        hx, hy = ux - sy, uy + sx
        # H = I + m c² + L⊥·(A' L⊥ + e') + L⊥·e' + p'
        own = inertia + p + lx * (uy + ey) - ly * (ux + ex)
        damper = joint_resistance(d, i, shift) + impedance.joint[i]
        inverse = 1.0 / (own + damper)
        share = damper * inverse
        factors.gain_x[i], factors.gain_y[i], factors.inverse[i] = hx * inverse, hy * inverse, inverse
        factors.own[i], factors.damper[i] = own, damper
        m = d.model.mass[i]
        # A = A' + m 1 − h hᵀ/(H + κ),  e = σ h,  p = σ H
        axx, axy, ayy = axx + m - hx * hx * inverse, axy - hx * hy * inverse, ayy + m - hy * hy * inverse
        ex, ey, p = share * hx, share * hy, share * own
    axx += impedance.xx[0]
    axy += impedance.xy[0]
    ayy += impedance.yy[0]
    # A⁻¹ of the base, 0 when that is pinned
    scale = 0.0 if d.model.pinned else 1.0 / (axx * ayy - axy * axy)
    factors.base_mobility[0], factors.base_mobility[1], factors.base_mobility[2] = (
        ayy * scale,
        -axy * scale,
        axx * scale,
    )


def joint_resistance(d, i, shift):
    """κ_i = s c_i + s² k_i [kg·m²] of the damper and the spring in the joint of link i, for a time s [s]."""
    return shift * (joint_damping(d, i) + shift * spring_stiffness(d, i))


def joint_damping(d, i):
    """c_i [N·m·s/rad], 0 at a free base, which has no joint."""
    return d.model.joint_damping[i] if i > 0 or d.model.pinned else 0.0


def solve_damped(d, links, factors, load, change):
    """Solve (M + Jᵀ D J + K) Δ = Jᵀ load + Σ μ_i g_i.

    Args:
        d: the instance.
        links: as for ``factorize_damped``.
        factors: its result.
        load: record with ``x, y``, shape (N+1,): impulse on each point [N·s]; and ``joint``,
            shape (N,), μ_i [N·m·s].
        change: result Δ, shape (N+2,): the change of the base's velocity [m/s] and of the angular velocities
            [rad/s].
    """
    n = d.links
    bx, by, t = 0.0, 0.0, 0.0
    for k in range(n):
        i = n - 1 - k
        bx += load.x[i + 1]
        by += load.y[i + 1]
        damper, inverse = factors.damper[i], factors.inverse[i]
        # s = L⊥·b' + t'
        s = links.x[i] * by - links.y[i] * bx + t
        moment = s + load.joint[i]
        change[ANGLES + i] = moment * inverse
        # b = b' − h (s + μ)/(H + κ),  t = σ s − (1 − σ) μ
        bx -= factors.gain_x[i] * moment
        by -= factors.gain_y[i] * moment
        t = inverse * (damper * s - factors.own[i] * load.joint[i])
    bx += load.x[0]
    by += load.y[0]
    x = factors.base_mobility[0] * bx + factors.base_mobility[1] * by
    y = factors.base_mobility[1] * bx + factors.base_mobility[2] * by
    change[0], change[1] = x, y
    before = 0.0
    for i in range(n):
        # α = (s + μ − h·a + κ β)/(H + κ)
        share = factors.damper[i] * factors.inverse[i]
        a = change[ANGLES + i] - factors.gain_x[i] * x - factors.gain_y[i] * y + share * before
        change[ANGLES + i] = a
        x -= a * links.y[i]
        y += a * links.x[i]
        before = a

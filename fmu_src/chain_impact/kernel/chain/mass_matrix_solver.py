"""The solver of linear systems with the mass matrix, by the recursion of chain/elimination.py.

``factorize_matrix`` and ``solve_response`` solve linear systems with the matrix M + Jᵀ D J + K in O(N), for
real, complex and dual numbers alike. The solution is the response of the chain to impulses. This module knows
places and joints only; constraints/constraint_response.py sets the impedances and impulses of contacts and
sticking elements. M is the mass matrix. J maps rates of the coordinates to velocities of points and sites,
and D are impedances (dampers) there. K = Σ κ_i χ_i χ_iᵀ, where κ_i is the impedance of joint i and χ_i the
gradient of ω_i − ω_{i−1}. With the response Δ, joint i exerts the angular impulse κ_i (Δ_i − Δ_{i−1}) − μ_i
against the change of its relative angular velocity; μ_i is a given impulse in the joint. A free base has no
joint, so κ_1 = 0.

The response minimises the quadratic form ½ Δᵀ (M + Jᵀ D J + K) Δ minus the work of the impulses. The links
are eliminated one after another, from both ends of the chain to the middle joint. The outer part of the chain
at a joint is the part between this joint and the end of its arm. Z is the least value of the form over this
part. Z depends on the motion a of the joint. Z also depends on the rotation β of the link on the inner side
of the joint, because a joint with an impedance κ transmits a moment:

    Z = ½ a·A a + β e·a + ½ p β² − b·a − t β.

A, e and p are a symmetric 3×3 articulated inertia. The impulses on the outer part act at the joint as the
impulse b and the angular impulse t. Link i adds its own inertia, and the impedances D at its outer joint and
at its sites; the formulas leave these impedances out. The elimination of link i is that of its rotation Δ_i =
α. L, m r_C, I and x⊥ are those of chain/elimination.py, and τ is a moment on the link. The coefficients A',
b', e', p' and t' belong to the outer part at the outer joint of link i, for which β is the α of link i:

    h = m r_C⊥ + A' L⊥ + e',   H = I + m r_C² + L⊥·A' L⊥ + 2 L⊥·e' + p',   s = L⊥·b' + t' + τ,
    Z = ½ a·(A' + m 1) a + α h·a + ½ H α² − s α − b'·a + ½ κ (α − β)² − μ (α − β),
    α = (s + μ − h·a + κ β)/(H + κ).

The result has the coefficients, with σ = κ/(H + κ) between 0 and 1,

    A = A' + m 1 − h hᵀ/(H + κ),   e = σ h,   p = σ H,
    b = b' − h (s + μ)/(H + κ),    t = σ s − (1 − σ) μ,

in which no digits cancel, however large κ is. As in chain/elimination.py, two arms meet at the middle joint:
the inward arm begins at the base, the outward arm at the tip. The impedance κ of the middle joint belongs to
the outward arm. At the middle joint the β of the outward arm is the α of the inward arm's link there, so e, p
and t of the outward arm add to h, H and s of this link. A light link at an end is eliminated before heavier
links, because its sum with a heavier link would lose digits of the light one.

In an implicit step κ and D may be complex, because they contain a complex shift (ode/extended_state.py). Even
then no pivoting is needed: the argument of every shift is below 61°, so all quadratic forms lie in a sector
of less than 122°, and no pivot vanishes.
"""

from chain_impact.kernel.chain.drives import joints_resist
from chain_impact.kernel.chain.elimination import arm_of_link, hinge_inertia, inertia_along
from chain_impact.kernel.chain.sites import has_link_moments, joint_place, site_arm, site_place
from chain_impact.kernel.function_marks import has_complex_rule, inlined
from chain_impact.kernel.record.state import FIRST_ANGLE

FREE, HELD, SHIFTED = 0, 1, 2
"""Slots of `scratch.factors`, one for each factorized matrix. FREE: the mass matrix, with armatures and, in
``project_state`` while an element sticks, with an added mass for each contact with a force law
(``contact_added_mass`` in forces/holding.py). HELD: the matrix of FREE plus Jᵀ D J with the
impedances D of the constraints. SHIFTED: the matrix of an implicit step, for its real shift."""


@has_complex_rule
def reciprocal(number):
    """Return 1/number, for a real ``number`` ≠ 0 whose reciprocal does not overflow."""
    return 1.0 / number


def complex_reciprocal(number):
    """Return 1/number for a complex ``number`` ≠ 0, by real operations.

    The complex division of numba may raise an error, and has branches, which cost time.
    """
    inverse_square = 1.0 / (number.real * number.real + number.imag * number.imag)
    return complex(number.real * inverse_square, -number.imag * inverse_square)


@has_complex_rule
def cross_product(lx, ly, bx, by):
    """Return L⊥·b for a link vector L and a vector b: the z component of the cross product L × b."""
    return lx * by - ly * bx


def complex_cross_product(lx, ly, bx, by):
    """Return L⊥·b for a complex b and a real L; in ``cross_product`` numba would make L complex."""
    return complex(cross_product(lx, ly, bx.real, by.real), cross_product(lx, ly, bx.imag, by.imag))


def complex_hinge_inertia(link, axx, axy, ayy):
    """Return the coupling h and the inertia H as ``hinge_inertia`` does, for a complex articulated inertia.

    The link's data are real. With ``hinge_inertia`` numba would convert these data to complex numbers, which
    costs time.
    """
    hx, hy, about_joint = hinge_inertia(link, axx.real, axy.real, ayy.real)
    gx, gy, part = hinge_inertia((link[0], link[1], 0.0, 0.0, 0.0), axx.imag, axy.imag, ayy.imag)
    return complex(hx, gx), complex(hy, gy), complex(about_joint, part)


COMPLEX_RULES = {
    reciprocal: complex_reciprocal,
    cross_product: complex_cross_product,
    hinge_inertia: complex_hinge_inertia,
}
"""Function of the kernel → the function that replaces it for complex numbers, which implicit steps use."""


def clear_impedance(d, impedance):
    """Set all numbers of ``impedance`` that are used to zero; ``factorize_matrix`` describes them.

    These numbers are the impedances D at points and sites, and at the places of joints if joints have places
    (``xx`` only); and the impedances κ of all joints, if any joint may resist (``joints_resist``).
    """
    for k in range(d.link_count + 1):
        impedance.xx[k], impedance.xy[k], impedance.yy[k] = 0.0, 0.0, 0.0
    if d.chain.has_joint_places:
        for k in range(joint_place(d, 0), joint_place(d, d.link_count)):
            impedance.xx[k] = 0.0
    for s in range(d.site_count):
        k = site_place(d, s)
        impedance.xx[k], impedance.xy[k], impedance.yy[k] = 0.0, 0.0, 0.0
    for i in range(d.link_count if joints_resist(d) else 0):
        impedance.joint[i] = 0.0


def factorize_matrix(d, link_vectors, space, slot, coupled):
    """Factorize M + Jᵀ D J + K: mass matrix, impedances D at places, impedances K of joints.

    Args:
        d: the instance.
        link_vectors: record with ``x, y``, shape (N+1,): the link vectors L_i [m] (entry N is not used).
        space: record of which two fields are used. ``impedance`` has D [kg] of each point and site as
            ``xx, xy, yy``, and κ_i [kg·m²] of each joint as ``joint``, shape (N,). ``factors`` gets the
            result, which ``solve_response`` uses.
        slot: the index in ``factors`` of this matrix: FREE, HELD or SHIFTED; for a complex matrix, the index
            of the complex shift.
        coupled: whether joints may transmit moments. If not, all impedances κ_i count as zero here, and all
            angular impulses μ_i in ``solve_response``; both functions then take less time.
    """
    n, middle, impedance = d.link_count, d.chain.meeting_joint, space.impedance
    space.factors.coupled[slot] = 1 if coupled else 0
    axx, axy, ayy, ex, ey, p = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    cxx, cxy, cyy, fx, fy, q = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(n - middle):
        i, j = n - 1 - k, k - (n - 2 * middle)
        axx, axy, ayy, ex, ey, p = factorize_link(
            d, link_vectors, space, slot, coupled, i, True, impedance.joint[i], axx, axy, ayy, ex, ey, p
        )
        if j >= 0:
            is_last = j + 1 == middle
            kappa = 0.0 if is_last else impedance.joint[j + 1]
            if is_last and coupled:
                # The outward arm's term e·a α couples the motion a of the middle joint with the rotation α of
                # link j. `factorize_link` needs this term in the motion a' of the link's outer joint:
                # a = a' − α L⊥, so e·a α = e·a' α − e·L⊥ α². The last term adds −2 e·L⊥ to p, because Z has
                # ½ p α². L leads from the middle joint to the outer joint, and the entry in ``link_vectors``
                # the other way: L is minus this entry.
                q += p + cross_product(2.0 * link_vectors.x[j], 2.0 * link_vectors.y[j], ex, ey)
                fx, fy = fx + ex, fy + ey
            cxx, cxy, cyy, fx, fy, q = factorize_link(
                d, link_vectors, space, slot, coupled, j, False, kappa, cxx, cxy, cyy, fx, fy, q
            )
    axx = axx + cxx + impedance.xx[middle]
    axy = axy + cxy + impedance.xy[middle]
    ayy = ayy + cyy + impedance.yy[middle]
    set_middle_mobility(d, space.factors, slot, axx, axy, ayy)


def copy_factors(d, coupled):
    """Copy the mass matrix's factors of ``solve_accelerations`` to slot FREE of ``scratch.factors``.

    So ``solve_response`` can use the factors without a new factorization. ``coupled`` tells whether joints
    may transmit moments, as for ``factorize_matrix``. In a chain with armatures,
    ``solve_accelerations_with_armatures`` in constraints/constraint_response.py has set this slot, so the
    function does nothing.
    """
    if d.chain.has_armatures:
        return
    elimination, factors = d.scratch.elimination, d.scratch.factors
    set_middle_mobility(d, factors, FREE, elimination.middle_xx, elimination.middle_xy, elimination.middle_yy)
    factors.coupled[FREE] = 1 if coupled else 0
    for i in range(d.link_count):
        factors.gain_x[FREE, i], factors.gain_y[FREE, i] = elimination.gain_x[i], elimination.gain_y[i]
        factors.inverse[FREE, i] = elimination.inverse[i]
        factors.coupling[FREE, i], factors.complement[FREE, i] = 0.0, 1.0


def set_middle_mobility(d, factors, slot, axx, axy, ayy):
    """Set ``middle_mobility`` of matrix ``slot`` in the factors: the inverse A⁻¹ at the middle joint.

    A is the articulated inertia with the components axx, axy and ayy. A pinned or sliding base is the middle
    joint. In place of the inverse, the mobility is then 0 at a pinned base, and u uᵀ/(u·A u + m) on a slider
    with the direction u and the carriage's mass m (slider.py).
    """
    mobility = factors.middle_mobility
    if d.slides:
        ux, uy, inverse = d.slider.ux, d.slider.uy, reciprocal(inertia_along(d, axx, axy, ayy))
        mobility[slot, 0], mobility[slot, 1] = ux * ux * inverse, ux * uy * inverse
        mobility[slot, 2] = uy * uy * inverse
        return
    scale = 0.0 if d.chain.has_base_joint else reciprocal(axx * ayy - axy * axy)
    mobility[slot, 0], mobility[slot, 1], mobility[slot, 2] = ayy * scale, -axy * scale, axx * scale


@inlined
def factorize_link(d, link_vectors, space, slot, coupled, i, outward, kappa, axx, axy, ayy, ex, ey, p):
    """Eliminate link i: return the articulated inertia at its inner joint (nearer to the middle joint).

    The arguments axx to p are the parts A, e and p (head of this module) of the articulated inertia at the
    outer joint; the result has the same six numbers at the inner joint. ``outward``: whether the inner joint
    is the proximal one; ``kappa``: κ of the inner joint.
    """
    point, factors = i + 1 if outward else i, space.factors
    axx += space.impedance.xx[point]
    axy += space.impedance.xy[point]
    ayy += space.impedance.yy[point]
    link = lx, ly, _, _, _ = arm_of_link(d, link_vectors, i, outward)
    hx, hy, about_joint = hinge_inertia(link, axx, axy, ayy)
    for s in range(
        d.chain.first_site[i] if d.site_count > 0 else 0, d.chain.first_site[i + 1] if d.site_count > 0 else 0
    ):
        rx, ry = site_arm(d, link_vectors, s)
        if not outward:
            rx, ry = rx - link_vectors.x[i], ry - link_vectors.y[i]
        k = site_place(d, s)
        xx, xy, yy = space.impedance.xx[k], space.impedance.xy[k], space.impedance.yy[k]
        # D r⊥, with the impedance D of the site and its arm r from the inner joint
        sx, sy = xy * rx - xx * ry, yy * rx - xy * ry
        hx, hy, about_joint = hx + sx, hy + sy, about_joint + cross_product(rx, ry, sx, sy)
        axx, axy, ayy = axx + xx, axy + xy, ayy + yy
    if coupled:
        hx, hy, about_joint = hx + ex, hy + ey, about_joint + (cross_product(2.0 * lx, 2.0 * ly, ex, ey) + p)
        inverse = reciprocal(about_joint + kappa)
        coupling = kappa * inverse
        factors.coupling[slot, i], factors.complement[slot, i] = coupling, about_joint * inverse
        # the parts e = σ h and p = σ H (head of this module) at the inner joint, with σ = κ/(H + κ)
        ex, ey, p = coupling * hx, coupling * hy, coupling * about_joint
    else:
        inverse = reciprocal(about_joint)
    kx, ky, m = hx * inverse, hy * inverse, d.chain.mass[i]
    factors.gain_x[slot, i], factors.gain_y[slot, i], factors.inverse[slot, i] = kx, ky, inverse
    # the part A = A' + m 1 − h hᵀ/(H + κ) of the articulated inertia at the inner joint
    return axx + m - hx * hx * inverse, axy - hx * hy * inverse, ayy + m - hy * hy * inverse, ex, ey, p


def solve_response(d, link_vectors, space, slot, change):
    """Solve (M + Jᵀ D J + K) Δ = Jᵀ p + Σ μ_i χ_i for the response Δ to impulses on points and in joints.

    Args:
        d: the instance.
        link_vectors: as for ``factorize_matrix``.
        space: record with the result of ``factorize_matrix``, and with ``applied_force``. This has the
            impulses ``x, y`` on each point 0…N [N·s], the impulses μ_i in the joints, ``joint``, shape (N,)
            [N·m·s], and the angular impulses τ_i on the links, ``link`` [N·m·s]. μ_i is read only if
            ``factorize_matrix`` has set the slot with ``coupled`` true, τ_i only if ``has_link_moments`` is
            true. ``move_site_forces`` must have replaced the impulses at sites. If ``applied_force`` has
            forces and moments, Δ has accelerations.
        slot: the index in ``factors`` of the matrix, as for ``factorize_matrix``.
        change: result Δ, in its first N + 2 entries: the change of the base's velocity [m/s] and of the
            links' angular velocities [rad/s]. Further entries of the array stay as they are.
    """
    n, middle, applied_force, is_coupled = (
        d.link_count,
        d.chain.meeting_joint,
        space.applied_force,
        space.factors.coupled[slot] != 0,
    )
    bx, by, t = 0.0, 0.0, 0.0
    cx, cy, u = 0.0, 0.0, 0.0
    for k in range(n - middle):
        i, j = n - 1 - k, k - (n - 2 * middle)
        bx, by, t = gather_forces(
            d, link_vectors, space, slot, is_coupled, i, True, applied_force.joint[i], bx, by, t, change
        )
        if j >= 0:
            is_last = j + 1 == middle
            moment = 0.0 if is_last else -applied_force.joint[j + 1]
            u = u + t if is_last else u
            cx, cy, u = gather_forces(
                d, link_vectors, space, slot, is_coupled, j, False, moment, cx, cy, u, change
            )
    bx, by = bx + cx + applied_force.x[middle], by + cy + applied_force.y[middle]
    mobility = space.factors.middle_mobility
    x = mobility[slot, 0] * bx + mobility[slot, 1] * by
    y = mobility[slot, 1] * bx + mobility[slot, 2] * by
    cx, cy, rotation, rate_before = x, y, 0.0, 0.0
    for k in range(n - middle):
        if k < middle:
            i = middle - 1 - k
            cx, cy, rotation = spread_motion(
                link_vectors, space, slot, is_coupled, i, False, cx, cy, rotation, change
            )
            rate_before = rotation if k == 0 else rate_before
        x, y, rate_before = spread_motion(
            link_vectors, space, slot, is_coupled, middle + k, True, x, y, rate_before, change
        )
    change[0], change[1] = cx, cy


@inlined
def gather_forces(d, link_vectors, space, slot, coupled, i, outward, moment, bx, by, t, change):
    """Set in ``change`` the part of α that the impulses cause: (s + μ)/(H + κ), the α for a = 0 and β = 0.

    α is the change of ω_i, a that of the velocity of the inner joint, which is nearer to the middle joint, β
    that of the angular velocity of the link on the inner side; the module's docstring has the other symbols.
    ``moment`` is the angular impulse μ of the inner joint on link i. Returns the impulse b and the angular
    impulse t at the inner joint, from those at the outer joint: the arguments bx, by and t.
    """
    factors, point, sign = space.factors, i + 1 if outward else i, 1.0 if outward else -1.0
    bx += space.applied_force.x[point]
    by += space.applied_force.y[point]
    s = cross_product(sign * link_vectors.x[i], sign * link_vectors.y[i], bx, by)
    if has_link_moments(d):
        s += space.applied_force.link[i]
    if coupled:
        s += t
        # angular impulse at the inner joint: t = σ s − (1 − σ) μ, with σ = κ/(H + κ)
        t = factors.coupling[slot, i] * s - factors.complement[slot, i] * moment
        s += moment
    change[FIRST_ANGLE + i] = s * factors.inverse[slot, i]
    # impulse at the inner joint: b = b' − h (s + μ)/(H + κ); here the variable ``s`` is the sum s + μ
    return bx - factors.gain_x[slot, i] * s, by - factors.gain_y[slot, i] * s, t


@inlined
def spread_motion(link_vectors, space, slot, coupled, i, outward, x, y, rate_before, change):
    """Add to the change of ω_i the effects of the inner joint's motion and of the inward link's rotation.

    ``x`` and ``y`` are the components of the inner joint's change of velocity a, and ``rate_before`` is the
    change β of the angular velocity of the inward link. The inner joint of link i is nearer to the middle
    joint; beyond the inner joint lies the inward link.

    Returns:
        The change of the outer joint's velocity, x and y, and the whole change of ω_i.
    """
    factors, sign = space.factors, 1.0 if outward else -1.0
    # change of the link's angular velocity: α = (s + μ − h·a + κ β)/(H + κ)
    alpha = change[FIRST_ANGLE + i] - factors.gain_x[slot, i] * x - factors.gain_y[slot, i] * y
    if coupled:
        alpha += factors.coupling[slot, i] * rate_before
    change[FIRST_ANGLE + i] = alpha
    return x - alpha * (sign * link_vectors.y[i]), y + alpha * (sign * link_vectors.x[i]), alpha

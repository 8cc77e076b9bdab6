"""Recursive Gibbs–Appell dynamics of a planar open chain, in O(N).

A revolute joint without a rotor transmits a force and, apart from its known torque, no moment. The outer part
of the chain at a joint therefore needs the force ``A a + b`` for an acceleration ``a`` of that joint: ``A``
is a symmetric 2×2 articulated inertia, ``b`` collects the terms of ω², gravity, torques and contact forces.
Appell's equation for α_i, ∂Z/∂α_i = 0 with the Gibbs function Z (docs/computation.md), eliminates α_i. For
chains with armatures, see ``solve_accelerations_with_armatures`` in constraints/constraint_response.py.

A free chain has two free ends. The elimination goes from both ends toward the middle joint, where two
equations remain. The accelerations are then computed from the middle outward. The two arms of the chain are
independent, so a processor overlaps their operations, which saves time. In a chain with a pinned or sliding
base, the base takes the place of the middle joint, and there is one arm.

The absolute link angles θ_i are the coordinates and all vectors are in the world frame, so no rotation matrix
appears: L is the vector along a link from the link's joint nearer to the middle, r_C the vector from that
joint to the centre of mass, x⊥ = ẑ × x, m the mass, I the inertia about the centre of mass, g gravity, f the
applied force on the outer joint, τ the moment on the link. A' and b' belong to the link's outer joint, A and
b to the joint nearer to the middle, its inner joint. The rotation of a link about its inner joint has the
inertia H and the coupling h with the motion of this joint (``hinge_inertia``).

The centre of mass may lie beside the line of the link, because L and m r_C are independent in the equations.
A site (chain/sites.py) with an impedance D adds D to A, D r⊥ to h and r⊥·D r⊥ to H of its link; r is the arm
of the site from the joint nearer to the middle. A force at the site acts as a force at the proximal joint and
a moment τ on the link.

Source: the recursion after Ahmadizadeh, Shafei, Fooladi, *A recursive algorithm for dynamics of multiple
frictionless impact-contacts in open-loop robotic mechanisms*, Mechanism and Machine Theory; the elimination
in this form is derived in docs/computation.md.
"""

from chain_impact.kernel.function_marks import has_complex_rule, inlined
from chain_impact.kernel.record.state import omega_at, velocity_at


@inlined
def arm_of_link(d, link, i, outward):
    """Return data of link i, counted from 0, relative to its inner joint, the one nearer to the middle joint.

    ``link`` has the link vectors as ``x, y`` [m], from the proximal joint of a link to its other joint.
    ``outward``: whether the inner joint is the link's proximal joint.

    Returns:
        Five numbers: x and y of L [m], and x and y of m r_C [kg·m], all from the inner joint and in the world
        frame; and the inertia about this joint, I + m r_C² [kg·m²].
    """
    lx, ly = link.x[i], link.y[i]
    beside_x, beside_y = 0.0, 0.0
    if d.skewed:
        second = d.chain.mass[i] * d.chain.offset_ratio[i]
        beside_x, beside_y = -second * ly, second * lx
    if outward:
        first = d.chain.mass[i] * d.chain.center_of_mass_ratio[i]
        sx, sy, inertia = first * lx, first * ly, d.chain.proximal_inertia[i]
    else:
        first = d.chain.mass[i] * (1.0 - d.chain.center_of_mass_ratio[i])
        sx, sy, inertia = -first * lx, -first * ly, d.chain.distal_inertia[i]
        lx, ly = -lx, -ly
    if d.skewed:
        sx, sy = sx + beside_x, sy + beside_y
    return lx, ly, sx, sy, inertia


@has_complex_rule
@inlined
def hinge_inertia(link, axx, axy, ayy):
    """Return x and y of the coupling h [kg·m], and the inertia H [kg·m²], of a link about its inner joint.

    H and h follow from the articulated inertia A' at the link's outer joint (xx, xy, yy) and from ``link``,
    the data of ``arm_of_link``.
    """
    lx, ly, sx, sy, inertia = link
    # coupling h = m r_C⊥ + A' L⊥ and inertia H = I + m r_C² + L⊥·A' L⊥; the module's docstring has the
    # symbols
    hx, hy = axy * lx - axx * ly - sy, ayy * lx - axy * ly + sx
    return hx, hy, (inertia + ayy * (lx * lx)) + (axx * (ly * ly) - axy * (2.0 * lx * ly))


def eliminate_inner(d, y, i, outward, axx, axy, ayy, bx, by):
    """Eliminate the angular acceleration α_i of a link between two joints.

    The outer part of the chain at a joint needs the force A a + b for an acceleration a of the joint. Returns
    A (xx, xy, yy) and b (x, y) at the link's inner joint. The arguments axx to by are A' and b' at the link's
    outer joint.
    """
    joint, omega = i + 1 if outward else i, y[omega_at(d.link_count) + i]
    link = lx, ly, _, _, _ = arm_of_link(d, d.scratch.link_vector, i, outward)
    w2 = omega * omega
    # d = b' − f − ω² A' L is the force at the outer joint, with the applied force f there, if α = 0 and the
    # inner joint has no acceleration
    dx = bx - d.scratch.applied_force.x[joint] - w2 * (axx * lx + axy * ly)
    dy = by - d.scratch.applied_force.y[joint] - w2 * (axy * lx + ayy * ly)
    hx, hy, about_joint = hinge_inertia(link, axx, axy, ayy)
    return eliminate_link(d, i, w2, link, hx, hy, 1.0 / about_joint, axx, axy, ayy, dx, dy)


def eliminate_end(d, y, i, outward):
    """Eliminate the angular acceleration α_i of link i, which is at a free end, where A' = 0 and b' = 0.

    The inertia H of ``hinge_inertia`` is a constant for this link. Returns A (xx, xy, yy) and b (x, y) at the
    link's inner joint, as ``eliminate_inner`` does.
    """
    joint, omega = i + 1 if outward else i, y[omega_at(d.link_count) + i]
    link = _, _, sx, sy, inertia = arm_of_link(d, d.scratch.link_vector, i, outward)
    dx, dy = -d.scratch.applied_force.x[joint], -d.scratch.applied_force.y[joint]
    w2 = omega * omega
    return eliminate_link(d, i, w2, link, -sy, sx, 1.0 / inertia, 0.0, 0.0, 0.0, dx, dy)


def eliminate_link(d, i, w2, link, hx, hy, inverse, axx, axy, ayy, dx, dy):
    """Return A (xx, xy, yy) and b (x, y) at the inner joint of link i, from A' at its outer joint.

    (dx, dy) is the force at the outer joint without accelerations, the d of the comments below. ``w2`` is ω²,
    and ``inverse`` 1/H. The function stores h/H, 1/H and h₀/H of the link for ``accelerate_link`` and
    ``copy_factors``.
    """
    lx, ly, sx, sy, _ = link
    m, gx, gy = d.chain.mass[i], d.chain.gravity[0], d.chain.gravity[1]
    # the moment about the inner joint without accelerations: h₀ = L⊥·d − m r_C⊥·g − τ
    h0 = (lx * dy - ly * dx) + (sy * gx - sx * gy - d.scratch.moment[i])
    if d.site_count > 0:
        h0 -= d.scratch.applied_force.link[i]
    kx, ky = hx * inverse, hy * inverse
    elimination = d.scratch.elimination
    elimination.gain_x[i] = kx
    elimination.gain_y[i] = ky
    elimination.inverse[i] = inverse
    elimination.bias[i] = h0 * inverse
    # at the inner joint: A = A' + m 1 − h hᵀ/H, b = d − ω² m r_C − m g − h h₀/H
    return (
        (axx + m) - hx * kx,
        axy - hx * ky,
        (ayy + m) - hy * ky,
        (dx - w2 * sx - m * gx) - kx * h0,
        (dy - w2 * sy - m * gy) - ky * h0,
    )


def accelerate_link(d, y, i, outward, ax, ay, rate):
    """Set in ``rate`` the angular acceleration α_i of link i; its inner joint has the acceleration ax, ay.

    If ``outward`` is true, the inner joint is the proximal joint. Returns x and y of the acceleration [m/s²]
    of the outer joint, at the other end of the link.
    """
    elimination, speed_index = d.scratch.elimination, omega_at(d.link_count) + i
    # the variable ``a`` is α = −(h·a + h₀)/H for the acceleration a of the inner joint
    a = -(elimination.gain_x[i] * ax + elimination.gain_y[i] * ay + elimination.bias[i])
    rate[speed_index] = a
    w2 = y[speed_index] * y[speed_index]
    sign = 1.0 if outward else -1.0
    lx, ly = sign * d.scratch.link_vector.x[i], sign * d.scratch.link_vector.y[i]
    # acceleration of the outer joint: a' = a + α L⊥ − ω² L, with a of the inner joint and the link vector L
    return (ax - w2 * lx) - a * ly, (ay - w2 * ly) + a * lx


def solve_accelerations(d, y, rate):
    """Solve the equations of motion for the accelerations under the applied forces in the record.

    Args:
        d: the instance; reads ``scratch.link_vector`` (L_i) [m], ``scratch.applied_force`` (force on each
            point 0…N [N] and, in a scene with sites, moment on each link [N·m]), ``scratch.moment`` (net
            joint torque on each link) [N·m] and, with a slider, ``scratch.thrust`` (force of its drive) [N].
        y: state, of which the angular velocities ω_i [rad/s] are read.
        rate: result: the accelerations of the base [m/s²], which are zero if the base is pinned, also if a
            prescribed motion moves it, and of the links [rad/s²]. The function also stores the factors that
            ``copy_factors`` needs for the response to other forces.
    """
    # for a chain with a base joint ``middle`` is a constant, so the compiled code of this call is faster
    if d.chain.has_base_joint:
        solve_along_arms(d, y, rate, 0)
    else:
        solve_along_arms(d, y, rate, d.link_count // 2)


@inlined
def solve_along_arms(d, y, rate, middle):
    """Solve for the accelerations, as ``solve_accelerations``, by elimination up to the joint ``middle``.

    The part of the chain on each side of this joint is an arm. If ``middle`` is 0, the base, there is only
    the arm that ends at the tip: for a pinned or sliding base, or a free chain of one link.
    """
    n = d.link_count
    axx, axy, ayy, bx, by = eliminate_end(d, y, n - 1, True)
    cxx, cxy, cyy, dx, dy = 0.0, 0.0, 0.0, 0.0, 0.0
    if middle > 0:
        cxx, cxy, cyy, dx, dy = eliminate_end(d, y, 0, False)
    for k in range(1, n - middle):
        i = n - 1 - k
        axx, axy, ayy, bx, by = eliminate_inner(d, y, i, True, axx, axy, ayy, bx, by)
        if k < middle:
            cxx, cxy, cyy, dx, dy = eliminate_inner(d, y, k, False, cxx, cxy, cyy, dx, dy)

    # the acceleration a of the middle joint: A a + b = 0 in a free chain; if the base is pinned or slides,
    # the base is the middle joint: a = 0 at a pinned base, and a is along the line on a slider
    ax, ay = 0.0, 0.0
    if d.slides:
        # the slider's equation of motion (slider.py): a = s̈ u, (u·A u + m) s̈ = F + u·(f + m g − b), with
        # the direction u, the coordinate s, the carriage's mass m, gravity g, the force F of the drive, the
        # applied force f on the base, which contains dry friction, and A a + b, the force that the chain
        # needs
        ux, uy, m = d.slider.ux, d.slider.uy, d.slider.mass
        elimination = d.scratch.elimination
        elimination.middle_xx, elimination.middle_xy, elimination.middle_yy = axx, axy, ayy
        push_x = d.scratch.applied_force.x[0] + m * d.chain.gravity[0] - bx
        push_y = d.scratch.applied_force.y[0] + m * d.chain.gravity[1] - by
        along = (d.scratch.thrust + ux * push_x + uy * push_y) / inertia_along(d, axx, axy, ayy)
        ax, ay = along * ux, along * uy
    elif middle > 0 or not d.chain.has_base_joint:
        axx, axy, ayy = axx + cxx, axy + cxy, ayy + cyy
        bx, by = bx + dx - d.scratch.applied_force.x[middle], by + dy - d.scratch.applied_force.y[middle]
        determinant = axx * ayy - axy * axy
        ax = (axy * by - ayy * bx) / determinant
        ay = (axy * bx - axx * by) / determinant
        elimination = d.scratch.elimination
        elimination.middle_xx, elimination.middle_xy, elimination.middle_yy = axx, axy, ayy

    # Accelerations from the middle outward: a is the acceleration of a joint of the arm toward the tip, c of
    # a joint of the arm toward the base; the base gets the last c. A base with a prescribed motion is the
    # middle joint: the links get the base's given acceleration, but the rate of the base is 0, because the
    # solver does not integrate the base's motion.
    cx, cy = ax, ay
    if d.channel_count > 0 and d.chain.base_moves:
        ax, ay = d.channel.acceleration[0], d.channel.acceleration[1]
    for k in range(n - middle):
        ax, ay = accelerate_link(d, y, middle + k, True, ax, ay, rate)
        if k < middle:
            cx, cy = accelerate_link(d, y, middle - 1 - k, False, cx, cy, rate)
    rate[velocity_at(n)] = cx
    rate[velocity_at(n) + 1] = cy


def inertia_along(d, axx, axy, ayy):
    """Return u·A u + m [kg], the inertia of chain and carriage along the line of a slider.

    u is the line's direction, A (xx, xy, yy) the articulated inertia of the chain at the base, and m the
    carriage's mass.
    """
    ux, uy = d.slider.ux, d.slider.uy
    return (ux * ux) * axx + (2.0 * ux * uy) * axy + (uy * uy) * ayy + d.slider.mass

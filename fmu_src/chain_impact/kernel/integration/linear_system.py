"""The linear systems of an implicit step, (1 − s A) x = r, for a real and for complex shifts s.

A is the stiff part of the Jacobian. A point resting on a stiff wall makes the equations stiff: the contact's
own motions are far faster than the chain's, and decay. So do joints with dampers or springs; their moments
are −C v − S q, up to constants, with C = Σ c_i g_i g_iᵀ, S = Σ k_i g_i g_iᵀ and g_i the gradient of
ω_i − ω_{i−1}. All other terms are left out and treated by Newton's iteration. For z of extended.py

    ∂v̇/∂(g, ġ, v, q) = −M⁻¹ (Jᵀk, Jᵀc, C, S),   g̈ likewise with −J M⁻¹,   ∂(ẋ, ġ)/∂(v, ġ) = 1,

k = ∂F/∂δ, c = ∂F/∂δ̇, J the gradient of the clearances. The solution needs no linear algebra except the
recursion. With x_v = r_v − Δ the rows of v̇ are M Δ = s (Jᵀ (k x_g + c x_ġ) + C x_v + S x_q), hence

    (M + Jᵀ D J + K) Δ = Jᵀ (D r_ġ + s k r_g) + K r_v + s S r_q,   D = s c + s² k,   K = s C + s² S,
    x_v = r_v − Δ,   x_ġ = r_ġ − J Δ,   x_q = r_q + s x_v,   x_g = r_g + s x_ġ,

with Δ the response of the chain to impulses at the touching points and moments in the joints. The contacts'
impedance D adds to the articulated inertia at their points. κ_i = s (c_i + s k_i) acts as a damper in joint
i, on which K r_v + s S r_q is an impulse: chain/damped.py, and chain/shifted.py for a complex s. A point that
a rigid wall constrains, J Δ = 0, has an impedance far larger than the mass of the chain.
"""

from chain_impact.kernel.chain.damped import joint_damping, joint_resistance
from chain_impact.kernel.chain.kinematics import move_points
from chain_impact.kernel.chain.recursion import no_impedance
from chain_impact.kernel.chain.shifted import factorize_shifted, solve_shifted, times
from chain_impact.kernel.chain.springs import spring_stiffness
from chain_impact.kernel.chain.state import ANGLES, coordinate_count, omega_at, velocity_at
from chain_impact.kernel.integration.extended import compliant, gap_at, impulse_at, rate_at
from chain_impact.kernel.integration.impulse import impulse_count
from chain_impact.kernel.model.compliance import factorize_contacts, holding_impedance, solve_chain
from chain_impact.kernel.model.constraints import constraint_rows
from chain_impact.kernel.model.geometry import (
    add_along,
    add_impedance,
    along,
    clear_loads_of,
    impedance_of_joints,
    normal,
    tangent,
    to_joints,
)


def factorize_real(d, shift):
    """Eliminate M + Jᵀ D J + K for a real s = ``shift`` [s]."""
    own = d.implicit
    for k in range(compliant(d)):
        # D = s c + s² k
        own.impedance[k] = shift * (own.damping[k] + shift * own.stiffness[k])
    for k in range(compliant(d), constraint_rows(d)):
        own.impedance[k] = holding_impedance(d)
    factorize_contacts(d, own.link, own.impedance, shift, own.real)


def solve_real(d, shift, x):
    """Solve (1 − s A) x = r for the real s = ``shift`` [s] that was factorized; x holds r."""
    n, own, change = d.links, d.implicit, d.implicit.answer[0]
    clear_loads_of(d, d.work.load)
    if d.model.resisting:
        for i in range(n):
            # K r_v + s S r_q
            turning, turned = relative(x, omega_at(n), i), relative(x, ANGLES, i)
            moment = joint_resistance(d, i, shift) * turning + shift * spring_stiffness(d, i) * turned
            d.work.load.joint[i] = moment
    for k in range(compliant(d)):
        # D r_ġ + s k r_g
        impulse = own.impedance[k] * x[rate_at(d, k)] + shift * own.stiffness[k] * x[gap_at(d, k)]
        add_along(normal(d, d.touch.active_index[k]), d.work.load, impulse)
    solve_chain(d, own.link, own.real, change)
    for j in range(coordinate_count(n)):
        x[velocity_at(n) + j] -= change[j]
        x[j] += shift * x[velocity_at(n) + j]
    for k in range(compliant(d)):
        x[rate_at(d, k)] -= along(normal(d, d.touch.active_index[k]), d.work.motion)
        x[gap_at(d, k)] += shift * x[rate_at(d, k)]
    for k in range(min(impulse_count(d), compliant(d))):
        x[impulse_at(d, k)] -= shift * (
            own.stiffness[k] * x[gap_at(d, k)] + own.damping[k] * x[rate_at(d, k)]
        )


def relative(r, first, i):
    """Entry i of those that begin at ``first``, relative to the previous one; the base has 0."""
    return r[first + i] - (r[first + i - 1] if i > 0 else 0.0)


def factorize_complex(d, pair, s_r, s_i):
    """Eliminate M + Jᵀ D J + K for a complex s [s], given by its parts."""
    own, impedance, reactance = d.implicit, d.work.impedance, d.implicit.reactance
    complex_d, re, im = own.factors.impedance, 2 * pair, 2 * pair + 1
    no_impedance(d, impedance)
    no_impedance(d, reactance)
    square_r, square_i = times(s_r, s_i, s_r, s_i)
    for k in range(d.touch.active_count):
        c = d.touch.active_index[k]
        if k >= compliant(d):
            add_impedance(normal(d, c), impedance, holding_impedance(d))
        else:
            # D = s c + s² k
            complex_d[re, k] = s_r * own.damping[k] + square_r * own.stiffness[k]
            complex_d[im, k] = s_i * own.damping[k] + square_i * own.stiffness[k]
            add_impedance(normal(d, c), impedance, complex_d[re, k])
            add_impedance(normal(d, c), reactance, complex_d[im, k])
    for i in range(d.friction.stuck_count):
        add_impedance(tangent(d, d.element.stuck[i]), impedance, holding_impedance(d))
    if d.model.jointed:
        impedance_of_joints(d, impedance)
        impedance_of_joints(d, reactance)
    factorize_shifted(d, own.link, impedance, reactance, pair, s_r, s_i, own.factors)


def solve_complex(d, pair, s_r, s_i, x, y):
    """Solve (1 − s A) (x + iy) = r for the complex s [s] that was factorized; x and y hold r."""
    n, own, work = d.links, d.implicit, d.work
    change, change_i, own_motion = own.answer[0], own.answer[1], own.motion
    complex_d, re, im = own.factors.impedance, 2 * pair, 2 * pair + 1
    clear_loads_of(d, work.load)
    clear_loads_of(d, own.load)
    load_joints(d, s_r, s_i, x, y)
    for k in range(compliant(d)):
        # D r_ġ + s k r_g
        c, stiffness = d.touch.active_index[k], own.stiffness[k]
        fast_r, fast_i = times(complex_d[re, k], complex_d[im, k], x[rate_at(d, k)], y[rate_at(d, k)])
        deep_r, deep_i = times(s_r, s_i, x[gap_at(d, k)], y[gap_at(d, k)])
        add_along(normal(d, c), work.load, fast_r + stiffness * deep_r)
        add_along(normal(d, c), own.load, fast_i + stiffness * deep_i)
    if d.model.jointed:
        to_joints(d, work.load)
        to_joints(d, own.load)
    solve_shifted(d, own.link, own.factors, pair, work.load, own.load, own.answer)
    move_points(d, own.link, change, work.motion)
    move_points(d, own.link, change_i, own_motion)
    for j in range(coordinate_count(n)):
        at = velocity_at(n) + j
        x[at], y[at] = x[at] - change[j], y[at] - change_i[j]
        add_product(x, y, j, s_r, s_i, x[at], y[at])
    for k in range(compliant(d)):
        c, at = d.touch.active_index[k], rate_at(d, k)
        x[at], y[at] = x[at] - along(normal(d, c), work.motion), y[at] - along(normal(d, c), own_motion)
        add_product(x, y, gap_at(d, k), s_r, s_i, x[at], y[at])
    for k in range(min(impulse_count(d), compliant(d))):
        deep, fast = gap_at(d, k), rate_at(d, k)
        force_r = own.stiffness[k] * x[deep] + own.damping[k] * x[fast]
        force_i = own.stiffness[k] * y[deep] + own.damping[k] * y[fast]
        add_product(x, y, impulse_at(d, k), -s_r, -s_i, force_r, force_i)


def add_product(x, y, j, a, b, c, d):
    """Add (a + ib)(c + id) to entry j of x + iy."""
    more_r, more_i = times(a, b, c, d)
    x[j] += more_r
    y[j] += more_i


def load_joints(d, s_r, s_i, x, y):
    """Set the impulses in the joints: K r_v + s S r_q."""
    if not d.model.resisting:
        return
    n, real, imaginary = d.links, d.work.load.joint, d.implicit.load.joint
    square_r, square_i = times(s_r, s_i, s_r, s_i)
    for i in range(n):
        # κ = s c + s² k
        c, stiffness = joint_damping(d, i), spring_stiffness(d, i)
        damper_r, damper_i = s_r * c + square_r * stiffness, s_i * c + square_i * stiffness
        turning_r, turning_i = relative(x, omega_at(n), i), relative(y, omega_at(n), i)
        add_product(real, imaginary, i, damper_r, damper_i, turning_r, turning_i)
        turned_r, turned_i = relative(x, ANGLES, i), relative(y, ANGLES, i)
        add_product(real, imaginary, i, s_r * stiffness, s_i * stiffness, turned_r, turned_i)

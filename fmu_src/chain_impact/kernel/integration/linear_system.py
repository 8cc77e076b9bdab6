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
i, on which K r_v + s S r_q is an impulse (chain/elimination.py). A point that a rigid wall constrains,
J Δ = 0, has an impedance far larger than the mass of the chain.

The functions take s, x and work ``space`` that are all real or all complex. The space has impedances, loads,
factors, of which a ``row`` is used, and the resulting motion.
"""

from chain_impact.kernel.chain.elimination import SHIFTED, factorize, no_impedance
from chain_impact.kernel.chain.joints import joint_resistance, spring_stiffness
from chain_impact.kernel.chain.state import ANGLES, coordinate_count, omega_at, velocity_at
from chain_impact.kernel.integration.extended import compliant, gap_at, quadrature_at, rate_at
from chain_impact.kernel.model.compliance import holding_impedance, joints_loaded, solve_space
from chain_impact.kernel.model.geometry import (
    add_along,
    add_impedance,
    along,
    clear_loads_of,
    constraint,
    constraint_rows,
    join,
)


def contact_impedance(d, k, s):
    """D = s c + s² k [kg] of the k-th contact with a clearance in z."""
    return s * (d.implicit.damping[k] + s * d.implicit.stiffness[k])


def factorize_shift(d, s, space, row):
    """Eliminate M + Jᵀ D J + K for a shift s [s]."""
    no_impedance(d, space.impedance)
    for k in range(compliant(d)):
        add_impedance(constraint(d, k), space.impedance, contact_impedance(d, k, s))
    for k in range(compliant(d), constraint_rows(d)):
        add_impedance(constraint(d, k), space.impedance, holding_impedance(d))
    join(d, space.impedance, s)
    factorize(d, d.implicit.link, space, row, d.model.resisting != 0 or joints_loaded(d))


def solve_shift(d, s, space, row, x):
    """Solve (1 − s A) x = r for the shift s [s] that was factorized; x holds r."""
    n, own, change = d.links, d.implicit, space.change
    clear_loads_of(d, space.load)
    if d.model.resisting:
        for i in range(n):
            # K r_v + s S r_q
            turning, turned = relative(x, omega_at(n), i), relative(x, ANGLES, i)
            moment = joint_resistance(d, i, s) * turning + s * spring_stiffness(d, i) * turned
            space.load.joint[i] = moment
    for k in range(compliant(d)):
        # D r_ġ + s k r_g
        impulse = contact_impedance(d, k, s) * x[rate_at(d, k)] + s * own.stiffness[k] * x[gap_at(d, k)]
        add_along(constraint(d, k), space.load, impulse)
    solve_space(d, own.link, space, row, change)
    for j in range(coordinate_count(n)):
        x[velocity_at(n) + j] -= change[j]
        x[j] += s * x[velocity_at(n) + j]
    for k in range(compliant(d)):
        x[rate_at(d, k)] -= along(constraint(d, k), space.motion)
        x[gap_at(d, k)] += s * x[rate_at(d, k)]
    for k in range(min(d.quadrature.count, compliant(d))):
        x[quadrature_at(d, k)] -= s * (own.stiffness[k] * x[gap_at(d, k)] + own.damping[k] * x[rate_at(d, k)])


def relative(r, first, i):
    """Entry i of those that begin at ``first``, relative to the previous one; the base has 0."""
    return r[first + i] - (r[first + i - 1] if i > 0 else 0.0)


def factorize_real(d, s):
    """Eliminate for a real shift s [s]."""
    d.implicit.shift = s
    factorize_shift(d, s, d.work, SHIFTED)


def solve_real(d, s, x):
    """Solve (1 − s A) x = r for a real shift s [s]; x holds r."""
    solve_shift(d, s, d.work, SHIFTED, x)


def factorize_complex(d, s, pair):
    """Eliminate for a complex shift s [s], one of a ``pair`` of conjugate ones."""
    factorize_shift(d, s, d.implicit.pairs, pair)


def solve_complex(d, s, pair, x, y, size):
    """Solve (1 − s A) (x + iy) = r for a complex shift s [s]; x and y hold r, of so many entries."""
    own = d.implicit.pairs
    for j in range(size):
        own.x[j] = complex(x[j], y[j])
    solve_shift(d, s, own, pair, own.x)
    for j in range(size):
        x[j], y[j] = own.x[j].real, own.x[j].imag

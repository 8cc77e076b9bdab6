"""The rates of the motions due to joints: of the decay by dampers and the oscillation by springs.

With C = Σ c_i g_i g_iᵀ, g_i the gradient of ω_i − ω_{i−1}, damped motions decay with the eigenvalues of
M⁻¹ C. The largest is at least the rate of one joint whose damper is the only one,

    ρ_i = c_i g_iᵀ M⁻¹ g_i,

and not much larger. Likewise for springs S = Σ k_i g_i g_iᵀ and the squares of the frequencies,

    ω_i² = k_i g_iᵀ M⁻¹ g_i.

A moment in joint i acts on two arms that share the joint's acceleration a: as 1 on the one outward
(A, k = h/H, 1/H, as recursion.py eliminates it), as −1 on the one inward (Ā, k̄, 1/H̄):

    α = 1/H − k·a,   ᾱ = −1/H̄ − k̄·a,   (A + Ā) a + k − k̄ = 0,
    g_iᵀ M⁻¹ g_i = α − ᾱ = 1/H + 1/H̄ + (k − k̄)·(A + Ā)⁻¹ (k − k̄).

As M ≥ diag(I), no eigenvalue exceeds the largest of diag(I)⁻¹ C, which no row sum exceeds (Gershgorin):
2 (c_i + c_{i+1})/I_i, and for springs 2 (k_i + k_{i+1})/I_i. With both, λ² + λ c + k = 0 where c and k are at
most these bounds, hence |λ| ≤ c + √k. This bound does not depend on the angles. A damper or spring at a link
without inertia makes it infinite.
"""

import math

from chain_impact.kernel.chain.damped import joint_damping
from chain_impact.kernel.chain.kinematics import link_vectors
from chain_impact.kernel.chain.recursion import factorize_link, no_impedance
from chain_impact.kernel.chain.springs import spring_stiffness

HELD = 1e6  # times the mass of the first link: the inertia of a pin, which changes the rates by 1e-6


def joint_bound(d):
    """An upper bound [1/s] on the rates of decay and oscillation by the joints' dampers and springs."""
    damping, stiffness = 0.0, 0.0
    for i in range(d.links):
        c, k = joint_damping(d, i), spring_stiffness(d, i)
        if i + 1 < d.links:
            c += joint_damping(d, i + 1)
            k += spring_stiffness(d, i + 1)
        damping = max(damping, over(2.0 * c, d.model.inertia[i]))
        stiffness = max(stiffness, over(2.0 * k, d.model.inertia[i]))
    return damping + math.sqrt(stiffness)


def over(resistance, inertia):
    """A resistance over an inertia, neither of them negative; 0/0 = 0."""
    if inertia > 0.0:
        return resistance / inertia
    return math.inf if resistance > 0.0 else 0.0


def joint_rate(d, y):
    """The largest of all ρ_i and ω_i [1/s] in the state y, whose link vectors are stored in ``work.link``."""
    link_vectors(d, y)
    link, factors, inner = d.work.link, d.work.factors, d.work.inner
    impedance = d.work.impedance
    no_impedance(d, impedance)
    pin = HELD * d.model.mass[0] if d.model.pinned else 0.0
    axx, axy, ayy = pin, 0.0, pin
    for i in range(d.links):
        axx, axy, ayy = factorize_link(d, link, impedance, inner, i, False, axx, axy, ayy)
        inner.xx[i], inner.xy[i], inner.yy[i] = axx, axy, ayy
    fastest = 0.0
    axx, axy, ayy = 0.0, 0.0, 0.0
    for k in range(d.links):
        i = d.links - 1 - k
        axx, axy, ayy = factorize_link(d, link, impedance, factors, i, True, axx, axy, ayy)
        free = mobility(d, i, axx, axy, ayy)
        fastest = max(fastest, joint_damping(d, i) * free, math.sqrt(spring_stiffness(d, i) * free))
    return fastest


def mobility(d, i, axx, axy, ayy):
    """g_iᵀ M⁻¹ g_i [1/(kg·m²)] for both arms of joint i and the A of the outer one."""
    outer, inner = d.work.factors, d.work.inner
    if i == 0:
        return outer.inverse[0]  # a pin: a = 0
    x, y = outer.gain_x[i] - inner.gain_x[i - 1], outer.gain_y[i] - inner.gain_y[i - 1]
    axx, axy, ayy = axx + inner.xx[i - 1], axy + inner.xy[i - 1], ayy + inner.yy[i - 1]
    # (k − k̄)·(A + Ā)⁻¹ (k − k̄)
    shared = (ayy * x * x - 2.0 * axy * x * y + axx * y * y) / (axx * ayy - axy * axy)
    return outer.inverse[i] + inner.inverse[i - 1] + shared

"""f(e) of Kuwabara and Kono: the damping g with which an impact realises the restitution e.

The impact has the mass, the stiffness and the impact speed 1: m = K = v₀ = 1. Its force is
F = max(0, δ^{3/2} + g δ^{1/2} δ̇), with the penetration δ. With z = √δ, w = δ̇ and a variable s in place of
the time t, where dt = 2z ds, the right-hand sides are polynomials: dz/ds = w, dw/ds = −2z²(z² + g w). While
F > 0, w falls. When F reaches 0, w has its minimum, which is −e: the impact ends.

    f(e) = (1 − e) e^(−3/5) P(r),   r = √(1 − e^(1/8))

The factor 1 − e is 0 at e = 1, as f is, and e^(−3/5) is infinite at e = 0, as f is; P is smooth. For e → 1
the restitution e is a series in the powers 0, 1, 2, 5/2 … of g, so P is smooth in √(1 − e). For e → 0 the
restitution is proportional to g^(−5/3), with terms of e ln e. P falls from 1.1761 at e = 0 to 1/1.15345 at
e = 1. The kernel uses a polynomial in r for P; its relative error is below 2e-11 for all e. The coefficients
come from solutions of the impact by Taylor series of order 24, at 64 Chebyshev points.
"""

import math

from chain_impact.kernel.mathematics.exponentials import exp, expm1
from chain_impact.kernel.mathematics.logarithms import log

CHEBYSHEV_COEFFICIENTS = (
    1.03271384845832,
    0.1847072566438916,
    -0.01671535445063114,
    -0.03721727370647146,
    0.006396675131328571,
    0.008493436112951088,
    -0.0005865981151766474,
    -0.001691007101392291,
    -0.0004322256960379083,
    0.0002708975745739573,
    0.0001779595761334634,
    4.909512247297751e-06,
    -3.414074436239121e-05,
    -1.411262063511191e-05,
    1.152928781530904e-06,
    2.973589287016968e-06,
    9.769573498914527e-07,
    -1.07740563200341e-07,
    -1.989037255581121e-07,
    -6.388653716625646e-08,
    3.070089941936028e-09,
    1.127568295613235e-08,
    5.100051062565567e-09,
    8.18447981331543e-10,
    -5.722270411891142e-10,
    -5.686217507266342e-10,
    -2.257025204907669e-10,
    1.366058085033507e-11,
    6.341555601869174e-11,
    3.644739035504518e-11,
    2.319357752853941e-13,
    -5.361139578642958e-12,
    -6.519081540287504e-12,
    1.232169309263561e-12,
)
"""The coefficients of P, for the Chebyshev polynomials of 2r − 1."""
# The largest 1 − e for which P has its value at e = 1 (r = 0), because toward e = 1 the derivative of r with
# respect to e grows without bound.
NEAREST_TO_ONE = 1e-12


def viscoelastic_factor(e):
    """Return f(e), the factor of the damping in the law of Kuwabara and Kono, for 0 < e ≤ 1."""
    exponent = log(e)
    root = math.sqrt(-expm1(0.125 * exponent)) if 1.0 - e > NEAREST_TO_ONE else 0.0 * e
    return (1.0 - e) * exp(-0.6 * exponent) * evaluate_series(2.0 * root - 1.0)


def evaluate_series(x):
    """Return the sum of the Chebyshev series of P at x, by Clenshaw's rule (1955, Math Tab Wash 9:118)."""
    last, sum_so_far = 0.0 * x, 0.0 * x
    for k in range(len(CHEBYSHEV_COEFFICIENTS) - 1, 0, -1):
        last, sum_so_far = sum_so_far, CHEBYSHEV_COEFFICIENTS[k] + 2.0 * x * sum_so_far - last
    return CHEBYSHEV_COEFFICIENTS[0] + x * sum_so_far - last

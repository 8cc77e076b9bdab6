"""Cosines and sines of all angles at once, without branches: three times cheaper than the C library's.

Those of the C library would take half the time of a right-hand side. These are the same on every machine, so
results do not depend on its C library. Their errors are below 2e-16, see tests/kernel/chain/test_sincos.py.
"""

import math

from chain_impact.kernel.inlining import inlined

LARGEST = 1e6  # rad; beyond it the reduction loses digits
TWO_OVER_PI = 0.6366197723675814
# π/2 in two parts, the first of 33 bits, so that any multiple by k < 2²⁰ is exact (after Cody & Waite 1980)
HALF_PI_1, HALF_PI_2 = 1.5707963267341256, 6.077100506506192e-11
# best approximations on |r| ≤ π/4: sin r = r + r³ S(r²), cos r = 1 − r²/2 + r⁴ C(r²), by Remez's exchange
# fmt: off
S = (-0.166666666666666, 0.008333333333316473, -0.00019841269825928324,
     2.75573125428654e-06, -2.505059994965131e-08, 1.58885695564513e-10)
C = (0.0416666666666666, -0.0013888888888874133, 2.480158728948765e-05,
     -2.75573143539534e-07, 2.0875723499343115e-09, -1.1359659812851872e-11)
# fmt: on


# adding and subtracting it rounds to an integer, as doubles of its size have no fraction
ROUND = 1.5 * 2.0**52


def polar(radius, y, first, horizontal, vertical):
    """Set r cos φ and r sin φ for each radius r and the angles φ in y, from index ``first`` on.

    All arrays are as long as ``radius``, shape (N,), or longer.
    """
    count = len(radius)
    if not in_reach(y, first, count):
        for i in range(count):
            horizontal[i] = radius[i] * math.cos(y[first + i])
            vertical[i] = radius[i] * math.sin(y[first + i])
        return
    # the compiler knows that the results do not overwrite this copy …
    copy(y, first, count, vertical)
    # … so it uses vector instructions here
    for i in range(count):
        cosine, sine = cosine_and_sine(vertical[i])
        horizontal[i] = radius[i] * cosine
        vertical[i] = radius[i] * sine


@inlined
def copy(y, first, count, out):
    """Copy ``count`` numbers of y, from index ``first`` on, in vectors.

    They are read again as vectors, which is slow for a processor if they were written one by one. All numbers
    of a group are read before the first is written, so the compiler moves a group as a vector.
    """
    fours, pairs = count - count % 4, count - count % 2
    for i in range(0, fours, 4):
        a, b, c, d = y[first + i], y[first + i + 1], y[first + i + 2], y[first + i + 3]
        out[i], out[i + 1], out[i + 2], out[i + 3] = a, b, c, d
    for i in range(fours, pairs, 2):
        a, b = y[first + i], y[first + i + 1]
        out[i], out[i + 1] = a, b
    for i in range(pairs, count):
        out[i] = y[first + i]


def in_reach(y, first, count):
    """Whether the angles in y, from index ``first`` on, are small enough for ``cosine_and_sine``."""
    total = 0.0
    for i in range(count):
        total += abs(y[first + i])
    return total < LARGEST


@inlined
def cosine_and_sine(angle):
    """The cosine and sine of an angle below LARGEST."""
    # φ = k π/2 + r
    k = (angle * TWO_OVER_PI + ROUND) - ROUND
    r = (angle - k * HALF_PI_1) - k * HALF_PI_2
    # the quarter turns k mod 4, from −2 to 2
    turns = k - 4.0 * ((0.25 * k + ROUND) - ROUND)
    t = r * r
    t2 = t * t
    s = r + r * t * ((S[0] + t * S[1]) + t2 * ((S[2] + t * S[3]) + t2 * (S[4] + t * S[5])))
    c = 1.0 - (0.5 * t - t2 * ((C[0] + t * C[1]) + t2 * ((C[2] + t * C[3]) + t2 * (C[4] + t * C[5]))))
    # p = cos(turns π/2) and q = sin(turns π/2) are polynomials in turns, exact in floating point
    u = turns * turns
    p, q = 1.0 - u * (7.0 - u) * (1.0 / 6.0), turns * (4.0 - u) * (1.0 / 3.0)
    return p * c - q * s, p * s + q * c

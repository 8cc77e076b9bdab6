"""Cosines and sines of angles.

``cosine_and_sine`` has no branches, so its compiled code computes several angles at once, about three times
faster than the C library; with this library, sines would take half the time of an evaluation of ẏ. The errors
are below 2e-16, see tests/kernel/mathematics/test_angles.py.
"""

import math

import numpy as np

from chain_impact.kernel.function_marks import has_dual_rule, inlined
from chain_impact.kernel.mathematics.doubles import (
    BITS_OF_ONE,
    FRACTION_BITS,
    ROUNDING_TERM,
    bits_of,
    double_of_bits,
)

# [rad] the largest |angle| for ``cosine_and_sine``; a larger angle would lose digits when its quarter turns
# are subtracted
LARGEST_ANGLE = 1e6
TWO_OVER_PI = 0.6366197723675814
# π/2 as a sum of two numbers. The first has at most 33 bits, so its product with any integer k, |k| < 2²⁰, is
# exact (after Cody & Waite 1980).
HALF_PI_1, HALF_PI_2 = 1.5707963267341256, 6.077100506506192e-11
HALF_PI = 1.5707963267948966
# coefficients, from the constant one on, of the best polynomials S and C for |r| ≤ π/4, by Remez's exchange:
# sin r = r + r³ S(r²), cos r = 1 − r²/2 + r⁴ C(r²)
# fmt: off
S = (-0.166666666666666, 0.008333333333316473, -0.00019841269825928324,
     2.75573125428654e-06, -2.505059994965131e-08, 1.58885695564513e-10)
C = (0.0416666666666666, -0.0013888888888874133, 2.480158728948765e-05,
     -2.75573143539534e-07, 2.0875723499343115e-09, -1.1359659812851872e-11)
# fmt: on
# GROUP_BITS: the number of bits of 2/π in each group, an entry of TWO_OVER_PI_DIGITS. GROUP_COUNT: the number
# of groups that ``reduce_far_angle`` uses for one angle, enough for every double.
GROUP_BITS, GROUP_COUNT = 24, 6
# exponent e of the largest double m 2^e, with an integer m of 53 bits; this exponent determines how many bits
# of 2/π are stored
LAST_DIGIT = 971


def _digit_groups():
    """Return the binary digits of 2/π after the point, in groups of GROUP_BITS digits.

    Each group is an integer, stored as a double; the first group has the digits next to the point.
    """
    count = LAST_DIGIT // GROUP_BITS + GROUP_COUNT + 1
    scale = GROUP_BITS * count + 32
    # Machin's formula of 1706: π = 16 arctan(1/5) − 4 arctan(1/239)
    digits = (2 << 2 * scale) // (16 * _fixed_arctangent(5, scale) - 4 * _fixed_arctangent(239, scale))
    groups = (digits >> (scale - GROUP_BITS * (i + 1)) & ((1 << GROUP_BITS) - 1) for i in range(count))
    return np.array([float(group) for group in groups])


def _fixed_arctangent(n, scale):
    """Return arctan(1/n) times 2^scale, rounded to an integer near it, for an integer n > 1."""
    term, total, k = (1 << scale) // n, 0, 1
    while term:
        total += term // k if k % 4 == 1 else -(term // k)
        term, k = term // (n * n), k + 2
    return total


TWO_OVER_PI_DIGITS = _digit_groups()


@has_dual_rule
def unit_vector(angle):
    """Return the cosine and sine of any angle [rad]; both are NaN if the angle is not finite."""
    if abs(angle) < LARGEST_ANGLE:
        return cosine_and_sine(angle)
    if not abs(angle) < math.inf:
        return math.nan, math.nan
    turns, r = reduce_far_angle(angle)
    return cosine_and_sine_of_parts(turns, r)


def cosine(angle):
    """Return the cosine of any angle [rad]; NaN if the angle is not finite."""
    return unit_vector(angle)[0]


def sine(angle):
    """Return the sine of any angle [rad]; NaN if the angle is not finite."""
    return unit_vector(angle)[1]


@inlined
def cosine_and_sine(angle):
    """Return the cosine and sine of an angle [rad] between −LARGEST_ANGLE and LARGEST_ANGLE."""
    # the angle φ is k quarter turns and a remainder r: φ = k π/2 + r
    k = (angle * TWO_OVER_PI + ROUNDING_TERM) - ROUNDING_TERM
    r = (angle - k * HALF_PI_1) - k * HALF_PI_2
    # k mod 4, as an integer from −2 to 2: whole turns have no effect
    turns = k - 4.0 * ((0.25 * k + ROUNDING_TERM) - ROUNDING_TERM)
    return cosine_and_sine_of_parts(turns, r)


@inlined
def cosine_and_sine_of_parts(turns, r):
    """Return cosine and sine of turns π/2 + r, for an integer ``turns`` from −2 to 2, and |r| up to π/4."""
    t = r * r
    t2 = t * t
    s = r + r * t * ((S[0] + t * S[1]) + t2 * ((S[2] + t * S[3]) + t2 * (S[4] + t * S[5])))
    c = 1.0 - (0.5 * t - t2 * ((C[0] + t * C[1]) + t2 * ((C[2] + t * C[3]) + t2 * (C[4] + t * C[5]))))
    # With c = cos r and s = sin r, the results are the sums p c − q s and p s + q c. Here p = cos(turns
    # π/2) and q = sin(turns π/2), computed exactly by polynomials that have these values for turns = −2 to 2.
    u = turns * turns
    p, q = 1.0 - u * (7.0 - u) * (1.0 / 6.0), turns * (4.0 - u) * (1.0 / 3.0)
    return p * c - q * s, p * s + q * c


def reduce_far_angle(angle):
    """Return the quarter turns, −2 to 2, and the remainder r [rad] of a large angle, without whole turns.

    The angle [rad] is finite, with |angle| ≥ LARGEST_ANGLE. The bits of 2/π that would only add whole turns
    are not used (M. H. Payne & R. N. Hanek 1983, SIGNUM Newsletter 18:19).
    """
    pattern = bits_of(abs(angle))
    # |φ| = m 2^e for the angle φ, with m = a 2²⁷ + b and integers m, e, a and b
    e = (pattern >> FRACTION_BITS) - 1075
    m = double_of_bits((pattern & ((1 << FRACTION_BITS) - 1)) + (1075 << FRACTION_BITS))
    a = float(math.floor(m * 2.0**-27))
    b = m - a * 2.0**27
    first = max(0, (e - 2) // GROUP_BITS)
    total, lost = 0.0, 0.0
    for i in range(first, first + GROUP_COUNT):
        for half, exponent in ((a, e + 27 - GROUP_BITS * (i + 1)), (b, e - GROUP_BITS * (i + 1))):
            if exponent >= 2:
                continue
            # this product, in quarter turns, is exact, and so is its remainder after whole turns are removed
            part = half * (
                float(TWO_OVER_PI_DIGITS[i]) * double_of_bits(BITS_OF_ONE + (exponent << FRACTION_BITS))
            )
            remainder = part - 4.0 * math.floor(0.25 * part)
            # ``total`` is the sum of the remainders, and ``lost`` the sum of what rounding loses in ``total``
            before, total = total, total + remainder
            lost += remainder - (total - before) if before > remainder else before - (total - remainder)
    k = math.floor(total + 0.5)
    r = ((total - k) + lost) * HALF_PI
    turns = k - 4.0 * math.floor(0.25 * k + 0.5)
    return (turns, r) if angle > 0.0 else (-turns, -r)

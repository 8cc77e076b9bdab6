"""Exponentials e^x and e^x − 1, with errors below 1 ulp (unit in the last place).

e^x = 2^k 2^(j/128) e^r, with an integer k, an integer j from 0 to 127, a small remainder r, and 2^(j/128)
from a table (P. T. P. Tang 1989, ACM Trans Math Softw 15:144).
"""

import math

import numpy as np

from chain_impact.kernel.function_marks import has_dual_rule, inlined
from chain_impact.kernel.mathematics.doubles import (
    FIXED_BITS,
    FRACTION_BITS,
    ROUNDING_TERM,
    bits_of,
    double_of_bits,
    split_in_two_doubles,
)
from chain_impact.kernel.mathematics.logarithms import LINEAR_UP_TO, LN_2, LOG_PLACES, log_parts_beside_one

POWER_COUNT_BITS = 7  # the table has 2⁷ powers of 2, with the exponents j/128
POWER_COUNT = 1 << POWER_COUNT_BITS
# coefficients, from the constant one on, of the best polynomial P for |r| < ln 2/256, by Remez's exchange:
# e^r = 1 + r + r² P(r)
EXP_P = (0.499999999999966, 0.16666666666665828, 0.04166668128670721, 0.008333335946890487)
STEP_HIGH, STEP_LOW = split_in_two_doubles(LN_2 // POWER_COUNT, LOG_PLACES)
STEPS_PER_ONE = (POWER_COUNT << FIXED_BITS) / LN_2
BITS_OF_ROUNDING_TERM = bits_of(ROUNDING_TERM)
# the bound of |x| for ``exp_of_common``: for |x| < COMMON_RANGE, e^x is finite, and has all digits of a
# double
COMMON_RANGE = 650.0
# for |x| ≥ COMMON_RANGE, e^x is computed as e^(x ∓ HALF_RANGE ln 2) times 2^±HALF_RANGE, so that the first
# factor is in the range of ``exp_of_common``
HALF_RANGE = 512
SCALE_UP, SCALE_DOWN = 2.0**HALF_RANGE, 2.0**-HALF_RANGE
HALF_RANGE_HIGH, HALF_RANGE_LOW = split_in_two_doubles(HALF_RANGE * LN_2, LOG_PLACES)
# e^x is infinite above OVERFLOW_ABOVE, and 0 below UNDERFLOW_BELOW
OVERFLOW_ABOVE, UNDERFLOW_BELOW = (710.0, -746.0)
# |x| below which x + x²/2 is e^x − 1 to about eleven digits; a step of Newton's method gives twice as many
NEARLY_LINEAR = 1e-5
# from this x on, 1 is at most 1/32 ulp of e^x, so that the rounded e^x, minus 1, is accurate
STEEP_FROM = 40.0


def _table():
    """Return two arrays for j from 0 to 127: the bits of 2^(j/128) as a double, and what rounding has lost.

    The second array is relative to 2^(j/128).
    """
    patterns, remainders = [], []
    for j in range(POWER_COUNT):
        power, root = 1 << FIXED_BITS, 2 << FIXED_BITS
        for bit in reversed(range(POWER_COUNT_BITS)):  # the factors √2, √√2, … where a bit of j is 1
            root = math.isqrt(root << FIXED_BITS)
            power = power * root >> FIXED_BITS if j >> bit & 1 else power
        high, low = split_in_two_doubles(power, FRACTION_BITS)
        patterns.append(bits_of(high))
        remainders.append(low / high)
    return np.array(patterns), np.array(remainders)


POWER_BITS, POWER_REMAINDERS = _table()


@inlined
def exp_of_common(high, low):
    """Return e^(high + low), for |high| < COMMON_RANGE; |low| is 0 or far smaller than |high|."""
    shifted = high * STEPS_PER_ONE + ROUNDING_TERM
    steps = shifted - ROUNDING_TERM
    count = bits_of(shifted) - BITS_OF_ROUNDING_TERM
    r = ((high - steps * STEP_HIGH) - steps * STEP_LOW) + low
    j, r2 = count & (POWER_COUNT - 1), r * r
    tail = (float(POWER_REMAINDERS[j]) + r) + r2 * (
        (EXP_P[0] + r * EXP_P[1]) + r2 * (EXP_P[2] + r * EXP_P[3])
    )
    power = double_of_bits(int(POWER_BITS[j]) + ((count >> POWER_COUNT_BITS) << FRACTION_BITS))
    return power + power * tail


def exp_of_sum(high, low):
    """Return e^(high + low), for any ``high`` but NaN; |low| is 0 or far smaller than |high|."""
    if abs(high) < COMMON_RANGE:
        return exp_of_common(high, low)
    if high > OVERFLOW_ABOVE:
        return math.inf
    if high < UNDERFLOW_BELOW:
        return 0.0
    if high > 0.0:
        return exp_of_common(high - HALF_RANGE_HIGH, low - HALF_RANGE_LOW) * SCALE_UP
    return exp_of_common(high + HALF_RANGE_HIGH, low + HALF_RANGE_LOW) * SCALE_DOWN


@has_dual_rule
def exp(x):
    """Return e^x: ∞ or 0 beyond the range of doubles, and NaN for NaN."""
    return math.nan if math.isnan(x) else exp_of_sum(x, 0.0)


@has_dual_rule
def expm1(x):
    """Return e^x − 1: ∞ if e^x exceeds the range of doubles, and NaN for NaN."""
    if abs(x) < LINEAR_UP_TO:
        return 1.0 * x
    if not -1.0 < x < STEEP_FROM:
        return exp(x) - 1.0
    y = x + 0.5 * x * x if abs(x) < NEARLY_LINEAR else exp(x) - 1.0
    # one step of Newton's method for the equation ln(1 + y) = x improves y = e^x − 1
    high, low = log_parts_beside_one(y)
    return y + ((x - high) - low) * (1.0 + y)

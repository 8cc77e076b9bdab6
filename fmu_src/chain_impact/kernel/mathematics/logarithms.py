"""Natural logarithms ln x and ln(1 + x), with errors below 1 ulp (unit in the last place).

With x = 2^k m, the mantissa m between about √½ and √2, and a number c near 1/m from a table, ln x = k ln 2 −
ln c + ln(1 + r), r = m c − 1 (P. T. P. Tang 1990, ACM Trans Math Softw 16:378). Each logarithm is first
computed as the sum of two doubles, with a relative error below 2⁻⁶³; powers need this accuracy.
"""

import math

import numpy as np

from chain_impact.kernel.function_marks import has_dual_rule, inlined
from chain_impact.kernel.mathematics.doubles import (
    BITS_OF_LEAST_NORMAL,
    BITS_OF_ONE,
    FIXED_BITS,
    FRACTION_BITS,
    bits_of,
    double_of_bits,
    round_to_26_bits,
    split_in_two_doubles,
)

# MANTISSA_INTERVALS: the number of intervals of the mantissa m, each with a row in the table. WIDTH_BITS: an
# interval contains 2^WIDTH_BITS doubles.
MANTISSA_INTERVALS, WIDTH_BITS = 256, 44
# FIRST_INTERVAL_BITS: the bits of the start of the first interval of the mantissa, near √½. MIDDLE_INTERVAL:
# the index, from 0, of the interval in which c = 1; this interval extends as far below 1 as above 1, so that
# ln x loses no digits near x = 1.
MIDDLE_INTERVAL = 150
FIRST_INTERVAL_BITS = BITS_OF_ONE - 2 * (1 << WIDTH_BITS) // 3 - (MIDDLE_INTERVAL << WIDTH_BITS)
# ln 2 and −ln c are sums of two doubles; the first double has LOG_PLACES bits after the binary point, so that
# k ln 2 − ln c of the first doubles is exact for |k| < 2¹¹
LOG_PLACES = 42
# coefficients, from the constant one on, of the best polynomial P for |r| < 0.0035, by Remez's exchange:
# ln(1 + r) = r − r²/2 + r³ P(r)
LOG_P = (
    0.33333333333333337,
    -0.24999999999045547,
    0.1999999999789618,
    -0.1666689359914569,
    0.14285993276740327,
)
LINEAR_UP_TO = 2.0**-54  # |x| up to which ln(1 + x) and e^x − 1 are equal to x in double precision


def fixed_logarithm(a, b):
    """Return ln(a/b) of two positive integers, times 2^FIXED_BITS, rounded to an integer near it."""
    # ln(a/b) = 2 (z + z³/3 + z⁵/5 + …), z = (a − b)/(a + b)
    term = ((a - b) << FIXED_BITS) // (a + b)
    square, total, n = term * term >> FIXED_BITS, 0, 1
    while abs(term) > 1:
        total += term // n
        term, n = term * square >> FIXED_BITS, n + 2
    return 2 * total


def _table():
    """Return the columns of a table with a row for each interval of the mantissa m.

    The columns are c, a number near 1/m, and the two doubles whose sum is −ln c.
    """
    rows = []
    for i in range(MANTISSA_INTERVALS):
        m = double_of_bits(FIRST_INTERVAL_BITS + (i << WIDTH_BITS) + (1 << (WIDTH_BITS - 1)))
        # c has 9 bits, so r = m c − 1 is exact
        unit = 512 if m > 1.0 else 256
        c = unit if i == MIDDLE_INTERVAL else round(unit / m)
        rows.append((c / unit, *split_in_two_doubles(fixed_logarithm(unit, c), LOG_PLACES)))
    return tuple(np.array(column) for column in zip(*rows, strict=True))


MANTISSA_INVERSE, LOG_HIGH, LOG_LOW = _table()
LN_2 = fixed_logarithm(2, 1)
LN_2_HIGH, LN_2_LOW = split_in_two_doubles(LN_2, LOG_PLACES)


@inlined
def log_parts(pattern):
    """Return the natural logarithm of a positive normal number as the sum of two doubles.

    Args:
        pattern: the 64 bits of the number, as an integer.
    """
    k = (pattern - FIRST_INTERVAL_BITS) >> FRACTION_BITS
    i = ((pattern - FIRST_INTERVAL_BITS) >> WIDTH_BITS) & (MANTISSA_INTERVALS - 1)
    m, c = double_of_bits(pattern - (k << FRACTION_BITS)), float(MANTISSA_INVERSE[i])
    # r = m c − 1 is the sum of u and v; u, v, r and u² are exact
    m_front = round_to_26_bits(m)
    u, v = m_front * c - 1.0, (m - m_front) * c
    r = u + v
    base = float(k) * LN_2_HIGH + float(LOG_HIGH[i])
    # high + rounded = base + r − u²/2: ``rounded`` is the sum of what rounding loses in ``first`` and in
    # ``high``
    first, half_square = base + r, 0.5 * (u * u)
    high = first - half_square
    rounded = ((base - first) + r) + ((first - high) - half_square)
    # −r²/2 without −u²/2, which ``high`` contains: r² − u² = v (u + r), because r = u + v
    small = (float(k) * LN_2_LOW + float(LOG_LOW[i])) - 0.5 * v * (u + r)
    r2 = r * r
    tail = r * r2 * ((LOG_P[0] + r * LOG_P[1]) + r2 * ((LOG_P[2] + r * LOG_P[3]) + r2 * LOG_P[4]))
    return high, (rounded + small) + tail


def log_parts_of_any(x):
    """Return the natural logarithm of a positive finite number, normal or not, as the sum of two doubles."""
    pattern = bits_of(x)
    if pattern < BITS_OF_LEAST_NORMAL:
        pattern = bits_of(x * 2.0**52) - (52 << FRACTION_BITS)
    return log_parts(pattern)


@has_dual_rule
def log(x):
    """Return ln x; −∞ for x = 0, and NaN for x < 0 and for NaN."""
    if 0.0 < x < math.inf:
        high, low = log_parts_of_any(x)
        return high + low
    if x == 0.0:
        return -math.inf
    return math.inf if x > 0.0 else math.nan


def log_parts_beside_one(x):
    """Return ln(1 + x), for −1 < x < ∞, as the sum of two doubles."""
    whole = 1.0 + x
    lost = x - (whole - 1.0) if abs(x) < 1.0 else 1.0 - (whole - x)
    # ln(1 + x) = ln w + d/w − …, with w (``whole``) the rounded sum 1 + x, and d (``lost``) the part 1 + x −
    # w that rounding loses
    high, low = log_parts_of_any(whole)
    return high, low + (lost - 0.5 * lost * lost) / whole


@has_dual_rule
def log1p(x):
    """Return ln(1 + x); −∞ for x = −1, and NaN for x < −1 and for NaN."""
    if abs(x) < LINEAR_UP_TO:
        return 1.0 * x
    if not -1.0 < x < math.inf:
        return log(1.0 + x)
    high, low = log_parts_beside_one(x)
    return high + low

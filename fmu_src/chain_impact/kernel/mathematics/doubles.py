"""Bits of doubles, products as sums of two doubles, and doubles from integers with a fixed binary point."""

import numpy as np

from chain_impact.kernel.function_marks import inlined

BITS_OF_ONE, BITS_OF_INFINITY, BITS_OF_LEAST_NORMAL = 0x3FF << 52, 0x7FF << 52, 1 << 52
"""The bits of 1, of infinity, and of the least positive double that is not subnormal."""
# number of bits of the fraction of a double: the lowest bits, below those of the exponent
FRACTION_BITS = 52
# ROUNDING_HALF and FRONT_MASK round a double to 26 significant bits: ROUNDING_HALF is added to the bits of
# the double, and FRONT_MASK masks the sum
ROUNDING_HALF, FRONT_MASK = 1 << 26, -(1 << 27)
# tables are computed with integers i that stand for the reals i/2^FIXED_BITS
FIXED_BITS = 160
ROUNDING_TERM = 1.5 * 2.0**52
"""x + ROUNDING_TERM, minus this term, is x rounded to an integer, for |x| < 2⁵¹: doubles from 2⁵² on are
integers."""


@inlined
def bits_of(number):
    """Return the 64 bits of a double as a signed integer."""
    return int(np.float64(number).view(np.int64))


@inlined
def double_of_bits(pattern):
    """Return the double whose bits are those of the integer ``pattern``."""
    return float(np.int64(pattern).view(np.float64))


@inlined
def round_to_26_bits(number):
    """Return a number rounded to 26 significant bits, so that products of two such numbers are exact."""
    return double_of_bits((bits_of(number) + ROUNDING_HALF) & FRONT_MASK)


@inlined
def product_in_two_doubles(y, high, low):
    """Return the product y (high + low) as the sum of two doubles, the larger one first.

    |low| is far smaller than |high|. Only the second double is rounded. (T. J. Dekker 1971, Numer Math
    18:224)
    """
    of_y, of_high = round_to_26_bits(y), round_to_26_bits(high)
    return of_y * of_high, (y - of_y) * of_high + y * ((high - of_high) + low)


def split_in_two_doubles(fixed, fraction_bits):
    """Return ``fixed``/2^FIXED_BITS, for an integer ``fixed``, as the sum of two doubles.

    The first double is the nearest multiple of 2^−fraction_bits, so that sums of first doubles can be exact.
    Only the second double is rounded.
    """
    unit = 1 << (FIXED_BITS - fraction_bits)
    first = (fixed + unit // 2) // unit
    return first / (1 << fraction_bits), (fixed - first * unit) / (1 << FIXED_BITS)

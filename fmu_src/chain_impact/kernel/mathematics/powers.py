"""Powers, with errors below 1 ulp: x^y = e^(y ln x), with the exponent as the sum of two doubles."""

import math

from chain_impact.kernel.functions import has_dual_rule
from chain_impact.kernel.mathematics.doubles import INFINITY, LEAST_NORMAL, bits, product
from chain_impact.kernel.mathematics.exponentials import COMMON, common, of_sum
from chain_impact.kernel.mathematics.logarithms import any_parts, parts

ALL_EVEN = 2.0**53  # from this number on all doubles are even integers
HUGE_EXPONENT = 2.0**64  # |y| from which x^y is 0, 1 or infinite


@has_dual_rule
def power(x, y):
    """Return x^y."""
    pattern = bits(x)
    if LEAST_NORMAL <= pattern < INFINITY:
        high, low = parts(pattern)
        high, low = product(y, high, low)
        if abs(high) < COMMON:
            return common(high, low)
    return any_power(x, y)


def any_power(x, y):
    """Return x^y of any numbers; 0, infinite numbers and NaN give what C and Python define."""
    if y == 0.0 or x == 1.0:
        return 1.0
    if math.isnan(x) or math.isnan(y):
        return math.nan
    whole = abs(y) >= ALL_EVEN or math.floor(y) == y
    size = abs(x)
    if x < 0.0 and size < math.inf and not whole:
        return math.nan
    odd = whole and abs(y) < ALL_EVEN and math.floor(0.5 * y) != 0.5 * y
    return math.copysign(of_size(size, y), x) if odd else of_size(size, y)


def of_size(x, y):
    """Return x^y for x ≥ 0 and y ≠ 0."""
    if x == 1.0:
        return 1.0
    if x == 0.0 or math.isinf(x) or abs(y) >= HUGE_EXPONENT:
        return math.inf if (x > 1.0) == (y > 0.0) else 0.0
    high, low = any_parts(x)
    high, low = product(y, high, low)
    return of_sum(high, low)

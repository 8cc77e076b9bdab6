"""Powers, with errors below 1 ulp (unit in the last place).

x^y = e^(y ln x) for x > 0, with y ln x as the sum of two doubles.
"""

import math

from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.mathematics.doubles import (
    BITS_OF_INFINITY,
    BITS_OF_LEAST_NORMAL,
    bits_of,
    product_in_two_doubles,
)
from chain_impact.kernel.mathematics.exponentials import COMMON_RANGE, exp_of_common, exp_of_sum
from chain_impact.kernel.mathematics.logarithms import log_parts, log_parts_of_any

ALL_EVEN = 2.0**53  # from this number on all doubles are even integers
HUGE_EXPONENT = 2.0**64  # for |y| from this number on, |x|^y is 0, 1 or infinite for every x but NaN


@has_dual_rule
def power(x, y):
    """Return x^y for any x and y, as ``any_power``; faster for a normal x > 0 and |y ln x| < COMMON_RANGE."""
    pattern = bits_of(x)
    if BITS_OF_LEAST_NORMAL <= pattern < BITS_OF_INFINITY:
        high, low = log_parts(pattern)
        high, low = product_in_two_doubles(y, high, low)
        if abs(high) < COMMON_RANGE:
            return exp_of_common(high, low)
    return any_power(x, y)


def any_power(x, y):
    """Return x^y for any x and y; 0, infinity, NaN and x < 0 have the results that pow() in C prescribes."""
    if y == 0.0 or x == 1.0:
        return 1.0
    if math.isnan(x) or math.isnan(y):
        return math.nan
    is_whole = abs(y) >= ALL_EVEN or math.floor(y) == y
    magnitude = abs(x)
    if x < 0.0 and magnitude < math.inf and not is_whole:
        return math.nan
    is_odd = is_whole and abs(y) < ALL_EVEN and math.floor(0.5 * y) != 0.5 * y
    return math.copysign(power_of_magnitude(magnitude, y), x) if is_odd else power_of_magnitude(magnitude, y)


def power_of_magnitude(x, y):
    """Return x^y for x ≥ 0 and y ≠ 0, of which none is NaN; ``any_power`` adds the sign for a base < 0."""
    if x == 1.0:
        return 1.0
    if x == 0.0 or math.isinf(x) or abs(y) >= HUGE_EXPONENT:
        return math.inf if (x > 1.0) == (y > 0.0) else 0.0
    high, low = log_parts_of_any(x)
    high, low = product_in_two_doubles(y, high, low)
    return exp_of_sum(high, low)

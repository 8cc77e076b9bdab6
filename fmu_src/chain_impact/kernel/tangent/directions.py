"""Dual numbers, as far as the kernel knows them: a value with its derivatives in several directions.

An instance whose reals are dual numbers, of the same layout otherwise, is called t where d is the instance
itself. The kernel's functions work on either. Compiled, dual numbers are those of
compilation/dual_numbers.py.
"""

import numpy as np

DIRECTIONS = 4  # that one instance of dual numbers carries; more take several instances


def dual_dtype(dtype):
    """The layout of an instance, or of a part of it, with a dual number for each real."""
    if dtype.subdtype:
        item, shape = dtype.subdtype
        return np.dtype((dual_dtype(item), shape))
    if dtype.names:
        return np.dtype([(name, dual_dtype(dtype[name])) for name in dtype.names])
    if dtype == np.float64:
        return np.dtype([("value", np.float64), ("slope", np.float64, (DIRECTIONS,))])
    return dtype


def value(number):
    """The value of a dual number."""
    return number.value


def carried(number, slope, argument):
    """A value with the derivatives of a dual number times a slope."""
    return argument.carried(number, slope)


def varies(number):
    """Whether a dual number has any derivative that is not zero."""
    return number.varies()

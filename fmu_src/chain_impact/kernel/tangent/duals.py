"""Dual numbers, as the kernel uses them: a value with its derivatives in several directions.

The primal instance is called d. The tangent instance t has the same layout, but its reals are dual numbers.
The kernel's functions work on both. The compiled kernel uses the dual numbers of compilation/dual_numbers.py.

Instances of dual numbers stand after an instance in memory; together they have all requested directions. The
compiled versions of these functions are in compilation/record_type.py.
"""

import numpy as np

from chain_impact.kernel.record.fields import GIVEN

LEAST_RATE = 1e-300  # [1/s] the least rate that has a reciprocal: 1 over a smaller one may overflow
DIRECTIONS = 4  # number of directions of one instance of dual numbers; more directions need several instances


def dual_dtype(dtype):
    """Return the layout of an instance, or of a part of one, with a dual number for each real."""
    if dtype.subdtype:
        item, shape = dtype.subdtype
        return np.dtype((dual_dtype(item), shape))
    if dtype.names:
        return np.dtype([(name, dual_dtype(dtype[name])) for name in dtype.names])
    if dtype == np.float64:
        return np.dtype([("value", np.float64), ("slope", np.float64, (DIRECTIONS,))])
    return dtype


# the time up to which the derivatives can be trusted, see kernel/tangent/trust.py
TRUST = np.dtype(
    [
        ("reason", np.int64),  # 0: trusted everywhere so far
        ("time", np.float64),  # s, time after which the derivatives cannot be trusted
        ("point", np.int64),  # point of the impact or of the dry friction, or the joint; −1 without one
        ("wall", np.int64),  # −1: a joint
        # the possible change by friction that was left open, over the largest derivative, see friction.py
        ("share", np.float64),
        (
            "split",
            np.int64,
        ),  # 1: friction has left something open: the derivatives of its impulses are unknown
    ]
)


def tangent_dtype(instance):
    """Return the layout of an instance of dual numbers for a primal instance of the layout ``instance``."""
    dual = dual_dtype(instance)
    return np.dtype([*((name, dual[name]) for name in dual.names), ("trust", TRUST)])


def value(number):
    """Return the value of a dual number."""
    return number.value


def carried(number, slope, argument):
    """Return a dual number with the value ``number`` and the derivatives of ``argument`` times a slope."""
    return argument.carried(number, slope)


def reciprocal(rate):
    """Return 1/rate of a rate without derivatives, and 0 where this overflows.

    If a rate is 0, the time at which a value passes zero has no derivatives.
    """
    return 1.0 / rate if abs(rate) > LEAST_RATE else 0.0


def slope(number, direction):
    """Return the derivative of a dual number in a direction, from 0."""
    return number.slope[direction]


def sloped(number, direction, slope):
    """Return a dual number with another derivative in one direction."""
    return number.sloped(direction, slope)


def varies(number):
    """Return whether a dual number has any derivative that is not zero."""
    return number.varies()


def block(d, number):
    """Return tangent instance ``number`` of d, from 0."""
    return d.tangent_instances[number]


def words(record):
    """Return all numbers of a record, each followed by its derivatives."""
    return record.words


def copy_values(source, target):
    """Give a part of an instance of dual numbers the values of the same part of the instance.

    Derivatives stay unchanged. All fields are copied, including those of nested records, so a parameter that
    is added to the record needs no change here.
    """
    target.copy_values(source)


def copy_given(d, t, when):
    """Give t the values of all parts of d that the scene or an importer gives and that apply at ``when``.

    ``when`` is a constant: AT_START or AT_ANY_TIME, as declared at the layout of each part.
    """
    for part, applies in GIVEN.items():
        if applies == when:
            copy_values(getattr(d, part), getattr(t, part))

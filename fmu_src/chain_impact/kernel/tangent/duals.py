"""Dual numbers as the kernel uses them: a value and the derivatives of this value in several directions.

The primal instance d is the record of the run. The tangent instance t has the same layout, but with dual
numbers in place of reals. The kernel's functions accept both instances. The compiled kernel uses the dual
numbers of compilation/dual_numbers.py.

A direction is a parameter or input with respect to which derivatives are computed. The tangent instances
follow the primal instance in memory; each has DIRECTIONS directions. The functions of this module that take
instances have their compiled versions in compilation/built_in.py.
"""

import numpy as np

from chain_impact.kernel.record.fields import SETTABLE

# largest absolute value of a rate for which ``reciprocal`` returns 0, because 1/rate may overflow
LEAST_RATE = 1e-300
DIRECTIONS = 4  # number of directions in one tangent instance; more directions need more instances


def dual_dtype(dtype):
    """Return the layout ``dtype`` of an instance, or of a part of it, with a dual number for each real."""
    if dtype.subdtype:
        item, shape = dtype.subdtype
        return np.dtype((dual_dtype(item), shape))
    if dtype.names:
        return np.dtype([(name, dual_dtype(dtype[name])) for name in dtype.names])
    if dtype == np.float64:
        return np.dtype([("value", np.float64), ("slope", np.float64, (DIRECTIONS,))])
    return dtype


# layout of the part ``trust``: the time up to which the derivatives can be trusted, and why they end at this
# time (kernel/tangent/trust.py)
TRUST = np.dtype(
    [
        # 0: the derivatives have not ended; else the number, in trust.py, of the reason why they have ended
        ("reason", np.int64),
        ("time", np.float64),  # s, if ``reason`` is not 0: time from which on derivatives are not trusted
        # number of the point or joint whose impact or dry friction ends the derivatives; 0 for the base and
        # for the slider; −1: no such point
        ("point", np.int64),
        # index of the wall, as in `candidate.wall`; −1: dry friction in a joint or of the slider; without
        # meaning if ``point`` is −1
        ("wall", np.int64),
        # a sum over the changes of positions whose derivatives are neglected: changes by a speed that
        # friction stops soon. Each change adds its share (``is_negligible`` in tangent/friction.py)
        ("neglected", np.float64),
        # 1: the derivatives of friction impulses are not known (``mark_split``)
        ("split", np.int64),
        # 1: the motion has no derivative in this direction (rises.py, and ``check_coefficient`` in trust.py)
        ("missing", np.int64, (DIRECTIONS,)),
        # size of the parameter or input of this direction, in its unit: its absolute value in the scene, or 1
        # if this is 0 or infinite, and in a direction that is not used
        ("size", np.float64, (DIRECTIONS,)),
    ]
)


def tangent_dtype(instance):
    """Return the layout of a tangent instance, for a primal instance of the layout ``instance``.

    A tangent instance has a dual number for each real, and after all other parts the part ``trust``.
    """
    dual = dual_dtype(instance)
    return np.dtype([*((name, dual[name]) for name in dual.names), ("trust", TRUST)])


def value(number):
    """Return the value of a dual number, without its derivatives."""
    return number.value


def dual_with_slope(number, slope, argument):
    """Return a dual number of the value ``number`` with the derivatives of ``argument`` times ``slope``."""
    return argument.dual_with_slope(number, slope)


def reciprocal(rate):
    """Return 1/rate for a real number, or 0 if the absolute value of the rate is at most LEAST_RATE.

    With the result 0, an event time with the derivatives −φ′/φ̇ gets derivatives of zero.
    """
    return 1.0 / rate if abs(rate) > LEAST_RATE else 0.0


def slope(number, direction):
    """Return the derivative of a dual number in one direction; the directions are counted from 0."""
    return number.slope[direction]


def replace_slope(number, direction, slope):
    """Return a copy of a dual number in which the derivative in one direction is ``slope``."""
    return number.replace_slope(direction, slope)


def has_slope(number):
    """Return whether any derivative of a dual number is not zero."""
    return number.has_slope()


def tangent_instance(d, number):
    """Return tangent instance ``number``, counted from 0, of the primal instance d."""
    return d.tangent_instances[number]


def as_words(part):
    """Return a view of an instance, or of a part of an instance, as one array of words of 8 bytes.

    A change of a word changes the instance. A dual number is DIRECTIONS + 1 words: first the value, then the
    derivatives.
    """
    return part.words


def copy_values(source, target):
    """Copy the values of ``source``, a part of the primal instance, to ``target``.

    ``target`` is the same part of a tangent instance; the derivatives there do not change. All fields are
    copied, also those of nested records.
    """
    target.copy_values(source)


def copy_given(d, t, when):
    """Copy from d to t the values of all parts that a scene or importer gives and that apply at ``when``.

    ``when`` is AT_START or AT_ANY_TIME, as ``settable`` declares it for each part (record/fields.py).
    Derivatives in t do not change.
    """
    for part, applies in SETTABLE.items():
        if applies == when:
            copy_values(getattr(d, part), getattr(t, part))

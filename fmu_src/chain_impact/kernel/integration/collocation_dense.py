"""The dense output of an implicit step: its collocation polynomial of degree 5, with an error of h⁶.

The first five functions of dense.py span the polynomials of degree 5 that are 0 at the start of the step. The
last two vanish at both ends, and make the coordinates match the integrated clearances in between.
"""

from fractions import Fraction

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.state import dissipated_at, sundman_u_at, velocity_at
from chain_impact.kernel.integration.dense import POWERS, interpolate
from chain_impact.kernel.integration.extended import (
    compliant,
    extended_size,
    friction_impulse_at,
    gap_at,
    impulse_at,
    rate_at,
)
from chain_impact.kernel.integration.impulse import friction_count, impulse_count
from chain_impact.kernel.integration.projection import project_coordinates
from chain_impact.kernel.integration.radau import NODES, STAGES

WITH_START = (0.0, *NODES)


def _coefficients():
    """For each function of the dense output, its coefficient from the increments of the stages.

    The functions at the nodes are inverted in rational numbers and rounded once. The last digits of NumPy's
    inverse depend on the processor, and with them the compiled kernel would, too.
    """
    nodes = [Fraction(node) for node in NODES]
    rows = [[t**p * (1 - t) ** q for p, q in POWERS[:STAGES]] for t in nodes]
    for k, row in enumerate(rows):
        row += [Fraction(int(i == k)) for i in range(STAGES)]
    for k in range(STAGES):
        rows[k] = [value / rows[k][k] for value in rows[k]]
        for i in range(STAGES):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return tuple(tuple(float(value) for value in row[STAGES:]) for row in rows)


# row m: the coefficient of the m-th function, from the increments of the stages
SHAPE = _coefficients()
CURVE_BOUND = (0.0, 2.0, 4.0, 2.0, 2.0)  # the largest second derivatives of these functions on [0, 1]


def lagrange(first, m, x):
    """The m-th Lagrange polynomial through the start of a step and its nodes, from the ``first`` on, at x."""
    value = 1.0
    for k in range(first, STAGES + 1):
        if k != m:
            value *= (x - WITH_START[k]) / (WITH_START[m] - WITH_START[k])
    return value


def coefficient(stages, m, j):
    """The coefficient of the m-th function of the dense output, for component j of z."""
    total = 0.0
    for i in range(STAGES):
        total += SHAPE[m][i] * stages[i, j]
    return total


def finish(d, h):
    """Store the stages of the step that was tried, to predict the next ones, and the state's dense output."""
    own, dense = d.implicit, d.step.dense
    for i in range(STAGES):
        for j in range(extended_size(d)):
            own.last[i, j] = own.stages[i, j]
    own.began, own.span, own.listing = d.step.start, h, d.touch.listings
    for j in range(len(d.work.y)):
        dense[0, j] = d.step.state_end[j] - d.step.state[j]
        for m in range(1, len(dense)):
            dense[m, j] = 0.0
    for m in range(1, STAGES):
        for j in range(sundman_u_at(d.links)):
            dense[m, j] = coefficient(own.last, m, j)
    for k in range(impulse_count(d)):
        keep_impulse(d, d.impulse, k, impulse_at(d, k))
    for k in range(friction_count(d)):
        keep_impulse(d, d.friction_impulse, k, friction_impulse_at(d, k))


def keep_impulse(d, own, k, at):
    """Store the dense output of the k-th integral in a part of the record, which is component ``at`` of z."""
    own.dense[0, k] = own.state_end[k] - own.state[k]
    for m in range(1, len(own.dense)):
        own.dense[m, k] = coefficient(d.implicit.last, m, at) if m < STAGES else 0.0


def keep_clearances(d, _h):
    """Make the dense output match the integrated clearances also at the thirds of the last step."""
    dense, own, change = d.step.dense, d.implicit, d.work.change
    if compliant(d) == 0:
        return
    for third in range(1, 3):
        interpolate(d.step, third / 3.0, d.work.y)
        locate_points(d, d.work.y)
        for derivative in range(2):
            for k in range(compliant(d)):
                at = rate_at(d, k) if derivative else gap_at(d, k)
                own.normal[k] = interpolated(d, at, third / 3.0)
            project_coordinates(d, d.work.y, derivative, change)
            for j in range(len(change)):
                own.thirds[third - 1, derivative * velocity_at(d.links) + j] = change[j]
    for j in range(dissipated_at(d.links)):
        one, two = own.thirds[0, j], own.thirds[1, j]
        # 8/729 F₅ + 8/2187 F₆ and 8/729 F₅ + 16/2187 F₆ shall equal the changes at the thirds
        dense[6, j] = 2187.0 / 8.0 * (two - one)
        dense[5, j] = 729.0 / 8.0 * one - dense[6, j] / 3.0


def interpolated(d, j, theta):
    """Component j of z at the fraction θ of the last step."""
    total = d.implicit.start[j]
    for m in range(1, STAGES + 1):
        total += lagrange(0, m, theta) * d.implicit.last[m - 1, j]
    return total


def bound_curvatures(d, h):
    """Bound |g̈| [m/s²] of the active contacts over the last step, from their clearance polynomials."""
    for k in range(compliant(d)):
        bound = 0.0
        for m in range(STAGES):
            bound += CURVE_BOUND[m] * abs(coefficient(d.implicit.last, m, gap_at(d, k)))
        d.search.curvature[d.touch.active_index[k]] = bound / (h * h)

"""The implicit step of order 9 for sustained contact and stiff joints: Radau IIA.

The step finds the polynomial of degree 5 that starts at z_0 and satisfies ż = f(z) at five nodes. The end of
this polynomial is the result of the step. The extended state z, its rate f and the linear systems are in
extended_state.py; the coefficients, and the iteration for the values at the nodes, are in radau.py.

Two estimates of the error compare rates with polynomials through the rates F_1 to F_5 at the five nodes,

    E = (1 − h μ A)⁻¹ h μ (f(z_0) − P(0)),   E′ = (1 − h μ A)⁻¹ h μ (F_5 − P′(1)),

where P goes through all five rates, and P′ through F_1 to F_4; here ′ does not mean a derivative. h is the
step size, A the Jacobian, and μ the real eigenvalue of radau.py. The order of E′ is one less than the order
of E. The quotient |E|²/|E′| is of order 7, closer to the order of the result.

The dense output is the polynomial of degree 5, with an error of order h⁶. The first five basis functions of
dense_output.py span all such polynomials that are 0 at the start of the step. The other two are 0 at both
ends of the step; they move coordinates and rates within the step toward the integrated clearances and their
rates.
"""

import math
from fractions import Fraction

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.impulses import any_constraint
from chain_impact.kernel.cost import count_evaluations, count_other_cost
from chain_impact.kernel.equations import clear_stage_notes
from chain_impact.kernel.mathematics.powers import power
from chain_impact.kernel.ode.dense_output import BASIS_POWERS, interpolate_state
from chain_impact.kernel.ode.extended_state import (
    clearance_at,
    clearance_count,
    extend_start,
    extended_length,
    extended_rate,
    extended_slopes,
    factorize_complex,
    factorize_real,
    project_clearances,
    project_coordinates,
    quadrature_at,
    rate_at,
    solve_complex,
    solve_real,
)
from chain_impact.kernel.ode.friction_work import correct_friction_energy, store_friction_forces, work_along
from chain_impact.kernel.ode.quadratures import copy_tried_quadratures
from chain_impact.kernel.ode.radau import (
    END_WEIGHTS,
    MOST_ITERATIONS,
    RADAU_NODES,
    REAL_EIGENVALUE,
    START_WEIGHTS,
    lagrange_polynomial,
    shift_of,
    simplified_newton,
)
from chain_impact.kernel.ode.step_control import (
    END_OVERSHOOT,
    ERROR_ORDER,
    clear_faded,
    reject_step,
    set_outcome,
)
from chain_impact.kernel.ode.step_errors import force_errors, largest_errors, raise_scales, set_scales
from chain_impact.kernel.record.constants import (
    DIVERGED,
    IMPLICIT,
    INFINITE,
    NEWTON_SLOW,
    PAIR_COUNT,
    RADAU_STAGES,
)
from chain_impact.kernel.record.method import was_implicit
from chain_impact.kernel.record.state import dissipated_at, sundman_u_at, supplied_at, time_at, velocity_at

LAST_STAGE = RADAU_STAGES - 1
SLOW_CONVERGENCE = 0.2  # above this ratio of a Newton correction to the one before, shorter steps cost less
# Stages are predicted with degree 5, 4 or 3 if the new step ends at most 1.2, 2 or 3 sizes of the last step
# after the last step's end, else with degree 1. Size and end are those that the last step had before a cut.
EXTRAPOLATED_LENGTHS = (1.2, 2.0, 3.0)
# The cost of a step without its evaluations, in evaluations: all factorizations; all solutions in an
# iteration; error estimate and projection onto the clearances. A real factorization costs 1 and a real
# solution 0.7, complex ones 2.5 times as much; estimate and projection take four real solutions.
FACTORIZATION_COST, SOLUTION_COST, ESTIMATE_COST = 6, 4, 3
FORCELESS_PART = 1e-3  # a contact that ends in this first part of a step has hardly any force left
DECAY_TIMES = 3.0  # size of a step, in decay times of its fast motion, if this motion equals the tolerance


def _coefficients():
    """Return the matrix from the stages' increments to the coefficients of the first five basis functions.

    The matrix is computed in rational numbers: the last digits of NumPy's inverse depend on the processor.
    """
    nodes = [Fraction(node) for node in RADAU_NODES]
    rows = [[t**p * (1 - t) ** q for p, q in BASIS_POWERS[:RADAU_STAGES]] for t in nodes]
    for k, row in enumerate(rows):
        row += [Fraction(int(i == k)) for i in range(RADAU_STAGES)]
    for k in range(RADAU_STAGES):
        rows[k] = [value / rows[k][k] for value in rows[k]]
        for i in range(RADAU_STAGES):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return tuple(tuple(float(value) for value in row[RADAU_STAGES:]) for row in rows)


# row m times the increments of the stages is the coefficient of the m-th basis function of the dense output
INTERPOLANT_MATRIX = _coefficients()
# the largest |second derivative| of each of the first five basis functions on [0, 1]
CURVATURE_BOUND = (0.0, 2.0, 4.0, 2.0, 2.0)


def factorize_systems(d, h):
    """Factorize the linear systems of an implicit step of size h [s]."""
    factorize_real(d, h * REAL_EIGENVALUE)
    for pair in range(PAIR_COUNT):
        factorize_complex(d, shift_of(pair, h), pair)


def solve_systems(d, h, component_count):
    """Replace ``implicit.right_hand_sides``, of z's length, by the solutions for step size h."""
    rows = d.implicit.right_hand_sides
    solve_real(d, h * REAL_EIGENVALUE, rows[0])
    for pair in range(PAIR_COUNT):
        solve_complex(d, shift_of(pair, h), pair, rows[1 + 2 * pair], rows[2 + 2 * pair], component_count)


def set_residual(d, i, j, residual):
    """Set component j of row i of ``implicit.right_hand_sides`` to the number ``residual``."""
    d.implicit.right_hand_sides[i, j] = residual


def can_extrapolate(d):
    """Return whether the last step was implicit and had the present contacts: then it can predict stages."""
    return d.implicit.contact_set_of_step == d.contacts.contact_set and was_implicit(d)


def set_jacobian(d, z):
    """Evaluate the Jacobian A at z, the predicted state at the middle node, if ``can_extrapolate`` is true.

    Otherwise z is inaccurate, and A stays as ``prepare_step`` has evaluated it, at the start of the step.
    """
    if can_extrapolate(d):
        extended_slopes(d, z)


find_residuals, correct_stages, _converge = simplified_newton(
    clear_stage_notes, extended_rate, store_friction_forces, set_jacobian, factorize_systems, solve_systems
)


def prepare_step(d, h):
    """Prepare a step; return the size [s]: h, or less if a contact ends soon or a motion is fast."""
    extend_start(d)
    extended_slopes(d, d.implicit.z_start)
    set_weights(d)
    h = size_toward_end(d, h)
    return h if can_extrapolate(d) else size_for_fast_motion(d, h)


def set_weights(d):
    """Set the weights of errors in z: 1/(tolerance × scale), or 0 for components that are not controlled."""
    weight = d.implicit.error_weight
    for j in range(supplied_at(d.link_count), extended_length(d)):
        weight[j] = math.inf
    set_scales(d, d.step.state_end, weight, clearance_count(d))
    raise_scales(d, d.step.state_end, weight, clearance_count(d))
    for j in range(extended_length(d)):
        weight[j] = 1.0 / (d.solver.tolerance * weight[j])


def size_toward_end(d, h):
    """Return h [s] or, if less, END_OVERSHOOT × the predicted time to the next end of a contact in z."""
    for k in range(clearance_count(d)):
        clearance, rate = d.implicit.z_start[clearance_at(d, k)], d.implicit.z_start[rate_at(d, k)]
        # near its end a contact has hardly any force, so the rate ġ of its clearance g hardly changes, and
        # the end is about −g/ġ away; an end within FORCELESS_PART h is ignored: hardly any force is left
        # before it
        if rate > 0.0 and FORCELESS_PART * h * rate < -clearance < h * rate / END_OVERSHOOT:
            h = END_OVERSHOOT * -clearance / rate
    return h


def size_for_fast_motion(d, h):
    """Return h [s] or, if a fast motion at the start exceeds the tolerance, a smaller size that resolves it.

    The operator (1 − h μ A)⁻¹ removes the fast part of the rate. The removed part shows how large the fast
    motion is. Applied to this part, the operator shows how fast the motion decays.
    """
    implicit, shift, component_count = d.implicit, h * REAL_EIGENVALUE, extended_length(d)
    factorize_real(d, shift)
    fast_part, decayed_part = implicit.right_hand_sides[0], implicit.right_hand_sides[1]
    for j in range(component_count):
        fast_part[j] = implicit.rate_start[j]
    solve_real(d, shift, fast_part)
    for j in range(component_count):
        fast_part[j] = implicit.rate_start[j] - fast_part[j]
        decayed_part[j] = fast_part[j]
    solve_real(d, shift, decayed_part)
    count_other_cost(d, 3)
    fast_error, decayed_error = 0.0, 0.0
    for j in range(velocity_at(d.link_count), dissipated_at(d.link_count)):
        fast_error = max(fast_error, abs(fast_part[j]) * implicit.error_weight[j])
        decayed_error = max(decayed_error, abs(decayed_part[j]) * implicit.error_weight[j])
    if not (math.isfinite(fast_error) and fast_error > decayed_error > 0.0):
        return h
    # the operator leaves the part 1/(1 + ρ h μ) of a motion that decays with the rate ρ; h μ is ``shift``
    rho = (fast_error / decayed_error - 1.0) / shift
    if rho * h > 1.0 and fast_error > rho:
        return min(h, DECAY_TIMES / rho * power(rho / fast_error, 1.0 / (ERROR_ORDER[IMPLICIT] - 1)))
    return h


def extrapolate_stages(d, h, component_count):
    """Predict the stages of a step h [s] by the last step's polynomial if possible, or by constant speeds."""
    implicit = d.implicit
    if can_extrapolate(d):
        extrapolate_polynomial(d, h, component_count)
        return
    for i in range(RADAU_STAGES):
        part = h * RADAU_NODES[i]
        for j in range(component_count):
            implicit.stages[i, j] = 0.0
        for j in range(velocity_at(d.link_count)):
            implicit.stages[i, j] = part * implicit.rate_start[j]
        for k in range(clearance_count(d)):
            implicit.stages[i, clearance_at(d, k)] = part * implicit.rate_start[clearance_at(d, k)]


def extrapolate_polynomial(d, h, component_count):
    """Predict the stages by a polynomial through nodes of the last step; h [s] determines the degree."""
    implicit = d.implicit
    last_size, start = d.step.size, (d.step.end - d.step.start) / d.step.size
    length, first_node = start + h / last_size - 1.0, 0
    while first_node < len(EXTRAPOLATED_LENGTHS) and length > EXTRAPOLATED_LENGTHS[first_node]:
        first_node += 1
    first_node = RADAU_STAGES - 1 if first_node == len(EXTRAPOLATED_LENGTHS) else first_node
    for i in range(RADAU_STAGES):
        for j in range(component_count):
            implicit.stages[i, j] = 0.0
    for m in range(max(1, first_node), RADAU_STAGES + 1):
        start_weight = lagrange_polynomial(first_node, m, start)
        for i in range(RADAU_STAGES):
            weight = lagrange_polynomial(first_node, m, start + h * RADAU_NODES[i] / last_size) - start_weight
            for j in range(component_count):
                implicit.stages[i, j] += weight * implicit.last_stages[m - 1, j]


def integrate_trial(d, h):
    """Try a step of size h [s] from the start of ``prepare_step``; store the result in ``trial``."""
    implicit, component_count = d.implicit, extended_length(d)
    extrapolate_stages(d, h, component_count)
    converged = _converge(d, h, component_count)
    count_evaluations(d, RADAU_STAGES * implicit.iterations)
    count_other_cost(d, FACTORIZATION_COST + SOLUTION_COST * implicit.iterations + ESTIMATE_COST)
    if converged:
        if d.friction.active_count > 0:
            correct_friction_energy(d, h)
        set_step_end(d, h)
        error = error_estimate(d, h, component_count)
        if clearance_count(d) > 0:
            change, mismatch = project_clearances(d, implicit.z_scratch, d.trial.state)
            error = max(error, change, mismatch)
        set_outcome(d, error, cost_factor(implicit))
    elif not math.isfinite(implicit.relative_correction):
        reject_step(d, INFINITE)
    else:
        reject_step(d, DIVERGED if implicit.convergence_rate > 1.0 else NEWTON_SLOW)


def cost_factor(implicit):
    """Return a factor < 1 on the next size, which is smaller after more or slower Newton iterations."""
    factor = (2.0 * MOST_ITERATIONS + 1.0) / (2.0 * MOST_ITERATIONS + implicit.iterations)
    if implicit.convergence_rate > SLOW_CONVERGENCE:
        factor = min(factor, math.sqrt(max(0.5, SLOW_CONVERGENCE / implicit.convergence_rate)))
    return factor


def set_step_end(d, h):
    """Set the extended state z and the state y at the end of a step of size h; locate the points there."""
    implicit, y = d.implicit, d.trial.state
    for j in range(extended_length(d)):
        implicit.z_scratch[j] = implicit.z_start[j] + implicit.stages[LAST_STAGE, j]
    for j in range(sundman_u_at(d.link_count)):
        y[j] = implicit.z_scratch[j]
    y[sundman_u_at(d.link_count)], y[time_at(d.link_count)] = 1.0, h
    copy_tried_quadratures(d, implicit.z_scratch, quadrature_at(d, 0))
    locate_points(d, y)


def error_estimate(d, h, component_count):
    """Return the error of the components of z in a step h [s], over the tolerance; ∞ if not finite."""
    implicit, rows, shift = d.implicit, d.implicit.right_hand_sides, h * REAL_EIGENVALUE
    for j in range(component_count):
        start, end = implicit.rate_start[j], implicit.rates[LAST_STAGE, j]
        for i in range(RADAU_STAGES):
            start -= START_WEIGHTS[i] * implicit.rates[i, j]
        for i in range(LAST_STAGE):
            end -= END_WEIGHTS[i] * implicit.rates[i, j]
        rows[0, j], rows[1, j] = shift * start, shift * end
    solve_real(d, shift, rows[0])
    solve_real(d, shift, rows[1])
    first, second = largest_errors(rows[0], rows[1], implicit.error_weight, component_count)
    if first == math.inf:
        return math.inf
    if any_constraint(d):
        # A projection onto the constraints leaves a fast motion of stiff joints at the start of the step.
        # This motion decays within the step, but would dominate the error estimate of a step of any length. A
        # second solution of the system removes this motion from the estimate.
        solve_real(d, shift, rows[0])
        count_other_cost(d, 1)
        for j in range(dissipated_at(d.link_count)):
            d.scratch.y_error[0, j], d.scratch.y_error[1, j] = rows[0, j], rows[1, j]
        first_force, second_force = force_errors(d)
        first = max(first, first_force / d.solver.tolerance)
        second = max(second, second_force / d.solver.tolerance)
    return first * min(1.0, first / second) if second > 0.0 else first


def dense_coefficient(stages, m, j):
    """Return the coefficient of the m-th basis function of the dense output for component j of ``stages``."""
    total = 0.0
    for i in range(RADAU_STAGES):
        total += INTERPOLANT_MATRIX[m][i] * stages[i, j]
    return total


def store_stages(d, faded):
    """Store the stages, if ``faded`` with tiny coordinates set to 0, and set the dense output from them."""
    implicit = d.implicit
    for i in range(RADAU_STAGES):
        for j in range(extended_length(d)):
            implicit.last_stages[i, j] = implicit.stages[i, j]
        if faded:
            clear_faded(d, implicit.last_stages[i])
    implicit.contact_set_of_step = d.contacts.contact_set
    for j in range(len(d.scratch.state)):
        set_dense(d.step, j, implicit.last_stages, j, RADAU_STAGES if j < sundman_u_at(d.link_count) else 1)
    for k in range(d.quadrature.count):
        set_dense(d.quadrature, k, implicit.last_stages, quadrature_at(d, k), RADAU_STAGES)


def set_dense(values, j, stages, component, degree):
    """Set the dense output of entry j, a ``component`` of z; coefficients F_m with m ≥ ``degree`` are 0."""
    values.dense[0, j] = values.state_end[j] - values.state[j]
    for m in range(1, len(values.dense)):
        values.dense[m, j] = dense_coefficient(stages, m, component) if m < degree else 0.0


def match_clearances(d):
    """Move the dense output toward the integrated clearances and rates at one and two thirds of the step.

    ``project_coordinates`` gives the changes; dry friction along these changes adds to the dissipated energy.
    """
    dense, implicit, change = d.step.dense, d.implicit, d.scratch.change
    last_component = dissipated_at(d.link_count)
    if clearance_count(d) == 0:
        return
    for third in range(1, 3):
        interpolate_state(d.step, third / 3.0, d.scratch.state)
        locate_points(d, d.scratch.state)
        for derivative in range(2):
            for k in range(clearance_count(d)):
                component = rate_at(d, k) if derivative else clearance_at(d, k)
                implicit.target_clearance[k] = extended_component(d, component, third / 3.0)
            project_coordinates(d, d.scratch.state, derivative, change)
            for j in range(len(change)):
                implicit.dense_corrections[third - 1, derivative * velocity_at(d.link_count) + j] = change[j]
            if derivative == 0:
                implicit.dense_corrections[third - 1, last_component] = (
                    -work_along(d, change) if d.friction.active_count > 0 else 0.0
                )
    for j in range(last_component + 1):
        change_at_one, change_at_two = implicit.dense_corrections[0, j], implicit.dense_corrections[1, j]
        # the coefficients F₅ and F₆ change the dense output by 8/729 F₅ + 8/2187 F₆ at one third of the step,
        # and by 8/729 F₅ + 16/2187 F₆ at two thirds
        dense[6, j] = 2187.0 / 8.0 * (change_at_two - change_at_one)
        dense[5, j] = 729.0 / 8.0 * change_at_one - dense[6, j] / 3.0


def extended_component(d, j, theta):
    """Return component j of the extended state z at the fraction θ of the last step."""
    total = d.implicit.z_start[j]
    for m in range(1, RADAU_STAGES + 1):
        total += lagrange_polynomial(0, m, theta) * d.implicit.last_stages[m - 1, j]
    return total


def bound_curvatures(d, h):
    """Set bounds on |g̈| [m/s²] in the last step for integrated clearances g of contacts with a force law."""
    for k in range(clearance_count(d)):
        bound = 0.0
        for m in range(RADAU_STAGES):
            coefficient = dense_coefficient(d.implicit.last_stages, m, clearance_at(d, k))
            bound += CURVATURE_BOUND[m] * abs(coefficient)
        d.search.curvature[d.contacts.active_index[k]] = bound / (h * h)

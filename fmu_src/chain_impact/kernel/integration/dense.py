"""The last accepted step and its dense output: y₀ + θ(F₀ + (1−θ)(F₁ + θ(F₂ + … + θ F₆))), 0 ≤ θ ≤ 1."""

import numpy as np

from chain_impact.kernel.chain.state import sundman_u_at, time_at

POWERS = ((1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 3))  # p, q of θᵖ (1−θ)^q, with F₀ to F₆
DENSE_COEFFICIENTS = len(POWERS)
# Guesses of a fast method for a root between two bounds, three to ten as a rule. Then the bracket is halved.
FAST = 20
# Guesses after which no number is left within a bracket of width 1, or it is narrower than any resolution.
TRIES = FAST + 64
RESOLUTION = 1e-15  # of a step: the accuracy of the fraction θ that belongs to a time


def next_guess(low, high, guess, tries):
    """The guess of a fast method, or the middle of the bracket if it lies outside or after FAST ``tries``."""
    if tries < FAST and low < guess < high:
        return guess
    return 0.5 * (low + high)


def time_rate(u):
    """The rate p = dt/ds of time in a regularized step (sundman.py)."""
    return u / (1.0 + u * u)


def interpolate(step, theta, y):
    """Set y to the state at the fraction θ ∈ [0, 1] of the last step."""
    for j in range(len(step.state)):
        y[j] = interpolate_component(step, theta, j)


def interpolate_component(step, theta, j):
    """Component j of the state at the fraction θ ∈ [0, 1] of the last step."""
    rest = 1.0 - theta
    high = step.dense[4, j] + rest * (step.dense[5, j] + theta * step.dense[6, j])
    low = step.dense[2, j] + rest * (step.dense[3, j] + theta * high)
    return step.state[j] + theta * (step.dense[0, j] + rest * (step.dense[1, j] + theta * low))


def fraction(d, time):
    """The fraction θ of the last step that belongs to a time [s]."""
    elapsed = time - d.step.start
    if d.step.regularized < 0:
        return elapsed / d.step.size
    return regularized_fraction(d, elapsed)


def regularized_fraction(d, elapsed):
    """The fraction θ of the last step, a regularized one, at which the time ``elapsed`` [s] has passed."""
    step, root, clock = d.step, sundman_u_at(d.links), time_at(d.links)
    at_end = step.state[root] + step.dense[0, root]
    if elapsed >= step.dense[0, clock] and at_end >= 0.0:
        return 1.0
    # t increases with θ as long as u ≥ 0, and dt/dθ = h p: Newton's method inside a bracket
    low, high, theta = 0.0, 1.0, 0.5
    for tries in range(TRIES):
        error = interpolate_component(step, theta, clock) - elapsed
        if error == 0.0:
            break
        u = interpolate_component(step, theta, root)
        if error > 0.0 or u < 0.0:
            high = theta
        else:
            low = theta
        slope = step.size * time_rate(u)
        guess = next_guess(low, high, theta - error / slope if slope > 0.0 else high, tries)
        if abs(guess - theta) <= RESOLUTION:
            break
        theta = guess
    return theta


def _basis_bounds():
    """Largest size on [0, 1] of the interpolant's basis functions and of their slopes."""
    theta = np.linspace(0.0, 1.0, 10001)
    rest = 1.0 - theta
    values = [theta**p * rest**q for p, q in POWERS]
    slopes = [p * theta ** (p - 1) * rest**q - q * theta**p * rest ** max(q - 1, 0) for p, q in POWERS]
    return (
        tuple(float(np.abs(v).max()) for v in values),
        tuple(float(np.abs(s).max()) for s in slopes),
    )


BASIS_BOUND, SLOPE_BOUND = _basis_bounds()


def rate_bounds(step, j):
    """Bounds on |y_j| and |ẏ_j| over the last step, from the interpolant's coefficients."""
    value, slope = abs(step.state[j]), 0.0
    for m in range(DENSE_COEFFICIENTS):
        f = abs(step.dense[m, j])
        value += BASIS_BOUND[m] * f
        slope += SLOPE_BOUND[m] * f
    return value, slope / step.size


def rate_bounds_along(step, j, nx, ny):
    """As ``rate_bounds``, for the component along (nx, ny) of the vector that begins at y_j."""
    value, slope = abs(nx * step.state[j] + ny * step.state[j + 1]), 0.0
    for m in range(DENSE_COEFFICIENTS):
        f = abs(nx * step.dense[m, j] + ny * step.dense[m, j + 1])
        value += BASIS_BOUND[m] * f
        slope += SLOPE_BOUND[m] * f
    return value, slope / step.size

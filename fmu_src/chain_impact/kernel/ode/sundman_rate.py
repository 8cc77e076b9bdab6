"""The rate p = dt/ds of time in a regularized step, and the rate of p, as functions of u (sundman.py)."""


def regularized_time_rate(u):
    """Return p = dt/ds = u/(1 + u²), the rate of time in a regularized step (sundman.py)."""
    return u / (1.0 + u * u)


def regularized_time_rate_change(u, slope):
    """Return p′ = dp/ds = u′ (1 − u²)/(1 + u²)², the rate of p = dt/ds; ``slope`` is u′."""
    quotient = 1.0 / (1.0 + u * u)
    return slope * (1.0 - u * u) * quotient * quotient

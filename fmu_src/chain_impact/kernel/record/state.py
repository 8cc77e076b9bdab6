"""The state vector y, and functions for the indices of its entries.

    y = (x₀, θ₁ … θ_N, ẋ₀, ω₁ … ω_N, dissipated energy, supplied energy, u, t)

The first N + 2 entries are the coordinates: the position x₀ of the base, x and y [m], and the absolute angles
θ of the links [rad]. The next N + 2 entries are the rates of the coordinates [m/s, rad/s]. The energies [J]
count from the start of the run. The last two entries belong to the integration variable of a step
(ode/sundman.py). u = √(δ/δ*), with the penetration δ and the expected penetration δ* of the regularized
contact; without a regularized contact u is constant and has no meaning. t is the time since the start of the
step [s].
"""

from chain_impact.kernel.function_marks import inlined

# index of the first angle in y, and in a vector of changes of the coordinates; the base's x and y come before
FIRST_ANGLE = 2


def coordinate_count(n):
    """Return the number of coordinates of a chain of n links."""
    return n + 2


def velocity_at(n):
    """Return the index in y of the base's velocity, which is the first of the rates of all coordinates."""
    return n + 2


def omega_at(n):
    """Return the index in y of the angular velocity of link 1, for ``n`` links."""
    return n + 4


def dissipated_at(n):
    """Return the index in y of the dissipated energy, which follows all coordinates and their rates."""
    return 2 * n + 4


def supplied_at(n):
    """Return the index in y of the supplied energy: of inputs, powered drives and prescribed motions."""
    return 2 * n + 5


def sundman_u_at(n):
    """Return the index in y of u, the root of the regularized contact's penetration over the expected one."""
    return 2 * n + 6


def time_at(n):
    """Return the index in y of the time since the start of the step."""
    return 2 * n + 7


def state_length(n):
    """Return the length of the state vector y of a chain with n links."""
    return 2 * n + 8


@inlined
def relative_to_previous(values, first, i):
    """Return the angle of link i relative to link i − 1, or this angle's rate or change; i counts from 0.

    ``values`` has the angles of all links from +x, or their rates or changes, from index ``first`` on. For
    i = 0 the result is the link's own value.
    """
    return values[first + i] - (values[first + i - 1] if i > 0 else 0.0)

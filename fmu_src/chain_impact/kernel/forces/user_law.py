"""The interface of a user's own contact law: two functions that are linked to the kernel.

Plain Python uses the functions below. A compiled kernel calls functions of these names that are linked to it:
those of the law, or stubs that say that there is none (compilation/compilers.py).
"""

ARGUMENTS = (
    "penetration",
    "rate",
    "impact_speed",
    "effective_mass",
    "stiffness",
    "exponent",
    "restitution",
)
"""The arguments that a law may have: δ ≥ 0 [m], δ̇ [m/s], v₀ [m/s], m_eff [kg], K [N/mⁿ], n, e."""


def present():
    """Return 1 if there is a user's law, else 0."""
    return 0


def force(_penetration, _rate, _impact_speed, _effective_mass, _stiffness, _exponent, _restitution):
    """Return the force [N] of the user's law for all of ``ARGUMENTS``, before it is cut off at 0."""
    return 0.0

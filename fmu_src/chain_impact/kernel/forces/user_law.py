"""The interface of a user's own contact law: two functions that are linked to the kernel.

Plain Python uses the functions below. A compiled kernel is linked with C functions in their place,
``user_law_present`` and ``user_law_force``: those of a user's law, or stubs that report no law
(compilation/compilers.py).
"""

LAW_ARGUMENTS = (
    "penetration",
    "rate",
    "impact_speed",
    "effective_mass",
    "stiffness",
    "exponent",
    "restitution",
)
"""The arguments that a law may have: δ ≥ 0 [m], δ̇ [m/s], v₀ [m/s], m_eff [kg], K [N/mⁿ], n, e.

At a stop in a joint the arguments belong to an angle: rad, rad/s, kg·m², N·m/radⁿ.
"""


def has_user_law():
    """Return 0: there is no user's law. In a kernel with a law, another function replaces this one."""
    return 0


def force(_penetration, _rate, _impact_speed, _effective_mass, _stiffness, _exponent, _restitution):
    """Return 0. A user's law returns its force [N] before the cut at 0; at a joint's stop the moment [N·m].

    ``LAW_ARGUMENTS`` describes the arguments.
    """
    return 0.0

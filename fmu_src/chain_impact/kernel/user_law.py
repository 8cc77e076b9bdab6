"""The place of a user's law in the kernel: lower.py fills it before it compiles a kernel that has one."""

from chain_impact.kernel.jit import jit

PRESENT = False
ARGUMENTS = (
    "penetration",
    "rate",
    "impact_speed",
    "effective_mass",
    "stiffness",
    "exponent",
    "restitution",
)
"""What a law may ask for: δ ≥ 0 [m], δ̇ [m/s], v₀ [m/s], m_eff [kg], K [N/mⁿ], n, e."""


force = jit(lambda *_: 0.0)  # N, of ARGUMENTS, before it is cut off at 0


def install(compiled):
    """Make a compiled function of ``ARGUMENTS`` the user's law of the kernels lowered from now on."""
    global PRESENT, force
    PRESENT, force = True, compiled

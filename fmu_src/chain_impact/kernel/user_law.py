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


@jit
def force(penetration, rate, impact_speed, effective_mass, stiffness, exponent, restitution):
    """The force of the user's law [N], before it is cut off at 0."""
    return 0.0


def install(function):
    """Compile a function of ``ARGUMENTS`` as the user's law of the kernels lowered from now on."""
    global PRESENT, force  # noqa: PLW0603
    PRESENT, force = True, jit(function)

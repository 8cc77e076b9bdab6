"""A free impact, by integration without the kernel."""

from tests.helpers.models.reference import rebound

MASS, SPEED, STIFFNESS = 2.0, 1.5, 1e7


def scaled_impact(law, e, mass=MASS, speed=SPEED, stiffness=STIFFNESS):
    """Return restitution, largest depth [m] and force [N] of a law's impact, integrated without the kernel.

    With the length L = (m v²/K)^{1/(n+1)} and the time L/v, m δ̈ = −K δⁿ − d δᵖ δ̇ is the equation of
    ``rebound`` with f = d Lᵖ⁺¹/(m v).
    """
    length = (mass * speed**2 / stiffness) ** (1 / (law.exponent + 1))
    factor, s = law.damping_factor(e), law.mass_power
    damping = factor * stiffness ** (1 - s) * mass**s
    scaled = damping * length ** (law.rate_exponent + 1) / (mass * speed)
    unit = rebound(law.exponent, law.rate_exponent, scaled, law.approach_only)
    return unit.restitution, unit.depth * length, unit.force * mass * speed**2 / length

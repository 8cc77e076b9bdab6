"""The largest penetration of a contact that loses no energy."""


def lossless_penetration(energy: float, stiffness: float, exponent: float) -> float:
    """Return the penetration δ [m] at which the force K δⁿ has stored the energy E [J]: K δⁿ⁺¹/(n+1) = E.

    At a stop in a joint the stiffness is in N·m/radⁿ and the penetration in rad.
    """
    penetration: float = (energy * (exponent + 1.0) / stiffness) ** (1.0 / (exponent + 1.0))
    return penetration

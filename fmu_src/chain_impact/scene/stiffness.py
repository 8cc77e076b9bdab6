"""The stiffness of the contact of an elastic sphere with an elastic plane, from radius and materials."""

import math
import warnings

from chain_impact.scene.errors import SceneWarning

INCOMPRESSIBLE_RATIO = 0.5  # [1] Poisson's ratio of an incompressible material, the largest possible ratio
# [m] radius of a part of a large machine; a larger number is probably a radius in mm
LARGEST_RADIUS = 1.0
LEAST_MODULUS = 1e3  # [Pa] Young's modulus of very soft gels; a smaller number is probably a modulus in GPa


def sphere_plane_stiffness(
    radius: float, young_1: float, poisson_1: float, young_2: float, poisson_2: float
) -> float:
    """Return the stiffness K [N/m^1.5] of an elastic sphere on an elastic plane, for the exponent 3/2.

    K = (4/3) E* √R with 1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂, after Hertz 1881, J Reine Angew Math 92:156.

    Args:
        radius: R of the sphere [m].
        young_1: E₁, Young's modulus of the sphere [Pa].
        poisson_1: ν₁, Poisson's ratio of the sphere, above −1 and at most 0.5.
        young_2: E₂, Young's modulus of the plane [Pa].
        poisson_2: ν₂, Poisson's ratio of the plane, above −1 and at most 0.5.

    Warns:
        SceneWarning: when a Young's modulus is so small that it is probably in GPa, or the radius so large
            that it is probably in mm.

    Raises:
        ValueError: when a value is out of range.
    """
    for name, value in (("radius", radius), ("young_1", young_1), ("young_2", young_2)):
        if not 0.0 < value < math.inf:
            raise ValueError(f"{name} = {value} must be a finite number > 0")
    for name, value in (("poisson_1", poisson_1), ("poisson_2", poisson_2)):
        if not -1.0 < value <= INCOMPRESSIBLE_RATIO:
            raise ValueError(f"{name} = {value} must be > -1 and <= 0.5")
    for name, value in (("young_1", young_1), ("young_2", young_2)):
        if value < LEAST_MODULUS:
            hint = f"{name} = {value:g} Pa is softer than a gel: is it in GPa?"
            warnings.warn(hint, SceneWarning, stacklevel=2)
    if radius > LARGEST_RADIUS:
        warnings.warn(f"radius = {radius:g} m: is it in mm?", SceneWarning, stacklevel=2)
    compliance = (1.0 - poisson_1**2) / young_1 + (1.0 - poisson_2**2) / young_2
    return 4.0 / 3.0 * math.sqrt(radius) / compliance

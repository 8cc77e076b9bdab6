"""The factors of the contact laws as functions of a complex restitution, after docs/contact_laws.md."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from tests.helpers.reference import exact_damping_factor, rebound

TINY = 1e-30
"""The imaginary part of a parameter; its square is lost to round-off, so that of any analytic function is
this times its derivative (W. Squire & G. Trapp 1998, *SIAM Rev* 40:110)."""


def exact_factor(e: complex) -> complex:
    """λ with λ(1+e) = ln[(1+λ)/(1−λe)], of Zhang & Sharf 2009, and its derivative by that equation."""
    value = exact_damping_factor(e.real)
    if value == 0.0:
        return 1.5 * (1.0 - e)  # the first term of its series, which is all that a derivative sees
    by_e = value / (1.0 - value * e.real) - value
    by_factor = 1.0 + e.real - 1.0 / (1.0 + value) - e.real / (1.0 - value * e.real)
    return complex(value, e.imag * by_e / by_factor)


def viscoelastic_factor(e: complex) -> complex:
    """f(e) of Kuwabara & Kono 1987: the damping whose unit impact has the restitution e."""

    def missing(damping: float) -> float:
        return rebound(1.5, 0.5, damping).restitution - e.real

    # for small f e′ = 1 − 1.1534 f, and more than that for larger
    damping, h = brentq(missing, 0.99 * (1.0 - e.real) / 1.1535, 2.0 * e.real**-0.6, xtol=1e-15), 1e-3
    near, far = (missing(damping + k * h) - missing(damping - k * h) for k in (1, 2))
    return complex(damping, e.imag * 12.0 * h / (8.0 * near - far))


def logarithmic(e: complex) -> complex:
    """ζ of a linear oscillator whose half-cycles shrink to e."""
    return -cmath.log(e) / cmath.sqrt(cmath.pi**2 + cmath.log(e) ** 2)


FAMILY: dict[str, Callable[[complex], complex]] = {
    "hertz": lambda e: 0.0 * e,
    "hunt_crossley": lambda e: 3 * (1 - e) / 2,
    "herbert_mcwhannell": lambda e: 6 * (1 - e) / ((2 * e - 1) ** 2 + 3),
    "lee_wang": lambda e: 3 * (1 - e) / 4,
    "lankarani_nikravesh": lambda e: 3 * (1 - e**2) / 4,
    "gonthier": lambda e: (1 - e**2) / e,
    "zhang_sharf": exact_factor,
    "zhiying_qishao": lambda e: 3 * (1 - e**2) / 4 * cmath.exp(2 * (1 - e)),
    "ye": lambda e: 8 * (1 - e) / (5 * e),
    "flores": lambda e: 8 * (1 - e) / (5 * e),
    "gharib_hurmuzlu": lambda e: 1 / e,
    "hu_guo": lambda e: 3 * (1 - e) / (2 * e),
    "carvalho_martins": lambda e: 1.5 * (1 - e) * (11 - e) / (1 + 9 * e),
}
"""λ(e) of F = K δⁿ (1 + λ δ̇/v₀)."""
WITH_MASS: dict[str, tuple[Callable[[complex], complex], float, float]] = {
    "kelvin_voigt": (lambda e: 2 * logarithmic(e), 0.0, 0.5),
    "tsuji": (lambda e: math.sqrt(5) * logarithmic(e), 0.25, 0.5),
    "jankowski": (
        lambda e: 9 * math.sqrt(5) * (1 - e**2) / (e * (e * (9 * math.pi - 16) + 16)),
        0.25,
        0.5,
    ),
    "kuwabara_kono": (viscoelastic_factor, 0.5, 0.4),
}
"""f(e), the power p of δ and the power s of the mass, of F = K δⁿ + d δᵖ δ̇ with d = f K^(1−s) m^s."""


@dataclass
class Law:
    """F = K δⁿ + d δᵖ δ̇ of one wall or stop, with its parameters in each lane, shape (lanes,)."""

    model: str
    stiffness: np.ndarray
    exponent: np.ndarray
    restitution: np.ndarray
    slowest: np.ndarray  # m/s or rad/s, the least speed that is latched

    def __post_init__(self) -> None:
        self.rigid, self.approach_only = self.model == "newton_impact", self.model == "jankowski"
        self.rate_exponent, self.mass_power, factor = self.exponent, 0.0, lambda e: 0.0 * e
        if self.model in FAMILY:
            factor = FAMILY[self.model]
        elif not self.rigid:
            factor, p, self.mass_power = WITH_MASS[self.model]
            self.rate_exponent = np.full(len(self.exponent), p, complex)
        # lanes differ in the restitution of at most one of them
        made = {e: factor(complex(e)) for e in set(self.restitution)}
        self.factor = np.array([made[e] for e in self.restitution])
        n, p = self.exponent, self.rate_exponent
        smooth = [
            m
            for m in (1, 2, 4)
            if not (m * n).imag.any() and not (m * n[0]).real % 1 and not (m * p[0]).real % 1
        ]
        # in the eighth root, δⁿ of any n has derivatives up to the order of the method
        self.m = smooth[0] if smooth else 8

    def damping(self, speed: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """d = λ K/v₀ of the Hunt–Crossley family, else f K^(1−s) m^s."""
        if self.mass_power == 0.0:
            return self.factor * self.stiffness / speed
        return self.factor * self.stiffness * (mass / self.stiffness) ** self.mass_power

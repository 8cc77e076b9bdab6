"""The damping factors of the contact laws for a complex restitution, after docs/contact_laws.md."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from tests.helpers.models.reference import exact_damping_factor, rebound

TINY = 1e-30
"""The imaginary part of a parameter. Its square is lost in round-off, so the imaginary part of any analytic
function is TINY times the function's derivative (W. Squire & G. Trapp 1998, *SIAM Rev* 40:110)."""


def exact_factor(e: complex) -> complex:
    """Return λ with λ(1+e) = ln[(1+λ)/(1−λe)], after Zhang & Sharf 2009, and its derivative."""
    value = exact_damping_factor(e.real)
    if value == 0.0:
        return 1.5 * (1.0 - e)  # the first term of the series, which suffices for the derivative
    by_e = value / (1.0 - value * e.real) - value
    by_factor = 1.0 + e.real - 1.0 / (1.0 + value) - e.real / (1.0 - value * e.real)
    return complex(value, e.imag * by_e / by_factor)


def viscoelastic_factor(e: complex) -> complex:
    """Return f(e) of Kuwabara & Kono 1987: the damping with which a unit impact has the restitution e."""

    def missing(damping: float) -> float:
        return rebound(1.5, 0.5, damping).restitution - e.real

    # for small f e′ = 1 − 1.1534 f; for larger f, e′ is larger than this
    damping, h = brentq(missing, 0.99 * (1.0 - e.real) / 1.1535, 2.0 * e.real**-0.6, xtol=1e-15), 1e-3
    near, far = (missing(damping + k * h) - missing(damping - k * h) for k in (1, 2))
    return complex(damping, e.imag * 12.0 * h / (8.0 * near - far))


def logarithmic(e: complex) -> complex:
    """Return ζ of a linear oscillator whose half-cycles shrink to e."""
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
"""Law → λ(e) in F = K δⁿ (1 + λ δ̇/v₀)."""
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
"""Law → f(e), the power p of δ and the power s of the mass, in F = K δⁿ + d δᵖ δ̇ with d = f K^(1−s) m^s."""


@dataclass
class Law:
    """The law F = K δⁿ + d δᵖ δ̇ of one wall or stop, with its parameters in each lane, shape (lanes,)."""

    model: str
    stiffness: np.ndarray
    exponent: np.ndarray
    restitution: np.ndarray
    slowest: np.ndarray  # m/s or rad/s, the least speed that v₀ may have

    def __post_init__(self) -> None:
        self.rigid, self.approach_only = self.model == "newton_impact", self.model == "jankowski"
        self.rate_exponent, self.mass_power, factor = self.exponent, 0.0, lambda e: 0.0 * e
        if self.model in FAMILY:
            factor = FAMILY[self.model]
        elif not self.rigid:
            factor, p, self.mass_power = WITH_MASS[self.model]
            self.rate_exponent = np.full(len(self.exponent), p, complex)
        # at most one lane has a different restitution than the others
        made = {e: factor(complex(e)) for e in set(self.restitution)}
        self.factor = np.array([made[e] for e in self.restitution])
        n, p = self.exponent, self.rate_exponent
        smooth = [
            m
            for m in (1, 2, 4)
            if not (m * n).imag.any() and not (m * n[0]).real % 1 and not (m * p[0]).real % 1
        ]
        # with the eighth root, δⁿ of any n has derivatives up to the order of the method
        self.m = smooth[0] if smooth else 8

    def damping(self, speed: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """Return d = λ K/v₀ for the Hunt–Crossley family, else d = f K^(1−s) m^s."""
        if self.mass_power == 0.0:
            return self.factor * self.stiffness / speed
        return self.factor * self.stiffness * (mass / self.stiffness) ** self.mass_power

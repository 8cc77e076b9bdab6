"""The factors of the contact laws as functions of a complex restitution, after docs/contact_laws.md."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from tests.complex_step import TINY, runge_kutta


def exact_factor(e: complex) -> complex:
    """λ with λ(1+e) = ln[(1+λ)/(1−λe)]: of Zhang & Sharf 2009, for e < 1."""
    if e.real == 1.0:
        return 1.5 * (1.0 - e)  # the first term of its series, which is all that a derivative sees

    # of s, with λe = 1 − exp(−s)
    def remainder(s: Any, e: Any, log: Any, exp: Any) -> Any:
        part = 1.0 - exp(-s)
        return s - part * (1.0 + 1.0 / e) + log(1.0 + part / e)

    root = brentq(remainder, 1e-3 * (1.0 - e.real), 2.0 + 2.0 / e.real, (e.real, math.log, math.exp), 1e-15)
    s = complex(root)
    for _ in range(3):
        part = 1.0 - cmath.exp(-s)
        slope = 1.0 - (1.0 - part) * (1.0 + 1.0 / e - 1.0 / (e + part))
        s -= remainder(s, e, cmath.log, cmath.exp) / slope
    return (1.0 - cmath.exp(-s)) / e


def viscoelastic_rebound(damping: np.ndarray) -> np.ndarray:
    """Restitution of the unit impact δ̈ = −δ^{3/2} − f δ^{1/2} δ̇ until the force is zero, for each f.

    In z = √δ and w = δ̇, with dt = 2z ds: z′ = w, w′ = −2z²(z² + f w). The force ends where z² + f w does.
    """

    def rate(y: np.ndarray) -> np.ndarray:
        return np.stack([y[1], -2.0 * y[0] ** 2 * (y[0] ** 2 + damping * y[1])])

    def force(y: np.ndarray) -> np.ndarray:
        return y[0] ** 2 + damping * y[1]

    y, size = np.stack([0.0 * damping, 1.0 + 0.0 * damping]), 0.02
    while True:
        after = runge_kutta(rate, y, size, rate(y))[0]
        if after[1].real.max() < 0.0 and force(after).real.max() < 0.0:
            break
        y = after
    # w is least there, so where exactly the step ends is of second order
    h = size * force(y) / (force(y) - force(after))
    for _ in range(40):
        after = runge_kutta(rate, y, h, rate(y))[0]
        slope = rate(after)
        change = force(after) / (2.0 * after[0] * slope[0] + damping * slope[1])
        h = h - change
        if np.abs(change).max() < 1e-15:
            break
    return -runge_kutta(rate, y, h, rate(y))[0][1]


def viscoelastic_factor(e: complex) -> complex:
    """f(e) of Kuwabara & Kono 1987: the damping whose unit impact has the restitution e."""

    def missing(damping: float) -> float:
        return viscoelastic_rebound(np.array([complex(damping)]))[0].real - e.real

    # for small f e′ = 1 − 1.1534 f, and more than that for larger
    damping = brentq(missing, 0.99 * (1.0 - e.real) / 1.1535, 2.0 * e.real**-0.6, xtol=1e-15)
    rebound = viscoelastic_rebound(np.array([damping + 1j * TINY]))[0]
    return damping + (e - rebound.real) / (rebound.imag / TINY)


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

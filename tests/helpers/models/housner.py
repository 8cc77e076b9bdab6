"""The block of the model rocking_block on a rigid floor: Housner 1963, Bull Seismol Soc Am 53:403."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad

from chain_impact import load_scene, simulate

GRAVITY = 9.81  # m/s²
STIFFNESSES = [64e9 * 8.0**k for k in range(4)]  # N/m^1.5


@dataclass(frozen=True)
class Block:
    """A rectangle that is tilted on one of its lower corners and released."""

    half_width: float = 0.1  # m
    half_height: float = 0.5  # m
    tilt: float = math.radians(4.0)  # θ₀

    @property
    def reach(self) -> float:
        """The distance R from a corner to the centre [m]."""
        return math.hypot(self.half_width, self.half_height)

    @property
    def slenderness(self) -> float:
        """The angle α [rad] of the line from the corner to the centre, from the vertical."""
        return math.atan2(self.half_width, self.half_height)

    @property
    def rate(self) -> float:
        """The rate p [1/s] with p² = m g R / I = 3 g / (4 R)."""
        return math.sqrt(0.75 * GRAVITY / self.reach)


BLOCK = Block()


def small_quarter_period(block: Block = BLOCK) -> float:
    """Return T/4 = (1/p) arccosh(1/(1 − θ₀/α)) [s] for θ̈ = −p² (α − θ), the case of small angles."""
    return math.acosh(1.0 / (1.0 - block.tilt / block.slenderness)) / block.rate


def quarter_period(block: Block = BLOCK) -> float:
    """Return T/4 [s] for θ̈ = −p² sin(α − θ), by quadrature."""
    alpha, tilt, rate = block.slenderness, block.tilt, block.rate

    def share(u: float) -> float:
        # θ = θ₀ (1 − u²) because the speed at the start is zero; cos a − cos b = 2 sin((a + b)/2) sin((b −
        # a)/2)
        fallen = tilt * u * u
        drop = 2.0 * math.sin(alpha - tilt + fallen / 2.0) * math.sin(fallen / 2.0)
        return 2.0 * tilt * u / (rate * math.sqrt(2.0 * drop))

    return float(quad(share, 0.0, 1.0, epsabs=1e-14)[0])


def simulated_quarter_period(tolerance: float) -> float:
    """Return T/4 [s] of the model in the limit of a rigid floor, from floors with stiffness ratios of 8.

    A corner sinks by δ = (m g/K)^(2/3). The time is a series in δ; each step of the extrapolation removes one
    power.
    """
    onsets = []
    for stiffness in STIFFNESSES:
        scene = load_scene("rocking_block").with_values({"contact.stiffness": stiffness})
        impacts = simulate(scene, 0.3, tolerance=tolerance, output_step=math.inf).impacts
        onsets.append(impacts["onset"][impacts["point"] == 1][0])
    times = np.array(onsets)
    for power in range(1, len(STIFFNESSES)):
        share = 4.0**power  # the ratio of δ^power between two floors, where δ is a quarter
        times = (share * times[1:] - times[:-1]) / (share - 1.0)
    return float(times[0])

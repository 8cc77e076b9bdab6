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
    """A rectangle that is tilted on one of its lower corners and let go."""

    half_width: float = 0.1  # m
    half_height: float = 0.5  # m
    tilt: float = math.radians(4.0)  # θ₀

    @property
    def reach(self) -> float:
        """R, from a corner to the centre [m]."""
        return math.hypot(self.half_width, self.half_height)

    @property
    def slenderness(self) -> float:
        """The angle α at which the centre stands above the corner [rad]."""
        return math.atan2(self.half_width, self.half_height)

    @property
    def rate(self) -> float:
        """The rate p of p² = m g R / I = 3 g / (4 R) [1/s]."""
        return math.sqrt(0.75 * GRAVITY / self.reach)


BLOCK = Block()


def small_quarter_period(block: Block = BLOCK) -> float:
    """T/4 = (1/p) arccosh(1/(1 − θ₀/α)) of θ̈ = −p² (α − θ), for small angles [s]."""
    return math.acosh(1.0 / (1.0 - block.tilt / block.slenderness)) / block.rate


def quarter_period(block: Block = BLOCK) -> float:
    """T/4 of θ̈ = −p² sin(α − θ), a quadrature of dθ/|ω| with ω² = 2 p² (cos(α − θ₀) − cos(α − θ)) [s]."""
    alpha, tilt, rate = block.slenderness, block.tilt, block.rate

    def share(u: float) -> float:
        # θ = θ₀ (1 − u²), as the speed at the start is zero; cos a − cos b = 2 sin((a + b)/2) sin((b − a)/2)
        fallen = tilt * u * u
        drop = 2.0 * math.sin(alpha - tilt + fallen / 2.0) * math.sin(fallen / 2.0)
        return 2.0 * tilt * u / (rate * math.sqrt(2.0 * drop))

    return float(quad(share, 0.0, 1.0, epsabs=1e-14)[0])


def simulated_quarter_period(tolerance: float) -> float:
    """T/4 of the model as its floor becomes rigid, from floors each 8 times as stiff as the last [s].

    A corner sinks by δ = (m g/K)^(2/3). The time is a series in δ, of which each step takes a power away.
    """
    found = []
    for stiffness in STIFFNESSES:
        scene = load_scene("rocking_block").with_values({"contact.stiffness": stiffness})
        impacts = simulate(scene, 0.3, tolerance=tolerance, output_step=math.inf).impacts
        found.append(impacts["onset"][impacts["point"] == 1][0])
    times = np.array(found)
    for power in range(1, len(STIFFNESSES)):
        share = 4.0**power  # of δ, which is a quarter
        times = (share * times[1:] - times[:-1]) / (share - 1.0)
    return float(times[0])

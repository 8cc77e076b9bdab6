"""Fixed steps of semi-implicit Euler and of RK4 on the compiled plain_chain.py."""

from __future__ import annotations

import math

import numpy as np
from plain_chain import clearance, jit, locate, mechanical_energy, new_work, rate

from chain_impact.kernel.events.exclusion import RELATCH_RATIO


@jit
def fixed_steps(chain, y, dt, stop, floor, limits, euler):  # noqa: PLR0912, PLR0917, compiled
    """Fixed steps of semi-implicit Euler or of RK4; a contact begins and ends at the end of a step.

    Args:
        chain: the chain.
        y: state, changed in place.
        dt: step [s].
        stop: [s].
        floor: smallest latched speed [m/s].
        limits: energy [J] and depth [m] at which it stops.
        euler: whether to take Euler's steps.

    Returns:
        Steps, highest energy [J], largest depth [m], onsets; not finite when the state is.
    """
    n, count = len(chain.length) + 2, len(chain.candidate_point)
    work, active, v0 = new_work(n - 1), np.zeros(count, np.bool_), np.ones(count)
    k1, k2, k3, k4, z = np.empty(2 * n), np.empty(2 * n), np.empty(2 * n), np.empty(2 * n), np.empty(2 * n)
    highest, deepest, onsets = -np.inf, 0.0, 0
    total = round(stop / dt)
    for step in range(total):
        stored = rate(chain, work, y, active, v0, k1)
        locate(chain, work, y)
        energy = stored + mechanical_energy(chain, work, y)
        for c in range(count):
            gap, speed = clearance(chain, work, c)
            deepest = max(deepest, -gap)
            if gap < 0.0 and not active[c]:
                active[c], v0[c] = True, max(-speed, floor)
                onsets += 1
                stored = rate(chain, work, y, active, v0, k1)
            elif gap >= 0.0:
                active[c] = False
            elif -speed > RELATCH_RATIO * v0[c]:
                v0[c] *= RELATCH_RATIO
        highest = max(highest, energy)
        if not (energy <= limits[0] and deepest <= limits[1]):
            return step, (highest if math.isfinite(energy) else np.nan), deepest, onsets
        if euler:
            for j in range(n):
                y[n + j] += dt * k1[n + j]
                y[j] += dt * y[n + j]
        else:
            for j in range(2 * n):
                z[j] = y[j] + 0.5 * dt * k1[j]
            rate(chain, work, z, active, v0, k2)
            for j in range(2 * n):
                z[j] = y[j] + 0.5 * dt * k2[j]
            rate(chain, work, z, active, v0, k3)
            for j in range(2 * n):
                z[j] = y[j] + dt * k3[j]
            rate(chain, work, z, active, v0, k4)
            for j in range(2 * n):
                y[j] += dt * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]) / 6.0
    return total, highest, deepest, onsets

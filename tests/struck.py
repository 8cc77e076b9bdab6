"""Random single impacts of one rod or two with friction, and their closed form for stiff walls."""

from __future__ import annotations

import numpy as np

from tests.assembled import Assembled
from tests.coulomb_impact import Departure, Strike, stiff_limit
from tests.coulomb_problems import Table
from tests.places import separated
from tests.problems import contact_table, scene_table
from tests.reference import exact_damping_factor

SLOWEST, FASTEST = 0.3, 5.0  # m/s, of the approach


def struck(seed: int, stiffness: float) -> tuple[Table, Strike, float]:
    """A scene whose tip touches the floor at time 0 and arrives, without gravity; what arrives; and e.

    One free rod, two free ones, or two whose base is pinned. Nothing else can touch.
    """
    rng = np.random.default_rng(seed)
    count = 1 + seed % 2
    base = "pinned" if seed % 4 == 1 else "free"
    restitution, friction = float(rng.uniform(0.2, 1.0)), float(rng.uniform(0.0, 1.2))
    coulomb = {"friction": friction}
    if rng.random() < 0.5:
        coulomb["static_friction"] = friction * float(rng.uniform(1.0, 1.5))
    while True:
        lengths, masses = rng.uniform(0.3, 1.0, count), rng.uniform(0.3, 2.0, count)
        angles, omegas = rng.uniform(-np.pi, np.pi, count), rng.uniform(-3.0, 3.0, count)
        velocity = [0.0, 0.0] if base == "pinned" else rng.uniform(-2.0, 2.0, 2).tolist()
        initial = {
            "position": [0.0, -float(lengths @ np.sin(angles))],
            "angles": angles.tolist(),
            "velocity": velocity,
            "angular_velocities": omegas.tolist(),
        }
        contact = contact_table(stiffness=stiffness, restitution=restitution, points=[count], **coulomb)
        links = [{"length": float(a), "mass": float(m)} for a, m in zip(lengths, masses, strict=True)]
        table = scene_table("Struck", links, initial, {"y_min": 0.0}, contact, base=base, stop_time=0.1)
        scene, bounds = separated(table)
        chain = Assembled(scene, bounds)
        strike = chain.strike(chain.start, 0)
        if SLOWEST < strike.approach < FASTEST:
            return table, strike, restitution


def duration(strike: Strike, stiffness: float) -> float:
    """How long a force must be given to end [s]: many durations of an elastic impact."""
    return 40.0 * (strike.approach**2 / strike.nn / stiffness) ** 0.4 / strike.approach


def limit(seed: int) -> Departure:
    """The impact as K → ∞."""
    _, strike, restitution = struck(seed, 1.0)
    return stiff_limit(strike, exact_damping_factor(restitution))


def extrapolated(soft: np.ndarray, stiff: np.ndarray, ratio: float) -> np.ndarray:
    """Richardson's extrapolation of values at K and ``ratio`` · K, which approach their limit as K^−2/5.

    Of the first 200 impacts simulated at 1e12 and 1e13, the impulses came within 1.3e-6 of the normal one,
    half of them within 3e-9; at 1e11 and 1e12 within 7e-6 and 9e-9. Two of the first 1500 need larger
    stiffnesses, 493 and 869: a pinned arm is all but straight, so W is all but singular and the impact long.
    """
    factor = ratio**0.4
    return (factor * stiff - soft) / (factor - 1.0)

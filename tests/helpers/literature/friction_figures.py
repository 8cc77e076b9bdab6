"""Problems from the literature with dry friction: published figures, second solutions and our values.

The scenes, with their sources and closed forms, are those of coulomb_literature.py. If walls are rigid in the
source, our value is the limit K → ∞, by Richardson's extrapolation from two stiffnesses. Units are SI
throughout.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from chain_impact import Result
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.literature import coulomb_literature
from tests.helpers.literature.figures import Figure, Problem, problem, run
from tests.helpers.models.coulomb_impact import extrapolated, stiff_limit
from tests.helpers.models.derivatives import differentiate
from tests.helpers.models.housner import quarter_period, simulated_quarter_period
from tests.helpers.models.reference import exact_damping_factor
from tests.helpers.scenes.coulomb_problems import Table

SOFT, STIFF = 1e12, 1e13  # [N/m^(3/2)] the two stiffnesses for impacts
SOFT_FLOOR = 1e5  # [N/m^(3/2)] stiffness of a floor that throws Glocker's rod up


def run_table(table: Table, tolerance: float, **changes: Any) -> Result:
    """Return the result of the scene of a table at a tolerance."""
    return run(table["name"], tolerance, scene_from_dict(table, table["name"]), **changes)


def in_the_limit(
    build: Callable[[float], Table], values: Callable[[Result], list[float]], tolerance: float, **changes: Any
) -> tuple[np.ndarray, Result]:
    """Return values of an impact as K → ∞, and the run with the larger K."""
    soft, stiff = (run_table(build(stiffness), tolerance, **changes) for stiffness in (SOFT, STIFF))
    return extrapolated(np.array(values(soft)), np.array(values(stiff)), STIFF / SOFT), stiff


def unpublished(quantity: str, independent: float, ours: float, held: float) -> Figure:
    """Return a figure for which the source has neither a value nor an equation."""
    return Figure(quantity, None, independent, ours, held, equation=False)


def impulses(result: Result) -> list[float]:
    """Return the normal impulse and the impulse of friction of the only impact [N·s]."""
    (impact,) = result.impacts
    return [impact["impulse"], result[f"contact[{impact['point']}].y_min.friction_impulse"][-1]]


def kane_pendulum(tolerance: float) -> Problem:
    """Return figures for the energy that Kane and Levinson's rule adds, and that a force takes."""
    _, exact = coulomb_literature.kane_pendulum()
    (*impulse, speed, gained), result = in_the_limit(
        lambda stiffness: coulomb_literature.kane_pendulum(stiffness)[0],
        lambda result: [
            *impulses(result),
            result.impacts["separation_speed"][0],
            result["energy.total"][-1] - result["energy.total"][0],
        ],
        tolerance,
        output_step=0.05,
    )
    limit, published = exact.limit, exact.published_gain
    figures = [
        Figure("energy made by the impact [J]", published, -limit.dissipated, gained, 1e-9, 0.05, True),
        unpublished("normal impulse [N·s]", limit.normal, impulse[0], 1e-8),
        unpublished("impulse of friction [N·s]", limit.tangential, impulse[1], 1e-8),
        unpublished("separation speed [m/s]", limit.separation, speed, 1e-8),
    ]
    return problem("kane_pendulum", result, figures)


def siconos_stick(tolerance: float) -> Problem:
    """Return figures for the stick between its first and second impact, in free flight."""
    _, exact = coulomb_literature.siconos_stick()

    def flight(result: Result) -> list[float]:
        angle, spin = result["link[1].angle"][-1], result["link[1].angular_velocity"][-1]
        along = result["point[0].vx"][-1] - 0.5 * spin * math.sin(angle)
        return [along, spin, result["energy.total"][-1] - result["energy.total"][0]]

    ours, result = in_the_limit(
        lambda stiffness: coulomb_literature.siconos_stick(stiffness)[0],
        flight,
        tolerance,
        stop_time=0.1,
        output_step=0.1,
    )
    onset = result.impacts["onset"][0]
    names = (
        "velocity of the centre along the floor after it [m/s]",
        "angular velocity after it [rad/s]",
        "energy made by it [J]",
    )
    held, errors = (1e-8, 1e-6, 1e-8), (0.0062, 0.0051, 0.0015)
    figures = [unpublished("impact: time [s]", exact.onset, onset, 1e-12)]
    figures += [
        Figure(*row, True)
        for row in zip(names, exact.published, exact.limit, ours, held, errors, strict=True)
    ]
    fremond = [f"Frémond's law: {name}" for name in names]
    figures += [
        Figure(*row, True)
        for row in zip(
            fremond, coulomb_literature.FREMOND, exact.limit, ours, held, (0.0013, 0.0041, 7e-5), strict=True
        )
    ]
    return problem("siconos_stick", result, figures)


def glocker_rod(tolerance: float) -> Problem:
    """Return figures for the time at which the rigid rod cannot slide on, and for its motion then."""
    _, exact = coulomb_literature.glocker_rod()
    soft, stiff = (time_at(stiffness, tolerance, exact.angle) for stiffness in (1e7, 1e8))
    # observation: this time approaches that of the rigid rod in proportion to K^−1/2
    ours = (math.sqrt(10.0) * stiff - soft) / (math.sqrt(10.0) - 1.0)
    table, _ = coulomb_literature.glocker_rod(SOFT_FLOOR)
    result = run_table(table, tolerance, stop_time=0.86, output_step=0.86)
    phases = result.stick_slip
    angles = [
        phases["start"][phases["mode"] == 0][0],
        result.impacts["end"][0],
        result["point[1].vy"][-1],
        result["link[1].angular_velocity"][-1],
    ]
    names = ("the end sticks: time [s]", "it leaves the floor: time [s]", "its upward speed at 0.86 s [m/s]")
    names += ("angular velocity at 0.86 s [rad/s]",)
    figures = [
        Figure("it cannot slide on: time [s]", exact.published, exact.time, ours, 2e-5, 0.016, True),
        *(
            unpublished(f"K = 10⁵: {name}", second, value, 2e-8)
            for name, second, value in zip(names, thrown_up(), angles, strict=True)
        ),
    ]
    return problem("glocker_rod", result, figures)


def time_at(stiffness: float, tolerance: float, angle: float) -> float:
    """Return the time [s] at which Glocker's rod reaches an angle from the floor."""
    table, _ = coulomb_literature.glocker_rod(stiffness)
    result = run_table(table, tolerance, stop_time=0.82, output_step=1e-3)
    turned = CubicHermiteSpline(result.time, result["link[1].angle"], result["link[1].angular_velocity"])
    return float(brentq(lambda time: turned(time) + angle, 0.8, 0.82, xtol=1e-14))


FALL = 1e-11  # m


@cache
def thrown_up() -> tuple[float, float, float, float]:
    """Return when the end sticks and leaves the soft floor; upward speed and spin of the rod at 0.86 s."""
    table, _ = coulomb_literature.glocker_rod(SOFT_FLOOR)
    x, y = table["initial"]["position"]
    # the contact begins a little later, because this model cannot start in a contact at rest
    table = table | {"initial": table["initial"] | {"position": [x, y + FALL]}}
    motion = differentiate(scene_from_dict(table, table["name"]), (), [0.86])
    (sticks,), (leaves,) = [time for time, _, mode in motion.modes if mode == 0], motion.impacts["end"]
    return sticks, leaves, motion.values["point[1].vy"][-1], motion.values["link[1].angular_velocity"][-1]


def stewart_rod(tolerance: float) -> Problem:
    """Return figures for the impact of Stewart and Trinkle's rod, whose end slides, stops and sticks."""
    _, exact = coulomb_literature.stewart_rod()
    limit = stiff_limit(exact.strike, exact_damping_factor(0.05))
    ours, result = in_the_limit(
        lambda stiffness: coulomb_literature.stewart_rod(stiffness)[0],
        lambda result: [*impulses(result), result.impacts["separation_speed"][0]],
        tolerance,
        stop_time=0.39,
        output_step=0.39,
    )
    figures = [
        unpublished("impact: time [s]", exact.onset, result.impacts["onset"][0], 1e-12),
        # a restitution of 0.05 makes the contact long: its limit is approached more slowly than as K^−2/5
        unpublished("normal impulse [N·s]", limit.normal, ours[0], 1e-5),
        unpublished("impulse of friction [N·s]", limit.tangential, ours[1], 1e-5),
        unpublished("separation speed [m/s]", limit.separation, ours[2], 1e-5),
    ]
    return problem("stewart_rod", result, figures)


def rocking_block(tolerance: float) -> Problem:
    """Return figures for the spin of a block after its other corner hits the floor."""
    tilt, restitutions = 0.2, (0.1, 0.2)
    left, figures = [], []
    for restitution in restitutions:
        after, result, exact = rocked(tilt, restitution, tolerance)
        left.append(after / exact.before)
        quantity = f"block of 1 × 1.5 m, e = {restitution}: angular velocity after / before"
        figures.append(unpublished(quantity, exact.after / exact.before, left[-1], 2e-7))
    (onset,) = result.impacts["onset"][result.impacts["point"] == 2]
    # the corner that hits sticks during the impact, so the spin after it is linear in e
    plastic, quantity = 2.0 * left[0] - left[1], "block of 1 × 1.5 m, extrapolated to e = 0: the same"
    figures = [
        # a block on a stiff floor stands a little deeper than on a rigid floor
        unpublished("other corner hits: time [s]", exact.onset, onset, 1e-8),
        *figures,
        Figure(quantity, None, exact.published, plastic, 3e-7),
        unpublished(
            "quarter period on a rigid floor [s]", quarter_period(), simulated_quarter_period(tolerance), 1e-9
        ),
    ]
    return problem("rocking_block", result, figures)


def rocked(
    tilt: float, restitution: float, tolerance: float
) -> tuple[float, Result, coulomb_literature.RockingBlock]:
    """Return the spin [rad/s] after the other corner's impact as K → ∞, the stiff run, the exact answer."""

    def build(stiffness: float) -> Table:
        return coulomb_literature.rocking_block(tilt, stiffness=stiffness, restitution=restitution)[0]

    _, exact = coulomb_literature.rocking_block(tilt, restitution=restitution)
    stop = exact.onset + 1e-3
    (after,), result = in_the_limit(
        build,
        lambda result: [result["link[1].angular_velocity"][-1]],
        tolerance,
        stop_time=stop,
        output_step=stop,
    )
    return after, result, exact

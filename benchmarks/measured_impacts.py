"""Measured impacts with friction: ``python -m benchmarks measured_impacts FOLDER``.

FOLDER is ``processed_data`` of the repository mcubelab/planar-impact-dataset (Fazeli, Donlon, Drumwright &
Rodriguez 2017). The repository has no licence, so this project contains only aggregates of its data.

An ellipse is dropped in a plane; its velocities before and after each impact were measured, and the place of
the contact point. In the scene the ellipse is one free link from the centre of mass to the contact point,
without gravity. Restitution and friction, the same for all impacts, are fitted to every second trial with
``fit``, and judged by the other trials. Beside the laws of this package there is a model with a compliance
along the wall.

The sign of x in the data contradicts that of the angles: only with −x do the torques follow from the forces.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat
from scipy.optimize import minimize

from benchmarks import common
from chain_impact import Fit, fit, simulate
from chain_impact.scene.scene import Scene, scene_from_dict

MASS, GYRATION = 0.0364, 0.0192  # mass [kg] and radius of gyration [m] of the ellipse
# STOP: end of a run [s]; GAP: distance from the wall at the start [m]; the impact begins within 1e-5 s and
# takes about 1e-5 s
STOP, GAP = 1e-3, 1e-6
START = {"contact.restitution": 0.6, "contact.friction": 0.2}
# ratio of tangential to normal stiffness of an elastic contact, 2 (1 − ν)/(2 − ν) for Poisson's ratio ν = 0.3
MINDLIN = 0.82
STEPS = 400  # number of time steps in half an elastic impact, in the model with a compliance


@dataclass(frozen=True)
class Trials:
    """The n measured impacts, with velocities (v_x, v_y, ω) of the centre [m/s, m/s, rad/s].

    Attributes:
        before: velocities before the impacts, shape (n, 3).
        after: velocities after the impacts, shape (n, 3).
        arm: vectors from the centre to the contact point [m], shape (n, 2).
    """

    before: np.ndarray
    after: np.ndarray
    arm: np.ndarray

    def __getitem__(self, part: slice) -> Trials:
        return Trials(self.before[part], self.after[part], self.arm[part])

    def at_contact(self, velocity: np.ndarray) -> np.ndarray:
        """Return the velocity of the contact point along the wall and away from it [m/s], shape (n, 2)."""
        at_contact: np.ndarray = velocity[:, :2] + velocity[:, 2:] * self.arm[:, ::-1] * [-1.0, 1.0]
        return at_contact


def read(folder: Path) -> Trials:
    """Return the trials of the data set."""
    data = loadmat(folder / "data_ellipse.mat", simplify_cells=True)["data"]
    signs = [-1.0, 1.0, 1.0]
    velocities_before, velocities_after = (data[f"states_{name}"][:, 3:] * signs for name in "if")
    return Trials(velocities_before, velocities_after, np.stack([data["n"][:, 2], -data["d"][:, 2]], axis=1))


# --- as scenes --------------------------------------------------------------------------------------------


def ellipse() -> Scene:
    """Return the scene of all trials; ``values`` has the values that differ between trials."""
    link = {"length": 0.03, "mass": MASS, "center_of_mass": 0.0, "inertia": MASS * GYRATION**2}
    table = {
        "name": "Ellipse",
        "gravity": [0.0, 0.0],
        "chain": {"links": [link]},
        "box": {"y_min": 0.0},
        "contact": {"stiffness": 1e10, "points": [1]},
        "initial": {"position": [0.0, 0.04], "angles": [-math.pi / 2]},
        "simulation": {"stop_time": STOP, "step_size": STOP},
    }
    return scene_from_dict(table, "ellipse").with_values(START)


def values(trials: Trials) -> dict[str, np.ndarray]:
    """Return name of a value of the scene → its values, one for each trial."""
    arm_x, arm_y = trials.arm.T
    names = ("initial.vx", "initial.vy", "initial.angular_velocity[1]")
    scene_values = {"link[1].length": np.hypot(arm_x, arm_y), "initial.angle[1]": np.arctan2(arm_y, arm_x)}
    return scene_values | {"initial.y": GAP - arm_y} | dict(zip(names, trials.before.T, strict=True))


OUTPUTS = ("point[0].vx", "point[0].vy", "link[1].angular_velocity")


def fitted(scene: Scene, trials: Trials, laws: bool = False) -> Fit:
    """Return the fit of restitution and friction to the velocities after the impacts."""
    data = [
        {"time": [STOP]} | dict(zip(OUTPUTS, velocity[:, None], strict=True)) for velocity in trials.after
    ]
    sigma = dict(zip(OUTPUTS, (0.2, 0.2, 0.2 / GYRATION), strict=True))
    return fit(scene, data, list(START), set_each=values(trials), sigma=sigma, laws=laws)


def predicted(scene: Scene, trials: Trials) -> np.ndarray:
    """Return the simulated velocities after the impacts, shape (n, 3)."""
    scene_values = values(trials)
    rows = []
    for k in range(len(trials.before)):
        result = simulate(scene.with_values({name: float(value[k]) for name, value in scene_values.items()}))
        rows.append([result[name][-1] for name in OUTPUTS])
    return np.array(rows)


# --- with a compliance along the wall -----------------------------------------------------------------------


def compliant(trials: Trials, restitution: float, friction: float, ratio: float) -> np.ndarray:
    """Return velocities after impacts, shape (n, 3), for a spring along the wall in series with dry friction.

    The normal force is K δ^3/2, times e² on the way out. The stiffness of the spring is the slope of K δ^3/2
    times ``ratio`` (Mindlin & Deresiewicz 1953). Without gravity the value of K [N/m^1.5] does not matter: it
    is that of the mass [kg].
    """
    velocity, (arm_x, arm_y) = trials.before.copy(), trials.arm.T
    closing = -trials.at_contact(velocity)[:, 1]
    inverse = 1.0 + (arm_x / GYRATION) ** 2
    dt = 2.94 / closing * (1.25 * closing**2 / inverse) ** 0.4 / STEPS
    depth, stretch = np.zeros((2, len(dt)))
    inwards = touches = np.full(len(dt), True)
    while touches.any():
        slip_speed, normal_speed = trials.at_contact(velocity).T
        depth = depth - normal_speed * dt
        touches, inwards = touches & (depth > 0.0), inwards & (normal_speed < 0.0)
        root = np.sqrt(np.where(touches, depth, 0.0))
        normal = np.where(inwards, 1.0, restitution**2) * root**3
        spring, limit = 1.5 * ratio * root, friction * normal
        tangential = np.clip(-spring * (stretch + slip_speed * dt), -limit, limit)
        stretch = -tangential / np.where(touches, spring, 1.0)
        torque = (arm_x * normal - arm_y * tangential) / GYRATION**2
        velocity += np.stack([tangential, normal, torque], axis=1) * dt[:, None]
    return velocity


def fitted_compliant(trials: Trials, ratio: float | None) -> list[float]:
    """Return restitution, friction and ratio of the stiffnesses; a ``ratio`` that is given is not fitted."""

    def misfit(x: np.ndarray) -> float:
        if not (0.0 < x[0] <= 1.0 and (x > 0.0).all()):
            return math.inf
        return float((errors(trials, compliant(trials, *x, *fixed)) ** 2).sum())

    fixed = [] if ratio is None else [ratio]
    starts = (
        [[*START.values(), start_ratio] for start_ratio in (0.3, 1.0, 3.0)]
        if ratio is None
        else [[*START.values()]]
    )
    solutions = [minimize(misfit, x, method="Nelder-Mead", options={"xatol": 1e-3}) for x in starts]
    return [*min(solutions, key=lambda solution: solution.fun).x, *fixed]


# --- errors -------------------------------------------------------------------------------------------------


def errors(trials: Trials, velocities: np.ndarray) -> np.ndarray:
    """Return the errors of predicted velocities [m/s], shape (n,).

    An error is the length of the vector of the errors of v_x, v_y, and ω times the radius of gyration.
    """
    sizes: np.ndarray = np.linalg.norm((velocities - trials.after) * [1.0, 1.0, GYRATION], axis=1)
    return sizes


def figures(trials: Trials, velocities: np.ndarray, **parameters: float) -> dict[str, Any]:
    """Return the median error, the error that 90 % of trials stay below [m/s], and two shares of the trials.

    The first share is that of trials in which the contact point moves along the wall after the impact in the
    measured direction; the second share, in which it moves against its direction before the impact.
    """
    quantiles = np.quantile(errors(trials, velocities), (0.5, 0.9))
    directions = trials.at_contact(velocities)[:, 0]
    directions = np.sign(np.where(np.abs(directions) < 1e-6, 0.0, directions))  # 0: it sticks
    directions_before, directions_after = (
        np.sign(trials.at_contact(velocity)[:, 0]) for velocity in (trials.before, trials.after)
    )
    parts = {
        "direction": np.mean(directions == directions_after),
        "moves back": np.mean(directions == -directions_before),
    }
    numbers = parameters | {"median": quantiles[0], "90 %": quantiles[1]} | parts
    return {name: common.rounded(number) for name, number in numbers.items()}


def facts(trials: Trials) -> dict[str, float]:
    """Return facts on the measurements: speeds, Newton's restitution, the share of points that move back."""
    contact_before, contact_after = trials.at_contact(trials.before), trials.at_contact(trials.after)
    low, middle, high = np.quantile(-contact_after[:, 1] / contact_before[:, 1], (0.05, 0.5, 0.95))
    numbers = {
        "trials": len(contact_before),
        "speed": np.median(np.linalg.norm(trials.before * [1.0, 1.0, GYRATION], axis=1)),
        "restitution": middle,
        "restitution 5 %": low,
        "restitution 95 %": high,
        "moves back": np.mean(contact_before[:, 0] * contact_after[:, 0] < 0.0),
        "median ratio": np.median(contact_after[:, 0] / contact_before[:, 0]),
    }
    return {name: common.rounded(number) for name, number in numbers.items()}


def measure(trials: Trials) -> dict[str, Any]:
    """Return facts on all trials, and the errors of each law and of the compliant model in the odd trials."""
    fitted_trials, judged_trials = trials[::2], trials[1::2]
    rows: dict[str, Any] = {}
    for entry in fitted(ellipse(), fitted_trials, laws=True).ranking:
        if entry.fit is None:
            rows[entry.law] = {"note": entry.note}
            continue
        rows[entry.law] = figures(
            judged_trials, predicted(entry.fit.scene, judged_trials), **entry.fit.values
        )
    for name, ratio in (("Mindlin", MINDLIN), ("free", None)):
        x = fitted_compliant(fitted_trials, ratio)
        names = (*START, "ratio of the stiffnesses")
        velocities = compliant(judged_trials, *x)
        rows[f"compliance, {name}"] = figures(judged_trials, velocities, **dict(zip(names, x, strict=True)))
    return {"facts": facts(trials), "odd trials": rows}


def main() -> None:
    """Fit and judge all models, and save the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="processed_data of mcubelab/planar-impact-dataset")
    folder = parser.parse_args().folder
    started = common.environment()
    settings = {"data": "mcubelab/planar-impact-dataset f24a7e3", "fitted to": "even trials"}
    common.save("measured_impacts", started, settings, measure(read(folder)))


if __name__ == "__main__":
    main()

"""A measured arm under torque, with dry friction in its joints: ``python -m benchmarks measured_arm FOLDER``.

FOLDER is ``data/experiment_records/design_C.1/sys_id/20230629`` of dfki-ric-underactuated-lab/double_pendulum
(BSD-3-Clause, commit 1e8544e): a double pendulum with motors in both joints, whose angles and torques were
measured. Both torques act on the model as they were measured. SciPy's ``least_squares``, with derivatives and
equal weights for all errors, fits centres of mass, inertias, viscous damping and dry friction to one run,
with confidence intervals. The result is judged by a run to which it is not fitted.

A motion is predicted over short spans, each from the angles and rates measured at its start, because errors
grow fast where the arm is upright.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from benchmarks import common
from chain_impact import simulate
from chain_impact.scene.scene import Scene, scene_from_dict

FITTED, UNSEEN = "20230629-143601", "20230629-143524"
SPAN, STEP = 0.5, 0.02  # [s] duration of a span, and communication step
HALF_WINDOW = 5  # a parabola through this number of samples on each side of a start gives the rates there
KEYS = ("center_of_mass", "inertia", "joint_damping", "joint_friction")
START, HIGHEST, SCALE = (0.2, 0.005, 0.01, 0.1), (1.0, 0.2, 0.5, 1.0), (0.1, 0.005, 0.02, 0.05)
DRY = "joint_friction"


class Span(NamedTuple):
    """A part of a run, of T samples.

    Attributes:
        times: times of the samples, from 0 [s], shape (T,).
        angles: angles of the joints [rad], shape (2, T).
        torques: torques at the joints [N·m], shape (2, T).
        rates: rates of the joints at the start [rad/s], shape (2,).
    """

    times: np.ndarray
    angles: np.ndarray
    torques: np.ndarray
    rates: np.ndarray


def arm() -> Scene:
    """Return the scene, with the lengths and masses of the design; both links hang down at the start."""
    links = [{"length": 0.2, "mass": 0.5}, {"length": 0.3, "mass": 0.6}]
    table = {
        "name": "MeasuredArm",
        "chain": {"base": "pinned", "links": links},
        "inputs": {"joint_torques": True},
        "initial": {"angles": [-math.pi / 2] * 2},
        "solver": {"tolerance": 1e-6},
        "simulation": {"stop_time": SPAN, "step_size": STEP},
    }
    return scene_from_dict(table, "measured_arm")


def read(file: Path, first: float = 0.5) -> list[Span]:
    """Return parts of a run, each SPAN long; data before the time ``first`` [s] are left out."""
    data = np.genfromtxt(file, delimiter=",", names=True)
    time = data["time"]
    angles, torques = (np.array([data[f"{name}_meas{i}"] for i in (1, 2)]) for name in ("pos", "tau"))
    spans = []
    for start in np.arange(first, time[-1] - SPAN - STEP, SPAN):
        at = int(np.searchsorted(time, start))
        window, part = (
            slice(at - HALF_WINDOW, at + HALF_WINDOW + 1),
            slice(at, np.searchsorted(time, start + SPAN + STEP)),
        )
        bend = np.polyfit(time[window] - time[at], angles[:, window].T, 2)
        part_angles = angles[:, part].copy()
        part_angles[:, 0] = bend[2]
        spans.append(Span(time[part] - time[at], part_angles, torques[:, part], bend[1]))
    return spans


def angle_errors(
    x: np.ndarray, span: Span, names: list[str], derivatives: bool = False
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the errors of both joint angles [rad] over a span if the parameters ``names`` have values ``x``.

    The second result is their derivatives with respect to ``x``, or None without ``derivatives``.
    """
    angles, rates = np.cumsum(span.angles[:, 0]) - math.pi / 2, np.cumsum(span.rates)
    start = {f"initial.angle[{i + 1}]": float(math.remainder(a, math.tau)) for i, a in enumerate(angles)}
    start |= {f"initial.angular_velocity[{i + 1}]": float(rate) for i, rate in enumerate(rates)}
    result = simulate(
        arm().with_values(dict(zip(names, map(float, x), strict=True)) | start),
        inputs={f"joint[{i}].torque": (span.times, torque) for i, torque in enumerate(span.torques, 1)},
        interpolation="linear",
        output=["link[*].angle"],
        sensitivities=names if derivatives else None,
    )

    def joints(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return np.concatenate([first - first[0], second - first - (second[0] - first[0])])

    measured = [np.interp(result.time, span.times, angle - angle[0]) for angle in span.angles]
    errors = joints(result["link[1].angle"], result["link[2].angle"]) - np.concatenate(measured)
    if not derivatives:
        return errors, None
    slopes = [[result.sensitivity(f"link[{i}].angle", name) for i in (1, 2)] for name in names]
    # a derivative that does not exist, for example when a joint almost stops, becomes 0: the row does not
    # guide the search, but its error still counts
    return errors, np.nan_to_num(np.stack([joints(*pair) for pair in slopes], axis=1))


def all_angle_errors(x: np.ndarray, spans: list[Span], names: list[str]) -> np.ndarray:
    """Return errors over all spans [rad]."""
    return np.concatenate([angle_errors(x, span, names)[0] for span in spans])


def fitted(spans: list[Span], dry: bool) -> tuple[dict[str, dict[str, float]], np.ndarray]:
    """Return the parameters with their 95 % intervals, with dry friction or without; and their values."""
    keys = [k for k in range(len(KEYS)) if dry or KEYS[k] != DRY]
    names = [f"link[{i}].{KEYS[k]}" for i in (1, 2) for k in keys]

    def both(values: tuple[float, ...]) -> list[float]:
        return [values[k] for k in keys] * 2

    solution = least_squares(
        all_angle_errors,
        both(START),
        jac=lambda x, spans, names: np.concatenate([angle_errors(x, span, names, True)[1] for span in spans]),
        args=(spans, names),
        x_scale=both(SCALE),
        bounds=(np.full(len(names), 1e-9), both(HIGHEST)),
    )
    freedom = len(solution.fun) - len(names)
    covariance = np.linalg.inv(solution.jac.T @ solution.jac) * (solution.fun @ solution.fun) / freedom
    half = student.ppf(0.975, freedom) * np.sqrt(np.diag(covariance))
    table = {
        name: {"value": common.rounded(value, 3), "±": common.rounded(width, 2)}
        for name, value, width in zip(names, solution.x, half, strict=True)
    }
    return table, solution.x


def measure(fitted_spans: list[Span], unseen: list[Span]) -> dict[str, Any]:
    """Fit models to ``fitted_spans``, with dry friction and without; return title of the model → its results.

    The results are parameters and root mean square errors [rad] over ``fitted_spans`` and over ``unseen``.
    """
    rows: dict[str, Any] = {}
    for title, dry in (("viscous and dry friction", True), ("viscous friction only", False)):
        table, x = fitted(fitted_spans, dry)
        errors = (all_angle_errors(x, spans, list(table)) for spans in (fitted_spans, unseen))
        rms = [common.rounded(math.sqrt(float((error**2).mean())), 3) for error in errors]
        rows[title] = {"parameters": table, "rms, fitted": rms[0], "rms, unseen": rms[1]}
    return rows


def main() -> None:
    """Fit and judge both models, and save the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="…/design_C.1/sys_id/20230629 of double_pendulum")
    folder = parser.parse_args().folder
    started = common.environment()
    runs = [read(folder / name / "trajectory.csv") for name in (FITTED, UNSEEN)]
    settings = {"data": "dfki-ric-underactuated-lab/double_pendulum 1e8544e", "span [s]": SPAN}
    common.save("measured_arm", started, settings | {"runs": [FITTED, UNSEEN]}, measure(*runs))


if __name__ == "__main__":
    main()

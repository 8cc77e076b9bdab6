"""What derivatives by all parameters together must obey, whatever happens: units and the place of the origin.

If the unit of mass, length or time is changed, every quantity changes by a known power of the factor. The
derivative by that factor is Euler's relation for homogeneous functions: Σ a_p p ∂y/∂p = a_y y, with the
powers a of the parameters and of y. It holds through any number of impacts and needs no reference solution.
For time, y also moves on: Σ a_p p ∂y/∂p + t ẏ = a_y y.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

MASS, LENGTH, TIME = range(3)
UNITS = {"mass": MASS, "length": LENGTH, "time": TIME}
_PARAMETERS = {
    "gravity": (0, 1, -2),
    "mass": (1, 0, 0),
    "length": (0, 1, 0),
    "center_of_mass": (0, 1, 0),
    "inertia": (1, 2, 0),
    "joint_damping": (1, 2, -1),
    "joint_stiffness": (1, 2, -2),
    "joint_rest_angle": (0, 0, 0),
    "joint_min": (0, 0, 0),
    "joint_max": (0, 0, 0),
    "box": (0, 1, 0),
    "restitution": (0, 0, 0),
    "radius": (0, 1, 0),
    "torque": (1, 2, -2),
    "force": (1, 1, -2),
}
_VARIABLES = {
    "x": (0, 1, 0),
    "y": (0, 1, 0),
    "vx": (0, 1, -1),
    "vy": (0, 1, -1),
    "angle": (0, 0, 0),
    "angular_velocity": (0, 0, -1),
}
_FIELDS = {
    "onset": (0, 0, 1),
    "end": (0, 0, 1),
    "impact_speed": (0, 1, -1),
    "separation_speed": (0, 1, -1),
    "peak_force": (1, 1, -2),
    "max_penetration": (0, 1, 0),
    "effective_mass": (1, 0, 0),
    "impulse": (1, 1, -1),
}
# of a joint at a stop: angles, their rates, and moments
_AT_STOPS = {
    "onset": (0, 0, 1),
    "end": (0, 0, 1),
    "impact_speed": (0, 0, -1),
    "separation_speed": (0, 0, -1),
    "peak_force": (1, 2, -2),
    "max_penetration": (0, 0, 0),
    "effective_mass": (1, 2, 0),
    "impulse": (1, 2, -1),
}
RATES = {"x": "vx", "y": "vy", "vx": "ax", "vy": "ay", "angle": "angular_velocity"}
RATES |= {"angular_velocity": "angular_acceleration"}


def applicable(laws: Iterable[str]) -> list[tuple[str, str]]:
    """The pairs of law and unit for which the relation holds."""
    # the restitution of Kuwabara and Kono is that at 1 m/s, a speed that is no parameter
    return [(law, unit) for law in laws for unit in UNITS if "kuwabara_kono" not in law or unit == "mass"]


def weights(values: Mapping[str, float], unit: int, exponent: float) -> np.ndarray:
    """a_p p of each parameter, by name, for the exponent of the contact law of walls."""

    def power(name: str) -> float:
        if name.endswith(".stiffness"):
            return ((1.0, 2.0, -2.0) if name == "stop.stiffness" else (1.0, 1.0 - exponent, -2.0))[unit]
        known = _PARAMETERS | _VARIABLES
        parts = [part.split("[", 1)[0] for part in name.split(".")]
        return next(known[part][unit] for part in parts if part in known)

    return np.array([power(name) * value for name, value in values.items()])


def state_residual(
    outputs: Mapping[str, np.ndarray],
    slopes: Mapping[str, np.ndarray],
    times: np.ndarray,
    weight: np.ndarray,
    unit: int,
) -> float:
    """By how much the outputs of the state miss the relation, over the largest term of each.

    Args:
        outputs: of the state and its rates, name → shape (T,).
        slopes: of the state by all parameters, name → shape (T, P).
        times: [s], shape (T,).
        weight: a_p p of the parameters.
        unit: MASS, LENGTH or TIME.
    """
    worst = 0.0
    for name, slope in slopes.items():
        head, _, last = name.rpartition(".")
        right = _VARIABLES[last][unit] * outputs[name]
        if unit == TIME:
            right = right - times * outputs[f"{head}.{RATES[last]}"]
        worst = max(worst, _missed(slope * weight, right))
    return worst


def impact_residual(
    impacts: Mapping[str, np.ndarray],
    slopes: Mapping[str, np.ndarray],
    at_stops: np.ndarray,
    weight: np.ndarray,
    unit: int,
) -> float:
    """The same of the impacts that are over, at walls and at stops. Their times are quantities, too."""
    worst, over = 0.0, np.isfinite(impacts["end"])
    for kind, powers in ((over & ~at_stops, _FIELDS), (over & at_stops, _AT_STOPS)):
        for field, slope in slopes.items():
            values = impacts[field][kind]
            if np.isfinite(values).all():
                least = 1e-3 * np.abs(values).max(initial=0.0)
                worst = max(worst, _missed(slope[kind] * weight, powers[field][unit] * values, least))
    return worst


def _missed(terms: np.ndarray, right: np.ndarray, least: float = 0.0) -> float:
    """The error of Σ a_p p ∂y/∂p over the largest term, or over the least size that counts."""
    error = np.abs(terms.sum(-1) - right).max(initial=0.0)
    largest = max(np.abs(terms).max(initial=0.0), np.abs(right).max(initial=0.0), least)
    return float(error / largest) if largest else 0.0


def shifted(names: Sequence[str], axis: str) -> np.ndarray:
    """1 for the parameters that move all there is along an axis: Σ ∂y/∂p is 1 for that coordinate, else 0."""
    ends = {"x": (".x", ".x_min", ".x_max"), "y": (".y", ".y_min", ".y_max")}[axis]
    moved = ("initial", "box", "wall")
    return np.array([float(name.split(".")[0] in moved and name.endswith(ends)) for name in names])

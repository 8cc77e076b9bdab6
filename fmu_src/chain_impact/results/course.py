"""What happens within one impact: force, penetration and speed, at times between the rows of its result."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chain_impact.results.joint_stops import at_stop
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.names import STOPS
from chain_impact.variables.model import Model

SAMPLES = 400  # of an impact
MANY = 4000  # the same where a contact lasts long
SOON = 1e-6  # of an impact, the first of more times shortly after its onset

Rerun = Callable[[np.ndarray], np.ndarray]
"""Outputs at times [s] that increase, shape (S,), from the same run once more."""


@dataclass(frozen=True, eq=False)
class Course:
    """One impact over time; at a stop of a joint all is that of its angle.

    Attributes:
        time: from the onset to the end, shape (S,) [s]; empty for an impulse.
        force: shape (S,) [N].
        penetration: shape (S,) [m].
        speed: of penetration, positive when closing, shape (S,) [m/s].
        energy_lost: dissipated from just before the onset until just after the end, by all there is [J].
    """

    time: np.ndarray
    force: np.ndarray
    penetration: np.ndarray
    speed: np.ndarray
    energy_lost: float


def course_of(
    model: Model, rerun: Rerun | None, impact: np.void, *, until: float = math.nan, near: float = 0.0
) -> Course:
    """Return the course of an impact, a row of ``Result.impacts``.

    The run is repeated up to there with rows within the impact: it is the same run to the last bit, as rows
    do not change the solution.

    Args:
        model: of the scene as it was simulated.
        rerun: ``Result.rerun``.
        impact: the row.
        until: the end of the course where the impact has none [s].
        near: so long after the onset [s] are the times of a contact that lasts longer close together.

    Raises:
        ValueError: when the result cannot be run once more.
    """
    if rerun is None:
        raise ValueError(f"{model.scene.name}: only a result of simulate() has the course of an impact")
    onset, end = float(impact["onset"]), float(impact["end"])
    end = until if math.isnan(end) else end
    inside = np.linspace(onset, end, SAMPLES if end > onset else 0)
    if 0.0 < near < end - onset:
        shares = np.union1d(np.geomspace(SOON, 1.0, SAMPLES), np.linspace(0.0, 1.0, MANY))
        times = np.union1d((end - onset) * shares, np.linspace(0.0, near, SAMPLES))
        inside = np.unique((onset + times).clip(onset, end))
    before, after = max(0.0, math.nextafter(onset, 0.0)), math.nextafter(end, math.inf)
    outputs = rerun(np.concatenate([[before], inside, [after]]))
    at, sign = place_of(model, impact)
    within = outputs[1 : 1 + len(inside)]
    speed = within["penetration_rate"][:, at].copy()
    if len(speed):  # the outputs have none where there is no penetration
        speed[0] = impact["impact_speed"]
    if len(speed) == len(inside) > 1 and not math.isnan(impact["end"]):
        speed[-1] = -impact["separation_speed"]
    return Course(
        time=inside[: len(within)],
        force=(sign * within["force"][:, at]).clip(0.0),
        penetration=within["penetration"][:, at].clip(0.0),
        speed=speed,
        energy_lost=float(outputs["dissipated"][-1] - outputs["dissipated"][0]),
    )


def place_of(model: Model, impact: np.void) -> tuple[int, float]:
    """Where the outputs have the force of an impact, and its sign there; see ``_stops`` of the outputs."""
    pairs, scene = model.candidates, model.scene
    if not at_stop(scene, impact["wall"]):
        return pairs.index((impact["point"], impact["wall"])), 1.0
    first = len(point_wall_pairs(scene))
    of_joint = [joint for joint, _ in pairs[first:]].index(impact["point"])
    return first + of_joint, 1.0 if scene.wall_names[impact["wall"]] == STOPS[0] else -1.0

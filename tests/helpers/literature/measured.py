"""Measured motions, compared with a second solution and with our simulation.

``models/<model>/measured.csv`` has the measured values under the names of the FMU's variables, in SI units.
docs/validation.md and the pages of the models name the sources.
"""

from __future__ import annotations

import csv
import math

import numpy as np

from chain_impact import load_scene
from chain_impact.scene.files.models import models_folder
from tests.helpers.literature.figures import Figure, Problem, problem, run
from tests.helpers.models.derivatives import differentiate


def measured(model: str) -> dict[str, np.ndarray]:
    """Return the columns of the measured values of a model: ``time`` [s] and variables."""
    with (models_folder() / model / "measured.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


def heard_impacts() -> np.ndarray:
    """Return the times [s] at which the golf ball was heard on the floor."""
    columns = measured("golf_ball")
    return columns["time"][columns["point[0].y"] == 0.0]


def golf_ball(tolerance: float) -> Problem:
    """Return figures for the times of heard impacts, with the restitution from heights as the model's."""
    model, numbers = "golf_ball", (2, 3, 5, 9)
    result = run(model, tolerance)
    scene = load_scene(model)
    gravity, height, e = -scene.gravity[1], scene.initial.position[1], scene.contact.restitution
    fall, onsets = math.sqrt(2 * height / gravity), heard_impacts()
    figures = []
    for n in numbers:
        # flights of the duration 2 v eᵏ/g with v = g · fall
        exact = fall + 2 * fall * sum(e**k for k in range(1, n))
        ours = result.impacts["onset"][n - 1]
        heard = f"{onsets[n - 1]:.4f}"
        figures.append(Figure(f"impact {n}: time [s]", heard, exact, ours, 1e-11, 0.07, measured=True))
    return problem(model, result, figures)


def triple_pendulum(tolerance: float) -> Problem:
    """Return figures for angles that encoders measured, and of the chain with the published parameters."""
    model, chosen_times = "triple_pendulum", (1.0, 2.0, 5.0)
    result = run(model, tolerance)
    exact = differentiate(load_scene(model), (), chosen_times).values
    columns = measured(model)
    figures = []
    for k, time in enumerate(chosen_times):
        row = round(time * 100)
        for link in (1, 2, 3):
            name = f"link[{link}].angle"
            second, ours, text = exact[name][k], result[name][row], f"{columns[name][row]:.4f}"
            quantity = f"angle of link {link} at {time:g} s [rad]"
            figures.append(Figure(quantity, text, second, ours, 1e-9, 0.05, measured=True))
    return problem(model, result, figures)

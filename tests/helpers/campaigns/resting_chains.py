"""Random chains that fall on a rough floor or slope and come to rest: derivatives of their final positions.

``python -m tests.helpers.campaigns.resting_chains FIRST COUNT`` counts the verdicts on the derivatives.
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np

from chain_impact import simulate
from chain_impact.results.result import Result
from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.simulation.errors import SimulationError
from tests.helpers.campaigns.random_parts import Draw
from tests.helpers.scenes.problems import of_law

LAWS = ("zhang_sharf", "hunt_crossley", "flores", "tsuji", "lankarani_nikravesh", "kelvin_voigt")
PARAMETERS = ("contact.friction", "initial.vx")
RESTS = 1e-6  # [m/s or rad/s] the largest speed at rest
SIZES = (1e-6, 1e-5)  # sizes of the differences: the rest position of a chain is known to about 1e-10 rad
# largest distance of two differences that count as converged, over the largest derivative of a position
CONVERGED = 1e-2
LARGEST_ERROR = 2e-2  # largest error of a derivative, over the largest derivative of a position
NAN, WRONG, CORRECT, OPEN, MOVES = (
    "no derivative",
    "wrong",
    "right",
    "differences do not converge",
    "does not rest",
)


def thrown(seed: int) -> Scene:
    """Return the scene of a seed: one to three links, some with dry joints, above a rough floor or slope."""
    draw, links = Draw(seed), []
    for i in range(draw.whole(1, 3)):
        link = {"length": draw.real(0.15, 0.4), "mass": draw.real(0.2, 1.0)}
        if i > 0:
            link["joint_damping"] = draw.real(0.005, 0.08)
            link["joint_friction"] = draw.real(0.05, 0.4) * draw.chance(0.4)
        links.append(link)
    size, friction = sum(link["length"] for link in links), draw.real(0.3, 0.8)
    contact = of_law(draw.one(LAWS)) | {
        "restitution": draw.real(0.1, 0.5),
        "stiffness": draw.power(1e4, 1e6),
        "friction": friction,
        "static_friction": friction * draw.real(1.0, 1.3) * draw.chance(0.4),
    }
    slope = {"name": "slope", "point": [0.0, 0.0], "angle": draw.real(0.03, 0.25)}
    ground = {"walls": [slope]} if draw.chance(0.4) else {"box": {"y_min": 0.0}}
    table = {
        "name": "Resting",
        "chain": {"base": "free", "links": links},
        "contact": contact,
        "initial": {
            "position": [0.0, draw.real(0.05, 0.2) + 0.5 * size],
            "velocity": [draw.real(-2.0, 2.0), draw.real(-1.0, 0.5)],
            "angles": [draw.real(-0.5, 0.5) for _ in links],
            "angular_velocities": [draw.real(-2.0, 2.0) for _ in links],
        },
        "solver": {"tolerance": 1e-9, "work_limit": 1e8},
        "simulation": {"stop_time": 4.0, "step_size": 0.02},
    }
    return scene_from_dict({**table, **ground}, "resting")


def names_of(scene: Scene) -> list[str]:
    links = range(1, len(scene.chain.links) + 1)
    return ["point[0].x", "point[0].y", *(f"link[{i}].angle" for i in links)]


def rests(scene: Scene, result: Result) -> bool:
    links = range(1, len(scene.chain.links) + 1)
    rates = ["point[0].vx", "point[0].vy", *(f"link[{i}].angular_velocity" for i in links)]
    return all(abs(result[name][-1]) < RESTS for name in rates)


def shares_left_open(result: Result) -> list[float]:
    """Return the errors of derivatives that a run reports, over the largest derivative."""
    limits = [limit for limit in result.sensitivity_limits if "off by " in limit]
    return [float(limit.split("off by ")[1].split()[0]) for limit in limits]


def check(seed: int) -> list[str]:
    """Return the verdict on the derivatives at rest for each of PARAMETERS; [MOVES] without a rest.

    A run that fails counts as one without a rest.
    """
    scene = thrown(seed)
    try:
        result = simulate(scene, sensitivities=PARAMETERS)
        if not rests(scene, result):
            return [MOVES]
        return [verdict(scene, result, name) for name in PARAMETERS]
    except SimulationError:
        return [MOVES]


def verdict(scene: Scene, result: Result, parameter: str) -> str:
    """Return NAN, WRONG, CORRECT or OPEN for the derivatives at rest by a parameter.

    They are compared with central differences of runs at a smaller tolerance; OPEN: these do not converge.
    """
    names, near = names_of(scene), []
    for size in SIZES:
        width = size * max(1.0, abs(scene.values[parameter]))
        more, less = (
            simulate(
                scene.with_values(
                    {parameter: scene.values[parameter] + sign * width, "solver.tolerance": 1e-12}
                )
            )
            for sign in (1.0, -1.0)
        )
        near.append(np.array([more[name][-1] - less[name][-1] for name in names]) / (2.0 * width))
    largest = np.abs(near[1]).max() + 1e-6
    if not np.abs(near[0] - near[1]).max() < CONVERGED * largest:
        return OPEN
    slopes = np.array([result.sensitivity(name, parameter)[-1] for name in names])
    if np.isnan(slopes).any():
        return NAN
    return CORRECT if np.abs(slopes - near[0]).max() < LARGEST_ERROR * largest else WRONG


if __name__ == "__main__":
    first, count = int(sys.argv[1]), int(sys.argv[2])
    counts: Counter[str] = Counter()
    for seed in range(first, first + count):
        verdicts = check(seed)
        counts.update(verdicts)
        if WRONG in verdicts or NAN in verdicts:
            print(seed, *verdicts)
    print(dict(counts))

"""Further problems with values that other programs store for their tests: scenes, second solutions and ours.

Three balls of Siconos (siconos-tutorials, commit b6c9bfd) and a block of Solfec (solfec-1.0, commit 287fba1).
Units are SI throughout.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from chain_impact import Result
from chain_impact.scene.scene import Scene
from tests.helpers.literature.figures import Figure, Problem, problem, run
from tests.helpers.scenes.problems import RIGID, build, contact_table, rest_depth

WEIGHT = 9.81  # [N] the weight of 1 kg


def ball(height: float, speed: float, gravity: float, stop: float, box: Any, **contact: Any) -> Scene:
    """Return a point mass of 1 kg that moves up at a speed."""
    link = {"length": 1.0, "mass": 1.0, "center_of_mass": 0.0, "inertia": 1.0}
    initial = {"position": [0.0, height], "angles": [0.0], "velocity": [0.0, speed]}
    table = contact_table(points=[0], **contact)
    return build("SiconosBall", [link], initial, box, table, gravity=gravity, stop_time=stop)


# --- a ball between floor and ceiling, BouncingBallED-TwoContacts ------------------------------------------

# time [s] → height [m]
BETWEEN = {
    1.0: "1.07922134938",
    2.0: "0.586634631357",
    3.0: "0.594515381278",
    5.0: "0.0687654906721",
}


def ball_between_walls(tolerance: float) -> Problem:
    """Return figures for a ball thrown up at 10 m/s from 1 m under a ceiling at 1.5 m.

    The restitution is 0.8, and g = 10 m/s².
    """
    box = {"y_min": 0.0, "y_max": 1.5}
    scene = ball(1.0, 10.0, 10.0, 6.0, box, model=RIGID, restitution=0.8, minimum_impact_speed=1e-9)
    result = run("SiconosBall", tolerance, scene, output_step=0.5)
    flight = between(1.0, 10.0, 10.0, 1.5, 0.8)
    figures = [
        Figure(
            f"height at {time:g} s [m]",
            stored,
            flight(time),
            result["point[0].y"][round(2 * time)],
            1e-10,
            1e-11,
        )
        for time, stored in BETWEEN.items()
    ]
    return problem("ball_between_walls", result, figures)


def between(
    height: float, speed: float, gravity: float, ceiling: float, restitution: float
) -> Callable[[float], float]:
    """Return the height over time of a ball between two rigid walls: flights of parabolas."""

    def at(time: float) -> float:
        y, v, now = height, speed, 0.0
        while True:
            # the time at which the ball is on the floor
            down = (v + math.sqrt(v * v + 2 * gravity * y)) / gravity
            root = v * v - 2 * gravity * (ceiling - y)
            up = (v - math.sqrt(root)) / gravity if v > 0 and root > 0 else math.inf
            step = min(up, down)
            if now + step > time:
                t = time - now
                return y + v * t - gravity * t * t / 2
            y, v, now = (ceiling if up < down else 0.0), -restitution * (v - gravity * step), now + step

    return at


# --- a ball that stays on the floor, BouncingBallED-withRestingContact -------------------------------------


def ball_stays(tolerance: float) -> Problem:
    """Return figures for a ball dropped from 1 m with e = 0: landing time and speed, and the later force."""
    scene = ball(1.0, 0.0, WEIGHT, 8.5, {"y_min": 0.0}, model=RIGID, restitution=0.0)
    result = run("SiconosBall", tolerance, scene, output_step=0.5)
    (impact,) = result.impacts
    rows = (
        ("impact: time [s]", "0.451523640986", math.sqrt(2 / WEIGHT), impact["onset"]),
        ("impact: speed [m/s]", "4.42944691807", math.sqrt(2 * WEIGHT), impact["impact_speed"]),
        ("force of the floor at 8.5 s [N]", "9.81", WEIGHT, result["contact[0].y_min.force"][-1]),
    )
    return problem("ball_stays", result, [Figure(*row, 1e-12, 1e-11) for row in rows])


# --- an elastic floor and a rigid ceiling, BouncingBallTS-CompliantContact ----------------------------------

FLOOR, CEILING, SPRING = 0.1, 0.7, 100.0  # positions of floor and ceiling [m], stiffness of the floor [N/m]
SOFT, STIFF = 1e12, 1e14  # [N/m] two stiffnesses of the ceiling
# time [s] → height [m], by time stepping of 0.5 ms
COMPLIANT = {
    0.5: "-0.199951654",
    2.0: "-0.233550721",
}


def ball_on_a_spring(tolerance: float) -> Problem:
    """Return figures for a ball dropped from 1 m onto a linear elastic floor, under a rigid ceiling, e = 1.

    The ball starts above the ceiling. The time stepping of the source lets it through the ceiling, so our
    simulation begins when the ball is below the ceiling, with its speed at that time.
    """
    passed, speed = math.sqrt(2 * (1.0 - CEILING) / WEIGHT), math.sqrt(2 * WEIGHT * (1.0 - CEILING))
    times = [time - passed for time in COMPLIANT]

    def heights(stiffness: float) -> tuple[np.ndarray, Result]:
        contact = {"model": "hertz", "exponent": 1.0, "restitution": 1.0, "stiffness": SPRING}
        contact["wall"] = {"y_max": {"stiffness": stiffness}}
        scene = ball(CEILING, -speed, WEIGHT, 10.0, {"y_min": FLOOR, "y_max": CEILING}, **contact)
        runs = [run("SiconosBall", tolerance, scene, stop_time=t, output_step=t) for t in times]
        return np.array([result["point[0].y"][-1] for result in runs]), runs[-1]

    (soft, _), (stiff, result) = heights(SOFT), heights(STIFF)
    ratio = math.sqrt(STIFF / SOFT)  # ratio of the durations of an impact
    limit = (ratio * stiff - soft) / (ratio - 1.0)
    figures = [
        Figure(f"height at {time:g} s [m]", stored, on_a_spring(elapsed, speed), ours, 1e-8, 0.14, True)
        for (time, stored), elapsed, ours in zip(COMPLIANT.items(), times, limit, strict=True)
    ]
    return problem("ball_on_a_spring", result, figures)


def on_a_spring(time: float, speed: float) -> float:
    """Return the height [m] of a ball that leaves the ceiling downwards.

    The motion is periodic without losses.
    """
    drop = CEILING - FLOOR
    lands = math.sqrt(speed**2 + 2 * WEIGHT * drop)
    fall = (lands - speed) / WEIGHT
    omega, sag = math.sqrt(SPRING), WEIGHT / SPRING
    # on the spring: y − FLOOR + sag = sag cos ωt − (lands/ω) sin ωt, until the ball is back at FLOOR
    contact = 2 * (math.pi - math.atan2(lands / omega, sag)) / omega
    t = time % (2 * fall + contact)
    if t < fall:
        return CEILING - speed * t - WEIGHT * t * t / 2
    t -= fall
    if t < contact:
        return FLOOR - sag + sag * math.cos(omega * t) - lands / omega * math.sin(omega * t)
    t -= contact
    return FLOOR + lands * t - WEIGHT * t * t / 2


# --- a block that sticks and slides, block-sliding of Solfec, after Potra et al. 2006 ----------------------

PUSH, GRIP = 8.0, 0.8 * WEIGHT  # [N] amplitude of the push, and limit of friction
# time [s], whether the value is the velocity [m/s] or x − 3 m → value, by time stepping of 1 ms
BLOCK = {
    (2.001, False): "0.00435080898",
    (5.001, False): "-0.00870878769",
    (8.001, False): "0.00441870359",
    (0.151, True): "0.0183699246991",
    (3.151, True): "-0.021223275136",
    (6.151, True): "0.00288766940501",
}


def sliding_block(tolerance: float) -> Problem:
    """Return figures for a block of 1 kg on a table, pushed by 8 cos t; µ = 0.8. Here the block is a rod.

    At first the rod sinks into its floor while it slides. The missing normal impulse equals the momentum of
    sinking, so the rod moves µ times the depth too far; this distance is subtracted.
    """
    link = {"length": 0.3, "mass": 1.0}
    contact = contact_table(stiffness=1e8, restitution=0.2, friction=0.8)
    box, initial = {"y_min": 0.0}, {"angles": [0.0]}
    inputs = {"tip_force": True}
    scene = build("Block", [link], initial, box, contact, gravity=WEIGHT, stop_time=8.001, inputs=inputs)
    push = {"tip.force.x": lambda time: PUSH * math.cos(time)}
    result = run("Block", tolerance, scene, output_step=1e-3, inputs=push)
    figures, sunk = [], 0.8 * rest_depth(scene, 2)
    for (time, moving), stored in BLOCK.items():
        quantity = f"velocity at {time} s [m/s]" if moving else f"displacement at {time} s [m]"
        row = round(1e3 * time)
        ours = result["point[0].vx"][row] if moving else result["point[0].x"][row] - sunk
        second = float(slid(time)[moving])
        figures.append(Figure(quantity, stored, second, ours, 2e-9, 2e-4, True))
    return problem("sliding_block", result, figures)


def slid(time: float) -> tuple[float, float]:
    """Return displacement [m] and velocity [m/s] of the rigid block.

    The block slides from the time t₀ at which the push exceeds the static friction.

    From t₀ on, with the sign s of the push there: v = 8 (sin t − sin t₀) − s 7.848 (t − t₀), until v = 0.
    """
    early, moved = math.acos(GRIP / PUSH), 0.0
    for half in range(math.ceil(time / math.pi) + 1):
        start, sign = max(0.0, half * math.pi - early), (-1.0) ** half

        def speed(t: float, start: float = start, sign: float = sign) -> float:
            return PUSH * (math.sin(t) - math.sin(start)) - sign * GRIP * (t - start)

        end = brentq(speed, half * math.pi + 1e-3, half * math.pi + 1.0, xtol=1e-15)
        if time <= start:
            break
        t = min(time, end)
        way = math.cos(start) - math.cos(t) - math.sin(start) * (t - start)
        moved += PUSH * way - sign * GRIP * (t - start) ** 2 / 2
        if time < end:
            return moved, speed(time)
    return moved, 0.0

"""Questions from public threads about other programs: the question, our scene, a closed form and our figure.

If the scene of a question is not a planar chain, our scene contains the effect in question. Units are SI.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from chain_impact import Result, simulate
from chain_impact.scene.scene import Scene, scene_from_dict
from tests.helpers.scenes.friction import SLOPE, sled
from tests.helpers.scenes.problems import GRAVITY, RIGID, build, contact_table, ghost_spinner

# the difference of a coefficient of friction from the coefficient that just holds, over this coefficient
NEARLY = 0.01


@dataclass(frozen=True)
class Question:
    """One question.

    Attributes:
        threads: owner/name#number on GitHub.
        asked: the question or observation in the thread.
        scene: our scene in words, and the figure with its unit.
        exact: the closed form of the figure.
        ours: function that simulates our scene and returns the figure.
        held: the largest allowed error of the figure, over the closed form, or absolute if that is 0.
    """

    threads: tuple[str, ...]
    asked: str
    scene: str
    exact: float
    ours: Callable[[], float]
    held: float = 1e-9


def ball(box: dict[str, float], y: float, speed: float, gravity: float = 0.0, **more: Any) -> Scene:
    """Return a point mass of 1 kg at x = 0, thrown up at a speed, or along x without floor and ceiling."""
    stop = more.pop("stop_time")
    velocity = [0.0, speed] if {"y_min", "y_max"} & box.keys() else [speed, 0.0]
    initial = {"position": [0.0, y], "angles": [0.0], "velocity": velocity}
    link = {"length": 1.0, "mass": 1.0, "center_of_mass": 0.0, "inertia": 1.0}
    contact = contact_table(points=[0], **more)
    return build("Ball", [link], initial, box, contact, gravity=gravity, stop_time=stop)


def onset(scene: Scene, number: int = 0) -> float:
    """Return the onset [s] of an impact."""
    return float(simulate(scene).impacts["onset"][number])


def thrown_under_a_ceiling(overlap: float = 1e-9, rise: float = 0.5) -> Question:
    """Return the figure for a parabola whose top is slightly beyond a ceiling."""
    top = 0.5 * GRAVITY * rise**2
    scene = ball({"y_max": top - overlap}, 0.0, GRAVITY * rise, GRAVITY, stop_time=1.0, model="hertz")
    return Question(
        ("scipy/scipy#9228",),
        "`solve_ivp` misses two of three roots.",
        "The path of a ball goes 1 nm beyond the ceiling. Impact [s]",
        rise - math.sqrt(2.0 * overlap / GRAVITY),
        lambda: onset(scene),
        1e-8,
    )


def spinning_rod(overlap: float = 1e-6) -> Question:
    """Return the figure for a rod whose ends come below a floor for a moment at each turn."""
    scene, exact = ghost_spinner(-overlap)
    return Question(
        ("patrick-kidger/diffrax#507",),
        "An event is missed where a step has two changes of sign.",
        "The end of a spinning rod comes 1 µm below the floor. Contact [s]",
        float(exact.onset[0]),
        lambda: onset(scene),
        1e-8,
    )


def goes_on(number: int = 30) -> Question:
    """Return the figure for impacts one after the other in one run."""
    fall = math.sqrt(2.0 / GRAVITY)
    exact = fall + 2.0 * fall * sum(0.9**k for k in range(1, number))
    scene = ball({"y_min": 0.0}, 1.0, 0.0, GRAVITY, stop_time=9.0, model=RIGID, restitution=0.9)
    return Question(
        ("patrick-kidger/diffrax#492",),
        "Going on after an event is left to the user.",
        f"A ball with e = 0.9 falls from 1 m. Impact {number} [s]",
        exact,
        lambda: onset(scene, number - 1),
    )


def speed_of_an_impact() -> Question:
    """Return the figure for the speed at the onset, not at the end of a step."""
    scene = ball({"y_min": 0.0}, 1.0, 0.0, GRAVITY, stop_time=1.0)
    return Question(
        ("hannorein/rebound#862",),
        "Are velocities in a collision handler those of the collision?",
        "A ball falls from 1 m; communication step 0.1 s. Impact speed [m/s]",
        math.sqrt(2.0 * GRAVITY),
        lambda: float(simulate(scene, output_step=0.1).impacts["impact_speed"][0]),
    )


def prescribed_restitution() -> Question:
    """Return the figure for a law with a force that realises e."""
    scene = ball({"y_min": 0.0}, 1e-3, -1.0, stop_time=0.1, restitution=0.8)

    def ratio() -> float:
        impact = simulate(scene).impacts[0]
        return float(impact["separation_speed"] / impact["impact_speed"])

    return Question(
        ("google-deepmind/mujoco#2080",),
        "Can a coefficient of restitution be given?",
        "`zhang_sharf`, e = 0.8, 1 m/s. Speed after / before",
        0.8,
        ratio,
    )


def contact_force() -> Question:
    """Return the figure for a spring as a contact."""
    scene = ball(
        {"y_min": 0.0}, 1e-3, -1.0, stop_time=0.1, model="hertz", exponent=1.0, stiffness=1e6, restitution=1.0
    )
    return Question(
        ("google-deepmind/mujoco#2630",),
        "Contact forces are a quarter of the expected ones.",
        "1 kg, 1 m/s, 10⁶ N/m. Peak force [N]",
        1000.0,
        lambda: float(simulate(scene).impacts["peak_force"][0]),
    )


def elastic_bounces(count: int = 20) -> Question:
    """Return the figure for the height after many elastic bounces."""
    fall = math.sqrt(20.0 / GRAVITY)
    scene = ball({"y_min": 0.0}, 10.0, 0.0, GRAVITY, stop_time=2 * count * fall, model=RIGID, restitution=1.0)
    return Question(
        ("dojo-sim/Dojo.jl#56", "jrouwe/JoltPhysics#1286", "bulletphysics/bullet3#1530"),
        "Elastic impacts: missing; gain height (closed); lose it (closed).",
        f"A ball with e = 1 falls from 10 m. Height after {count} bounces [m]",
        10.0,
        lambda: float(simulate(scene)["point[0].y"][-1]),
    )


def on_a_slope(part: float, stop: float, **more: Any) -> Result:
    """Return the run, until ``stop`` [s], of a rod that starts at rest on a slope.

    Its coefficient of friction is ``part`` times the smallest holding coefficient.
    """
    values = {"initial.vx": 0.0, "initial.vy": 0.0, "contact.friction": part * math.tan(SLOPE)}
    return simulate(sled(**values), stop_time=stop, tolerance=1e-10, **more)


def holds() -> Question:
    """Return the figure for a rod that friction just holds, for an hour."""

    def drift() -> float:
        result = on_a_slope(1.0 + NEARLY, 3600.0, output_step=1.0)
        x, y = (result[f"point[0].{axis}"][2:] for axis in "xy")  # the rows from 2 s on
        return float(math.hypot(x[-1] - x[0], y[-1] - y[0]))

    return Question(
        ("google-deepmind/mujoco#3328",),
        "A pinched capsule creeps, 50 to 2,300 µm/s.",
        "A rod rests on a slope, µ = 1.01 tan α. Drift from 2 s to an hour [m]",
        0.0,
        drift,
        1e-12,
    )


def slides() -> Question:
    """Return the figure for a rod that friction just does not hold."""

    def speed() -> float:
        result = on_a_slope(1.0 - NEARLY, 2.0)
        return float(math.hypot(result["point[0].vx"][-1], result["point[0].vy"][-1]))

    return Question(
        ("newton-physics/newton#3943",),
        "No µ holds a static load.",
        "The same rod, µ = 0.99 tan α, slides. Speed after 2 s [m/s]",
        2.0 * GRAVITY * NEARLY * math.sin(SLOPE),
        speed,
        1e-6,
    )


def derivative(scene: Scene, output: str, name: str, **more: Any) -> float:
    """Return the derivative of an output by the parameter ``name``, at the end of the run."""
    result = simulate(scene, sensitivities=[name], **more)
    return float(result.sensitivity(output, name)[-1])


def later_if_higher() -> Question:
    """Return the figure for a ball without gravity: if it starts higher, it ends lower."""
    scene = ball({"y_min": 0.0}, 3.0, -5.0, stop_time=1.0, model=RIGID, restitution=1.0)
    return Question(
        ("google/brax#317",),
        "The final height of an elastic ball jumps with the first one.",
        "An elastic ball, no gravity. ∂(final height)/∂(first height)",
        -1.0,
        lambda: derivative(scene, "point[0].y", "initial.y"),
    )


def long_horizon(torque: float = 0.5, inertia: float = 0.2, stop: float = 1000.0) -> Question:
    """Return the figure for a wheel that a torque turns for a long time."""
    link = {"length": 1.0, "mass": 1.0, "center_of_mass": 0.0, "inertia": inertia}
    table = {
        "name": "Wheel",
        "chain": {"base": "pinned", "links": [link]},
        "inputs": {"joint_torques": True},
        "initial": {"angles": [0.0]},
        "simulation": {"stop_time": stop, "step_size": stop},
    }
    scene = scene_from_dict(table, "wheel")
    return Question(
        ("NVIDIA/warp#650",),
        "Over a long time, gradients by inertia leave the analytic ones.",
        "A torque turns a wheel for 1000 s. ∂(angle)/∂(inertia)",
        -torque * stop**2 / (2.0 * inertia**2),
        lambda: derivative(scene, "link[1].angle", "link[1].inertia", inputs={"joint[1].torque": torque}),
    )


def position_of_the_wall() -> Question:
    """Return the figure for a derivative by a wall's position: of a ball's place after an elastic impact."""
    scene = ball({"x_max": 0.52}, 0.0, 1.0, stop_time=1.0, model=RIGID, restitution=1.0)
    return Question(
        ("keenon/nimblephysics#97",),
        "Gradients through the impact of two elastic balls are wrong.",
        "One ball and a wall, elastic. ∂(final x)/∂(wall)",
        2.0,
        lambda: derivative(scene, "point[0].x", "box.x_max"),
    )


def restitution_of_a_speed() -> Question:
    """Return the figure for a derivative by e: of the speed after an impact, with a force law."""
    scene = ball({"y_min": 0.0}, 1e-3, -2.0, stop_time=0.1, restitution=0.8)

    def slope() -> float:
        result = simulate(scene, sensitivities=["contact.restitution"])
        return float(result.impact_sensitivity("separation_speed", "contact.restitution")[0])

    return Question(
        ("google-deepmind/mujoco#2841",),
        "The gradient of the speed after a collision is NaN (closed).",
        "A ball at 2 m/s, `zhang_sharf`. ∂(speed after)/∂e [m/s]",
        2.0,
        slope,
        1e-7,
    )


QUESTIONS = [
    make()
    for make in (
        thrown_under_a_ceiling,
        spinning_rod,
        goes_on,
        speed_of_an_impact,
        prescribed_restitution,
        contact_force,
        elastic_bounces,
        holds,
        slides,
        later_if_higher,
        long_horizon,
        position_of_the_wall,
        restitution_of_a_speed,
    )
]

"""Problems from the literature: published figures, an independent second solution, and our simulation.

Each function of ``PROBLEMS`` runs one model and returns its ``Figure``s. Problems with measured data are in
measured.py, problems with dry friction in friction_figures.py. Published figures are facts of the sources
that docs/validation.md names. The second solutions are closed forms, root searches in closed forms, and the
chain of models/chain_model.py at 1e-13. Units are SI throughout.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk, gamma

from chain_impact import load_scene
from chain_impact.scene.scene import Scene, with_values
from tests.helpers.literature.figures import Figure, Problem, problem, run
from tests.helpers.literature.friction_figures import (
    glocker_rod,
    kane_pendulum,
    rocking_block,
    siconos_stick,
    stewart_rod,
)
from tests.helpers.literature.measured import golf_ball, triple_pendulum
from tests.helpers.literature.stored import ball_between_walls, ball_on_a_spring, ball_stays, sliding_block
from tests.helpers.literature.walker import kneed_leg
from tests.helpers.models.accumulation import Arm, first_accumulation, second_accumulation
from tests.helpers.models.beam import Bar, impulse
from tests.helpers.models.derivatives import differentiate

# --- double pendulum at a wall -------------------------------------------------------------------------

# time [s] → energy minus energy at 2.5 s [J], stored in the tests of Solfec
SOLFEC = {0.0: "11.6766522245", 0.6: "9.02830180065", 1.0: "0.892467558418", 1.5: "0.642073700206"}


def double_pendulum_wall(tolerance: float) -> Problem:
    """Return energies after impacts; the published ones were stored by a first-order scheme."""
    model = "double_pendulum_wall"
    result = run(model, tolerance)
    exact = differentiate(load_scene(model), (), [*SOLFEC, 2.5]).values
    energy = exact["energy.kinetic"] + exact["energy.potential"]
    ours = result["energy.kinetic"] + result["energy.potential"]
    figures = [
        Figure(
            f"energy at {time} s minus energy at 2.5 s [J]",
            stored,
            energy[row] - energy[-1],
            ours[round(time * 1000)] - ours[-1],
            1e-10,
            0.01,
            inaccurate=True,
        )
        for row, (time, stored) in enumerate(SOLFEC.items())
    ]
    return problem(model, result, figures)


# --- simple pendulum -----------------------------------------------------------------------------------

# time [s] → x and y [m], of the reference solution of the library
A01 = {10.0: ("-2.75087E-01", "-9.61419E-01"), 2000.0: ("8.14603E-01", "-5.80019E-01")}


def simple_pendulum(tolerance: float) -> Problem:
    """Return positions early and after 2000 s: the library's reference solution, and elliptic functions."""
    model = "simple_pendulum"
    result = run(model, tolerance, stop_time=2000.0, output_step=0.5)
    figures = [
        Figure(
            f"{axis} at {time:g} s [m]",
            stored,
            exact,
            result[f"point[1].{axis}"][round(2 * time)],
            held,
            6e-7,
        )
        for (time, published), held in zip(A01.items(), (1e-10, 1e-7), strict=True)
        for axis, stored, exact in zip("xy", published, pendulum(time), strict=True)
    ]
    return problem(model, result, figures)


def pendulum(time: float) -> tuple[float, float]:
    """Return the position [m] of a pendulum of 1 m released at (-1, 0) m, by Jacobi's elliptic functions.

    sin(φ/2) = k sn(K(k) − √(g/l) t, k) with k = sin(φ₀/2), φ from the vertical, φ₀ = π/2.
    """
    k = math.sin(math.pi / 4)
    sine = ellipj(ellipk(k * k) - math.sqrt(9.81) * time, k * k)[0]
    angle = 2 * math.asin(k * sine)
    return -math.sin(angle), -math.cos(angle)


# --- balls on a rigid floor ----------------------------------------------------------------------------

# time [s] → height [m], stored in the tests of Siconos: by time stepping of 5 ms, and event-driven
SICONOS = {
    2.0: ("1.05996e-03", "1.368436228507e-02"),
    4.0: ("2.64892e-01", "2.805174716218e-01"),
    8.0: ("3.77209e-03", "1.192658722943e-03"),
}


def bouncing_ball(tolerance: float) -> Problem:
    """Return heights over time, and the time of rest of the ball: two stored references, and closed forms."""
    model = "bouncing_ball"
    result = run(model, tolerance)
    exact, heights = bounces(1.0, 0.9), result["point[0].y"]
    figures = []
    for time, (stepped, driven) in SICONOS.items():
        ours = heights[round(time / 5e-3)]
        quantity = f"height at {time:g} s [m]"
        figures.append(Figure(f"{quantity}, time stepping", stepped, exact(time), ours, 1e-10, 0.02, True))
        figures.append(Figure(f"{quantity}, event-driven", driven, exact(time), ours, 1e-10, 1e-12))
    # the sum of the durations of all flights: √(2h/g) (1 + e)/(1 − e)
    rest = math.sqrt(2 / 9.81) * (1 + 0.9) / (1 - 0.9)
    scene = with_values(load_scene(model), {("contact", "minimum_impact_speed"): 1e-9})
    last = run(model, tolerance, scene).impacts["onset"][-1]
    figures.append(Figure("time of rest [s], minimum_impact_speed 10⁻⁹ m/s", None, rest, last, 1e-6))
    return problem(model, result, figures)


def bounces(height: float, restitution: float, gravity: float = 9.81) -> Callable[[float], float]:
    """Return the height over time of a ball on a rigid floor: flights from t_k with e v_k."""

    def at(time: float) -> float:
        onset, speed = math.sqrt(2 * height / gravity), math.sqrt(2 * gravity * height)
        if time < onset:
            return height - gravity * time**2 / 2
        while speed > 1e-12:
            speed *= restitution
            flight = 2 * speed / gravity
            if time < onset + flight:
                return speed * (time - onset) - gravity * (time - onset) ** 2 / 2
            onset += flight
        return 0.0

    return at


# engine, its best setting at 10 µs → mean square of the energy error [J²], as SimBenchmark stores it
ENGINES = {"RaiSim": "1.86446e-10", "ODE": "0.0185021", "DART": "7.38571", "Bullet": "7.52322"}


def elastic_ball(tolerance: float) -> Problem:
    """Return the energy error of 49 balls in 20 s: of engines at steps of 10 µs, and of our simulation."""
    model, balls = "elastic_ball", 49
    result = run(model, tolerance, output_step=1e-3)
    energy = balls * (result["energy.kinetic"] + result["energy.potential"])
    error = float(np.mean((energy - balls * 10.0 * 9.81 * 5.0) ** 2))
    figures = [
        Figure(f"mean square of the energy error [J²], {engine}", stored, 0.0, error, 1e-14, 8.0, True)
        for engine, stored in ENGINES.items()
    ]
    height = bounces(4.9, 1.0)(20.0) + 0.1
    figures.append(Figure("height at 20 s [m]", None, height, result["point[0].y"][-1], 1e-10))
    return problem(model, result, figures)


# --- one contact with a force law ----------------------------------------------------------------

RESTITUTIONS = (0.2, 0.4, 0.6, 0.8)
OXIDE = {"length": 0.0025, "young": 3.8e11, "poisson": 0.23, "density": 4000.0, "speed": 3.9}


def sphere_on_wall(tolerance: float) -> Problem:
    """Return figures for tests 2 and 3 of Chung & Ooi: Hertz's closed forms, and the restitution."""
    model = "sphere_on_wall"
    result = run(model, tolerance)
    scene, (impact,) = load_scene(model), result.impacts
    (link,), k, speed = scene.chain.links, scene.contact.stiffness, scene.initial.velocity[0]
    # δ = (5 m v²/4K)^(2/5), F = K δ^(3/2), T = 2 (δ/v) √π Γ(7/5)/Γ(9/10)
    depth = (1.25 * link.mass * speed**2 / k) ** 0.4
    duration = 2 * depth / speed * math.sqrt(math.pi) * gamma(1.4) / gamma(0.9)
    figures = [
        Figure("deepest penetration [m]", None, depth, impact["max_penetration"], 1e-15),
        Figure("peak force [N]", None, k * depth**1.5, impact["peak_force"], 1e-6),
        Figure("duration of contact [s]", None, duration, impact["end"] - impact["onset"], 1e-13),
        Figure("rebound speed [m/s]", "0.2", speed, impact["separation_speed"], 1e-11),
    ]
    for restitution in RESTITUTIONS:
        (hit,) = run(model, tolerance, oxide_sphere(scene, restitution)).impacts
        restitution_of_run = hit["separation_speed"] / hit["impact_speed"]
        quantity = f"test 3: restitution, prescribed {restitution}"
        figures.append(Figure(quantity, str(restitution), restitution, restitution_of_run, 1e-10))
    return problem(model, result, figures)


def oxide_sphere(scene: Scene, restitution: float) -> Scene:
    """Return the scene of test 3 of Chung & Ooi: a sphere of aluminium oxide with a restitution."""
    radius, speed = OXIDE["length"], OXIDE["speed"]
    mass = 4 / 3 * math.pi * radius**3 * OXIDE["density"]
    changes = {
        ("chain", "links", 0, "length"): radius,
        ("chain", "links", 0, "mass"): mass,
        ("chain", "links", 0, "inertia"): 0.4 * mass * radius**2,
        ("contact", "model"): "zhang_sharf",
        ("contact", "stiffness"): 4 / 3 * OXIDE["young"] / (1 - OXIDE["poisson"] ** 2) * math.sqrt(radius),
        ("contact", "restitution"): restitution,
        ("contact", "radius"): radius,
        ("initial", "position"): [-radius - 1e-4, 0.0],
        ("initial", "velocity"): [speed, 0.0],
        ("simulation", "stop_time"): 2e-4,
        ("simulation", "step_size"): 1e-6,
    }
    return with_values(scene, changes)


def elastic_floor(tolerance: float) -> Problem:
    """Return figures for SDND108 A of code_aster: a fall, half an oscillation on a spring, and a flight."""
    model = "elastic_floor"
    result = run(model, tolerance)
    first, second = result.impacts[:2]
    mass, k, gravity, height, start = 1.0, 100.0, 10.0, 2.0, 1.0
    speed, rate = math.sqrt(start**2 + 2 * gravity * height), math.sqrt(k / mass)
    onset = (speed - start) / gravity
    # on the spring, δ = (g/ω²)(1 − cos ωτ) + (v/ω) sin ωτ
    depth = gravity / rate**2 + math.hypot(gravity / rate**2, speed / rate)
    # δ = 0 again at tan(ωτ/2) = −v ω/g, in the second quadrant
    duration = 2 / rate * (math.pi - math.atan(speed * rate / gravity))
    figures = [
        Figure("first contact [s]", None, onset, first["onset"], 1e-11),
        Figure("speed at contact [m/s]", None, speed, first["impact_speed"], 1e-10),
        Figure("deepest penetration [m]", None, depth, first["max_penetration"], 1e-10),
        Figure("duration of contact [s]", None, duration, first["end"] - first["onset"], 1e-9),
        Figure("second contact [s]", None, onset + duration + 2 * speed / gravity, second["onset"], 1e-9),
    ]
    return problem(model, result, figures)


# --- clattering rod ------------------------------------------------------------------------------------


def clattering_rod(tolerance: float) -> Problem:
    """Return figures for the impacts of a rod's two ends: closed forms of flights, and searches for roots."""
    model, numbers = "clattering_rod", (1, 2, 3, 10, 20, 30)
    result = run(model, tolerance)
    exact = clatter(load_scene(model), max(numbers))
    figures = []
    for n in numbers:
        end, onset, speed = exact[n - 1]
        row = result.impacts[n - 1]
        assert row["point"] == end
        figures.append(Figure(f"impact {n}, of end {end}: time [s]", None, onset, row["onset"], 1e-10))
        figures.append(Figure(f"impact {n}: speed [m/s]", None, speed, row["impact_speed"], 1e-9))
    return problem(model, result, figures)


def clatter(scene: Scene, impacts: int) -> list[tuple[int, float, float]]:
    """Return (end, time [s], speed [m/s]) of each impact of a uniform rod's ends on a rigid floor.

    In flight y = y₀ + v t − g t²/2 and θ = θ₀ + ω t, so end s = ∓1 is at y + s (l/2) sin θ. An impact of
    speed u on it gives the impulse p = (1 + e) u m/(1 + 3 cos²θ): v += p/m, ω += s (l/2) cos θ p/I.
    """
    (link,), e, gravity = scene.chain.links, scene.contact.restitution, -scene.gravity[1]
    half, mass, angle = link.length / 2, link.mass, scene.initial.angles[0]
    inertia = mass * link.length**2 / 12
    height, speed, spin, now = scene.initial.position[1] + half * math.sin(angle), 0.0, 0.0, 0.0
    contacts: list[tuple[int, float, float]] = []
    while len(contacts) < impacts:
        state = height, speed, angle, spin

        def gap(t: float, side: int, state: tuple[float, ...] = state) -> float:
            y, v, theta, omega = state
            return y + v * t - gravity * t**2 / 2 + side * half * math.sin(theta + omega * t)

        # the steps are shorter than any flight between these impacts
        step, time, hits = 1e-5, 1e-9, []
        while not hits:
            hits = [
                (brentq(gap, time, time + step, (side,), xtol=1e-15), side)
                for side in (-1, 1)
                if gap(time, side) > 0 >= gap(time + step, side)
            ]
            time += step
        flight, side = min(hits)
        height += speed * flight - gravity * flight**2 / 2
        speed -= gravity * flight
        angle += spin * flight
        now += flight
        arm = side * half * math.cos(angle)
        approach = -(speed + arm * spin)
        impulse = (1 + e) * approach * mass / (1 + 3 * math.cos(angle) ** 2)
        speed += impulse / mass
        spin += arm * impulse / inertia
        contacts.append((0 if side < 0 else 1, now, approach))
    return contacts


# --- an arm with two accumulations of impacts ----------------------------------------------------------


def falling_arm(tolerance: float) -> Problem:
    """Return the times at which elbow and tip of an arm come to rest, each after infinitely many impacts."""
    model = "falling_arm"
    result = run(model, tolerance)
    arm = Arm(load_scene(model))
    elbow, point, state = first_accumulation(arm)
    assert point == 1
    impacts = result.impacts
    rests = [impacts["onset"][impacts["point"] == k][-1] for k in (1, 2)]
    there = run(model, tolerance, stop_time=elbow)
    rate = there.angular_velocities[-1, 1]
    tip = second_accumulation(arm, elbow, state)
    figures = [
        # the simulation ends an accumulation where bounces are too low to distinguish from rest
        Figure("time of rest of the elbow [s]", None, elbow, rests[0], 2e-7),
        Figure("angle of link 2 then [rad]", None, state[1], there.angles[-1, 1], 1e-10),
        Figure("angular velocity of link 2 then [rad/s]", None, state[3], rate, 1e-8),
        Figure("time of rest of the tip [s]", None, tip, rests[1], 2e-7),
    ]
    return problem(model, result, figures)


# --- a bar that bends ----------------------------------------------------------------------------------


def steel_bar(tolerance: float) -> Problem:
    """Return figures for the effective restitution of a vibrating bar, against an Euler–Bernoulli beam."""
    model, lengths = "steel_bar", (0.2, 0.3, 0.4)
    result, scene = run(model, tolerance), load_scene(model)
    times = np.linspace(0.0, scene.simulation.stop_time, 2)
    figures = []
    for length in lengths:
        bar = Bar(length)
        _, exact = bar.impact(times)
        ours = impulse(bar.chain(scene, 20, tolerance))
        quantity = f"restitution of a bar of {length} m without its vibration"
        # a chain of 20 links differs slightly from a beam
        figures.append(Figure(quantity, None, bar.restitution(exact), bar.restitution(ours), 2e-4))
    figures.append(Figure("impulse on the bar of 0.4 m [N·s]", None, exact, impulse(result), 1e-5))
    return problem(model, result, figures)


PROBLEMS: dict[str, Callable[[float], Problem]] = {
    function.__name__: function
    for function in (
        double_pendulum_wall,
        simple_pendulum,
        bouncing_ball,
        elastic_ball,
        sphere_on_wall,
        elastic_floor,
        clattering_rod,
        falling_arm,
        steel_bar,
        kneed_leg,
        golf_ball,
        triple_pendulum,
        kane_pendulum,
        siconos_stick,
        glocker_rod,
        stewart_rod,
        rocking_block,
        ball_between_walls,
        ball_stays,
        ball_on_a_spring,
        sliding_block,
    )
}

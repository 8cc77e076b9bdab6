"""Scenes with dry friction whose derivatives are known, and the kernel's derivatives of any case."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from chain_impact.simulation.derivatives import Differentiated, DifferentiatedRun
from tests.helpers.scenes.derivative_scenes import (
    Case,
    all_parameters,
    exact,
    link,
    start,
    state_names,
    table,
)
from tests.helpers.scenes.problems import of_law

SLOPE = 0.35  # rad


def parameters_of(case_scene: Any, inputs: dict[str, float] | None = None) -> tuple[str, ...]:
    """Return all parameters on which a motion depends, except a radius and a coefficient without effect."""
    values = case_scene.values
    covered = values.get("contact.static_friction", 0.0) <= values.get("contact.friction", 0.0)
    left_out = {"contact.radius", *(["contact.static_friction"] if covered else [])}
    return tuple(name for name in all_parameters(case_scene, inputs or {}) if name not in left_out)


def puck(law: str = "zhang_sharf", friction: float = 0.2, static: float = 0.0, **solver: Any) -> Case:
    """Return a body that touches a slope at its centre of mass: it slides up, stops, and may slide back."""
    scene = table(
        [link(0.1, 0.4, center_of_mass=0.0)],
        walls=[{"name": "slope", "point": [0.0, 0.0], "angle": SLOPE}],
        contact={
            "points": [0],
            "stiffness": 1e4,
            "restitution": 0.1,
            "friction": friction,
            "static_friction": static,
            **of_law(law),
        },
        initial=start(position=[0.0, 1e-3], angles=[SLOPE + 1.5], velocity=[1.3, 0.2]),
        simulation={"stop_time": 0.6, "step_size": 0.01},
        solver=solver,
    )
    return Case(scene, parameters_of(scene), (0.1, 0.3, 0.6))


def swinging(static: float = 0.0, law: str = "zhang_sharf", **solver: Any) -> Case:
    """Return a link that swings below a point on a floor: the point slides, sticks, and slides again."""
    scene = table(
        [{"length": 0.4, "mass": 0.8}],
        box={"y_min": 0.0},
        contact={
            "points": [0],
            "stiffness": 5e3,
            "restitution": 0.1,
            "friction": 0.35,
            "static_friction": static,
            **of_law(law),
        },
        initial=start(position=[0.0, 1e-3], angles=[-0.3], velocity=[0.1, -0.3]),
        simulation={"stop_time": 0.8, "step_size": 0.01},
        solver=solver,
    )
    return Case(scene, parameters_of(scene), (0.1, 0.4, 0.8))


def driven_links(static: float = 0.45, law: str = "zhang_sharf", **solver: Any) -> Case:
    """Return two links below a point on a floor with its own material, with a torque and a dry joint."""
    scene = table(
        [
            link(0.4, 0.8, damping=0.01),
            link(0.3, 0.5, damping=0.02, friction=0.15),
        ],
        box={"y_min": 0.0},
        contact={
            "points": [0],
            "stiffness": 5e3,
            "restitution": 0.1,
            "wall": {"y_min": {"friction": 0.3, "static_friction": static}},
            **of_law(law),
        },
        inputs={"joint_torques": True},
        initial=start(position=[0.0, 1e-3], angles=[-0.4, -1.2], velocity=[0.2, -0.3], spins=[0.0, 1.0]),
        simulation={"stop_time": 0.8, "step_size": 0.01},
        solver=solver,
    )
    inputs = {"joint[2].torque": 0.1}
    return Case(scene, parameters_of(scene, inputs), (0.1, 0.4, 0.8), inputs)


def dry_joints(links: int = 2, **solver: Any) -> Case:
    """Return a pinned chain with dry friction in all joints, which swings and comes to rest."""
    joint = {"joint_friction": 0.5, "joint_damping": 0.01}
    lengths = (0.4, 0.35, 0.3, 0.25)[:links]
    scene = table(
        [
            {"length": length, "mass": 0.9 - 0.1 * i, **joint, "joint_friction": 0.9 / (i + 1.0) ** 2}
            for i, length in enumerate(lengths)
        ],
        base="pinned",
        inputs={"joint_torques": True},
        initial=start(angles=[-0.6, -1.1, -1.5, -0.9][:links], spins=[-0.1, -0.25, 0.1, -0.2][:links]),
        simulation={"stop_time": 2.0, "step_size": 0.01},
        solver=solver,
    )
    inputs = {"joint[1].torque": 0.1}
    return Case(scene, parameters_of(scene, inputs), (0.5, 1.2, 2.0), inputs)


def thrown(links: int = 2, law: str = "zhang_sharf", stop: float = 0.5, **solver: Any) -> Case:
    """Return a chain with dry joints that falls on a rough floor: impacts slide and stick."""
    body = link(0.3, 0.7, damping=0.01)
    scene = table(
        [body, *[body | {"joint_friction": 0.1 + 0.03 * i} for i in range(links - 1)]],
        box={"y_min": 0.0},
        contact={
            "stiffness": 1e6,
            "restitution": 0.6,
            "friction": 0.35,
            "static_friction": 0.4,
            **of_law(law),
        },
        initial=start(
            position=[0.0, 0.25],
            angles=[0.5, -0.4, 0.3, 0.1][:links],
            velocity=[0.3, -1.0],
            spins=[1.0, 2.0, -1.0, 0.5][:links],
        ),
        simulation={"stop_time": stop, "step_size": 1e-3},
        solver=solver,
    )
    return Case(scene, parameters_of(scene), (0.3 * stop, 0.7 * stop, stop))


DRY = {
    "slides back": puck(),
    "stops on a slope": puck(friction=0.5),
    "stops by static friction": puck(friction=0.3, static=0.5),
    "stops, tsuji": puck("tsuji", friction=0.5),
    "thrown, kelvin_voigt": thrown(2, "kelvin_voigt", stop=0.25),
    "swings": swinging(),
    "swings, static": swinging(static=0.5),
    "swings, hertz": swinging(law="hertz"),
    "driven": driven_links(),
    "driven, flores": driven_links(law="flores"),
    "two dry joints": dry_joints(2),
    "three dry joints": dry_joints(3),
    "four dry joints": dry_joints(4),
    "thrown": thrown(2, stop=0.4),
    "three thrown": thrown(3, stop=0.3),
}
ENERGIES = ("energy.total", "energy.dissipated")


def outputs_of(case: Case) -> list[str]:
    """Return the outputs of a case that are compared."""
    supplied = ["energy.supplied"] if case.inputs else []
    links = range(1, len(case.scene.chain.links) + 1)
    rates = ["point[0].ax", "point[0].ay", *(f"link[{i}].angular_acceleration" for i in links)]
    rubbed = [name for name in exact(case).values if "friction" in name]
    return [*state_names(case.scene), *ENERGIES, *supplied, *rates, *rubbed]


@cache
def kernel_derivatives(
    case: Case, tolerance: float = 1e-12, *, start: bool = False, method: str = "auto"
) -> Differentiated:
    """Return the kernel's derivatives at the case's times; with ``start`` also at 0 s, before them."""
    scene = case.scene.with_values({"solver.tolerance": tolerance, "solver.method": method})
    run = DifferentiatedRun(scene, case.parameters, outputs_of(case), inputs=case.inputs)
    values = [case.value(name) for name in case.parameters]
    times = np.array([0.0, *case.times] if start else case.times)
    return run.run(np.array(values), times)

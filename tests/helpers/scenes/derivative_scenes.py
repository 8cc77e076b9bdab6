"""Scenes whose derivatives are known, and differences of runs as a second comparison."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from chain_impact import simulate
from chain_impact.scene.candidates import point_wall_pairs
from chain_impact.scene.scene import Scene, scene_from_dict, scene_to_dict
from tests.helpers.models.derivatives import FIELDS, Derivatives, differentiate
from tests.helpers.models.kept_answers import Arrays, kept
from tests.helpers.scenes.problems import default_scene, of_law

ORACLE = "tests.helpers.models.derivatives"


@dataclass(frozen=True)
class Case:
    """A scene with inputs, parameters for derivatives, and times at which results are compared [s].

    All values of the scene are given, so the derivatives are partial derivatives. The derivatives through
    derived values are sums of these, see tests/scenarios/test_derived_values.py.
    """

    scene: Scene
    parameters: tuple[str, ...]
    times: tuple[float, ...]
    inputs: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self):
        # input values that change over time, in a form that can be hashed
        held = {k: tuple(map(tuple, v)) if np.ndim(v) else v for k, v in self.inputs.items()}
        object.__setattr__(self, "inputs", held)
        data = scene_to_dict(self.scene, derived=True)
        object.__setattr__(self, "scene", scene_from_dict(data, self.scene.name))

    def value(self, parameter: str) -> float:
        """Return the value of an input or of a parameter; 0 if the scene does not have it."""
        return float(self.inputs.get(parameter, self.scene.values.get(parameter, 0.0)))

    def __hash__(self) -> int:
        return hash((self.scene, self.parameters, self.times, tuple(self.inputs.items())))


# field of an answer that is a dictionary → field with the names of its keys
DICTIONARIES = {"values": "values", "slopes": "values", "impacts": "impacts", "impact_slopes": "impacts"}


def as_arrays(answer: Derivatives) -> Arrays:
    return {
        "names": np.array([*answer.values]),
        **{name: np.array([*getattr(answer, name).values()]) for name in DICTIONARIES},
        "points": answer.points,
        "walls": answer.walls,
        "steps": np.array(answer.steps),
        "modes": np.array(answer.modes, float).reshape(-1, 3),
    }


def from_arrays(data: Arrays) -> Derivatives:
    names = {"values": data["names"].tolist(), "impacts": FIELDS}
    tables: dict[str, Any] = {
        name: dict(zip(names[of], data[name], strict=True)) for name, of in DICTIONARIES.items()
    }
    modes = [(time, int(element), int(mode)) for time, element, mode in data["modes"].tolist()]
    return Derivatives(
        **tables, points=data["points"], walls=data["walls"], steps=int(data["steps"]), modes=modes
    )


@cache
def _exact(case: Case, tolerance: float) -> Derivatives:
    given = case.parameters, case.times, dict(case.inputs), tolerance
    arrays = from_arrays(
        kept(lambda: as_arrays(differentiate(case.scene, *given)), ORACLE, case.scene, *given)
    )
    return replace(arrays, values=add_joints(arrays.values), slopes=add_joints(arrays.slopes))


def exact(case: Case, tolerance: float = 1e-12) -> Derivatives:
    """Return the independent model's answer, which does not depend on the settings of the solver."""
    return _exact(replace(case, scene=case.scene.with_values({"solver.method": "auto"})), tolerance)


def add_joints(named: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return ``named`` with entries of joints added: the entry of link i minus that of link i − 1.

    The entry of joint 1 is that of link 1.
    """
    joints, before = {}, {"angle": 0.0, "angular_velocity": 0.0}
    for name, value in named.items():
        if name.startswith("link[") and (kind := name.split(".")[1]) in before:
            joints[f"joint{name[4:]}"] = value - before[kind]
            before[kind] = value
    return named | joints


def table(links: Sequence[Mapping[str, float]], **tables: Any) -> Scene:
    data = {"name": "Case", "chain": {"base": tables.pop("base", "free"), "links": links}, **tables}
    return scene_from_dict(data, "case")


def link(length: float, mass: float, **more: float) -> dict[str, float]:
    """Return the table of a link; keys of its joint have no prefix."""
    own = ("center_of_mass", "inertia")
    return {"length": length, "mass": mass} | {k if k in own else f"joint_{k}": v for k, v in more.items()}


def start(spins: Any = None, **more: Any) -> dict[str, Any]:
    """Return a table [initial] with the keys ``more``, and with the angular velocities ``spins`` if given."""
    return more | ({} if spins is None else {"angular_velocities": spins})


def struck_twice(law: str, restitution: float = 0.7, stiffness: float = 1e7) -> Case:
    """Return two links that fall onto the floor: three impacts at two points, one of them at 0.2022 s."""
    scene = table(
        [
            {"length": 0.5, "mass": 1.0},
            link(0.4, 0.7, damping=0.01, stiffness=1.0, rest_angle=0.2),
        ],
        box={"x_min": -1.0, "y_min": 0.0},
        contact={"stiffness": stiffness, "restitution": restitution, **of_law(law)},
        initial=start(position=[0.0, 0.25], angles=[0.4, -0.3], velocity=[-0.5, -1.0], spins=[1.0, 2.0]),
        simulation={"stop_time": 0.3, "step_size": 2e-4},
    )
    return Case(scene, all_parameters(scene, {}), (0.1, 0.2022, 0.3))


def all_parameters(scene: Scene, inputs: Mapping[str, float]) -> tuple[str, ...]:
    """Return the names of the inputs, and of all parameters on which a motion depends.

    Exponents, minimum impact speeds and the solver's settings are left out.
    """
    tables = ["gravity", "link", "box", "wall", "initial", "stop"]
    if point_wall_pairs(scene):
        tables.append("contact")
    left_out = [f"{law}.{key}" for law in ("contact", "stop") for key in ("exponent", "minimum_impact_speed")]
    pinned = scene.chain.base == "pinned"
    if not scene.has_contact_friction:
        left_out += [f"contact.{key}" for key in ("friction", "static_friction")]
    left_out += [] if scene.chain.slider else ["initial.slider_velocity"]
    links = enumerate(scene.chain.links, 1)
    only_there = ("joint_friction", "joint_armature", "center_of_mass_offset")
    left_out += [f"link[{i}].{key}" for i, link in links for key in only_there if not getattr(link, key)]
    names = [
        name
        for name, value in scene.values.items()
        if isinstance(value, float) and name.split("[")[0].split(".")[0] in tables and name not in left_out
    ]
    of_base = [f"link[1].{key}" for key in ("joint_damping", "joint_stiffness", "joint_rest_angle")]
    idle = ("initial.vx", "initial.vy") if pinned else tuple(of_base)
    return (*(name for name in names if name not in idle), *inputs)


def sprung_chain(law: str = "zhang_sharf", **solver: Any) -> Case:
    """Return three unequal links with springs and dampers in driven joints, between a floor and a slope."""
    scene = table(
        [
            link(0.4, 1.0, center_of_mass=0.15),
            link(0.3, 0.6, damping=0.05, stiffness=2.0, rest_angle=0.3),
            link(0.35, 0.8, damping=0.02, stiffness=3.0, inertia=0.02),
        ],
        box={"y_min": 0.0},
        walls=[{"name": "slope", "point": [1.58, 0.0], "angle": 2.2}],
        contact={"stiffness": 3e6, "restitution": 0.6, "radius": 0.02, **of_law(law)},
        inputs={"joint_torques": True, "tip_force": True},
        initial=start(
            position=[0.0, 0.3], angles=[0.5, -0.2, 0.4], velocity=[1.5, -0.5], spins=[-1.0, 1.0, 2.0]
        ),
        simulation={"stop_time": 0.3, "step_size": 2e-3},
        solver=solver,
    )
    inputs = {"joint[2].torque": 0.4, "joint[3].torque": -0.3, "tip.force.x": 1.5, "tip.force.y": 0.5}
    return Case(scene, all_parameters(scene, inputs), (0.1, 0.216, 0.3), inputs)


def pinned_chain(law: str = "hunt_crossley", **solver: Any) -> Case:
    """Return two links on a pinned base that swing against a wall, driven at the base."""
    scene = table(
        [
            link(0.5, 1.0, damping=0.1, stiffness=1.0, rest_angle=-1.0),
            link(0.4, 0.5, damping=0.02, stiffness=1.0, rest_angle=0.1),
        ],
        base="pinned",
        box={"x_max": 0.6},
        contact={"stiffness": 1e6, "restitution": 0.75, "radius": 0.01, **of_law(law)},
        inputs={"joint_torques": True},
        initial=start(position=[0.0, 0.0], angles=[-1.8, -1.2], spins=[3.0, 2.0]),
        simulation={"stop_time": 1.0, "step_size": 2e-2},
        solver=solver,
    )
    inputs = {"joint[1].torque": 5.0, "joint[2].torque": 0.2}
    return Case(scene, all_parameters(scene, inputs), (0.3, 0.7, 1.0), inputs)


def pressed_tip(law: str = "zhang_sharf", **solver: Any) -> Case:
    """Return two links whose tip is pressed onto the floor: v₀ is latched several times."""
    scene = table(
        [
            link(0.5, 0.8, damping=0.05),
            link(0.4, 0.5, damping=0.02),
        ],
        base="pinned",
        box={"y_min": -0.5},
        contact={"stiffness": 2e4, "restitution": 0.4, "points": [2], **of_law(law)},
        inputs={"joint_torques": True, "tip_force": True},
        initial=start(position=[0.0, 0.0], angles=[-0.3, -1.07], spins=[0.0, -0.2]),
        simulation={"stop_time": 0.12, "step_size": 2e-3},
        solver=solver,
    )
    inputs = {"tip.force.y": -30.0, "joint[2].torque": 1.0}
    left_out = ("gravity.x", "contact.radius")
    parameters = tuple(name for name in all_parameters(scene, inputs) if name not in left_out)
    return Case(scene, parameters, (0.02, 0.06, 0.12), inputs)


def stopped_chain(contact: str, stops: str, times: tuple[float, ...], **solver: Any) -> Case:
    """Return two pinned links that hit the stops of the second joint, and a floor with its own material.

    Their impacts are at the knee at 0.135 s, at the floor at 0.418 s, and from 0.424 s on at both together.
    """
    scene = table(
        [
            link(0.5, 1.0, max=0.5, damping=0.02),
            link(0.4, 0.5, center_of_mass=0.15, min=-0.9, max=0.3, stiffness=1.0, damping=0.01),
        ],
        base="pinned",
        box={"y_min": -0.55},
        contact={
            "restitution": 0.6,
            "radius": 0.01,
            "points": [2],
            "wall": {"y_min": {"stiffness": 1e6, "restitution": 0.75}},
            **of_law(contact),
        },
        stops={"stiffness": 5e3, "restitution": 0.5, **of_law(stops)},
        initial=start(position=[0.0, 0.0], angles=[0.4, 0.2], spins=[1.0, 2.0]),
        simulation={"stop_time": times[-1], "step_size": 1e-3},
        solver=solver,
    )
    return Case(scene, all_parameters(scene, {}), times)


def thrown_chain() -> Case:
    """Return four links with stops in all joints, thrown up without a wall: three impacts until 0.8 s."""
    stopped = link(0.3, 0.6, min=-0.8, max=0.7)
    scene = table(
        [{"length": 0.4, "mass": 1.0}, stopped, stopped | {"joint_max": 0.9}, stopped | {"length": 0.2}],
        stops={"stiffness": 2e3, "restitution": 0.5},
        initial=start(
            position=[0.0, 0.0],
            angles=[0.1, 0.3, 0.2, -0.1],
            velocity=[0.0, 3.0],
            spins=[1.0, -2.0, 3.0, -1.5],
        ),
        simulation={"stop_time": 0.8, "step_size": 0.02},
    )
    return Case(scene, all_parameters(scene, {}), (0.2, 0.5, 0.8))


AT_STOPS = {
    "stops": thrown_chain(),
    "stop and wall": stopped_chain("zhang_sharf", "lankarani_nikravesh", (0.2, 0.42, 0.424)),
    "stop with wall": stopped_chain("zhang_sharf", "zhang_sharf", (0.2, 0.43, 0.5)),
    "stop, rigid wall": stopped_chain("newton_impact", "zhang_sharf", (0.2, 0.43, 0.5)),
    "rigid stop, wall": stopped_chain("zhang_sharf", "newton_impact", (0.2, 0.425, 0.434)),
    "rigid stop and wall": stopped_chain("newton_impact", "newton_impact", (0.2, 0.43, 0.5)),
}
"""Chains with stops in their joints: without a wall, or with a floor of the same or of another law."""


def thrown_on_a_slope(seed: int, *, joints: bool = False, base: str = "free") -> Scene:
    """Return a chain of three unequal links that hits a floor and a slope, with two friction coefficients."""
    rng = np.random.default_rng(seed)
    links = [
        link(
            float(rng.uniform(0.3, 0.7)),
            float(rng.uniform(0.5, 2.0)),
            friction=float(rng.uniform(0.1, 0.6)) if joints and (i > 0 or base == "pinned") else 0.0,
        )
        for i in range(3)
    ]
    mu = float(rng.uniform(0.1, 0.8))
    return table(
        links,
        base=base,
        box={"y_min": 0.0},
        walls=[{"name": "slope", "point": [2.4, 0.0], "angle": 1.9}],
        contact={
            "stiffness": 1e6,
            "restitution": 0.6,
            "friction": mu,
            "static_friction": 1.25 * mu,
            "wall": {"slope": {"friction": 0.3}},
        },
        initial=start(
            position=[0.2, 0.75],
            angles=list(rng.uniform(-0.6, 0.6, 3)),
            velocity=[0.0, 0.0] if base == "pinned" else list(rng.uniform(-1.0, 1.0, 2)),
            spins=list(rng.uniform(-3.0, 3.0, 3)),
        ),
        simulation={"stop_time": 0.6},
    )


def six_impacts() -> Case:
    """Return the default scene until 1.2 s: six impacts of five points."""
    scene = default_scene().with_values({"simulation.stop_time": 1.2, "simulation.step_size": 0.1})
    parameters = (
        "contact.stiffness",
        "contact.restitution",
        "link[2].mass",
        "link[3].length",
        "link[1].center_of_mass",
        "link[4].inertia",
        "link[3].joint_damping",
        "initial.angle[3]",
        "initial.angular_velocity[2]",
        "initial.vx",
        "gravity.y",
        "box.y_min",
    )
    return Case(scene, parameters, (0.3, 0.6, 0.9, 1.2))


def state_names(scene: Scene) -> list[str]:
    """Return the names of the outputs that form the state: of the base and of the links."""
    links = range(1, len(scene.chain.links) + 1)
    base = [f"point[0].{name}" for name in ("x", "y", "vx", "vy")]
    return [*base, *(f"link[{i}].{name}" for i in links for name in ("angle", "angular_velocity"))]


def size_of(case: Case, parameter: str) -> float:
    """Return the absolute value of a parameter; 1 if the value is zero."""
    return abs(case.value(parameter)) or 1.0


def off(result: np.ndarray, expected: np.ndarray, values: np.ndarray, unit: float) -> float:
    """Return the error of an output's derivatives by a parameter, over the largest derivative.

    ``values`` are those of the output, ``unit`` is the parameter's ``size_of``. Derivatives of an output that
    hardly depends on the parameter are compared with a thousandth of the output over ``unit``. The error is 0
    if no derivative is known (all are NaN), or if these and all values are 0. NaN must stand at the same
    places in ``result`` and ``expected``.
    """
    kept = ~np.isnan(expected)
    assert np.array_equal(kept, ~np.isnan(result))
    if not kept.any():
        return 0.0
    largest = max(np.abs(expected[kept]).max(), 1e-3 * np.abs(values[kept]).max() / unit)
    return float(np.abs(result - expected)[kept].max() / largest) if largest else 0.0


def run(case: Case, changes: Mapping[str, float], tolerance: float = 1e-13) -> tuple[np.ndarray, np.ndarray]:
    """Return the states at the times of a case, (T, W), and the impacts, (fields, I), with changed values."""
    scene = case.scene.with_values({k: v for k, v in changes.items() if k not in case.inputs})
    inputs = {name: changes.get(name, value) for name, value in case.inputs.items()}
    result = simulate(scene, tolerance=tolerance, inputs=inputs)
    rows = np.searchsorted(result.time, np.array(case.times) - 1e-9)
    states = np.stack([result[name][rows] for name in state_names(scene)], 1)
    return states, np.array([result.impacts[name] for name in FIELDS])


def differences(case: Case, parameter: str) -> tuple[np.ndarray, np.ndarray]:
    """Return derivatives of both results of ``run`` by central differences of the sizes that agree best.

    Each difference is extrapolated once (L. F. Richardson 1911, *Phil Trans R Soc A* 210:307).
    """
    at, unit = case.value(parameter), size_of(case, parameter)

    def slopes(size: float) -> list[np.ndarray]:
        above, below = (run(case, {parameter: at + sign * size}) for sign in (1.0, -1.0))
        return [(a - b) / (2.0 * size) for a, b in zip(above, below, strict=True)]

    all_slopes = [slopes(unit * size) for size in (5e-4, 2.5e-4, 1.25e-4, 6.25e-5, 3.125e-5)]
    best = []
    for sizes in zip(*all_slopes, strict=True):
        extrapolated_slopes = [(4.0 * fine - coarse) / 3.0 for coarse, fine in itertools.pairwise(sizes)]
        gaps = [np.nanmax(np.abs(a - b), initial=0.0) for a, b in itertools.pairwise(extrapolated_slopes)]
        best.append(extrapolated_slopes[int(np.argmin(gaps)) + 1])
    return best[0], best[1]

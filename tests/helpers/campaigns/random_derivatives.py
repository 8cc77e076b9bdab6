"""Random scenes whose derivatives, in all rows and impacts, are compared with central differences.

In each kind of scene, steps end in other ways: explicit steps are truncated where a contact begins, and
repeated where a contact ends or a force has a kink; implicit steps are repeated at every event; a single
contact has its own integration variable; rigid walls release points; drives reach their limits; friction
sticks and slides; inputs have kinks. ``python -m tests.helpers.campaigns.random_derivatives KIND FIRST
COUNT`` checks more of a kind than the tests do.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from chain_impact import simulate
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.tangent.friction import SAME_TIME_SLOPE
from chain_impact.results.result import Result
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import Scene, scene_from_dict, scene_to_dict
from chain_impact.simulation.derivatives import DIFFERENTIABLE_COLUMNS
from chain_impact.simulation.errors import SimulationError
from tests.helpers.campaigns.body_derivatives import Given, bodies, carts, moved_bases
from tests.helpers.campaigns.random_parts import Draw
from tests.helpers.campaigns.resting_chains import shares_left_open
from tests.helpers.scenes.problems import of_law

SIZES = (1e-6, 5e-6)  # sizes of the differences, relative to the parameter
AGREE = 3e-3  # largest difference of the two differences that count as having one limit, over the derivative
WRONG = 1e-2  # largest error of a derivative that errors of a run explain, over the derivative
# least size to which an error is relative, over the largest derivative of a column, and over value over
# parameter; smaller derivatives are errors of the runs
LEAST = 1e-3
# the largest round-off of the difference of an output between two runs, in the output's unit; divided by the
# difference of the parameter, it is an allowed error of a derivative
ROUND_OFF = 1e-13
# factor on the error that a run reports: it is relative to the largest derivative of a position, and the
# error of rates may be larger
OPEN = 10.0
PARAMETERS = (
    "link[1].mass",
    "link[1].length",
    "contact.stiffness",
    "contact.restitution",
    "contact.friction",
    "gravity.y",
    "box.y_min",
    "link[2].joint_stiffness",
    "link[1].joint_torque_limit",
    "link[2].joint_friction",
    "initial.angle[1]",
    "initial.vx",
    "link[1].center_of_mass_offset",
    "link[1].point[1].x",
    "link[1].point[1].y",
    "contact.radius",
    "slider.angle",
    "slider.mass",
    "slider.damping",
    "slider.stiffness",
    "slider.rest_position",
    "slider.friction",
    "slider.force_limit",
    "slider.min",
    "signal.push.amplitude",
    "signal.push.frequency",
    "signal.push.final",
    "signal.push.start",
    "signal.push.duration",
    "signal.push.value[2]",
    "signal.push.time[2]",
)


@dataclass
class Checked:
    """The numbers of compared derivatives and of rows with any of these, and the wrong derivatives.

    A wrong derivative is a tuple: parameter, time [s], output or impact, derivative, and difference.
    """

    rows: int = 0
    compared: int = 0
    wrong: list[tuple[str, float, str, float, float]] = field(default_factory=list)


def thrown(draw: Draw, stiffest: float = 1e6, rigid: bool = False, **asked: Any) -> Given:
    """Return one to three links that fall on a floor, some beside a wall, or swing above it on a pinned base.

    ``asked`` may have ``pinned``, ``stops``, ``stop`` (time), ``method``, and ``friction``, a probability.
    """
    pinned, friction = asked.get("pinned", draw.chance(0.4)), asked.get("friction", 0.0)
    links = []
    for i in range(draw.whole(1, 3)):
        link = {"length": draw.real(0.2, 0.5), "mass": draw.real(0.3, 1.5)}
        if i > 0 or pinned:
            link["joint_damping"] = draw.real(0.0, 0.05)
            link["joint_stiffness"] = draw.real(0.5, 5.0) * draw.chance(0.3)
            link["joint_friction"] = draw.real(0.05, 0.5) * draw.chance(friction)
            if asked.get("stops"):
                link |= {"joint_min": draw.real(-2.5, -1.6), "joint_max": draw.real(0.6, 1.5)}
        links.append(link)
    size, laws = (
        sum(link["length"] for link in links),
        [law for law in CONTACT_LAWS if law != "newton_impact"],
    )
    law = of_law("newton_impact" if rigid else draw.one(laws))
    contact = {**law, "restitution": draw.real(0.2, 0.8), "stiffness": draw.power(1e3, stiffest)}
    if draw.chance(friction):
        contact["friction"] = draw.real(0.1, 0.8)
        contact["static_friction"] = contact["friction"] * draw.one((0.0, draw.real(1.0, 1.4)))
    initial = {
        "angles": [draw.real(-0.6, 0.2) for _ in links],
        "angular_velocities": [draw.real(-3.0, 3.0) for _ in links],
    }
    if pinned:
        box = {"y_min": -draw.real(0.6, 0.9) * size}
    else:
        box = {"y_min": 0.0} | ({"x_max": size + 0.2} if draw.chance(0.3) else {})
        initial["position"] = [0.0, draw.real(0.7, 1.2) * max(size, 0.4)]
        initial["velocity"] = [draw.real(-2.0, 2.0), draw.real(-1.0, 1.0)]
    scene = {
        "name": "Random",
        "chain": {"base": "pinned" if pinned else "free", "links": links},
        "box": box,
        "contact": contact,
        "initial": initial,
        "outputs": {"loads": True},
        "solver": {"tolerance": 1e-10, "method": asked.get("method", "auto")},
        "simulation": {"stop_time": asked.get("stop", 1.0), "step_size": 1e-3},
    }
    if asked.get("stops"):
        stops = draw.one((law, of_law("zhang_sharf")))
        scene["stops"] = {**stops, "stiffness": draw.power(1e2, 1e4), "restitution": draw.real(0.2, 0.7)}
    return scene, {}


def with_tip_force(draw: Draw) -> Given:
    """Return a chain with a force at its tip that is piecewise linear in time."""
    scene, _ = thrown(draw, friction=0.3)
    times = [0.0, draw.real(0.1, 0.4), draw.real(0.5, 0.7), 1.0]
    scene["inputs"] = {"tip_force": True}
    return scene, {f"tip.force.{axis}": (times, [draw.real(-3.0, 3.0) for _ in times]) for axis in "xy"}


def servos(draw: Draw) -> Given:
    """Return an arm with stiff servos, which reach the limits of their torques as it falls on a floor."""
    links = [
        {
            "length": draw.real(0.2, 0.5),
            "mass": draw.power(0.2, 4.0),
            "joint_stiffness": draw.power(50.0, 5e4),
            "joint_damping": draw.power(2.0, 80.0),
            "joint_torque_limit": draw.power(3.0, 80.0),
            "joint_armature": 0.01,
        }
        for _ in range(draw.whole(1, 3))
    ]
    size = sum(link["length"] for link in links)
    return {
        "name": "Servos",
        "chain": {"base": "pinned", "links": links},
        "box": {"y_min": -draw.real(0.3, 0.6) * size},
        "contact": {"restitution": 0.3, "stiffness": 1e6},
        "inputs": {"joint_targets": True},
        "initial": {"angles": [draw.real(-0.15, 0.15) for _ in links]},
        "outputs": {"loads": True},
        "solver": {"tolerance": 1e-9},
        "simulation": {"stop_time": 0.2, "step_size": 1e-3},
    }, {}


KINDS: dict[str, Callable[[Draw], Given]] = {
    "soft": lambda draw: thrown(draw, 1e4),
    "stiff": thrown,
    "dry": lambda draw: thrown(draw, friction=1.0),
    "dry and soft": lambda draw: thrown(draw, 1e4, friction=1.0, pinned=False),
    "implicit": lambda draw: thrown(draw, 1e8, friction=0.3, method="implicit", stop=0.6),
    "stops": lambda draw: thrown(draw, stops=True),
    "rigid": lambda draw: thrown(draw, rigid=True),
    "rigid stops": lambda draw: thrown(draw, rigid=True, stops=True),
    "driven": with_tip_force,
    "servos": servos,
    "carts": carts,
    "moved bases": moved_bases,
    "bodies": bodies,
}


def given(kind: str, seed: int) -> tuple[Scene, dict[str, Any], list[str]] | None:
    """Return a scene of a kind with all values given, its inputs, and at most three of PARAMETERS.

    None if the package refuses the scene, for example because it starts in a wall.
    """
    draw = Draw([*KINDS].index(kind), seed)
    table, inputs = KINDS[kind](draw)
    try:
        scene = scene_from_dict(table, "random")
    except SceneError:
        return None
    scene = scene_from_dict(scene_to_dict(scene, derived=True), "random")
    names = [name for name in PARAMETERS if scene.values.get(name)]
    return (
        scene,
        inputs,
        [str(name) for name in draw.generator.choice(names, min(3, len(names)), replace=False)],
    )


def check(kind: str, seed: int) -> Checked:
    """Return the comparison of the derivatives of a scene; it is empty if the package refuses the scene.

    Only derivatives that are also wrong at a smaller tolerance, with larger differences, count as wrong.
    """
    case = given(kind, seed)
    if case is None:
        return Checked()
    checked = compare(*case)
    if checked.wrong:
        finer = case[0].with_values({"solver.tolerance": 1e-12})
        again = {fault[:3] for fault in compare(finer, *case[1:], scale=3.0).wrong}
        checked.wrong = [fault for fault in checked.wrong if fault[:3] in again]
    return checked


def compare(scene: Scene, inputs: dict[str, Any], parameters: list[str], scale: float = 1.0) -> Checked:
    """Return the comparison of derivatives with differences whose sizes are ``scale`` times SIZES.

    It is empty if one of the runs ends early.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            result = simulate(scene, inputs=inputs, sensitivities=parameters)
            checked = Checked()
            for parameter in parameters:
                near = [moved(scene, inputs, parameter, scale * size) for size in SIZES]
                compare_one(result, parameter, scene.values[parameter], near, checked)
        except SimulationError:
            return Checked()
    return checked


def moved(scene: Scene, inputs: dict[str, Any], parameter: str, size: float) -> tuple[Result, Result, float]:
    """Return runs with a larger and a smaller parameter, and the difference between the two values."""
    value = scene.values[parameter]
    more, less = (
        simulate(scene.with_values({parameter: value * (1.0 + sign * size)}), inputs=inputs)
        for sign in (1, -1)
    )
    return more, less, 2.0 * size * value


def compare_one(result: Result, parameter: str, value: float, near: Any, checked: Checked) -> None:
    """Compare the derivatives of all outputs by a parameter, and of the impacts if all runs have as many.

    ``near`` are the results of ``moved`` for two sizes. The comparison is added to ``checked``.
    """
    by = result.sensitivities
    columns = [name for name in by.columns if name in result.columns and name != "time"]
    values = np.stack([result[name] for name in columns], 1)
    slopes = np.stack([result.sensitivity(name, parameter) for name in columns], 1)
    first, other = (
        np.stack([more[name] - less[name] for name in columns], 1) / width for more, less, width in near
    )
    largest = np.abs(other).max(0)
    floor = LEAST * np.maximum(largest, np.abs(values).max(0) / abs(value))
    uncertainty = OPEN * left_open(result) * largest + ROUND_OFF / abs(near[0][2])
    wrong, compared = differ(slopes, first, other, floor, uncertainty)
    checked.rows += int(compared.any(1).sum())
    checked.compared += int(compared.sum())
    for t, j in np.argwhere(wrong):
        checked.wrong.append(
            (parameter, float(result.time[t]), columns[j], float(slopes[t, j]), float(first[t, j]))
        )
    impacts, all_of_them = result.impacts, [run.impacts for more, less, _ in near for run in (more, less)]
    if any(len(few) != len(impacts) for few in all_of_them):
        return
    for name in DIFFERENTIABLE_COLUMNS:
        rows = result.impact_sensitivity(name, parameter)
        first, other = ((more.impacts[name] - less.impacts[name]) / width for more, less, width in near)
        most = OPEN * left_open(result) * np.nanmax(np.abs(rows), initial=0.0)
        wrong, compared = differ(rows, first, other, LEAST * np.abs(impacts[name]) / abs(value), most)
        checked.compared += int(compared.sum())
        for i in np.flatnonzero(wrong):
            label = f"{name} of impact {i + 1}"
            checked.wrong.append(
                (parameter, float(impacts["onset"][i]), label, float(rows[i]), float(first[i]))
            )


def left_open(result: Result) -> float:
    """Return the error of derivatives that a run reports, over the largest derivative.

    With friction the result is at least SAME_TIME_SLOPE, because a run does not report smaller errors.
    """
    untold = SAME_TIME_SLOPE if any(name.endswith("friction_impulse") for name in result.columns) else 0.0
    return max(shares_left_open(result), default=untold)


def differ(
    slopes: Any, first: Any, other: Any, floor: Any, uncertainty: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Return which derivatives are wrong, and which are compared: those for which both differences agree.

    ``first`` and ``other`` are the differences. ``floor`` is the least size to which errors are relative, and
    ``uncertainty`` the error that the run reports, with the round-off of differences.
    """
    size, apart = np.maximum(np.abs(other), floor + 1e-9), np.abs(first - other)
    compared = (apart <= AGREE * size) & ~np.isnan(slopes)
    return compared & ~(np.abs(slopes - first) <= WRONG * size + 3.0 * apart + uncertainty), compared


def main() -> None:
    kind, first, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    rows, compared = 0, 0
    for seed in range(first, first + count):
        checked = check(kind, seed)
        rows, compared = rows + checked.rows, compared + checked.compared
        for fault in checked.wrong[:3]:
            print(kind, seed, *fault)
    print(f"{kind}: {count} scenes, {rows} rows, {compared} derivatives")


if __name__ == "__main__":
    main()

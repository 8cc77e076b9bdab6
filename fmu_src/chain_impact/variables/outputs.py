"""The outputs among the variables of the FMU: those that the scene asks for in its table ``outputs``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.names import AXES
from chain_impact.scene.scene import Scene
from chain_impact.variables.variable import OBSERVED, Variable

OWNERS = {
    **dict.fromkeys(("point_position", "point_velocity", "point_acceleration"), "point"),
    **dict.fromkeys(("angle", "angular_velocity", "angular_acceleration"), "link"),
    **dict.fromkeys(("force", "penetration", "penetration_rate", "impulse"), "contact"),
}
"""Field of the output record with many elements → what each of them is of, the first part of its name."""
_STATUSES = "; ".join(f"{code} {text}" for code, text in STATUS_TEXT.items())


def _output(
    name: str,
    unit: str,
    description: str,
    *place: str | int,
    minimum: float | None = None,
    maximum: float | None = None,
    held: bool = False,
) -> Variable:
    """An output; what the kernel observes changes continuously, all else only at events and steps."""
    return Variable(
        name=name,
        type="real" if unit else "integer",
        causality="output",
        variability="continuous" if place[0] in OBSERVED and unit else "discrete",
        unit=unit,
        description=description,
        place=place,
        minimum=minimum,
        maximum=maximum,
        held=held,
    )


def all_outputs(scene: Scene, candidates: Sequence[tuple[int, int]]) -> Iterator[Variable]:
    """The outputs that the scene asks for, with those of its candidates."""
    asked = scene.outputs
    if asked.points:
        yield from _points(scene)
    if asked.links:
        yield from _links(scene)
    if asked.contacts:
        yield from _contacts(scene, candidates)
    if asked.energies:
        yield from _energies(scene)
    yield from _last_impact(scene)
    yield from _latest_impacts(scene)
    if asked.solver:
        yield from _statistics()


def _points(scene: Scene) -> Iterator[Variable]:
    vectors = (("position", "", "m"), ("velocity", "v", "m/s"), ("acceleration", "a", "m/s2"))
    for k in range(len(scene.chain.links) + 1):
        held = k == 0 and scene.chain.base == "pinned"
        for quantity, prefix, unit in vectors:
            for j, axis in enumerate(AXES):
                name, text = f"point[{k}].{prefix}{axis}", f"point {k}: {axis} of the {quantity}"
                yield _output(name, unit, text, "output", f"point_{quantity}", k, j, held=held)


def _links(scene: Scene) -> Iterator[Variable]:
    rotations = (("angle", "rad"), ("angular_velocity", "rad/s"), ("angular_acceleration", "rad/s2"))
    for i in range(len(scene.chain.links)):
        for quantity, unit in rotations:
            text = f"link {i + 1}: {quantity.replace('_', ' ')}, absolute, from +x"
            yield _output(f"link[{i + 1}].{quantity}", unit, text, "output", quantity, i)


def _contacts(scene: Scene, candidates: Sequence[tuple[int, int]]) -> Iterator[Variable]:
    touches = (
        ("force", "N", "force of the wall, along its normal"),
        ("penetration", "m", "penetration, 0 when apart"),
        ("penetration_rate", "m/s", "rate of penetration, positive when closing, 0 when apart"),
        ("impulse", "N.s", "impulse of the wall since the start, along its normal"),
    )
    for c, (point, number) in enumerate(candidates):
        wall = scene.wall_names[number]
        for quantity, unit, text in touches:
            name, where = f"contact[{point}].{wall}.{quantity}", f"point {point} at {wall}"
            least = 0.0 if quantity == "penetration" else None
            yield _output(name, unit, f"{where}: {text}", "output", quantity, c, minimum=least)


def _energies(scene: Scene) -> Iterator[Variable]:
    texts = {
        "kinetic": "kinetic energy",
        "potential": "potential energy of gravity, zero at the origin",
        "elastic": "energy stored in the contacts and in the springs of joints",
        "dissipated": "energy lost in contacts and joint damping since the start",
        "supplied": "energy supplied by the inputs since the start",
        "total": "kinetic, potential and elastic energy",
    }
    if not (scene.inputs.joint_torques or scene.inputs.tip_force):
        del texts["supplied"]
    for key, text in texts.items():
        yield _output(f"energy.{key}", "J", text, "output", key, minimum=0.0 if key == "kinetic" else None)


def _last_impact(scene: Scene) -> Iterator[Variable]:
    walls = _wall_numbers(scene)
    texts = {
        "count": ("", "impacts since the start"),
        "last_time": ("s", "time of the last impact, of the start before the first"),
        "last_point": ("", "point of the last impact, -1 before the first"),
        "last_wall": ("", f"wall of the last impact: 0 none, {walls}"),
        "last_speed": ("m/s", "approach speed at the last impact, 0 before the first"),
    }
    limits = {
        "count": (0, None),
        "last_point": (-1, len(scene.chain.links)),
        "last_wall": (0, len(scene.wall_names)),
        "last_speed": (0.0, None),
    }
    for key, (unit, text) in texts.items():
        least, most = limits.get(key, (None, None))
        yield _output(f"impact.{key}", unit, text, "impact", key, minimum=least, maximum=most)


def _latest_impacts(scene: Scene) -> Iterator[Variable]:
    walls = _wall_numbers(scene)
    quantities = (
        ("time", "s", "time of its onset, 0 if there is none", None, None),
        ("point", "", "point, -1 if there is none", -1, len(scene.chain.links)),
        ("wall", "", f"wall: 0 if there is none, {walls}", 0, len(scene.wall_names)),
        ("speed", "m/s", "approach speed at its onset", 0.0, None),
        ("end", "s", "time of its end, the present time if it lasts", None, None),
        (
            "separation_speed",
            "m/s",
            "speed from the wall at its end, the present one if it lasts",
            None,
            None,
        ),
        ("peak_force", "N", "largest force so far, infinite for an impulse of a rigid wall", 0.0, None),
        ("max_penetration", "m", "largest penetration so far", 0.0, None),
        ("impulse", "N.s", "impulse of the wall so far", None, None),
    )
    for j in range(scene.outputs.impacts):
        of = "latest impact" if j == 0 else f"latest impact but {j}"
        for key, unit, text, least, most in quantities:
            name = f"impact[{j + 1}].{key}"
            yield _output(name, unit, f"{of}: {text}", "latest", key, j, minimum=least, maximum=most)


def _wall_numbers(scene: Scene) -> str:
    """The numbers of the walls in words.

    They are integers and no enumeration: importers count those from 1, with no room for "none".
    """
    return ", ".join(f"{w} {wall}" for w, wall in enumerate(scene.wall_names, 1))


def _statistics() -> Iterator[Variable]:
    texts = {
        "steps": "accepted steps of the solver",
        "rejected_steps": "rejected steps of the solver",
        "rhs_evaluations": "evaluations of the equations of motion by the solver",
        "implicit_steps": "accepted implicit steps",
        "status": f"status of the solver: {_STATUSES}",
    }
    for key, text in texts.items():
        most = max(STATUS_TEXT) if key == "status" else None
        yield _output(f"solver.{key}", "", text, "statistics", key, minimum=0, maximum=most)

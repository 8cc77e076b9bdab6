"""The outputs among the variables of the FMU: those that the scene asks for in its table ``outputs``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from chain_impact.kernel.rows.geometry import WALLS
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING, STATUS_TEXT
from chain_impact.scene.candidates import point_wall_pairs, stop_pairs
from chain_impact.scene.names import AXES
from chain_impact.scene.scene import Scene
from chain_impact.scene.tables import Outputs
from chain_impact.variables.variable import OBSERVED, Variable

SHAPES = 64  # of scenes, whose outputs are kept
OWNERS = {
    **dict.fromkeys(("point_position", "point_velocity", "point_acceleration"), "point"),
    **dict.fromkeys(("angle", "angular_velocity", "angular_acceleration"), "link"),
    **dict.fromkeys(("force", "penetration", "penetration_rate", "impulse"), "contact"),
    **dict.fromkeys(("friction.force", "friction.impulse", "friction.sticking"), "contact"),
}
"""Field of the output record with many elements → what each of them is of, the first part of its name."""
LABELS = {field: field.removeprefix("point_").replace(".", "_") for field in OWNERS} | {
    "friction.sticking": "sticking"
}
"""Field of the output record with many elements → what all of them together are called."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """All of a scene that its outputs depend on: scenes of one shape have the same outputs.

    Attributes:
        links: how many.
        pinned: whether the base is.
        pairs: the pairs of a point and a wall that can touch.
        stops: the stops, as such pairs of a joint and a wall.
        wall_names: as of the scene.
        contact_friction: whether a contact may have dry friction.
        friction_joints: the joints with dry friction.
        asked: which outputs the scene asks for.
        is_driven: whether energy may be supplied.
        base_moves: whether inputs move the base.
        moving_walls: the names of the walls that inputs move.
    """

    links: int
    pinned: bool
    pairs: tuple[tuple[int, int], ...]
    stops: tuple[tuple[int, int], ...]
    wall_names: tuple[str, ...]
    contact_friction: bool
    friction_joints: tuple[int, ...]
    asked: Outputs
    is_driven: bool
    base_moves: bool
    moving_walls: tuple[str, ...]

    @property
    def has_friction(self) -> bool:
        """Whether a contact or a joint may have dry friction."""
        return self.contact_friction or bool(self.friction_joints)


def shape_of(scene: Scene) -> Shape:
    """The shape of a scene."""
    return Shape(
        links=len(scene.chain.links),
        pinned=scene.chain.base == "pinned",
        pairs=tuple(point_wall_pairs(scene)),
        stops=() if scene.stops.exponent is None else tuple(stop_pairs(scene)),
        wall_names=scene.wall_names,
        contact_friction=scene.has_contact_friction,
        friction_joints=scene.friction_joints,
        asked=scene.outputs,
        is_driven=scene.is_driven,
        base_moves=scene.inputs.base_motion,
        moving_walls=scene.moving_walls,
    )


def all_outputs(scene: Scene) -> dict[str, Variable]:
    """The outputs that the scene asks for, by their names, those of its candidates too. They are kept."""
    return outputs_of(shape_of(scene))


@lru_cache(SHAPES)
def outputs_of(shape: Shape) -> dict[str, Variable]:
    """The outputs of all scenes of a shape, made once: that takes as long as a short simulation."""
    return {variable.name: variable for variable in _outputs(shape)}


def _outputs(shape: Shape) -> Iterator[Variable]:
    asked = shape.asked
    if asked.points:
        yield from _points(shape)
    if asked.links:
        yield from _links(shape)
    yield from _joints(shape)
    if asked.contacts:
        yield from _contacts(shape)
        yield from _motions(shape)
        yield from _stops(shape)
        yield from _joint_friction(shape)
    if asked.energies:
        yield from _energies(shape)
    if asked.loads:
        yield from _joint_loads(shape)
        yield from _wall_loads(shape)
    yield from _last_impact(shape)
    yield from _latest_impacts(shape)
    if asked.solver:
        yield from _statistics(shape)


def _points(shape: Shape) -> Iterator[Variable]:
    vectors = (("position", "", "m"), ("velocity", "v", "m/s"), ("acceleration", "a", "m/s2"))
    for k in range(shape.links + 1):
        held = k == 0 and shape.pinned and not shape.base_moves
        for quantity, prefix, unit in vectors:
            for j, axis in enumerate(AXES):
                name, text = f"point[{k}].{prefix}{axis}", f"point {k}: {axis} of the {quantity}"
                yield _output(name, unit, text, "output", f"point_{quantity}", k, j, held=held)


def _links(shape: Shape) -> Iterator[Variable]:
    rotations = (
        ("angle", "rad", "angle, absolute, from +x"),
        ("angular_velocity", "rad/s", "angular velocity, absolute"),
        ("angular_acceleration", "rad/s2", "angular acceleration, absolute"),
    )
    for i in range(shape.links):
        for quantity, unit, text in rotations:
            yield _output(f"link[{i + 1}].{quantity}", unit, f"link {i + 1}: {text}", "output", quantity, i)


def _joints(shape: Shape) -> Iterator[Variable]:
    rotations = (("angle", "rad", "angle"), ("angular_velocity", "rad/s", "angular velocity"))
    for i in range(0 if shape.pinned else 1, shape.links):
        of = f"of link {i + 1} relative to " + ("the link before" if i > 0 else "the ground, from +x")
        for quantity, unit, text in rotations:
            place = ("output", f"joint_{quantity}", i)
            yield _output(f"joint[{i + 1}].{quantity}", unit, f"joint {i + 1}: {text} {of}", *place)


def _contacts(shape: Shape) -> Iterator[Variable]:
    touches = (
        ("force", "N", "force of the wall, along its normal"),
        ("penetration", "m", "penetration, 0 when apart"),
        ("penetration_rate", "m/s", "rate of penetration, positive when closing, 0 when apart"),
        ("impulse", "N.s", "impulse of the wall since the start, along its normal"),
    )
    rubs = shape.contact_friction
    for c, (point, number) in enumerate(shape.pairs):
        wall = shape.wall_names[number]
        for quantity, unit, text in touches:
            name, where = f"contact[{point}].{wall}.{quantity}", f"point {point} at {wall}"
            least = 0.0 if quantity == "penetration" else None
            yield _output(name, unit, f"{where}: {text}", "output", quantity, c, minimum=least)
        if rubs:
            yield from _contact_friction(f"contact[{point}].{wall}", f"point {point} at {wall}", c)


def _motions(shape: Shape) -> Iterator[Variable]:
    """How far walls and belts have moved."""
    channel = 2 if shape.base_moves else 0
    for wall in shape.moving_walls:
        moved = {
            "position": "how far it has moved along its inward normal n",
            "belt_position": "how far its belt has moved along t = (n_y, -n_x)",
        }
        for k, (key, text) in enumerate(moved.items()):
            place = ("output", "channel", channel + k)
            yield _output(f"wall.{wall}.{key}", "m", f"at wall {wall}: {text}", *place)
        channel += 2


def _contact_friction(name: str, where: str, c: int) -> Iterator[Variable]:
    """The dry friction of candidate c."""
    along = "along t = (n_y, -n_x) of its normal n"
    touches = (
        ("force", "friction_force", "N", f"dry friction of the wall, {along}"),
        ("impulse", "friction_impulse", "N.s", f"impulse of dry friction since the start, {along}"),
    )
    for field, key, unit, text in touches:
        yield _output(f"{name}.{key}", unit, f"{where}: {text}", "output", "friction", field, c)
    yield _sticking(name, where, "sticking", c)


def _joint_friction(shape: Shape) -> Iterator[Variable]:
    """The dry friction in joints."""
    for joint in shape.friction_joints:
        name, where = f"joint[{joint}]", f"joint {joint}"
        text = f"{where}: moment of dry friction on link {joint}"
        place = ("output", "friction", "joint_moment", joint - 1)
        yield _output(f"{name}.friction_moment", "N.m", text, *place)
        yield _sticking(name, where, "joint_sticking", joint - 1)


def _sticking(name: str, where: str, field: str, index: int) -> Variable:
    """Whether something sticks. It is a real number, which FMI lets change at any time."""
    place = ("output", "friction", field, index)
    text = f"{where}: 1 while it sticks by dry friction, else 0"
    return _output(f"{name}.sticking", "1", text, *place, minimum=0.0, maximum=1.0)


def _stops(shape: Shape) -> Iterator[Variable]:
    """The outputs of each joint with a stop: the kernel puts them in the place of its first candidate."""
    touches = (
        ("force", "stop_moment", "N.m", "moment of its stops, positive at joint_min"),
        ("penetration", "stop_penetration", "rad", "angle beyond a stop, 0 when apart"),
        ("impulse", "stop_impulse", "N.m.s", "impulse of its stops since the start, positive at joint_min"),
    )
    first: dict[int, int] = {}
    for c, (joint, _) in enumerate(shape.stops, len(shape.pairs)):
        first.setdefault(joint, c)
    for joint, c in first.items():
        for quantity, key, unit, text in touches:
            least = 0.0 if quantity == "penetration" else None
            name = f"joint[{joint}].{key}"
            yield _output(name, unit, f"joint {joint}: {text}", "output", quantity, c, minimum=least)


def _energies(shape: Shape) -> Iterator[Variable]:
    texts = {
        "kinetic": "kinetic energy",
        "potential": "potential energy of gravity, zero at the origin",
        "elastic": "energy stored in the contacts and in the springs of joints",
        "dissipated": "energy lost in contacts and joint damping since the start",
        "supplied": "energy supplied by the inputs and by drives of joints since the start",
        "total": "kinetic, potential and elastic energy",
    }
    if not shape.is_driven:
        del texts["supplied"]
    if shape.has_friction:
        texts["dissipated"] = "energy lost in contacts, joint damping and dry friction since the start"
    for key, text in texts.items():
        yield _output(f"energy.{key}", "J", text, "output", key, minimum=0.0 if key == "kinetic" else None)
    if shape.has_friction:
        text = "energy lost in dry friction since the start, part of energy.dissipated"
        yield _output("energy.friction", "J", text, "output", "friction", "dissipated")


def _joint_loads(shape: Shape) -> Iterator[Variable]:
    """What each joint transmits: its row is that of its link."""
    for i in range(0 if shape.pinned else 1, shape.links):
        name = f"joint[{i + 1}]"
        of = f"of {'the link before' if i > 0 else 'the ground'} on link {i + 1}"
        quantities = [
            *((f"force.{axis}", "N", f"{axis} of the force {of}", axis) for axis in AXES),
            ("moment", "N.m", f"moment {of}: drive, spring, damper, friction and stops", "moment"),
            *(
                (f"impulse.{axis}", "N.s", f"{axis} of the impulse {of} since the start", f"impulse_{axis}")
                for axis in AXES
            ),
            ("peak_force", "N", f"largest force {of} since the start", "peak"),
        ]
        for key, unit, text, field in quantities:
            least = 0.0 if field == "peak" else None
            place = ("output", "load", field, i)
            yield _output(f"{name}.{key}", unit, f"joint {i + 1}: {text}", *place, minimum=least)


def _wall_loads(shape: Shape) -> Iterator[Variable]:
    """What the chain exerts on each wall that a point can touch: its row comes after those of the links."""
    for number in sorted({number for _, number in shape.pairs}):
        wall, about = shape.wall_names[number], "the origin" if number < len(WALLS) else "its point"
        quantities = [
            *((f"load.{axis}", "N", f"{axis} of the force of the chain on the wall", axis) for axis in AXES),
            ("load_moment", "N.m", f"moment of the chain on the wall, about {about}", "moment"),
        ]
        for key, unit, text, field in quantities:
            place = ("output", "load", field, shape.links + number)
            yield _output(f"wall.{wall}.{key}", unit, f"at wall {wall}: {text}", *place)


def _last_impact(shape: Shape) -> Iterator[Variable]:
    walls, of_stop = _wall_numbers(shape), _of_stops(shape)
    texts = {
        "count": ("", "impacts since the start"),
        "last_time": ("s", "time of the last impact, of the start before the first"),
        "last_point": ("", f"point of the last impact, -1 before the first{of_stop['point']}"),
        "last_wall": ("", f"wall of the last impact: 0 none, {walls}"),
        "last_speed": ("m/s", f"approach speed at the last impact, 0 before the first{of_stop['speed']}"),
    }
    limits = {
        "count": (0, None),
        "last_point": (-1, shape.links),
        "last_wall": (0, len(shape.wall_names)),
        "last_speed": (0.0, None),
    }
    for key, (unit, text) in texts.items():
        least, most = limits.get(key, (None, None))
        yield _output(f"impact.{key}", unit, text, "impact", key, minimum=least, maximum=most)


def _latest_impacts(shape: Shape) -> Iterator[Variable]:
    walls, of_stop = _wall_numbers(shape), _of_stops(shape)
    quantities = (
        ("time", "s", "time of its onset, 0 if there is none", None, None),
        ("point", "", f"point, -1 if there is none{of_stop['point']}", -1, shape.links),
        ("wall", "", f"wall: 0 if there is none, {walls}", 0, len(shape.wall_names)),
        ("speed", "m/s", f"approach speed at its onset{of_stop['speed']}", 0.0, None),
        ("end", "s", "time of its end, the present time if it lasts", None, None),
        (
            "separation_speed",
            "m/s",
            f"speed from the wall at its end, the present one if it lasts{of_stop['speed']}",
            None,
            None,
        ),
        (
            "peak_force",
            "N",
            f"largest force so far, 0 for an impulse of a rigid wall{of_stop['force']}",
            0.0,
            None,
        ),
        ("max_penetration", "m", f"largest penetration so far{of_stop['penetration']}", 0.0, None),
        ("impulse", "N.s", f"impulse of the wall so far{of_stop['impulse']}", None, None),
    )
    for j in range(shape.asked.impacts):
        of = "latest impact" if j == 0 else f"latest impact but {j}"
        for key, unit, text, least, most in quantities:
            name = f"impact[{j + 1}].{key}"
            yield _output(name, unit, f"{of}: {text}", "latest", key, j, minimum=least, maximum=most)


def _of_stops(shape: Shape) -> dict[str, str]:
    """What the quantities of an impact are of a stop, in words; nothing for a scene without stops."""
    texts = {
        "point": "; of a stop its joint",
        "speed": "; of a stop in rad/s",
        "force": "; of a stop the moment in N.m",
        "penetration": "; of a stop the angle in rad",
        "impulse": "; of a stop in N.m.s",
    }
    return texts if shape.stops else dict.fromkeys(texts, "")


def _wall_numbers(shape: Shape) -> str:
    """The numbers of the walls in words.

    They are integers and no enumeration: importers count those from 1, with no room for "none".
    """
    return ", ".join(f"{w} {wall}" for w, wall in enumerate(shape.wall_names, 1))


def _statistics(shape: Shape) -> Iterator[Variable]:
    without = () if shape.contact_friction else (FRICTION_WITH_RIGID_WALLS, STATIC_BELOW_SLIDING)
    statuses = {code: text for code, text in STATUS_TEXT.items() if code not in without}
    listed = "; ".join(f"{code} {text}" for code, text in statuses.items())
    texts = {
        "steps": "accepted steps of the solver",
        "rejected_steps": "rejected steps of the solver",
        "rhs_evaluations": "evaluations of the equations of motion by the solver",
        "implicit_steps": "accepted implicit steps",
        "status": f"status of the solver: {listed}",
    }
    for key, text in texts.items():
        most = max(statuses) if key == "status" else None
        yield _output(f"solver.{key}", "", text, "statistics", key, minimum=0, maximum=most)

"""The tables of a scene file, except [chain] and [signals]: dataclasses whose fields are the tables' keys.

The metadata of each field have unit, description, range and default; see ``scene_key`` in key_rules.py.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SOLVER_METHODS
from chain_impact.kernel.record.contacts import LATEST_COUNT
from chain_impact.scene.keys.default_rules import (
    JOINT_SUMS,
    MOVABLE,
    ZERO_RULE,
    ZEROS,
    as_in_contact,
    default_if_stops,
)
from chain_impact.scene.rules.key_rules import IDENTIFIER, scene_key
from chain_impact.scene.texts.input_table import INPUT_KEYS

_RESERVED = ("con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10)))
_ANY_CASE = "|".join("".join(f"[{c.upper()}{c}]" if c.isalpha() else c for c in name) for name in _RESERVED)
MODEL_NAME = (  # the rule ``pattern`` for the key ``name`` of a scene, so that files can have this name
    rf"(?!(?:{_ANY_CASE})$){IDENTIFIER[0]}",
    f"{IDENTIFIER[1]}, and no name that Windows reserves: con, prn, aux, nul, com1 to com9, lpt1 to lpt9",
)
XML_TEXT = (r"[^\x00-\x08\x0B\x0C\x0E-\x1F\uD800-\uDFFF\uFFFE\uFFFF]*", "text without control characters")
_VARIABLE_NAME = (r"[A-Za-z][A-Za-z0-9_.*\[\]]*", "the name of a parameter or an input, with * for any text")
_PYTHON_FILE = (r"|[^\x00]*\.py", "the path of a Python file, from the folder of the scene")


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """The walls of the box, each parallel to x or y; a missing key (None) is a missing wall."""

    x_min: float | None = scene_key("m", "left wall", None, label="left")
    x_max: float | None = scene_key("m", "right wall", None, label="right")
    y_min: float | None = scene_key("m", "floor", None, label="floor")
    y_max: float | None = scene_key("m", "ceiling", None, label="ceiling")


@dataclass(frozen=True, slots=True, kw_only=True)
class Wall:
    """A straight, endless wall at any angle; a file may give a normal in place of the angle."""

    name: str = scene_key("", "name, different for each wall", pattern=IDENTIFIER)
    point: tuple[float, float] = scene_key("m", "a point on the wall")
    angle: float | None = scene_key(
        "rad", "direction of the wall, from +x; the left side is free", None, label="Angle"
    )
    normal: tuple[float, float] | None = scene_key("1", "in place of angle: a vector to the free side", None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """A table [contact.wall.<name>]: the material of one wall, a side of ``box`` or an entry of ``walls``.

    A value that the file does not give is None; then the value in [contact] applies. But if the file gives
    ``friction`` for the wall and no ``static_friction``, both coefficients of the wall are equal; so are they
    if ``static_friction`` is 0.
    """

    stiffness: float | None = scene_key(
        "N/m^exponent", "contact stiffness; if missing: as in [contact]", None, above=0.0
    )
    restitution: float | None = scene_key(
        "1", "prescribed restitution; if missing: as in [contact]", None, minimum=0.0, maximum=1.0
    )
    friction: float | None = scene_key(
        "1", "coefficient of sliding friction; if missing: as in [contact]", None, minimum=0.0
    )
    static_friction: float | None = scene_key(
        "1",
        "coefficient of static friction; if missing: the wall's friction, or else as in [contact]",
        None,
        minimum=0.0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """The points that may touch walls; the contact law of walls, of slider stops and, by default, [stops]."""

    law_file: str = scene_key("", "file with a law of your own, named as the law", "", pattern=_PYTHON_FILE)
    model: str = scene_key(
        "", "contact law", "zhang_sharf", choices=tuple(CONTACT_LAWS), extended_by="law_file"
    )
    stiffness: float = scene_key("N/m^exponent", "contact stiffness", 1e8, above=0.0, alone=True)
    exponent: float = scene_key("1", "exponent of penetration, 3/2 for Hertz", 1.5, minimum=1.0, maximum=3.0)
    restitution: float = scene_key("1", "prescribed restitution", 0.7, minimum=0.0, maximum=1.0, alone=True)
    radius: float = scene_key("m", "radius of each point without its own", 0.0, minimum=0.0)
    points: tuple[int, ...] = scene_key("", "ends of links that may touch, base (0) to tip (N)", MOVABLE)
    minimum_impact_speed: float = scene_key(
        "m/s",
        "an impact slower than this is damped as one at this speed; on a rigid wall it does not rebound",
        1e-3,
        above=0.0,
        alone=True,
    )
    friction: float = scene_key("1", "coefficient of sliding friction", ZERO_RULE, minimum=0.0)
    static_friction: float = scene_key(
        "1",
        "coefficient of static friction, not less than friction; 0: equal to friction",
        ZERO_RULE,
        minimum=0.0,
    )
    wall: Mapping[str, Material] = scene_key("", "materials of single walls, by the name of the wall", {})

    def __post_init__(self) -> None:
        """Sort ``points``: their order has no meaning, so equal sets of points must make equal scenes."""
        object.__setattr__(self, "points", tuple(sorted(self.points)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Stops:
    """The contact law of stops in joints, with angles and moments; all keys are None without such stops."""

    model: str | None = scene_key(
        "",
        "law; default: as in [contact]",
        None,
        choices=tuple(CONTACT_LAWS),
        extended_by="contact.law_file",
    )
    stiffness: float | None = scene_key(
        "N.m/rad^exponent", "stiffness of the stops", default_if_stops(1e5), above=0.0
    )
    exponent: float | None = scene_key(
        "1", "exponent of penetration at the stops", as_in_contact("exponent"), minimum=1.0, maximum=3.0
    )
    restitution: float | None = scene_key(
        "1", "prescribed restitution of the stops", as_in_contact("restitution"), minimum=0.0, maximum=1.0
    )
    minimum_impact_speed: float | None = scene_key(
        "rad/s",
        "a slower impact at a stop is damped as one at this speed; at a rigid stop it does not rebound",
        default_if_stops(1e-3),
        above=0.0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """The inputs that the scene asks for, for its FMU and for runs in Python."""

    joint_torques: bool = scene_key(
        "", "torques at the joints between links and at a base that is pinned or on a slider", False
    )
    slider_force: bool = scene_key("", "force on the carriage of a slider, along its line", False)
    joint_targets: bool = scene_key(
        "",
        "targets that all joints, and a slider, follow by their springs and dampers",
        False,
    )
    tip_force: bool = scene_key("", "force on the tip", False)
    base_motion: bool = scene_key("", "motion of a pinned base", False)
    wall_motion: tuple[str, ...] = scene_key(
        "",
        "names of the walls that move, or true for all: along their inward normals, and as belts",
        (),
        pattern=(rf"\*|{IDENTIFIER[0]}", "the name of a wall"),
        or_true=True,
    )

    @property
    def any(self) -> bool:
        """Whether the scene asks for inputs; inputs that signals drive count, too."""
        return any(getattr(self, key) for key in INPUT_KEYS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """The outputs that the scene asks for; every scene has the outputs of the last impact."""

    points: bool = scene_key("", "position, velocity and acceleration of the points", True)
    links: bool = scene_key("", "angle, its rate and acceleration of the links", True)
    contacts: bool = scene_key(
        "", "force, penetration, impulse and dry friction of each contact, stop and joint", True
    )
    impacts: int = scene_key("", "how many impacts, the latest ones", 8, minimum=0, maximum=LATEST_COUNT)
    energies: bool = scene_key("", "the energies", True)
    loads: bool = scene_key("", "forces and moments in the joints and on the walls, and their peaks", False)
    solver: bool = scene_key("", "steps, evaluations and status of the solver", True)
    sensitivities: tuple[str, ...] = scene_key(
        "", "parameters and inputs with respect to which outputs have derivatives", (), pattern=_VARIABLE_NAME
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Initial:
    """The state of the chain at the start of a run."""

    position: tuple[float, float] = scene_key("m", "position of the base", (0.0, 0.0), alone=True)
    joint_angles: tuple[float, ...] | None = scene_key(
        "rad",
        "angle of each link, relative to the link before, of link 1 from +x; in place of angles",
        None,
        per_link=True,
        file_only=True,
    )
    angles: tuple[float, ...] = scene_key(
        "rad", "angle of each link, absolute, from +x", JOINT_SUMS, per_link=True, alone=True
    )
    velocity: tuple[float, float] = scene_key("m/s", "velocity of the base", (0.0, 0.0), alone=True)
    angular_velocities: tuple[float, ...] = scene_key(
        "rad/s", "angular velocity of each link, absolute", ZEROS, per_link=True, alone=True
    )
    slider_velocity: float = scene_key("m/s", "velocity of a slider along its line", 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """The settings of the integration of the equations of motion."""

    method: str = scene_key("", "integration method", "auto", choices=SOLVER_METHODS, alone=True)
    tolerance: float = scene_key(
        "1", "relative error tolerance", 1e-8, minimum=1e-13, maximum=1e-2, alone=True
    )
    work_limit: float = scene_key(
        "1/s",
        "most evaluations of the right-hand side in a second of simulated time",
        5e6,
        above=0.0,
        alone=True,
    )


STEP_ROUND_OFF = 1e-12
"""[1] stop_time/step_size counts as a whole number if its relative difference from the nearest whole number
is smaller than this round-off"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """The default experiment: stop time and communication step."""

    stop_time: float = scene_key("s", "end of the simulation", 1.0, above=0.0, alone=True)
    step_size: float = scene_key("s", "communication step", 1e-3, above=0.0, alone=True)

"""The tables of a scene file: dataclasses whose fields are the keys of the tables.

The metadata of each field have unit, description, range and default; see scene.py.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.ode.control import SOLVER_METHODS
from chain_impact.kernel.record.contacts import LATEST
from chain_impact.scene.limits import quantity
from chain_impact.scene.names import INPUTS_OF, SLIDER_STOPS, STOPS
from chain_impact.scene.reading import refusal
from chain_impact.scene.rules import (
    CARRIAGE,
    CONTACT_RADIUS,
    FROM_JOINTS,
    MIDDLE,
    MOVABLE,
    ROD,
    ZEROS,
    as_in_contact,
    with_stops,
)

MAX_LINKS = 1000
CORNERS = 4  # number of corners of a box

IDENTIFIER = (r"[A-Za-z_][A-Za-z0-9_]*", "letters, digits and _, not beginning with a digit")
_RESERVED = ("con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(1, 10)))
_ANY_CASE = "|".join("".join(f"[{c.upper()}{c}]" if c.isalpha() else c for c in name) for name in _RESERVED)
OPTIONAL_NAME = (rf"({IDENTIFIER[0]})?", IDENTIFIER[1])
MODEL_NAME = (  # regular expression for names, which are also names of files
    rf"(?!(?:{_ANY_CASE})$){IDENTIFIER[0]}",
    f"{IDENTIFIER[1]}, and no name that Windows reserves: con, prn, aux, nul, com1 to com9, lpt1 to lpt9",
)
XML_TEXT = (r"[^\x00-\x08\x0B\x0C\x0E-\x1F\uD800-\uDFFF\uFFFE\uFFFF]*", "text without control characters")
_NAME = (r"[A-Za-z][A-Za-z0-9_.*\[\]]*", "the name of a parameter or an input, with * for any text")
_PYTHON_FILE = (r"|[^\x00]*\.py", "the path of a Python file, from the folder of the scene")


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """A point of a link that is not one of its two ends, such as a heel or a corner; it may touch walls."""

    x: float = quantity("m", "position along the link, from the joint nearer to the base")
    y: float = quantity("m", "position to the left of the link's line", 0.0)
    radius: float | None = quantity("m", "radius of the point", CONTACT_RADIUS, minimum=0.0)
    name: str = quantity("", "name in lists and pictures", "", pattern=OPTIONAL_NAME)

    @property
    def is_at_joint(self) -> bool:
        """Whether the point lies at the proximal joint of its link."""
        return self.x == self.y == 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """One rigid link, from its proximal joint to its other end; with a ``count``, that many equal links."""

    count: int | None = quantity(
        "", "number of equal links, 1 if missing", None, minimum=1, maximum=MAX_LINKS, file_only=True
    )
    length: float = quantity("m", "length", above=0.0)
    mass: float = quantity("kg", "mass", above=0.0)
    shape: str | None = quantity(
        "", "box: a rectangle, with a point at each corner and its inertia", None, choices=("box",)
    )
    height: float | None = quantity("m", "height of the box, across the link", None, above=0.0)
    center_of_mass: float = quantity(
        "m", "centre of mass, from the joint nearer to the base, behind which it may lie", MIDDLE
    )
    center_of_mass_offset: float = quantity(
        "m", "distance of the centre of mass from the link's line, to its left", 0.0
    )
    inertia: float = quantity("kg.m2", "inertia about the centre of mass", ROD, minimum=0.0)
    points: tuple[Site, ...] = quantity("", "points of the link, beside its ends, that may touch", ())
    joint_damping: float = quantity(
        "N.m.s/rad", "viscous damping of the joint nearer to the base", 0.0, minimum=0.0
    )
    joint_stiffness: float = quantity(
        "N.m/rad", "stiffness of the joint nearer to the base", 0.0, minimum=0.0
    )
    joint_rest_angle: float = quantity("rad", "angle of the joint at which its spring is slack", 0.0)
    joint_friction: float = quantity(
        "N.m", "moment of dry friction in the joint nearer to the base", 0.0, minimum=0.0
    )
    joint_armature: float = quantity(
        "kg.m2", "inertia of the rotor of the joint's drive, reflected through its gear", 0.0, minimum=0.0
    )
    joint_torque_limit: float | None = quantity(
        "N.m", "limit of the torque of motor, spring and damper together", None, minimum=0.0
    )
    joint_min: float | None = quantity("rad", "stop at the least angle of the joint nearer to the base", None)
    joint_max: float | None = quantity(
        "rad", "stop at the largest angle of the joint nearer to the base", None
    )

    @property
    def corners(self) -> int:
        """The number of points that are corners of the shape; these points come first."""
        return CORNERS if self.shape else 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Slider:
    """The carriage of a base that slides along a straight line through the initial position."""

    angle: float = quantity("rad", "direction of the line, from +x", 0.0)
    mass: float = quantity("kg", "mass of the carriage", 1.0, minimum=0.0)
    damping: float = quantity("N.s/m", "viscous damping along the line", 0.0, minimum=0.0)
    stiffness: float = quantity("N/m", "stiffness of a spring along the line", 0.0, minimum=0.0)
    rest_position: float = quantity("m", "position on the line at which the spring is slack", 0.0)
    friction: float = quantity("N", "force of dry friction along the line", 0.0, minimum=0.0)
    min: float | None = quantity("m", "stop at the least position of the carriage", None)
    max: float | None = quantity("m", "stop at the largest position of the carriage", None)
    force_limit: float | None = quantity(
        "N", "limit of the force of motor, spring and damper together", None, minimum=0.0
    )

    @property
    def stops(self) -> tuple[str, ...]:
        """The names, among the walls, of the existing stops of the slider."""
        return tuple(stop for stop in SLIDER_STOPS if getattr(self, stop.removeprefix("slider_")) is not None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainTable:
    """The links from base to tip, and the kind of base."""

    base: str = quantity(
        "",
        "base point: free to move, pinned, or on a slider",
        "free",
        choices=("free", "pinned", "slider"),
    )
    slider: Slider | None = quantity("", "carriage and line of a base on a slider", CARRIAGE)  # noqa: RUF009
    links: tuple[Link, ...] = quantity("", "links from base to tip", entries=(1, MAX_LINKS))

    def __post_init__(self) -> None:
        """Replace a link that has a `count` by this number of equal links; refuse too many links."""
        if (total := sum(link.count or 1 for link in self.links)) > MAX_LINKS:
            raise refusal(("chain", "links"), "links", count=total, most=MAX_LINKS)
        links = (replace(link, count=None) for link in self.links for _ in range(link.count or 1))
        object.__setattr__(self, "links", tuple(links))

    @property
    def movable_points(self) -> range:
        """The numbers of the joints and ends that can move: all points except a pinned base."""
        return range(1 if self.base == "pinned" else 0, len(self.links) + 1)

    @property
    def is_skewed(self) -> bool:
        """Whether the centre of mass of some link lies beside the link's line."""
        return any(link.center_of_mass_offset != 0.0 for link in self.links)

    @property
    def has_limits(self) -> bool:
        """Whether the drive of some joint, or of the slider, has a largest torque or force."""
        limits = [link.joint_torque_limit for link in self.links]
        limits += [self.slider.force_limit] if self.slider else []
        return any(limit is not None for limit in limits)

    @property
    def is_body(self) -> bool:
        """Whether some link is more than a line with two ends, or the base slides."""
        return self.is_skewed or self.slider is not None or any(link.points for link in self.links)

    @property
    def has_base_joint(self) -> bool:
        """Whether a joint connects link 1 with the base: the base is pinned, or slides."""
        return self.base != "free"

    @property
    def sites(self) -> tuple[tuple[int, Site], ...]:
        """The points of links, numbered from N + 1 on: the index of the link, and the point."""
        return tuple((i, site) for i, link in enumerate(self.links) for site in link.points)

    @property
    def joints(self) -> range:
        """The numbers of the joints, which are the numbers of their links; a free base has no joint 1."""
        return range(1 if self.has_base_joint else 2, len(self.links) + 1)

    @property
    def stops(self) -> tuple[tuple[int, str], ...]:
        """The existing stops as pairs: the number of the joint's link, and ``joint_min`` or ``joint_max``."""
        links = enumerate(self.links, 1)
        return tuple((i, stop) for i, link in links for stop in STOPS if getattr(link, stop) is not None)

    @property
    def joint_ranges(self) -> dict[int, tuple[float, float]]:
        """The joints with a stop → joint_min and joint_max [rad]; infinite for a missing stop."""
        links = {joint: self.links[joint - 1] for joint, _ in self.stops}
        none = (-math.inf, math.inf)
        return {
            joint: (
                none[0] if link.joint_min is None else link.joint_min,
                none[1] if link.joint_max is None else link.joint_max,
            )
            for joint, link in links.items()
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """The walls along the axes; a missing key (None) is a missing wall."""

    x_min: float | None = quantity("m", "left wall", None)
    x_max: float | None = quantity("m", "right wall", None)
    y_min: float | None = quantity("m", "floor", None)
    y_max: float | None = quantity("m", "ceiling", None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wall:
    """A straight, endless wall at any angle; a file may give a normal in place of the angle."""

    name: str = quantity("", "name, different for each wall", pattern=IDENTIFIER)
    point: tuple[float, float] = quantity("m", "a point on the wall")
    angle: float | None = quantity("rad", "direction of the wall, from +x; its left is free", None)
    normal: tuple[float, float] | None = quantity("1", "in place of angle: a vector to the free side", None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """The material of one wall of the box or of ``walls``: the values that differ from ``contact``."""

    stiffness: float | None = quantity(
        "N/m^exponent", "contact stiffness; if missing: as in [contact]", None, above=0.0
    )
    restitution: float | None = quantity(
        "1", "prescribed restitution; if missing: as in [contact]", None, minimum=0.0, maximum=1.0
    )
    friction: float | None = quantity(
        "1", "coefficient of sliding friction; if missing: as in [contact]", None, minimum=0.0
    )
    static_friction: float | None = quantity(
        "1",
        "coefficient of static friction; if missing: the wall's friction, or else as in [contact]",
        None,
        minimum=0.0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Contact:
    """The contact law of the walls, and the points that may touch the walls."""

    law_file: str = quantity("", "file with a law of your own, named as the law", "", pattern=_PYTHON_FILE)
    model: str = quantity(
        "", "contact law", "zhang_sharf", choices=tuple(CONTACT_LAWS), extended_by="law_file"
    )
    stiffness: float = quantity("N/m^exponent", "contact stiffness", 1e8, above=0.0)
    exponent: float = quantity("1", "exponent of penetration, 3/2 for Hertz", 1.5, minimum=1.0, maximum=3.0)
    restitution: float = quantity("1", "prescribed restitution", 0.7, minimum=0.0, maximum=1.0)
    radius: float = quantity("m", "radius of every point that may touch", 0.0, minimum=0.0)
    points: tuple[int, ...] = quantity("", "points that may touch, base (0) to tip (N)", MOVABLE)
    minimum_impact_speed: float = quantity(
        "m/s",
        "an impact slower than this is damped as one at this speed; on a rigid wall it does not rebound",
        1e-3,
        above=0.0,
    )
    friction: float = quantity("1", "coefficient of sliding friction", 0.0, minimum=0.0)
    static_friction: float = quantity(
        "1", "coefficient of static friction, not less than friction; 0: equal to it", 0.0, minimum=0.0
    )
    wall: Mapping[str, Material] = quantity("", "materials of single walls, by the name of the wall", {})

    def __post_init__(self) -> None:
        """Sort the points: the order of points has no meaning, so equal sets must make equal scenes."""
        object.__setattr__(self, "points", tuple(sorted(self.points)))


@dataclass(frozen=True, slots=True, kw_only=True)
class Stops:
    """The contact law of all stops in joints, for angles and moments; all keys are None without stops."""

    model: str | None = quantity(
        "",
        "law; default: as in [contact]",
        None,
        choices=tuple(CONTACT_LAWS),
        extended_by="contact.law_file",
    )
    stiffness: float | None = quantity(
        "N.m/rad^exponent", "stiffness of the stops", with_stops(1e5), above=0.0
    )
    exponent: float | None = quantity(
        "1", "exponent of penetration at the stops", as_in_contact("exponent"), minimum=1.0, maximum=3.0
    )
    restitution: float | None = quantity(
        "1", "prescribed restitution of the stops", as_in_contact("restitution"), minimum=0.0, maximum=1.0
    )
    minimum_impact_speed: float | None = quantity(
        "rad/s",
        "a slower impact at a stop is damped as one at this speed; at a rigid stop it does not rebound",
        with_stops(1e-3),
        above=0.0,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """The inputs of the FMU."""

    joint_torques: bool = quantity(
        "", "torques at the joints between links and at a base that is pinned or on a slider", False
    )
    slider_force: bool = quantity("", "force on the carriage of a slider, along its line", False)
    joint_targets: bool = quantity(
        "", "angles and angular velocities that these joints follow by their springs and dampers", False
    )
    tip_force: bool = quantity("", "force on the tip", False)
    base_motion: bool = quantity("", "motion of a pinned base", False)
    wall_motion: tuple[str, ...] = quantity(
        "",
        "names of the walls that move, or true for all: along their inward normals, and as belts",
        (),
        pattern=(rf"\*|{IDENTIFIER[0]}", "the name of a wall"),
        or_true=True,
    )

    @property
    def any(self) -> bool:
        """Whether the scene asks for inputs, also if signals drive all of them."""
        return any(getattr(self, key) for key in INPUTS_OF)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outputs:
    """The outputs of the FMU, besides the outputs of the last impact."""

    points: bool = quantity("", "position, velocity and acceleration of the points", True)
    links: bool = quantity("", "angle, its rate and acceleration of the links", True)
    contacts: bool = quantity(
        "", "force, penetration, impulse and dry friction of each contact, stop and joint", True
    )
    impacts: int = quantity("", "how many of the latest impacts", 8, minimum=0, maximum=LATEST)
    energies: bool = quantity("", "the energies", True)
    loads: bool = quantity("", "forces and moments in the joints and on the walls, and their peaks", False)
    solver: bool = quantity("", "steps, evaluations and status of the solver", True)
    sensitivities: tuple[str, ...] = quantity(
        "", "parameters and inputs with respect to which outputs have derivatives", (), pattern=_NAME
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Initial:
    """The state at time 0."""

    position: tuple[float, float] = quantity("m", "position of the base", (0.0, 0.0))
    joint_angles: tuple[float, ...] | None = quantity(
        "rad",
        "angle of each link, relative to the link before, of link 1 from +x; in place of angles",
        None,
        per_link=True,
        file_only=True,
    )
    angles: tuple[float, ...] = quantity(
        "rad", "angle of each link, absolute, from +x", FROM_JOINTS, per_link=True
    )
    velocity: tuple[float, float] = quantity("m/s", "velocity of the base", (0.0, 0.0))
    angular_velocities: tuple[float, ...] = quantity(
        "rad/s", "angular velocity of each link, absolute", ZEROS, per_link=True
    )
    slider_velocity: float = quantity("m/s", "velocity of a slider along its line", 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Solver:
    """The settings of the integration of the equations of motion."""

    method: str = quantity("", "integration method", "auto", choices=SOLVER_METHODS)
    tolerance: float = quantity("1", "relative error tolerance", 1e-8, minimum=1e-13, maximum=1e-2)
    work_limit: float = quantity(
        "1/s", "most evaluations of the right-hand side in a second of simulated time", 5e6, above=0.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """The default experiment."""

    stop_time: float = quantity("s", "end of the simulation", 1.0, above=0.0)
    step_size: float = quantity("s", "communication step", 1e-3, above=0.0)

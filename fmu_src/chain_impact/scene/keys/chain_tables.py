"""The tables of the chain in a scene file: links with their points, the slider, and the whole chain."""

import math
from dataclasses import dataclass, replace

from chain_impact.scene.errors import refusal
from chain_impact.scene.keys.default_rules import CONTACT_RADIUS, MIDDLE, ROD, SLIDER_TABLE, ZERO_RULE
from chain_impact.scene.rules.key_rules import IDENTIFIER, scene_key
from chain_impact.scene.texts.names import SLIDER_STOPS, STOPS

MAX_LINKS = 1000
BOX_CORNERS = 4  # number of corners of a link with the shape of a box
OPTIONAL_NAME = (rf"({IDENTIFIER[0]})?", IDENTIFIER[1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """A point of a link that is not one of the link's two ends, such as a heel; it may touch walls."""

    x: float = scene_key("m", "position along the link, from the joint nearer to the base", label="Along")
    y: float = scene_key("m", "position to the left of the link's line", 0.0, label="Left")
    radius: float | None = scene_key("m", "radius of the point", CONTACT_RADIUS, minimum=0.0, label="Radius")
    name: str = scene_key("", "name in lists and pictures", "", pattern=OPTIONAL_NAME, label="Name")

    @property
    def is_at_joint(self) -> bool:
        """Whether the point is at the proximal end of its link: both ``x`` and ``y`` are 0."""
        return self.x == self.y == 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """One rigid link and its proximal joint; an entry of a file with a ``count`` is that many such links."""

    count: int | None = scene_key(
        "", "number of equal links, 1 if missing", None, minimum=1, maximum=MAX_LINKS, file_only=True
    )
    length: float = scene_key("m", "length", above=0.0, label="Length")
    mass: float = scene_key("kg", "mass", above=0.0, alone=True, label="Mass")
    shape: str | None = scene_key(
        "", "box: a rectangle with its inertia, and with a point at each corner", None, choices=("box",)
    )
    height: float | None = scene_key(
        "m", "height of the box, across the link", None, above=0.0, label="Height"
    )
    center_of_mass: float = scene_key(
        "m",
        "centre of mass along the link, from the joint nearer to the base; negative behind this joint",
        MIDDLE,
        label="Centre of mass along",
    )
    center_of_mass_offset: float = scene_key(
        "m",
        "distance of the centre of mass from the link's line, to its left",
        ZERO_RULE,
        label="Centre of mass left",
    )
    inertia: float = scene_key(
        "kg.m2", "inertia about the centre of mass", ROD, minimum=0.0, alone=True, label="Inertia"
    )
    points: tuple[Site, ...] = scene_key("", "additional points of the link that may touch", ())
    joint_damping: float = scene_key(
        "N.m.s/rad", "viscous damping of the joint nearer to the base", 0.0, minimum=0.0, alone=True
    )
    joint_stiffness: float = scene_key(
        "N.m/rad", "stiffness of the joint nearer to the base", 0.0, minimum=0.0, alone=True
    )
    joint_rest_angle: float = scene_key("rad", "angle of the joint at which its spring is slack", 0.0)
    joint_friction: float = scene_key(
        "N.m", "moment of dry friction in the joint nearer to the base", ZERO_RULE, minimum=0.0
    )
    joint_armature: float = scene_key(
        "kg.m2",
        "inertia of the rotor of the joint's drive, reflected through its gear",
        ZERO_RULE,
        minimum=0.0,
    )
    joint_torque_limit: float | None = scene_key(
        "N.m", "limit of the torque of motor, spring and damper together", None, minimum=0.0
    )
    joint_min: float | None = scene_key(
        "rad", "stop at the least angle of the joint nearer to the base", None, label="Stop from"
    )
    joint_max: float | None = scene_key(
        "rad", "stop at the largest angle of the joint nearer to the base", None, label="Stop to"
    )

    @property
    def corners(self) -> int:
        """The number of entries of ``points`` that are corners of a box; they come first. 0 without a box."""
        return BOX_CORNERS if self.shape else 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Slider:
    """The carriage of a base that slides along a straight line through the base's initial position.

    Positions of the carriage count from this initial position, positive in the direction ``angle``.
    """

    angle: float = scene_key("rad", "direction of the line, from +x", 0.0, label="Slider: angle")
    mass: float = scene_key("kg", "mass of the carriage", 1.0, minimum=0.0, label="Mass")
    damping: float = scene_key("N.s/m", "viscous damping along the line", 0.0, minimum=0.0, label="Damping")
    stiffness: float = scene_key(
        "N/m", "stiffness of a spring along the line", 0.0, minimum=0.0, label="Stiffness"
    )
    rest_position: float = scene_key(
        "m", "position on the line at which the spring is slack", 0.0, label="Rest position"
    )
    friction: float = scene_key(
        "N", "force of dry friction along the line", ZERO_RULE, minimum=0.0, label="Friction"
    )
    min: float | None = scene_key("m", "stop at the least position of the carriage", None, label="Stop from")
    max: float | None = scene_key("m", "stop at the largest position of the carriage", None, label="Stop to")
    force_limit: float | None = scene_key(
        "N", "limit of the force of motor, spring and damper together", None, minimum=0.0, label="Force limit"
    )

    @property
    def stops(self) -> tuple[str, ...]:
        """The names of the slider's existing stops, as in ``wall_names``."""
        return tuple(stop for stop in SLIDER_STOPS if getattr(self, stop.removeprefix("slider_")) is not None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainTable:
    """The table [chain]: the kind of base, its slider, and the links from base to tip."""

    base: str = scene_key(
        "",
        "base point: free to move, pinned, or on a slider",
        "free",
        choices=("free", "pinned", "slider"),
    )
    slider: Slider | None = scene_key("", "carriage and line of a base on a slider", SLIDER_TABLE)  # noqa: RUF009
    links: tuple[Link, ...] = scene_key("", "links from base to tip", entries=(1, MAX_LINKS))

    def __post_init__(self) -> None:
        """Replace each link that has a `count` by this number of equal links without a `count`.

        Refuse more than MAX_LINKS links together.
        """
        if (total := sum(link.count or 1 for link in self.links)) > MAX_LINKS:
            raise refusal(("chain", "links"), "links", count=total, most=MAX_LINKS)
        links = (replace(link, count=None) for link in self.links for _ in range(link.count or 1))
        object.__setattr__(self, "links", tuple(links))

    @property
    def movable_points(self) -> range:
        """The numbers of the ends of links that ``contact.points`` may list.

        These are 0 to N, without 0 (the base) if the base is pinned, because walls do not act on it.
        """
        return range(1 if self.base == "pinned" else 0, len(self.links) + 1)

    @property
    def has_base_joint(self) -> bool:
        """Whether a joint connects link 1 with the base; True unless the base is free."""
        return self.base != "free"

    @property
    def sites(self) -> tuple[tuple[int, Site], ...]:
        """The additional points of all links, as pairs: index of the link, from 0, and the point.

        The pairs are in the order of the points' numbers, which begin at N + 1.
        """
        return tuple((i, site) for i, link in enumerate(self.links) for site in link.points)

    @property
    def stops(self) -> tuple[tuple[int, str], ...]:
        """The existing stops as pairs: the number of the joint, and ``joint_min`` or ``joint_max``."""
        links = enumerate(self.links, 1)
        return tuple((i, stop) for i, link in links for stop in STOPS if getattr(link, stop) is not None)

    @property
    def joint_ranges(self) -> dict[int, tuple[float, float]]:
        """Number of each joint with a stop → joint_min and joint_max [rad]; a missing stop is −∞ or ∞."""
        links = {joint: self.links[joint - 1] for joint, _ in self.stops}
        free_range = (-math.inf, math.inf)
        return {
            joint: (
                free_range[0] if link.joint_min is None else link.joint_min,
                free_range[1] if link.joint_max is None else link.joint_max,
            )
            for joint, link in links.items()
        }

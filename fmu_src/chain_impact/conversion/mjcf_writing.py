"""A scene as MJCF: elements for MuJoCo, and a text element with all data of the scene as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from itertools import pairwise
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from chain_impact.conversion.mjcf import NO_LIMIT, TEXT_NAME
from chain_impact.conversion.mjcf_contacts import point_name
from chain_impact.conversion.robot import JOINT_KEYS
from chain_impact.scene.keys.chain_tables import Link, Slider
from chain_impact.scene.scene import Scene, scene_to_dict
from chain_impact.text import names_text

# axis of a hinge: the scene's x and y are x and z in MJCF, because z points up in MuJoCo's pictures
HINGE = "0 -1 0"
# [kg·m²] a moment of inertia that MuJoCo accepts; it replaces smaller ones
LEAST_INERTIA = 2e-15
# [1] the least radius of a point in MJCF, divided by the length of the longest link, because MuJoCo needs a
# radius above 0
LEAST_RADIUS = 1e-4
# [s] MuJoCo's default time step; it replaces a larger communication step of the scene, with which MuJoCo
# would be too inaccurate
LARGEST_STEP = 2e-3


def mjcf_of(scene: Scene) -> tuple[str, list[str], list[str]]:
    """Return a scene as the text of MJCF, and two lists of lines on the scene's features.

    The first list is on features that MuJoCo has in another form, the second on features that MuJoCo lacks.
    """
    root = Element("mujoco", model=scene.name)
    SubElement(root, "compiler", angle="radian", autolimits="true")
    SubElement(
        root,
        "option",
        gravity=_numbers(scene.gravity[0], 0.0, scene.gravity[1]),
        integrator="RK4",
        timestep=repr(min(scene.simulation.step_size, LARGEST_STEP)),
    )
    is_free, links = scene.chain.base == "free", scene.chain.links
    embedded_data = scene_to_dict(scene)
    for table, link in zip(embedded_data["chain"]["links"], links, strict=True):
        table |= {"center_of_mass": link.center_of_mass, "inertia": link.inertia}
    SubElement(SubElement(root, "custom"), "text", name=TEXT_NAME, data=json.dumps(embedded_data))
    world = SubElement(root, "worldbody")
    _add_walls(world, scene)
    _add_chain(world, scene)
    joints = range(2 if is_free else 1, len(links) + 1) if scene.inputs.joint_torques else ()
    motors = {f"joint[{i}].torque": f"joint[{i}]" for i in joints}
    motors |= {"slider.force": "slider"} if scene.inputs.slider_force else {}
    actuators = SubElement(root, "actuator") if motors else root
    for name, joint in motors.items():
        SubElement(actuators, "motor", name=name, joint=joint)
    _add_start(root, scene)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode") + "\n"
    return text, list(_differences(scene)), list(_left_out(scene))


def _add_walls(world: Element, scene: Scene) -> None:
    """Add a plane for each existing wall to ``world``; the z axis of a plane is the normal of the wall."""
    points = {wall.name: wall.point for wall in scene.walls}
    size = sum(link.length for link in scene.chain.links)
    for name, plane in scene.half_planes.items():
        normal = plane.normal
        x, y = points.get(name, (normal[0] * plane.offset, normal[1] * plane.offset))
        material = scene.contact.wall.get(name)
        given_friction = None if material is None else material.friction
        friction = scene.contact.friction if given_friction is None else given_friction
        SubElement(
            world,
            "geom",
            name=name,
            type="plane",
            size=_numbers(3.0 * size, 3.0 * size, 0.1 * size),
            pos=_numbers(x, 0.0, y),
            zaxis=_numbers(normal[0], 0.0, normal[1]),
            friction=_numbers(friction, 0.0, 0.0),
            condim="3" if friction > 0.0 else "1",
            contype="1",
            conaffinity="2",
            rgba="0.8 0.8 0.8 0.4",
        )


def _add_chain(world: Element, scene: Scene) -> None:
    """Add a body to ``world`` for each link, and one for the carriage of a slider if the carriage has a mass.

    The origin of a link's body is at the proximal joint of the link, the x axis of the body along the link.
    """
    is_free, links = scene.chain.base == "free", scene.chain.links
    base, radius = scene.initial.position, LEAST_RADIUS * max(link.length for link in links)
    width = repr(0.02 * sum(link.length for link in links) / len(links) ** 0.5)
    parent, position = world, _numbers(0.0, 0.0, 0.0) if is_free else _numbers(base[0], 0.0, base[1])
    slider, number = scene.chain.slider, len(links)
    if slider is not None and slider.mass > 0.0:
        parent, position = SubElement(parent, "body", name="slider", pos=position), _numbers(0.0, 0.0, 0.0)
        _add_inertial(parent, slider.mass, (0.0, 0.0), 0.0)
        _add_slide(parent, slider)
    for i, link in enumerate(links, 1):
        body = SubElement(parent, "body", name=f"link[{i}]", pos=position)
        _add_inertial(body, link.mass, (link.center_of_mass, link.center_of_mass_offset), link.inertia)
        # MuJoCo accepts no moving body without mass, so if the carriage has none, the body of link 1 slides
        if slider is not None and slider.mass == 0.0 and i == 1:
            _add_slide(body, slider)
        if is_free and i == 1:
            SubElement(body, "joint", name="base.x", type="slide", axis="1 0 0")
            SubElement(body, "joint", name="base.y", type="slide", axis="0 0 1")
        keys = {} if is_free and i == 1 else _joint(link)
        SubElement(body, "joint", {"name": f"joint[{i}]", "type": "hinge", "axis": HINGE, **keys})
        line = {"type": "capsule", "size": width, "fromto": _numbers(0.0, 0.0, 0.0, link.length, 0.0, 0.0)}
        SubElement(body, "geom", line, name=f"link[{i}]", mass="0", contype="0", conaffinity="0")
        for point, distance in ((i - 1, 0.0), (i, link.length)) if i == 1 else ((i, link.length),):
            if point in scene.contact.points:
                _add_ball(body, point, (distance, 0.0), max(scene.contact.radius, radius))
        for site in link.points:
            number += 1
            _add_ball(body, number, (site.x, site.y), max(site.radius or 0.0, radius))
        SubElement(body, "site", name=f"point[{i}]", pos=_numbers(link.length, 0.0, 0.0))
        parent, position = body, _numbers(link.length, 0.0, 0.0)


def _add_inertial(body: Element, mass: float, center: tuple[float, float], inertia: float) -> None:
    """Add mass [kg], centre of mass in the body's axes [m] and moment of inertia [kg·m²] to a body.

    The moment is about the centre; the two moments that the planar motion does not need get the same value.
    """
    x, y = center
    inertia_text = _numbers(*[max(inertia, LEAST_INERTIA)] * 3)
    SubElement(body, "inertial", pos=_numbers(x, 0.0, y), mass=repr(mass), diaginertia=inertia_text)


def _add_ball(body: Element, number: int, position: tuple[float, float], radius: float) -> None:
    """Add a sphere to a body for point ``number`` of the scene; the sphere touches walls only.

    ``position`` is the sphere's centre along the link and to the left of it [m], ``radius`` the radius [m].
    """
    x, y = position
    ball = {"type": "sphere", "size": repr(radius), "pos": _numbers(x, 0.0, y), "condim": "1"}
    ball |= {"friction": "0 0 0", "mass": "0", "contype": "2", "conaffinity": "1"}
    SubElement(body, "geom", ball, name=point_name(number))


def _add_slide(body: Element, slider: Slider) -> None:
    """Add the sliding joint, with the values of ``slider``, to the body of the carriage or of link 1."""
    axis = _numbers(math.cos(slider.angle), 0.0, math.sin(slider.angle))
    names = {key.slider: key.attribute for key in JOINT_KEYS.values() if key.slider and key.attribute}
    keys = _attributes(slider, names, slider.min, slider.max, slider.force_limit)
    SubElement(body, "joint", {"name": "slider", "type": "slide", "axis": axis, **keys})


def _joint(link: Link) -> dict[str, str]:
    """Return the values of the proximal joint of a link, as attributes of MJCF."""
    names = {key.link: key.attribute for key in JOINT_KEYS.values() if key.attribute}
    return _attributes(link, names, link.joint_min, link.joint_max, link.joint_torque_limit)


def _attributes(
    table: Link | Slider,
    names: dict[str, str],
    low: float | None,
    high: float | None,
    limit: float | None,
) -> dict[str, str]:
    """Return the values of a joint as attributes of MJCF; each key of ``names`` with the value 0 is left out.

    Args:
        table: the link or slider with the values.
        names: key of the table → name of the attribute.
        low: least angle or position [rad or m]; None without a stop.
        high: largest angle or position [rad or m]; None without a stop.
        limit: limit of the drives [N·m or N]; None or 0 gives no limit in MJCF.
    """
    attributes = {name: repr(value) for key, name in names.items() if (value := getattr(table, key))}
    if low is not None or high is not None:
        attributes["range"] = _numbers(-NO_LIMIT if low is None else low, NO_LIMIT if high is None else high)
    return attributes | ({"actuatorfrcrange": _numbers(-limit, limit)} if limit else {})


def _add_start(root: Element, scene: Scene) -> None:
    """Add to ``root`` a keyframe with the positions and velocities of all joints at the start of the run."""
    start = scene.initial
    positions, rates = {
        "pinned": ((), ()),
        "slider": ((0.0,), (start.slider_velocity,)),
        "free": (start.position, start.velocity),
    }[scene.chain.base]
    angles, speeds = ((values[0], *_steps(values)) for values in (start.angles, start.angular_velocities))
    SubElement(
        SubElement(root, "keyframe"),
        "key",
        name="start",
        qpos=_numbers(*positions, *angles),
        qvel=_numbers(*rates, *speeds),
    )


def _steps(values: tuple[float, ...]) -> Iterator[float]:
    return (later_value - earlier_value for earlier_value, later_value in pairwise(values))


def _differences(scene: Scene) -> Iterator[str]:
    """Yield a line for each feature of the scene that MuJoCo has in another form."""
    links = scene.chain.links
    if scene.half_planes and 0.0 in _radii(scene):
        radius = LEAST_RADIUS * max(link.length for link in links)
        yield f"points of radius 0 have the radius {radius:.3g} m in MJCF"
    if scene.chain.stops or (scene.chain.slider and scene.chain.slider.stops):
        yield "stops: MuJoCo has soft limits of its own, solreflimit and solimplimit"
    for name, limit in _limits(scene):
        if limit:
            yield f"{name}: in MuJoCo it does not limit spring and damper"
    for i, link in enumerate(links, 1):
        if link.inertia < LEAST_INERTIA:
            yield f"link[{i}].inertia = {link.inertia:g}: is {LEAST_INERTIA:g} kg·m² in MJCF"


def _left_out(scene: Scene) -> Iterator[str]:
    """Yield a line for each feature of the scene that MuJoCo does not have."""
    if scene.half_planes and _radii(scene):
        law_text = f"contact.model = {scene.contact.model}, stiffness, exponent and restitution"
        yield f"{law_text}: MuJoCo has a soft contact of its own, solref and solimp"
        walls = scene.contact.wall.values()
        if any([scene.contact.static_friction, *(wall.static_friction for wall in walls)]):
            yield "static_friction: MuJoCo has one coefficient"
    for name, limit in _limits(scene):
        if limit == 0.0:
            yield f"{name} = 0: MuJoCo has no such limit"
    if scene.signals:
        names = names_text([f"signals.{name}" for name in scene.signals], 3)
        yield f"{names}: MuJoCo has no signals over time: a program must set what they drive"
    for key in ("joint_targets", "tip_force", "base_motion", "wall_motion"):
        if getattr(scene.inputs, key):
            yield f"inputs.{key}: is not an input of the MuJoCo model"


def _radii(scene: Scene) -> list[float | None]:
    """Return the radii [m] of the points in ``contact.points``, then of the additional points of links.

    None of these is None in a completed scene.
    """
    contact = scene.contact
    return [contact.radius for _ in contact.points] + [site.radius for _, site in scene.chain.sites]


def _limits(scene: Scene) -> Iterator[tuple[str, float | None]]:
    """Yield (name, value) of the drive's limit for the joint of each link and for the slider, if any.

    A name is ``link[1].joint_torque_limit`` [N·m], for example, or ``slider.force_limit`` [N]. The value of a
    drive without a limit is None.
    """
    for i, link in enumerate(scene.chain.links, 1):
        yield f"link[{i}].joint_torque_limit", link.joint_torque_limit
    if scene.chain.slider:
        yield "slider.force_limit", scene.chain.slider.force_limit


def _numbers(*values: float) -> str:
    # 0.0 is added, because MJCF would show −0.0
    return " ".join(repr(float(value) + 0.0) for value in values)

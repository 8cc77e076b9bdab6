"""Conversion of a spatial robot into a planar chain, without the packages that read files."""

# Tests: conversion/plane.py, conversion/joints.py, conversion/proposals.py, conversion/robot.py

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from chain_impact import SceneError, extras, load_scene
from chain_impact.conversion.mjcf import read_mjcf
from chain_impact.conversion.mjcf_writing import mjcf_of
from chain_impact.conversion.planar import ConversionChoices
from chain_impact.conversion.proposals import chain_of
from chain_impact.conversion.robot import Body, Joint, Plane, Robot
from chain_impact.conversion.urdf import read_urdf
from chain_impact.extras import MissingExtraError
from chain_impact.scene.scene import scene_from_dict

DOWN = np.array([0.0, 0.0, -9.81])
CENTER = np.array([0.1, 0.0, 0.0])


def hinge(name, axis=(0.0, 1.0, 0.0), **options):
    return Joint(name=name, kind="hinge", axis=np.array(axis), anchor=np.zeros(3), **options)


def body(name, parent, position, joints=(), **options):
    return Body(
        name=name,
        parent=parent,
        rotation=np.eye(3),
        position=np.array(position),
        joints=joints,
        **{"mass": 1.0, "center": CENTER, "inertia": np.diag([0.01, 0.02, 0.03]), **options},
    )


def arm(*joints, **options):
    """Return a robot of bodies 0.3 m apart along x, each with one of the joints, and a tip 0.2 m further."""
    bodies = [body(f"b{i}", i - 1, (0.3 * (i > 0), 0.0, 0.5 * (i == 0)), [j]) for i, j in enumerate(joints)]
    bodies.append(body("tip", len(joints) - 1, (0.2, 0.0, 0.0), mass=0.0, inertia=np.zeros((3, 3))))
    return Robot(name="arm", bodies=bodies, gravity=DOWN, **options)


def scene(robot, *joints, **choices):
    result = chain_of(robot, ConversionChoices(joints=joints, **choices), "arm.urdf")
    return scene_from_dict(result.data, "arm"), result


def test_x_of_the_robot_stays_x_and_the_signs_of_joints_are_turned():
    first = hinge("a", start=0.4, low=-1.0, high=2.0, damping=0.1, friction=0.2, armature=0.3)
    converted, result = scene(arm(first, hinge("b", start=-0.2, stiffness=5.0, rest=0.1)))
    upper, lower = converted.chain.links
    assert (upper.length, lower.length, upper.center_of_mass, upper.inertia) == (0.3, 0.2, 0.1, 0.02)
    assert (upper.joint_damping, upper.joint_friction, upper.joint_armature) == (0.1, 0.2, 0.3)
    # a positive angle about +y turns the x axis downwards
    assert result.notes[:2] == [
        "plane: x of the scene is (1 0 0) of the robot, y is (0 0 1)",
        "joints a, b: angles and torques have the other sign in the scene",
    ]
    assert converted.initial.angles == pytest.approx([-0.4, -0.2], abs=1e-11)
    assert (upper.joint_min, upper.joint_max) == pytest.approx((-2.0, 1.0), abs=1e-11)
    assert (lower.joint_stiffness, lower.joint_rest_angle) == (5.0, -0.1)
    assert converted.initial.position == (0.0, 0.5)
    assert converted.gravity == (0.0, -9.81)


def test_a_joint_with_the_opposite_axis_counts_the_other_way():
    second = hinge("b", (0.0, -1.0, 0.0), start=0.3, low=-0.1, high=0.5)
    converted, result = scene(arm(hinge("a"), second))
    assert converted.initial.angles == pytest.approx([0.0, 0.3], abs=1e-11)
    link = converted.chain.links[1]
    assert (link.joint_min, link.joint_max) == pytest.approx((-0.1, 0.5))
    assert "joint a: angles and torques have the other sign in the scene" in result.notes


def test_the_plane_is_as_chosen():
    robot = arm(hinge("a"), hinge("b"))
    mirrored, result = scene(robot, plane="-x,z")
    assert mirrored.initial.angles == pytest.approx([math.pi, math.pi])
    assert not any("other sign" in note for note in result.notes)
    upside, _ = scene(robot, plane="z,x")
    assert upside.gravity == (-9.81, 0.0)
    assert upside.initial.angles == pytest.approx([0.5 * math.pi, 0.5 * math.pi])
    for plane, message in (
        ("x", "must be two of x, y"),
        ("x,y", "at right angles"),
        ("x,-x", "at right angles"),
    ):
        with pytest.raises(SceneError, match=message):
            scene(robot, plane=plane)


def test_a_frame_is_chosen_as_the_tip():
    robot = arm(hinge("a"), hinge("b"))
    bodies = [*robot.bodies, body("hand", 1, (0.1, 0.0, 0.0), mass=0.0, inertia=np.zeros((3, 3)))]
    converted, result = scene(Robot(name="arm", bodies=bodies, gravity=DOWN), tip="hand")
    assert converted.chain.links[1].length == 0.1
    assert "tip: the last link ends at hand, 0.1 m from its joint" in result.notes
    with pytest.raises(SceneError, match="hnd is not a frame of the last link; the nearest is hand"):
        scene(Robot(name="arm", bodies=bodies, gravity=DOWN), tip="hnd")


def test_offsets_along_hinge_axes_vanish_and_held_joints_merge_bodies():
    robot = arm(hinge("a"), hinge("b"))
    aside = [body("b0", -1, (0.0, 0.0, 0.5), [hinge("a")]), body("b1", 0, (0.3, 0.7, 0.0), [hinge("b")])]
    aside.append(robot.bodies[-1])
    moved_scene, _ = scene(Robot(name="arm", bodies=aside, gravity=DOWN))
    assert moved_scene.chain == scene(robot)[0].chain
    held_scene, result = scene(arm(hinge("a"), hinge("b", start=0.5 * math.pi)), "a")
    (link,) = held_scene.chain.links
    assert link.mass == 2.0
    assert link.length == pytest.approx(math.hypot(0.3, 0.2))
    assert "joint b: held at the start" in result.notes
    # masses at (0.1, 0) m and at (0.3, -0.1) m; the line of the link ends at (0.3, -0.2) m
    moment = 2 * 0.02 + 0.1**2 + 0.3**2 + 0.1**2
    center = link.center_of_mass, link.center_of_mass_offset
    assert center == pytest.approx(np.array([0.2 * 0.3 + 0.05 * 0.2, 0.2 * 0.2 - 0.05 * 0.3]) / link.length)
    assert link.inertia + link.mass * np.dot(center, center) == pytest.approx(moment, abs=1e-10)
    assert result.warnings == []


@pytest.mark.parametrize("plane", ["x,z", "-x,z"])
def test_a_mirrored_plane_mirrors_the_centre_of_mass(plane):
    bodies = list(arm(hinge("a")).bodies)
    bodies[0] = body("b0", -1, (0.0, 0.0, 0.5), [hinge("a")], center=np.array([0.1, 0.0, 0.03]))
    converted, result = scene(Robot(name="arm", bodies=bodies, gravity=DOWN), plane=plane)
    (link,) = converted.chain.links
    offset = 0.03 if plane == "x,z" else -0.03
    assert (link.center_of_mass, link.center_of_mass_offset, link.inertia) == (0.1, offset, 0.02)
    assert result.warnings == []


def test_joints_with_upright_axes_bear_gravity():
    converted, result = scene(arm(hinge("a", (0.0, 0.0, 1.0)), hinge("b", (0.0, 0.0, 1.0))))
    assert converted.gravity == (0.0, 0.0)
    assert converted.initial.angles == (0.0, 0.0)
    assert "gravity: its part along the axes, 9.81 m/s², is borne by the joints" in result.notes


def test_planes_are_walls_and_a_start_beyond_a_stop_is_moved():
    planes = [
        Plane(name="y_min", point=np.zeros(3), normal=np.array([0.0, 0.0, 1.0]), contacts=[(0, 0.4)]),
        Plane(
            name="", point=np.array([2.0, 0.0, 0.0]), normal=np.array([-1.0, 0.0, 0.0]), contacts=[(0, 0.0)]
        ),
        Plane(name="side", point=np.zeros(3), normal=np.array([0.0, 1.0, 0.0]), contacts=[(0, 0.0)]),
    ]
    converted, result = scene(arm(hinge("a", start=0.1, low=0.2, high=0.5), planes=planes))
    assert converted.box.y_min == 0.0
    assert converted.contact.wall["y_min"].friction == 0.4
    assert [wall.name for wall in converted.walls] == ["wall_2"]
    assert converted.half_planes["wall_2"].normal == pytest.approx((-1.0, 0.0), abs=1e-12)
    assert (
        "plane side: is not at right angles to the plane of the motion: it is not a wall" in result.left_out
    )
    assert converted.initial.angles[0] == pytest.approx(-0.2)
    assert "joint a: starts at its stop; in the file it starts 0.1 rad beyond this stop" in result.warnings


@pytest.mark.parametrize(
    ("robot", "joints", "message"),
    [
        (
            arm(hinge("a"), hinge("b", (0.0, 0.0, 1.0)), hinge("c")),
            (),
            "arm.urdf: the axes of the joints are not parallel: the robot is not a planar chain; "
            "choose joints a,c:",
        ),
        (arm(hinge("a")), ("c",), "arm.urdf: c is not a joint; joints: a"),
        (
            arm(hinge("a"), Joint(name="b", kind="slide", axis=np.eye(3)[0], anchor=np.zeros(3))),
            (),
            "joint b slides",
        ),
        (arm(Joint(name="a", kind="ball", axis=np.eye(3)[1], anchor=np.zeros(3))), (), "is of the kind ball"),
        (Robot(name="none", bodies=[body("b", -1, (0, 0, 0))], gravity=DOWN), (), "no hinge moves"),
        (
            Robot(
                name="tree",
                bodies=[body("b", -1, (0, 0, 0), [hinge("a")])]
                + [body(name, 0, (0.3, 0, 0), [hinge(name)]) for name in ("left", "right")],
                gravity=DOWN,
            ),
            (),
            "joints left and right do not follow one another: a scene has one chain without branches",
        ),
        (
            Robot(
                name="twice",
                bodies=[body("b", -1, (0, 0, 0), [hinge("a")]), body("c", 0, (0, 0.1, 0), [hinge("b")])],
                gravity=DOWN,
            ),
            (),
            "joints a and b have the same axis; choose joints b: these make a chain",
        ),
    ],
)
def test_robots_that_are_no_planar_chain_are_refused_with_a_way_out(robot, joints, message):
    with pytest.raises(SceneError) as caught:
        scene(robot, *joints)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_mjcf_of_a_scene_has_its_links_walls_and_start():
    text, _, left_out = mjcf_of(load_scene("pinned_arm"))
    root = ElementTree.fromstring(text)
    assert [body.get("name") for body in root.iter("body")] == ["link[1]", "link[2]"]
    (wall,) = [geom for geom in root.iter("geom") if geom.get("type") == "plane"]
    assert (wall.get("name"), wall.get("pos"), wall.get("zaxis")) == ("x_max", "0.3 0.0 0.0", "-1.0 0.0 0.0")
    angles = [float(word) for word in root.find("keyframe/key").get("qpos").split()]
    assert np.cumsum(angles) == pytest.approx([-2.4, -2.1])
    assert [motor.get("joint") for motor in root.iter("motor")] == ["joint[1]", "joint[2]"]
    assert left_out[0].startswith("contact.model = zhang_sharf")


@pytest.mark.parametrize(("read", "package"), [(read_urdf, "yourdfpy"), (read_mjcf, "mujoco")])
def test_without_the_extra_one_line_says_how_to_install_it(monkeypatch, tmp_path, read, package):
    def missing(name):
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(extras, "import_module", missing)
    with pytest.raises(MissingExtraError, match=rf"{package} .*pip install '.*({package}|convert)"):
        read(tmp_path / "robot.xml")

"""Contacts, limits, drives and shapes of robot files are converted, or reported."""

# Tests: conversion/mjcf_contacts.py, conversion/mjcf_couplings.py, conversion/mjcf_drives.py
# Tests: conversion/points.py, conversion/walls.py

import math
import re
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from chain_impact.cli import main
from tests.conversion.robot_files import TWO, arm, drives, joint, key, link, read, refused, urdf
from tests.tiers import needs_interop

pytestmark = needs_interop

FLOOR = '<geom name="floor" type="plane" size="3 3 .1" {}/>'


def test_disabled_contacts_and_limits_are_not_in_the_scene(tmp_path):
    limited = 'range="-30 30" limited="true"'
    scene, result = read(
        tmp_path, arm(flags='<flag contact="disable" limit="disable"/>', world=FLOOR.format(""), a=limited)
    )
    assert scene.half_planes == {}
    assert scene.chain.links[0].joint_min is None
    assert "flags: no limits of joints, no contacts, in the file and in the scene" in result.notes
    assert result.warnings == []
    scene, _ = read(
        tmp_path, arm(flags='<flag constraint="disable"/>', world=FLOOR.format(""), b='frictionloss="1"')
    )
    assert (scene.half_planes, scene.chain.links[1].joint_friction) == ({}, 0.0)


@pytest.mark.parametrize(
    ("floor", "shape", "rest", "friction"),
    [
        ('contype="0" conaffinity="0"', "", "", None),
        ('contype="2" conaffinity="4"', 'contype="1" conaffinity="8"', "", None),
        ('contype="2" conaffinity="0"', 'contype="0" conaffinity="2"', "", 1.0),
        ('friction="1"', 'friction="2"', "", 2.0),
        ('friction=".3" priority="1"', 'friction="2"', "", 0.3),
        ('condim="1"', 'condim="1"', "", 0.0),
        (
            'contype="0" conaffinity="0"',
            "",
            '<contact><pair geom1="floor" geom2="lower" friction=".7 .7 .1 .1 .1"/></contact>',
            0.7,
        ),
        ("", "", '<contact><exclude body1="world" body2="lower"/></contact>', 1.0),
    ],
)
def test_a_touched_plane_is_a_wall_with_the_friction_of_the_pair(tmp_path, floor, shape, rest, friction):
    scene, result = read(tmp_path, arm(world=FLOOR.format(floor), shape=shape, rest=rest))
    if friction is None:
        assert scene.half_planes == {}
        assert "plane floor: nothing that moves touches it: it is not a wall" in result.left_out
    else:
        assert list(scene.half_planes) == ["floor"]
        material = scene.contact.wall.get("floor")
        assert ((material and material.friction) or 0.0) == friction
        ends = {"pair": ("lower",), "exclude": ("upper",)}
        touching = next((names for word, names in ends.items() if word in rest), ("upper", "lower"))
        names = {site.name.partition("_")[0] for _, site in scene.chain.sites}
        assert (names, scene.contact.points) == (set(touching), ())


CORNERS = [(x, z, 0.0, "") for x in (0.1, 0.3) for z in (-0.12, -0.08)]
FOOT = {
    "sphere": ('<geom name="heel" size=".02" pos=".3 .1 -.1" mass=".1"/>', [(0.3, -0.1, 0.02, "heel")]),
    "sphere twice": (
        '<geom name="heel" size=".02" pos=".3 .1 -.1"/><geom name="twin" size=".02" pos=".3 -.1 -.1"/>',
        [(0.3, -0.1, 0.02, "heel")],
    ),
    "sphere within a sphere that it touches": (
        '<geom name="inner" size=".01" pos=".3 .1 -.11"/><geom name="outer" size=".02" pos=".3 0 -.1"/>',
        [(0.3, -0.1, 0.02, "outer")],
    ),
    "spheres on one line": (
        "".join(f'<geom size=".02" pos=".{x} {y} -.1"/>' for y in (0.1, -0.1) for x in (2, 1, 3)),
        [(x, -0.1, 0.02, "") for x in (0.1, 0.3)],
    ),
    "capsule across": (
        '<geom name="roll" type="capsule" fromto=".3 .1 -.1 .3 -.1 -.1" size=".04"/>',
        [(0.3, -0.1, 0.04, "roll")],
    ),
    "capsule": (
        '<geom name="2nd toe" type="capsule" fromto=".3 0 .2 .2 .1 -.1" size=".04" mass=".1"/>',
        [(0.2, -0.1, 0.04, "geom_2nd_toe_1"), (0.3, 0.2, 0.04, "geom_2nd_toe_2")],
    ),
    "box": (
        '<geom type="box" size=".1 .05 .02" pos=".2 0 -.1" mass=".1"/>',
        CORNERS,
    ),
    "box turned in the plane": (
        '<geom type="box" euler="0 90 0" size=".02 .3 .1" pos=".2 0 -.1"/>',
        CORNERS,
    ),
    "wheel": ('<geom type="cylinder" euler="90 0 0" size=".2 .03" pos=".3 0 0"/>', [(0.3, 0.0, 0.2, "")]),
    "roller": (
        '<geom type="cylinder" euler="70 0 0" size=".02 .1" pos=".3 0 -.1"/>',
        None,
    ),
    "upright roller": (
        '<geom type="cylinder" size=".02 .1" pos=".3 0 -.1"/>',
        [(x, z, 0.0, "") for x in (0.28, 0.32) for z in (-0.2, 0.0)],
    ),
}
"""Name → a shape of a foot, and its points: x and z in the body, radius, name; None: computed in the test."""


@pytest.mark.parametrize("name", FOOT)
@pytest.mark.parametrize("plane", ["x,z", "-x,z"])
@pytest.mark.parametrize("axis", [1, -1])
def test_shapes_that_touch_a_floor_become_points_at_their_places(tmp_path, name, plane, axis):
    shape, expected = FOOT[name]
    text = arm(world=FLOOR.format(""), lower='euler="0 25 0"', rest=key(qpos=".3 -.7"))
    bare = '<geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" />'
    text = text.replace(bare, bare.replace("/>", 'contype="0" conaffinity="0"/>') + shape)
    text = text.replace('name="b" axis="0 1 0"', f'name="b" axis="0 {axis} 0"')
    scene, result = read(tmp_path, text, plane=plane)
    assert scene.contact.points == ()
    points = [(*at, site.name) for (i, site), at in zip(scene.chain.sites, starts(scene), strict=True) if i]
    # about +y, in radians: the euler angle and both joint angles; the floor is at z = 0
    turn, sign = math.radians(25) + 0.3 - axis * 0.7, 1 if plane == "x,z" else -1
    knee = 0.4 * math.cos(0.3), 1.5 - 0.4 * math.sin(0.3)
    if expected is None:  # an oblique view of a cylinder: a rectangle with ellipses at its ends
        middle = sign * (knee[0] + 0.3 * math.cos(turn) - 0.1 * math.sin(turn))
        offsets = np.array([row[:2] for row in points]) - (
            middle,
            knee[1] - 0.3 * math.sin(turn) - 0.1 * math.cos(turn),
        )
        axes = np.array([[sign * math.cos(turn), -math.sin(turn)], [sign * math.sin(turn), math.cos(turn)]])
        tilt = math.radians(70)
        sizes = 0.02, 0.1 * math.cos(tilt) + 0.02 * math.sin(tilt)
        assert np.abs(offsets @ axes.T).max(axis=0) == pytest.approx(sizes, abs=1e-12)
        return
    rows = [
        (
            sign * (knee[0] + x * math.cos(turn) + z * math.sin(turn)),
            knee[1] - x * math.sin(turn) + z * math.cos(turn),
            radius,
        )
        for x, z, radius, _ in expected
    ]
    assert sorted(row[:3] for row in points) == [pytest.approx(row, abs=1e-12) for row in sorted(rows)]
    assert {row[3] for row in points} == {row[3] for row in expected}
    assert not [line for line in result.warnings if "reach" in line]


def test_how_far_an_oblique_cylinder_reaches_beyond_its_points_is_told(tmp_path):
    """The expected reach comes from many points on both rims of the cylinder."""
    angles = 0.5, 1.2, 0.2
    roll = '<geom type="cylinder" size=".05 .2" pos=".5 0 .05" euler="{} {} {}"/>'
    degrees = [math.degrees(angle) for angle in angles]
    bare = '<geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" />'
    text = arm(world=FLOOR.format("")).replace(bare, roll.format(*degrees).replace("/>", ' mass="1"/>'))
    scene, result = read(tmp_path, text)
    (message,) = [line for line in result.differs if "reach" in line]
    rotation = Rotation.from_euler("XYZ", angles).as_matrix()
    turn = np.linspace(0.0, 2.0 * np.pi, 3600)
    rims = [[0.05 * np.cos(turn), 0.05 * np.sin(turn), np.full_like(turn, z)] for z in (-0.2, 0.2)]
    rims = (rotation @ np.concatenate(rims, axis=1))[[0, 2]].T + np.array([0.5, 0.05])
    points = np.array([(site.x, site.y) for i, site in scene.chain.sites if i == 1])
    walls = np.array([np.cos(turn), np.sin(turn)])
    expected = ((rims @ walls).max(axis=0) - (points @ walls).max(axis=0)).max()
    assert float(re.search(r"reach ([\d.e-]+) m", message)[1]) == pytest.approx(expected, rel=0.02)
    assert 1e-4 < expected < 4e-4


def test_a_roll_whose_axis_has_few_digits_is_one_point(tmp_path):
    for kind in ("capsule", "cylinder"):
        roll = f'<geom name="roll" type="{kind}" quat=".7071071 .7071065 0 0" size=".04 .2" pos=".2 0 -.1"/>'
        scene, _ = read(tmp_path, arm(world=FLOOR.format(""), more=roll))
        assert [site.radius for _, site in scene.chain.sites if site.name == "roll"] == [0.04]


def test_shapes_of_two_links_around_their_joint_are_one_point(tmp_path):
    wheel = '<geom name="{}" type="cylinder" euler="90 0 0" size="{} .03" pos="{} 0 0"/>'
    for upper, lower in ((0.1, 0.1), (0.2, 0.1), (0.1, 0.2)):
        text = arm(world=FLOOR.format(""), more=wheel.format("hub", upper, ".4"))
        text = text.replace("<site", f"{wheel.format('rim', lower, 0)}<site")
        scene, _ = read(tmp_path, text)
        names = ["hub"] if upper >= lower else ["rim"]
        assert [site.name for _, site in scene.chain.sites if site.name != "lower"] == names
        assert scene.contact.points == ()


def test_a_joint_inside_a_shape_of_the_next_link_is_no_point(tmp_path):
    wheel = '<geom name="hub" type="cylinder" euler="90 0 0" size=".1 .03" pos="{} 0 0"/>'
    bare = '<geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" />'
    egg = '<geom type="ellipsoid" size=".15 .01 .01" pos=".15 0 0" mass="1"/>'
    for x, points in ((".4", (2,)), (".2", (1, 2))):
        text = arm(world=FLOOR.format(""), more=wheel.format(x)).replace(bare, egg)
        text = text.replace('mass="2" ', 'mass="2" contype="0" conaffinity="0"')
        assert read(tmp_path, text)[0].contact.points == points


def starts(scene):
    """Return the place and radius of the points of links at the start."""
    return [at for number, at in scene.start.items() if number > len(scene.chain.links)]


def test_a_point_that_starts_within_a_wall_is_smaller_or_left_out_and_told(tmp_path):
    ball = '<geom name="{}" size=".05" pos=".3 0 {}" mass=".1"/>'
    shapes = ball.format("heel", "-1.47") + ball.format("toe", "-1.6")
    text = arm(world=FLOOR.format("")).replace("<site", f"{shapes}<site")
    scene, result = read(tmp_path, text)
    radii = {site.name: site.radius for _, site in scene.chain.sites}
    assert "toe" not in radii
    assert any("point toe starts 0.15 m deep in floor: it is left out" in line for line in result.warnings)
    ball = ball.format("heel", "-1.47")
    scene, result = read(tmp_path, arm(world=FLOOR.format("")).replace("<site", f"{ball}<site"))
    assert {site.name: site.radius for _, site in scene.chain.sites}["heel"] == pytest.approx(0.03)
    assert any(
        "point heel starts 0.02 m deep in floor: its radius is smaller" in line for line in result.warnings
    )


def test_a_carriage_that_touches_the_floor_is_told(tmp_path):
    box = '<body name="box" pos="0 0 1.5"><joint name="rail" type="slide" axis="1 0 0"/><geom size=".1"/>'
    text = arm(world=FLOOR.format("")).replace(
        '<body name="upper" pos="0 0 1.5" >', f'{box}<body name="upper">'
    )
    _, result = read(tmp_path, text.replace("</worldbody>", "</body></worldbody>"))
    assert (
        "body box: touches walls in the file; in the scene it is on no link, and touches nothing"
        in result.left_out
    )


def test_the_part_of_an_ellipsoid_beyond_its_points_is_told(tmp_path):
    heel = '<geom type="ellipsoid" pos=".2 0 -.1" size=".05 .02 .1" mass=".1"/>'
    text = arm(world=FLOOR.format("")).replace("<site", f"{heel}<site")
    _, result = read(tmp_path, text)
    (line,) = [line for line in result.warnings if "shapes reach" in line and "joint b" in line]
    assert "reach 0.18 m, 60 % of the length" in line


def test_a_link_without_points_is_told_to_touch_with_its_two_ends(tmp_path):
    bare = '<geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" />'
    egg = '<geom type="ellipsoid" size=".15 .05 .05" pos=".15 0 0" mass="1"/>'
    _, result = read(tmp_path, arm(world=FLOOR.format("")).replace(bare, egg))
    (line,) = [line for line in result.warnings if "shapes reach" in line and "joint b" in line]
    assert "beyond its two ends" in line
    assert "reach 0.05 m" in line


def test_dozens_of_shapes_are_one_line(tmp_path):
    eggs = '<geom type="ellipsoid" size=".01 .01 .01" pos=".{:02} 0 0" mass="0"/>'
    _, result = read(tmp_path, arm(more="".join(map(eggs.format, range(30))), world=FLOOR.format("")))
    (line,) = [line for line in result.left_out if "ellipsoid" in line]
    assert line.startswith("shapes 30 ellipsoids: do not touch as shapes")


def test_only_shapes_that_can_touch_a_wall_first_become_points(tmp_path):
    balls = "".join(f'<geom type="sphere" size=".05" pos=".{i:02} 0 0" mass="0"/>' for i in range(10, 30))
    scene, _ = read(tmp_path, arm(more=balls, world=FLOOR.format("")))
    assert [(site.x, site.radius) for i, site in scene.chain.sites if i == 0] == [
        (0.4, 0.03),
        (0.1, 0.05),
        (0.29, 0.05),
    ]


@pytest.mark.parametrize(("damping", "warned"), [(0.01, False), (2.0, True)])
def test_the_speed_from_which_a_limit_acts_on_a_damper_is_told(tmp_path, damping, warned):
    servo = '<velocity joint="a" kv="20" forcerange="-3.15 3.15"/>'
    _, result = read(tmp_path, arm(a=f'damping="{damping}"', rest=drives(servo)))
    message = (
        f"joint a: the limit of its drives also limits its damper, from {3.15 / (20 + damping):.3g} rad/s on"
    )
    assert message in (result.warnings if warned else result.differs)


@pytest.mark.parametrize(
    ("actuators", "limit"),
    [
        (['<motor joint="a" ctrlrange="-10 10"/>'] * 2, 20.0),
        (['<motor joint="a" ctrlrange="-10 10" gear="-3"/>'], 30.0),
        (['<motor joint="a" ctrlrange="-10 10" forcerange="-4 4"/>'], 4.0),
        (['<motor joint="a" ctrlrange="-10 10"/>', '<motor joint="a"/>'], None),
        (['<position joint="a" kp="10" forcerange="-7 7" ctrlrange="-1 1"/>'], 7.0),
    ],
)
def test_the_limits_of_drives_are_added_up(tmp_path, actuators, limit):
    scene, _ = read(tmp_path, arm(rest=drives(*actuators)))
    assert scene.chain.links[0].joint_torque_limit == limit
    limited_scene, _ = read(tmp_path, arm(a='actuatorfrcrange="-3 3"', rest=drives(*actuators)))
    assert limited_scene.chain.links[0].joint_torque_limit == 3.0
    unlimited_scene, _ = read(tmp_path, arm(flags='<flag clampctrl="disable"/>', rest=drives(*actuators)))
    if "forcerange" not in actuators[0]:
        assert unlimited_scene.chain.links[0].joint_torque_limit is None


def test_a_range_of_controls_of_a_servo_is_told(tmp_path):
    servo = '<position name="hold" joint="a" kp="10" ctrlrange="-1 1"/>'
    scene, result = read(tmp_path, arm(rest=drives(servo) + key(ctrl="3")))
    assert scene.chain.links[0].joint_rest_angle == pytest.approx(-1.0)
    assert "actuator hold: its control is from -1 to 1; targets of a scene have no limits" in result.differs
    assert scene.inputs.joint_targets


def test_a_held_joint_has_no_remark(tmp_path):
    text = arm(
        b='stiffness="3 4 0" range="-1 1" frictionloss="2"',
        rest=drives('<damper joint="b" kv="1" ctrlrange="0 1"/>'),
    )
    _, result = read(tmp_path, text, joints=["a"])
    assert not [
        line
        for line in (*result.warnings, *result.differs, *result.left_out)
        if "joint b" in line or "actuator" in line
    ]
    assert "joint b: held at the start" in result.notes


def test_a_keyframe_is_chosen(tmp_path):
    keys = '<keyframe><key name="low" qpos=".1 .2"/><key name="high" qpos="-1 .5"/></keyframe>'
    first, result = read(tmp_path, arm(rest=keys))
    assert "start: keyframe low; keyframe can be high, none" in result.notes
    assert first.initial.angles == pytest.approx((-0.1, -0.3))
    high, _ = read(tmp_path, arm(rest=keys), keyframe="high")
    assert high.initial.angles == pytest.approx((1.0, 0.5))
    none, _ = read(tmp_path, arm(rest=keys), keyframe="none")
    assert none.initial.angles == (0.0, 0.0)
    assert "hi is not a keyframe" in refused(tmp_path, arm(rest=keys), keyframe="hi")
    assert "URDF has no keyframes" in refused(tmp_path, urdf(*TWO), keyframe="high")


MESH = '<asset><mesh name="shell" file="absent.stl"/><texture name="t" type="2d" file="absent.png"/></asset>'


def test_files_of_meshes_that_are_not_needed_may_be_absent(tmp_path):
    visible_mesh = '<geom type="mesh" mesh="shell" contype="0" conaffinity="0" mass="0"/>'
    scene, result = read(tmp_path, arm(asset=MESH, more=visible_mesh))
    assert scene.chain == read(tmp_path, arm())[0].chain
    assert "files absent.stl, absent.png: cannot be read" in result.left_out
    massive_mesh = visible_mesh.replace(' mass="0"', "")
    assert (
        "without the mass of mesh shell" in read(tmp_path, arm(asset=MESH, more=massive_mesh))[1].warnings[0]
    )
    text = arm(asset=MESH).replace(
        '<geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" />', massive_mesh
    )
    assert "a body has no mass but that of absent meshes: shell" in refused(tmp_path, text)

    generated, _ = read(tmp_path, urdf(*TWO, attributes='xmlns:xacro="http://www.ros.org/wiki/xacro"'))
    assert len(generated.chain.links) == 2


def test_a_proposal_converts(tmp_path):
    """Of seven joints, joints 2, 4, 6 and 7 have parallel axes, and joints 6 and 7 a common axis."""
    axes = ("0 0 1", "0 1 0", "0 0 1", "0 -1 0", "1 0 0", "0 1 0", "0 1 0")
    parts = [link(f"l{i}", ".1 0 0") for i in range(7)]
    for i, axis in enumerate(axes):
        parent, place = ("base", "0 0 1") if i == 0 else (f"l{i - 1}", "0 0 0" if i == 6 else ".2 0 0")
        parts.append(joint(f"j{i + 1}", parent, f"l{i}", place, axis=axis))
    message = refused(tmp_path, urdf(*parts))
    names = message.partition("choose joints ")[2].partition(":")[0].split(",")
    assert names[:2] == ["j2", "j4"]
    scene, _ = read(tmp_path, urdf(*parts), joints=names)
    assert len(scene.chain.links) == len(names) == 3
    message = refused(tmp_path, urdf(*parts), joints=["j2", "j4", "j6", "j7"])
    assert "joints j6 and j7 have the same axis; choose joints j2,j4,j7: these make" in message


def test_the_command_tells_warnings_first_and_quietly_nothing(tmp_path, capfd):
    file = tmp_path / "robot.xml"
    file.write_text(
        arm(upper='gravcomp="1"', rest=drives('<position joint="a" kp="3" kv="1"/>')), encoding="utf-8"
    )
    out = ["-o", str(tmp_path / "robot.toml")]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert main(["convert", str(file), "--plane=-x,z", "--tip", "tip", *out]) == 0
    lines = capfd.readouterr().out.splitlines()
    titles = [line.split()[0] for line in lines]
    assert titles == sorted(titles, key=["scene", "warning", "left", "note"].index)
    assert "warning  body upper: gravcomp bears 1 of its weight" in lines[1]
    assert (
        (tmp_path / "robot.toml")
        .read_text(encoding="utf-8")
        .splitlines()[1]
        .startswith("# warning: body upper")
    )
    assert main(["convert", str(file), "-q", *out]) == 0
    assert capfd.readouterr() == ("", "")
    for option in ("--plane", "--tip", "--keyframe"):
        assert main(["convert", "pinned_arm", option, "x", "-o", str(tmp_path / "x.xml")]) == 2
        assert f"{option}: a scene has nothing to choose" in capfd.readouterr().err

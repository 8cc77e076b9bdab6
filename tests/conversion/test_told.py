"""Contacts, limits, drives and shapes of robot files are converted, or reported."""

import math
import warnings

import numpy as np
import pytest

from chain_impact import SceneError
from chain_impact.cli import main
from chain_impact.conversion.convert import of_robot
from chain_impact.conversion.planar import Choices
from tests.conversion.robot_files import TWO, arm, drives, joint, key, link, urdf
from tests.tiers import needs_interop

pytestmark = needs_interop

FLOOR = '<geom name="floor" type="plane" size="3 3 .1" {}/>'


def read(tmp_path, text, **choices):
    file = tmp_path / ("robot.xml" if "<mujoco" in text else "robot.urdf")
    file.write_text(text, encoding="utf-8")
    return of_robot(file, Choices(**choices))


def refused(tmp_path, text, **choices):
    with pytest.raises(SceneError) as caught:
        read(tmp_path, text, **choices)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_disabled_contacts_and_limits_are_not_in_the_scene(tmp_path):
    limited = 'range="-30 30" limited="true"'
    scene, done = read(
        tmp_path, arm(flags='<flag contact="disable" limit="disable"/>', world=FLOOR.format(""), a=limited)
    )
    assert scene.half_planes == {}
    assert scene.chain.links[0].joint_min is None
    assert "flags: no limits of joints, no contacts: so in the scene" in done.notes
    assert done.warnings == []
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
def test_a_plane_is_a_wall_where_it_touches_and_has_the_friction_of_the_pair(
    tmp_path, floor, shape, rest, friction
):
    scene, done = read(tmp_path, arm(world=FLOOR.format(floor), shape=shape, rest=rest))
    if friction is None:
        assert scene.half_planes == {}
        assert "plane floor: nothing that moves touches it: it is no wall" in done.left_out
    else:
        assert list(scene.half_planes) == ["floor"]
        material = scene.contact.wall.get("floor")
        assert ((material and material.friction) or 0.0) == friction
        ends = {"pair": ("lower",), "exclude": ("upper",)}
        touching = next((names for word, names in ends.items() if word in rest), ("upper", "lower"))
        names = {site.name.partition("_")[0] for _, site in scene.chain.sites}
        assert (names, scene.contact.points) == (set(touching), ())


FOOT = {
    "sphere": ('<geom name="heel" size=".02" pos=".3 .1 -.1" mass=".1"/>', [(0.3, -0.1, 0.02, "heel")]),
    "capsule": (
        '<geom name="2nd toe" type="capsule" fromto=".3 0 .2 .2 .1 -.1" size=".04" mass=".1"/>',
        [(0.2, -0.1, 0.04, "geom_2nd_toe_1"), (0.3, 0.2, 0.04, "geom_2nd_toe_2")],
    ),
    "box": (
        '<geom type="box" size=".1 .05 .02" pos=".2 0 -.1" mass=".1"/>',
        [(x, z, 0.0, "") for x in (0.1, 0.3) for z in (-0.12, -0.08)],
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
"""Name → a shape of a foot, and its points: x and z in the body, radius and name."""


@pytest.mark.parametrize("name", FOOT)
@pytest.mark.parametrize("plane", ["x,z", "-x,z"])
@pytest.mark.parametrize("axis", [1, -1])
def test_what_touches_a_floor_becomes_points_where_the_file_has_it(tmp_path, name, plane, axis):
    shape, expected = FOOT[name]
    text = arm(world=FLOOR.format(""), lower='euler="0 25 0"', rest=key(qpos=".3 -.7"))
    bare = '<geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" />'
    text = text.replace(bare, bare.replace("/>", 'contype="0" conaffinity="0"/>') + shape)
    text = text.replace('name="b" axis="0 1 0"', f'name="b" axis="0 {axis} 0"')
    scene, done = read(tmp_path, text, plane=plane)
    assert scene.contact.points == ()
    found = [(*at, site.name) for (i, site), at in zip(scene.chain.sites, starts(scene), strict=True) if i]
    # about +y, in radians: the euler angle and both joint angles; the floor is at z = 0
    turn, sign = math.radians(25) + 0.3 - axis * 0.7, 1 if plane == "x,z" else -1
    knee = 0.4 * math.cos(0.3), 1.5 - 0.4 * math.sin(0.3)
    if expected is None:  # an oblique view of a cylinder: a rectangle with ellipses at its ends
        middle = sign * (knee[0] + 0.3 * math.cos(turn) - 0.1 * math.sin(turn))
        away = np.array([row[:2] for row in found]) - (
            middle,
            knee[1] - 0.3 * math.sin(turn) - 0.1 * math.cos(turn),
        )
        axes = np.array([[sign * math.cos(turn), -math.sin(turn)], [sign * math.sin(turn), math.cos(turn)]])
        tilt = math.radians(70)
        sizes = 0.02, 0.1 * math.cos(tilt) + 0.02 * math.sin(tilt)
        assert np.abs(away @ axes.T).max(axis=0) == pytest.approx(sizes, abs=1e-12)
        return
    rows = [
        (
            sign * (knee[0] + x * math.cos(turn) + z * math.sin(turn)),
            knee[1] - x * math.sin(turn) + z * math.cos(turn),
            radius,
        )
        for x, z, radius, _ in expected
    ]
    assert sorted(row[:3] for row in found) == [pytest.approx(row, abs=1e-12) for row in sorted(rows)]
    assert {row[3] for row in found} == {row[3] for row in expected}
    assert not [line for line in done.warnings if "reach" in line]


def starts(scene):
    """Return the place and radius of the points of links at the start."""
    return [at for number, at in scene.start.items() if number > len(scene.chain.links)]


def test_a_point_that_starts_within_a_wall_is_smaller_or_left_out_and_told(tmp_path):
    ball = '<geom name="{}" size=".05" pos=".3 0 {}" mass=".1"/>'
    shapes = ball.format("heel", "-1.47") + ball.format("toe", "-1.6")
    text = arm(world=FLOOR.format("")).replace("<site", f"{shapes}<site")
    scene, done = read(tmp_path, text)
    radii = {site.name: site.radius for _, site in scene.chain.sites}
    assert "toe" not in radii
    assert any("point toe starts 0.15 m deep in floor: it is left out" in line for line in done.warnings)
    ball = ball.format("heel", "-1.47")
    scene, done = read(tmp_path, arm(world=FLOOR.format("")).replace("<site", f"{ball}<site"))
    assert {site.name: site.radius for _, site in scene.chain.sites}["heel"] == pytest.approx(0.03)
    assert any(
        "point heel starts 0.02 m deep in floor: its radius is smaller" in line for line in done.warnings
    )


def test_a_carriage_that_touches_the_floor_is_told(tmp_path):
    box = '<body name="box" pos="0 0 1.5"><joint name="rail" type="slide" axis="1 0 0"/><geom size=".1"/>'
    text = arm(world=FLOOR.format("")).replace(
        '<body name="upper" pos="0 0 1.5" >', f'{box}<body name="upper">'
    )
    _, done = read(tmp_path, text.replace("</worldbody>", "</body></worldbody>"))
    assert "body box: touches walls in the file; it is on no link, and touches none" in done.left_out


def test_an_ellipsoid_that_reaches_beyond_the_points_is_told_with_the_distance(tmp_path):
    heel = '<geom type="ellipsoid" pos=".2 0 -.1" size=".05 .02 .1" mass=".1"/>'
    text = arm(world=FLOOR.format("")).replace("<site", f"{heel}<site")
    _, done = read(tmp_path, text)
    (line,) = [line for line in done.warnings if "shapes reach" in line and "joint b" in line]
    assert "reach 0.18 m, 60 % of the length" in line


def test_dozens_of_shapes_are_one_line(tmp_path):
    eggs = '<geom type="ellipsoid" size=".01 .01 .01" pos=".{:02} 0 0" mass="0"/>'
    _, done = read(tmp_path, arm(more="".join(map(eggs.format, range(30))), world=FLOOR.format("")))
    (line,) = [line for line in done.left_out if "ellipsoid" in line]
    assert line.startswith("shapes 30 ellipsoids: touch nothing as such")


def test_of_dozens_of_shapes_only_those_that_a_wall_can_touch_first_are_points(tmp_path):
    balls = "".join(f'<geom type="sphere" size=".05" pos=".{i:02} 0 0" mass="0"/>' for i in range(10, 30))
    scene, _ = read(tmp_path, arm(more=balls, world=FLOOR.format("")))
    assert [(site.x, site.radius) for i, site in scene.chain.sites if i == 0] == [
        (0.4, 0.03),
        (0.1, 0.05),
        (0.29, 0.05),
    ]


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
    kept, _ = read(tmp_path, arm(a='actuatorfrcrange="-3 3"', rest=drives(*actuators)))
    assert kept.chain.links[0].joint_torque_limit == 3.0
    free, _ = read(tmp_path, arm(flags='<flag clampctrl="disable"/>', rest=drives(*actuators)))
    if "forcerange" not in actuators[0]:
        assert free.chain.links[0].joint_torque_limit is None


def test_a_range_of_controls_of_a_servo_is_told(tmp_path):
    servo = '<position name="hold" joint="a" kp="10" ctrlrange="-1 1"/>'
    scene, done = read(tmp_path, arm(rest=drives(servo) + key(ctrl="3")))
    assert scene.chain.links[0].joint_rest_angle == pytest.approx(-1.0)
    assert "actuator hold: its control is from -1 to 1; targets of a scene have no limits" in done.differs
    assert scene.inputs.joint_targets


def test_nothing_is_told_of_what_is_held(tmp_path):
    text = arm(
        b='stiffness="3 4 0" range="-1 1" frictionloss="2"',
        rest=drives('<damper joint="b" kv="1" ctrlrange="0 1"/>'),
    )
    _, done = read(tmp_path, text, joints=["a"])
    assert not [
        line
        for line in (*done.warnings, *done.differs, *done.left_out)
        if "joint b" in line or "actuator" in line
    ]
    assert "joint b: held at the start" in done.notes


def test_a_keyframe_is_chosen(tmp_path):
    keys = '<keyframe><key name="low" qpos=".1 .2"/><key name="high" qpos="-1 .5"/></keyframe>'
    first, done = read(tmp_path, arm(rest=keys))
    assert "start: keyframe low; --keyframe can take high, none" in done.notes
    assert first.initial.angles == pytest.approx((-0.1, -0.3))
    high, _ = read(tmp_path, arm(rest=keys), keyframe="high")
    assert high.initial.angles == pytest.approx((1.0, 0.5))
    none, _ = read(tmp_path, arm(rest=keys), keyframe="none")
    assert none.initial.angles == (0.0, 0.0)
    assert "hi is no keyframe" in refused(tmp_path, arm(rest=keys), keyframe="hi")
    assert "URDF has no keyframes" in refused(tmp_path, urdf(*TWO), keyframe="high")


MESH = '<asset><mesh name="shell" file="absent.stl"/><texture name="t" type="2d" file="absent.png"/></asset>'


def test_files_that_nothing_needs_may_be_absent(tmp_path):
    seen = '<geom type="mesh" mesh="shell" contype="0" conaffinity="0" mass="0"/>'
    scene, done = read(tmp_path, arm(asset=MESH, more=seen))
    assert scene.chain == read(tmp_path, arm())[0].chain
    assert "files absent.stl, absent.png: cannot be read; nothing needs it" in done.left_out
    weighed = seen.replace(' mass="0"', "")
    assert "without the mass of mesh shell" in read(tmp_path, arm(asset=MESH, more=weighed))[1].warnings[0]
    only = arm(asset=MESH).replace(
        '<geom name="lower" type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="1" />', weighed
    )
    assert "a body has no mass but that of absent meshes: shell" in refused(tmp_path, only)


def limited(low, high, effort=5):
    return {
        "kind": "revolute",
        "more": f'<limit lower="{low}" upper="{high}" effort="{effort}" velocity="2"/>',
    }


def test_equal_limits_name_the_joint_and_what_converts(tmp_path):
    parts = [link("u"), link("l"), joint("a", "base", "u", **limited(0, 0)), joint("b", "u", "l", ".3 0 0")]
    told = refused(tmp_path, urdf(*parts))
    assert "joint a: its limits are equal, 0 rad, so it cannot move" in told
    assert "--joints b takes joints that make a chain" in told
    scene, _ = read(tmp_path, urdf(*parts), joints=["b"])
    assert len(scene.chain.links) == 1
    parts[2] = joint("a", "base", "u", **limited(1, -1))
    assert "joint a: its lower limit, 1 rad, is above its upper limit, -1 rad" in refused(
        tmp_path, urdf(*parts)
    )


def test_an_effort_of_zero_is_told(tmp_path):
    parts = [link("u"), joint("a", "base", "u", **limited(-1, 1, effort=0))]
    scene, done = read(tmp_path, urdf(*parts))
    assert scene.chain.links[0].joint_torque_limit is None
    assert "joint a: limit of the effort 0: is taken as none" in done.left_out


def test_moments_of_inertia_that_no_body_has_are_told(tmp_path):
    parts = [link("u").replace('ixx=".01"', 'ixx=".05"'), joint("a", "base", "u")]
    told = "link u: its moments of inertia, 0.02, 0.02 and 0.05 kg.m2, are those of no body"
    assert told in read(tmp_path, urdf(*parts))[1].differs


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        (['<joint name="a" type="fixed"/>'], "joint a: has no parent, must have one as in"),
        ([link("u"), joint("a", "base", "u", axis="0 0 0")], "robot.urdf: joint a: its axis is 0 0 0"),
        ([link("u", mass="1kg"), joint("a", "base", "u")], "link u cannot be read: could not convert"),
        ([link("u"), link("u"), joint("a", "base", "u")], "a link has 2 times the name u"),
        ([link("u"), joint("a", "base", "u"), joint("b", "base", "u")], "link u is the child of two joints"),
        ([link("u"), joint("a", "u", "u")], "joints make a ring of u; each link must lead back to base"),
    ],
)
def test_a_urdf_that_makes_no_sense_is_refused_with_the_place(tmp_path, parts, said):
    assert said in refused(tmp_path, urdf(*parts))


def test_unreadable_colours_and_absent_meshes_of_urdf_do_not_matter(tmp_path):
    mesh, colour = '<geometry><mesh filename="no.dae"/></geometry>', '<color rgba="red"/>'
    seen = f'<visual>{mesh}<material name="m">{colour}</material></visual>'
    scene, done = read(
        tmp_path,
        urdf(
            link("u", more=seen), joint("a", "base", "u"), '<material name="n"><color rgba="x"/></material>'
        ),
    )
    assert len(scene.chain.links) == 1
    assert done.left_out == ["shapes 1 mesh: touch nothing in the file, and are not in the scene"]


def test_what_urdf_does_not_know_is_told(tmp_path):
    extra = '<gazebo reference="u"><mu1>2</mu1></gazebo>'
    text = urdf(
        link("u", more="<contact><stiffness value='3'/></contact>"),
        joint("a", "base", "u", more="<calibration rising='1'/>"),
        extra,
    )
    _, done = read(tmp_path, text)
    assert set(done.left_out) == {
        "element gazebo u: is not in the scene: mu1",
        "link u: contact: is not in the scene",
        "joint a: calibration rising 1: is not in the scene",
    }


@pytest.mark.parametrize(
    "part", ["<xacro:include filename='x'/>", '<link name="${prefix}l"/>'], ids=["element", "text"]
)
def test_of_a_xacro_file_it_is_said_to_run_xacro(tmp_path, part):
    told = refused(tmp_path, urdf(*TWO, part, attributes='xmlns:xacro="http://www.ros.org/wiki/xacro"'))
    assert "run xacro first" in told
    generated, _ = read(tmp_path, urdf(*TWO, attributes='xmlns:xacro="http://www.ros.org/wiki/xacro"'))
    assert len(generated.chain.links) == 2


def test_a_proposal_converts(tmp_path):
    """Of seven joints, joints 2, 4, 6 and 7 have parallel axes, and joints 6 and 7 a common axis."""
    axes = ("0 0 1", "0 1 0", "0 0 1", "0 -1 0", "1 0 0", "0 1 0", "0 1 0")
    parts = [link(f"l{i}", ".1 0 0") for i in range(7)]
    for i, axis in enumerate(axes):
        parent, place = ("base", "0 0 1") if i == 0 else (f"l{i - 1}", "0 0 0" if i == 6 else ".2 0 0")
        parts.append(joint(f"j{i + 1}", parent, f"l{i}", place, axis=axis))
    told = refused(tmp_path, urdf(*parts))
    names = told.partition("--joints ")[2].partition(" takes")[0].split(",")
    assert names[:2] == ["j2", "j4"]
    scene, _ = read(tmp_path, urdf(*parts), joints=names)
    assert len(scene.chain.links) == len(names) == 3
    told = refused(tmp_path, urdf(*parts), joints=["j2", "j4", "j6", "j7"])
    assert "joints j6 and j7 have the same axis; --joints j2,j4,j7 takes" in told


def cart(axis="1 0 0", more="", **parts):
    rail = f'<joint name="rail" type="slide" axis="{axis}" {more}/><joint name="a"'
    return arm(**parts).replace('<joint name="a"', rail)


def test_a_slide_that_is_not_in_the_plane_or_not_before_the_hinges_is_refused_with_a_proposal(tmp_path):
    assert "joint rail slides" in (told := refused(tmp_path, cart("0 1 0")))
    assert "--joints a,b takes joints" in told
    finger = '<body pos=".3 0 0"><joint name="finger" type="slide" axis="1 0 0"/><geom size=".02"/></body>'
    text = arm().replace('<site name="tip" pos=".3 0 0"/>', f'<site name="tip" pos=".3 0 0"/>{finger}')
    assert "joint finger slides" in (told := refused(tmp_path, text))
    assert "--joints a,b takes joints" in told


def test_of_joints_about_several_axes_a_slide_and_its_hinges_are_proposed(tmp_path):
    text = cart().replace('<joint name="b" axis="0 1 0"', '<joint name="b" axis="0 0 1"')
    assert "--joints rail,a takes" in refused(tmp_path, text)


def test_a_slide_is_a_slider_with_what_its_joint_and_drives_have(tmp_path):
    text = cart(
        "-3 0 0",
        'ref=".2" range="-.4 .9" limited="true" stiffness="8" springref=".5" damping=".7" frictionloss=".3"',
        rest=drives('<position joint="rail" kp="40" kv="2" forcerange="-6 6"/>', '<motor joint="a"/>')
        + key(qpos=".3 .1 0", qvel=".5 0 0", ctrl=".6 0"),
        b='ref="20"',
    )
    scene, done = read(tmp_path, text)
    slider, start = scene.chain.slider, scene.initial
    assert slider.angle == pytest.approx(math.pi)
    assert (slider.mass, slider.friction, slider.force_limit) == (0.0, 0.3, 6.0)
    assert (slider.stiffness, slider.damping) == pytest.approx((48.0, 2.7))
    # positions of the file minus 0.3 m, the initial position
    assert (slider.min, slider.max) == pytest.approx((-0.7, 0.6))
    assert slider.rest_position == pytest.approx((8 * 0.5 + 40 * 0.6) / 48 - 0.3)
    assert start.position == pytest.approx((0.2 - 0.3, 1.5))
    assert start.slider_velocity == 0.5
    assert scene.inputs.joint_targets
    assert scene.inputs.joint_torques
    assert not scene.inputs.slider_force
    assert "joint rail: limits are soft in MuJoCo; a scene has its own, in [contact]" in done.differs
    motor, _ = read(tmp_path, cart(rest=drives('<motor joint="rail" gear="10" ctrlrange="-1 1"/>')))
    assert motor.inputs.slider_force
    assert motor.chain.slider.force_limit == 10.0


def test_a_slide_that_starts_beyond_its_limit_starts_there(tmp_path):
    scene, done = read(tmp_path, cart(more='range=".1 .9" limited="true"'))
    assert scene.initial.position == pytest.approx((0.1, 1.5))
    assert (scene.chain.slider.min, scene.chain.slider.max) == pytest.approx((0.0, 0.8))
    assert (
        "joint rail: starts at its stop, 0.1 m from the start of the file, which is beyond" in done.warnings
    )


def test_the_armature_of_a_slide_that_rises_is_told_as_a_weight(tmp_path):
    scene, done = read(tmp_path, cart("0 0 1", 'armature=".5"'))
    assert scene.chain.slider.mass == 0.5
    told = "joint rail: its armature, 0.5 kg, is part of the mass of the carriage, which has weight"
    assert told in done.warnings
    assert told in read(tmp_path, cart("1 0 0", 'armature=".5"'))[1].differs


def test_equal_limits_of_a_slide_are_refused_with_its_unit(tmp_path):
    parts = [link("u"), link("l"), joint("b", "u", "l", ".3 0 0")]
    parts.append(
        joint(
            "s", "base", "u", kind="prismatic", axis="1 0 0", more='<limit lower="0" upper="0" effort="1"/>'
        )
    )
    assert "joint s: its limits are equal, 0 m, so it cannot move" in refused(tmp_path, urdf(*parts))


def test_the_command_tells_warnings_first_and_quietly_nothing(tmp_path, capfd):
    file = tmp_path / "robot.xml"
    file.write_text(
        arm(upper='gravcomp="1"', rest=drives('<position joint="a" kp="3" kv="1"/>')), encoding="utf-8"
    )
    out = ["-o", str(tmp_path / "robot.toml")]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert main(["convert", str(file), "--plane=-x,z", "--tip", "tip", *out]) == 0
    said = capfd.readouterr().out.splitlines()
    titles = [line.split()[0] for line in said]
    assert titles == sorted(titles, key=["scene", "warning", "left", "note"].index)
    assert "warning  body upper: gravcomp bears 1 of its weight" in said[1]
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

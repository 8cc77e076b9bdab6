"""What the conversion of URDF tells, and what it refuses."""

# Tests: conversion/urdf.py, conversion/urdf_elements.py

from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from chain_impact.conversion.differences import LEFT_OUT, WARNING
from chain_impact.conversion.urdf_elements import other_elements
from tests.conversion.robot_files import TWO, joint, link, read, refused, urdf
from tests.tiers import needs_interop

pytestmark = needs_interop


def limited(low, high, effort=5):
    return {
        "kind": "revolute",
        "content": f'<limit lower="{low}" upper="{high}" effort="{effort}" velocity="2"/>',
    }


def test_equal_limits_name_the_joint_and_what_converts(tmp_path):
    parts = [link("u"), link("l"), joint("a", "base", "u", **limited(0, 0)), joint("b", "u", "l", ".3 0 0")]
    message = refused(tmp_path, urdf(*parts))
    assert "joint a: its limits are equal, 0 rad, so it cannot move" in message
    assert "choose joints b: these make a chain" in message
    scene, _ = read(tmp_path, urdf(*parts), joints=["b"])
    assert len(scene.chain.links) == 1
    parts[2] = joint("a", "base", "u", **limited(1, -1))
    assert "joint a: its lower limit, 1 rad, is above its upper limit, -1 rad" in refused(
        tmp_path, urdf(*parts)
    )


def test_an_effort_of_zero_is_told(tmp_path):
    parts = [link("u"), joint("a", "base", "u", **limited(-1, 1, effort=0))]
    scene, result = read(tmp_path, urdf(*parts))
    assert scene.chain.links[0].joint_torque_limit is None
    assert "joint a: limit of the effort 0: is taken as none" in result.left_out


def test_moments_of_inertia_that_no_body_has_are_told(tmp_path):
    parts = [link("u").replace('ixx=".01"', 'ixx=".05"'), joint("a", "base", "u")]
    message = "link u: no rigid body can have the moments of inertia 0.02, 0.02 and 0.05 kg·m²"
    assert message in read(tmp_path, urdf(*parts))[1].differs


def test_a_moment_of_inertia_counts_without_a_mass(tmp_path):
    bare, _ = read(tmp_path, urdf(*TWO))
    tool = link("tool", center="0 0 0", mass=0)
    scene, _ = read(tmp_path, urdf(*TWO[:2], tool, *TWO[3:]))
    first, last = scene.chain.links
    assert first == bare.chain.links[0]
    assert last.inertia == pytest.approx(bare.chain.links[1].inertia + 0.02, rel=1e-12)
    assert (last.mass, last.center_of_mass) == (0.5, bare.chain.links[1].center_of_mass)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (['<joint name="a" type="fixed"/>'], "joint a: has no parent, must have one as in"),
        ([link("u"), joint("a", "base", "u", axis="0 0 0")], "robot.urdf: joint a: its axis is 0 0 0"),
        ([link("u", mass="1kg"), joint("a", "base", "u")], "link u cannot be read: could not convert"),
        ([link("u", mass=-1), joint("a", "base", "u")], "link u: mass value = -1 must be at least 0"),
        ([link("u", "inf 0 0"), joint("a", "base", "u")], "link u: origin xyz = inf 0 0 must be finite"),
        (
            [link("u"), joint("a", "base", "u", content='<dynamics damping="nan"/>')],
            "joint a: dynamics damping = nan",
        ),
        (
            [link("u"), joint("a", "base", "u", **limited("nan", 1))],
            "joint a: limit lower = nan must be a number",
        ),
        (
            [link("u"), joint("a", "base", "u", content='<axis xyz="1 0 0"/>')],
            "joint a: has 2 elements axis, must",
        ),
        (
            [link("u").replace("<mass", '<mass value="2"/><mass'), joint("a", "base", "u")],
            "link u: has 2 elements mass",
        ),
        ([link("u"), link("u"), joint("a", "base", "u")], "2 links have the name u"),
        ([link("u"), joint("a", "base", "u"), joint("b", "base", "u")], "link u is the child of two joints"),
        ([link("u"), joint("a", "u", "u")], "joints make a ring of u; each link must lead back to base"),
        (['<link name="u"/>', joint("a", "base", "u")], "on the axis of joint a; u has no mass in the file"),
    ],
)
def test_a_urdf_that_makes_no_sense_is_refused_with_the_place(tmp_path, parts, message):
    assert message in refused(tmp_path, urdf(*parts))


def test_unreadable_colours_and_absent_meshes_of_urdf_do_not_matter(tmp_path):
    mesh, colour = '<geometry><mesh filename="no.dae"/></geometry>', '<color rgba="red"/>'
    visual = f'<visual>{mesh}<material name="m">{colour}</material></visual>'
    scene, result = read(
        tmp_path,
        urdf(
            link("u", content=visual),
            joint("a", "base", "u"),
            '<material name="n"><color rgba="x"/></material>',
        ),
    )
    assert len(scene.chain.links) == 1
    assert result.left_out == ["shapes 1 mesh: touch nothing in the file, and are not in the scene"]


def test_quantities_that_urdf_does_not_know_are_reported(tmp_path):
    extra = '<gazebo reference="u"><mu1>2</mu1></gazebo>'
    text = urdf(
        link("u", content="<contact><stiffness value='3'/></contact>"),
        joint("a", "base", "u", content="<calibration rising='1'/>"),
        extra,
    )
    _, result = read(tmp_path, text)
    assert set(result.left_out) == {
        "element gazebo u: is not in the scene: mu1",
        "link u: contact: is not in the scene",
        "joint a: calibration rising 1: is not in the scene",
    }


def test_a_mimic_is_told_of_a_moving_joint_only(tmp_path):
    mimic = '<mimic joint="a"/>'
    grip = joint("grip", "lower", "tool", kind="fixed", content=mimic)
    for b, count in (("", 0), (mimic, 1)):
        _, result = read(tmp_path, urdf(*TWO[:4], joint("b", "upper", "lower", ".3 0 0", content=b), grip))
        lines = [line for line in (*result.warnings, *result.left_out) if "mimic" in line]
        assert len(lines) == count
        assert all(line.startswith("joint b: ") for line in lines)


@pytest.mark.parametrize(
    "part", ["<xacro:include filename='x'/>", '<link name="${prefix}l"/>'], ids=["element", "text"]
)
def test_a_xacro_file_is_refused_with_the_advice_to_run_xacro(tmp_path, part):
    message = refused(tmp_path, urdf(*TWO, part, attributes='xmlns:xacro="http://www.ros.org/wiki/xacro"'))
    assert "run xacro first" in message


SHAPE = """<collision name="{name}">
  <origin xyz="{xyz}" rpy="{rpy}"/><geometry>{geometry}</geometry>
</collision>"""


@pytest.mark.parametrize(
    ("geometry", "xyz", "rpy", "expected"),
    [
        # corners (x, z) of a box, turned by a quarter of a turn about the axis of the joint
        ('<box size=".2 .1 .06"/>', ".3 0 0", "0 1.5707963267948966 0", [(0.27, 0.1), (0.33, 0.1)]),
        ('<sphere radius=".02"/>', ".3 0 -.05", "0 0 0", [(0.3, -0.05)]),
        (
            '<cylinder radius=".03" length=".4"/>',
            ".1 0 0",
            "0 1.5707963267948966 0",
            [(0.3, 0.03), (-0.1, 0.03)],
        ),
    ],
)
def test_collision_shapes_are_points(tmp_path, geometry, xyz, rpy, expected):
    shape = SHAPE.format(name="heel", geometry=geometry, xyz=xyz, rpy=rpy)
    parts = [link("u").replace("</link>", f"{shape}</link>"), joint("a", "base", "u")]
    scene, result = read(tmp_path, urdf(*parts))
    points = scene.chain.links[0].points
    assert all(point.name.startswith("heel") for point in points)
    # the link may point along any direction of the plane: distances from the joint do not depend on it
    distances = sorted({round(float(np.hypot(point.x, point.y)), 12) for point in points})
    assert {round(float(np.hypot(*point)), 12) for point in expected} <= set(distances)
    assert {point.radius for point in points} == ({0.02} if "sphere" in geometry else {0.0})
    assert not [text for text in result.left_out if "shapes" in text]


def test_ends_of_a_link_touch_in_place_of_its_mesh(tmp_path):
    shapes = {
        name: SHAPE.format(name=name, geometry=geometry, xyz=".2 0 0", rpy="0 0 0")
        for name, geometry in (("skin", '<mesh filename="no.stl"/>'), ("heel", '<sphere radius="0.02"/>'))
    }
    links = {name: link(name).replace("</link>", f"{shape}</link>") for name, shape in shapes.items()}
    first = joint("a", "base", "skin")
    scene, result = read(tmp_path, urdf(links["skin"], first))
    assert not scene.chain.links[0].points
    assert scene.contact.points == (1,)
    assert any("a: outlines of shapes (mesh) are not known: the two ends" in text for text in result.differs)
    # also if another link has points
    scene, result = read(tmp_path, urdf(*links.values(), first, joint("b", "skin", "heel", ".3 0 0")))
    assert len(scene.chain.links[1].points) == 1
    assert scene.contact.points == (1,)
    assert any("a: outlines of shapes (mesh) are not known: the two ends" in text for text in result.differs)


def test_a_link_without_shapes_beside_links_with_shapes_is_told_first(tmp_path):
    heel = SHAPE.format(name="heel", geometry='<sphere radius="0.02"/>', xyz=".2 0 0", rpy="0 0 0")
    sole = link("sole").replace("</link>", f"{heel}</link>")
    joints = joint("a", "base", "bare"), joint("b", "bare", "sole", ".3 0 0")
    scene, result = read(tmp_path, urdf(link("bare"), sole, *joints))
    assert scene.contact.points == ()
    assert result.warnings == [
        "link of joint a: has no contact of its own, as no shape there can touch; "
        "contact.points can add its ends"
    ]
    # without any shape, all ends touch
    scene, result = read(tmp_path, urdf(link("bare"), link("sole"), *joints))
    assert scene.contact.points == (1, 2)
    assert not result.warnings


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_a_free_base_of_urdf_is_refused_with_the_joints_to_write(tmp_path, kind):
    root = joint("root", "base", "u").replace("revolute", kind).replace("continuous", kind)
    message = refused(tmp_path, urdf(link("u"), root))
    assert f"joint root is of the kind {kind}: a scene has hinges and slides only; for a" in message
    assert "two slides at right angles and a hinge" in message


@pytest.mark.parametrize(
    ("extension", "title"),
    [
        ('<gazebo reference="u"><gravity>false</gravity></gazebo>', WARNING),
        ('<gazebo reference="u"><gravity> True </gravity><mu1>1</mu1></gazebo>', LEFT_OUT),
        ('<gazebo reference="a"><springStiffness>5</springStiffness></gazebo>', WARNING),
        ('<gazebo reference="a"><springStiffness>0</springStiffness></gazebo>', LEFT_OUT),
        ('<mujoco><compiler strippath="true"/><option gravity="0 0 -3"/></mujoco>', WARNING),
        ('<mujoco><compiler settotalmass="5"/></mujoco>', WARNING),
        ('<mujoco><compiler strippath="true"/><!-- a remark --></mujoco>', LEFT_OUT),
        ('<gazebo reference="a"><dampingFactor>0.0</dampingFactor></gazebo>', LEFT_OUT),
        ('<gazebo reference="u"><gravity>1.0</gravity></gazebo>', LEFT_OUT),
        ('<mujoco><option timestep="0.001"/><compiler settotalmass="-1"/></mujoco>', LEFT_OUT),
        ('<sensor name="s"><gravity>0</gravity></sensor>', LEFT_OUT),
    ],
)
def test_an_extension_for_a_simulator_that_changes_the_motion_is_a_warning(extension, title):
    differences = [*other_elements(fromstring(f"<robot>{extension}</robot>"))]
    assert [difference.title for difference in differences] == [title]

"""Conversion of robots in URDF and MJCF into scenes, and back; a scene compared with MuJoCo."""

# Tests: conversion/mjcf_writing.py, conversion/mjcf.py, conversion/mjcf_files.py, conversion/urdf.py

import numpy as np
import pytest

from chain_impact import SceneError, load_scene, model_names, simulate
from chain_impact.cli import main
from chain_impact.conversion.convert import convert, scene_of_robot
from chain_impact.conversion.mjcf_writing import mjcf_of
from chain_impact.conversion.planar import ConversionChoices
from chain_impact.scene.files.models import models_folder
from chain_impact.scene.scene import scene_from_dict, scene_of
from tests.tiers import needs_interop

pytestmark = needs_interop

URDF = """
<robot name="two links">
  <link name="world"/>
  <link name="base"><inertial><mass value="3"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="upper">
    <inertial><origin xyz="0 0 -0.1" rpy="0 0 0"/><mass value="0.5"/>
      <inertia ixx="0.003" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.001"/></inertial>
    <visual><geometry><mesh filename="package://upper.dae"/></geometry></visual>
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
  </link>
  <link name="lower">
    <inertial><origin xyz="0 0 0.05" rpy="0 0 0"/><mass value="0.25"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>
  </link>
  <link name="tool"/>
  <joint name="mount" type="fixed"><origin xyz="0 0 1"/><parent link="world"/><child link="base"/></joint>
  <joint name="shoulder" type="revolute">
    <origin xyz="0.02 0 0"/><parent link="base"/><child link="upper"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="2" effort="7" velocity="20"/>
  </joint>
  <joint name="elbow" type="continuous">
    <origin xyz="0.03 0 -0.2" rpy="3.141592653589793 0 0"/><parent link="upper"/><child link="lower"/>
    <axis xyz="1 0 0"/><dynamics damping="0.01" friction="0.02"/>
  </joint>
  <joint name="flange" type="fixed"><origin xyz="0 0 0.15"/><parent link="lower"/><child link="tool"/></joint>
  <transmission name="drive"/>
</robot>
"""
MJCF = """
<mujoco model="hopper">
  <compiler angle="degree"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1" friction="0.8 0.1 0.1"/>
    <body name="thigh" pos="0 0 1.25">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="z" type="slide" axis="0 0 1" ref="1.25"/>
      <joint name="turn" type="hinge" axis="0 1 0"/>
      <geom name="thigh" type="capsule" fromto="0 0 0 0 0 -0.4" size="0.05"/>
      <body name="leg" pos="0 0 -0.4">
        <joint name="knee" type="hinge" axis="0 1 0" range="-150 0"
               stiffness="4" springref="-20" armature="0.1"/>
        <geom type="mesh" mesh="shin"/>
        <geom name="leg" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.04"/>
        <site name="foot" pos="0 0 -0.5"/>
      </body>
    </body>
  </worldbody>
  <asset><mesh name="shin" file="not_there.obj"/></asset>
  <actuator><motor name="drive" joint="knee" gear="20" ctrlrange="-1 1"/></actuator>
  <sensor><jointpos name="bend" joint="knee"/></sensor>
</mujoco>
"""


def written(tmp_path, name, text):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / name


def carts():
    """Yield an arm on a slider with all slider values, and an arm whose carriage has no mass."""
    heel = {"x": 0.3, "y": -0.1, "radius": 0.02, "name": "heel"}
    links = [{"length": 0.5, "mass": 1.0, "center_of_mass_offset": 0.05}, {"length": 0.4, "mass": 0.7}]
    links[1]["points"] = [heel, {"x": -0.1, "y": 0.2}]
    slider = {"angle": 0.4, "mass": 2.0, "damping": 0.3, "stiffness": 20.0, "rest_position": -0.1}
    slider |= {"friction": 0.2, "min": -0.3, "max": 0.9, "force_limit": 8.0}
    for name, table in (("cart", slider), ("rail", {"angle": -2.0, "mass": 0.0, "max": 1.5})):
        yield scene_from_dict(
            {
                "name": name,
                "chain": {"base": "slider", "slider": table, "links": links},
                "contact": {"points": []},
                "inputs": {"slider_force": True, "joint_torques": True},
                "initial": {"position": [0.1, 0.2], "angles": [0.3, -1.0], "slider_velocity": 0.6},
            },
            name,
        )


@pytest.mark.parametrize("model", [*model_names(), *carts()], ids=lambda model: getattr(model, "name", model))
def test_a_scene_is_the_same_again_after_mjcf(model, tmp_path):
    scene = scene_of(model)
    converted_scene, result = scene_of_robot(written(tmp_path, "model.xml", mjcf_of(scene)[0]))
    assert (result.warnings, result.left_out) == ([], [])
    assert list(converted_scene.values) == list(scene.values)
    for name, value in scene.values.items():
        converted_value = converted_scene.values[name]
        assert converted_value == value, name


def test_the_model_of_a_real_arm_is_what_convert_makes_of_its_file():
    """Base, inputs and links are those of the file; starting angles, targets and limits may differ."""
    joints = ["shoulder_lift_joint", "elbow_joint", "wrist_1_joint"]
    converted_scene, _ = scene_of_robot(models_folder() / "ur5e" / "ur5e.xml", ConversionChoices(joints))
    model = load_scene("ur5e")
    assert converted_scene.initial.position == model.initial.position
    assert converted_scene.inputs == model.inputs
    keys = ("length", "mass", "center_of_mass", "center_of_mass_offset", "inertia")
    keys += ("joint_damping", "joint_stiffness")
    keys += ("joint_friction", "joint_armature", "joint_torque_limit")
    for link, model_link in zip(converted_scene.chain.links, model.chain.links, strict=True):
        assert [getattr(link, key) for key in keys] == [getattr(model_link, key) for key in keys]


WITHOUT_BOX = {"box.x_min": None, "box.x_max": None, "box.y_min": None, "box.y_max": None}
FAR_STOPS = {"slider.max": 9.0, "slider.friction": 0.0, "slider.force_limit": 1e3}
WITHOUT_WALL = {"box.x_max": None, "link[2].joint_armature": 0.05, "link[2].joint_stiffness": 3.0}


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("four_link_box", WITHOUT_BOX),
        ("triple_pendulum", {}),
        ("pinned_arm", WITHOUT_WALL | {"link[2].joint_rest_angle": 0.4}),
        *zip(carts(), (FAR_STOPS | {"slider.min": -9.0}, {"slider.max": 9.0}), strict=True),
        ("triple_pendulum", {"link[1].center_of_mass_offset": 0.1, "link[3].center_of_mass_offset": -0.2}),
    ],
)
def test_in_flight_mujoco_moves_as_the_scene(model, changes):
    import mujoco

    run = {"simulation.stop_time": 1.0, "solver.tolerance": 1e-12}
    scene = scene_of(model).with_values({**changes, **run})
    scene = scene.with_values({"contact.points": []})
    mujoco_model = mujoco.MjModel.from_xml_string(mjcf_of(scene)[0])
    data = mujoco.MjData(mujoco_model)
    mujoco.mj_resetDataKeyframe(mujoco_model, data, 0)
    mujoco_model.opt.timestep = 1e-3
    for _ in range(1000):
        mujoco.mj_step(mujoco_model, data)
    mujoco.mj_forward(mujoco_model, data)
    tip = data.site(f"point[{len(scene.chain.links)}]").xpos
    assert tip[[0, 2]] == pytest.approx(simulate(scene).points[-1, -1], abs=1e-9)


def test_a_urdf_becomes_a_scene_and_what_is_left_out_is_named(tmp_path, capsys):
    file, scene = written(tmp_path, "arm.urdf", URDF), tmp_path / "arm.toml"
    assert main(["convert", str(file), "-o", str(scene)]) == 0
    converted_scene = load_scene(scene)
    upper, lower = converted_scene.chain.links
    assert converted_scene.name == "two_links"
    assert (upper.length, upper.mass, upper.center_of_mass, upper.inertia) == (0.2, 0.5, 0.1, 0.003)
    assert (lower.length, lower.mass, lower.center_of_mass, lower.inertia) == (0.15, 0.25, 0.05, 0.001)
    assert (upper.joint_torque_limit, lower.joint_damping, lower.joint_friction) == (7.0, 0.01, 0.02)
    hanging = -0.5 * np.pi
    assert (upper.joint_min, upper.joint_max) == pytest.approx((hanging - 1.0, hanging + 2.0))
    assert converted_scene.initial.angles == pytest.approx((hanging, hanging))
    assert converted_scene.initial.position == (0.0, 1.0)
    assert converted_scene.inputs.joint_torques
    output = capsys.readouterr().out
    for line in (
        "plane: x of the scene is (0 1 0) of the robot, y is (0 0 1)",
        "shapes 1 mesh: touch nothing in the file, and are not in the scene",
        "joint shoulder: limit of the velocity, 20 rad/s: is not in the scene",
        "element transmission drive: is not in the scene",
        "body base: no motion, so no effect of the mass",
    ):
        assert line in output
        assert f"{line}\n" in scene.read_text(encoding="utf-8")


def test_an_mjcf_of_others_becomes_a_scene_without_its_meshes(tmp_path):
    scene, result = scene_of_robot(written(tmp_path, "hopper.xml", MJCF))
    thigh, leg = scene.chain.links
    assert scene.chain.base == "free"
    assert (thigh.length, leg.length) == (0.4, 0.5)
    assert scene.initial.position == (0.0, 1.25)
    assert scene.half_planes["floor"].clearance(0.0, 1.25) == pytest.approx(1.25)
    assert scene.contact.wall["floor"].friction == 1.0  # the larger friction of the two shapes
    assert (leg.joint_armature, leg.joint_stiffness, leg.joint_torque_limit) == (0.1, 4.0, 20.0)
    assert leg.joint_rest_angle == pytest.approx(np.radians(20.0))
    assert (leg.joint_min, leg.joint_max) == pytest.approx((0.0, np.radians(150.0)), abs=1e-12)
    assert scene.inputs.joint_torques
    assert result.warnings[0] == (
        "body leg: without the mass of mesh shin, of which the file not_there.obj cannot be read"
    )
    assert "1 sensor: not in the scene" in result.left_out
    assert thigh.mass == pytest.approx(1000.0 * (np.pi * 0.05**2 * 0.4 + 4.0 / 3.0 * np.pi * 0.05**3))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("x.urdf", "<robot", "is no XML"),
        ("x.xml", "<sdf/>", "its root element is 'sdf', must be 'robot' (URDF) or 'mujoco' (MJCF)"),
        ("x.xml", "<mujoco><nothing/></mujoco>", "MuJoCo cannot read it"),
        (
            "x.urdf",
            '<robot name="r"><link name="a"/><link name="b"/></robot>',
            "must have exactly one root link",
        ),
    ],
)
def test_a_file_that_is_no_robot_is_refused_in_one_line(tmp_path, name, text, message):
    with pytest.raises(SceneError) as caught:
        scene_of_robot(written(tmp_path, name, text))
    assert message in str(caught.value)


def test_the_command_refuses_other_suffixes_and_joints_of_a_scene(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["convert", "pinned_arm", "-o", str(tmp_path / "x.csv")])
    assert "must end in .toml, .xml" in capsys.readouterr().err
    assert main(["convert", "pinned_arm", "--joints", "a", "-o", str(tmp_path / "x.xml")]) == 2
    assert "a scene has nothing to choose" in capsys.readouterr().err
    assert main(["convert", "pinned_arm", "-o", str(tmp_path / "x.xml")]) == 0
    assert "left out contact.model = zhang_sharf" in capsys.readouterr().out


def test_the_conversion_of_a_scene_into_a_scene_is_refused(tmp_path):
    pattern = r"^pinned_arm is a scene; its MJCF is written to a file that ends in \.xml$"
    with pytest.raises(SceneError, match=pattern):
        convert("pinned_arm", tmp_path / "arm.toml")


@pytest.mark.parametrize(("attribute", "name"), [("", "arm"), ('model=""', "arm"), ('model="two"', "two")])
def test_a_robot_without_a_name_has_the_name_of_its_file(tmp_path, attribute, name):
    body = '<body><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .4 0 0" size=".02"/></body>'
    file = tmp_path / "arm.xml"
    file.write_text(f"<mujoco {attribute}><worldbody>{body}</worldbody></mujoco>", encoding="utf-8")
    assert scene_of_robot(file)[0].name == name


def test_what_mujoco_warns_of_is_a_note_and_no_file_is_written(work_folder, capfd):
    shape = '<geom type="capsule" fromto="0 0 0 .4 0 0" size=".02"/>'
    link = f'<body name="{{0}}"><joint name="{{0}}" axis="0 1 0"/>{shape}'
    child = f'<mujoco><option timestep=".005"/><worldbody>{link.format("shin")}</body></worldbody></mujoco>'
    attached = '<frame pos=".4 0 0"><attach model="leg" body="shin" prefix="leg_"/></frame>'
    (work_folder / "leg.xml").write_text(child, encoding="utf-8")
    (work_folder / "robot.xml").write_text(
        '<mujoco><asset><model name="leg" file="leg.xml"/></asset><worldbody>'
        f"{link.format('thigh')}{attached}</body></worldbody></mujoco>",
        encoding="utf-8",
    )
    assert main(["convert", "robot.xml", "-o", "robot.toml"]) == 0
    output, error_output = capfd.readouterr()
    (line,) = [line for line in output.splitlines() if "Attach conflict" in line]
    assert line.startswith("note     MuJoCo warns: ")
    assert "timestep: parent has 0.002 (default), child has 0.005" in line
    assert "Attach conflict" not in error_output
    assert sorted(path.name for path in work_folder.iterdir()) == ["leg.xml", "robot.toml", "robot.xml"]

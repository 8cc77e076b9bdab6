"""Slides of robot files become the slider of a scene, or are refused with a proposal."""

# Tests: conversion/joints.py, conversion/proposals.py

import math

import pytest

from tests.conversion.robot_files import arm, drives, free, joint, key, link, read, refused, urdf
from tests.tiers import needs_interop

pytestmark = needs_interop


def cart(axis="1 0 0", attributes="", **parts):
    rail = f'<joint name="rail" type="slide" axis="{axis}" {attributes}/><joint name="a"'
    return arm(**parts).replace('<joint name="a"', rail)


def test_a_slide_out_of_plane_or_after_a_hinge_is_refused(tmp_path):
    assert "joint rail slides" in (message := refused(tmp_path, cart("0 1 0")))
    assert "choose joints a,b: these" in message
    finger = '<body pos=".3 0 0"><joint name="finger" type="slide" axis="1 0 0"/><geom size=".02"/></body>'
    text = arm().replace('<site name="tip" pos=".3 0 0"/>', f'<site name="tip" pos=".3 0 0"/>{finger}')
    assert "joint finger slides" in (message := refused(tmp_path, text))
    assert "choose joints a,b: these" in message


def test_joints_about_several_axes_give_a_proposal_of_a_slide_and_hinges(tmp_path):
    text = cart().replace('<joint name="b" axis="0 1 0"', '<joint name="b" axis="0 0 1"')
    assert "choose joints rail,a:" in refused(tmp_path, text)


def test_a_slide_is_a_slider_with_what_its_joint_and_drives_have(tmp_path):
    text = cart(
        "-3 0 0",
        'ref=".2" range="-.4 .9" limited="true" stiffness="8" springref=".5" damping=".7" frictionloss=".3"',
        rest=drives('<position joint="rail" kp="40" kv="2" forcerange="-6 6"/>', '<motor joint="a"/>')
        + key(qpos=".3 .1 0", qvel=".5 0 0", ctrl=".6 0"),
        b='ref="20"',
    )
    scene, result = read(tmp_path, text)
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
    assert "joint rail: limits are soft in MuJoCo; a scene has its own, in [contact]" in result.differs
    motor, _ = read(tmp_path, cart(rest=drives('<motor joint="rail" gear="10" ctrlrange="-1 1"/>')))
    assert motor.inputs.slider_force
    assert motor.chain.slider.force_limit == 10.0


def test_remarks_on_joints_of_a_free_base_name_no_table_of_the_scene(tmp_path):
    """A scene with a free base has no slider and no joint 1, so that limits of these joints have no place."""
    soft = 'range="-9 9" limited="true" frictionloss=".2"'
    scene, result = read(tmp_path, free(x=soft, z=soft, turn=soft))
    assert scene.chain.base == "free"
    assert not [line for line in result.differs if line.startswith("joint")]
    assert {line.partition(":")[0] for line in result.warnings} == {"joints x, z", "joint turn"}
    assert all("friction 0.2" in line for line in result.warnings)


def test_a_slide_that_starts_beyond_its_limit_starts_there(tmp_path):
    scene, result = read(tmp_path, cart(attributes='range=".1 .9" limited="true"'))
    assert scene.initial.position == pytest.approx((0.1, 1.5))
    assert (scene.chain.slider.min, scene.chain.slider.max) == pytest.approx((0.0, 0.8))
    assert "joint rail: starts at its stop; in the file it starts 0.1 m beyond this stop" in result.warnings


def test_the_armature_of_a_slide_that_rises_is_told_as_a_weight(tmp_path):
    scene, result = read(tmp_path, cart("0 0 1", 'armature=".5"'))
    assert scene.chain.slider.mass == 0.5
    message = "joint rail: its armature, 0.5 kg, is part of the mass of the carriage, which has weight"
    assert message in result.warnings
    assert message in read(tmp_path, cart("1 0 0", 'armature=".5"'))[1].differs


def test_equal_limits_of_a_slide_are_refused_with_its_unit(tmp_path):
    parts = [link("u"), link("l"), joint("b", "u", "l", ".3 0 0")]
    parts.append(
        joint(
            "s",
            "base",
            "u",
            kind="prismatic",
            axis="1 0 0",
            content='<limit lower="0" upper="0" effort="1"/>',
        )
    )
    assert "joint s: its limits are equal, 0 m, so it cannot move" in refused(tmp_path, urdf(*parts))

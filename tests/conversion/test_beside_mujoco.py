"""Robots from files move as in MuJoCo for 0.5 s, or the first warning names the cause of the difference."""

# Tests: conversion/mjcf.py, conversion/planar.py, conversion/urdf.py

import pytest

from benchmarks.robots import ANGLE_TOLERANCE, compared
from chain_impact.conversion.planar import ConversionChoices
from tests.conversion.robot_files import TWO, arm, cart, drives, free, joint, key, link, urdf
from tests.tiers import needs_interop

pytestmark = needs_interop

SAME = {
    "plain": arm(),
    "springs": arm(a='stiffness="8" springref="50" damping=".3"', b='armature=".05" stiffness="2"'),
    "ref": arm(a='ref="30" stiffness="5" springref="10"', b='ref="-20" range="-90 90" limited="true"'),
    "other sign": arm(b='ref="10" stiffness="4" springref="40"').replace(
        'name="b" axis="0 1 0"', 'name="b" axis="0 -1 0"'
    ),
    "turned bodies": arm(upper='euler="0 30 0"', lower='euler="0 -70 0"'),
    "gravity aside": arm(option='gravity="3 0 -9"'),
    "no gravity": arm(flags='<flag gravity="disable"/>', a='stiffness="3"'),
    "no springs": arm(flags='<flag spring="disable"/>', a='stiffness="30" damping="1"'),
    "no dampers": arm(flags='<flag damper="disable"/>', a='stiffness="3" damping="10"'),
    "no actuators": arm(flags='<flag actuation="disable"/>', rest=drives('<position joint="a" kp="50"/>')),
    "a group of actuators off": arm(
        option='actuatorgroupdisable="2"',
        rest=drives('<position joint="a" kp="50" group="2"/>', '<position joint="b" kp="5"/>'),
    ),
    "all borne": arm(upper='gravcomp="1"', lower='gravcomp="1"', a='stiffness="3"'),
    "half borne": arm(upper='gravcomp=".5"', lower='gravcomp=".5"'),
    "borne without passive forces": arm(
        upper='gravcomp="1"', flags='<flag spring="disable" damper="disable"/>', a='damping="1"'
    ),
    "servo": arm(a='ref="30"', rest=drives('<position joint="a" kp="40" kv="2"/>')),
    "servo and key": arm(
        rest=drives('<position joint="a" kp="40" kv="2" ctrlrange="-1 .5" ctrllimited="true"/>')
        + key(qpos=".3 -.4", qvel="0 0", ctrl="2")
    ),
    "geared servo": arm(rest=drives('<position joint="b" kp="7" kv=".1" gear="-3"/>') + key(ctrl="2")),
    "two servos": arm(
        rest=drives('<position joint="a" kp="40"/>', '<position joint="a" kp="20" kv="1"/>')
        + key(ctrl="1 -1")
    ),
    "servo and spring": arm(
        a='stiffness="10" springref="60" ref="20"', rest=drives('<position joint="a" kp="15"/>')
    ),
    "velocity servo": arm(rest=drives('<velocity joint="b" kv="2"/>')),
    "general servo": arm(
        rest=drives(
            '<general joint="a" gainprm="5" biastype="affine" biasprm="2 -20 -1" gear="2"/>',
        )
        + key(ctrl="1.5")
    ),
    "motors": arm(rest=drives('<motor joint="a" ctrlrange="-5 5"/>', '<motor joint="b" gear="30"/>')),
    "rotor in the actuator": arm(rest=drives('<motor joint="a" gear="10" armature="1e-3" damping="2e-3"/>')),
    "welded bodies": arm(
        more='<body pos=".1 0 0"><geom type="sphere" size=".05" pos=".05 0 0" mass="3"/></body>'
    ),
    "depth": arm(lower='euler="0 0 0"').replace('pos=".4 0 0"', 'pos=".4 .25 0"'),
    "free": free(),
    "free and thrown": free(rest=key(qpos=".1 .2 .3 -.5", qvel="1 2 3 -4")),
    "centre behind": arm(more='<geom type="sphere" size=".05" pos="-.6 0 0" mass="3"/>'),
    "centres aside": arm(
        more='<geom type="sphere" size=".05" pos=".2 0 .1" mass="1"/>', lower='euler="0 20 0"'
    ),
    "centre aside of a joint that counts the other way": arm(
        more='<geom type="sphere" size=".05" pos=".2 0 -.1" mass="1"/>'
    ).replace('name="b" axis="0 1 0"', 'name="b" axis="0 -1 0"'),
    "centre aside of a free base": free(rest=key(qpos=".1 .2 .3 -.5", qvel="1 2 3 -4")).replace(
        '<body name="leg"', '<geom type="sphere" size=".05" pos=".2 0 -.1" mass="1"/><body name="leg"'
    ),
    "cart": cart(),
    "cart with all that a slide has": cart(
        x='ref=".2" damping=".5" stiffness="30" springref=".7" axis="-2 0 0"',
        rest=drives('<position joint="x" kp="20" kv="1"/>', '<motor joint="a"/>') + key(ctrl=".3 0"),
    ),
    "cart on a slope": cart(x='axis="1 0 -.5" damping=".2"', rest=key(qpos=".4 .3 -1", qvel="1 2 3")),
    "cart that gravity does not move": cart(box='gravcomp="1"', upper='gravcomp="1"', lower='gravcomp="1"'),
    "slide and hinge of one body": arm().replace(
        '<joint name="a"', '<joint name="rail" type="slide" axis="1 0 0" armature=".5"/><joint name="a"'
    ),
    "urdf of a cart": urdf(
        link("cart", mass=2),
        *TWO[:3],
        joint("rail", "base", "cart", kind="prismatic", axis="0 0 -1"),
        joint("a", "cart", "upper"),
        *TWO[4:],
    ),
    "urdf": urdf(*TWO),
    "urdf with the centre aside": urdf(
        link("upper", ".15 0 .04"),
        link("lower", ".1 0 0"),
        joint("a", "base", "upper"),
        joint("b", "upper", "lower", ".3 0 0"),
    ),
    "urdf of other axes": urdf(
        link("upper", "0 .15 0"),
        link("lower", "0 .1 0"),
        joint("a", "base", "upper", "0 0 1", axis="-1 0 0"),
        joint("b", "upper", "lower", "0 .3 0", axis="1 0 0", content='<dynamics damping=".2"/>'),
    ),
    "urdf with a namespace": urdf(*TWO, attributes='xmlns="http://example.org/robot"'),
    "urdf with prefixes that are not declared": urdf(*TWO, "<drake:group name='g'/>"),
}
"""Name → a file whose robot moves as in MuJoCo."""

DIFFERENT = {
    "some borne": (arm(upper='gravcomp="1"'), "body upper: gravcomp bears 1 of its weight"),
    "springs that are not linear": (arm(a='stiffness="3 2 0"'), "joint a: its spring is not linear"),
    "dampers that are not linear": (arm(b='damping="1 2 0"'), "joint b: its damping is not linear"),
    "yielding": (arm(a='stiffness="30" springyield="2"'), "joint a: its spring yields"),
    "air": (arm(option='density="1000"'), "option density: the robot moves in a fluid"),
    "tendon": (
        arm(
            rest='<tendon><fixed name="t" stiffness="20"><joint joint="a" coef="1"/>'
            '<joint joint="b" coef="1"/></fixed></tendon>'
        ),
        "tendon t: stiffness: is not in the scene",
    ),
    "coupled": (
        arm(rest='<equality><joint name="e" joint1="a" joint2="b"/></equality>'),
        "equality e: joint: is not in the scene",
    ),
    "damper as an actuator": (
        arm(rest=drives('<damper name="d" joint="a" kv="3" ctrlrange="0 1"/>') + key(ctrl="1")),
        "actuator d: is neither a motor nor a servo",
    ),
    "motor that is on": (
        arm(rest=drives('<motor name="m" joint="a"/>') + key(ctrl="3")),
        "joint a: its drives act with 3 at the start",
    ),
    "filter": (
        arm(rest=drives('<general name="f" joint="b" dyntype="filter" dynprm=".1"/>') + key(ctrl="2")),
        "actuator f: has an activation (filter)",
    ),
    "site": (
        arm(rest=drives('<motor name="thrust" site="tip" gear="0 0 1 0 0 0"/>') + key(ctrl="5")),
        "actuator thrust: acts on no joint, but on a site",
    ),
    "one-sided": (
        arm(rest=drives('<motor joint="a" ctrlrange="0 10"/>')),
        "joint a: its drives act with 0 to 10; a limit of a scene is equal in both directions",
    ),
    "slides": (
        free(
            x='damping="5" stiffness="10" armature=".5"',
            z='frictionloss="3" range="-.1 .1" limited="true"',
            rest=drives('<motor name="push" joint="x"/>', '<position name="lift" joint="z" kp="100"/>'),
        ),
        "joint x: damping 5, stiffness 10, armature 0.5: the base of the scene is free",
    ),
    "start beyond a stop, with a drive that also limits the damper": (
        arm(
            a='damping="9" actuatorfrcrange="-5 5"',
            b='range="-60 -10" limited="true"',
            rest=drives('<motor joint="a"/>'),
        ),
        "joint b: starts at its stop",
    ),
    "air, and tendons that move nothing or have a motor": (
        arm(
            option='density="1000"',
            more='<body name="fin"><joint name="c" axis="0 0 1"/><geom size=".05" mass=".1"/></body>',
            rest='<tendon><fixed name="t"><joint joint="c" coef="1"/></fixed>'
            '<fixed name="u"><joint joint="b" coef="1"/></fixed></tendon>'
            + drives('<position name="flap" tendon="t" kp="9"/>', '<motor name="pull" tendon="u"/>'),
        ),
        "option density: the robot moves in a fluid",
    ),
    "rotor of a cart on a slope": (cart(x='armature=".4"'), "joint x: its armature, 0.4 kg, is part of"),
    "held trunk": (free(turn='stiffness="3"'), "joint turn: stiffness 3: the base of the scene is free"),
    "urdf with mimic": (
        urdf(*TWO[:-1], joint("end", "lower", "tool", kind="fixed")).replace(
            'link="lower"/>\n    <origin xyz=".3 0 0"/><axis xyz="0 1 0"/>',
            'link="lower"/><origin xyz=".3 0 0"/><axis xyz="0 1 0"/><mimic joint="a"/>',
        ),
        "joint b: mimic joint a: it follows another joint in the file",
    ),
}
"""Name → a file whose robot moves differently, and the beginning of its first warning."""


def beside(tmp_path, text, **choices):
    file = tmp_path / ("robot.xml" if "<mujoco" in text else "robot.urdf")
    file.write_text(text, encoding="utf-8")
    return compared(file, ConversionChoices(**choices))


@pytest.mark.parametrize("name", SAME)
def test_a_robot_moves_as_in_mujoco(tmp_path, name):
    comparison = beside(tmp_path, SAME[name])
    assert comparison.difference is not None, comparison.cause
    assert comparison.difference <= ANGLE_TOLERANCE


@pytest.mark.parametrize("name", DIFFERENT)
def test_the_first_difference_of_motion_is_reported(tmp_path, name):
    text, beginning = DIFFERENT[name]
    choices = {"joints": ["a", "b"]} if 'name="c"' in text else {}
    assert beside(tmp_path, text, **choices).cause.startswith(beginning)


def test_with_held_joints_and_another_keyframe_it_moves_alike(tmp_path):
    text = arm(rest="<keyframe><key name='k' qpos='.3 .9'/><key name='l' qpos='1 -.4'/></keyframe>")
    for joints in (["a"], ["b"]):
        assert beside(tmp_path, text, joints=joints, keyframe="l").difference <= ANGLE_TOLERANCE
    assert beside(tmp_path, text, keyframe="none").difference <= ANGLE_TOLERANCE

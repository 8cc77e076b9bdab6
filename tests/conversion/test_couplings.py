"""What couples joints and bodies is reported where it can move the chain, and only there."""

# Tests: conversion/mjcf_couplings.py, conversion/mjcf_drives.py

import pytest

from tests.conversion.robot_files import arm, cart, drives, key, read
from tests.tiers import needs_interop

pytestmark = needs_interop

CABLE = """<tendon>
  <spatial name="t"><site site="root"/><geom geom="ball"/><site site="root"/></spatial>
  <spatial name="u" stiffness="5"><site site="root"/><site site="mid"/></spatial>
</tendon>"""


def warnings_of(result, begin):
    """Return the warnings that begin with a text."""
    return [line for line in result.warnings if line.startswith(begin)]


@pytest.mark.parametrize(
    ("drive", "moved_joints"),
    [
        ('<position name="d" tendon="t" kp="5"/>', "ab"),
        ('<position name="d" tendon="u" kp="5"/>', "a"),
        ('<motor name="d" site="tip"/>', "ab"),
        ('<motor name="d" site="mid"/>', "a"),
        ('<motor name="d" site="tip" refsite="mid"/>', "b"),
    ],
)
def test_an_actuator_without_a_joint_is_told_where_it_moves_the_chain(tmp_path, drive, moved_joints):
    sites = {"world": '<site name="root" pos="0 0 .5"/>', "more": '<site name="mid" pos=".2 0 0"/>'}
    text = arm(**sites, rest=CABLE + drives(drive))
    text = text.replace('<site name="tip"', '<geom name="ball" size=".05" mass="0"/><site name="tip"')
    for name in "ab":
        _, result = read(tmp_path, text, joints=[name])
        assert len(warnings_of(result, "actuator d: acts on no joint")) == (name in moved_joints)
        assert len(warnings_of(result, "tendon u: stiffness")) == (name == "a")


@pytest.mark.parametrize("flag", ["limit", "constraint", "spring"])
def test_a_limited_tendon_is_told_unless_limits_or_constraints_are_off(tmp_path, flag):
    limited = CABLE.replace('stiffness="5"', 'range="0 1"')
    option = f'<option><flag {flag}="disable"/></option>'
    text = arm(
        world='<site name="root" pos="0 0 .5"/>',
        more='<site name="mid" pos=".2 0 0"/>',
        rest=limited + option,
    )
    text = text.replace('<site name="tip"', '<geom name="ball" size=".05" mass="0"/><site name="tip"')
    _, result = read(tmp_path, text)
    assert len(warnings_of(result, "tendon u: limited")) == (flag == "spring")


def test_a_weld_of_a_carriage_to_the_world_is_told(tmp_path):
    text = cart(rest='<equality><weld name="w" body1="box"/></equality>')
    for joints in (["x", "a", "b"], ["a", "b"]):
        _, result = read(tmp_path, text, joints=joints)
        assert len(warnings_of(result, "equality w: weld")) == ("x" in joints)


@pytest.mark.parametrize(
    ("control", "first"), [("0", "joint b: its spring is not linear"), ("1", "actuator f: has an activation")]
)
def test_a_drive_at_rest_is_told_after_what_acts_at_once(tmp_path, control, first):
    filtered = '<general name="f" joint="a" dyntype="filter" dynprm=".1" ctrlrange="-2 2"/>'
    _, result = read(tmp_path, arm(b='stiffness="3 2 0"', rest=drives(filtered) + key(ctrl=control)))
    assert result.warnings[0].startswith(first)

"""Every field of a compiled MuJoCo model is converted, reported, or known to have no effect."""

# Tests: conversion/differences.py

import mujoco
import numpy as np
import pytest

from chain_impact.conversion import mjcf_fields
from chain_impact.conversion.differences import SceneAspect, difference_lines
from chain_impact.conversion.mjcf_fields import (
    DISABLED,
    FIELD_REMARKS,
    IGNORED_FLAGS,
    USED_FIELDS,
    fields_of_model,
    treatments,
    unsupported_fields,
)
from tests.tiers import needs_interop

pytestmark = needs_interop

RICH = """
<mujoco>
  <option gravity="0 0 -9.81" density="0" timestep="0.01"/>
  <custom><numeric name="n" data="1 2"/><text name="t" data="words"/></custom>
  <asset>
    <texture name="grey" builtin="flat" type="2d" width="8" height="8"/><material name="grey" texture="grey"/>
  </asset>
  <worldbody>
    <light pos="0 0 3"/><camera name="eye" pos="0 -2 1"/>
    <geom name="floor" type="plane" size="3 3 1"/>
    <body name="upper" pos="0 0 2">
      <joint name="a" axis="0 1 0" damping=".1" stiffness="2" range="-90 90" limited="true" user="3"/>
      <geom name="rod" type="capsule" fromto="0 0 0 .4 0 0" size=".03" material="grey"/>
      <body name="lower" pos=".4 0 0">
        <joint name="b" axis="0 1 0" armature=".01"/>
        <geom name="stick" type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
        <site name="tip" pos=".3 0 0"/>
      </body>
    </body>
  </worldbody>
  <contact><pair geom1="floor" geom2="stick"/></contact>
  <tendon><fixed name="both"><joint joint="a" coef="1"/><joint joint="b" coef="1"/></fixed></tendon>
  <actuator><motor name="push" joint="a" ctrlrange="-1 1" ctrllimited="true"/></actuator>
  <sensor><jointpos joint="a"/></sensor>
  <keyframe><key name="k" qpos=".2 .3" qvel="1 -1"/></keyframe>
</mujoco>
"""


def rich():
    return mujoco.MjModel.from_xml_string(RICH)


def acceleration(model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return data.qacc_smooth.copy()


def test_a_field_of_a_new_mujoco_has_yet_to_be_decided_on():
    """On failure, decide for each new field: converted, reported, or without effect on a scene."""
    field_fates = {field: treatments(field) for field, _ in fields_of_model(rich())}
    assert [field for field, fate in field_fates.items() if not fate] == []
    assert [field for field, fate in field_fates.items() if {"used", "remarked"} <= set(fate)] == []


def test_the_table_has_no_field_that_mujoco_does_not_have():
    field_names = {field for field, _ in fields_of_model(rich())}
    assert [
        name
        for name in [*USED_FIELDS.split(), *(row.field for row in FIELD_REMARKS)]
        if name not in field_names
    ] == []


def test_each_flag_of_mujoco_is_honoured_or_has_no_effect():
    bits = [*mujoco.mjtDisableBit.__members__, *mujoco.mjtEnableBit.__members__]
    names = {bit.partition("_")[2] for bit in bits if "_" in bit}
    assert names == {*DISABLED, *IGNORED_FLAGS.split()}


@pytest.mark.parametrize("row", FIELD_REMARKS, ids=lambda row: row.field)
def test_reported_fields_are_reported_where_they_are_not_at_their_default(row):
    model = rich()
    changes_motion = row.effect in (SceneAspect.MOTION, SceneAspect.LATER_MOTION)
    title = "warning" if changes_motion else "differs" if row.differs else "left out"
    lines = difference_lines(unsupported_fields(model), title)
    if row.field == "key_plastic":
        assert model.nplastic == 0  # number of plastic springs, which are reported separately
        return
    holder = model.opt if row.kind == "option" else model
    name = row.field.removeprefix("opt.")
    value = np.asarray(getattr(holder, name))
    if value.ndim:
        value.flat[-1] = row.default + 1
    else:
        setattr(holder, name, row.default + 1)
    changed_lines = difference_lines(unsupported_fields(model), title)
    (line,) = set(changed_lines) - set(lines)
    assert row.text in line


def test_a_field_that_the_table_does_not_have_is_told_if_it_is_not_zero(monkeypatch):
    monkeypatch.setattr(mjcf_fields, "USED_FIELDS", USED_FIELDS.replace("body_mass", ""))
    lines = difference_lines(unsupported_fields(rich()), "warning")
    assert [line for line in lines if "body_mass" in line and "not known to this version" in line]


def test_fields_without_effect_change_no_acceleration_in_flight():
    model = rich()
    expected = acceleration(model)
    for field, value in fields_of_model(model):
        values = np.asarray(value)
        excluded = {"used", "remarked", "follow from other fields", "counts, addresses and names"}
        if (
            excluded & set(treatments(field))
            or values.dtype.kind != "f"
            or not values.ndim
            or not values.size
        ):
            continue
        original = values.copy()
        values += 0.01
        assert acceleration(model) == pytest.approx(expected, abs=1e-12), field
        values[...] = original

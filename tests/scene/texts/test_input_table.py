"""The table of inputs agrees with the tables of keys, variables and parameters."""

# Tests: scene/texts/parameter_hints.py

from dataclasses import fields

import pytest

from chain_impact.scene.keys.tables import Inputs
from chain_impact.scene.texts.input_table import (
    INPUT_KEYS,
    INPUT_KINDS,
    determined_quantities,
    exclusive_inputs,
    input_kind,
    is_motion,
    is_position,
    value_at_start,
    without_drive,
)
from chain_impact.variables.outputs import INPUTS
from chain_impact.variables.parameters import PARAMETERS


def test_each_key_and_each_variable_of_inputs_has_a_row():
    assert set(INPUT_KEYS) == {entry.name for entry in fields(Inputs)}
    variables = {kind.name: kind for block in INPUTS for kind in block.kinds}
    assert variables.keys() == INPUT_KINDS.keys()
    for name, row in INPUT_KINDS.items():
        assert (variables[name].unit, variables[name].when) == (row.unit, (f"inputs.{row.key}",))


def test_rows_name_inputs_and_parameters_that_exist():
    parameters = {kind.name for block in PARAMETERS for kind in block.kinds}
    for row in INPUT_KINDS.values():
        assert row.name in row.determined
        assert {*row.determined} - {"", *INPUT_KINDS} == set()
        assert row.parameter in {"", *parameters}
        assert all(INPUT_KINDS[name].exclusive == row.exclusive for name in row.exclusive)


@pytest.mark.parametrize(
    ("name", "determined", "exclusive"),
    [
        ("joint[3].torque", ("joint[3].torque",), ("joint[3].torque",)),
        ("slider.target_position", ("slider.target_position", "slider.target_velocity"), None),
        ("joint[12].target_velocity", ("joint[12].target_velocity",), None),
        ("base.vy", ("base.y", "base.vy", "base.ay"), ("base.y", "base.vy", "base.ay")),
        ("wall.ramp.belt_speed", ("", "wall.ramp.belt_speed"), None),
    ],
)
def test_a_signal_determines_integrals_and_derivatives(name, determined, exclusive):
    assert determined_quantities(name) == determined
    assert exclusive_inputs(name) == (exclusive or (name,))


def test_positions_are_motions_and_belts_are_not():
    motions = {name for name in ("base.x", "base.ax", "wall.a.velocity") if is_motion(name)}
    assert motions == {"base.x", "base.ax", "wall.a.velocity"}
    assert [is_motion(name) for name in ("wall.a.belt_speed", "tip.force.x", "base.z")] == [False] * 3
    names = ("base.y", "wall.a.displacement", "base.vy", "slider.target_position")
    assert [is_position(name) for name in names] == [True, True, False, False]


def test_an_input_that_nothing_drives_has_the_value_of_its_parameter():
    assert without_drive("joint[2].target_angle") == "link[2].joint_rest_angle"
    assert [without_drive(name) for name in ("base.vx", "joint[2].torque", "nothing")] == [None] * 3
    assert value_at_start({"initial.x": 2.0}, "base.x") == 2.0
    assert value_at_start({"initial.x": 2.0, "base.x": 3.0}, "base.x") == 3.0
    assert value_at_start({"initial.x": 2.0}, "base.vx") == 0.0
    assert input_kind("joint[2].torqe") is None

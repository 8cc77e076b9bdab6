"""Inputs over time in plain Python: their present values, their times, and the limit of a step."""

# Tests: kernel/record/input_fields.py

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.kernel.chain import inputs
from chain_impact.kernel.record.constants import INPUT_DEGREE
from chain_impact.kernel.record.input_fields import INPUT_SIZES
from chain_impact.kernel.record.state import time_at
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.kernel.plain import Plain


def driven(degree=2):
    """Return the arm with torques 1 + 2 x + 3 x² and 4 of a piece from 0 to 2 s, x = t − 1."""
    block = PreparedScene(load_scene("pinned_arm")).new_instance()
    given = block[0]["given"]
    given["motor"][:2] = 1.0, 4.0
    piece = given["piece"]
    piece["degree"], piece["middle"], piece["scale"], piece["end"] = degree, 1.0, 1.0, 2.0
    piece["motor"][1:3, 0] = 2.0, 3.0
    block[0]["step"]["regularized_candidate"] = -1
    d = Plain(block[0])
    inputs.apply_inputs(d)
    return d


@pytest.mark.parametrize(
    ("degree", "end", "regularized", "size", "expected"),
    [
        *((2, 1.0, -1, 0.1, 0.1), (2, 1.0, -1, 0.6, 0.5), (2, 1.0, -1, 1.0, 1.0)),
        *((2, 1.0, -1, 5.0, 1.0), (0, 1.0, -1, 5.0, 5.0)),
        (2, 1.0, 0, 5.0, 5.0),  # a regularized step, or a step at the end of its piece, is not cut
        (2, 2.0, -1, 5.0, 5.0),
    ],
)
def test_a_step_ends_with_the_piece_or_well_before(degree, end, regularized, size, expected):
    d = driven(degree)
    d.step.end, d.step.regularized_candidate = end, regularized
    assert inputs.limit_to_input_piece(d, size) == expected


def test_inputs_go_on_where_the_last_step_ends_with_the_piece():
    d = driven()
    d.step.communication_point, d.step.end, d.given.pending = 2.0, 2.0 + 1e-15, inputs.CONTINUES
    assert inputs.inputs_continue(d)
    d.step.end = 2.1
    assert not inputs.inputs_continue(d)
    d.step.end, d.given.pending = 2.0, inputs.REINITIALIZE
    assert not inputs.inputs_continue(d)


def test_a_state_sees_the_inputs_at_its_time():
    """The time in a state counts from the time origin; constant inputs stay as they are."""
    d = driven()
    y = d.step.state.copy()
    d.step.time_origin, y[time_at(d.link_count)] = 1.25, 0.5
    inputs.ensure_inputs(d, y)
    assert list(d.inputs.motor[:2]) == [1.0 + 2.0 * 0.75 + 3.0 * 0.75**2, 4.0]
    d = driven(degree=0)
    d.inputs.motor[0] = 77.0
    inputs.ensure_inputs(d, y)
    assert d.inputs.motor[0] == 77.0


CART = {
    "chain.base": "slider",
    "inputs.joint_torques": True,
    "inputs.joint_targets": True,
    "inputs.slider_force": True,
    "inputs.tip_force": True,
}


def cart():
    """Return a cart with all inputs that act on a chain."""
    return Plain(PreparedScene(load_scene("pinned_arm").with_values(CART)).new_instance()[0])


@pytest.mark.parametrize("degree", [0, 1, INPUT_DEGREE])
def test_given_inputs_are_used_as_polynomials(degree):
    d, rng = cart(), np.random.default_rng(degree)
    own, given = d.given.piece, d.given
    own.degree, own.middle, own.scale, own.end, own.change_rate = degree, 0.4, 2.0, 3.0, 7.0
    for name in INPUT_SIZES:
        own[name][:], given[name][:] = rng.normal(size=own[name].shape), rng.normal(size=given[name].shape)
    inputs.apply_inputs(d)
    for name in INPUT_SIZES:
        np.testing.assert_array_equal(d.inputs[name], given[name])
    assert (d.inputs.piece.end, d.inputs.piece.change_rate) == (3.0, 7.0)
    inputs.set_inputs(d, 1.1)
    for name in INPUT_SIZES:
        powers = np.vstack([given[name], own[name][1 : degree + 1]])
        expected = np.polynomial.polynomial.polyval((1.1 - 0.4) * 2.0, powers)
        np.testing.assert_allclose(d.inputs[name], expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", [*INPUT_SIZES, "drive_damping", "drive_stiffness"])
def test_inputs_are_not_in_use_if_one_differs(name):
    d = cart()
    inputs.apply_inputs(d)
    for k in range(len(d.given[name])):
        assert inputs.are_inputs_in_use(d)
        used = d.given[name][k]
        d.given[name][k] += 1.0
        assert not inputs.are_inputs_in_use(d)
        d.given[name][k] = used


def test_polynomials_do_not_count_as_inputs_in_use():
    assert not inputs.are_inputs_in_use(driven())

"""The course of the inputs, in plain Python: what holds, at what time, and how far a step may go."""

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.kernel.model.inputs import (
    AT_ONCE,
    DEGREE,
    GOING_ON,
    goes_on,
    polynomial,
    set_inputs,
    take_inputs,
    within_piece,
)
from chain_impact.variables.model import new_instance
from tests.plain import Plain


def driven(order=2):
    """The arm with torques 1 + 2 x + 3 x² and 4 of a piece from 0 to 2 s, x = t − 1."""
    block = new_instance(load_scene("pinned_arm"))
    given = block[0]["given"]
    given["joint_torque"] = 1.0, 4.0
    course = given["course"]
    course["order"], course["middle"], course["scale"], course["until"] = order, 1.0, 1.0, 2.0
    course["joint_torque"][1:3, 0] = 2.0, 3.0
    block[0]["step"]["regularized"] = -1
    d = Plain(block[0])
    take_inputs(d)
    return d


def test_a_polynomial_is_that_of_its_coefficients():
    powers = np.random.default_rng(0).normal(size=(DEGREE + 1, 2))
    for order in range(DEGREE + 1):
        expected = np.polynomial.polynomial.polyval(0.7, powers[: order + 1, 1])
        assert polynomial(powers, order, 1, 0.7) == pytest.approx(expected, rel=1e-14)


def test_the_inputs_are_those_of_a_time():
    d = driven()
    set_inputs(d, 1.5)
    assert list(d.inputs.joint_torque) == [1.0 + 2.0 * 0.5 + 3.0 * 0.25, 4.0]
    assert list(driven(order=0).inputs.joint_torque) == [1.0, 4.0]


@pytest.mark.parametrize(("size", "expected"), [(0.1, 0.1), (0.6, 0.5), (1.0, 1.0), (5.0, 1.0)])
def test_a_step_ends_with_the_piece_or_well_before(size, expected):
    d = driven()
    d.step.end = 1.0
    assert within_piece(d, size) == expected
    assert within_piece(driven(order=0), size) == size


def test_inputs_go_on_where_the_last_step_ends_with_the_piece():
    d = driven()
    d.step.time, d.step.end, d.given.changed = 2.0, 2.0 + 1e-15, GOING_ON
    assert goes_on(d)
    d.step.end = 2.1
    assert not goes_on(d)
    d.step.end, d.given.changed = 2.0, AT_ONCE
    assert not goes_on(d)

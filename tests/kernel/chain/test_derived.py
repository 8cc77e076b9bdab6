"""Derived parameters without a given value: in plain Python, with dual numbers, and at initialization."""

# Tests: kernel/chain/inertia.py, kernel/initialize.py

import numpy as np
import pytest

from chain_impact.kernel.chain.inertia import (
    corner_of_box,
    given_or_derived,
    inertia_of_box,
    middle_of_rod,
)
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.record.constants import NOT_GIVEN
from chain_impact.kernel.status import OK
from tests.kernel.chains import chain, stopped_chain
from tests.kernel.tangent.dual import Dual


def test_a_given_value_is_in_use_and_else_the_derived_one():
    """The derived value has the derivatives of its source, and the given value its own derivative."""
    for given, expected in ((0.0, 0.0), (0.3, 0.3), (NOT_GIVEN, 0.1)):
        assert given_or_derived(given, 0.1) == expected
    given, derived = Dual(NOT_GIVEN, [1.0, 0.0]), Dual(0.25, [0.0, 0.5])
    result = given_or_derived(given, derived)
    assert (result.value, result.slope.tolist()) == (0.25, [1.0, 0.5])
    given = Dual(0.3, [1.0, 0.0])
    assert given_or_derived(given, derived) is given


def test_the_rod_is_uniform():
    """Its inertia is the integral of (x − L/2)² over its mass."""
    length, mass = 0.7, 1.3
    x, weights = np.polynomial.legendre.leggauss(4)
    places = 0.5 * length * (1.0 + x)
    assert middle_of_rod(length) == pytest.approx(weights @ places / 2.0, rel=1e-14)
    about = weights @ (places - middle_of_rod(length)) ** 2 / 2.0
    assert inertia_of_box(mass, length, 0.0) == pytest.approx(mass * about, rel=1e-14)


def test_the_box_is_a_uniform_rectangle_with_four_corners():
    """Its inertia is the integral of the square of the distance from the middle over its mass."""
    length, height, mass = 0.7, 0.3, 1.3
    x, weights = np.polynomial.legendre.leggauss(4)
    along, across = np.meshgrid(0.5 * length * x, 0.5 * height * x)
    about = (np.outer(weights, weights) * (along**2 + across**2)).sum() / 4.0
    assert inertia_of_box(mass, length, height) == pytest.approx(mass * about, rel=1e-14)
    corners = [corner_of_box(number, length, height) for number in (1, 2, 3, 4)]
    assert corners == [(0.0, -0.15), (0.7, -0.15), (0.0, 0.15), (0.7, 0.15)]


def test_each_start_derives_anew_what_is_not_given():
    _, d = chain(np.random.default_rng(0), 2)
    given = [d.chain.center_of_mass[1], d.chain.inertia[1]]
    d.chain.given_center_of_mass[0] = d.chain.given_inertia[0] = NOT_GIVEN
    for length, mass in ((0.8, 2.0), (1.7, 0.3)):
        d.chain.length[:], d.chain.mass[:] = length, mass
        assert initialize(d, 0.0) == OK
        assert d.chain.center_of_mass[0] == length / 2
        assert d.chain.inertia[0] == mass * length * length / 12
        assert [d.chain.center_of_mass[1], d.chain.inertia[1]] == given


def test_stops_follow_the_walls_where_nothing_else_is_given():
    _, d = stopped_chain(2)
    d.stops.given_exponent = d.given.stop_restitution = NOT_GIVEN
    d.contact_settings.exponent, d.given.restitution = 1.3, 0.35
    assert initialize(d, 0.0) == OK
    own = np.flatnonzero(d.candidate.stop)
    assert (d.law.restitution[own] == 0.35).all()
    assert (d.law.exponent[own] == 1.3).all()
    assert (d.stops.exponent, d.stops.restitution) == (1.3, 0.35)
    d.given.stop_restitution, d.stops.given_exponent = 0.9, 1.1
    assert initialize(d, 0.0) == OK
    assert (d.law.restitution[own] == 0.9).all()
    assert (d.stops.exponent, d.stops.restitution) == (1.1, 0.9)

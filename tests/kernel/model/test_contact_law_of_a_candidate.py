"""The law of one candidate: what is given for it, by its wall, as a stop or for all."""

import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS
from chain_impact.kernel.laws.contact_laws import damping_factor
from chain_impact.kernel.model import contact_law
from chain_impact.kernel.model.contact_law import (
    HARMLESS,
    USER_LAW,
    check_law,
    check_laws,
    copy_law,
    derive_damping,
    exponent,
    given_number,
    given_restitution,
    given_stiffness,
    is_derived,
    note_kind,
    origin,
    set_parameters,
    start_laws,
)
from chain_impact.kernel.status import (
    EXPONENT_NOT_ALLOWED,
    FRICTION_WITH_RIGID_WALLS,
    OK,
    PARAMETER_OUT_OF_RANGE,
    RESTITUTION_NOT_ALLOWED,
    RIGID_WHILE_TOUCHING,
    STATIC_BELOW_SLIDING,
    UNKNOWN_LAW,
)
from tests.kernel.chains import stopped_chain, stops_of, touch
from tests.plain import make_rigid

NUMBER = {name: law.number for name, law in CONTACT_LAWS.items()}
SIZE = 1.6  # m, the longest link


@pytest.fixture
def given():
    """A record with walls of which one has a material of its own, and stops; a candidate of each kind."""
    _, d = stopped_chain(2)
    d.model.size = SIZE
    d.given.law, d.given.stiffness, d.given.restitution = NUMBER["flores"], 1e6, 0.4
    d.given.stop_stiffness, d.given.stop_restitution = 1e3, 0.2
    d.contact.exponent, d.stops.exponent, d.stops.law = 1.5, 1.0, 0
    d.contact.minimum_impact_speed, d.stops.minimum_impact_speed = 1e-3, 2e-3
    walls = sorted(set(d.candidate.wall[d.candidate.stop == 0]))
    d.walls.stiffness[:], d.walls.restitution[:] = 0.0, -1.0
    d.walls.stiffness[walls[1]], d.walls.restitution[walls[2]] = 5e7, 0.0
    kinds = [
        int(np.flatnonzero((d.candidate.wall == wall) & (d.candidate.stop == 0))[0]) for wall in walls[:3]
    ]
    return d, (*kinds, stops_of(d)[0])


def test_a_wall_may_give_its_own_stiffness_or_restitution_and_a_stop_those_of_stops(given):
    d, kinds = given
    assert [given_stiffness(d, c) for c in kinds] == pytest.approx([1e6, 5e7, 1e6, 1e3 / SIZE**2], rel=1e-13)
    assert [given_restitution(d, c) for c in kinds] == [0.4, 0.4, 0.0, 0.2]
    assert [exponent(d, c) for c in kinds] == [1.5, 1.5, 1.5, 1.0]
    assert [given_number(d, c) for c in kinds] == [NUMBER["flores"]] * 4
    d.stops.law = NUMBER["lee_wang"]
    assert [given_number(d, c) for c in kinds] == [NUMBER["flores"]] * 3 + [NUMBER["lee_wang"]]


def test_laws_come_from_a_wall_from_the_stops_or_from_what_holds_for_all(given):
    d, kinds = given
    places = [origin(d, c) for c in kinds]
    assert places[0] == -1
    assert places[1:3] == [d.candidate.wall[c] for c in kinds[1:3]]
    assert len(set(places)) == 4
    assert {origin(d, c) for c in stops_of(d)} == {origin(d, kinds[3])}


def test_a_law_is_set_to_what_is_given(given):
    d, kinds = given
    for c, least in zip(kinds, (1e-3, 1e-3, 1e-3, 2e-3 * SIZE), strict=True):
        derive_damping(d, c)
        set_parameters(d, c)
        assert d.law.number[c] == given_number(d, c)
        assert d.law.exponent[c] == exponent(d, c)
        assert d.law.stiffness[c] == given_stiffness(d, c)
        assert d.law.restitution[c] == given_restitution(d, c)
        assert d.law.minimum_impact_speed[c] == pytest.approx(least, rel=1e-13)
        assert d.law.harmless_depth[c] == pytest.approx(HARMLESS * SIZE, rel=1e-13)
    d.law.impulsive[kinds[0]] = 1
    set_parameters(d, kinds[0])
    assert d.law.harmless_depth[kinds[0]] == 0.0


@pytest.mark.parametrize("name", ["flores", "jankowski", "kelvin_voigt", "newton_impact"])
def test_the_constants_of_a_law_are_those_of_the_registry(given, name):
    d, (c, *_) = given
    law = CONTACT_LAWS[name]
    d.given.law = law.number
    d.law.number[c] = 0
    derive_damping(d, c)
    assert d.law.impulsive[c] == law.impulsive
    assert d.law.approach_only[c] == law.approach_only
    assert d.law.rate_exponent[c] == (1.5 if law.rate_exponent is None else law.rate_exponent)
    assert d.law.damping_factor[c] == damping_factor(law.number, 0.4)


def test_a_users_law_has_none_of_them(given):
    d, (c, *_) = given
    d.given.law = USER_LAW
    d.law.approach_only[c], d.law.damping_factor[c], d.law.impulsive[c] = 1, 5.0, 1
    derive_damping(d, c)
    assert (d.law.approach_only[c], d.law.damping_factor[c], d.law.impulsive[c]) == (0, 0.0, 0)
    assert d.law.rate_exponent[c] == 1.5


def test_constants_are_derived_once(given, monkeypatch):
    d, (c, *_) = given
    d.law.number[c] = 0
    derive_damping(d, c)
    set_parameters(d, c)
    assert is_derived(d, c)
    asked = []
    monkeypatch.setattr(contact_law, "damping_factor", lambda *what: asked.append(what) or 0.5)
    derive_damping(d, c)
    assert asked == []
    for name, value in (("restitution", 0.5), ("law", NUMBER["lee_wang"])):
        before = d.given[name]
        d.given[name] = value
        assert not is_derived(d, c)
        derive_damping(d, c)
        d.given[name] = before
    assert asked == [(NUMBER["flores"], 0.5), (NUMBER["lee_wang"], 0.4)]


def test_a_copied_law_is_the_same_in_all_parts(given):
    d, (c, other, *_) = given
    for k, name in enumerate(d._record["law"].dtype.names):
        if name != "same_as":
            d.law[name][c], d.law[name][other] = 10 + k, 99
    copy_law(d.law, c, other)
    for name in set(d._record["law"].dtype.names) - {"same_as"}:
        assert d.law[name][other] == d.law[name][c] != 99


@pytest.mark.parametrize("rigid", [0, 1])
def test_the_kinds_of_laws_are_noted(given, rigid):
    d, (c, *_) = given
    d.contact.any_rigid = d.contact.any_force = 0
    d.law.impulsive[c] = rigid
    note_kind(d, c)
    assert (d.contact.any_rigid, d.contact.any_force) == (rigid, 1 - rigid)


@pytest.mark.parametrize(
    ("changes", "status"),
    [
        ({}, OK),
        ({"law": 0}, UNKNOWN_LAW),
        ({"law": USER_LAW}, UNKNOWN_LAW),
        ({"restitution": -0.01}, PARAMETER_OUT_OF_RANGE),
        ({"restitution": 1.01}, PARAMETER_OUT_OF_RANGE),
        ({"restitution": math.nan}, PARAMETER_OUT_OF_RANGE),
        ({"restitution": 1.0}, OK),
        ({"stiffness": 0.0}, PARAMETER_OUT_OF_RANGE),
        ({"stiffness": math.nan}, PARAMETER_OUT_OF_RANGE),
        ({"law": NUMBER["kelvin_voigt"]}, EXPONENT_NOT_ALLOWED),  # it is linear
        ({"law": NUMBER["jankowski"]}, OK),
        ({"restitution": 0.0}, RESTITUTION_NOT_ALLOWED),  # for which its damping would be infinite
        ({"restitution": 0.0, "law": NUMBER["newton_impact"]}, OK),
    ],
)
def test_what_is_given_is_checked(given, changes, status):
    d, (c, *_) = given
    d.law.number[c] = 0
    for name, value in changes.items():
        d.given[name] = value
    assert check_law(d, c) == status
    assert check_laws(d) == status or status == OK


def test_a_users_law_is_known_to_a_kernel_that_has_one(given, monkeypatch):
    d, (c, *_) = given
    monkeypatch.setattr(contact_law.user_law, "present", lambda: True)
    for number, status in ((USER_LAW, OK), (USER_LAW + 1, UNKNOWN_LAW)):
        d.given.law = number
        assert check_law(d, c) == status


def test_a_contact_with_a_force_cannot_become_rigid(given):
    d, (c, *_) = given
    d.given.law = NUMBER["newton_impact"]
    d.given.restitution = d.given.stop_restitution = 0.5
    assert check_laws(d) == OK
    touch(d, [c])
    assert check_laws(d) == RIGID_WHILE_TOUCHING
    make_rigid(d)
    assert check_laws(d) == OK


@pytest.mark.parametrize(
    ("of_all", "of_wall", "refused"),
    [
        ((0.3, 0.3), (-1.0, -1.0), None),
        ((0.3, 0.2), (-1.0, -1.0), 0),
        ((0.3, 0.2), (0.1, 0.2), 0),
        ((0.3, 0.4), (0.3, 0.2), 1),
        ((0.3, 0.4), (-1.0, 0.2), 1),
        ((0.0, 0.2), (0.3, -1.0), None),  # a wall takes no static friction from the others
    ],
)
def test_a_static_friction_below_that_of_sliding_is_refused_with_its_wall(given, of_all, of_wall, refused):
    d, kinds = given
    d.given.friction, d.given.static_friction = of_all
    d.walls.restitution[:] = -1.0
    wall = d.candidate.wall[kinds[1]]
    d.walls.friction[wall], d.walls.static_friction[wall] = of_wall
    assert start_laws(d) == (OK if refused is None else STATIC_BELOW_SLIDING)
    assert d.fault.place == (0 if refused is None else 1 + kinds[refused])


@pytest.mark.parametrize(
    ("of_all", "of_wall", "right"),
    [
        ((0.3, 0.5), (-1.0, -1.0), (0.3, 0.5)),
        ((0.3, 0.0), (-1.0, -1.0), (0.3, 0.3)),  # without one of its own the static one is that of sliding
        ((0.3, 0.5), (0.1, -1.0), (0.1, 0.1)),  # a wall takes no static friction from the others
        ((0.3, 0.5), (0.1, 0.4), (0.1, 0.4)),
        ((0.3, 0.5), (-1.0, 0.4), (0.3, 0.4)),
        ((0.3, 0.5), (0.0, -1.0), (0.0, 0.0)),
        ((0.0, 0.0), (0.7, -1.0), (0.7, 0.7)),
    ],
)
def test_a_wall_may_give_its_own_friction_and_a_stop_has_none(given, of_all, of_wall, right):
    d, kinds = given
    d.given.friction, d.given.static_friction = of_all
    wall = d.candidate.wall[kinds[1]]
    d.walls.friction[wall], d.walls.static_friction[wall] = of_wall
    common = (of_all[0], max(of_all))
    for c, pair in ((kinds[0], common), (kinds[1], right), (kinds[3], (0.0, 0.0))):
        derive_damping(d, c)
        set_parameters(d, c)
        assert (d.law.friction[c], d.law.static_friction[c]) == pair
        d.contact.any_friction = 0
        note_kind(d, c)
        assert d.contact.any_friction == (pair[1] > 0.0)


@pytest.mark.parametrize("name", ["friction", "static_friction"])
def test_a_wall_with_friction_of_its_own_has_a_law_of_its_own(given, name):
    d, (c, *_) = given
    assert origin(d, c) == -1
    d.walls[name][d.candidate.wall[c]] = 0.0
    assert origin(d, c) == d.candidate.wall[c]


@pytest.mark.parametrize(
    ("sliding", "static", "status"),
    [
        (0.3, 0.0, OK),
        (0.0, 0.3, OK),
        (1e3, 1e4, OK),
        (-0.1, 0.0, PARAMETER_OUT_OF_RANGE),
        (-0.1, 0.5, PARAMETER_OUT_OF_RANGE),
        (math.nan, 0.0, PARAMETER_OUT_OF_RANGE),
        (math.inf, 0.0, PARAMETER_OUT_OF_RANGE),
        (0.3, math.inf, PARAMETER_OUT_OF_RANGE),
    ],
)
def test_coefficients_of_friction_are_checked(given, sliding, static, status):
    d, (c, *_) = given
    d.given.friction, d.given.static_friction = sliding, static
    assert check_law(d, c) == status
    assert check_laws(d) == status


@pytest.mark.parametrize("name", ["friction", "static_friction"])
def test_rigid_walls_have_no_friction_but_stops_beside_them_may_be_rigid(given, name):
    d, (c, *_, stop) = given
    rigid = NUMBER["newton_impact"]
    d.given[name], d.given.law, d.stops.law = 0.3, rigid, NUMBER["flores"]
    assert check_law(d, c) == FRICTION_WITH_RIGID_WALLS
    assert check_laws(d) == FRICTION_WITH_RIGID_WALLS
    d.given.law, d.stops.law = NUMBER["flores"], rigid
    assert check_law(d, stop) == OK
    assert check_laws(d) == OK
    d.given[name], d.given.law = 0.0, rigid
    assert check_laws(d) == OK

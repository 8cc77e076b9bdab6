"""The contact law of each candidate: what was given for it, for its wall, or for stops in units of angles."""

import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS
from chain_impact.kernel.advance import latch_again
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.laws import user_law
from chain_impact.kernel.laws.contact_laws import LAW_COUNT
from chain_impact.kernel.model.contact_force import elastic_energy, law_force, set_damping
from chain_impact.kernel.model.contact_law import HARMLESS, USER_LAW, start_laws, update_laws
from chain_impact.kernel.model.inputs import apply_inputs
from chain_impact.kernel.status import (
    EXPONENT_NOT_ALLOWED,
    OK,
    PARAMETER_OUT_OF_RANGE,
    RESTITUTION_NOT_ALLOWED,
    RIGID_WHILE_TOUCHING,
    UNKNOWN_LAW,
)
from tests.kernel.chains import chain, stopped_chain, touch
from tests.plain import make_rigid

LAWS = pytest.mark.parametrize("law", CONTACT_LAWS.values(), ids=lambda law: law.id)
PARTS = ("number", "stiffness", "exponent", "restitution", "minimum_impact_speed", "damping_factor")
PARTS += ("rate_exponent", "approach_only", "impulsive", "any_force", "any_rigid")


def prepared(**more):
    """A chain of three links with walls."""
    return chain(np.random.default_rng(4), 3, **more)[1]


def restitution_for(law, e=0.7):
    """A restitution; near 1 the factor of Kuwabara and Kono takes no integration."""
    return 1.0 - 1e-7 if law.id == "kuwabara_kono" else e


def test_what_was_given_holds():
    d = prepared(inputs=True)
    d.given.law, d.given.stiffness, d.given.restitution = 3, 5e5, 0.25
    d.given.joint_torque[:], d.given.tip_force[:] = 1.5, (2.0, 3.0)
    apply_inputs(d)
    assert update_laws(d) == OK
    for name, value in (("number", 3), ("stiffness", 5e5), ("restitution", 0.25)):
        assert (d.law[name] == value).all()
    assert d.inputs.joint_torque.tolist() == [1.5] * 3
    assert d.inputs.tip_force.tolist() == [2.0, 3.0]


@LAWS
def test_a_law_is_what_the_registry_says(law):
    d = prepared()
    given, contact, own, e = d.given, d.contact, d.law, restitution_for(law)
    given.law, given.restitution, contact.exponent = law.number, e, law.exponent or 2.0
    own.approach_only[:] = own.rate_exponent[:] = 9
    assert start_laws(d) == OK
    p = contact.exponent if law.rate_exponent is None else law.rate_exponent
    assert (own.rate_exponent == p).all()
    assert (own.approach_only == law.approach_only).all()
    assert (own.damping_factor == law.damping_factor(e)).all()
    assert (own.impulsive == law.impulsive).all()
    assert (contact.any_rigid, contact.any_force) == (law.impulsive, not law.impulsive)
    if law.exponent is not None:
        contact.exponent = 1.1
        assert start_laws(d) == EXPONENT_NOT_ALLOWED
    if law.id not in {"kelvin_voigt", "tsuji"}:  # whose logarithm of 0 is an error in Python
        contact.exponent, given.restitution = law.exponent or 2.0, 0.0
        assert start_laws(d) == (OK if law.allows_zero else RESTITUTION_NOT_ALLOWED)


def test_a_users_law_has_no_factor(monkeypatch):
    monkeypatch.setattr(user_law, "present", lambda: 1)
    d = prepared()
    d.given.law, d.contact.exponent, d.law.damping_factor[:] = USER_LAW, 1.7, 5.0
    d.law.approach_only[:] = 1
    assert start_laws(d) == OK
    for name, value in (("damping_factor", 0.0), ("rate_exponent", 1.7), ("approach_only", 0)):
        assert (d.law[name] == value).all()


@pytest.mark.parametrize(
    ("field", "value", "status"),
    [
        ("law", 0, UNKNOWN_LAW),
        ("law", LAW_COUNT + 1, UNKNOWN_LAW),
        ("law", 1, OK),
        ("law", LAW_COUNT, OK),
        ("restitution", -1e-9, PARAMETER_OUT_OF_RANGE),
        ("restitution", 1.0 + 1e-9, PARAMETER_OUT_OF_RANGE),
        ("restitution", math.nan, PARAMETER_OUT_OF_RANGE),
        ("restitution", 1.0, OK),
        ("stiffness", 0.0, PARAMETER_OUT_OF_RANGE),
        ("stiffness", math.nan, PARAMETER_OUT_OF_RANGE),
        ("stiffness", 1e-3, OK),
    ],
)
def test_a_law_that_is_none_or_out_of_range_is_refused(field, value, status, monkeypatch):
    d = prepared()
    d.given[field] = value
    before = laws_of(d)
    assert update_laws(d) == status
    if status != OK:
        assert laws_of(d) == before
    if value == LAW_COUNT + 1:
        monkeypatch.setattr(user_law, "present", lambda: 1)
        assert update_laws(d) == OK
    if value == LAW_COUNT:
        assert d.law.impulsive.all()
    # and at the start, where what was given is taken over
    monkeypatch.undo()
    assert initialize(d, 0.0) == d.statistics.status == status


def laws_of(d):
    """All that is known of the laws, as bytes."""
    return d.law.tobytes(), d.contact.any_force, d.contact.any_rigid


def test_a_law_is_derived_when_it_or_its_restitution_has_changed_also_for_contacts_that_last():
    d = prepared()
    touch(d, [2, 5])
    d.touch.impact_speed[:], d.touch.effective_mass[:] = 1.5, 2.0
    d.touch.damping[:] = d.touch.depth_scale[:] = 0.0
    for law, restitution in (("ye", 0.5), ("ye", 0.25), ("flores", 0.25)):
        d.given.law, d.given.restitution = CONTACT_LAWS[law].number, restitution
        assert update_laws(d) == OK
        latch_again(d)
        assert (d.law.damping_factor == CONTACT_LAWS[law].damping_factor(restitution)).all()
        damping = d.law.damping_factor[2] * d.law.stiffness[2] / 1.5
        assert d.touch.damping[[2, 5]] == pytest.approx([damping] * 2, rel=1e-12)
    assert elastic_energy(d, 5, d.touch.depth_scale[5]) == pytest.approx(0.5 * 2.0 * 1.5**2, rel=1e-12)
    assert np.count_nonzero(d.touch.damping) == np.count_nonzero(d.touch.depth_scale) == 2
    # what is known is not found anew, but the damping of contacts follows the stiffness
    d.law.damping_factor[0] = 77.0
    d.given.stiffness *= 2.0
    assert update_laws(d) == OK
    latch_again(d)
    assert (d.law.damping_factor == 77.0).all()
    assert d.touch.damping[2] == pytest.approx(77.0 * d.given.stiffness / 1.5, rel=1e-12)
    # one that is refused changes nothing
    d.contact.exponent, before, kept = 1.2, d.given.law, laws_of(d)
    d.given.law = CONTACT_LAWS["kelvin_voigt"].number
    assert update_laws(d) == EXPONENT_NOT_ALLOWED
    assert laws_of(d) == kept
    d.contact.exponent, d.given.law = 1.5, before
    # at the start of a run all is found anew
    assert start_laws(d) == OK
    assert (d.law.damping_factor == CONTACT_LAWS["flores"].damping_factor(0.25)).all()
    # rigid walls have no depth
    d.touch.depth_scale[:] = 5.0
    make_rigid(d)
    d.given.law = CONTACT_LAWS["newton_impact"].number
    assert update_laws(d) == OK
    latch_again(d)
    assert d.law.impulsive.all()
    assert (d.touch.depth_scale == 5.0).all()


# --- walls and stops of their own --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stiffness", "restitution"), [(3e5, -1.0), (0.0, 0.2), (3e5, 0.2), (0.0, 0.0), (0.0, -1.0)]
)
def test_a_wall_of_its_own_material_has_what_it_says_and_the_rest_of_all(stiffness, restitution):
    d = prepared(model="hunt_crossley", restitution=0.5, stiffness=1e7)
    wall = d.candidate.wall[1]
    d.walls.stiffness[wall], d.walls.restitution[wall] = stiffness, restitution
    assert start_laws(d) == OK
    own, e = d.candidate.wall == wall, restitution if restitution >= 0.0 else 0.5
    assert 0 < own.sum() < d.candidates
    assert (d.law.stiffness[own] == (stiffness or 1e7)).all()
    assert (d.law.restitution[own] == e).all()
    assert (d.law.stiffness[~own] == 1e7).all()
    assert (d.law.restitution[~own] == 0.5).all()
    law = CONTACT_LAWS["hunt_crossley"]
    assert (d.law.damping_factor[own] == law.damping_factor(e)).all()
    assert (d.law.damping_factor[~own] == law.damping_factor(0.5)).all()


def test_candidates_of_one_origin_have_one_law():
    """``same_as`` is the first of them; the material of a wall may change in a run."""
    d = stopped_chain(2)[1]
    wall = d.candidate.wall[1]
    d.walls.restitution[wall] = 0.2
    assert start_laws(d) == OK
    origins = [-2 if d.candidate.stop[c] else wall == d.candidate.wall[c] for c in range(d.candidates)]
    assert len(set(origins)) == 3
    assert d.law.same_as.tolist() == [origins.index(origin) for origin in origins]
    d.walls.restitution[wall], d.given.stop_restitution = 0.9, 0.1
    assert update_laws(d) == OK
    factor, e = CONTACT_LAWS["zhang_sharf"].damping_factor, d.given.restitution
    of_origin = {-2: 0.1, True: 0.9, False: e}
    assert d.law.restitution.tolist() == [of_origin[origin] for origin in origins]
    assert d.law.damping_factor.tolist() == [factor(of_origin[origin]) for origin in origins]


@pytest.mark.parametrize("value", [math.nan, 0.0, -1.0])
def test_stops_that_are_out_of_range_are_refused_and_change_nothing(value):
    d = stopped_chain(2)[1]
    before = laws_of(d)
    d.given.stop_stiffness, d.given.law = value, 3
    assert update_laws(d) == PARAMETER_OUT_OF_RANGE
    assert laws_of(d) == before
    d.given.stop_stiffness, d.stops.law = 1e4, LAW_COUNT + 1
    assert update_laws(d) == UNKNOWN_LAW
    assert laws_of(d) == before


@pytest.mark.full("more cases", but=24)
@LAWS
@pytest.mark.parametrize("exponent", [1.5, 2.0])
def test_the_law_of_a_stop_is_that_of_an_angle(law, exponent):
    """M = K φⁿ + d φᵖ φ̇ with d of K, v₀ in rad/s and the moment of inertia; here F = M/s at δ = s φ."""
    _, d = stopped_chain(3)
    size, n, e = d.model.size, law.exponent or exponent, restitution_for(law)
    inertia, speed, stiffness = 0.37, 2.5, 4e4
    d.stops.law, d.stops.exponent, d.given.stop_stiffness, d.given.stop_restitution = (
        law.number,
        n,
        stiffness,
        e,
    )
    d.stops.minimum_impact_speed = 0.02
    assert start_laws(d) == OK
    c = int(np.flatnonzero(d.candidate.stop)[0])
    assert d.law.number[c] == law.number
    assert d.law.number[0] == d.given.law != law.number or law.id == "zhang_sharf"
    assert d.law.minimum_impact_speed[c] == pytest.approx(0.02 * size, rel=1e-14)
    assert d.law.impulsive[c] == law.impulsive
    assert d.law.restitution[c] == e
    if law.impulsive:
        return
    d.touch.effective_mass[c], d.touch.impact_speed[c] = inertia / size**2, speed * size
    set_damping(d, c)
    p = n if law.rate_exponent is None else law.rate_exponent
    factor, m = law.damping_factor(e), law.mass_power
    damping = factor * stiffness ** (1.0 - m) * inertia**m / (speed if m == 0.0 else 1.0)
    for angle in (1e-3, 0.2):
        for rate in (1.3, -0.4):
            spring = stiffness * angle**n
            damper = 0.0 if law.approach_only and rate < 0.0 else damping * angle**p * rate
            force, elastic = law_force(d, c, angle * size, rate * size)
            assert elastic * size == pytest.approx(spring, rel=1e-12)
            assert force * size == pytest.approx(max(0.0, spring + damper), rel=1e-11)
            energy = elastic_energy(d, c, angle * size)
            assert energy == pytest.approx(spring * angle / (n + 1.0), rel=1e-12)


def test_a_users_law_of_a_stop_takes_and_returns_what_belongs_to_angles(monkeypatch):
    told = []

    def moment(*arguments):
        told.append(arguments)
        return 12.0

    monkeypatch.setattr(user_law, "present", lambda: 1)
    monkeypatch.setattr(user_law, "force", moment)
    _, d = stopped_chain(2)
    size, d.stops.law = d.model.size, USER_LAW
    d.stops.exponent, d.given.stop_stiffness, d.given.stop_restitution = 1.3, 5e3, 0.4
    assert start_laws(d) == OK
    c = d.candidates - 1
    d.touch.effective_mass[c], d.touch.impact_speed[c] = 0.3 / size**2, 2.0 * size
    force, elastic = law_force(d, c, 0.1 * size, 0.7 * size)
    assert told[0] == pytest.approx((0.1, 0.7, 2.0, 0.3, 5e3, 1.3, 0.4), rel=1e-12)
    assert force * size == pytest.approx(12.0, rel=1e-13)
    assert elastic * size == pytest.approx(5e3 * 0.1**1.3, rel=1e-12)


def test_a_stop_without_a_law_has_that_of_the_walls():
    _, d = stopped_chain(2)
    d.stops.law, d.given.law = 0, CONTACT_LAWS["ye"].number
    assert update_laws(d) == OK
    assert (d.law.number == CONTACT_LAWS["ye"].number).all()


def test_what_touches_with_a_force_cannot_become_rigid():
    """But what is held by a rigid wall may be so further on, and others may become rigid."""
    rigid = CONTACT_LAWS["newton_impact"].number
    d = stopped_chain(2)[1]
    stop = int(np.flatnonzero(d.candidate.stop)[0])
    touch(d, [stop])
    before, kept = laws_of(d), d.given.law
    d.given.law = rigid
    d.stops.law = rigid
    assert update_laws(d) == RIGID_WHILE_TOUCHING
    assert laws_of(d) == before
    d.stops.law = kept
    assert update_laws(d) == OK
    assert (d.law.impulsive == (d.candidate.stop == 0)).all()
    assert (d.contact.any_rigid, d.contact.any_force) == (1, 1)
    touch(d, [0])
    assert update_laws(d) == OK


def test_a_depth_is_harmless_by_round_off_of_a_link_and_none_in_a_rigid_wall():
    d = prepared()
    d.model.size = 2.5
    assert start_laws(d) == OK
    harmless = d.law.harmless_depth[0]
    assert harmless == 2.5 * HARMLESS
    # a force of 1e-10 N at 1e8 N/m^1.5, and more than round-off of positions
    assert 1e8 * harmless**1.5 < 1e-9
    assert harmless > 1e3 * 2.0**-53 * d.model.size
    d.given.law = CONTACT_LAWS["newton_impact"].number
    assert update_laws(d) == OK
    assert (d.law.harmless_depth == 0.0).all()

"""Dry friction as loads and constraints, against dense algebra with the textbook's matrices."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel import equations
from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.constraints import geometry
from chain_impact.kernel.forces import active_contacts, friction
from chain_impact.kernel.record.constants import NO_FRICTION, STICKS
from tests.kernel.chains import chain, locate_touching_state
from tests.kernel.rubbing import MOMENT, MU, MU_S, mobility, rubbing_chain, tangents

CASES = [("free", 2, True), ("free", 4, False), ("pinned", 1, True), ("pinned", 0, True)]


def elements_of(d):
    return [int(e) for e in d.friction_element.index[: d.friction.active_count]]


def rate_at(d, y):
    """Return ẏ with the present modes; the points get their accelerations from ẏ."""
    rate = np.zeros(len(y))
    locate_points(d, y)
    equations.rate_from_points(d, y, rate)
    accelerate_points(d, y, rate)
    return rate


@pytest.mark.parametrize(("base", "contacts", "joints"), CASES)
def test_contacts_are_listed_before_joints(base, contacts, joints):
    _, d, _ = rubbing_chain(np.random.default_rng(1), base, contacts, joints)
    elements, own = elements_of(d), d.friction
    assert elements[: own.contact_count] == [int(c) for c in d.contacts.active_index[:contacts]]
    assert [friction.drive_of_element(d, e) for e in elements[contacts:]] == ([1, 2, 3] if joints else [])
    assert own.may_act
    assert not geometry.has_sticking(d)
    d.friction_element.mode[elements[-1]] = STICKS
    friction.list_sticking(d)
    assert (own.stuck_count, int(d.friction_element.stuck_index[0])) == (1, elements[-1])
    assert own.stuck_joints == joints
    friction.suspend_sticking(d)
    assert not geometry.has_sticking(d)
    friction.list_friction(d)
    assert own.stuck_count == 1
    friction.clear_friction(d)
    assert (d.friction_element.mode[:] == NO_FRICTION).all()


def test_only_a_law_with_friction_rubs():
    _, d, _ = rubbing_chain(np.random.default_rng(1), "free", 1, False)
    c = int(d.contacts.active_index[0])
    assert friction.may_have_friction(d, c)
    d.law.static_friction[:] = 0.0
    assert not friction.may_have_friction(d, c)
    d.contact_settings.any_friction = 0
    friction.set_friction_used(d)
    assert not d.friction.may_act


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("base", "contacts", "joints"), CASES)
def test_sliding_friction_is_a_load_against_the_motion(base, contacts, joints, sign):
    """M q̈ changes by Σ J_tᵀ F_t, F_t = −s µ F_n or −s M/size; the power −F_t v_t is dissipated."""
    rng = np.random.default_rng(2)
    scene, d, y = rubbing_chain(rng, base, contacts, joints)
    elements = elements_of(d)
    d.friction_element.mode[elements] = sign
    rate = rate_at(d, y)
    d.friction.active_count = 0
    free = rate_at(d, y)
    rows = tangents(scene, d, y, elements)
    response, _ = mobility(scene, d, y, rows)
    normal = np.array([d.contacts.force[e] if e < d.candidate_count else 0.0 for e in elements])
    sizes = np.where(normal > 0.0, MU * normal, MOMENT / d.chain.longest_link)
    n = d.link_count
    np.testing.assert_allclose(
        rate[n + 2 : 2 * n + 4] - free[n + 2 : 2 * n + 4], response @ (-sign * sizes), rtol=1e-9, atol=1e-9
    )
    speeds = rows @ y[n + 2 : 2 * n + 4]
    assert rate[2 * n + 4] - free[2 * n + 4] == pytest.approx(sign * sizes @ speeds, rel=1e-9)
    np.testing.assert_allclose(d.friction_element.force[elements], -sign * sizes, rtol=1e-12)
    limits = np.where(normal > 0.0, MU_S * normal, MOMENT / d.chain.longest_link)
    np.testing.assert_allclose(d.friction_element.friction_limit[elements], limits, rtol=1e-12)


@pytest.mark.parametrize(("base", "contacts", "joints"), CASES)
def test_sticking_elements_have_no_tangential_acceleration(base, contacts, joints):
    rng = np.random.default_rng(3)
    scene, d, y = rubbing_chain(rng, base, contacts, joints)
    elements = elements_of(d)
    d.friction.active_count = d.friction.contact_count = 0
    free = rate_at(d, y)
    bias = np.array([geometry.tangential_acceleration(d, e) for e in elements])
    friction.list_friction(d)
    d.friction_element.mode[elements] = STICKS
    friction.list_sticking(d)
    rate = rate_at(d, y)
    left = [geometry.tangential_acceleration(d, e) for e in elements]
    np.testing.assert_allclose(left, 0.0, atol=1e-11 * (1.0 + np.abs(bias).max()))
    response, w = mobility(scene, d, y, tangents(scene, d, y, elements))
    forces = np.linalg.lstsq(w, -bias, rcond=1e-10)[0]
    n = d.link_count
    gained = rate[n + 2 : 2 * n + 4] - free[n + 2 : 2 * n + 4]
    np.testing.assert_allclose(gained, response @ forces, rtol=1e-7, atol=1e-7)
    if np.linalg.cond(w) < 1e8:
        np.testing.assert_allclose(d.friction_element.force[elements], forces, rtol=1e-6, atol=1e-6)


def test_a_contact_begins_in_the_direction_of_its_motion():
    _, d, _ = rubbing_chain(np.random.default_rng(4), "free", 1, False)
    c = int(d.contacts.active_index[0])
    speed = geometry.tangential_rate(d, c)
    friction.begin_friction(d, c)
    assert d.friction_element.mode[c] == np.sign(speed)
    for vector in (d.scratch.velocity.x, d.scratch.velocity.y):
        vector[:] = 0.0
    friction.begin_friction(d, c)
    assert d.friction_element.mode[c] == STICKS
    assert d.friction_element.anchor[c] == geometry.tangential_position(d, c) != 0.0


def test_margins_are_the_least_of_a_step():
    _, d, _ = rubbing_chain(np.random.default_rng(5), "free", 1, False)
    c = int(d.contacts.active_index[0])
    speed = geometry.tangential_rate(d, c)
    d.friction_element.mode[c] = -int(np.sign(speed))
    d.friction_element.margin[c] = 7.0
    friction.clear_friction_margins(d)
    assert d.friction_element.margin[c] == math.inf
    active_contacts.clear_applied_forces(d)
    power = friction.apply_sliding_friction(d, c, 2.0)
    assert power == pytest.approx(-2.0 * abs(speed), rel=1e-14)
    assert d.friction_element.margin[c] == -abs(speed)
    d.contacts.force[c] = 5.0
    assert friction.apply_friction(d) == pytest.approx(-5.0 * MU * abs(speed), rel=1e-14)
    d.friction_element.mode[c] = STICKS
    friction.list_sticking(d)
    d.constraints.impulse[d.contacts.active_count] = 5.0 * MU_S + 100.0
    friction.store_static_forces(d)
    assert d.friction_element.margin[c] == pytest.approx(-100.0, rel=1e-12)
    assert friction.add_power_of_sticking(d) == pytest.approx(-d.friction_element.force[c] * speed, rel=1e-14)


def test_an_anchor_moves_only_where_it_cannot_be_held():
    _, d, _ = rubbing_chain(np.random.default_rng(6), "free", 1, False)
    c = int(d.contacts.active_index[0])
    d.friction_element.mode[c] = STICKS
    friction.list_sticking(d)
    there = geometry.tangential_position(d, c)
    near = there + 0.5 * friction.ANCHOR_ROUND_OFF * geometry.largest_coordinate(d)
    d.friction_element.anchor[c] = near
    friction.move_missed_anchors(d)
    assert d.friction_element.anchor[c] == near
    d.friction_element.anchor[c] = there + 2.0 * friction.ANCHOR_ROUND_OFF * geometry.largest_coordinate(d)
    friction.move_missed_anchors(d)
    assert d.friction_element.anchor[c] == there


@pytest.mark.parametrize("room", [True, False])
def test_a_contact_that_begins_has_a_mode_and_is_listed(room):
    """A damaged record without room does not list the contact."""
    rng = np.random.default_rng(7)
    _, d = chain(rng, 3, **({"friction": MU} if room else {}))
    locate_touching_state(rng, d, [])
    d.law.friction[:] = d.law.static_friction[:] = MU
    d.contact_settings.any_friction = 1
    friction.set_friction_used(d)
    assert (d.friction_element_count > 0, d.friction.may_act) == (room, room)
    active_contacts.begin_force_law_contact(d, 1)
    active_contacts.list_active_contacts(d)
    assert d.contacts.active_count == 1
    assert elements_of(d) == [1] * room
    if room:
        assert d.friction_element.mode[1] == np.sign(geometry.tangential_rate(d, 1)) != 0.0


def test_notes_of_friction_in_a_step_are_forgotten_with_the_step():
    _, d, _ = rubbing_chain(np.random.default_rng(5), "free", 2, True)
    elements = elements_of(d)
    d.friction_element.margin[:] = -1.0
    equations.clear_stage_notes(d)
    others = sorted(set(range(d.friction_element_count)) - set(elements))
    assert (d.friction_element.margin[elements] == math.inf).all()
    assert (d.friction_element.margin[others] == -1.0).all()


@pytest.mark.parametrize(
    ("force", "approach_only", "load"), [(3.0, 0, 3.0), (3.0, 1, 3.0), (-3.0, 0, -3.0), (-3.0, 1, 0.0)]
)
def test_friction_goes_with_a_force_that_is_continued_beyond_its_kink(force, approach_only, load):
    """A law with approach damping has no friction while its continued force pulls."""
    contacts, law = SimpleNamespace(force=[99.0, force]), SimpleNamespace(approach_only=[0, approach_only])
    assert friction.normal_force_for_friction(SimpleNamespace(contacts=contacts, law=law), 1) == load

"""The modes of dry friction after an event, against all combinations of modes by dense algebra."""

import itertools

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import largest, locate_points
from chain_impact.kernel.events.friction_modes import AGAINST, against, update_modes
from chain_impact.kernel.events.marks import STICKING_ENDS, pending_changes
from chain_impact.kernel.events.sampled import excess
from chain_impact.kernel.model.contact import list_touching
from chain_impact.kernel.model.friction import NO_FRICTION, STICKS, list_sticking
from chain_impact.kernel.model.geometry import tangential_position, tangential_rate
from tests.kernel.rubbing import MODES, AtRest, rubbing_chain

CASES = [("free", 2, True), ("free", 3, False), ("pinned", 1, True), ("pinned", 0, True), ("free", 0, True)]
SEEDS = range(6)
BOTH = pytest.mark.parametrize(("base", "contacts", "joints"), CASES)


def assert_laws_hold(chain):
    """That each element at rest has a force and an acceleration after Coulomb."""
    d, reached = chain.d, chain.accelerations()
    scale = largest(d, d.work.acceleration)
    held, sliding = chain.limits()
    for k, e in enumerate(chain.elements):
        force, mode = d.element.force[e], chain.modes[k]
        if mode == STICKS:
            assert abs(force) <= held[k] + excess(d, e)
            assert abs(reached[k]) <= 1e-11 * scale
        else:
            assert force == pytest.approx(-mode * sliding[k], rel=1e-12)
            assert mode * reached[k] >= -AGAINST * scale


@pytest.mark.full("more cases", but=15)
@BOTH
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("jumped", [True, False])
def test_the_modes_of_elements_at_rest_are_those_that_dense_algebra_finds(
    seed, jumped, base, contacts, joints
):
    """For µ_s = µ all consistent combinations have the same accelerations, and the kernel has these."""
    chain = AtRest(seed, base, contacts, joints)
    right = chain.consistent()
    assert right
    update_modes(chain.d, jumped)
    assert chain.modes in right
    assert_laws_hold(chain)
    for reached in right.values():
        np.testing.assert_allclose(chain.accelerations(), reached, atol=1e-6 * np.abs(chain.bias).max())


@pytest.mark.full("more cases", but=14)
@BOTH
@pytest.mark.parametrize("seed", SEEDS)
def test_so_they_are_with_more_static_friction(seed, base, contacts, joints):
    """There may be several answers, with accelerations of their own; the kernel has one of them."""
    chain = AtRest(seed, base, contacts, joints, holding=1.7)
    update_modes(chain.d, True)
    assert chain.modes in chain.consistent()
    assert_laws_hold(chain)


@pytest.mark.full("takes long")
def test_the_chains_at_rest_have_all_kinds_of_modes():
    """So that the tests above are about sticking and both ways of sliding, and changes of the first guess."""
    found, changed = set(), 0
    for seed, case in itertools.product(SEEDS, CASES):
        chain = AtRest(seed, *case)
        before = chain.modes
        update_modes(chain.d, False)
        found |= set(chain.modes)
        changed += before != chain.modes
    assert found == set(MODES)
    assert changed > len(SEEDS)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_mode_that_is_consistent_is_kept_and_costs_one_evaluation(seed):
    chain = AtRest(seed, "free", 2, True, holding=1.7)
    d = chain.d
    update_modes(d, True)
    modes, before, logged = chain.modes, int(d.statistics.rhs_evaluations), int(d.changes.count)
    update_modes(d, False)
    assert (chain.modes, int(d.statistics.rhs_evaluations) - before) == (modes, 1)
    assert d.changes.count == logged


@pytest.mark.parametrize("jumped", [True, False])
def test_what_moves_slides_in_the_direction_of_its_motion(jumped):
    """What stuck moves by errors only, if no speed has jumped."""
    rng = np.random.default_rng(8)
    _, d, y = rubbing_chain(rng, "free", 3, True)
    d.step.state_end[:] = y
    elements = [int(e) for e in d.element.index[: d.friction.count]]
    signs = [int(np.sign(tangential_rate(d, e))) for e in elements]
    assert set(signs) == {1, -1}
    d.element.mode[elements] = STICKS if jumped else [-sign for sign in signs]
    update_modes(d, jumped)
    assert d.element.mode[elements].tolist() == signs
    assert not d.element.undecided[elements].any()
    assert not d.element.slack[elements].any()
    assert d.element.mode[list(set(range(d.elements)) - set(elements))].tolist() == [NO_FRICTION] * (
        d.elements - len(elements)
    )


def test_anchors_are_kept_by_what_stuck_before_and_otherwise_set():
    chain = AtRest(0, "free", 2, True)
    d = chain.d
    d.law.static_friction[:], d.model.joint_friction[:] = 1e9, 1e9
    d.element.mode[chain.elements] = STICKS
    first, *others = chain.elements
    d.element.mode[others[0]] = 1
    here = d.element.anchor[chain.elements].copy()
    moved = here + 1e-9
    d.element.anchor[chain.elements] = moved
    update_modes(d, False)
    assert chain.modes == (STICKS,) * len(chain.elements)
    assert d.element.anchor[first] == moved[0]
    assert d.element.anchor[others[0]] == pytest.approx(here[1], abs=1e-13)
    # the state is projected onto all of them
    locate_points(d, d.step.state_end)
    for e in chain.elements:
        assert tangential_position(d, e) == pytest.approx(d.element.anchor[e], abs=1e-12)
        assert abs(tangential_rate(d, e)) < 1e-12
    d.element.anchor[chain.elements] = moved + 1e-3
    update_modes(d, True)
    assert d.element.anchor[chain.elements] == pytest.approx(moved, abs=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_what_has_reached_its_limit_slides_against_its_force(seed):
    chain = AtRest(seed, "free", 2, True)
    d = chain.d
    d.law.static_friction[:], d.model.joint_friction[:] = 1e9, 1e9
    d.element.mode[chain.elements] = STICKS
    update_modes(d, True)
    assert not any(chain.modes)
    e = chain.elements[-1]
    force = float(d.element.force[e])
    d.model.joint_friction[e - d.candidates] = 0.9 * abs(force) * d.model.size
    d.element.event[e] = STICKING_ENDS
    assert pending_changes(d) == 1
    update_modes(d, False)
    assert d.element.mode[e] == against(force) == -np.sign(force)
    assert pending_changes(d) == 0
    assert chain.modes in chain.consistent()


def test_joints_of_a_chain_without_friction_have_no_mode():
    chain = AtRest(0, "free", 2, True)
    d = chain.d
    d.model.joint_friction[:] = 0.0
    update_modes(d, True)
    assert (d.element.mode[d.candidates :] == NO_FRICTION).all()
    assert d.friction.count == 2
    list_sticking(d)
    assert d.friction.stuck_joints == 0


def test_no_mark_of_a_change_outlives_the_choice_of_modes():
    """Not even of an element whose contact has ended: it would count when that point touches again."""
    _, d, _ = rubbing_chain(np.random.default_rng(5), "free", 2, True)
    d.element.event[:] = STICKING_ENDS
    d.touch.active[d.touch.active_index[0]] = 0
    list_touching(d)
    update_modes(d, False)
    assert d.friction.count < d.elements
    assert not d.element.event.any()

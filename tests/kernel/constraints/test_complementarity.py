"""Impulses at rigid walls that only push, compared with every possible set of contacts."""

import itertools

import numpy as np
import pytest

from chain_impact.kernel.constraints import complementarity, impulses
from chain_impact.kernel.forces import holding
from tests.helpers.models.reference import complementary_impulses
from tests.kernel.forces.pressed import problem


@pytest.mark.full("more cases", but=28)
@pytest.mark.parametrize("seed", range(40))
def test_impulses_are_complementary(seed):
    """The result is compared with all 2^k sets of contacts, from any guess."""
    rng = np.random.default_rng(seed)
    d, _, _, response, w = problem(pressed=rng.integers(0, 2, rng.integers(1, 5)), seed=seed)
    own, count = d.constraints, len(w)
    own.target_motion[:count] = rng.choice([0.0, 0.5], count) * np.abs(own.unforced_motion[:count])
    expected = complementary_impulses(w, own.unforced_motion[:count], own.target_motion[:count])
    impulses.factorize_free(d)
    complementarity.solve_lcp(d, np.abs(own.unforced_motion[:count]).max())
    scale = np.linalg.cond(w) * max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(own.impulse[:count], expected, atol=1e-14 * scale)
    np.testing.assert_allclose(own.change, response @ expected, atol=1e-13 * scale)
    assert ((own.impulse[:count] > 0.0) <= (own.in_active_set[:count] == 1)).all()


def test_a_link_jammed_between_two_walls_has_a_solution_of_many():
    """A point lies between opposite walls: W is singular; the motion is unique, the two forces are not."""
    d, *_ = problem(pressed=(1, 1))
    own, (first, second) = d.constraints, d.contacts.active_index[:2]
    d.candidate.place[second] = d.candidate.place[first]
    for normal in (d.candidate.normal_x, d.candidate.normal_y):
        normal[second] = -normal[first]
    own.unforced_motion[:2], own.target_motion[:2] = (-1.0, 1.0), 0.0
    impulses.factorize_free(d)
    complementarity.solve_lcp(d, 1.0)
    np.testing.assert_allclose(own.reached_motion[:2], 0.0, atol=1e-14)
    assert (own.impulse[:2] >= 0.0).all()


def test_a_contact_that_pulls_or_falls_short_is_wrong_beyond_round_off():
    d, *_ = problem(pressed=(1, 1, 0, 0))
    own = d.constraints
    scale = 3.0
    own.target_motion[:4] = 0.5
    for pull, short in ((2.0, 2.0), (0.5, 2.0), (2.0, 0.5), (0.5, 0.5)):
        own.is_violated[:] = 7
        own.impulse[:4] = 4.0, -pull * impulses.SIGN_TOLERANCE * 4.0, 0.0, 0.0
        own.reached_motion[:4] = -9.0, 0.5, 0.7, 0.5 - short * impulses.SIGN_TOLERANCE * scale
        expected = [0, int(pull > 1.0), 0, int(short > 1.0)]
        assert complementarity.count_violations(d, scale) == sum(expected)
        assert own.is_violated[:4].tolist() == expected
    # the largest error may be a pulling contact
    own.impulse[:4], own.reached_motion[:4] = (1.0, -4.0, 0.0, 0.0), 1.0
    assert complementarity.count_violations(d, scale) == 1
    assert holding.least_impulse(d) == -4.0
    own.impulse[:4] = 1.0
    assert holding.least_impulse(d) == 0.0


def test_wrong_contacts_change_together_and_after_stalls_one_by_one(monkeypatch):
    """Cases: block pivots; block pivots that do not reduce the wrong contacts; single pivots afterwards."""
    d, *_ = problem()
    wrong, sets, own = [4, 4, 4, 4, 4, 4, 2, 2, 0], [], d.constraints

    def note_active_set(_, __):
        sets.append(own.in_active_set[:4].copy())
        count = wrong.pop(0)
        own.is_violated[:4] = [k < count for k in range(4)]
        return count

    monkeypatch.setattr(complementarity, "solve_equality", lambda *_: None)
    monkeypatch.setattr(complementarity, "count_violations", note_active_set)
    complementarity.solve_lcp(d, 1.0)
    changed = [
        np.flatnonzero(contact_set != other).tolist() for contact_set, other in itertools.pairwise(sets)
    ]
    assert changed == [[0, 1, 2, 3]] * (1 + complementarity.MAX_STALLED_PIVOTS) + [[3], [3], [0, 1], [0, 1]]

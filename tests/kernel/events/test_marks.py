"""Marks of events: set one by one, deleted together, and copied to a tangent instance."""

import numpy as np
import pytest

from chain_impact.kernel.events import marks
from chain_impact.kernel.record.constants import (
    CONTACT_ENDS,
    KINK,
    NO_EVENT,
    ONSET,
    SLIDING_ENDS,
    STICKING_ENDS,
)
from tests.kernel.rubbing import rubbing_chain


@pytest.fixture
def d():
    """Return a chain with marks at two candidates, at an element with friction and at an element without."""
    _, d, _ = rubbing_chain(np.random.default_rng(5), "free", 2, True)
    marks.mark_contact_event(d, 2, KINK)
    marks.mark_contact_event(d, 5, CONTACT_ENDS)
    listed = int(d.friction_element.index[1])
    marks.mark_mode_change(d, listed, STICKING_ENDS)
    marks.mark_mode_change(
        d, next(e for e in range(d.friction_element_count) if e not in d.friction_element.index), SLIDING_ENDS
    )
    return d


def marks_of(d):
    return np.flatnonzero(d.contacts.event).tolist(), int(np.count_nonzero(d.friction_element.event))


def test_each_mark_is_that_of_one_candidate_or_element(d):
    assert marks_of(d) == ([2, 5], 2)
    assert (d.contacts.event[2], d.contacts.event[5]) == (KINK, CONTACT_ENDS)
    marks.mark_contact_event(d, 2, NO_EVENT)
    assert marks_of(d) == ([5], 2)


@pytest.mark.parametrize(
    ("drop", "left"),
    [
        (marks.drop_events, ([], 0)),
        (marks.drop_contact_events, ([], 2)),
        (marks.drop_mode_marks, ([2, 5], 0)),
    ],
)
def test_marks_are_dropped_also_where_there_is_no_friction_any_more(d, drop, left):
    drop(d)
    assert marks_of(d) == left


def test_only_an_onset_is_one(d):
    assert not marks.ends_in_onset(d)
    marks.mark_contact_event(d, 7, ONSET)
    assert marks.ends_in_onset(d)


def test_changes_of_elements_without_friction_do_not_count(d):
    assert marks.count_mode_changes(d) == 1


def test_a_tangent_instance_has_the_same_marks(d):
    _, t, _ = rubbing_chain(np.random.default_rng(5), "free", 2, True)
    marks.mark_contact_event(t, 1, CONTACT_ENDS)
    marks.copy_marks(d, t)
    assert t.contacts.event.tolist() == d.contacts.event.tolist()
    assert t.friction_element.event.tolist() == d.friction_element.event.tolist()

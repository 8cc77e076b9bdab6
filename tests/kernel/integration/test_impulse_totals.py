"""The impulses of the walls beside a step: from the stages to the totals, for the active contacts."""

import numpy as np
import pytest

from chain_impact.kernel.chain.state import time_at
from chain_impact.kernel.integration.dense import DENSE_COEFFICIENTS, interpolate_component
from chain_impact.kernel.integration.impulse import (
    append_impulses,
    commit_impulses,
    give_impulses,
    impulse_count,
    impulse_within,
    reset_impulse_step,
    roll_back_impulses,
    set_impulse_stage,
    set_impulse_stage_at_end,
    settle_impulses,
    truncate_impulses,
)
from chain_impact.kernel.model.contact import keep_end_forces
from tests.kernel.chains import chain, touch
from tests.plain import make_rigid

TOUCHED = [1, 3]
FIELDS = ("state", "state_end", "tried", "total", "onset")


@pytest.fixture
def d():
    """Two contacts whose impulses, forces and stages are all different."""
    rng = np.random.default_rng(13)
    _, d = chain(rng, 2)
    touch(d, TOUCHED)
    d.impulse.wanted = 1
    for name in FIELDS:
        d.impulse[name][:] = rng.uniform(1.0, 9.0, d.candidates)
    d.impulse.dense[:], d.impulse.stage[:] = (
        rng.uniform(1.0, 9.0, part.shape) for part in (d.impulse.dense, d.impulse.stage)
    )
    d.touch.force[:], d.touch.force_end[:] = rng.uniform(1.0, 9.0, (2, d.candidates))
    d.work.stage[:] = rng.uniform(0.1, 0.9, d.work.stage.shape)
    return d


def values(d, *names):
    return [d.impulse[name][:2].tolist() for name in names]


def test_they_are_those_of_the_active_contacts_if_they_are_wanted(d):
    assert impulse_count(d) == 2
    touch(d, [2])
    assert impulse_count(d) == 1
    d.impulse.wanted = 0
    assert impulse_count(d) == 0


@pytest.mark.parametrize(
    ("function", "forces"), [(set_impulse_stage, "force"), (set_impulse_stage_at_end, "force_end")]
)
def test_a_stage_is_the_force_in_the_variable_of_the_step(d, function, forces):
    """dp/ds = F dt/ds."""
    before = d.impulse.stage.copy()
    function(d, 4)
    right = d.touch[forces][TOUCHED] * d.work.stage[4, time_at(2)]
    assert d.impulse.stage[4, :2].tolist() == right.tolist()
    before[4, :2] = right
    assert d.impulse.stage.tolist() == before.tolist()


def test_the_forces_at_the_end_are_kept_of_the_active_contacts(d):
    before = d.touch.force_end.copy()
    d.impulse.wanted = 0  # other parts of the solver need them, too
    keep_end_forces(d)
    before[TOUCHED] = d.touch.force[TOUCHED]
    assert d.touch.force_end.tolist() == before.tolist()


def test_an_accepted_step_begins_where_the_last_one_ended(d):
    end, tried = values(d, "state_end", "tried")
    append_impulses(d)
    assert values(d, "state", "state_end") == [end, tried]


def test_a_step_that_is_dropped_leaves_the_impulses_of_its_start(d):
    (start,) = values(d, "state")
    roll_back_impulses(d)
    assert values(d, "state", "state_end") == [start, start]


def test_a_step_that_is_cut_ends_with_the_impulses_there(d):
    right = [interpolate_component(d.impulse, 0.3, k) for k in range(2)]
    truncate_impulses(d, 0.3)
    assert values(d, "state_end") == [right]


def test_totals_are_those_at_the_end_of_the_step(d):
    before = d.impulse.total.copy()
    commit_impulses(d)
    before[TOUCHED] = d.impulse.state_end[:2]
    assert d.impulse.total.tolist() == before.tolist()


def test_one_that_has_fallen_stays_as_it_was(d):
    d.impulse.state[:2], d.impulse.state_end[:2] = (5.0, 5.0), (4.9, 5.5)
    settle_impulses(d)
    assert values(d, "state_end") == [[5.0, 5.5]]


def test_of_points_that_a_rigid_wall_holds_the_sum_stays(d):
    make_rigid(d)
    d.candidate.wall[TOUCHED] = 2
    d.impulse.state[:2], d.impulse.state_end[:2] = (5.0, 1.0), (4.0, 3.0)
    settle_impulses(d)
    assert values(d, "state_end") == [[5.0, 2.0]]
    # never by more than the other one has been given
    d.impulse.state_end[:2] = 4.0, 1.5
    settle_impulses(d)
    assert values(d, "state_end") == [[5.0, 1.0]]
    # stops of other joints have nothing to do with it
    d.candidate.stop[TOUCHED], d.impulse.state_end[:2] = 1, (4.0, 3.0)
    settle_impulses(d)
    assert values(d, "state_end") == [[5.0, 3.0]]
    # nor have other walls
    d.candidate.stop[TOUCHED] = 0
    d.candidate.wall[TOUCHED] = 2, 3
    d.impulse.state_end[:2] = 4.0, 3.0
    settle_impulses(d)
    assert values(d, "state_end") == [[5.0, 3.0]]


@pytest.mark.parametrize("kept", [1.0, 0.7])
def test_a_course_that_falls_is_below_all_that_follows(d, kept):
    """3 θ² − 2 θ³ rises slowly at first, and here it falls before that."""
    thetas = np.linspace(0.0, kept, 71)
    d.impulse.dense[:, 0], d.step.kept = 0.0, kept
    d.impulse.dense[:3, 0], d.impulse.state[0] = (1.0, -1.9, 2.0), 3.0
    d.impulse.state_end[0] = interpolate_component(d.impulse, kept, 0)
    dense = np.array([interpolate_component(d.impulse, theta, 0) for theta in thetas])
    course = np.array([impulse_within(d, theta, 0) for theta in thetas])
    assert np.diff(dense).min() < -1e-3
    assert np.diff(course).min() >= 0.0
    assert (course[0], course[-1]) == (3.0, d.impulse.state_end[0])
    assert np.abs(course - np.maximum(3.0, dense)).max() <= np.abs(dense - dense.clip(3.0)).max()


def test_a_new_phase_starts_from_the_totals(d):
    total = d.impulse.total[TOUCHED].tolist()
    reset_impulse_step(d)
    assert values(d, "state", "state_end") == [total, total]
    assert d.impulse.dense.shape[0] == DENSE_COEFFICIENTS
    assert not d.impulse.dense[:, :2].any()
    assert d.impulse.dense[:, 2:].all()


@pytest.mark.parametrize(
    "function", [append_impulses, roll_back_impulses, commit_impulses, reset_impulse_step]
)
def test_without_them_nothing_is_done(d, function):
    d.impulse.wanted = 0
    before = d._record.tobytes()
    function(d)
    assert d._record.tobytes() == before


def test_rigid_walls_give_their_impulses_at_once_and_none_that_pulls(d):
    make_rigid(d)
    d.rigid.impulse[:2] = 2.5, -1e-17
    right = d.impulse.total.copy()
    right[TOUCHED[0]] += 2.5
    give_impulses(d)
    assert d.impulse.total.tolist() == right.tolist()


def test_contacts_with_a_force_are_given_no_impulse_at_once(d):
    make_rigid(d, np.arange(d.candidates) == TOUCHED[1])
    d.impulse.onset[:] = 0.0
    before = d.impulse.total.copy()
    d.rigid.impulse[:2] = 7.0, 2.0
    give_impulses(d)
    before[TOUCHED[1]] += 2.0
    assert d.impulse.total.tolist() == before.tolist()

"""What is done with the instances of dual numbers behind an instance, one after the other."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.status import NOT_FINITE, OK
from chain_impact.kernel.tangent import entry
from chain_impact.kernel.tangent.directions import DIRECTIONS
from chain_impact.kernel.tangent.entry import (
    all_valid,
    forget_slopes,
    observe_all,
    replay_all,
    truncate_all,
)

SIZES = {"links": 2, "candidates": 6, "elements": 8}
WIDE, LOOKS, BLOCKS = 1 + DIRECTIONS, 4, 2


def output(words):
    return SimpleNamespace(words=words)


@pytest.fixture
def d():
    """An instance with four outputs, and two of dual numbers behind it: each number is told by its place."""
    one = SimpleNamespace(tangents=BLOCKS, **SIZES, output=output(np.arange(4.0)))
    one.statistics = SimpleNamespace(status=OK)
    one.tangent_instances = [
        SimpleNamespace(**SIZES, output=output(1000.0 * (b + 1) + np.arange(LOOKS * WIDE)))
        for b in range(BLOCKS)
    ]
    return one


def test_slopes_are_forgotten_and_values_are_not():
    numbers = np.arange(2.0 * WIDE)
    forget_slopes(numbers)
    assert numbers[[0, WIDE]].tolist() == [0.0, WIDE]
    assert np.isnan(np.delete(numbers, [0, WIDE])).all()


@pytest.mark.parametrize("status", [OK, NOT_FINITE])
def test_after_a_fault_no_derivative_is_told_nor_one_that_is_not_trusted(d, status, monkeypatch):
    filled = []
    monkeypatch.setattr(entry, "fill_outputs", filled.append)
    monkeypatch.setattr(entry, "trusted", lambda t: t is d.tangent_instances[1])
    d.statistics.status = status
    observe_all(d)
    assert filled == d.tangent_instances
    for t, kept in zip(d.tangent_instances, (False, status == OK), strict=True):
        assert math.isnan(t.output.words[1]) != kept


def test_the_earliest_end_of_all_is_shared_by_all(d, monkeypatch):
    d.tangents = 3
    d.tangent_instances.append(SimpleNamespace())
    d.tangent_instances = [SimpleNamespace(end=end) for end in (5.0, 3.0, 4.0)]
    replayed = []
    monkeypatch.setattr(entry, "replay", lambda _, t: replayed.append(t))

    def share_reason(t, other):
        t.end = min(t.end, other.end)

    monkeypatch.setattr(entry, "share_reason", share_reason)
    replay_all(d)
    assert replayed == d.tangent_instances
    assert [t.end for t in d.tangent_instances] == [3.0, 3.0, 3.0]


def test_each_follows_its_contacts_and_then_its_end(d, monkeypatch):
    done = []
    monkeypatch.setattr(entry, "update_own_to_output_time", lambda t: done.append(("contacts", t)))
    monkeypatch.setattr(entry, "move_end", lambda t: done.append(("end", t)))
    monkeypatch.setattr(entry, "share_reasons", lambda d: done.append(("shared", d)))
    truncate_all(d)
    assert done[:-1] == [(what, t) for t in d.tangent_instances for what in ("contacts", "end")]
    assert done[-1] == ("shared", d)


@pytest.mark.parametrize("wrong", [0, 1])
@pytest.mark.parametrize("what", [*SIZES, "bounds"])
def test_one_that_is_not_valid_is_enough(d, wrong, what, monkeypatch):
    valid = [True, True]
    monkeypatch.setattr(entry, "within_bounds", lambda t: valid[t is d.tangent_instances[1]])
    assert all_valid(d)
    if what == "bounds":
        valid[wrong] = False
    else:
        setattr(d.tangent_instances[wrong], what, 7)
    assert not all_valid(d)

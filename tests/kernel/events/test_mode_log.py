"""The log of changes between sticking and sliding."""

# Tests: kernel/events/friction_modes.py

import numpy as np

from chain_impact.kernel.events.friction_modes import choose_friction_modes, log_changes
from chain_impact.kernel.record.constants import NO_FRICTION, STICKS
from tests.kernel.rubbing import AtRest


def test_changes_are_logged_with_their_place():
    chain = AtRest(0, "free", 2, True)
    d, (contact, other, *joints) = chain.d, chain.elements
    d.friction_element.mode_before[:], d.friction_changes.count = d.friction_element.mode, 0
    log_changes(d)
    assert d.friction_changes.count == 0
    d.step.end = 0.75
    d.friction_element.mode_before[contact], d.friction_element.mode[contact] = STICKS, -1
    d.friction_element.mode_before[joints[1]], d.friction_element.mode[joints[1]] = 1, STICKS
    d.friction_element.mode_before[other], d.friction_element.mode[other] = 1, NO_FRICTION
    log_changes(d)
    log = d.friction_changes
    rows = [(log.time[k], log.point[k], log.wall[k], log.mode[k]) for k in range(log.count)]
    point, wall = d.candidate.point, d.candidate.wall
    assert rows == [
        (0.75, point[contact], wall[contact], -1),
        (0.75, point[other], wall[other], NO_FRICTION),
        (0.75, 3, -1, STICKS),
    ]


def test_in_a_full_log_changes_take_the_place_of_the_oldest():
    chain = AtRest(0, "free", 2, True)
    d, log = chain.d, chain.d.friction_changes
    length = len(log.time)
    log.count, log.time[:] = length - 1, np.arange(length, dtype=float)
    d.step.end = 1e6
    d.friction_element.mode_before[:] = d.friction_element.mode
    for e in chain.elements[:3]:
        d.friction_element.mode_before[e] = 7
    log_changes(d)
    assert log.count == length + 2
    assert log.time[[0, 1, length - 1]].tolist() == [1e6] * 3
    assert log.time[2 : length - 1].tolist() == list(range(2, length - 1))


def test_a_choice_is_logged_at_the_end_of_the_step():
    chain = AtRest(1, "free", 2, True)
    d, before = chain.d, chain.modes
    d.step.end, d.friction_changes.count = 0.25, 0
    choose_friction_modes(d, True)
    changed = [k for k, modes in enumerate(zip(before, chain.modes, strict=True)) if len(set(modes)) > 1]
    assert d.friction_changes.count == len(changed) > 0
    assert d.friction_changes.mode[: len(changed)].tolist() == [chain.modes[k] for k in changed]
    assert (d.friction_changes.time[: len(changed)] == 0.25).all()

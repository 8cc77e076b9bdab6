"""The force on a contact that sticks alone, against that of the general constraints."""

import numpy as np
import pytest

from chain_impact.kernel.model import holding
from chain_impact.kernel.model.equations import free_rate
from chain_impact.kernel.model.friction import STICKS, list_sticking
from chain_impact.kernel.model.holding import add_constraint_forces, sticks_alone
from tests.kernel.rubbing import rubbing_chain
from tests.plain import make_rigid


def stuck_chain(base, contacts, joints, stuck):
    """A chain with friction of which the elements numbered ``stuck`` stick, in the order of their list."""
    _, d, y = rubbing_chain(np.random.default_rng(8), base, contacts, joints)
    for k in stuck:
        d.element.mode[d.element.index[k]] = STICKS
    list_sticking(d)
    return d, y


@pytest.mark.parametrize(
    ("contacts", "joints", "stuck", "alone"),
    [
        (1, False, [], False),
        (1, False, [0], True),
        (2, False, [0, 1], False),
        (2, False, [1], True),
        (1, True, [0], True),
        (1, True, [1], False),
        (1, True, [0, 1], False),
    ],
)
def test_one_contact_alone_sticks(contacts, joints, stuck, alone):
    d, _ = stuck_chain("free", contacts, joints, stuck)
    assert sticks_alone(d) == alone


def test_beside_a_rigid_wall_no_contact_sticks_alone():
    d, _ = stuck_chain("free", 2, False, [1])
    make_rigid(d, [c == d.touch.active_index[0] for c in range(d.candidates)])
    assert d.touch.compliant_count == 1
    assert not sticks_alone(d)


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize(("contacts", "stuck"), [(1, 0), (2, 0), (2, 1)])
def test_its_force_is_that_of_the_constraint(base, contacts, stuck, monkeypatch):
    results = []
    for alone in (sticks_alone, lambda _d: False):
        monkeypatch.setattr(holding, "sticks_alone", alone)
        d, y = stuck_chain(base, contacts, True, [stuck])
        rate = np.zeros(len(y))
        free_rate(d, y, rate)
        free = rate.copy()
        add_constraint_forces(d, y, rate)
        e = d.element.stuck[0]
        impulse = d.rigid.impulse[d.touch.active_count]
        results.append([*(rate - free), impulse, d.element.force[e], d.element.margin[e], d.friction.power])
    assert np.abs(results[0]).max() > 1.0
    np.testing.assert_allclose(results[1], results[0], rtol=1e-9, atol=1e-9)

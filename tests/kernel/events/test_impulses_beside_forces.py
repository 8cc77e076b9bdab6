"""What an impact changes of the contacts with a force that are active beside it."""

import numpy as np

from chain_impact.kernel.events import impulses
from chain_impact.kernel.events.impulses import follow_jump
from chain_impact.kernel.model.geometry import clearance
from tests.kernel.chains import chain, struck
from tests.plain import make_rigid


def test_contacts_with_a_force_take_the_rates_after_it_and_the_side_of_their_kink(monkeypatch):
    rng = np.random.default_rng(47)
    _, d = chain(rng, 2)
    touched, sides = [0, 5, 9], []
    y = struck(rng, d, touched)
    make_rigid(d, np.arange(d.candidates) == 5)
    d.step.state_end[:] = y
    d.work.velocity.x[:] = 1e9  # of before
    d.touch.speed[:], d.touch.force_rate[:] = 77.0, -5.0
    monkeypatch.setattr(impulses, "set_kink_side", lambda _, c: sides.append(int(c)))
    follow_jump(d)
    assert sides == [0, 9]
    for c in touched:
        if c in sides:
            assert d.touch.speed[c] == -clearance(d, c)[1]
            assert abs(d.touch.speed[c]) < 1e3
            assert d.touch.force_rate[c] == 1.0
        else:
            assert (d.touch.speed[c], d.touch.force_rate[c]) == (77.0, -5.0)

"""Random scenes at rest: the run reaches its end, and the state stays constant (tests/helpers/resting.py)."""

import pytest

from chain_impact.kernel.status import OK
from tests.helpers.resting import KINDS, LONG, SHORT, run, scene

# Allowed change of the energy balance over the energies in the last quarter of a run at rest: round-off, or a
# thousandth of the tolerance's budget for one step.
RESTS, SHARE = 1e-12, 1e-3


def check_rest(found):
    """Check that no run ends early, and that the energy of a chain at rest stays the same."""
    assert [one for one in found if one.status != OK] == []
    for one in found:
        assert not one.rests or one.drift < RESTS + SHARE * scene(one.kind, one.seed).solver.tolerance


@pytest.mark.parametrize("kind", KINDS)
def test_chains_that_rest_go_on_to_rest(kind):
    check_rest([run(kind, seed, SHORT) for seed in range(8)])


CHATTERED = {
    "rigid_drop": (2, 113, 584, 2400),
    "rigid_pendulum": (1611,),
    "rod_on_slope": (1407,),
    "sprung_stops": (22, 77, 934, 1717),
}


@pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for kind in CHATTERED for seed in CHATTERED[kind]])
def test_chains_that_chattered_come_to_rest(kind, seed):
    """The causes were alternating impacts, joints sticking at stops, and interpolants of implicit steps."""
    assert run(kind, seed, SHORT).status == OK


@pytest.mark.parametrize("kind", ["pendulum", "double_pendulum", "rigid_pendulum"])
def test_an_hour_of_rest_is_held(kind):
    found = [run(kind, seed, LONG) for seed in range(20)]
    assert sum(one.rests for one in found) > 8
    check_rest(found)

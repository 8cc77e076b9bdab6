"""Conservation of energy and momenta in flight and impacts."""

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.kernel.record.constants import SOLVER_METHODS
from tests.helpers.models.reference import momenta
from tests.helpers.scenes.problems import GRAVITY, default_scene, of_law, rod, tumbling_chain


def balance(result):
    """Return the conserved quantity: present energy plus dissipated energy minus supplied energy."""
    energy = result.energy
    return energy["total"] + energy["dissipated"] - energy["supplied"]


# --- flight ------------------------------------------------------------------------------------------------


def test_a_tumbling_chain_keeps_energy_and_momenta_for_ten_seconds():
    result = simulate(tumbling_chain(stop_time=10.0, tolerance=1e-10))
    momentum, spin = momenta(result)
    mass = sum(link.mass for link in result.scene.chain.links)
    momentum[:, 1] += mass * GRAVITY * result.time
    for quantity in (result.energy["total"], momentum[:, 0], momentum[:, 1], spin):
        assert np.ptp(quantity) < 1e-9 * max(abs(quantity[0]), 1.0)


def test_energy_drift_falls_with_the_tolerance():
    drifts = [np.ptp(simulate(tumbling_chain(2.0, tol)).energy["total"]) for tol in (1e-4, 1e-6, 1e-8, 1e-10)]
    assert drifts == sorted(drifts, reverse=True)
    assert drifts[-1] < 1e-4 * drifts[0]


# --- energy ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_energy_never_rises_and_the_energy_balance_closes(law):
    result = simulate(default_scene(**of_law(law)), stop_time=2.0, tolerance=1e-10)
    energy, start = result.energy, result.energy["total"][0]
    assert start == pytest.approx(61.6630096858, abs=1e-9)
    assert len(result.impacts) >= 5
    assert (np.diff(energy["total"]) < 1e-8 * start).all()
    assert (
        np.diff(energy["dissipated"]) >= -1e-11 * start
    ).all()  # dissipated energy may fall by round-off only
    assert (result.outputs["force"] >= 0.0).all()
    assert np.ptp(balance(result)) < 1e-6 * start


@pytest.mark.parametrize("method", SOLVER_METHODS)
def test_the_energy_balance_closes_when_the_force_ends_before_the_contact(method):
    """A rod's end leaves a soft, damped wall faster than the wall recovers: no force, but stored energy."""
    scene = rod(1.0, 1.0, 0.0, gravity=GRAVITY, stop_time=0.55, restitution=0.25, stiffness=1e4)
    result = simulate(scene, tolerance=1e-10, output_step=1e-4, method=method)
    outputs = result.outputs
    assert ((outputs["penetration"] > 1e-3) & (outputs["force"] == 0.0)).any()
    assert np.ptp(balance(result)) < 1e-7 * balance(result)[0]

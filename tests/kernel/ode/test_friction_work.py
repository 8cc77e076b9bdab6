"""The work of dry friction along the motion that an implicit step has found."""

import numpy as np
import pytest

from chain_impact.kernel.ode.friction_work import correct_friction_energy, store_friction_forces, work_along
from chain_impact.kernel.ode.radau import Q
from chain_impact.kernel.record.constants import RADAU_STAGES, STICKS
from chain_impact.kernel.record.state import dissipated_at, velocity_at
from tests.kernel.rubbing import rubbing_chain, tangents

H = 0.1  # s


@pytest.fixture
def rubbing():
    """Return random numbers, an instance, its sliding elements, and the gradients of their places."""
    rng = np.random.default_rng(23)
    scene, d, y = rubbing_chain(rng, "free", 2, True)
    elements = d.friction_element.index[: d.friction.active_count].copy()
    return rng, d, elements, tangents(scene, d, y, elements)


@pytest.mark.parametrize("speed", [0.0, 0.4])
def test_only_the_corrected_motion_dissipates_whatever_the_rates_contain(rubbing, speed):
    """The stages have other forces and speeds when their rates are evaluated."""
    rng, d, elements, slopes = rubbing
    lost, first, count = dissipated_at(d.link_count), velocity_at(d.link_count), slopes.shape[1]
    d.implicit.z_start[:] = d.implicit.stages[:] = 0.0
    expected = np.zeros(RADAU_STAGES)
    for m in range(RADAU_STAGES):
        moved, corrected = rng.normal(size=(2, count))
        d.friction_element.force[elements] = rng.normal(size=len(elements))
        store_friction_forces(d, m)
        d.implicit.rates[m, :count] = moved
        d.implicit.stages[m, first : first + count] = speed * corrected
        d.implicit.rates[m, lost] = -d.friction_element.force[elements] @ slopes @ moved
        expected[m] = -speed * d.friction_element.force[elements] @ slopes @ corrected
    d.implicit.stages[:, lost] = H * np.array(Q) @ d.implicit.rates[:, lost]
    correct_friction_energy(d, H)
    assert d.implicit.stages[:, lost] == pytest.approx(H * np.array(Q) @ expected, rel=1e-9, abs=1e-14)


def test_the_work_along_a_change_is_that_of_sliding_and_sticking_elements(rubbing):
    rng, d, elements, slopes = rubbing
    e = d.friction_element.stuck_index[0] = elements[1]
    d.friction_element.mode[e], d.friction.stuck_count = STICKS, 1
    change, d.friction_element.force[elements] = (
        rng.normal(size=slopes.shape[1]),
        rng.normal(size=len(elements)),
    )
    assert work_along(d, change) == pytest.approx(
        d.friction_element.force[elements] @ slopes @ change, rel=1e-9
    )

"""The state vector: each entry has one meaning, and none is left over."""

import numpy as np
import pytest

from chain_impact.kernel.chain.state import (
    ANGLES,
    coordinate_count,
    dissipated_at,
    omega_at,
    state_size,
    sundman_u_at,
    supplied_at,
    time_at,
    velocity_at,
)
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.status import OK
from tests.kernel.chains import chain


@pytest.mark.parametrize("count", [1, 2, 7])
def test_the_places_of_all_quantities_make_up_the_state(count):
    """y = (x₀, θ, ẋ₀, ω, dissipated, supplied, u, t)."""
    coordinates = [*range(2), *range(ANGLES, ANGLES + count)]
    rates = [*range(velocity_at(count), velocity_at(count) + 2)]
    rates += range(omega_at(count), omega_at(count) + count)
    last = [place(count) for place in (dissipated_at, supplied_at, sundman_u_at, time_at)]
    assert [*coordinates, *rates, *last] == list(range(state_size(count)))
    assert len(coordinates) == len(rates) == coordinate_count(count)


@pytest.mark.parametrize("count", [1, 2, 7])
def test_the_initial_values_have_their_places(count):
    rng = np.random.default_rng(count)
    _, d = chain(rng, count)
    values = {name: rng.normal(size=len(d.initial[name])) for name in d.initial._record.dtype.names}
    for name, value in values.items():
        d.initial[name][:] = value
    d.step.state[:] = d.work.y[:] = 7.0  # of another run
    assert initialize(d, 2.5) == OK
    expected = [*values["position"], *values["angle"], *values["velocity"], *values["angular_velocity"]]
    np.testing.assert_array_equal(d.step.state, [*expected, 0.0, 0.0, 1.0, 0.0])
    np.testing.assert_array_equal(d.step.state_end, d.step.state)

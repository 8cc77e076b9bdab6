"""The state vector: each entry has one meaning, and no entry is unused."""

# Tests: kernel/record/state.py

import pytest

from chain_impact.kernel.record.state import (
    FIRST_ANGLE,
    coordinate_count,
    dissipated_at,
    omega_at,
    state_length,
    sundman_u_at,
    supplied_at,
    time_at,
    velocity_at,
)


@pytest.mark.parametrize("count", [1, 2, 7])
def test_the_places_of_all_quantities_make_up_the_state(count):
    """y = (x₀, θ, ẋ₀, ω, dissipated, supplied, u, t)."""
    coordinates = [*range(2), *range(FIRST_ANGLE, FIRST_ANGLE + count)]
    rates = [*range(velocity_at(count), velocity_at(count) + 2)]
    rates += range(omega_at(count), omega_at(count) + count)
    last = [place(count) for place in (dissipated_at, supplied_at, sundman_u_at, time_at)]
    assert [*coordinates, *rates, *last] == list(range(state_length(count)))
    assert len(coordinates) == len(rates) == coordinate_count(count)

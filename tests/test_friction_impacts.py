"""200 random impacts of one rod and two with friction: the kernel against the closed form of stiff walls.

Simulated at two stiffnesses and extrapolated, as the limit K → ∞ is approached as K^−2/5. It exists for every
strike with W positive definite, so none is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import scene_from_dict
from tests.coulomb_impact import Departure, Strike
from tests.struck import duration, extrapolated, limit, struck

COUNT = 200
SOFT, STIFF = 1e12, 1e13  # N/m^(3/2)
WITHIN, HALF_WITHIN = 3e-6, 1e-8  # of all impacts, and of half of them


@dataclass(frozen=True)
class Impact:
    """What arrives, the closed form of what follows, and the simulated one.

    Attributes:
        strike: what arrives.
        exact: the closed form.
        values: extrapolated impulse of the normal force and of friction [N·s], separation speed [m/s], energy
            that is lost [J].
        modes: of friction one after the other, at the larger stiffness: 0 sticks, ±1 slides along ±t.
    """

    strike: Strike
    exact: Departure
    values: np.ndarray
    modes: list[int]


def simulated(seed, stiffness):
    """The values of an impact at a stiffness, its modes, and what arrives."""
    table, strike, _ = struck(seed, stiffness)
    scene, stop = scene_from_dict(table, "struck"), duration(strike, stiffness)
    result = simulate(scene, tolerance=1e-12, stop_time=stop, output_step=stop)
    (impact,) = result.impacts
    assert impact["end"] < stop
    rubbed = result[f"contact[{impact['point']}].y_min.friction_impulse"][-1]
    lost = result["energy.dissipated"][-1]
    values = np.array([impact["impulse"], rubbed, impact["separation_speed"], lost])
    return values, result.stick_slip["mode"].tolist(), strike


@pytest.fixture(scope="module")
def impacts():
    found = []
    for seed in range(COUNT):
        (soft, _, _), (stiff, modes, strike) = (simulated(seed, stiffness) for stiffness in (SOFT, STIFF))
        found.append(Impact(strike, limit(seed), extrapolated(soft, stiff, STIFF / SOFT), modes))
    return found


def agree(found, exact, units):
    """Whether all agree within WITHIN of their units, and half of them within HALF_WITHIN."""
    off = np.abs(np.subtract(found, exact)) / units
    worst = int(off.argmax())
    assert off[worst] < WITHIN, f"seed {worst}: off by {off[worst]:.1e}"
    assert np.median(off) < HALF_WITHIN


@pytest.mark.full("takes long")
def test_impulses_are_those_of_the_closed_form(impacts):
    """Both within 3e-6 of the normal impulse."""
    units = [one.exact.normal for one in impacts]
    agree([one.values[0] for one in impacts], units, units)
    agree([one.values[1] for one in impacts], [one.exact.tangential for one in impacts], units)


@pytest.mark.full("takes long")
def test_separation_speeds_are_those_of_the_closed_form(impacts):
    """Within 3e-6 of the speed of approach."""
    exact, units = [one.exact.separation for one in impacts], [one.strike.approach for one in impacts]
    agree([one.values[2] for one in impacts], exact, units)


@pytest.mark.full("takes long")
def test_energies_that_are_lost_are_those_of_the_closed_form(impacts):
    """Within 3e-6 of ½ (normal impulse) (speed of approach); and none is made."""
    units = [0.5 * one.exact.normal * one.strike.approach for one in impacts]
    lost = [one.values[3] for one in impacts]
    agree(lost, [one.exact.dissipated for one in impacts], units)
    assert min(lost) > 0.0


def test_points_slide_stick_and_turn_round_as_in_the_closed_form(impacts):
    for seed, one in enumerate(impacts):
        sign = int(np.sign(one.strike.sliding))
        expected = [{"slip": sign, "stick": 0, "reverse": -sign}[phase] for phase in one.exact.phases]
        # at the end of a contact no force is left that could hold the point against centrifugal forces
        assert one.modes[: len(expected)] == expected, seed
    assert {one.exact.phases for one in impacts} == {("slip",), ("slip", "stick"), ("slip", "reverse")}

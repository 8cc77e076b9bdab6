"""The mode of a contact that begins without tangential speed, from the chain's mobility couplings."""

import math

import numpy as np
import pytest

from chain_impact.simulation.simulate import simulate
from tests.helpers.scenes.problems import build


def first_change(scene):
    """Return the first change of a mode, and the first impact."""
    result = simulate(scene)
    return result.stick_slip[0], result.impacts[0]


@pytest.mark.parametrize(("law", "exponent"), [("hertz", 1.5), ("tsuji", 1.5), ("kelvin_voigt", 1.0)])
@pytest.mark.parametrize("angle", [1.0472, 2.0944, -0.7])
@pytest.mark.parametrize("share", [0.97, 1.03])
def test_a_rod_that_falls_without_turning_sticks_if_friction_suffices(law, exponent, angle, share):
    """W_tn/W_tt = 3 sin θ cos θ/(1 + 3 sin² θ) for the end of a uniform rod."""
    sine, cosine = math.sin(angle), math.cos(angle)
    ratio = 3.0 * sine * cosine / (1.0 + 3.0 * sine * sine)
    contact = {"model": law, "exponent": exponent, "stiffness": 1e7, "friction": share * abs(ratio)}
    contact["restitution"] = 1.0 if law == "hertz" else 0.6
    start = {"position": [0.0, 1.3], "angles": [angle], "velocity": [0.0, -1.0]}
    links = [{"length": 1.0, "mass": 2.0}]
    scene = build("Rod", links, start, {"y_min": 0.0}, contact, gravity=9.81, stop_time=0.6)
    change, impact = first_change(scene)
    assert change["start"] == impact["onset"]
    assert change["point"] == impact["point"] == (0 if sine > 0.0 else 1)
    if share > 1.0:
        assert change["mode"] == 0
        return
    # the centre of mass falls on, so the foot slides outward; t = x along this floor
    under = cosine if sine > 0.0 else -cosine
    assert change["mode"] == -int(np.sign(under))


@pytest.mark.parametrize("friction", [0.2, 0.9])
def test_a_point_whose_couplings_vanish_sticks(friction):
    """All points of a horizontal falling rod move along the normal only."""
    contact = {"model": "hertz", "stiffness": 1e7, "restitution": 1.0, "friction": friction}
    start = {"position": [0.0, 0.5], "angles": [0.0], "velocity": [0.0, -1.0]}
    links = [{"length": 1.0, "mass": 2.0}]
    scene = build("Flat", links, start, {"y_min": 0.0}, contact, gravity=9.81, stop_time=0.3)
    result = simulate(scene)
    assert set(result.stick_slip["mode"].tolist()) == {0}

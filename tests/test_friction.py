"""Dry friction at walls and in joints, against closed forms and the independent simulation of coulomb.py."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import scene_from_dict
from tests.coulomb_problems import BODIES, SETTLED, held, oblique_ball, pushed_flat, sliding

LATE = np.array([0.3, 0.5, 0.8, 1.1, 1.5, 2.0])  # s, after a body has settled


def run(table, **options):
    return simulate(scene_from_dict(table, "friction"), **options)


def along(result, slope, of="point[0]", prefix=""):
    """The tangential coordinate of a point on a slope, or with the prefix v its speed."""
    return math.cos(slope) * result[f"{of}.{prefix}x"] + math.sin(slope) * result[f"{of}.{prefix}y"]


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(
    ("slope", "speed", "friction", "static_friction"),
    [(0.0, 2.0, 0.3, None), (0.3, 2.5, 0.5, 0.6), (0.3, 2.5, 0.2, None), (-0.4, -1.5, 0.25, 0.3)],
    ids=["stops on a floor", "stops on a slope", "slides back", "slides back down the other side"],
)
def test_a_body_slides_as_coulombs_law_makes_it(body, slope, speed, friction, static_friction):
    table, exact = sliding(BODIES[body], slope, speed, friction, static_friction=static_friction)
    result = run(table, output_step=0.01, tolerance=1e-11)
    rows = np.searchsorted(result.time, LATE - 1e-9)
    way, velocity = along(result, slope), along(result, slope, prefix="v")
    for row, time in zip(rows, result.time[rows], strict=True):
        # 1e-6: the body still settles, by damped oscillations
        assert velocity[row] == pytest.approx(exact.velocity(time), abs=2e-6)
        assert way[row] - way[0] == pytest.approx(exact.way(time), abs=2e-6)
        if abs(time - exact.stop) > 0.05:
            for point in BODIES[body].points:
                force = result[f"contact[{point}].ramp.friction_force"][row]
                assert force == pytest.approx(exact.friction_force(time), rel=1e-4)
    halts = [phase["start"] for phase in result.stick_slip if phase["mode"] == 0 and phase["start"] > SETTLED]
    if exact.sticks:
        assert halts[0] == pytest.approx(exact.stop, abs=1e-6)
        assert (np.abs(velocity[result.time > exact.stop + 0.01]) < 1e-15).all()


def test_the_time_of_a_stop_is_exact():
    """Once the rod has settled, v_t + µ ẏ falls at the rate µ g, so nothing but the event is in question."""
    table, exact = sliding(BODIES["rod"], 0.0, 6.0, 0.3, stop_time=2.5)
    table["contact"] |= {"restitution": 0.05}
    result = run(table, output_step=0.1, tolerance=1e-12)
    (stop,) = {float(phase["start"]) for phase in result.stick_slip if phase["mode"] == 0}
    assert stop == pytest.approx(exact.stop, abs=1e-9)


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10, 1e12])
def test_a_body_that_sticks_stays_for_an_hour(stiffness):
    slope = math.radians(20.0)
    table, forces = held(BODIES["rod"], slope, 0.5, stop_time=3600.0)
    table["contact"]["stiffness"] = stiffness
    result = run(table, output_step=36.0)
    way = along(result, slope)
    assert np.ptp(way[1:]) < 1e-12
    assert result.statistics["steps"] <= 3700
    # together they hold the weight; of their shares, 3,600 steps have changed the last digits at random
    first, second = (result[f"contact[{k}].ramp.friction_force"][-1] for k in (0, 1))
    assert first + second == pytest.approx(2.0 * forces.tangential, rel=1e-13)
    assert first == pytest.approx(forces.tangential, rel=5e-9)
    assert result["contact[1].ramp.sticking"][-1] == 1.0


@pytest.mark.parametrize("body", ["rod", "chain"])
def test_redundant_contacts_share_and_hold_through_ten_pushes(body):
    begin = 2.0 * SETTLED  # the depths then differ from those at rest by round-off
    table, inputs, exact = pushed_flat(BODIES[body], 0.4, 0.5, begin=begin)
    result = run(table, inputs=inputs, output_step=0.01, tolerance=1e-10)
    start = np.searchsorted(result.time, begin - 1e-9)
    moved = result["point[0].x"][start:] - result["point[0].x"][start]
    expected = [exact.at(time)[0] for time in result.time[start:]]
    np.testing.assert_allclose(moved, expected, rtol=0.0, atol=1e-13)
    changes = np.unique(np.round([time for time, _ in exact.changes()], 10))
    found = np.unique(
        np.round([one["start"] for one in result.stick_slip if one["start"] > SETTLED - 1e-3], 10)
    )
    assert len(found) == 20
    assert found == pytest.approx(changes, abs=1e-9)


@pytest.mark.parametrize("slide", [0.3, -2.0])
def test_an_oblique_ball_rebounds_as_its_impulses_say(slide):
    table, exact = oblique_ball(1.5, slide, 0.3)
    result = run(table, tolerance=1e-12)
    (impact,) = result.impacts
    assert impact["separation_speed"] == pytest.approx(exact.separation, rel=1e-8)
    assert impact["impulse"] == pytest.approx(exact.normal, rel=1e-8)
    assert result["point[0].vx"][-1] == pytest.approx(exact.sliding, abs=1e-9)
    assert result["contact[0].y_min.friction_impulse"][-1] == pytest.approx(exact.tangential, rel=1e-9)
    assert result["energy.friction"][-1] == pytest.approx(exact.lost_by_friction, rel=1e-9)
    lost = result["energy.dissipated"][-1] - result["energy.friction"][-1]
    assert lost == pytest.approx(exact.lost_by_damping, rel=1e-7)

"""Impacts: exact ones, their rigid limit, and several at once."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.scene.scene import SOLVER_METHODS, with_values
from tests.problems import (
    GRAVITY,
    clattering_rod,
    cornered_rod,
    default_scene,
    flat_chain,
    flat_rod,
    rod,
    struck_ball,
    struck_rod,
)
from tests.reference import exact_damping_factor, momenta, point_impact
from tests.turned import mirrored

# --- one impact --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [1e5, 1e8, 1e11])
def test_hertz_impact_has_the_textbook_depth_force_and_duration(stiffness):
    """δ = 1.09336 (m v²/K)^⅖, F = 1.14326 K (m v²/K)^⅗, T = 2.94328 δ/v."""
    mass, speed = 2.0, 1.5
    scene, _ = struck_ball(mass, speed, model="hertz", stiffness=stiffness)
    (impact,) = simulate(scene, tolerance=1e-10).impacts
    ratio = mass * speed**2 / stiffness
    assert impact["max_penetration"] == pytest.approx(1.0933620739 * ratio**0.4, rel=1e-6)
    assert impact["peak_force"] == pytest.approx(1.1432626298 * stiffness * ratio**0.6, rel=1e-6)
    duration = 2.9432751843 * 1.0933620739 * ratio**0.4 / speed
    assert impact["end"] - impact["onset"] == pytest.approx(duration, rel=1e-6)
    assert impact["separation_speed"] == pytest.approx(speed, rel=1e-6)


@pytest.mark.full("more cases", but=4)
@pytest.mark.parametrize("exponent", [1.0, 1.3, 2.0, 3.0])
@pytest.mark.parametrize("restitution", [0.3, 1.0])
def test_impact_is_exact_for_any_exponent(exponent, restitution):
    scene, exact = struck_ball(
        damping_factor=exact_damping_factor(restitution), exponent=exponent, restitution=restitution
    )
    result = simulate(scene)
    (impact,) = result.impacts
    assert impact["max_penetration"] == pytest.approx(exact.max_penetration, rel=1e-7)
    assert impact["peak_force"] == pytest.approx(exact.peak_force, rel=1e-7)
    assert impact["end"] - impact["onset"] == pytest.approx(exact.duration, rel=1e-7)
    assert impact["separation_speed"] == pytest.approx(exact.separation_speed, rel=1e-7)
    assert result.energy["dissipated"][-1] == pytest.approx(exact.dissipated, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_every_method_keeps_its_tolerance_in_an_impact(method, tolerance):
    scene, exact = struck_ball(damping_factor=exact_damping_factor(0.7))
    (impact,) = simulate(scene, method=method, tolerance=tolerance).impacts
    for name in ("max_penetration", "peak_force", "separation_speed"):
        assert impact[name] == pytest.approx(getattr(exact, name), rel=30 * tolerance)


def test_time_series_shows_the_impact_that_the_list_tells_of():
    scene, exact = struck_ball(damping_factor=exact_damping_factor(0.7))
    result = simulate(scene, output_step=exact.duration / 1000)
    (impact,) = result.impacts
    inside = (result.time > impact["onset"]) & (result.time < impact["end"])
    force, depth = result.outputs["force"][:, 0], result.outputs["penetration"][:, 0]
    assert inside.sum() > 900
    assert (force[inside] > 0.0).all()
    assert (force[~inside] == 0.0).all()
    assert force.max() == pytest.approx(impact["peak_force"], rel=1e-4)
    assert depth.max() == pytest.approx(impact["max_penetration"], rel=1e-4)
    # Newton: F = m a of the ball's centre, and no force acts beside it
    acceleration = result.outputs["point_acceleration"][:, 0]
    np.testing.assert_allclose(acceleration[:, 1], force, rtol=0, atol=1e-9 * force.max())


@pytest.mark.parametrize("part", [0.1, 0.3, 0.7])
def test_an_unfinished_contact_tells_its_peaks_so_far(part):
    scene, exact = struck_ball(damping_factor=exact_damping_factor(0.7))
    result = simulate(scene, stop_time=1e-3 + part * exact.duration, output_step=1e-6)
    (impact,) = result.impacts
    assert math.isnan(impact["end"])
    assert math.isnan(impact["separation_speed"])
    assert impact["max_penetration"] == pytest.approx(result.outputs["penetration"].max(), rel=1e-5)
    assert impact["peak_force"] == pytest.approx(result.outputs["force"].max(), rel=1e-5)


@pytest.mark.parametrize("tilt", [-0.7, 0.2, 0.5, 1.2, 1.5])
def test_effective_mass_of_a_rods_end(tilt):
    scene, exact = struck_rod(tilt, 0.7, 1e8)
    impact = simulate(scene).impacts[0]
    assert impact["effective_mass"] == pytest.approx(exact.effective_mass, rel=1e-12)


def test_a_frictionless_wall_takes_normal_momentum_only():
    scene = rod(0.5, 1e-3, spin=2.0, stop_time=0.02)
    scene = with_values(scene, {("initial", "velocity"): (0.8, scene.initial.velocity[1])})
    result = simulate(scene)
    assert len(result.impacts) == 1
    momentum, _ = momenta(result)
    assert np.ptp(momentum[:, 0]) < 1e-10
    assert np.ptp(momentum[:, 1]) > 0.1


# --- the rigid limit ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("tilt", "restitution"), [(0.5, 0.7), (0.5, 0.3), (-1.1, 1.0)])
def test_rigid_limit_of_a_rods_end_is_approached_as_stiffness_to_the_minus_two_fifths(tilt, restitution):
    stiffness, errors = np.array([1e6, 1e8, 1e10, 1e12]), []
    for k in stiffness:
        scene, exact = struck_rod(tilt, restitution, k)
        result = simulate(scene)
        momentum, _ = momenta(result)
        base = exact.spin if tilt > 0 else -exact.spin  # which end is hit
        errors.append((abs(result.angular_velocities[-1, 0] - base), abs(momentum[-1, 1] - exact.speed)))
        assert result.statistics["steps"] < 60  # the cost does not depend on the stiffness
    for column in np.transpose(errors):
        slope = np.polyfit(np.log(stiffness), np.log(column), 1)[0]
        assert slope == pytest.approx(-0.4, abs=0.01)


# --- several at once ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9])
def test_a_flat_rod_rebounds_like_a_point_and_does_not_turn(restitution):
    result = simulate(flat_rod(restitution=restitution))
    assert len(result.impacts) == 2
    np.testing.assert_allclose(result.impacts["separation_speed"], restitution, rtol=1e-7)
    assert np.abs(result.angular_velocities).max() < 1e-12


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 1.0])
def test_the_second_end_of_a_clattering_rod_arrives_faster(restitution):
    scene, speed = clattering_rod(restitution)
    impacts = simulate(scene).impacts
    assert impacts["point"][:2].tolist() == [0, 1]
    assert impacts["end"][0] < impacts["onset"][1]
    assert impacts["impact_speed"][1] == pytest.approx(speed, rel=1e-6)


def test_a_small_tilt_makes_a_small_difference():
    """From 1e-10 rad, where the two contacts all but coincide, the outcome tends to that of the flat rod."""
    spins = [abs(simulate(flat_rod(tilt)).angular_velocities[-1, 0]) for tilt in (1e-10, 1e-9, 1e-8, 1e-7)]
    ratios = np.array(spins) / spins[0]
    np.testing.assert_allclose(ratios, [1.0, 10.0, 100.0, 1000.0], rtol=1e-2)
    assert spins[-1] < 1e-2


@pytest.mark.parametrize("restitution", [0.1, 0.7, 1.0])
def test_a_rod_returns_from_a_corner_as_it_came(restitution):
    result = simulate(cornered_rod(restitution))
    assert len(result.impacts) == 2
    back = result.outputs["point_velocity"][-1]
    np.testing.assert_allclose(back, restitution * math.sqrt(0.5), rtol=1e-7)
    assert np.abs(result.angular_velocities).max() < 1e-12


def test_a_flat_chain_on_five_points_stays_symmetric():
    result = simulate(flat_chain(0.01, restitution=0.3), stop_time=0.3)
    assert len(result.impacts) >= 10
    heights = result.points[..., 1]
    np.testing.assert_allclose(heights, heights[:, ::-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(result.points[:, 2, 0], 1.0, rtol=0, atol=1e-9)
    places = result.points[..., 0] - 1.0
    np.testing.assert_allclose(places, -places[:, ::-1], rtol=0, atol=1e-9)


def test_a_mirrored_scene_has_a_mirrored_result():
    scene = with_values(default_scene(), {("gravity",): (1.5, -9.81)})
    here, there = simulate(scene, 0.7), simulate(mirrored(scene), 0.7)
    assert len(here.impacts) >= 2
    np.testing.assert_allclose(there.points * [-1.0, 1.0], here.points, rtol=0, atol=1e-9)
    np.testing.assert_allclose(there.impacts["onset"], here.impacts["onset"], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(there.impacts["point"], here.impacts["point"])


@pytest.mark.parametrize("floor", [1e-1, 1e-3, 1e-6])
def test_a_second_hit_within_a_contact_is_no_explosion(floor):
    """One end rests, latched at a gentle speed; the other end falls and pushes the first into the floor."""
    scene = rod(0.3, 0.0, 0.0, gravity=GRAVITY, stop_time=1.0, restitution=0.5, minimum_impact_speed=floor)
    result = simulate(scene)
    impacts = result.impacts
    fall = impacts[impacts["point"] == 1][0]
    assert fall["impact_speed"] > 1.0
    assert (result.outputs["force"] >= 0.0).all()
    # no contact can be harder than the whole rod arriving at the speed of the falling end
    ratio = fall["impact_speed"] ** 2 / scene.contact.stiffness
    hardest = (1 + exact_damping_factor(0.5)) * 1.1432626298 * scene.contact.stiffness * ratio**0.6
    assert impacts["peak_force"].max() < hardest
    assert np.diff(result.energy["total"]).max() < 1e-8


# --- the default scene against one degree of freedom -------------------------------------------------------


@pytest.mark.parametrize(
    ("stiffness", "tolerance"),
    # the chain moves on while it is in contact, the less the shorter that is: as K^(−2/5)
    [(1e9, 0.03), (2.145e10, 0.01), (1e11, 0.005), (1e12, 0.002)],
)
def test_impacts_of_the_default_scene_are_those_of_their_effective_mass(stiffness, tolerance):
    """No two contacts overlap in it; where they do, as in the tests above, none is that of a free mass."""
    result = simulate(default_scene(stiffness=stiffness), output_step=5e-5)
    impacts, dissipated = result.impacts[np.isfinite(result.impacts["end"])], result.energy["dissipated"]
    assert len(impacts) > 8
    assert (impacts["end"][:-1] < impacts["onset"][1:]).all()
    factor = exact_damping_factor(0.7)
    for impact in impacts:
        exact = point_impact(impact["effective_mass"], impact["impact_speed"], stiffness, 1.5, factor)
        before, after = np.searchsorted(result.time, [impact["onset"], impact["end"]]) - [1, 0]
        found = {
            "separation_speed": impact["separation_speed"],
            "peak_force": impact["peak_force"],
            "max_penetration": impact["max_penetration"],
            "duration": impact["end"] - impact["onset"],
            "dissipated": dissipated[after] - dissipated[before],
        }
        for name, value in found.items():
            assert value == pytest.approx(getattr(exact, name), rel=tolerance), (name, impact)


def test_the_first_impact_deviates_from_its_effective_mass_as_stiffness_to_the_minus_two_fifths():
    stiffness, deviations, factor = np.array([1e8, 1e9, 1e10, 1e11]), [], exact_damping_factor(0.7)
    for k in stiffness:
        first = simulate(default_scene(stiffness=k), stop_time=0.51, tolerance=1e-11).impacts[0]
        exact = point_impact(first["effective_mass"], first["impact_speed"], k, 1.5, factor)
        found = [first[name] / getattr(exact, name) - 1 for name in ("separation_speed", "peak_force")]
        deviations.append([*found, (first["end"] - first["onset"]) / exact.duration - 1])
    for column in np.abs(deviations).T:
        assert np.polyfit(np.log(stiffness), np.log(column), 1)[0] == pytest.approx(-0.4, abs=0.03)

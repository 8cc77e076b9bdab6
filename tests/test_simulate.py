"""Whole simulations: conservation laws, exact impacts, rest, and what must never happen."""

import functools
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.kernel import status
from chain_impact.scene import SOLVER_METHODS, SceneError, with_values
from chain_impact.simulate import SimulationError
from tests.problems import (
    FAR,
    GRAVITY,
    ball,
    build,
    clattering_rod,
    contact_table,
    cornered_rod,
    default_scene,
    dropped_ball,
    exact_damping_factor,
    flat_chain,
    flat_rod,
    mirrored,
    newton_impact,
    rest_depth,
    rod,
    struck_ball,
    struck_rod,
    tumbling_chain,
)


def ledger(result):
    """What must stay constant: the energy that is there, was lost and was not put in."""
    energy = result.energy
    return energy["total"] + energy["dissipated"] - energy["supplied"]


def momenta(result):
    """Momentum, shape (T, 2), and angular momentum about the centre of mass, shape (T,), from the outputs."""
    links = result.scene.chain.links
    place, velocity, spin = 0.0, 0.0, 0.0
    mass = np.array([link.mass for link in links])
    centres, speeds = [], []
    for i, link in enumerate(links):
        part = link.center_of_mass / link.length
        for name, rows in (("point_position", centres), ("point_velocity", speeds)):
            points = result.outputs[name]
            rows.append(points[:, i] + part * (points[:, i + 1] - points[:, i]))
        spin = spin + link.inertia * result.angular_velocities[:, i]
    place = np.average(centres, axis=0, weights=mass)
    velocity = np.average(speeds, axis=0, weights=mass)
    for m, centre, speed in zip(mass, centres, speeds, strict=True):
        arm, motion = centre - place, speed - velocity
        spin = spin + m * (arm[:, 0] * motion[:, 1] - arm[:, 1] * motion[:, 0])
    return mass.sum() * velocity, spin


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


def test_outputs_agree_with_each_other():
    """Velocities are the rates of positions, accelerations those of velocities."""
    result = simulate(tumbling_chain(0.02), output_step=1e-5)
    outputs, dt = result.outputs, 2e-5
    pairs = [
        ("point_position", "point_velocity"),
        ("point_velocity", "point_acceleration"),
        ("angle", "angular_velocity"),
        ("angular_velocity", "angular_acceleration"),
    ]
    for value, rate in pairs:
        difference = (outputs[value][2:] - outputs[value][:-2]) / dt
        scale = np.abs(outputs[rate]).max()
        np.testing.assert_allclose(difference, outputs[rate][1:-1], rtol=0, atol=1e-6 * scale)


def test_a_pendulum_keeps_its_energy_and_its_pin():
    """A pinned rod that swings past a wall it does not reach."""
    scene = build(
        "Pendulum",
        [{"length": 1.0, "mass": 2.0}],
        {"position": [0.5, 0.25], "angles": [0.3]},
        {"y_max": FAR},
        contact_table(points=[1]),
        gravity=GRAVITY,
        base="pinned",
        stop_time=10.0,
    )
    result = simulate(scene)
    np.testing.assert_array_equal(result.points[:, 0], [[0.5, 0.25]] * len(result.time))
    assert np.ptp(result.energy["total"]) < 1e-8
    assert np.ptp(result.energy["kinetic"]) > 1.0


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


def test_rigid_limit_of_a_chain_is_newtons_impact():
    """The first impact of the default scene, against M⁻¹Jᵀ of the assembled equations."""
    stiffness, errors = np.array([1e7, 1e9, 1e11]), []
    for k in stiffness:
        scene = default_scene(stiffness=k)
        first = simulate(scene, stop_time=0.51, tolerance=1e-11).impacts[0]
        ends = [first["onset"], first["end"]]
        before, after = (simulate(scene, end, end, tolerance=1e-11).outputs[-1] for end in ends)
        velocity = [
            np.concatenate([row["point_velocity"][0], row["angular_velocity"]]) for row in (before, after)
        ]
        contact = int(first["point"]), ("x_min", "x_max", "y_min", "y_max")[first["wall"]]
        expected, effective = newton_impact(scene, before["angle"], velocity[0], contact, 0.7)
        assert first["effective_mass"] == pytest.approx(effective, rel=1e-10)
        errors.append(np.abs(velocity[1] - expected).max())
    assert errors[-1] < 1e-3 * np.abs(expected).max()
    assert np.polyfit(np.log(stiffness), np.log(errors), 1)[0] == pytest.approx(-0.4, abs=0.02)


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


# --- energy ------------------------------------------------------------------------------------------------


@functools.cache
def tumble(law):
    return simulate(default_scene(model=law), stop_time=2.0, tolerance=1e-10)


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_energy_never_rises(law):
    result = tumble(law)
    energy, start = result.energy, result.energy["total"][0]
    assert start == pytest.approx(61.6630096858, abs=1e-9)
    assert len(result.impacts) >= 5
    assert (np.diff(energy["total"]) < 1e-8 * start).all()
    assert (np.diff(energy["dissipated"]) >= 0.0).all()
    assert (result.outputs["force"] >= 0.0).all()


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_energy_ledger_closes(law):
    result = tumble(law)
    assert np.ptp(ledger(result)) < 1e-6 * ledger(result)[0]


def test_joint_damping_is_in_the_ledger():
    scene = default_scene()
    changes = {("chain", "links", i, "joint_damping"): 0.3 for i in range(4)}
    result = simulate(with_values(scene, changes), 0.6, tolerance=1e-10)
    flight = result.time < result.impacts["onset"][0]
    assert result.energy["dissipated"][flight][-1] > 0.01
    assert np.ptp(ledger(result)) < 1e-6 * ledger(result)[0]


@pytest.mark.parametrize("method", SOLVER_METHODS)
def test_ledger_closes_to_the_tolerance_when_the_force_ends_before_the_contact(method):
    """A rod's end leaves a soft, damped wall faster than its surface returns: no force, but depth to lose."""
    scene = rod(1.0, 1.0, 0.0, gravity=GRAVITY, stop_time=0.55, restitution=0.25, stiffness=1e4)
    result = simulate(scene, tolerance=1e-10, output_step=1e-4, method=method)
    outputs = result.outputs
    assert ((outputs["penetration"] > 1e-3) & (outputs["force"] == 0.0)).any()
    assert np.ptp(ledger(result)) < 1e-7 * ledger(result)[0]


# --- every method ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_every_method_keeps_its_tolerance_in_an_impact(method, tolerance):
    scene, exact = struck_ball(damping_factor=exact_damping_factor(0.7))
    (impact,) = simulate(scene, method=method, tolerance=tolerance).impacts
    for name in ("max_penetration", "peak_force", "separation_speed"):
        assert impact[name] == pytest.approx(getattr(exact, name), rel=30 * tolerance)


@pytest.mark.parametrize("method", SOLVER_METHODS)
def test_every_method_comes_to_the_same_result(method):
    expected = simulate(default_scene(), 0.7, 0.7, tolerance=1e-11, method="explicit")
    result = simulate(default_scene(), 0.7, 0.7, tolerance=1e-9, method=method)
    np.testing.assert_allclose(result.points, expected.points, rtol=0, atol=1e-6)
    assert len(result.impacts) == len(expected.impacts) >= 2
    np.testing.assert_allclose(result.impacts["onset"], expected.impacts["onset"], rtol=0, atol=1e-6)
    assert np.diff(result.energy["total"]).max() < 1e-6 * result.energy["total"][0]


# --- rest --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("restitution", "stop_time"), [(0.05, 2.0), (0.3, 4.0), (0.8, 6.0), (0.9, 11.0)])
def test_a_dropped_ball_comes_to_rest(restitution, stop_time):
    scene, drop = dropped_ball(stop_time=stop_time, restitution=restitution)
    result = simulate(scene)
    impacts, floor = result.impacts, scene.contact.minimum_impact_speed
    # each bounce is e times the last one; below the floor of v₀ there are none
    assert 2 <= len(impacts) <= math.log(drop.speed / floor) / -math.log(restitution) + 3
    done = impacts[:-1]
    # gravity acts for the time of the contact, too
    allowed = GRAVITY * (done["end"] - done["onset"])
    assert (abs(done["separation_speed"] - restitution * done["impact_speed"]) < allowed).all()
    np.testing.assert_allclose(impacts["impact_speed"][1:], impacts["separation_speed"][:-1], rtol=1e-8)
    # the last contact does not end
    assert np.isfinite(impacts["end"][:-1]).all()
    assert math.isnan(impacts["end"][-1])
    assert result.outputs["penetration"][-1, 0] == pytest.approx(rest_depth(scene), rel=1e-6)
    assert result.outputs["force"][-1, 0] == pytest.approx(GRAVITY, rel=1e-6)


@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("stiffness", [1e6, 1e10])
def test_every_method_finds_the_same_rest(method, stiffness):
    scene, _ = dropped_ball(0.01, stop_time=2.0, stiffness=stiffness, restitution=0.3)
    tolerance = 1e-10
    last = simulate(scene, tolerance=tolerance, method=method).outputs[-1]
    # errors of a depth may be as large as errors of speeds over the contact's frequency, v₀ over the depth
    allowed = 10 * tolerance / scene.contact.minimum_impact_speed
    assert last["penetration"][0] == pytest.approx(rest_depth(scene), rel=allowed)
    assert last["force"][0] == pytest.approx(GRAVITY, rel=10 * allowed)


@pytest.mark.parametrize("restitution", [0.05, 0.7])
def test_the_cost_of_rest_does_not_grow_with_the_stiffness(restitution):
    """Ten seconds, most of them at rest; the stiffer floor has more bounces on the way there."""
    cost = []
    for stiffness in (1e6, 1e12):
        scene = dropped_ball(0.01, stop_time=10.0, stiffness=stiffness, restitution=restitution)[0]
        one, ten = (simulate(scene, stop, tolerance=1e-6).statistics for stop in (2.0, 10.0))
        cost.append(ten["rhs_evaluations"] - one["rhs_evaluations"])
    assert max(cost) < 1000
    assert cost[1] <= 2 * cost[0]


@pytest.mark.parametrize("speed", [1e-8, 1e-6, 1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("restitution", [0.05, 0.7])
def test_the_gentlest_touch_down_comes_to_rest(speed, restitution):
    scene = ball(1e-12, speed, gravity=GRAVITY, stop_time=1.0, restitution=restitution)
    result = simulate(scene)
    for name in result.outputs.dtype.names:
        assert np.isfinite(result.outputs[name]).all()
    # a weight set at once upon K δⁿ presses it to δⁿ = (n+1) m g/K at most, damping apart: (5/2) m g
    assert (result.outputs["force"] >= 0.0).all()
    assert result.impacts["peak_force"].max() < 3.0 * GRAVITY
    assert result.statistics["steps"] < 50_000
    assert len(result.impacts) < 10
    assert result.outputs["penetration"][-1, 0] == pytest.approx(rest_depth(scene), rel=1e-6)


def test_a_rod_at_rest_leans_on_both_ends_alike():
    scene = rod(0.0, 0.01, 0.0, gravity=GRAVITY, stop_time=3.0, restitution=0.3)
    result = simulate(scene)
    last = result.outputs[-1]
    assert last["force"].sum() == pytest.approx(GRAVITY, rel=1e-6)
    depths = last["penetration"][last["force"] > 0]
    np.testing.assert_allclose(depths, rest_depth(scene, points=2), rtol=1e-6)


def test_a_tilted_rod_clatters_to_rest_and_the_floor_carries_its_weight():
    result = simulate(rod(0.2, 0.1, 0.0, gravity=GRAVITY, stop_time=4.0, restitution=0.3))
    assert result.outputs["force"][-1].sum() == pytest.approx(GRAVITY, rel=1e-5)
    np.testing.assert_allclose(result.outputs["force"][-1].max(), GRAVITY / 2, rtol=1e-5)


def test_a_chain_at_rest_shares_its_weight_among_five_points():
    """Each rod leans with half its weight on either end."""
    result = simulate(flat_chain(0.001, restitution=0.3), stop_time=3.0)
    forces = result.outputs["force"][-1].reshape(5, 4)[:, 2]
    np.testing.assert_allclose(forces / GRAVITY, [0.5, 1.0, 1.0, 1.0, 0.5], rtol=1e-5)


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


@pytest.mark.parametrize("part", [0.1, 0.3, 0.7])
def test_an_unfinished_contact_tells_its_peaks_so_far(part):
    scene, exact = struck_ball(damping_factor=exact_damping_factor(0.7))
    result = simulate(scene, stop_time=1e-3 + part * exact.duration, output_step=1e-6)
    (impact,) = result.impacts
    assert math.isnan(impact["end"])
    assert math.isnan(impact["separation_speed"])
    assert impact["max_penetration"] == pytest.approx(result.outputs["penetration"].max(), rel=1e-5)
    assert impact["peak_force"] == pytest.approx(result.outputs["force"].max(), rel=1e-5)


# --- the solver as its user sees it ------------------------------------------------------------------------


def test_the_output_step_changes_nothing():
    fine, coarse = (simulate(default_scene(), 2.0, step) for step in (1e-4, 0.37))
    assert fine.impacts.tobytes() == coarse.impacts.tobytes()
    assert fine.statistics == coarse.statistics
    np.testing.assert_array_equal(fine.outputs[-1].tobytes(), coarse.outputs[-1].tobytes())
    assert len(fine.impacts) >= 5


def test_a_simulation_is_repeatable_to_the_bit():
    first, second = (simulate(default_scene(), 0.5) for _ in range(2))
    assert first.outputs.tobytes() == second.outputs.tobytes()


def test_time_runs_to_the_stop_time_in_steps():
    result = simulate(ball(stop_time=1.0), 0.95, 0.1)
    np.testing.assert_allclose(result.time, [*np.arange(10) * 0.1, 0.95], rtol=0, atol=1e-15)
    result = simulate(ball(stop_time=1.0), 0.3, 0.1)
    np.testing.assert_allclose(result.time, [0.0, 0.1, 0.2, 0.3], rtol=0, atol=1e-15)


def test_many_impacts_are_all_collected_between_two_output_points():
    """More contacts than the log of the kernel holds, in one row of output: an elastic ball hops for ever."""
    scene, drop = dropped_ball(1e-3, stop_time=3.0, model="hertz", stiffness=1e10)
    result = simulate(scene, output_step=3.0)
    impacts = result.impacts
    assert len(result.time) == 2
    period = 2 * drop.onset + impacts["end"][0] - impacts["onset"][0]
    assert len(impacts) == 1 + math.floor((3.0 - drop.onset) / period) > 100
    expected = drop.onset + period * np.arange(len(impacts))
    np.testing.assert_allclose(impacts["onset"], expected, rtol=0, atol=1e-5)
    np.testing.assert_allclose(impacts["impact_speed"], drop.speed, rtol=1e-5)


def test_tighter_tolerance_converges_to_one_result():
    """Over the first impacts; later ones are for chaos."""
    results = [simulate(default_scene(), 0.6, 0.6, tolerance=tol) for tol in (1e-6, 1e-8, 1e-10, 1e-12)]
    errors = [np.abs(result.points[-1] - results[-1].points[-1]).max() for result in results[:-1]]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-7


def test_progress_rises_to_one():
    seen = []
    simulate(ball(stop_time=0.1), output_step=1e-6, progress=seen.append)
    assert len(seen) > 1
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_a_fault_on_the_way_carries_the_result_up_to_it():
    """A wall so stiff that the contact is shorter than the resolution of time: the ball is seen to arrive."""
    scene = ball(0.05, 1.0, stiffness=1e60, stop_time=0.1)
    with pytest.raises(SimulationError, match=r"stopped at t = 0\.05 s: ") as caught:
        simulate(scene, output_step=0.01)
    error = caught.value
    assert error.status in (status.NOT_FINITE, status.STEP_TOO_SMALL)
    assert error.time == pytest.approx(0.05, abs=1e-12)
    assert error.result.time[-1] == pytest.approx(0.05, abs=0.011)
    assert len(error.result.time) >= 5
    assert error.result.impacts["onset"].tolist() == [pytest.approx(0.05)]
    assert np.isfinite(error.result.points).all()
    assert error.result.statistics["status"] == error.status


@pytest.mark.parametrize("stiffness", [1e40, 1e200])
def test_a_wall_too_stiff_for_the_clock_is_a_fault_and_no_endless_loop(stiffness):
    """In a process of its own, as the kernel could not be interrupted."""
    program = (
        "from chain_impact import simulate; from tests.problems import ball\n"
        f"simulate(ball(0.05, 1.0, stiffness={stiffness}, stop_time=0.1))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program],
        check=False,
        cwd=Path(__file__).parents[1],
        timeout=10,
        capture_output=True,
        text=True,
    )
    assert "SimulationError: the simulation stopped at t = 0.05 s" in ran.stderr


def test_a_start_that_overflows_is_refused():
    scene = rod(0.0, 1.0, spin=1e200)
    with pytest.raises(SimulationError, match="no longer finite") as caught:
        simulate(scene)
    assert caught.value.result is None
    assert caught.value.time == 0.0


@pytest.mark.parametrize(
    "arguments", [{"stop_time": -1.0}, {"tolerance": 0.5}, {"method": "guess"}, {"output_step": 0.0}]
)
def test_arguments_out_of_range_are_refused(arguments):
    with pytest.raises(SceneError, match="must be"):
        simulate(ball(), **arguments)


# --- any scene ---------------------------------------------------------------------------------------------

LENGTHS = st.floats(0.1, 0.5)
ANGLES = st.floats(-math.pi, math.pi)


@st.composite
def boxed_chains(draw):
    """Four links of any kind and motion, in a box that they may outgrow when stretched."""
    links = [
        {
            "length": draw(LENGTHS),
            "mass": draw(st.floats(0.1, 5.0)),
            "center_of_mass": draw(st.floats(0.0, 0.5)),
            "inertia": draw(st.floats(1e-3, 0.2)),
            "joint_damping": draw(st.sampled_from([0.0, 0.05])),
        }
        for _ in range(4)
    ]
    law = draw(st.sampled_from([law for law in CONTACT_LAWS if law != "hertz"]))
    contact = contact_table(
        model=law,
        stiffness=10 ** draw(st.floats(4.0, 10.0)),
        exponent=draw(st.sampled_from([1.0, 1.5, 2.0])),
        restitution=draw(st.floats(0.05, 1.0)),
        radius=draw(st.sampled_from([0.0, 0.02])),
    )
    angles = draw(st.lists(ANGLES, min_size=4, max_size=4))
    lengths = [link["length"] for link in links]
    reach = np.cumsum([np.array(lengths) * f(angles) for f in (np.cos, np.sin)], axis=1)
    low, high = np.minimum(reach.min(axis=1), 0.0), np.maximum(reach.max(axis=1), 0.0)
    margin = draw(st.floats(0.05, 0.5)) + contact["radius"]
    box = {
        "x_min": low[0] - margin,
        "x_max": high[0] + margin,
        "y_min": low[1] - margin,
        "y_max": high[1] + margin,
    }
    initial = {
        "angles": angles,
        "velocity": draw(st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=2)),
        "angular_velocities": draw(st.lists(st.floats(-6.0, 6.0), min_size=4, max_size=4)),
    }
    return build("Any", links, initial, box, contact, gravity=GRAVITY, stop_time=0.3, tolerance=1e-9)


@given(boxed_chains())
@settings(max_examples=300, deadline=None, derandomize=True)
def test_any_scene_keeps_the_laws_of_physics(scene):
    result = simulate(scene)
    outputs, balance = result.outputs, ledger(result)
    for name in outputs.dtype.names:
        assert np.isfinite(outputs[name]).all()
    assert (outputs["force"] >= 0.0).all()
    scale = result.energy["kinetic"].max() + np.ptp(result.energy["potential"])
    assert np.ptp(balance) < 1e-5 * scale
    assert np.diff(result.energy["total"]).max() < 1e-6 * scale
    # nothing tunnels: who is beyond a wall is in contact, and no deeper than the energy there is can push it
    box, contact = scene.box, scene.contact
    sides = [(0, box.x_min), (0, -box.x_max), (1, box.y_min), (1, -box.y_max)]
    gaps = []
    for point in range(5):
        for wall, (axis, place) in enumerate(sides):
            sign = 1.0 - 2.0 * (wall % 2)
            gaps.append(sign * result.points[:, point, axis] - place - contact.radius)
    depths = np.maximum(0.0, -np.transpose(gaps))
    np.testing.assert_allclose(outputs["penetration"], depths, rtol=0, atol=1e-10)
    energy = contact.stiffness * depths ** (contact.exponent + 1) / (contact.exponent + 1)
    assert energy.max() <= scale * (1 + 1e-6)


DROPPED_RODS = st.builds(
    rod,
    tilt=ANGLES,
    lowest=st.floats(0.01, 1.0),
    speed=st.floats(-3.0, 3.0),
    spin=st.floats(-20.0, 20.0),
    gravity=st.just(GRAVITY),
    stop_time=st.just(0.6),
    restitution=st.floats(0.05, 1.0),
    stiffness=st.floats(4.0, 11.0).map(lambda power: 10.0**power),
)


@given(DROPPED_RODS)
@settings(max_examples=300, deadline=None, derandomize=True)
def test_any_rod_keeps_the_laws_of_physics(scene):
    result = simulate(scene)
    outputs = result.outputs
    assert (outputs["force"] >= 0.0).all()
    scale = result.energy["kinetic"].max() + np.ptp(result.energy["potential"])
    assert np.ptp(ledger(result)) < 1e-6 * scale
    momentum, _ = momenta(result)
    # no linear function of the state, so every step adds an error of up to the tolerance
    assert np.ptp(momentum[:, 0]) < 100 * scene.solver.tolerance * (1 + np.abs(momentum).max())

"""Sustained contact: what a chain does, and costs, when the scene goes quiet; and what wakes it."""

import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, SimulationError, load_scene, simulate
from chain_impact.kernel.status import TOO_MUCH_WORK
from chain_impact.scene.scene import SOLVER_METHODS, scene_from_dict, with_values
from chain_impact.simulation.instance import Instance
from tests.problems import FLOOR, GRAVITY, ball, dropped_ball, flat_chain, heap, of_law, rest_depth, rod
from tests.reference import balance

CHAIN = load_scene("four_link_box")
WEIGHT = 4 * 9.81


def quiet_chain(stiffness, restitution, method="auto"):
    """The default chain at tolerance 1e−6; it lies still after a few seconds."""
    values = {("contact", "stiffness"): stiffness, ("contact", "restitution"): restitution}
    values |= {("solver", "method"): method, ("solver", "tolerance"): 1e-6}
    return with_values(CHAIN, values)


def scene(links, angles, stop_time, walls, **tables):
    """A chain of links (length, mass), its base half a metre above the floor."""
    return scene_from_dict(
        {
            "name": "Torture",
            "chain": {"links": [{"length": length, "mass": mass} for length, mass in links]},
            "box": walls,
            "initial": {"position": [0.0, 0.5], "angles": angles},
            "simulation": {"stop_time": stop_time, "step_size": 1e-2},
            **tables,
        },
        "test",
    )


# ---- cost ---------------------------------------------------------------------------------------------

STEPS_PER_ONSET, STEPS_PER_SECOND = 40, 200


@pytest.mark.parametrize("restitution", [0.05, 0.3, 0.7])
@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10, 1e12])
def test_coming_to_rest_costs_a_bounded_number_of_steps(stiffness, restitution):
    instance = Instance(quiet_chain(stiffness, restitution))
    assert instance.advance(8.0) == 0
    before = instance.statistics
    assert instance.advance(10.0) == 0
    after = instance.statistics
    onsets = int(instance.record["impact"]["count"])
    assert after["steps"] <= STEPS_PER_ONSET * onsets + STEPS_PER_SECOND * 10
    assert after["rhs_evaluations"] <= 20_000 * 10
    assert after["rhs_evaluations"] - before["rhs_evaluations"] <= 500 * 2


@pytest.mark.parametrize("restitution", [0.05, 0.1])
@pytest.mark.parametrize("stiffness", [1e10, 1e12])
def test_loose_tolerances_see_the_same_contacts_and_sound_outputs(stiffness, restitution):
    """A careless penetration bounces: false onsets, and forces of kilonewtons in the outputs."""
    onsets = {}
    for tolerance in (1e-3, 1e-4, 1e-8):
        scene = with_values(quiet_chain(stiffness, restitution), {("solver", "tolerance"): tolerance})
        result = simulate(scene, stop_time=1.5, output_step=5e-4)
        onsets[tolerance] = len(result.impacts)
        assert balance(result) < max(1e-6, tolerance)
    # of 29 to 81: the last bounces before rest, lower than the tolerance tells, come and go with it
    assert onsets[1e-4] == pytest.approx(onsets[1e-8], abs=2)
    assert onsets[1e-3] == pytest.approx(onsets[1e-8], abs=2, rel=0.05)


def test_a_stiff_wall_does_not_bound_the_step_while_links_that_touch_turn():
    """At t = 0.7 to 1.2 s links fold on the floor, with some points at rest.

    A step bound by the curvature of the points' paths would shrink as 1/√k, a hundred times from 1e8 to 1e12.
    """
    steps = {}
    for stiffness in (1e8, 1e12):
        instance = Instance(quiet_chain(stiffness, 0.1))
        instance.advance(0.7)
        before = instance.statistics["implicit_steps"]
        instance.advance(1.2)
        steps[stiffness] = instance.statistics["implicit_steps"] - before
    assert steps[1e8] > 50
    assert steps[1e12] < 4 * steps[1e8]


def test_rest_is_a_hundred_times_cheaper_than_with_explicit_steps():
    spent = {}
    for method in ("auto", "explicit"):
        instance = Instance(quiet_chain(1e10, 0.1, method))
        instance.advance(5.0)
        before = instance.statistics["rhs_evaluations"]
        instance.advance(6.0)
        spent[method] = instance.statistics["rhs_evaluations"] - before
    assert spent["explicit"] >= 100 * spent["auto"]


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 2.145e10])
def test_flight_and_impacts_cost_the_same_as_with_the_explicit_method(stiffness):
    scenes = [quiet_chain(stiffness, 0.7, method) for method in ("auto", "explicit")]
    auto, explicit = (simulate(s, stop_time=0.7) for s in scenes)
    assert auto.statistics == explicit.statistics
    assert np.array_equal(auto.outputs, explicit.outputs)


def test_a_second_of_flight_with_contact_listed_but_far_takes_no_implicit_step():
    assert simulate(CHAIN, stop_time=0.49).statistics["implicit_steps"] == 0


# ---- rest ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10, 1e12])
def test_at_rest_the_walls_carry_the_weight_and_nothing_creeps(stiffness):
    result = simulate(quiet_chain(stiffness, 0.05), stop_time=60.0, output_step=1.0)
    late = result.outputs[result.time >= 10.0]
    floor = late["force"].reshape(len(late), 5, 4)
    assert floor[:, :, 2].sum(axis=1) == pytest.approx(WEIGHT, rel=1e-8)
    height = late["point_position"][:, :, 1]
    assert np.ptp(height, axis=0).max() < 1e-6 * np.abs(height).max()


def resting():
    """The default chain, with a force on its tip as input, after ten seconds."""
    instance = Instance(with_values(quiet_chain(1e10, 0.05), {("inputs", "tip_force"): True}))
    assert instance.advance(10.0) == 0
    instance.collect()
    return instance


def test_rest_wakes_in_the_step_in_which_it_is_pulled():
    instance = resting()
    record, out = instance.record, np.zeros(1, instance.record.dtype["output"])
    instance.trajectory(np.array([10.0]), out)
    height = out["point_position"][0, 4, 1]
    record["given"]["tip_force"] = [0.0, 100.0]
    record["given"]["changed"] = 1
    instance.trajectory(np.array([10.001]), out)
    assert out["point_velocity"][0, 4, 1] > 0.05
    assert out["point_position"][0, 4, 1] > height


def test_rest_carries_a_push_at_once():
    instance = resting()
    out = np.zeros(1, instance.record.dtype["output"])
    instance.record["given"]["tip_force"] = [0.0, -100.0]
    instance.record["given"]["changed"] = 1
    instance.trajectory(np.array([10.1]), out)
    assert out["force"][0].reshape(5, 4)[:, 2].sum() == pytest.approx(WEIGHT + 100.0, rel=1e-6)


# ---- coming to rest, to the exact depth ---------------------------------------------------------------


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
    assert np.isfinite(np.frombuffer(result.outputs.tobytes())).all()
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


# ---- torture ------------------------------------------------------------------------------------------

METHODS = ("auto", "explicit", "implicit")


@pytest.mark.parametrize("method", METHODS)
def test_light_link_between_heavy_ones(method):
    links = [(0.5, 1e3), (0.5, 1e-3), (0.5, 1e3), (0.5, 1e3)]
    result = simulate(scene(links, [0.3, -0.4, 0.2, -0.1], 3.0, FLOOR), method=method)
    assert balance(result) < 1e-6
    assert (result.outputs["force"] >= 0.0).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("angles", [[0.0, math.pi, 0.0, math.pi], [0.0] * 4], ids=["folded", "flat"])
def test_points_that_arrive_together(angles, method):
    result = simulate(scene([(0.5, 1.0)] * 4, angles, 3.0, FLOOR), method=method)
    assert balance(result) < 1e-6
    assert np.diff(result.energy["total"]).max() < (2e-7 if method == "implicit" else 1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_chain_longer_than_its_box_stays_inside(method):
    walls = {"x_min": -0.1, "x_max": 0.7, "y_min": 0.0, "y_max": 0.9}
    start = {"position": [0.0, 0.3], "angles": [0.2, 2.8, 0.3, 2.9], "velocity": [3.0, 1.0]}
    start["angular_velocities"] = [3.0, -3.0, 2.0, 5.0]
    result = simulate(scene([(0.5, 1.0)] * 4, [], 2.0, walls, initial=start), method=method)
    assert balance(result) < 1e-6
    assert result.points[:, :, 0].max() < 0.7 + 0.01
    assert result.points[:, :, 1].min() > -0.01


@pytest.mark.full("takes long")
def test_a_hundred_links_fall_in_a_heap():
    result = simulate(heap(stop_time=2.0), output_step=1e-2)
    assert len(result.impacts) > 1000
    assert balance(result) < 1e-5
    assert (result.outputs["force"] >= 0.0).all()


def test_torques_that_switch_every_millisecond_keep_the_ledger():
    instance = Instance(load_scene("pinned_arm"))
    record = instance.record
    out = np.zeros(2000, record.dtype["output"])
    for k in range(2000):
        record["given"]["joint_torque"] = [3.0 * (-1.0) ** k, -2.0 * (-1.0) ** (k // 2)]
        record["given"]["changed"] = 1
        assert instance.trajectory(np.array([(k + 1) * 1e-3]), out[k : k + 1]) == 1
    ledger = out["total"] + out["dissipated"] - out["supplied"]
    assert np.ptp(ledger) < 1e-6 * out["kinetic"].max()


def test_elastic_impacts_for_a_minute_keep_the_energy():
    changes = {("contact", "model"): "hertz", ("contact", "restitution"): 1.0}
    result = simulate(with_values(CHAIN, changes), stop_time=60.0, output_step=0.01, tolerance=1e-10)
    assert len(result.impacts) > 300
    energy = result.energy["total"]
    assert np.abs(energy - energy[0]).max() < 1e-6 * energy[0]


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_restitution_of_two_percent_under_every_law(law):
    changes = {("contact", key): value for key, value in of_law(law).items()}
    dropped = with_values(quiet_chain(1e8, 0.02), changes)
    result = simulate(dropped, stop_time=3.0)
    assert balance(result) < 1e-5
    assert np.diff(result.energy["total"]).max() < 1e-5 * result.energy["total"][0]
    assert (result.outputs["force"] >= 0.0).all()


# ---- bounded work -------------------------------------------------------------------------------------


def test_a_bound_on_work_ends_a_simulation_with_what_it_has():
    limited = with_values(CHAIN, {("solver", "work_limit"): 1500.0})
    with pytest.raises(SimulationError, match=r"solver\.work_limit") as caught:
        simulate(limited)
    assert caught.value.status == TOO_MUCH_WORK
    assert 0.5 < caught.value.time < 2.0
    result = caught.value.result
    assert result.time[-1] <= caught.value.time
    assert np.array_equal(result.outputs, simulate(CHAIN).outputs[: len(result.time)])


@pytest.mark.parametrize(("stiffness", "restitution", "onsets"), [(1e5, 0.3, 5), (1e10, 0.5, 27)])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_a_second_hit_inside_a_step_is_noticed(stiffness, restitution, onsets, tolerance):
    """The other end's impact presses a point in for less than a step: v₀ is latched anew all the same."""
    rod = {"base": "free", "links": [{"length": 1.0, "mass": 1.0}]}
    contact = {"stiffness": stiffness, "restitution": restitution}
    dropped = {
        "name": "Drop",
        "chain": rod,
        "box": {"y_min": 0.0},
        "contact": contact,
        "initial": {"position": [0.0, 0.1], "angles": [0.3]},
        "simulation": {"stop_time": 3.0},
    }
    # as found by other methods, with the same law and latch: docs/stability.md
    assert len(simulate(scene_from_dict(dropped, "drop"), tolerance=tolerance).impacts) == onsets

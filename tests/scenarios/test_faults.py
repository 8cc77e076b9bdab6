"""Difficult scenes for the search for events, the count of the cost and the energy balance."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.status import OK, TOO_MUCH_WORK
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.random_scenes import scene as random_scene
from tests.helpers.kernel.kernel_calls import advance, advance_awhile, initialize
from tests.helpers.models.reference import balance
from tests.helpers.scenes.turned import turned


def chain(count, initial, *, gravity=(0.0, -9.81), link=None, length=0.5, **tables):
    """Return equal links of 1 kg, above the floor unless a box is given."""
    table = {
        "name": "Chain",
        "gravity": list(gravity),
        "chain": {"links": [{"length": length, "mass": 1.0, **(link or {})}] * count},
        "box": {"y_min": 0.0},
        "initial": initial,
        **tables,
    }
    return scene_from_dict(table, "chain")


def cost(instance):
    """Return all that is counted against solver.work_limit."""
    record = instance.record
    return int(record["statistics"]["rhs_evaluations"] + record["budget"]["other_cost"])


# --- gliding along a wall, at no distance ------------------------------------------------------------------


HANGING = [-math.pi / 2] * 4
WALL = {"x_min": 0.0, "y_min": -1e3}


@pytest.mark.parametrize("gravity", [(0.0, -9.81), (0.0, -1000.0), (0.0, 0.0)])
@pytest.mark.parametrize("law", ["zhang_sharf", "newton_impact"])
def test_a_chain_flush_with_a_wall_falls_along_it_as_one_millimetre_away(law, gravity):
    costs = []
    for gap in (0.0, 1e-3):
        start = {"position": [gap, 2.4], "angles": HANGING, "velocity": [0.0, -1.0]}
        instance = Instance(chain(4, start, box=WALL, gravity=gravity, contact={"model": law}))
        assert instance.advance(1.0) == OK
        assert instance.record["impact"]["count"] == 0
        costs.append(cost(instance))
    assert costs[0] <= 3 * costs[1]


@pytest.mark.parametrize("turn", [0.7, 1.3, -2.0])
@pytest.mark.parametrize("gravity", [(0.0, -9.81), (0.0, -1000.0), (0.0, 0.0)])
@pytest.mark.parametrize("law", ["zhang_sharf", "newton_impact"])
def test_a_chain_flush_with_a_slanted_wall_falls_along_it_at_little_cost(law, gravity, turn):
    """Round-off makes its points touch and leave the wall several times."""
    start = {"position": [0.0, 2.4], "angles": HANGING, "velocity": [0.0, -1.0]}
    scene = chain(4, start, box=WALL, gravity=gravity, contact={"model": law})
    instance = Instance(turned(scene, turn))
    assert instance.advance(1.0) == OK
    assert cost(instance) < 1000


# --- loose tolerances --------------------------------------------------------------------------------------


def thrown(seed, count, damping, tolerance):
    """Return a chain with damped joints that is thrown onto the floor, spinning."""
    rng = np.random.default_rng(seed)
    length = 0.5 if count == 2 else 0.3
    start = {
        "position": [0.0, length * count * 1.05],
        "angles": list(rng.uniform(-0.3, 3.4, count)),
        "angular_velocities": list(rng.normal(0.0, 8.0, count)),
        "velocity": list(rng.normal(0.0, 3.0, 2)),
    }
    link, solver = {"joint_damping": damping}, {"tolerance": tolerance}
    return chain(count, start, link=link, solver=solver, contact={"stiffness": 1e8}, length=length)


@pytest.mark.parametrize("seed", range(60))
def test_no_tolerance_makes_energy_of_damped_joints(seed):
    """At a loose tolerance the end of a step has errors of millimetres."""
    count, damping, tolerance = [(2, 1.0, 1e-2), (10, 1000.0, 4e-3), (10, 1000.0, 1e-3)][seed % 3]
    result = simulate(thrown(seed, count, damping, tolerance), stop_time=0.6)
    assert balance(result) < 10 * tolerance
    ended = result.impacts[np.isfinite(result.impacts["end"])]
    assert (result.impacts["impact_speed"] >= 0.0).all()
    assert (ended["separation_speed"] >= 0.0).all()


def test_a_point_is_not_latched_deep_in_a_wall():
    """At the end of a step its position is 8 mm inside the wall, while its speed implies no motion there."""
    start = {
        "position": [0.0, 0.5230660473858592],
        "angles": [3.067928601106657, 2.7314651993312498],
        "angular_velocities": [-4.0684225728589185, 4.793214702481997],
        "velocity": [-0.646789204280724, -0.9128523793815926],
    }
    solver, contact = {"tolerance": 1e-2}, {"stiffness": 1e8}
    scene = chain(2, start, link={"joint_damping": 1.0}, solver=solver, contact=contact)
    result = simulate(scene, stop_time=0.6)
    assert balance(result) < 0.01
    assert result.outputs["penetration"].max() < 2e-3


# --- rigid walls -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("floor", [1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("restitution", [0.0, 1e-6, 0.3])
def test_a_point_that_leaves_a_rigid_wall_is_no_impact(restitution, floor):
    start = {"position": [0.0, 0.6], "angles": [0.3, -0.5, 0.7]}
    contact = {"model": "newton_impact", "restitution": restitution, "minimum_impact_speed": floor}
    for damping in (0.0, 5.0):
        scene = chain(3, start, link={"joint_damping": damping}, contact=contact)
        result = simulate(scene, stop_time=2.0)
        assert (result.impacts["impact_speed"] >= 0.0).all()
        assert balance(result) < 1e-6


# --- all calculations count --------------------------------------------------------------------------------


def test_the_search_for_events_counts_as_cost():
    start = {"position": [0.0, 0.6], "angles": [0.3, -0.5, 0.7]}
    scene = chain(3, start, contact={"model": "newton_impact", "restitution": 0.9})
    instance = Instance(scene)
    assert instance.advance(1.0) == OK
    evaluations = int(instance.record["statistics"]["rhs_evaluations"])
    assert cost(instance) > evaluations + 40
    with pytest.raises(SimulationError) as caught:
        simulate(with_values(scene, {("solver", "work_limit"): float(evaluations)}), stop_time=1.0)
    assert caught.value.status == TOO_MUCH_WORK


def test_a_search_that_is_given_up_ends_the_run():
    """The step is as long as the window of the limit; without the end the search would miss the floor."""
    scene = chain(1, {"position": [0.0, 4.0], "angles": [0.0]}, solver={"work_limit": 14.0})
    with pytest.raises(SimulationError) as caught:
        simulate(scene, stop_time=1.0)
    assert caught.value.status == TOO_MUCH_WORK


@pytest.mark.full("takes long")
def test_a_long_call_returns_in_between():
    """Python can handle Ctrl-C in between; the result is the same."""
    start = {"position": [0.0, 0.6], "angles": [0.3, -0.5, 0.7]}
    scene = chain(3, start, solver={"method": "explicit"}, contact={"stiffness": 1e12, "restitution": 0.2})
    instance, paused = Instance(scene), 0
    while advance_awhile(instance, 25.0):
        paused += 1
    whole = Instance(scene)
    assert advance(whole, 25.0) == OK
    assert paused > 0
    assert instance.record["step"].tobytes() == whole.record["step"].tobytes()


# --- forces that jump --------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_the_first_stage_after_an_onset_has_the_force_that_jumps_there(method):
    """The force of Kelvin and Voigt begins at c v₀, while the other end of the rod is already in contact."""
    start = {"position": [0.0, 0.01], "angles": [1e-3], "velocity": [0.0, -1.0]}
    contact = {"model": "kelvin_voigt", "exponent": 1.0, "stiffness": 1e4, "restitution": 0.5}
    instance = Instance(chain(1, start, contact=contact, solver={"method": method}))
    record = instance.record
    while record["impact"]["count"] < 2:
        assert instance.advance(math.nextafter(record["step"]["end"], math.inf)) == OK
    assert record["contacts"]["active_count"] == 2
    used = record["scratch"]["rate_start"].copy()
    record["step"]["communication_point"] = record["step"]["start"]
    instance.observe()
    output = record["output"]
    expected = [*output["point_acceleration"][0], *output["angular_acceleration"]]
    np.testing.assert_allclose(used[3:6], expected, rtol=1e-9, atol=1e-9)


# --- looks, restarts and late starts -----------------------------------------------------------------------


@pytest.mark.parametrize("seed", [54, 106, 1000026, 1000162])
def test_a_simulation_may_start_late(seed):
    """At this time a step of a picosecond is below the resolution of time."""
    instance, stop = Instance(random_scene(seed)), random_scene(seed).simulation.stop_time
    assert initialize(instance, 1e4) == OK
    assert instance.advance(1e4 + stop) == OK


def test_restarts_do_not_add_up_to_a_drift_of_the_energy():
    """An input shortens the last step again and again; the dropped part must change no energy."""
    scene = chain(
        4,
        {
            "position": [0.0, 3.0],
            "angles": [0.35, -0.5, 0.8, -0.2],
            "angular_velocities": [1.0, -2.0, 1.5, -1.0],
        },
        inputs={"joint_torques": True},
        contact={"points": []},
        solver={"tolerance": 1e-4, "method": "implicit"},
    )
    instance = Instance(scene)
    inputs = instance.record["given"]
    for k in range(20000):
        inputs["motor"][3], inputs["pending"] = 1e-3 * math.sin(5e-5 * k), 1
        assert instance.advance(1e-5 * (k + 1)) == OK
    record = instance.record["balance"]
    assert abs(record["value_end"] - record["window_value"]) < 5.0 * record["least_allowed_change"]


def test_restarts_cause_no_drift_while_falls_of_energy_are_corrected():
    """Each new torque cuts a step and moves sticking points back to their places."""
    random = np.random.default_rng(33)
    position, velocity = [0.0, 0.9], random.uniform(-1.0, 1.0, 2).tolist()
    angles, rates = random.uniform(-3.0, 3.0, 2).tolist(), random.uniform(-3.0, 3.0, 2).tolist()
    scene = scene_from_dict(
        {
            "name": "Thrown",
            "gravity": [0.0, -9.81],
            "chain": {
                "base": "free",
                "links": [{"length": 0.36, "mass": 1.28}, {"length": 0.4, "mass": 1.26}],
            },
            "walls": [{"name": "floor", "point": [0.0, 0.0], "angle": 0.0}],
            "contact": {"model": "hertz", "stiffness": 1.2e5, "friction": 0.8},
            "inputs": {"joint_torques": True},
            "initial": {
                "position": position,
                "velocity": velocity,
                "angles": angles,
                "angular_velocities": rates,
            },
            "solver": {"tolerance": 1e-3},
        },
        "thrown",
    )
    instance = Instance(scene)
    given, step, balance = (instance.record[name] for name in ("given", "step", "balance"))
    added = []
    for k, torque in enumerate(2.0 * np.random.default_rng(133).uniform(-1.0, 1.0, 16000)):
        given["motor"][1], given["pending"] = torque, 1
        assert instance.advance(1e-4 * (k + 1)) == OK
        added.append(float(step["energy_added_end"]))
    assert np.count_nonzero(np.diff(added)) > 20
    assert abs(balance["value_end"] - balance["run_value"]) < 5e-3


@pytest.mark.parametrize("stiffness", [1e4, 1e6, 1e10])
def test_a_new_stiffness_in_an_impact_is_a_change_of_energy_and_no_error(stiffness):
    instance = Instance(chain(1, {"position": [0.0, 0.2], "angles": [0.5]}))
    while instance.record["contacts"]["active_count"] == 0:
        assert instance.advance(instance.time + 1e-4) == OK
    instance.record["given"]["stiffness"], instance.record["given"]["pending"] = stiffness, 1
    assert instance.advance(instance.time + 0.3) == OK


def test_far_from_the_origin_round_off_is_no_drift():
    """The potential energy is a difference of large numbers far from the origin."""
    scene = chain(
        3,
        {"position": [1e6, 1e6 + 1.0], "angles": [0.3, -0.5, 0.7], "angular_velocities": [1.0, -2.0, 1.0]},
        gravity=(6.9, -6.9),
        box={"y_min": 1e6 - 10.0},
        solver={"tolerance": 1e-10},
    )
    result = simulate(scene, stop_time=0.4)
    assert result.statistics["steps"] + result.statistics["rejected_steps"] < 200


def test_far_from_the_origin_a_sliding_chain_needs_few_steps():
    """The round-off of clearances, 2 nm, is larger than the tolerance allows; it needs no shorter steps."""
    angle, steps = -0.2, []
    for distance in (0.0, 1.6e7):
        scene = chain(
            2,
            {
                "position": [distance * math.cos(angle), distance * math.sin(angle) + 1.0],
                "angles": [0.7, 1.4],
                "angular_velocities": [-1.2, -1.7],
            },
            length=0.2,
            link={"joint_friction": 0.5},
            box={},
            walls=[{"name": "slope", "point": [0.0, 0.0], "angle": angle}],
            contact={"model": "flores", "stiffness": 1.6e7, "restitution": 0.57, "friction": 0.1},
        )
        steps.append(simulate(scene, stop_time=10.0, output=[]).statistics["steps"])
    assert steps[1] < 4 * steps[0]

"""Sustained contact: the motion and cost of a chain at rest, its release, and bounded work."""

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, SimulationError, load_scene, simulate
from chain_impact.kernel.status import RIGID_WHILE_TOUCHING, TOO_MUCH_WORK
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.models.reference import balance
from tests.helpers.scenes.problems import (
    GRAVITY,
    RIGID,
    ball,
    build,
    default_scene,
    of_law,
    rigid,
)

CHAIN = load_scene("four_link_box")
WEIGHT = 4 * GRAVITY  # N, of the default chain


def quiet_chain(stiffness, restitution, method="auto", **contact):
    """Return the default chain at tolerance 1e−6; it lies still after a few seconds."""
    scene = default_scene(stiffness=stiffness, restitution=restitution, **contact)
    return with_values(scene, {("solver", "method"): method, ("solver", "tolerance"): 1e-6})


def floor_forces(row):
    """Return the forces [N] of the floor on the five points of the default chain, from rows of outputs."""
    return row["force"].reshape(*np.shape(row), 5, 4)[..., 2]


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
    """A wrong penetration would bounce: false onsets, and forces of kilonewtons in the outputs."""
    onsets = {}
    for tolerance in (1e-3, 1e-4, 1e-8):
        scene = with_values(quiet_chain(stiffness, restitution), {("solver", "tolerance"): tolerance})
        result = simulate(scene, stop_time=1.5, output_step=5e-4)
        onsets[tolerance] = len(result.impacts)
        assert balance(result) < max(1e-6, tolerance)
    # a run has 29 to 81 onsets; the last bounces before rest are below the resolution of the tolerance
    assert onsets[1e-4] == pytest.approx(onsets[1e-8], abs=2)
    assert onsets[1e-3] == pytest.approx(onsets[1e-8], abs=2, rel=0.05)


def test_a_stiff_wall_does_not_bound_the_step_while_links_that_touch_turn():
    """At t = 0.7 to 1.2 s links fold on the floor, with some points at rest.

    A step limit by the curvature of the points' paths would shrink as 1/√k, by 100 from 1e8 to 1e12.
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


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 2.145e10])
def test_flight_and_impacts_cost_the_same_as_with_the_explicit_method(stiffness):
    scenes = [quiet_chain(stiffness, 0.7, method) for method in ("auto", "explicit")]
    auto, explicit = (simulate(s, stop_time=0.7) for s in scenes)
    assert auto.statistics == explicit.statistics
    assert np.array_equal(auto.outputs, explicit.outputs)


@pytest.mark.parametrize("restitution", [0.05, 0.3, 0.5, 0.7, 0.9])
def test_the_default_chain_comes_to_rest_for_next_to_nothing(restitution):
    instance = Instance(default_scene(model=RIGID, restitution=restitution))
    assert instance.advance(11.0) == 0
    before = instance.statistics
    assert before["steps"] < 2000
    # afterwards a flat chain slides, and rarely meets a wall
    assert instance.advance(21.0) == 0
    after = instance.statistics
    assert after["steps"] - before["steps"] < 50
    assert after["rhs_evaluations"] - before["rhs_evaluations"] < 1000
    assert instance.record["contacts"]["active"].reshape(5, 4)[:, 2].all()


# ---- rest ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10, 1e12, RIGID])
def test_at_rest_the_floor_carries_the_weight_and_nothing_creeps(stiffness):
    hard = stiffness == RIGID
    scene = default_scene(model=RIGID, restitution=0.05) if hard else quiet_chain(stiffness, 0.05)
    result = simulate(scene, stop_time=60.0, output_step=1.0)
    late = result.outputs[result.time >= 10.0]
    floor, height = floor_forces(late), late["point_position"][:, :, 1]
    assert floor.sum(axis=1) == pytest.approx(WEIGHT, rel=1e-8)
    if hard:
        np.testing.assert_allclose(floor / GRAVITY, [[0.5, 1.0, 1.0, 1.0, 0.5]] * len(late), rtol=1e-8)
        assert np.abs(height).max() < 1e-14
    else:
        assert np.ptp(height, axis=0).max() < 1e-6 * np.abs(height).max()


@pytest.mark.parametrize("law", ["hertz", "tsuji", "zhang_sharf"])
def test_a_rod_that_starts_at_rest_on_a_very_stiff_floor(law):
    """Each end carries m g/2 and sinks into the floor from the height 0, with the rest penetration δ.

    Without damping it oscillates for ever. By its energy, ½ v² = g x − (2/5) (2 K/m) x^(5/2) at the
    penetration x, so the speed is largest at x = δ: √(6/5 g δ), 1.3e-4 m/s. A law with damping stops it.
    """
    flat, stiffness = {"position": [0.0, 0.0], "angles": [0.0]}, 1e14
    contact = {"model": law, "stiffness": stiffness}
    links = [{"length": 0.5, "mass": 1.0}]
    scene = build(
        "Flat", links, flat, {"y_min": 0.0}, contact, gravity=GRAVITY, stop_time=0.1, tolerance=1e-8
    )
    speeds = np.abs(simulate(scene)["point[1].vy"])
    largest = np.sqrt(1.2 * GRAVITY * (0.5 * GRAVITY / stiffness) ** (2 / 3))
    assert largest == pytest.approx(1.26e-4, rel=1e-2)
    if law == "hertz":
        assert 0.97 * largest < speeds.max() <= largest
    else:
        assert speeds.max() < largest
        assert speeds[-1] < 1e-12


@pytest.fixture(params=[RIGID, "zhang_sharf"])
def resting(request):
    """Return the default chain at rest after 10 s, a function that runs it on, and whether walls are rigid.

    The function runs to a time [s] with a new tip force [N], if given, and returns the outputs then.
    """
    scene = quiet_chain(1e10, 0.05, model=request.param)
    instance = Instance(with_values(scene, {("inputs", "tip_force"): True}))
    out = np.zeros(1, instance.record.dtype["output"])

    def at(time, force=None):
        instance.record["contact_log"]["collected"] = instance.record["contact_log"]["count"]
        if force is not None:
            instance.record["given"]["tip_force"] = force
            instance.record["given"]["pending"] = 1
        assert instance.trajectory(np.array([time]), out) == 1
        return out[0].copy()

    assert instance.advance(10.0) == 0
    return instance, at, request.param == RIGID


def test_a_pull_wakes_the_chain_at_once(resting):
    """The last rod rises about its inner joint: α = (f − m g/2) L/(m L²/3)."""
    _, at, hard = resting
    row = at(10.0, (0.0, 20.0))
    lift = 3 * (20.0 - GRAVITY / 2) / 0.5
    if hard:
        assert row["angular_acceleration"][3] == pytest.approx(lift, rel=1e-8)
        # the other end of that rod is pressed down with m(g + a) − f and half of a rod's weight
        pressed = GRAVITY / 2 + GRAVITY + 0.25 * lift - 20.0
        assert floor_forces(row)[3] == pytest.approx(pressed, rel=1e-8)
    later = at(10.01)
    raised = later["point_position"][4, 1] - row["point_position"][4, 1]
    assert raised == pytest.approx(0.5 * 0.5 * lift * 1e-4, rel=0.01 if hard else 0.05)
    assert (floor_forces(later) >= 0.0).all()


def test_a_push_is_carried_at_once(resting):
    _, at, hard = resting
    row = at(10.1, (0.0, -100.0))
    assert floor_forces(row).sum() == pytest.approx(WEIGHT + 100.0, rel=1e-10 if hard else 1e-6)


@pytest.mark.parametrize("law", [RIGID, "zhang_sharf"])
def test_torques_that_switch_every_millisecond_keep_the_energy_balance(law):
    scene = load_scene("pinned_arm")
    instance = Instance(rigid(scene) if law == RIGID else scene)
    record = instance.record
    out = np.zeros(2000, record.dtype["output"])
    for k in range(2000):
        record["given"]["motor"][:2] = [3.0 * (-1.0) ** k + 2.0, -2.0 * (-1.0) ** (k // 2)]
        record["given"]["pending"] = 1
        record["contact_log"]["collected"] = record["contact_log"]["count"]
        assert instance.trajectory(np.array([(k + 1) * 1e-3]), out[k : k + 1]) == 1
    balance = out["total"] + out["dissipated"] - out["supplied"]
    assert np.ptp(balance) < 1e-6 * out["kinetic"].max()
    assert (out["force"] >= 0.0).all()


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_restitution_of_two_percent_under_every_law(law):
    result = simulate(quiet_chain(1e8, 0.02, **of_law(law)), stop_time=3.0)
    assert balance(result) < 1e-5
    assert np.diff(result.energy["total"]).max() < 1e-5 * result.energy["total"][0]
    assert (result.outputs["force"] >= 0.0).all()


# ---- bounded work -------------------------------------------------------------------------------------


def test_a_bound_on_cost_ends_a_simulation_with_what_it_has():
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
    """The other end's impact presses a point in for less than a step; v₀ is latched again nevertheless."""
    start = {"position": [0.0, 0.1], "angles": [0.3]}
    contact = {"stiffness": stiffness, "restitution": restitution}
    links = [{"length": 1.0, "mass": 1.0}]
    scene = build("Drop", links, start, {"y_min": 0.0}, contact, gravity=GRAVITY, stop_time=3.0)
    assert len(simulate(scene, tolerance=tolerance).impacts) == onsets


# ---- another law on the way -----------------------------------------------------------------------------


def change_law(instance, law):
    instance.record["given"]["law"] = CONTACT_LAWS[law].number
    instance.record["given"]["pending"] = 1


def test_in_flight_the_law_may_change_to_it():
    instance = Instance(default_scene())
    assert instance.advance(0.4) == 0
    change_law(instance, RIGID)
    assert instance.advance(2.0) == 0
    impacts = instance.collect()
    assert (impacts["end"] == impacts["onset"])[:5].all()


def test_while_a_point_is_in_a_wall_it_may_not():
    instance = Instance(default_scene(restitution=0.05))
    assert instance.advance(9.0) == 0
    change_law(instance, RIGID)
    assert instance.advance(9.1) == RIGID_WHILE_TOUCHING
    assert instance.time == 9.0
    text = str(SimulationError(RIGID_WHILE_TOUCHING, 9.0, None))
    assert RIGID in text


def test_held_contacts_pass_to_another_law():
    instance = Instance(default_scene(model=RIGID, restitution=0.3))
    assert instance.advance(8.0) == 0
    assert instance.record["contacts"]["active_count"] == 5
    change_law(instance, "zhang_sharf")
    out = np.zeros(1, instance.record.dtype["output"])
    instance.record["contact_log"]["collected"] = instance.record["contact_log"]["count"]
    assert instance.trajectory(np.array([12.0]), out) == 1
    assert floor_forces(out[0]).sum() == pytest.approx(WEIGHT, rel=1e-5)
    assert (out["penetration"][0].reshape(5, 4)[:, 2] > 0.0).all()


@pytest.mark.parametrize("look", [False, True])
def test_a_change_that_is_refused_leaves_the_contacts_rigid(look):
    """The parameters are inconsistent when an output is requested in between; the output changes nothing."""

    def after(settings):
        instance = Instance(rigid(ball(height=0.01), restitution=0.0))
        assert instance.advance(1.0) == 0
        for law, restitution in settings:
            instance.record["given"]["restitution"] = restitution
            change_law(instance, law)
            if look:
                instance.observe()
        return instance, instance.advance(1.5)

    instance, status = after([("zhang_sharf", 0.0), ("zhang_sharf", 0.7)])
    assert status == 0
    assert instance.record["contact_log"]["count"] == 1
    _, status = after([("kelvin_voigt", 0.7), (RIGID, 0.7)])
    assert status == 0


# ---- rigid walls and dry joints ---------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize(
    ("friction", "angles", "speeds"),
    [
        (2.582, [-0.547, 0.056], [1.761, 3.063]),
        (1.7, [0.4, -0.3], [0.5, 1.0]),
        (5.0, [2.2, 0.6], [-1.0, 2.0]),
    ],
)
def test_a_chain_with_a_dry_joint_comes_to_rest_on_a_rigid_floor(friction, angles, speeds, restitution):
    """Slip in a joint by impacts at rest would lift points by friction; the joint sticks instead."""
    links = [{"length": 0.4, "mass": 1.0}, {"length": 0.4, "mass": 1.0, "joint_friction": friction}]
    start = {"position": [0.0, 0.9], "angles": angles, "angular_velocities": speeds}
    contact = {"model": RIGID, "restitution": restitution}
    scene = build("Dry", links, start, {"y_min": 0.0}, contact, gravity=GRAVITY, stop_time=10.0)
    result = simulate(scene)
    assert len(result.impacts) < 150
    assert result.statistics["steps"] < 2000
    late = result.outputs[result.time >= 5.0]
    # a chain at rest on a smooth floor may slide
    assert np.abs(late["angular_velocity"]).max() < 1e-12
    np.testing.assert_allclose(late["force"].sum(axis=1), 2.0 * GRAVITY, rtol=1e-9)
    assert np.abs(result.impacts["onset"]).max() < 5.0


def test_a_joint_that_sticks_at_its_stop_hits_it_few_times():
    """The drive of joint 1 shakes joint 2, whose dry friction holds it where its stop has stopped it."""
    links = [
        {"length": 0.4, "mass": 1.0, "joint_stiffness": 100.0},
        {"length": 0.4, "mass": 1.0, "joint_friction": 20.0, "joint_min": -0.3, "joint_max": 0.3},
    ]
    start = {"angles": [0.3, 0.5], "angular_velocities": [3.0, 12.0]}
    contact = {"model": RIGID, "restitution": 0.0}
    scene = build("Stop", links, start, {}, contact, base="pinned", gravity=GRAVITY, stop_time=10.0)
    result = simulate(scene)
    assert len(result.impacts) < 10
    bend = result.angles[-1, 1] - result.angles[-1, 0]
    assert 0.0 < bend <= 0.3 + 1e-12


# ---- one force ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [name for name in CONTACT_LAWS if name != RIGID])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_the_force_in_rows_is_that_of_the_accelerations(law, tolerance):
    """Also where a point rests and the sign of δ̇ is an error: F + m g = m a of the centre of mass."""
    links = [{"length": 0.5, "mass": 1.5}]
    start = {"position": [0.0, 0.4], "angles": [0.3], "angular_velocities": [1.0]}
    contact = {"stiffness": 1e6, **of_law(law)}
    contact["restitution"] = max(contact.get("restitution", 0.0), 0.3)
    scene = build(
        "Rod",
        links,
        start,
        {"y_min": 0.0},
        contact,
        gravity=GRAVITY,
        stop_time=2.0,
        tolerance=tolerance,
    )
    result = simulate(scene, output_step=0.01)
    mean = result.outputs["point_acceleration"][:, :, 1].mean(axis=1)
    force = result.outputs["force"].sum(axis=1)
    np.testing.assert_allclose(1.5 * (mean + GRAVITY), force, rtol=1e-9, atol=1e-9)

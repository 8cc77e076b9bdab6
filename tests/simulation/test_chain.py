"""A chain stepped in Python: bit-equal to simulate(); states, settable values and refused values."""

# Tests: simulation/instance.py, simulation/chain_access.py, simulation/chain_rows.py
# Tests: simulation/chain_states.py

import itertools
import math
import pickle
import zlib

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, Chain, SceneError, SimulationError, load_scene, simulate
from chain_impact.recording.impacts import IMPACT_DTYPE
from tests.helpers.kernel.kernel_calls import instance_of
from tests.helpers.scenes.problems import ball, default_scene, dropped_ball
from tests.helpers.tools.refusal import refusal

TORQUE, FORCE = "joint[2].torque", "tip.force.x"


@pytest.fixture
def arm():
    return load_scene("pinned_arm").with_values({"inputs.tip_force": True})


def drive(chain, times, signal):
    """Hold each value of a signal until the next time; return the outputs, shape (T, number of names)."""
    names = simulate(chain.scene, 1e-3).names
    rows = []
    for time in times:
        if time > chain.time:
            chain.step_to(time)
        elif time == 0.0:
            chain.set({TORQUE: signal(0.0)})
        rows.append(chain.get(names))
        chain.set({TORQUE: signal(time)})
    return np.array(rows)


def signal(time):
    return 2.0 * math.sin(9.0 * time)


# --- one result ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["four_link_box", "ramp", "rod_drop"])
def test_steps_give_the_bits_of_simulate(model):
    scene = load_scene(model)
    result, chain = simulate(scene), Chain(scene)
    rows = []
    for time in result.time:
        chain.step_to(time)
        rows.append(chain.get(result.names))
    assert np.array(rows).tobytes() == np.stack(list(result.columns.values()), -1).tobytes()
    assert chain.impacts.tobytes() == result.impacts.tobytes()
    assert len(result.impacts) > 2
    counts = [chain.get(f"solver.{name}") for name in ("steps", "rhs_evaluations")]
    assert counts == [result.statistics[name] for name in ("steps", "rhs_evaluations")]


def test_held_inputs_give_the_bits_of_simulate(arm):
    result = simulate(arm, inputs={TORQUE: signal}, interpolation="hold")
    chain = Chain(arm)
    rows = drive(chain, result.time.tolist(), signal)
    names = [name for name in result.names if name != TORQUE]
    assert rows.tobytes() == np.stack([result[name] for name in names], -1).tobytes()
    assert chain.impacts.tobytes() == result.impacts.tobytes()
    assert len(result.impacts) > 0


def test_a_recorded_run_is_the_result_of_simulate(arm, tmp_path):
    result = simulate(arm, inputs={TORQUE: signal}, interpolation="hold")
    chain = Chain(arm, record=True)
    chain.set(TORQUE, signal(0.0))
    for start, time in itertools.pairwise(result.time.tolist()):
        chain.set(TORQUE, signal(start))
        chain.step_to(time)
    recorded = chain.result()
    other_inputs = {FORCE: 0.0, "joint[1].torque": 0.0, "tip.force.y": 0.0}
    assert {*recorded.names} == {*result.names, *other_inputs}
    for name in ("time", *result.names):
        assert recorded[name].tobytes() == result[name].tobytes(), name
    assert recorded.impacts.tobytes() == result.impacts.tobytes()
    assert (recorded.statistics, recorded.scene) == (result.statistics, result.scene)
    recorded.plot(tmp_path / "run.svg")
    assert pickle.loads(pickle.dumps(chain)).result() == recorded
    chain_of_some = Chain(arm, record=["joint[*].torque", "energy.total"])
    chain_of_some.step(0.1)
    assert chain_of_some.result().names == ("energy.total", "joint[1].torque", TORQUE)
    assert "create Chain(…, record=True)" in refusal(Chain(arm).result)
    with pytest.raises(KeyError, match=r"energy.totl is not an output; the nearest is energy.total"):
        Chain(arm, record="energy.totl")


def test_rows_follow_restored_states_and_set_values(arm):
    chain = Chain(arm, record="point[2].x")
    chain.step(0.1)
    state = chain.save()
    for torque in (-1.0, 1.0):
        chain.restore(state)
        chain.set(TORQUE, torque)
        chain.step(0.2)
        chain.step_to(chain.time)
        assert chain.result().time.tolist() == [0.0, 0.1, pytest.approx(0.3)]
    chain.set(TORQUE, -1.0)
    branch = Chain(arm, record="point[2].x")
    branch.set(TORQUE, 2.0)
    branch.step(0.1)
    chain.restore(branch.save())
    chain.step(0.1)
    assert chain.result().time.tolist() == [0.1, 0.2]
    chain.reset()
    chain.set({"link[1].mass": 3.0, "contact.model": "flores"})
    changed_scene = chain.result().scene
    assert changed_scene == arm.with_values({"link[1].mass": 3.0, "contact.model": "flores"})


def test_many_impacts_in_one_step_are_all_collected():
    scene, _ = dropped_ball(1e-3, stop_time=3.0, model="hertz", stiffness=1e10)
    chain = Chain(scene)
    chain.step(3.0)
    assert len(chain.impacts) > 100
    assert set(chain.impacts["wall_name"]) == {chain.scene.wall_names[k] for k in chain.impacts["wall"]}
    assert chain.impacts.tobytes() == simulate(scene, output_step=math.inf).impacts.tobytes()


def test_looking_at_impacts_changes_nothing():
    quiet, curious = Chain(default_scene()), Chain(default_scene())
    lasting = 0
    for _ in range(1000):
        quiet.step(1e-3)
        curious.step(1e-3)
        lasting += bool(np.isnan(curious.impacts["end"]).any())
    assert lasting > 0
    assert quiet.save() == curious.save()


# --- states ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("split", [150, 186])  # in flight, and in the first contact
def test_a_state_is_continued_bit_by_bit(arm, split):
    chain, other_chain = Chain(arm), Chain(arm)
    times = [2e-3 * k for k in range(1, 251)]
    drive(chain, times[:split], signal)
    state, impacts = chain.save(), chain.impacts
    first = drive(chain, times[split:], signal)
    ended = chain.save()
    assert chain.impacts.tobytes() != impacts.tobytes()
    chain.restore(state)
    assert chain.impacts.tobytes() == impacts.tobytes()
    assert chain.time == times[split - 1]
    assert drive(chain, times[split:], signal).tobytes() == first.tobytes()
    other_chain.restore(state)
    assert drive(other_chain, times[split:], signal).tobytes() == first.tobytes()
    assert chain.save() == other_chain.save() == ended


def test_reset_goes_back_to_the_scene(arm):
    chain = Chain(arm)
    start = chain.save()
    chain.set({"contact.radius": 0.01, TORQUE: 3.0})
    chain.step(1.0)
    chain.reset()
    assert (chain.time, chain.get(TORQUE), chain.get("contact.radius")) == (0.0, 0.0, arm.contact.radius)
    assert len(chain.impacts) == 0
    assert chain.save() == start


@pytest.mark.parametrize("change", [lambda s: b"", lambda s: s[:-8], lambda s: b"x" + s[1:], lambda s: s + s])
def test_bytes_that_are_no_state_are_refused(arm, change):
    chain = Chain(arm)
    assert "the bytes are no state of this scene" in refusal(chain.restore, change(chain.save()))


def test_the_state_of_another_scene_is_refused(arm):
    state = Chain(arm.with_values({"link[1].mass": 9.0})).save()
    assert "the bytes are no state of this scene" in refusal(Chain(arm).restore, state)


def test_a_damaged_state_is_refused_and_changes_nothing(arm):
    """One bit of the state changes, also in a number whose every value would be valid."""
    chain = Chain(arm)
    chain.step(0.2)
    state = chain.save()
    for at in [*range(len(state) - 7 * 40, len(state), 7), 8, 40, len(state) // 2]:
        damaged = state[:at] + bytes([state[at] ^ 1]) + state[at + 1 :]
        assert "restore: the " in refusal(chain.restore, damaged)
    assert chain.save() == state


def test_an_unsound_state_with_a_right_checksum_is_refused(arm):
    chain = Chain(arm)
    state = chain.save()
    head = len(state) - instance_of(chain).words.nbytes
    checked = state[16:head] + b"\xff" * 16 + state[head + 16 :]
    forged = state[:8] + zlib.crc32(checked).to_bytes(8, "little") + checked
    assert "the state is damaged" in refusal(chain.restore, forged)
    assert chain.save() == state


# --- get and set -----------------------------------------------------------------------------------------


def test_get_gives_numbers_and_arrays():
    chain = Chain(default_scene())
    assert type(chain.get("point[4].x")) is float
    assert type(chain.get("impact.count")) is int
    assert chain.get("impact.last_point") == -1
    assert chain.get("contact.model") == CONTACT_LAWS[chain.scene.contact.model].number
    values = chain.get(["point[0].x", "impact.last_point", "link[2].mass"])
    assert values.tolist() == [0.6, -1.0, 1.0]
    assert chain.get("link[*].mass").tolist() == [1.0] * 4
    assert chain.get(["initial.x", "link[*].length"]).shape == (5,)
    assert {"point[0].x", "contact.stiffness", "impact.count"} <= set(chain.names)


def test_before_the_first_step_everything_but_outputs_can_be_set():
    values = {"link[1].mass": 2.0, "initial.angle[1]": 0.4, "contact.model": "flores", "box.x_max": 2.9}
    chain, scene = Chain(default_scene()), default_scene().with_values(values)
    chain.set(values)
    assert chain.get("link[1].angle") == 0.4
    chain.step_to(1.0)
    assert chain.get("point[*].x").tobytes() == chain_at(scene, 1.0).get("point[*].x").tobytes()
    message = refusal(chain.set, {"link[1].mass": 1.0})
    assert message == "FourLinkBox: link[1].mass is a fixed parameter and cannot be set after the first step"


def chain_at(scene, time):
    chain = Chain(scene)
    chain.step_to(time)
    return chain


def test_a_set_value_acts_from_the_present_time(arm):
    chain = Chain(arm)
    chain.step(0.1)
    acceleration = chain.get("link[2].angular_acceleration")
    chain.set({TORQUE: 5.0})
    assert chain.get("link[2].angular_acceleration") > acceleration + 1.0
    steps = chain.get("solver.steps")
    chain.set({TORQUE: 5.0, "contact.restitution": 0.25, "contact.model": 1})
    chain.step(1e-9)
    assert chain.get("solver.steps") > steps
    assert chain.get("contact.restitution") == 0.25


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"joint[3].torque": 1.0}, "joint[3].torque is not a variable; the nearest is joint[2].torque"),
        ({"point[0].x": 1.0}, "point[0].x is an output and cannot be set"),
        ({"contact.stiffness": 0.0}, "contact.stiffness = 0.0 must be a finite number > 0 [N/m^exponent]"),
        ({TORQUE: math.nan}, "joint[2].torque = nan must be a finite number [N·m]"),
        ({TORQUE: "1"}, "joint[2].torque = '1' must be a finite number [N·m]"),
        ({TORQUE: [1.0, 2.0]}, "joint[2].torque = [1.0, 2.0] must be"),
        ({TORQUE: True}, "joint[2].torque = true must be"),
        ({"contact.model": "nobody"}, "contact.model = 'nobody' must be one of 1 (hertz), "),
        ({"contact.model": 1.5}, "contact.model = 1.5 must be one of 1 (hertz), "),
    ],
)
def test_values_that_cannot_be_set_are_refused_and_change_nothing(arm, values, message):
    chain = Chain(arm)
    state = chain.save()
    assert refusal(chain.set, {"tip.force.y": 1.0, **values}).startswith(f"PinnedArm: {message}")
    assert chain.save() == state


def test_an_input_that_a_signal_drives_is_refused_with_the_signal(arm):
    signal = {"input": [TORQUE], "form": "constant", "value": 1.0}
    chain = Chain(arm.with_values({("signals", "push"): signal}))
    assert "signals.push drives it" in refusal(chain.set, TORQUE, 2.0)
    chain.set("tip.force.y", 2.0)
    assert chain.get(TORQUE) == 1.0


def test_a_single_value_is_set_by_name_and_value(arm):
    chain = Chain(arm)
    chain.set(TORQUE, 2.0)
    assert chain.get(TORQUE) == 2.0
    assert "= None must be" in refusal(chain.set, TORQUE)


@pytest.mark.parametrize(
    ("name", "key"), [("tip.force.x", "tip_force"), ("joint[2].torque", "joint_torques")]
)
def test_an_input_that_is_not_there_is_told_how_to_make_it(name, key):
    chain = Chain(load_scene("four_link_box"))
    hint = f"FourLinkBox: {name} is not a variable; set inputs.{key} = true"
    assert refusal(chain.get, name) == hint
    assert refusal(chain.set, name, 1.0) == hint


def test_an_unknown_name_is_refused(arm):
    chain = Chain(arm)
    with pytest.raises(KeyError, match=r"point\[9\]\.x is not a variable; the nearest is point"):
        chain.get(["point[0].x", "point[9].x"])
    assert "jiont* is not a variable" in refusal(chain.get, "jiont*")


# --- time and faults -------------------------------------------------------------------------------------


@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf])
def test_a_step_is_a_finite_number_above_zero(duration):
    message = refusal(Chain(ball()).step, duration)
    assert message.endswith(f"step({duration}) must be a finite number > 0 [s]")


def test_time_does_not_go_back():
    chain = Chain(ball())
    chain.step(0.01)
    chain.step_to(0.01)
    assert "step_to(0.005) must be a finite number >= 0.01 [s], the present time" in refusal(
        chain.step_to, 0.005
    )


def test_a_fault_is_a_sentence_and_an_earlier_state_goes_on():
    chain = Chain(ball(0.05, 1.0, stiffness=1e60, stop_time=0.1))
    chain.step(0.01)
    state = chain.save()
    for _ in range(2):
        with pytest.raises(SimulationError, match=r"stopped at t = 0\.05 s: "):
            chain.step(0.09)
    chain.restore(state)
    chain.step(0.01)
    assert chain.time == 0.02
    assert repr(chain).endswith("at t = 0.02 s")


def test_a_start_that_cannot_be_is_said_at_the_next_look(arm):
    chain = Chain(arm)
    chain.set({"initial.angle[1]": 0.0})
    with pytest.raises(SimulationError, match="beyond a wall"):
        chain.get("point[1].x")
    chain.reset()
    assert chain.impacts.dtype == IMPACT_DTYPE
    assert isinstance(chain.get("point[1].x"), float)


def test_errors_are_scene_errors_for_whoever_catches_them(arm):
    with pytest.raises(SceneError):
        Chain(arm).get("nothing")


# --- faults, refused laws and damaged states ----------------------------------------------------------------


def in_first_impact(part, **contact):
    """Return a chain that was stepped into the first impact of the default scene, and the row of this impact.

    The time is after ``part`` of the impact's duration.
    """
    scene = load_scene("four_link_box").with_values(
        {f"contact.{key}": number for key, number in contact.items()}
    )
    first = simulate(scene).impacts[0]
    chain = Chain(scene)
    chain.step_to(first["onset"] + part * (first["end"] - first["onset"]))
    return chain, first


def test_a_law_that_is_refused_and_taken_back_changes_no_contact():
    chain, first = in_first_impact(0.2, model="hunt_crossley")
    energy = chain.get("energy.total")
    chain.set({"contact.model": "tsuji", "contact.restitution": 0.0})
    refused = (
        "FourLinkBox: at t = .* s the values that are set cannot take effect: the contact law does not allow"
    )
    with pytest.raises(SceneError, match=refused + ".*: point 0 at the wall x_min"):
        chain.get("energy.total")
    assert len(chain.impacts) == 1  # impacts before the failure remain
    chain.set({"contact.model": "hunt_crossley", "contact.restitution": 0.7})
    assert chain.get("energy.total") == energy
    chain.step(0.01)
    assert chain.impacts[0]["peak_force"] == pytest.approx(first["peak_force"], rel=1e-6)


@pytest.mark.parametrize("look", [False, True])
@pytest.mark.parametrize("stiffness", [1e5, 1e11])
def test_a_change_of_the_stiffness_acts_from_now_on_only(look, stiffness):
    chain, first = in_first_impact(0.6, model="hunt_crossley")
    chain.set({"contact.stiffness": stiffness})
    if look:
        chain.get("energy.total")
    assert chain.impacts[0]["peak_force"] == pytest.approx(first["peak_force"], rel=1e-6)
    now = chain.get("contact[2].y_min.force")
    chain.step(1e-12)
    assert chain.impacts[0]["peak_force"] == pytest.approx(max(first["peak_force"], now), rel=1e-6)


@pytest.mark.parametrize("limit", [500, 1500, 2500])
def test_a_fault_loses_no_impact(limit):
    scene = load_scene("four_link_box").with_values({"solver.work_limit": limit})
    with pytest.raises(SimulationError) as stopped:
        simulate(scene)
    chain = Chain(scene)
    with pytest.raises(SimulationError):
        chain.step_to(2.0)
    np.testing.assert_array_equal(chain.impacts["onset"], stopped.value.result.impacts["onset"])
    assert len(chain.impacts) == chain.get("impact.count")


def test_inputs_that_change_lose_no_force_of_a_rigid_wall():
    scene = load_scene("four_link_box").with_values(
        {"contact.model": "newton_impact", "contact.restitution": 0.0, "inputs.tip_force": True}
    )
    held_chain, touched_chain = Chain(scene), Chain(scene)
    for k in range(1, 120):
        held_chain.step_to(5e-3 * k)
        touched_chain.step_to(5e-3 * k)
        touched_chain.set({"tip.force.x": 1e-12 * (k % 2)})
    expected_impact, impact = held_chain.impacts[0], touched_chain.impacts[0]
    assert np.isfinite(expected_impact["peak_force"])
    assert impact["peak_force"] == pytest.approx(expected_impact["peak_force"], rel=1e-3)

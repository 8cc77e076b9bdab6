"""Drives in joints: armatures, servos with targets, torque limits; against closed forms and textbooks."""

# Tests: kernel/chain/drives.py, kernel/events/saturation.py

import math
from functools import partial

import numpy as np
import pytest

from chain_impact import Chain, SceneError, load_scene, simulate
from chain_impact.scene.scene import scene_from_dict, with_values
from tests.helpers.kernel.kernel_calls import instance_of
from tests.helpers.models.driven_chain import DrivenChain
from tests.helpers.models.reference import balance
from tests.helpers.scenes.joint_drives import INERTIA, ROD, TOLERANCE, chain_with_drives, random_chain
from tests.helpers.tools.differences import slope

# --- servos ------------------------------------------------------------------------------------------------


STIFFNESS, DAMPING, ARMATURE = 12.0, 0.8, 0.3
SERVO = {"joint_stiffness": STIFFNESS, "joint_damping": DAMPING, "joint_armature": ARMATURE}
FOLLOWS = {"inputs": {"joint_targets": True}}


def one_servo(**changes):
    """Return a rod at a pin with a servo, without gravity; ``changes`` are keys of the link."""
    return chain_with_drives(
        [ROD | SERVO | changes], {"angles": [0.7], "angular_velocities": [1.5]}, **FOLLOWS
    )


def decaying(time, angle, speed):
    """Return the solution of (I + I_a) φ̈ + c φ̇ + k φ = 0 from an angle and its rate."""
    decay = DAMPING / 2 / (INERTIA + ARMATURE)
    pace = math.sqrt(STIFFNESS / (INERTIA + ARMATURE) - decay**2)
    waves = angle * np.cos(pace * time) + (speed + decay * angle) / pace * np.sin(pace * time)
    return np.exp(-decay * time) * waves


@pytest.mark.parametrize("method", ["auto", "explicit", "implicit"])
def test_a_servo_swings_to_its_target_as_the_damped_oscillator(method):
    """The target velocity shifts the equilibrium angle by c φ̇_t/k."""
    targets = {"joint[1].target_angle": 1.3, "joint[1].target_velocity": 0.4}
    tolerance = 1e-8 if method == "implicit" else TOLERANCE
    result = simulate(one_servo(), inputs=targets, method=method, tolerance=tolerance)
    rest = 1.3 + DAMPING * 0.4 / STIFFNESS
    exact = rest + decaying(result.time, 0.7 - rest, 1.5)
    np.testing.assert_allclose(result.angles[:, 0], exact, rtol=0, atol=100 * tolerance)
    assert balance(result) < 1e4 * tolerance
    assert not result.energy["elastic"].any()
    assert not result.energy["dissipated"].any()


def test_a_servo_follows_a_sine_as_its_transfer_function_says():
    """A (k + i c ω)/(k − J ω² + i c ω), plus a decaying part from the start."""
    pace, inertia = 3.0, INERTIA + ARMATURE
    targets = {
        "joint[1].target_angle": lambda t: math.sin(pace * t),
        "joint[1].target_velocity": lambda t: pace * math.cos(pace * t),
    }
    result = simulate(one_servo(), inputs=targets)
    drive = STIFFNESS + 1j * DAMPING * pace
    transfer = drive / (drive - inertia * pace**2)
    forced = (transfer * np.exp(1j * pace * result.time)).imag
    exact = forced + decaying(result.time, 0.7 - forced[0], 1.5 - pace * transfer.real)
    np.testing.assert_allclose(result.angles[:, 0], exact, rtol=0, atol=1e-9)
    assert balance(result) < 1e-9


def test_a_servo_without_targets_holds_its_rest_angle():
    """The rest angle is the start value of the target angle."""
    scene = with_values(one_servo(joint_rest_angle=0.7), {"initial.angular_velocities": [0.0]})
    chain = Chain(scene)
    assert chain.get(["joint[1].target_angle", "joint[1].target_velocity"]).tolist() == [0.7, 0.0]
    assert "link[1].joint_rest_angle" not in chain.names
    result = simulate(scene)
    assert (result.angles == 0.7).all()
    with pytest.raises(SceneError, match="start value of the target angle"):
        chain.set("link[1].joint_rest_angle", 0.1)


def test_a_spring_equals_a_servo_with_constant_targets():
    scene = random_chain(3, "pinned")
    servo = with_values(scene, {"inputs.joint_targets": True})
    spring, follower = simulate(scene), simulate(servo)
    np.testing.assert_allclose(follower.angles, spring.angles, rtol=0, atol=1e-11)
    work = spring.energy["elastic"] - spring.energy["elastic"][0] + spring.energy["dissipated"]
    np.testing.assert_allclose(-follower.energy["supplied"], work, rtol=0, atol=1e-9)


def test_stiffness_and_damping_can_be_set_at_any_time():
    """Each phase is the decay from the state before; a value set and reset changes nothing."""
    chain = Chain(one_servo(joint_stiffness=0.0, joint_damping=0.0, joint_rest_angle=0.2))
    chain.step_to(0.5)
    assert chain.get("link[1].angle") == pytest.approx(0.7 + 0.75, abs=1e-12)
    chain.set({"link[1].joint_stiffness": STIFFNESS, "link[1].joint_damping": DAMPING})
    state = chain.save()
    chain.step_to(0.9)
    assert chain.get("link[1].angle") == pytest.approx(0.2 + decaying(0.4, 1.25, 1.5), abs=1e-10)
    end = chain.save()
    chain.restore(state)
    for time in (0.6, 0.75):
        chain.step_to(time)
        chain.set("link[1].joint_stiffness", 1.0)
        chain.set("link[1].joint_stiffness", STIFFNESS)
    chain.step_to(0.9)
    again = Chain(chain.scene)
    again.restore(end)
    assert chain.get("link[1].angle") == again.get("link[1].angle")


def test_without_targets_stiffness_and_damping_are_fixed():
    chain = Chain(random_chain(2, "pinned"))
    chain.step_to(0.1)
    with pytest.raises(SceneError, match="fixed parameter"):
        chain.set("link[2].joint_stiffness", 1.0)


def test_a_stiff_servo_ignores_the_communication_step():
    scene = one_servo(joint_stiffness=1e8, joint_damping=1e5)
    scene = with_values(scene, {"solver.tolerance": 1e-6, "initial.angular_velocities": [0.0]})
    target = {"joint[1].target_angle": lambda t: 0.7 + 0.2 * math.sin(t) ** 2}
    fine, coarse = (simulate(scene, inputs=target, output_step=step) for step in (1e-3, 0.1))
    assert np.abs(fine.angles[:, 0] - 0.7 - 0.2 * np.sin(fine.time) ** 2).max() < 1e-3
    np.testing.assert_allclose(fine.angles[::100], coarse.angles, rtol=0, atol=1e-15)
    assert coarse.statistics["rhs_evaluations"] < 3000


# --- limits of torque --------------------------------------------------------------------------------------


def test_a_drive_at_its_limit_accelerates_evenly_and_then_swings():
    """The acceleration is M/J from φ₀ until k φ = M; then the motion is harmonic until the other limit."""
    link = ROD | {"joint_stiffness": STIFFNESS, "joint_torque_limit": 2.0}
    result = simulate(chain_with_drives([link], {"angles": [0.7]}), stop_time=0.5)
    slack = 2.0 / STIFFNESS
    until = math.sqrt(2.0 * (0.7 - slack) * INERTIA / 2.0)
    speed, pace = 2.0 / INERTIA * until, math.sqrt(STIFFNESS / INERTIA)
    after = result.time - until
    swing = slack * np.cos(pace * after) - speed / pace * np.sin(pace * after)
    exact = np.where(after < 0.0, 0.7 - result.time**2 / INERTIA, swing)
    assert np.abs(exact[-1]) < slack
    np.testing.assert_allclose(result.angles[:, 0], exact, rtol=0, atol=1e-11)
    work = 0.5 * INERTIA * result.angular_velocities[:, 0] ** 2
    np.testing.assert_allclose(result.energy["supplied"], work, rtol=0, atol=1e-11)
    assert not result.energy["elastic"].any()


def test_motor_and_servo_saturate_together():
    link = ROD | SERVO | {"joint_torque_limit": 3.0}
    scene = chain_with_drives(
        [link], {"angles": [0.0]}, inputs={"joint_targets": True, "joint_torques": True}
    )
    scene = with_values(scene, {"outputs.loads": True})
    result = simulate(scene, inputs={"joint[1].torque": 7.0, "joint[1].target_angle": -5.0}, stop_time=0.1)
    assert result["joint[1].moment"][0] == pytest.approx(-3.0 * INERTIA / (INERTIA + ARMATURE), rel=1e-14)
    expected = -1.5 * result.time**2 / (INERTIA + ARMATURE)
    np.testing.assert_allclose(result.angles[:, 0], expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_fast_target_is_followed_at_a_drives_limit(method):
    """In every row the torque is that of the spring to the swinging target, cut at the limit."""
    limit, stiffness = 0.08, 22.0
    link = ROD | {"joint_stiffness": stiffness, "joint_torque_limit": limit}
    swing = {
        "form": "sine",
        "input": "joint[1].target_angle",
        "mean": 0.6,
        "amplitude": 1.0,
        "frequency": 18.0,
    }
    scene = chain_with_drives([link], {"angles": [0.0]}, **FOLLOWS, signals={"swing": swing})
    result = simulate(scene, stop_time=1.0, output_step=1e-3, method=method, tolerance=1e-7)
    spring_torque = stiffness * (result["joint[1].target_angle"] - result["joint[1].angle"])
    torque = INERTIA * result["link[1].angular_acceleration"]
    np.testing.assert_allclose(torque, np.clip(spring_torque, -limit, limit), rtol=0, atol=1e-5)


def test_a_limit_of_zero_is_no_drive():
    scene = random_chain(2, "pinned")
    zero = with_values(scene, {f"link[{i}].joint_torque_limit": 0.0 for i in (1, 2)})
    slack = {f"link[{i}].joint_{key}": 0.0 for i in (1, 2) for key in ("stiffness", "damping")}
    free = simulate(with_values(scene, slack))
    np.testing.assert_allclose(simulate(zero).angles, free.angles, rtol=0, atol=1e-12)


def functions_of(scene, seed=5):
    """Return smooth inputs for all joints."""
    rng, functions = np.random.default_rng(seed), {}
    for i in range(1 if scene.chain.base == "pinned" else 2, len(scene.chain.links) + 1):
        size, pace = rng.uniform(0.2, 1.0), rng.uniform(2.0, 8.0)
        functions[f"joint[{i}].target_angle"] = lambda t, a=size, w=pace: a * math.sin(w * t)
        functions[f"joint[{i}].target_velocity"] = lambda t, a=size, w=pace: a * w * math.cos(w * t)
        functions[f"joint[{i}].torque"] = lambda t, a=size: a * math.cos(3.0 * t)
    return functions


BOTH = {"inputs": {"joint_targets": True, "joint_torques": True}}


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize(("count", "base"), [(1, "pinned"), (4, "pinned"), (4, "free")])
def test_a_chain_of_limited_servos_moves_as_the_textbook_says(count, base, method):
    scene = random_chain(count, base, limits=True, **BOTH)
    scene = with_values(scene, {f"link[{i + 1}].joint_stiffness": 40.0 for i in range(count)})
    check_against_the_textbook(scene, 1.0, method, functions_of(scene))


def test_a_real_arm_moves_as_the_textbook_says():
    """All drives of the arm reach their limits."""
    check_against_the_textbook(load_scene("ur5e"), 0.2, "explicit")


def check_against_the_textbook(scene, stop_time, method, inputs=None):
    """Compare the state at a time [s], and the energy that the drives have supplied."""
    exact = DrivenChain(scene, inputs).reached(stop_time)
    tolerance = 1e-9 if method == "implicit" else TOLERANCE
    result = simulate(scene, stop_time, inputs=inputs, method=method, tolerance=tolerance)
    end = result.outputs[-1]
    state = [*end["point_position"][0], *end["angle"], *end["point_velocity"][0], *end["angular_velocity"]]
    np.testing.assert_allclose([*state, end["supplied"]], exact, rtol=0, atol=100 * tolerance)
    assert balance(result) < 1e3 * tolerance


VARIED = {
    "link[2].joint_armature": 2e-4,
    "link[2].joint_stiffness": 0.5,
    "link[3].joint_damping": 1e-4,
    "link[2].joint_torque_limit": 5e-3,
    "joint[2].target_angle": 5e-4,
    "joint[3].target_velocity": 5e-3,
}


@pytest.mark.full("more cases", but="explicit")
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_derivatives_through_limits_are_those_of_differences(method):
    scene = random_chain(3, "pinned", limits=True, **BOTH)
    scene = with_values(scene, {f"link[{i}].joint_stiffness": 40.0 for i in (1, 2, 3)})
    inputs = functions_of(scene)
    tolerance = 1e-10 if method == "implicit" else TOLERANCE
    result = simulate(scene, inputs=inputs, sensitivities=list(VARIED), method=method, tolerance=tolerance)
    assert not result.sensitivity_limits

    def run(name, by):
        if name in inputs:
            changed, more = scene, inputs | {name: lambda t: inputs[name](t) + by}
        else:
            changed, more = with_values(scene, {name: scene.values[name] + by}), inputs
        return simulate(changed, inputs=more, tolerance=1e-13)["point[3].x"]

    for name, step in VARIED.items():
        exact = slope(partial(run, name), 0.0, step, 6)
        derivative = result.sensitivity("point[3].x", name)
        assert np.abs(derivative - exact).max() < 1e-8 * np.abs(exact).max(), name


@pytest.mark.parametrize("method", ["auto", "explicit", "implicit"])
@pytest.mark.parametrize("tolerance", [1e-8, 1.3e-9], ids=str)
def test_a_peak_where_a_drive_leaves_its_limit_has_its_derivative(method, tolerance):
    """The load of joint 1 is largest at 63.7 ms, where it falls at once as a drive leaves its limit."""
    drives = [(159.62, 68.179, 3.26), (16608.69, 2.529, 64.59), (44931.53, 39.237, 57.55)]
    links = [
        {"length": length, "mass": mass, "joint_armature": 0.01}
        | dict(zip(("joint_stiffness", "joint_damping", "joint_torque_limit"), drive, strict=True))
        for length, mass, drive in zip((0.477, 0.473, 0.411), (0.656, 3.899, 0.225), drives, strict=True)
    ]
    table = {
        "name": "Falls",
        "chain": {"base": "pinned", "links": links},
        "box": {"y_min": -0.5},
        "contact": {"restitution": 0.3, "stiffness": 1e6},
        "initial": {"angles": [0.144, -0.096, -0.011]},
        "outputs": {"loads": True},
        "solver": {"method": method, "tolerance": tolerance},
        **FOLLOWS,
    }
    scene, name = scene_from_dict(table, "falls"), "link[1].mass"
    result = simulate(scene, 0.064, output_step=math.inf, sensitivities=[name])
    # differences of two steps, at a tolerance of 1e-12
    for joint, exact in ((1, 11.83604), (2, -23.10055)):
        assert result.sensitivity(f"joint[{joint}].peak_force", name)[-1] == pytest.approx(exact, rel=1e-5)


def test_derivatives_hold_where_targets_and_stiffness_are_set_on_the_way():
    """The derivative is by a constant that is added to all set values."""
    steps = {
        "link[2].joint_stiffness": 0.05,
        "link[2].joint_torque_limit": 1e-3,
        "joint[1].target_angle": 1e-3,
    }
    scene = random_chain(2, "pinned", limits=True, **FOLLOWS)
    stiff = {f"link[{i}].joint_stiffness": 40.0 for i in (1, 2)} | {"link[1].joint_torque_limit": 30.0}
    scene = with_values(scene, stiff | {"outputs.sensitivities": list(steps)})

    def end(name="", change=0.0):
        chain = Chain(scene)
        if name:
            chain.set(name, chain.get(name) + change)
        for time, given in ((0.2, {"joint[1].target_angle": 1.5}), (0.4, {"link[2].joint_stiffness": 60.0})):
            chain.step_to(time)
            chain.set({key: value + change * (key == name) for key, value in given.items()})
        chain.step_to(0.7)
        return chain

    end_chain = end()
    for name, step in steps.items():
        exact = slope(lambda by, name=name: end(name, by).get("point[2].x"), 0.0, step, 6)
        result = end_chain.get(f"sensitivity.{name}.point[2].x")
        assert result == pytest.approx(exact, rel=1e-7), name
        assert abs(result) > 1e-5


def test_a_state_is_restored_bit_by_bit_while_a_drive_is_at_its_limit():
    chain = Chain(random_chain(2, "pinned", limits=True, **FOLLOWS))
    chain.set({"link[1].joint_stiffness": 200.0, "joint[1].target_angle": 2.0})
    chain.step_to(0.05)
    assert instance_of(chain).record["drive"]["mode"][0] != 0
    state = chain.save()
    chain.step_to(0.6)
    first = chain.save()
    chain.restore(state)
    chain.step_to(0.6)
    assert chain.save() == first


def test_targets_need_their_key():
    scene = random_chain(1, "pinned")
    for name in ("joint[1].target_angle", "joint[1].target_velocity"):
        with pytest.raises(SceneError, match="joint_targets"):
            simulate(scene, inputs={name: 1.0})
        with pytest.raises(SceneError, match="joint_targets"):
            Chain(scene).set(name, 1.0)


def test_an_accelerated_base_acts_as_gravity_on_limited_servos():
    scene = random_chain(3, "pinned", limits=True, **FOLLOWS)
    scene = with_values(scene, {f"link[{i}].joint_stiffness": 40.0 for i in (1, 2, 3)})
    inputs = {name: f for name, f in functions_of(scene).items() if "target" in name}
    moved = with_values(scene, {"inputs.base_motion": True})
    accelerated = simulate(moved, inputs=inputs | {"base.x": lambda t: 2.5 * t * t})
    leaning = simulate(with_values(scene, {"gravity": [-5.0, scene.gravity[1]]}), inputs=inputs)
    np.testing.assert_allclose(accelerated.angles, leaning.angles, rtol=0, atol=1e-10)
    assert balance(accelerated) < 1e-9


def test_loads_of_a_very_stiff_servo_are_as_accurate_as_the_docs_say():
    scene = load_scene("pinned_arm")
    links = range(1, len(scene.chain.links) + 1)
    servo = {"joint_stiffness": 1e7, "joint_damping": 1e3, "joint_armature": 0.05}
    changes = {f"link[{i}].{key}": value for i in links for key, value in servo.items()}
    scene = with_values(scene, {"outputs.loads": True, "inputs.joint_targets": True, **changes})
    angles = np.diff(scene.initial.angles, prepend=0.0)
    inputs = {
        f"joint[{i}].target_angle": lambda t, start=start: start + 0.3 * np.sin(7.0 * t)
        for i, start in zip(links, angles, strict=True)
    }
    loads_of_run, exact = (
        simulate(scene, inputs=inputs, stop_time=0.3, output_step=1e-3, tolerance=tolerance)
        for tolerance in (scene.solver.tolerance, 1e-12)
    )
    loads = [f"joint[{i}].{load}" for i in links for load in ("force.x", "force.y", "moment")]
    off = [np.abs(loads_of_run[name] - exact[name]).max() / np.abs(exact[name]).max() for name in loads]
    # the stiffness amplifies the rounding errors of the followed angles, which depend on the processor
    assert 1e-7 < max(off) < 1e-4

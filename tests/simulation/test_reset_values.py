"""Values that are set, observed and reset leave no trace: the run goes on as without them."""

# Tests: simulation/chain.py

import numpy as np
import pytest

from chain_impact import Chain, SimulationError, load_scene
from chain_impact.scene.errors import SceneError
from tests.helpers.campaigns.random_scenes import scene as random_scene
from tests.helpers.kernel.kernel_calls import instance_of

STEPS = 40
DRIVEN = {"inputs.tip_force": True, "inputs.joint_torques": True}
DERIVED_WITH = {**DRIVEN, "outputs.sensitivities": ["link[1].mass", "contact.restitution"]}
RIGID = {"contact.model": "newton_impact", "contact.restitution": 0.0}
SCENES = {
    "four_link_box": DRIVEN,
    "kneed_leg": DRIVEN,  # stops
    "sliding_rod": DRIVEN,  # dry friction
    "falling_arm": DRIVEN | RIGID,
    "clattering_rod": DERIVED_WITH,
    "double_pendulum_wall": DERIVED_WITH | RIGID,
}


def bits(chain, names):
    return np.array(chain.get(names)).tobytes()


def try_inputs(chain, variables, rng):
    """Read the outputs under random inputs, reset the inputs, and return outputs with forbidden changes."""
    inputs = [v.name for v in variables if v.causality == "input"]
    held = [v.name for v in variables if v.causality == "output" and not v.feedthrough]
    before, old = np.array(chain.get(held)), dict(zip(inputs, chain.get(inputs), strict=True))
    chain.set({name: float(rng.normal()) for name in inputs})
    after = np.array(chain.get(held))
    assert len(chain.impacts) == chain.get("impact.count")
    chain.set(old)
    return [name for name, a, b in zip(held, before, after, strict=True) if a.tobytes() != b.tobytes()]


@pytest.mark.parametrize(("name", "changes"), SCENES.items(), ids=SCENES)
def test_values_that_are_reset_move_only_what_is_declared(name, changes):
    scene = load_scene(name).with_values(changes)
    tried, alone, rng = Chain(scene), Chain(scene), np.random.default_rng(5)
    variables, moved = instance_of(tried).prepared_scene.variables, set()
    names = [v.name for v in variables]
    for k in range(1, STEPS + 1):
        time = scene.simulation.stop_time * k / STEPS
        for chain in (tried, alone):
            if k % 10 == 0:  # at some steps an input changes permanently
                chain.set("tip.force.x", 0.01 * k)
            chain.step_to(time)
        moved.update(try_inputs(tried, variables, rng))
        assert bits(tried, names) == bits(alone, names)
    assert not moved
    assert tried.get("impact.count") > 0


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("number", range(12))
def test_random_scenes_go_on_as_without_values_that_are_reset(number):
    scene = random_scene(7000000 + number).with_values(DRIVEN)
    tried, alone, rng = Chain(scene), Chain(scene), np.random.default_rng(number)
    variables = instance_of(tried).prepared_scene.variables
    for k in range(1, 9):
        for chain in (tried, alone):
            chain.step_to(scene.simulation.stop_time * k / 8)
        assert not try_inputs(tried, variables, rng)
    names = [v.name for v in variables]
    assert bits(tried, names) == bits(alone, names)
    assert tried.impacts.tobytes() == alone.impacts.tobytes()


def test_a_parameter_that_is_set_back_leaves_no_trace():
    tried, alone = Chain("four_link_box"), Chain("four_link_box")
    for chain in (tried, alone):
        chain.step(0.31)
    energy, stiffness = tried.get("energy.total"), tried.get("contact.stiffness")
    tried.set("contact.stiffness", 1e4)
    tried.get("energy.total")
    tried.set({"contact.model": "tsuji", "contact.restitution": 0.0})
    with pytest.raises(SceneError, match="the wall x_min"):
        tried.get("energy.total")
    tried.set({"contact.stiffness": stiffness, "contact.model": "zhang_sharf", "contact.restitution": 0.7})
    assert tried.get("energy.total") == energy
    for chain in (tried, alone):
        chain.step(0.5)
    assert bits(tried, list(tried.names)) == bits(alone, list(alone.names))


def test_static_friction_below_sliding_friction_is_refused():
    name, value = "wall.y_min.static_friction", 0.01
    with pytest.raises(SceneError, match=r"static_friction .*0\.01"):
        load_scene("sliding_rod").with_values({name: value})
    chain = Chain("sliding_rod")
    chain.step(0.3)
    chain.set(name, value)
    with pytest.raises(SceneError, match=r"static_friction is below friction.*point 0 at the wall y_min"):
        chain.get("energy.total")
    with pytest.raises(
        SimulationError, match=r"static_friction is below friction.*point 0 at the wall y_min"
    ):
        chain.step(0.4)

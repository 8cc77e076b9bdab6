"""Values that are set, observed and reset leave no trace: the run goes on as without them."""

# Tests: simulation/chain.py

import numpy as np
import pytest

from chain_impact import Chain, SimulationError, load_scene
from chain_impact.scene.errors import SceneError
from tests.helpers.campaigns.random_scenes import scene as random_scene
from tests.helpers.kernel.kernel_calls import instance_of

STEPS = 40
WITH_INPUTS = {"inputs.tip_force": True, "inputs.joint_torques": True}
DERIVED_WITH = {**WITH_INPUTS, "outputs.sensitivities": ["link[1].mass", "contact.restitution"]}
RIGID = {"contact.model": "newton_impact", "contact.restitution": 0.0}
SCENES = {
    "four_link_box": WITH_INPUTS,
    "kneed_leg": WITH_INPUTS,  # stops
    "sliding_rod": WITH_INPUTS,  # dry friction
    "falling_arm": WITH_INPUTS | RIGID,
    "clattering_rod": DERIVED_WITH,
    "double_pendulum_wall": DERIVED_WITH | RIGID,
}


def bits(chain, names):
    return np.array(chain.get(names)).tobytes()


def try_inputs(chain, variables, rng):
    """Set random inputs, reset them, and return the outputs without feedthrough that the inputs changed."""
    inputs = [v.name for v in variables if v.causality == "input"]
    names = [v.name for v in variables if v.causality == "output" and not v.feedthrough]
    values, old_inputs = np.array(chain.get(names)), dict(zip(inputs, chain.get(inputs), strict=True))
    chain.set({name: float(rng.normal()) for name in inputs})
    values_with_inputs = np.array(chain.get(names))
    assert len(chain.impacts) == chain.get("impact.count")
    chain.set(old_inputs)
    return [
        name
        for name, a, b in zip(names, values, values_with_inputs, strict=True)
        if a.tobytes() != b.tobytes()
    ]


@pytest.mark.parametrize(("name", "changes"), SCENES.items(), ids=SCENES)
def test_values_that_are_reset_move_only_what_is_declared(name, changes):
    scene = load_scene(name).with_values(changes)
    tried_chain, plain_chain, rng = Chain(scene), Chain(scene), np.random.default_rng(5)
    variables, changed_names = instance_of(tried_chain).prepared_scene.variables, set()
    names = [v.name for v in variables]
    for k in range(1, STEPS + 1):
        time = scene.simulation.stop_time * k / STEPS
        for chain in (tried_chain, plain_chain):
            if k % 10 == 0:  # at some steps an input changes permanently
                chain.set("tip.force.x", 0.01 * k)
            chain.step_to(time)
        changed_names.update(try_inputs(tried_chain, variables, rng))
        assert bits(tried_chain, names) == bits(plain_chain, names)
    assert not changed_names
    assert tried_chain.get("impact.count") > 0


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("number", range(12))
def test_random_scenes_go_on_as_without_values_that_are_reset(number):
    scene = random_scene(7000000 + number).with_values(WITH_INPUTS)
    tried_chain, plain_chain, rng = Chain(scene), Chain(scene), np.random.default_rng(number)
    variables = instance_of(tried_chain).prepared_scene.variables
    for k in range(1, 9):
        for chain in (tried_chain, plain_chain):
            chain.step_to(scene.simulation.stop_time * k / 8)
        assert not try_inputs(tried_chain, variables, rng)
    names = [v.name for v in variables]
    assert bits(tried_chain, names) == bits(plain_chain, names)
    assert tried_chain.impacts.tobytes() == plain_chain.impacts.tobytes()


def test_a_parameter_that_is_set_back_leaves_no_trace():
    tried_chain, plain_chain = Chain("four_link_box"), Chain("four_link_box")
    for chain in (tried_chain, plain_chain):
        chain.step(0.31)
    energy, stiffness = tried_chain.get("energy.total"), tried_chain.get("contact.stiffness")
    tried_chain.set("contact.stiffness", 1e4)
    tried_chain.get("energy.total")
    tried_chain.set({"contact.model": "tsuji", "contact.restitution": 0.0})
    with pytest.raises(SceneError, match="the wall x_min"):
        tried_chain.get("energy.total")
    tried_chain.set(
        {"contact.stiffness": stiffness, "contact.model": "zhang_sharf", "contact.restitution": 0.7}
    )
    assert tried_chain.get("energy.total") == energy
    for chain in (tried_chain, plain_chain):
        chain.step(0.5)
    assert bits(tried_chain, list(tried_chain.names)) == bits(plain_chain, list(plain_chain.names))


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

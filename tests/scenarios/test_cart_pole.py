"""The co-simulation of a cart-pole and the controller that balances the pole."""

import numpy as np
import pytest

from chain_impact import Chain, load_scene
from tests.helpers.scenes.model_files import co_simulated

STEP, ROWS = 5e-3, 1201  # s


@pytest.mark.full("builds two FMUs")
def test_the_controller_balances_the_pole_through_impact_and_push(tmp_path):
    """The reference is a Chain that a Python loop steps with the same gains."""
    columns = co_simulated("cart_pole", tmp_path, "--plot", tmp_path / "cart.png")
    assert (tmp_path / "cart.png").stat().st_size > 10_000
    assert columns["impact.count"][-1] == 1
    assert abs(columns["link[1].angle"][-1] - np.pi / 2) < 1e-3
    assert abs(columns["slider.position"][-1]) < 1e-2
    gains = {"slider.position": 20.0, "link[1].angle": -83.7}
    gains |= {"slider.velocity": 18.2, "link[1].angular_velocity": -16.3}
    chain, angles, force = Chain(load_scene("cart_pole")), [], 0.0
    for _ in range(ROWS):
        state = {name: chain.get(name) for name in gains}
        angles.append(state["link[1].angle"])
        chain.set("slider.force", force)
        # the value sampled at the start of a step acts from the end of the step
        force = sum(gain * state[name] for name, gain in gains.items()) + 83.7 * np.pi / 2
        chain.step(STEP)
    np.testing.assert_allclose(columns["link[1].angle"], angles, rtol=0.0, atol=1e-6)

"""Studies of scenes with dry friction: laws side by side, sweeps, fits and derivatives."""

from functools import partial

import numpy as np
import pytest

from chain_impact import Chain, compare, fit, load_scene, simulate, sweep
from chain_impact.scene.errors import UnknownNameError
from tests.helpers.scenes.friction import SLOPE, puck, sled, thrown
from tests.helpers.tools.refusal import refusal

HINT = "it is a parameter if the scene has this dry friction: give it a value in the scene file first"


def test_laws_are_compared_with_friction_but_for_rigid_walls():
    result = compare(puck(), laws=["flores", "zhang_sharf", "newton_impact"])
    assert result["newton_impact"].result is None
    assert result["newton_impact"].note.startswith("contact.friction = 0.2 must be 0 for the contact model")
    assert result["flores"].result["energy.friction"][-1] > 0.5


@pytest.mark.parametrize("scene", [thrown(), load_scene("rod_drop")], ids=["friction", "no friction"])
def test_the_loop_of_the_first_impact_is_that_of_the_normal_force(scene):
    (run,) = compare(scene, laws=["zhang_sharf"]).runs
    depth, force = run.loop
    assert force.max() == pytest.approx(run.peak_force, rel=1e-3)
    assert depth.max() == pytest.approx(run.max_penetration, rel=1e-3)
    first, chain = run.result.impacts[0], Chain(scene)
    chain.step_to(first["onset"])
    lost = chain.get("energy.dissipated")
    chain.step_to(first["end"])
    assert run.energy_lost == pytest.approx(chain.get("energy.dissipated") - lost, rel=1e-9)


def test_a_sweep_over_friction_gives_what_single_runs_give():
    columns = [
        "point[0].x",
        "energy.friction",
        "contact[0].slope.sticking",
        "contact[0].slope.friction_impulse",
    ]
    table = sweep(puck(), {"contact.friction": [0.0, 0.2, 0.5]}, outputs=columns)
    for k, friction in enumerate(table["contact.friction"][1:], 1):
        alone = simulate(puck(**{"contact.friction": friction}))
        for name in columns:
            assert table[name][k] == alone[name][-1], name
    assert (table["energy.friction"][0], table["contact[0].slope.friction_impulse"][0]) == (0.0, 0.0)
    assert table["contact[0].slope.sticking"].tolist() == [0.0, 0.0, 1.0]


def test_a_sweep_over_laws_tells_which_one_has_no_friction():
    table = sweep(puck(), {"contact.model": ["flores", "newton_impact"]})
    assert table["status"].tolist() == ["ok", "friction_with_rigid_walls"]


def measured():
    result, noise = simulate(puck(), output_step=0.05), np.random.default_rng(7)
    x = result["point[0].x"] + 1e-4 * noise.standard_normal(len(result.time))
    return {"time": result.time, "point[0].x": x}


@pytest.mark.parametrize("start", [0.1, 0.35])
def test_a_coefficient_is_fitted_to_a_measured_motion(start):
    """The puck slides up and back down, because µ < tan β."""
    result = fit(puck(**{"contact.friction": start}), measured(), ["contact.friction"])
    assert result.converged
    error = result.standard_errors["contact.friction"]
    assert abs(result.values["contact.friction"] - 0.2) < 4.0 * error
    assert error < 1e-4
    assert np.tan(SLOPE) > 0.35


@pytest.mark.parametrize("name", ["contact.friction", "contact.static_friction", "link[2].joint_friction"])
def test_the_friction_of_a_scene_that_has_none_is_no_parameter_yet(name):
    scene = thrown(**{"wall.y_min.friction": None, "link[2].joint_friction": None})
    refused = [
        refusal(sweep, scene, {name: [0.1, 0.2]}),
        refusal(fit, scene, measured(), [name]),
        refusal(partial(simulate, sensitivities=[name]), scene),
        refusal(Chain(scene).set, name, 0.1),
    ]
    assert all(text.startswith(f"Thrown: {name} is not a ") and text.endswith(HINT) for text in refused)
    with pytest.raises(UnknownNameError, match=r"wall\.y_min\.friction is not a parameter"):
        sweep(scene, {"wall.y_min.friction": [0.1]})


def test_a_sled_with_two_contacts_at_one_moment_has_no_derivatives():
    result = simulate(sled(), 0.1, sensitivities=["contact.friction"])
    assert "several points arrive at one moment" in result.sensitivity_limits[0]

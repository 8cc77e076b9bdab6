"""Requests to an instance with derivatives: any times, any number of parameters, any pieces."""

import math

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.kernel.tangent import duals
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.simulate import simulate
from tests.helpers.scenes.derivative_scenes import Case, struck_twice
from tests.helpers.tools.differences import slope
from tests.kernel.tangent.dual import followed, started

CASE = struck_twice("flores")
NAMES = CASE.parameters[: 2 * duals.DIRECTIONS + 1]
TIMES = np.linspace(0.0, 0.3, 31)


def case_with(*names):
    return Case(CASE.scene, names, CASE.times)


@pytest.fixture(scope="module")
def together():
    return followed(started(case_with(*NAMES)), TIMES)


def test_the_number_of_parameters_beside_one_does_not_matter(together):
    """Several instances of dual numbers carry the parameters, one after the other."""
    values, slopes = together
    for k in (0, duals.DIRECTIONS - 1, duals.DIRECTIONS, 2 * duals.DIRECTIONS):
        alone, slope = followed(started(case_with(NAMES[k])), TIMES)
        np.testing.assert_array_equal(alone, values)
        np.testing.assert_array_equal(slope[..., 0], slopes[..., k])


def test_the_pieces_in_which_a_run_is_made_do_not_matter(together):
    instance = started(case_with(*NAMES))
    pieces = [followed(instance, part) for part in np.array_split(TIMES, 5)]
    np.testing.assert_array_equal(np.concatenate([values for values, _ in pieces]), together[0])
    np.testing.assert_array_equal(np.concatenate([slopes for _, slopes in pieces]), together[1])


def test_impacts_are_followed_to_the_communication_point():
    """The largest force of a contact until then, and its derivative, equal those of the run."""
    names = ("contact.stiffness", "contact.restitution")
    onset = simulate(CASE.scene).impacts["onset"][0]
    at = onset + 4e-4
    scene = CASE.scene.with_values({"simulation.stop_time": at, "simulation.step_size": at})
    result = simulate(scene, tolerance=1e-12, sensitivities=names)
    assert np.isnan(result.impacts["end"]).tolist() == [True]
    derivatives = {name: result.impact_sensitivity("peak_force", name)[0] for name in names}

    def peak(values):
        return simulate(scene.with_values(values), tolerance=1e-12).impacts["peak_force"][0]

    for name in names:
        value = scene.values[name]
        expected = slope(lambda changed, name=name: peak({name: changed}), value, 1e-4 * value)
        assert derivatives[name] == pytest.approx(expected, rel=1e-6)
        assert np.isnan(result.impact_sensitivity("end", name)).all()
        assert np.isfinite(result.impact_sensitivity("impact_speed", name)).all()


def test_a_log_that_is_full_is_emptied_on_the_way():
    """A ball bounces more often between two rows than the log has room for: t_n − t_1 = 2 v Σ eᵏ/g."""
    name = "contact.restitution"
    scene = load_scene("bouncing_ball")
    result = simulate(scene, output_step=math.inf, sensitivities=name)
    impacts, e = result.impacts, scene.contact.restitution
    assert len(impacts) > len(Instance(scene).record["contact_log"]["point"])
    powers = np.arange(1, len(impacts))
    terms = 2.0 * impacts["impact_speed"][0] / -scene.gravity[1] * powers * e ** (powers - 1.0)
    bounces = 40  # bounces before rest
    derivatives = result.impact_sensitivity("onset", name)
    np.testing.assert_allclose(derivatives[1:bounces], np.cumsum(terms)[: bounces - 1], rtol=1e-6)
    often = simulate(scene, sensitivities=name)
    np.testing.assert_allclose(derivatives, often.impact_sensitivity("onset", name), rtol=1e-9)

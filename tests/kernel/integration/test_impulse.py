"""Impulses of the walls: what gravity and they give is what the chain's momentum changes by."""

from dataclasses import replace

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.simulation.instance import Instance
from tests import random_scenes
from tests.problems import GRAVITY, default_scene, dropped_ball, of_law
from tests.reference import momenta


def unbalanced(result):
    """The momentum [N·s] at each communication point that neither gravity nor the walls have given."""
    scene = result.scene
    momentum, _ = momenta(result)
    mass = sum(link.mass for link in scene.chain.links)
    walls = [scene.half_planes[scene.wall_names[wall]].normal for _, wall in candidates(scene)]
    given = result.outputs["impulse"] @ np.array(walls) + mass * np.outer(result.time, scene.gravity)
    return abs(momentum - momentum[0] - given).max()


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_momentum_balances_at_every_communication_point_under_every_law(law):
    result = simulate(default_scene(**of_law(law)), tolerance=1e-10)
    assert len(result.impacts) >= 5
    assert unbalanced(result) < 1e-8


@pytest.mark.full("takes long")
@pytest.mark.parametrize("method", ["auto", "implicit"])
def test_inside_of_an_impact_too(method):
    """In the first impact of the default scene, every 2 µs."""
    scene = load_scene("four_link_box")
    first = simulate(scene).impacts[0]
    result = simulate(scene, first["end"], 2e-6, method, 1e-9)
    inside = (result.time > first["onset"]) & (result.time < first["end"])
    assert inside.sum() > 100
    assert unbalanced(result) < 1e-6


def test_the_imbalance_falls_with_the_tolerance():
    off = [unbalanced(simulate(default_scene(), tolerance=tol)) for tol in (1e-4, 1e-6, 1e-8, 1e-10)]
    assert off == sorted(off, reverse=True)
    assert off[-1] < 1e-4 * off[0]


@pytest.mark.parametrize("law", ["zhang_sharf", "newton_impact"])
def test_a_rod_that_comes_to_rest(law):
    """Points that lie on the floor are held by the weight, explicitly, implicitly or by a rigid wall."""
    result = simulate(with_values(load_scene("rod_drop"), {"contact.model": law}), 6.0, tolerance=1e-9)
    assert unbalanced(result) < 1e-7
    weight = GRAVITY * sum(link.mass for link in result.scene.chain.links)
    change = result.outputs["impulse"][-1].sum() - result.outputs["impulse"][-1001].sum()
    assert change == pytest.approx(weight, rel=1e-6)  # in the last second


def test_a_bounce_has_the_impulse_of_its_change_of_speed():
    scene, _ = dropped_ball(model="newton_impact", restitution=0.6)
    impact = simulate(scene).impacts[0]
    mass = scene.chain.links[0].mass
    assert impact["impulse"] == pytest.approx(mass * 1.6 * impact["impact_speed"], rel=1e-12)


@pytest.mark.parametrize("law", ["hertz", "zhang_sharf", "kelvin_voigt"])
def test_each_impact_has_its_own(law):
    """In free fall m (v⁺ + v⁻) + m g T, whatever the force."""
    scene, _ = dropped_ball(stop_time=1.5, **of_law(law))
    mass = scene.chain.links[0].mass
    for impact in simulate(scene, tolerance=1e-11).impacts[:3]:
        change = impact["impact_speed"] + impact["separation_speed"]
        weight = GRAVITY * (impact["end"] - impact["onset"])
        assert impact["impulse"] == pytest.approx(mass * (change + weight), rel=1e-8)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_points_that_a_rigid_wall_releases_have_the_integral_of_their_force(tolerance):
    """A chain lies on the floor, and its tip is drawn up: one point after the other leaves."""
    lying = {
        "name": "Drawn",
        "chain": {"links": [{"length": 0.5, "mass": 1.0}] * 3},
        "box": {"y_min": 0.0},
        "contact": {"model": "newton_impact", "restitution": 0.0},
        "inputs": {"tip_force": True},
        "initial": {"angles": [0.0] * 3},
    }
    result = simulate(
        scene_from_dict(lying, "lying"),
        0.5,
        1e-4,
        tolerance=tolerance,
        inputs={"tip.force.y": lambda t: 60.0 * t, "tip.force.x": lambda t: 3.0 * t},
    )
    force, impulse = result.outputs["force"], result.outputs["impulse"]
    floor = force.max(axis=0) > 0.0
    assert floor.sum() == 4
    assert (force[-1, floor] == 0.0).sum() >= 2, "released"
    # where no row is between a force and its end, by Simpson's rule
    released = (force[2::2] == 0.0) != (force[:-2:2] == 0.0)
    steps = (force[:-2:2] + 4.0 * force[1:-1:2] + force[2::2]) / 6.0 * 2e-4
    errors = np.where(released, 0.0, np.abs(np.diff(impulse[::2], axis=0) - steps)).sum(axis=0)
    assert errors.max() < 300.0 * tolerance * impulse.max()


def test_they_do_not_depend_on_communication_points():
    scene = load_scene("four_link_box")
    coarse, fine = (simulate(scene, output_step=step) for step in (0.1, 1e-3))
    np.testing.assert_array_equal(coarse.outputs["impulse"], fine.outputs["impulse"][::100])
    np.testing.assert_array_equal(coarse.impacts["impulse"], fine.impacts["impulse"])


def test_an_input_that_changes_in_an_impact_does_not_lose_any():
    scene = with_values(load_scene("four_link_box"), {"inputs.tip_force": True})
    onset = simulate(scene).impacts[0]["onset"]
    times = onset + np.array([-1e-4, 2e-5, 5e-5, 1e-4])
    result = simulate(scene, inputs={"tip.force.x": (times, [0.0, 5.0, -5.0, 0.0])}, tolerance=1e-10)
    free = simulate(scene, tolerance=1e-10)
    pushed = 5.0 * (times[2] - times[1]) - 5.0 * (times[3] - times[2])
    row = np.searchsorted(result.time, times[-1])
    momentum, _ = momenta(result)
    mass = sum(link.mass for link in scene.chain.links)
    change = momentum[row] - momentum[0] - mass * result.time[row] * np.array(scene.gravity)
    floor = np.array([wall == 2 for _, wall in candidates(scene)])
    assert change[1] == pytest.approx(result.outputs["impulse"][row, floor].sum(), abs=1e-8)
    assert change[0] == pytest.approx(pushed, abs=1e-8)
    assert free.impacts[0]["impulse"] == pytest.approx(result.impacts[0]["impulse"], rel=1e-2)


def test_without_them_the_motion_is_the_same_bit_by_bit():
    scene = load_scene("four_link_box")
    without = replace(scene, outputs=replace(scene.outputs, contacts=False, impacts=0))
    assert Instance(without).record["impulse"]["wanted"] == 0
    one, other = simulate(scene), simulate(without)
    for name in ("point_position", "point_velocity", "force", "dissipated"):
        np.testing.assert_array_equal(one.outputs[name], other.outputs[name])
    assert not other.outputs["impulse"].any()
    assert one.statistics == other.statistics


@pytest.mark.parametrize(
    ("seed", "law"), [(14, "kuwabara_kono"), (30, "kuwabara_kono"), (124, "kelvin_voigt"), (157, "tsuji")]
)
def test_none_falls_where_the_force_ends_before_the_contact(seed, law):
    """From row to row, by more than the tolerance of what all of the chain has as momentum."""
    drawn = random_scenes.scene(seed)
    changes = {f"contact.{key}": value for key, value in of_law(law).items()}
    scene = drawn.with_values(changes | {"contact.restitution": max(0.05, drawn.contact.restitution)})
    result = simulate(scene, output_step=scene.simulation.stop_time / 2000)
    links = scene.chain.links
    speed = max(link.length for link in links) + result.impacts["impact_speed"].max()
    momentum = sum(link.mass for link in links) * speed
    falls = -np.diff(result.outputs["impulse"], axis=0).min()
    assert falls <= scene.solver.tolerance * momentum

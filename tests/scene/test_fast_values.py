"""Changed numbers without a new reading of the whole scene."""

import math

import pytest

from chain_impact import SceneError, SceneWarning, load_scene
from chain_impact.scene import scene as module
from chain_impact.scene.fast_values import with_numbers

MODELS = ("four_link_box", "pinned_arm", "kneed_leg", "ramp", "rod_drop")


def slow(scene, changes, monkeypatch):
    """Return the scene with changed values, by a new reading of the whole scene."""
    with monkeypatch.context() as patch:
        patch.setattr(module, "with_numbers", lambda *_: None)
        return scene.with_values(changes)


@pytest.mark.full("more cases", but=["four_link_box", "pinned_arm"])
@pytest.mark.parametrize("model", MODELS)
def test_a_changed_number_gives_the_scene_of_a_full_read(model, monkeypatch):
    scene, quick_count = load_scene(model), 0
    for name, value in scene.values.items():
        if isinstance(value, float):
            for new_value in (1.01 * value + 0.001, 0.0, -1.0, value):
                result = with_numbers(scene, {name: new_value})
                quick_count += result is not None
                if result is not None:
                    assert result == slow(scene, {name: new_value}, monkeypatch)
                    assert result.derived_paths == scene.derived_paths
    assert quick_count > 10


def test_several_numbers_and_a_path(monkeypatch):
    scene = load_scene("four_link_box")
    changes = {"link[2].mass": 2, ("gravity", 1): -1.6, "initial.angle[1]": 0.3, "initial.vx": 1.0}
    assert scene.with_values(changes) == slow(scene, changes, monkeypatch)
    simple = {name: value for name, value in changes.items() if name != ("gravity", 1)}
    assert with_numbers(scene, simple) == slow(scene, simple, monkeypatch)


def test_an_inertia_that_is_derived_follows_the_mass():
    scene = load_scene("four_link_box")
    changed_scene = with_numbers(scene, {"link[2].mass": 3.0})
    assert ("chain", "links", 1, "inertia") in scene.derived_paths
    assert changed_scene.chain.links[1].inertia == pytest.approx(
        3.0 * changed_scene.chain.links[1].length ** 2 / 12
    )


@pytest.mark.parametrize(
    "changes",
    [
        {"contact.restitution": 1.3},
        {"contact.restitution": float("nan")},
        {"contact.restitution": 10**400},
        {"contact.restitution": "0.5"},
        {"contact.restitution": True},
        {"contact.restitution": None},
        {"link[5].mass": 1.0},
        {"initial.x": 1e3},
        {"initial.angle[9]": 0.0},
        {"initial.angle[1]": 7.0},
        {"simulation.step_size": 1e3},
    ],
    ids=str,
)
def test_changes_beyond_numbers_are_left_to_the_reader(changes):
    assert with_numbers(load_scene("four_link_box"), changes) is None


def test_faults_are_told_as_ever():
    scene = load_scene("four_link_box")
    with pytest.raises(SceneError, match=r"contact.restitution = 1.3 must be a finite number >= 0 and <= 1"):
        scene.with_values({"contact.restitution": 1.3})
    with pytest.raises(SceneError, match=r"initial: point 0 at .* deep in the wall x_max"):
        scene.with_values({"initial.x": 1e3})


def test_a_fast_change_of_the_start_leaves_each_warning_to_the_reader():
    arm = load_scene("pinned_arm")
    changes = {"initial.x": arm.box.x_max + 0.1, "initial.angle[1]": math.pi, "initial.angle[2]": math.pi}
    with pytest.warns(SceneWarning, match=r"pinned base .* is 0\.1 m beyond the wall x_max"):
        arm.with_values(changes)
    arm_of_joint_angles = arm.with_values({"initial.joint_angles": [4.0, -4.0]})
    with pytest.warns(SceneWarning, match=r"initial\.joint_angles\[2\] = -8 rad is 1\.27 turns"):
        arm_of_joint_angles.with_values({"initial.angle[2]": -4.0})


def test_a_fast_change_of_a_mass_brings_the_hint_on_lengths():
    long_arm = load_scene("pinned_arm").with_values(
        {"box.x_max": None, "link[1].length": 25.0, "link[1].mass": 10.0}
    )
    assert with_numbers(long_arm, {"link[1].mass": 9.0}) is not None
    with pytest.warns(SceneWarning, match=r"link\[1\]\.length = 25 m is long .*: is it in mm\?"):
        long_arm.with_values({"link[1].mass": 1.0})

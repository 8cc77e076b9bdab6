"""Records of scenes that differ only in numbers: only these numbers are written again."""

# Tests: variables/shared_data.py

from dataclasses import replace

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.scene.asked_inputs import with_inputs
from chain_impact.variables import shared_data
from chain_impact.variables.prepared import PreparedScene

MODELS = ("four_link_box", "pinned_arm", "kneed_leg", "ramp", "sliding_rod", "controlled_arm")


def from_nothing(scene):
    shared_data._cache.clear()
    return PreparedScene(scene)


def same(result, expected):
    assert (result.candidates, result.counts, result.layout) == (
        expected.candidates,
        expected.counts,
        expected.layout,
    )
    assert result.outputs == expected.outputs
    assert result.parameters == expected.parameters
    assert result.output_indices.continuous == expected.output_indices.continuous
    assert result.new_instance().tobytes() == expected.new_instance().tobytes()


@pytest.mark.full("more cases", but=["four_link_box", "pinned_arm"])
@pytest.mark.parametrize("model", MODELS)
def test_a_record_is_the_one_of_a_scene_that_stands_alone(model):
    scene, compared_count = load_scene(model), 0
    for name, value in scene.values.items():
        # only real numbers; a coefficient of friction that is given, even as 0, decides which variables exist
        if not isinstance(value, float) or name in ("contact.friction", "contact.static_friction"):
            continue
        changes = {name: 0.99 * value if "position" not in name and "angle" not in name else value + 1e-9}
        try:
            changed_scene = scene.with_values(changes)
        except ValueError:
            continue
        expected = from_nothing(changed_scene)
        record = expected.new_instance().tobytes()
        from_nothing(scene).new_instance()
        result = PreparedScene(changed_scene)
        assert result.new_instance().tobytes() == record, name
        same(result, expected)
        compared_count += 1
    assert compared_count > 8


PINNED = {"chain.base": "pinned", "initial.velocity": [0.0, 0.0], "contact.points": [1, 2]}
CHANGES = [
    PINNED,
    {"contact.friction": 0.3},
    {"contact.model": "flores"},
    {"contact.points": [4]},
    {"box.x_max": None},
]
CHANGES += [{"link[2].joint_friction": 0.1}, {"link[2].inertia": 0.1}, {"inputs.tip_force": True}]
CASES = [("four_link_box", changes) for changes in [*CHANGES, {"outputs.impacts": 2}]]
CASES += [("pinned_arm", {"link[1].joint_min": -3.0})]
CASES += [("ramp", {"walls": [{"name": "ramp", "point": [0.0, 0.0], "angle": -0.2}]})]


@pytest.mark.parametrize(("model", "changes"), CASES, ids=str)
def test_a_change_of_more_than_numbers_makes_a_new_record(model, changes):
    scene = load_scene(model)
    changed_scene = scene.with_values(changes)
    expected = from_nothing(changed_scene)
    expected.new_instance()
    from_nothing(scene).new_instance()
    same(PreparedScene(changed_scene), expected)


def test_the_end_of_the_run_decides_on_the_end_of_a_table(tmp_path):
    """A table of positions ends at rest if the run lasts longer than the table."""
    (tmp_path / "motion.csv").write_text("time,base.y\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.02\n", "utf-8")
    scene = load_scene("pinned_arm").with_values({"inputs.base_motion": True, "simulation.stop_time": 0.2})
    short_scene = with_inputs(scene, tmp_path / "motion.csv")
    longer_scene = replace(short_scene, simulation=replace(short_scene.simulation, stop_time=0.9))
    expected = from_nothing(longer_scene).new_instance().tobytes()
    assert from_nothing(short_scene).new_instance().tobytes() != expected
    assert PreparedScene(longer_scene).new_instance().tobytes() == expected


def test_a_scene_finds_what_is_kept_of_an_earlier_one():
    first_scene, other_scene = load_scene("four_link_box"), load_scene("pinned_arm")
    outputs = from_nothing(first_scene).outputs
    assert PreparedScene(other_scene).outputs
    assert PreparedScene(first_scene.with_values({"contact.restitution": 0.5})).outputs is outputs
    for number in range(2 * shared_data.MOST_CACHED):
        PreparedScene(other_scene.with_values({"outputs.impacts": number}))
    assert len(shared_data._cache) == shared_data.MOST_CACHED


def test_each_new_instance_has_its_own_memory():
    scene = load_scene("four_link_box")
    first = PreparedScene(scene).new_instance()
    first.view(np.uint8)[:] = 1
    assert PreparedScene(scene).new_instance().tobytes() != first.tobytes()

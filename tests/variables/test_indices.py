"""The indices of outputs in the record: their words contain the results of a run."""

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.simulation.instance import Instance
from chain_impact.variables.prepared import PreparedScene


@pytest.mark.parametrize("name", ["four_link_box", "sliding_rod", "kneed_leg"])
def test_the_words_of_the_outputs_are_those_of_the_variables(name):
    prepared_scene = PreparedScene(load_scene(name))
    motion, stepwise, *_ = prepared_scene.output_indices
    assert [*motion, *stepwise] == [output.name for output in prepared_scene.outputs]
    words_of_outputs = {output.name: prepared_scene.word_of(output) for output in prepared_scene.outputs}
    assert motion == {output: words_of_outputs[output] for output in motion}
    assert {name: word for name, (word, _) in stepwise.items()} == {
        name: words_of_outputs[name] for name in stepwise
    }
    assert {output.name for output in prepared_scene.outputs if output.type != "real"} == {
        name for name, (_, is_real) in stepwise.items() if not is_real
    }


def test_scenes_of_one_shape_share_them():
    scene = load_scene("rod_drop")
    other_scene = PreparedScene(scene.with_values({"link[1].length": 0.9}))
    assert other_scene.output_indices is PreparedScene(scene).output_indices


def test_a_row_has_what_the_record_has_at_its_time():
    scene = load_scene("rod_drop").with_values({"simulation.stop_time": 1.0})
    result, instance = simulate(scene), Instance(scene)
    instance.trajectory(result.time, np.zeros(len(result.time), result.prepared_scene.output_layout))
    for name, word in result.prepared_scene.output_indices.continuous.items():
        assert result[name][-1] == instance.words[word]
    integers = instance.words.view(np.int64)
    for name, (word, is_real) in result.prepared_scene.output_indices.stepwise.items():
        assert result[name][-1] == (instance.words if is_real else integers)[word]

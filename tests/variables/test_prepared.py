"""A prepared scene: its derived quantities, the size of a new instance, and where it has the values."""

# Tests: variables/selection.py

import pickle
from collections import Counter
from functools import partial

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.fmu.documents import documents
from chain_impact.fmu.native_target import native_files
from chain_impact.kernel.record.constants import NO_CONTACT, NOT_GIVEN, SOLVER_METHODS
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.errors import UnknownNameError
from chain_impact.scene.files.models import model_names
from chain_impact.scene.scene import with_values
from chain_impact.variables import prepared as prepared_module
from chain_impact.variables.indices import word_index
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.scene_variables import value_at_path
from chain_impact.variables.selection import columns_named, differentiable_named

BUFFER = 64 * 1024  # bytes, the upper limit for an instance of four links in a box


def test_the_record_has_no_pointers_and_knows_its_candidates():
    for scene in map(load_scene, model_names()):
        instance = PreparedScene(scene).new_instance()
        assert not instance.dtype.hasobject
        assert np.frombuffer(instance.tobytes(), instance.dtype) == instance
        record = instance[0]
        assert (record["link_count"], record["candidate_count"]) == (
            len(scene.chain.links),
            len(candidates_of(scene)),
        )
        pairs = zip(record["candidate"]["point"], record["candidate"]["wall"], strict=True)
        assert list(pairs) == candidates_of(scene)


@pytest.mark.parametrize("model", model_names())
def test_each_value_of_the_scene_stands_where_its_variable_is(model):
    scene = load_scene(model)
    instance = PreparedScene(scene).new_instance()
    reals, integers = instance.view(np.float64), instance.view(np.int64)
    checked = 0
    for variable in PreparedScene(scene).variables:
        if variable.causality != "parameter" or variable.scene_path is None:
            continue
        value = value_at_path(scene, variable.scene_path)
        word = word_index(instance.dtype, variable.record_path)
        if variable.items:
            assert variable.items[integers[word] - 1].name == value, variable.name
        else:
            assert reals[word] == value, variable.name
        checked += 1
    assert checked > (15 if candidates_of(scene) else 8)


def test_words_of_the_scene_become_numbers():
    box = load_scene("four_link_box")
    changes = {("contact", "model"): "flores", ("solver", "method"): "implicit"}
    record = PreparedScene(with_values(box, changes)).new_instance()[0]
    assert record["given"]["law"] == CONTACT_LAWS["flores"].number
    assert record["solver"]["method"] == SOLVER_METHODS.index("implicit") + 1
    assert (record["chain"]["has_base_joint"], record["chain"]["has_inputs"]) == (0, 0)
    arm = PreparedScene(load_scene("pinned_arm")).new_instance()[0]
    assert {point for point, _ in candidates_of(load_scene("pinned_arm"))} == {
        1,
        2,
    }  # all points except the base
    assert (arm["chain"]["has_base_joint"], arm["chain"]["has_inputs"]) == (1, 1)


def test_a_new_instance_holds_nothing_but_the_scene():
    """All that the kernel writes is zero, except one index (no contact)."""
    scene = load_scene("four_link_box")
    instance = PreparedScene(scene).new_instance()
    assert instance.nbytes < BUFFER
    assert instance.tobytes() == PreparedScene(scene).new_instance().tobytes()
    assert instance[0]["step"]["regularized_candidate"] == NO_CONTACT
    instance[0]["step"]["regularized_candidate"] = 0
    for field in (
        "step",
        "contacts",
        "search",
        "implicit",
        "constraints",
        "contact_log",
        "statistics",
        "output",
        "scratch",
    ):
        assert not any(instance[0][field].tobytes()), field


PARTS = ("structure_of", "parameters_of", "undriven_inputs", "outputs_of")


def count_calls(monkeypatch):
    """Return a counter that counts the calls of each function in PARTS from the call of this function on."""
    counts = Counter()

    def counted(name, function, *arguments):
        counts[name] += 1
        return function(*arguments)

    for name in PARTS:
        monkeypatch.setattr(prepared_module, name, partial(counted, name, getattr(prepared_module, name)))
    return counts


def test_a_run_with_derivatives_and_an_fmu_work_each_part_out_once(monkeypatch, tmp_path):
    call_counts, once = count_calls(monkeypatch), dict.fromkeys(PARTS, 1)
    choices = {"output": ["point[1].*"], "sensitivities": ["link[1].*", "gravity.y"]}
    result = simulate("rod_drop", stop_time=0.1, **choices)
    assert result.sensitivities.units["point[1].x"] == "m"
    assert call_counts == once
    call_counts.clear()
    prepared_scene = PreparedScene(load_scene("pinned_arm"))
    assert {**native_files(prepared_scene, {}, 3), **documents(prepared_scene, 3)}
    assert call_counts == once


def test_the_start_of_a_prepared_scene_does_not_change():
    prepared_scene = PreparedScene(load_scene("rod_drop"))
    assert prepared_scene.start.tobytes() == prepared_scene.new_instance().tobytes()
    with pytest.raises(ValueError, match="read-only"):
        prepared_scene.start["link_count"] = 2
    starts, law = (
        {v.name: prepared_scene.start_text(v) for v in prepared_scene.parameters},
        CONTACT_LAWS["zhang_sharf"],
    )
    assert (starts["link[1].length"], starts["contact.model"]) == ("0.6", str(law.number))


def test_a_prepared_scene_goes_to_another_process_as_its_scene():
    prepared_scene = PreparedScene(load_scene("rod_drop"))
    pickled = pickle.dumps(prepared_scene)
    names = [variable.name for variable in prepared_scene.variables]
    assert pickle.dumps(prepared_scene) == pickled
    loaded_scene = pickle.loads(pickled)
    assert loaded_scene == prepared_scene
    assert [variable.name for variable in loaded_scene.variables] == names


def test_stops_and_materials_stand_in_the_record():
    scene = with_values(load_scene("four_link_box"), {"link[3].joint_min": -2.5, "link[3].joint_max": 2.0})
    materials = {"wall.y_max.stiffness": 1e6, "wall.x_min.restitution": 0.25}
    d = PreparedScene(scene.with_values({"link[4].joint_max": 1.5, **materials})).new_instance()[0]
    assert d["drive"]["min"][:-1].tolist() == [-np.inf, -np.inf, -2.5, -np.inf]
    assert d["drive"]["max"][:-1].tolist() == [np.inf, np.inf, 2.0, 1.5]
    assert d["candidate"]["stop"].tolist() == [0] * 20 + [1, -1, -1]
    assert d["candidate"]["point"][20:].tolist() == [3, 3, 4]
    assert d["candidate"]["wall"][20:].tolist() == [4, 5, 5]
    assert d["stops"]["law"] == 0, "that of contact"
    assert (d["stops"]["exponent"], d["stops"]["minimum_impact_speed"]) == (1.5, 1e-3)
    assert (d["given"]["stop_stiffness"], d["stops"]["restitution"]) == (1e5, 0.7)
    assert d["stops"]["given_exponent"] == d["given"]["stop_restitution"] == NOT_GIVEN
    assert d["walls"]["stiffness"].tolist() == [0.0, 0.0, 0.0, 1e6] + [0.0] * 23
    assert d["walls"]["restitution"].tolist() == [0.25] + [-1.0] * 26


def test_stops_can_have_a_law_of_their_own():
    scene = load_scene("pinned_arm").with_values({"link[1].joint_max": 3.0, "stops.model": "newton_impact"})
    d = PreparedScene(scene).new_instance()[0]
    assert (d["stops"]["law"], d["candidate"]["stop"][-1]) == (CONTACT_LAWS["newton_impact"].number, -1)
    assert d["given"]["law"] == CONTACT_LAWS["zhang_sharf"].number


def test_walls_that_no_point_can_touch_need_no_room():
    walls = [{"name": f"w{i}", "point": [-9.0, -9.0], "normal": [1.0, 1.0]} for i in range(6)]
    changes = {("walls",): walls, ("contact", "points"): [], ("chain", "links", 1, "joint_max"): 3.0}
    d = PreparedScene(with_values(load_scene("four_link_box"), changes)).new_instance()[0]
    assert (d["candidate"]["wall"].tolist(), d["walls"]["angle"].tolist()) == ([5], [0.0])


def test_a_name_that_is_no_text_is_refused():
    prepared_scene = PreparedScene(load_scene("rod_drop"))
    for refuse in (
        prepared_scene.indices_named,
        partial(differentiable_named, prepared_scene),
        partial(columns_named, prepared_scene),
    ):
        with pytest.raises(UnknownNameError, match=r"RodDrop: \['point\[1\].x'\] is not an? "):
            refuse([["point[1].x"]])
    chosen_indices = prepared_scene.indices_named(["energy.*", "point[1].x"])
    assert (
        PreparedScene(prepared_scene.scene).indices_named(name for name in [*chosen_indices.continuous])
        is chosen_indices
    )
    assert "point[1].x" in chosen_indices.continuous


def test_another_thread_may_clear_the_kept_indices_at_any_time(monkeypatch):
    class ClearedAtOnce(dict):
        def __setitem__(self, names, indices):
            self.clear()

    prepared_scene = PreparedScene(load_scene("rod_drop"))
    monkeypatch.setattr(prepared_scene, "_indices_by_names", ClearedAtOnce())
    assert [*prepared_scene.indices_named(["point[1].x", "energy.kinetic"]).continuous] == [
        "point[1].x",
        "energy.kinetic",
    ]

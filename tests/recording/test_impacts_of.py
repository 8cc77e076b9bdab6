"""The table of impacts from an FMU's record equals that of simulate() if each step shows all its impacts."""

# Tests: recording/impacts.py

import warnings

import numpy as np
import pytest

from chain_impact import SceneWarning, impacts_of, load_scene, simulate
from chain_impact.recording.impacts import FMU_NAMES
from chain_impact.simulation.instance import Instance

EXACT_NAMES = ("point", "wall", "onset", "impact_speed")


def recorded(scene, times):
    """Return the record of an importer that reads all impacts at each communication point: name → list."""
    instance = Instance(scene)
    record = {"time": np.array(times), "impact.count": []}
    names = [(j, name) for j in range(scene.outputs.impacts) for name in FMU_NAMES]
    record |= {f"impact[{j + 1}].{FMU_NAMES[name]}": [] for j, name in names}
    for time in times:
        assert instance.advance(time) == 0
        instance.observe()
        record["impact.count"].append(int(instance.record["impact"]["count"]))
        for j, name in names:
            record[f"impact[{j + 1}].{FMU_NAMES[name]}"].append(instance.record["latest"][name][j])
    return record


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("model", ["four_link_box", "rod_drop", "ramp"])
@pytest.mark.parametrize("step", [1e-3, 1e-2, 0.1])
def test_the_table_of_impacts_is_complete_at_any_communication_step(model, step):
    scene = load_scene(model).with_values({"outputs.impacts": 16})
    stop = scene.simulation.stop_time
    expected = simulate(scene).impacts
    table = impacts_of(recorded(scene, np.append(np.arange(0.0, stop, step), stop)))
    assert len(table) == len(expected)
    for name in EXACT_NAMES:
        np.testing.assert_array_equal(table[name], expected[name])
    for name in ("end", "separation_speed", "peak_force", "max_penetration", "impulse"):
        np.testing.assert_allclose(table[name], expected[name], rtol=1e-12, err_msg=name)
    assert all(np.isnan(table[name]).all() for name in ("effective_mass", "x", "y"))


def test_impacts_at_rigid_walls_have_no_duration():
    scene = load_scene("four_link_box").with_values({"contact.model": "newton_impact"})
    table = impacts_of(recorded(scene, np.linspace(0.0, 2.0, 21)))
    expected = simulate(scene).impacts
    for name in ("end", "duration", "peak_force"):
        np.testing.assert_array_equal(table[name], expected[name])
    bounces = table["duration"] == 0.0
    assert bounces.any()
    assert not table["peak_force"][bounces].any()


def test_a_contact_that_lasts_has_no_end():
    scene = load_scene("four_link_box")
    middle = simulate(scene).impacts[0][["onset", "end"]]
    table = impacts_of(recorded(scene, [0.0, 0.3, sum(middle.tolist()) / 2]))
    assert len(table) == 1
    assert np.isnan([table[name][0] for name in ("end", "duration", "separation_speed")]).all()
    assert table["peak_force"][0] > 0


def test_more_in_a_step_than_are_shown_are_missing():
    scene = load_scene("four_link_box").with_values({"outputs.impacts": 2})
    expected = simulate(scene).impacts
    with pytest.warns(SceneWarning, match=f"{len(expected) - 4} of {len(expected)} impacts are missing"):
        table = impacts_of(recorded(scene, [0.0, 1.0, 2.0]))
    assert sorted(table["onset"]) == [*expected["onset"][1:3], *expected["onset"][-2:]]


def test_a_contact_that_newer_impacts_hide_before_its_end_is_told():
    values = {"contact.restitution": 0.4}  # a point stays at the floor while others bounce
    scene = load_scene("four_link_box").with_values(values)
    times = np.linspace(0.0, 2.0, 201)
    with pytest.warns(SceneWarning, match=r"1 contact is known in part only.*outputs\.impacts"):
        table = impacts_of(recorded(scene, times))
    assert len(table) == len(simulate(scene).impacts)
    assert np.isnan(table["peak_force"]).sum() == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table = impacts_of(recorded(scene.with_values({"outputs.impacts": 32}), times))
    assert not np.isnan(table["peak_force"]).any()


def test_arrays_of_an_importer_are_taken_as_they_are():
    record = recorded(load_scene("rod_drop"), np.linspace(0.0, 1.0, 11))
    rows = np.rec.fromarrays(list(record.values()), names=list(record))
    assert impacts_of(rows).tobytes() == impacts_of(record).tobytes()
    result = simulate(load_scene("rod_drop"))
    assert impacts_of(result) is result.impacts


def test_impacts_have_the_names_of_their_walls():
    """The names come from columns of contacts, or from the caller; the box's walls have fixed names."""
    scene = load_scene("sliding_rod").with_values({"outputs.impacts": 16})
    expected = simulate(scene).impacts
    names = [scene.wall_names[wall] for wall in expected["wall"]]
    assert expected["wall_name"].tolist() == names
    assert {"ramp", "y_min"} <= set(names)
    record = recorded(scene, np.linspace(0.0, scene.simulation.stop_time, 201))
    assert impacts_of(record, scene.wall_names)["wall_name"].tolist() == names
    assert impacts_of(record)["wall_name"].tolist() == ["" if name == "ramp" else name for name in names]
    outputs = {"contact[0].ramp.force": [0.0], "contact[1].y_min.force": [0.0]}
    assert impacts_of(record | outputs)["wall_name"].tolist() == names


def test_a_record_without_impacts_is_refused():
    with pytest.raises(ValueError, match=r"no column impact\.count"):
        impacts_of({"time": [0.0]})
    with pytest.raises(ValueError, match=r"outputs\.impacts = 0"):
        impacts_of({"time": [0.0], "impact.count": [0]})


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("stop", [0.49, 0.5, 2.0])  # before an impact, within an impact, after many impacts
def test_the_columns_of_a_simulated_scene_are_those_of_its_fmu(stop):
    scene = load_scene("four_link_box").with_values({"simulation.stop_time": stop})
    result = simulate(scene)
    expected = recorded(scene, result.time)
    del expected["time"]
    for name, column in expected.items():
        np.testing.assert_array_equal(result[name], column, err_msg=name)

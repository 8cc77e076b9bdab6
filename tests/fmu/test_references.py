"""Reference results in FMUs: their statements hold, and faults in damaged results are found."""

import csv
import io
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.fmu.build import build_fmu
from chain_impact.fmu.references import (
    REFERENCE_FILE,
    REFERENCE_ROWS,
    REFERENCE_TOLERANCE,
    check_references,
    reference_results,
)
from chain_impact.scene.files.models import model_names
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.tools.planted_faults import spoiled

every_model = pytest.mark.parametrize("model", model_names())


def table_of(path):
    """Return the table in an FMU: name → tolerance and values, both of which may be NaN."""
    with zipfile.ZipFile(path) as fmu:
        names, tolerances, *rows = csv.reader(io.StringIO(fmu.read(REFERENCE_FILE).decode()))
    assert (names[0], tolerances[0]) == ("time", "tolerance")
    values = np.array([[cell or "nan" for cell in row] for row in rows], float)
    return dict(
        zip(
            names,
            zip([0.0, *(float(x or "nan") for x in tolerances[1:])], values.T, strict=True),
            strict=True,
        )
    )


@pytest.fixture
def spoil(native, tmp_path):
    """Return a function that changes the table of a model's FMU by a function of its text."""
    return lambda change, model="four_link_box": spoiled(
        native[model],
        tmp_path / "x.fmu",
        lambda name, content: change(content.decode()).encode() if name == REFERENCE_FILE else content,
    )


# --- the results in an FMU -------------------------------------------------------------------------------


@pytest.mark.full("more cases", but=4)
@every_model
def test_every_model_keeps_to_its_reference_which_is_small(fmus, model):
    passed, text = check_references(Path(fmus[model]))
    assert passed, text
    assert re.match(r"passed, outputs: 1\d, times: \d+, until ", text)
    with zipfile.ZipFile(fmus[model]) as fmu:
        assert fmu.getinfo(REFERENCE_FILE).compress_size < 12_000


@pytest.mark.full("more cases", but=["four_link_box", "rod_drop"])
@pytest.mark.parametrize("model", ["four_link_box", "rod_drop", "ramp"])
def test_the_results_are_those_of_another_method_at_a_tight_tolerance(native, model):
    """The reference has the scene's method, "auto"; the other method is the explicit one."""
    columns = table_of(native[model])
    expected = simulate(load_scene(model), tolerance=REFERENCE_TOLERANCE, method="explicit")
    compared = [name for name in columns if name in expected.columns]
    assert len(compared) > 8
    has_row = ~np.isnan(columns["impact.count"][1])
    times = columns["time"][1][has_row]
    rows = np.searchsorted(expected.time, times - 1e-9)
    for name in compared:
        # a tolerance in the table is ten times the largest deviation of a run with the scene's tolerance
        tolerance, values = columns[name]
        error = np.abs(expected.columns[name][rows] - values[has_row]).max()
        assert error <= tolerance / 5 + 1e-10, name
    impact_counts = [np.sum(expected.impacts["onset"] <= time) for time in times]
    assert columns["impact.count"][1][has_row].tolist() == impact_counts


@pytest.mark.full("takes long")
def test_the_times_are_those_that_can_be_relied_on():
    """No time is close to the beginning or end of a contact; chaotic motion leaves 1 to 10 of 1000 s."""
    scene = load_scene("four_link_box")
    usual_reference, long_reference, fine_reference, coarse_reference = (
        reference_results(PreparedScene(scene.with_values(changes)))
        for changes in (
            {},
            {"simulation.stop_time": 1000.0},
            {"solver.tolerance": 1e-10},
            {"solver.tolerance": 1e-4},
        )
    )

    def compared(result):
        return ~np.isnan(result.values).any(axis=1)

    impacts = simulate(scene).impacts
    edges = np.concatenate([impacts["onset"], impacts["end"]])
    assert np.nanmin(np.abs(usual_reference.times[compared(usual_reference), None] - edges)) > 1e-6
    assert 1.0 < long_reference.times[-1] < 10.0
    assert REFERENCE_ROWS / 10 < compared(long_reference).sum() <= REFERENCE_ROWS + 1
    assert coarse_reference.times[-1] < fine_reference.times[-1]


def test_inputs_differ_from_each_other_and_act(native):
    columns = table_of(native["controlled_arm"])
    values = np.array([columns[f"joint[{k}].torque"][1] for k in (1, 2)])
    assert np.ptp(values, axis=1).min() > 0.01
    assert np.abs(values[0] - values[1]).max() > 0.01
    assert np.nanmax(np.abs(columns["energy.supplied"][1])) > 0.01


def test_a_scene_that_cannot_run_has_no_reference_and_that_is_said(tmp_path, caplog):
    scene = load_scene("rod_drop").with_values({"solver.work_limit": 1.0})
    caplog.set_level("INFO", "chain_impact")
    path = build_fmu(scene, tmp_path, target="native")
    assert any(text.startswith("no reference results in the FMU: ") for text in caplog.messages)
    assert check_references(path) is None


# --- faults in the results -------------------------------------------------------------------------------


def changed(name, row, value):
    """Return a function that changes a cell in the text of a table."""

    def change(text):
        rows = [line.split(",") for line in text.splitlines()]
        rows[row][rows[0].index(name)] = value
        return "\n".join(map(",".join, rows))

    return change


def test_a_result_that_was_changed_is_found(spoil):
    passed, text = check_references(spoil(changed("point[4].x", 51, "1.5")))
    assert not passed
    assert re.fullmatch(
        r"point\[4\]\.x is not 1\.5 at t = 0\.98 s: \S+ off, \S+ allowed; of 1\d outputs 1 deviate", text
    )


def test_a_result_that_is_left_out_is_not_compared(spoil):
    assert check_references(spoil(changed("point[4].x", 51, "")))[0]


def test_another_model_is_found(native, tmp_path):
    """The FMU of a softer wall with the stiff wall's results fails soon after the first impact."""
    soft = load_scene("four_link_box").with_values({"contact.stiffness": 0.99e8})
    with zipfile.ZipFile(native["four_link_box"]) as source_zip:
        path = spoiled(
            build_fmu(soft, tmp_path, target="native"),
            tmp_path / "x.fmu",
            lambda name, content: source_zip.read(name) if name == REFERENCE_FILE else content,
        )
    passed, text = check_references(path)
    assert not passed
    first = simulate(soft).impacts["onset"][0]
    assert first < float(re.search(r"at t = (\S+) s", text)[1]) < first + 0.1


def test_inputs_that_do_not_arrive_are_found(spoil):
    def change(text):
        head, *rows = text.splitlines()
        column = head.split(",").index("joint[1].torque")
        cells = [row.split(",") for row in rows]
        return "\n".join([head, *(",".join([*row[:column], "0", *row[column + 1 :]]) for row in cells)])

    passed, text = check_references(spoil(change, "controlled_arm"))
    assert not passed
    assert int(re.search(r"of \d+ outputs (\d+) deviate", text)[1]) > 1


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda text: text.replace("point[4].x", "point[9].x"), "the FMU has no variable point[9].x"),
        (lambda text: f"{text}1,2\n", "must be a table of numbers"),
        (lambda text: "", "must be a table of numbers"),
        (lambda text: text.partition("\n")[0], "must be a table of numbers"),
        (lambda text: text.replace("\n0.02,", "\nsoon,"), "must be a table of numbers"),
        (lambda text: text.replace("\n0.02,", "\n-1,"), "the times must increase"),
        (lambda text: "\n".join(text.splitlines()[:3]), "two times or more"),
    ],
)
def test_wrong_reference_results_are_told(spoil, change, sentence):
    passed, text = check_references(spoil(change))
    assert not passed
    assert sentence in text


def test_an_fmu_that_refuses_the_inputs_cannot_be_simulated(spoil):
    passed, text = check_references(spoil(changed("joint[1].torque", 3, "inf"), "controlled_arm"))
    assert not passed
    assert text.startswith("cannot be simulated: ")

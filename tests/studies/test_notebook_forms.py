"""The notebook display of scenes, results and studies, and their pandas tables."""

# Tests: scene/display/drawing.py, studies/fit/result.py, study_data/sweep/runs.py

from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import compare, fit, load_scene, model_names, simulate, sweep


def forms(thing):
    """Return the parsed HTML of a notebook's display; it is well-formed, and its texts are escaped."""
    return ElementTree.fromstring(thing._repr_html_())


def cells(form):
    """Return the rows of the tables in a parsed display, each as a list of texts."""
    return [["".join(cell.itertext()) for cell in row] for row in form.iter("tr")]


@pytest.fixture(scope="module")
def comparison():
    return compare("rod_drop", laws=["hertz", "flores"])


@pytest.fixture(scope="module")
def fitted():
    result = simulate("rod_drop", 0.1)
    data = {"time": result.time, "point[0].y": result["point[0].y"]}
    return fit("rod_drop", data, ["gravity.y"], sigma={"point[0].y": 1e-3}, stop_time=0.1)


@pytest.fixture(scope="module")
def swept():
    return sweep("rod_drop", {"contact.restitution": np.linspace(0.1, 0.9, 12)})


@pytest.mark.parametrize("model", model_names())
def test_a_scene_is_a_small_drawing_and_its_lines(model):
    scene = load_scene(model)
    form = forms(scene)
    assert form.find("pre").text == repr(scene)
    drawing = next(part for part in form if part.tag.endswith("svg"))
    assert max(float(drawing.get(side)) for side in ("width", "height")) == 240
    low_x, low_y, width, height = map(float, drawing.get("viewBox").split())
    points = [
        (float(circle.get("cx")), float(circle.get("cy")))
        for circle in drawing
        if circle.tag.endswith("circle")
    ]
    assert len(points) == len(scene.start)
    assert all(low_x < x < low_x + width and low_y < y < low_y + height for x, y in points)
    x, y = scene.initial.position
    assert points[0] == (pytest.approx(x), pytest.approx(-y))


def test_a_comparison_is_a_table(comparison, tmp_path):
    head, *rows = cells(forms(comparison))
    assert head[:3] == ["law", "e′", "peak, kN"]
    assert [row[0] for row in rows] == ["hertz", "flores"]
    table = comparison.to_dataframe()
    assert table["restitution"].tolist() == [run.restitution for run in comparison.runs]
    comparison.save_csv(tmp_path / "laws.csv")
    assert (tmp_path / "laws.csv").read_text(encoding="utf-8").split("\n")[0].strip().split(",") == [*table]


def test_a_fit_is_tables(fitted):
    first = cells(forms(fitted))[1]
    assert first[0] == "gravity.y"
    row = fitted.to_dataframe().loc["gravity.y"]
    assert row["value"] == fitted.values["gravity.y"]
    assert (row["low"], row["high"]) == fitted.intervals["gravity.y"]


def test_a_sweep_lists_its_first_runs_and_ends_with_how_many_more(swept):
    form = forms(swept)
    head, *rows = cells(form)
    assert (tuple(head), len(rows)) == (swept.names, 10)
    assert rows[1][0] == f"{0.1 + 0.8 / 11:.6g}"
    assert form.find("pre").text == "… and 2 more runs"
    assert isinstance(swept.plot(), Figure)


def test_sensitivities_tell_changes_at_the_end():
    result = simulate("rod_drop", 0.1, sensitivities=["gravity.y"])
    sensitivities = result.sensitivities
    head, row = cells(forms(sensitivities))
    assert head[:3] == ["parameter", "value", "change"]
    change = 0.01 * -9.81 * result.sensitivity("point[1].y", "gravity.y")[-1]
    assert row == ["gravity.y", "-9.81 m/s²", "+ 1 %", *row[3:]]
    assert float(row[head.index("point[1].y [m]")]) == pytest.approx(change, rel=1e-2)

"""The charts of the benchmarks, drawn from the stored figures: what they say is what was measured."""

import importlib
import itertools
import json
import os
import re
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from chain_impact.results.plots.style import GREY, STYLE

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
COLOURS = 10  # the most that a chart tells apart


@pytest.fixture(scope="module")
def charts():
    """Imports a module of the benchmarks by its name; leaves path, modules and environment as they were."""
    environment, modules = dict(os.environ), set(sys.modules)
    sys.path.insert(0, str(BENCHMARKS))

    def load(name):
        module = importlib.import_module(name)
        os.environ.clear()  # common.py sets what numba compiles for
        os.environ.update(environment)
        return module

    yield load
    sys.path.remove(str(BENCHMARKS))
    for name in set(sys.modules) - modules:
        if BENCHMARKS in Path(getattr(sys.modules[name], "__file__", None) or "/").parents:
            del sys.modules[name]


def stored(name):
    return json.loads((BENCHMARKS / "results" / f"{name}.json").read_text(encoding="utf-8"))


def drawn(draw, record, size=(9.5, 5.0)):
    with mpl.rc_context(STYLE):
        page = Figure(figsize=size, layout="constrained")
        draw(page, record)
        page.draw_without_rendering()
    return page


@pytest.fixture(scope="module")
def work_precision(charts):
    """The module, what it draws from, and the first chart."""
    module, record = charts("work_precision_chart"), stored("work_precision")
    return module, record, drawn(module.draw, record)


def test_six_curves_are_named_in_their_colours_and_the_rest_is_grey(work_precision):
    module, _, page = work_precision
    (axes,) = page.axes
    names = [text for text in axes.texts if text.get_text().split(":")[0] in module.NAMED.values()]
    assert len(names) == 6
    colours = [to_hex(line.get_color()) for line in axes.lines]
    named = {to_hex(text.get_color()) for text in names}
    assert len(colours) - colours.count(to_hex(GREY)) == 6
    assert named == set(colours) - {to_hex(GREY)}
    assert f"grey: {colours.count(to_hex(GREY))} more" in page.texts[1].get_text()


def test_names_at_curves_overlap_nothing(work_precision):
    _, _, page = work_precision
    (axes,) = page.axes
    boxes = [Text.get_window_extent(text) for text in axes.texts if text.get_text()]
    for one, other in itertools.combinations(boxes, 2):
        assert not one.overlaps(other)
    for box in boxes:
        assert page.bbox.x0 <= box.x0 <= box.x1 <= page.bbox.x1


def test_the_factors_are_those_of_the_stored_figures(work_precision):
    """Against numbers of their own: two runs of each around the error, and a straight line between them."""
    module, record, page = work_precision

    def time(name):
        problem, stop = module.SHOWN
        runs = [
            (row["error"], row["seconds"])
            for row in record["results"]["rows"]
            if (row["problem"], row["stop"], row["name"]) == (problem, stop, name) and row.get("onsets_right")
        ]
        errors, seconds = np.log(sorted(runs)).T
        return np.exp(np.interp(np.log(module.AT), errors, seconds))

    ours, texts = time("ours"), {text.get_text() for text in page.axes[0].texts}
    for name, label in module.NAMED.items():
        assert name == "ours" or f"{label}: {time(name) / ours:.3g}×" in texts
    peers = [time(name) / ours for name in module.NAMED if name != "ours"]
    said = [float(found) for found in re.findall(r"([\d.]+) times faster", page.get_suptitle())]
    assert said == [float(f"{min(peers):.2g}"), round(time("scipy DOP853") / ours)]


def test_no_solver_that_is_not_named_is_faster_than_the_one_that_is_called_next(charts, work_precision):
    module, record, _ = work_precision
    equal = charts("equal_error")
    rows = record["results"]["rows"]
    times = {
        name: equal.seconds_at(module.AT, equal.usable(rows, *module.SHOWN, name)) for name in module.LOOKS
    }
    reached = {name: time for name, time in times.items() if time is not None and not name.startswith("ours")}
    assert min(reached, key=reached.get) in module.NAMED
    scipy = {name: time for name, time in reached.items() if name.startswith("scipy")}
    assert min(scipy, key=scipy.get) == module.USUAL


@pytest.mark.full("takes long")
def test_the_map_counts_the_completed_cells_and_colours_by_error(charts):
    module, record = charts("stability_chart"), stored("stability")
    page = drawn(module.draw, record, (9.5, 8.6))
    cells = record["results"]["cells"]
    for axes, method in zip(page.axes, record["settings"]["methods"], strict=True):
        done = sum(cell["outcome"] == "completed" for cell in cells if cell["method"] == method)
        assert axes.get_title().endswith(f": {done} of 72")
        errors = axes.images[0].get_array()
        late = sum(cell["outcome"] == "over budget" for cell in cells if cell["method"] == method)
        faulty = sum(
            cell["outcome"] not in ("completed", "over budget") for cell in cells if cell["method"] == method
        )
        assert np.ma.masked_invalid(errors).count() == 72 - late
        assert len(axes.lines) == late + faulty


def test_the_error_of_the_map_is_zero_where_the_energy_is_known(charts):
    """The rod lies on the floor: its weight, on two points, presses them in, K δ^1.5 = m g / 2."""
    module, record = charts("stability_chart"), stored("stability")
    expected = module.expected_energy(record)
    start = 9.81 * (0.1 + 0.5 * np.sin(0.3))
    for (stiffness, restitution), energy in expected.items():
        if restitution <= 0.5:
            depth = (9.81 / 2.0 / stiffness) ** (2.0 / 3.0)
            assert energy == pytest.approx(-9.81 * depth / start, rel=2e-3)


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("name", ["engines", "fmu_cost", "friction", "rest", "rhs", "scaling", "stiffness"])
def test_a_chart_has_a_message_few_colours_and_no_text_on_text(charts, name):
    module = charts(name)
    page = drawn(module.draw, stored(name), module.SIZE)
    message, conditions, *_ = (text.get_text() for text in page.texts)
    assert re.search(r"\d", message)
    assert conditions
    colours = {to_hex(line.get_color()) for axes in page.axes for line in axes.lines}
    assert len(colours) <= COLOURS
    for axes in page.axes:
        boxes = [Text.get_window_extent(text) for text in axes.texts if text.get_text()]
        for one, other in itertools.combinations(boxes, 2):
            assert not one.overlaps(other)
    for text in page.texts:
        box = text.get_window_extent()
        assert page.bbox.x0 <= box.x0 <= box.x1 <= page.bbox.x1
        assert not any(axes.get_window_extent().overlaps(box) for axes in page.axes)


@pytest.mark.full("takes long")
def test_the_factors_of_friction_are_those_of_the_stored_figures(charts):
    """With numbers of their own: where MuJoCo errs more than our loosest run, against that run."""
    module, record = charts("friction_chart"), stored("friction")
    message = drawn(module.draw, record, module.SIZE).get_suptitle()

    def factor(part):
        rows = {(row["name"], row["setting"]): row for row in record["results"][part]["rows"]}
        theirs, loosest = rows["MuJoCo Euler, defaults", 1e-3], rows["ours", 1e-2]
        assert theirs["error"] > loosest["error"]
        mine = [row["seconds"] for (name, _), row in rows.items() if name == "ours"]
        return theirs["seconds"] / min(mine[:2])

    said = [float(found) for found in re.search(r"takes ([\d.]+) to ([\d.]+) times", message).groups()]
    assert said == pytest.approx(sorted(map(factor, ("moving", "resting"))), rel=0.05)


def test_the_drift_and_the_depth_of_the_rod_on_the_slope_are_those_of_theory():
    """Our depth by statics, K δ^1.5 = m g cos β / 2; MuJoCo's drift is in proportion to 1 / impratio."""
    rows = {(row["name"], row["setting"]): row for row in stored("friction")["results"]["slope"]}
    depth = (1.2 * 9.81 * np.cos(0.35) / 2.0 / 1e6) ** (2.0 / 3.0)
    assert rows["ours", 1e-8]["penetration"] == pytest.approx(depth, rel=1e-3)
    assert rows["MuJoCo Euler, stiffness of ours", 1e-3]["penetration"] == pytest.approx(depth, rel=1e-2)
    drift = {key: row["drift"] for key, row in rows.items()}
    for setting in ("defaults", "stiffness of ours", "stiffest"):
        for step in (1e-2, 1e-3, 1e-4):
            creep = drift[f"MuJoCo Euler, {setting}", step]
            assert drift[f"MuJoCo Euler, {setting}, impratio 100", step] == pytest.approx(
                creep / 100, rel=1e-3
            )
    for step in (1e-2, 1e-3, 1e-4):  # where a contact cannot move along both of its directions
        planar = "MuJoCo Euler, defaults, in the plane only"
        assert drift.pop((f"{planar}, noslip", step)) == drift[planar, step] > 1000.0
    assert all(
        value < 1e-9 for (name, _), value in drift.items() if "ours" in name.split()[0] or "noslip" in name
    )


def test_the_contenders_have_at_most_ten_colours(charts):
    looks = charts("looks").LOOKS.values()
    assert len({to_hex(colour) for colour, _, _ in looks}) <= COLOURS
    assert len(set(looks)) == len(looks)

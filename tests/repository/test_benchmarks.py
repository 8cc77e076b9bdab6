"""The benchmarks fit the present package, as far as a test without running them can show."""

import functools
import importlib
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from scipy.io import savemat

import chain_impact
from chain_impact.pictures.drawing.style import STYLE
from tests.helpers.models.coulomb_impact import Strike, stiff_limit
from tests.helpers.models.reference import exact_damping_factor

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
FILES = sorted([*BENCHMARKS.glob("*.py"), *BENCHMARKS.glob("peers/*.py")])


@pytest.fixture(scope="module")
def charts():
    """Return a function that imports a module of the benchmarks by name."""
    return lambda name: importlib.import_module(f"benchmarks.{name}")


@pytest.mark.parametrize("name", [[], ["no_benchmark"], ["common"]])
def test_a_wrong_name_of_a_benchmark_lists_the_right_ones(name):
    command = [sys.executable, "-m", "benchmarks", *name]
    process = subprocess.run(command, cwd=BENCHMARKS.parent, check=False, capture_output=True, text=True)
    assert process.returncode == 2
    sentence, *listed = process.stderr.splitlines()
    assert "must be" in sentence
    assert all(argument in sentence for argument in name)
    names = {line.split()[0] for line in listed}
    assert "tables" in names
    assert names.isdisjoint({"common", "against_side", "no_benchmark"})


# --- the charts of the docs, drawn from the stored figures --------------------------------------------------


def stored(name):
    return json.loads((BENCHMARKS / "results" / f"{name}.json").read_text(encoding="utf-8"))


def title_and_page(module, record):
    with mpl.rc_context(STYLE):
        page = Figure(figsize=getattr(module, "SIZE", (9.5, 5.0)), layout="constrained")
        module.draw(page, record)
        page.draw_without_rendering()
    return page.get_suptitle() or page.texts[0].get_text(), page


@pytest.fixture(scope="module")
def drawing(charts):
    """Return a function from the name of a benchmark to (title, page), drawn once from its record."""
    return functools.cache(lambda name: title_and_page(charts(name), stored(name)))


@pytest.mark.full("needs compilers")
@pytest.mark.parametrize("name", ["work_precision", "stability", "fidelity", "friction", "rest"])
def test_a_chart_is_drawn_with_its_quantities_above_and_figures_below(drawing, name):
    title, page = drawing(name)
    assert len(title) < 100
    assert title.startswith("chain-impact")
    assert page.get_figwidth() == pytest.approx(190.0 / 25.4), "a printed page is so wide"
    sizes = {text.get_fontsize() for text in page.findobj(Text) if text.get_text().strip()}
    assert min(sizes) > 7.4
    assert re.search(r"\d", " ".join(text.get_text() for text in page.texts if text.get_text() != title))


def test_the_chart_of_friction_tells_factors_of_time_and_error(charts):
    module, results = charts("friction"), stored("friction")["results"]
    title, text = module.headline(results)
    at = {
        key: next(
            r for r in results[key] if (r["name"], r["setting"]) == (module.CREEPS, module.HEADLINE_STEP)
        )
        for key in module.TIMES
    }
    our_errors = {key: max(r["error"] for r in results[key] if r["name"] == "ours") for key in module.TIMES}
    error_ratios = sorted(at[key]["error"] / our_errors[key] for key in module.TIMES)
    assert error_ratios[0] > 10.0, "the errors are not equal"
    times = sorted(row["times ours"] for row in at.values())
    assert f"thrown chain: {times[0]:.2g} to {times[1]:.2g} times the CPU time" in text
    assert f"{error_ratios[0]:.2g} to {error_ratios[1]:.2g} times the error" in text
    assert "equal error" not in title + text


def test_an_error_is_compared_with_that_of_the_loosest_run(charts):
    race = charts("race")
    runs = ((1e-6, 3.0), (1e-3, 1.0), (1e-2, 2.0))
    rows = [{"tip": tip, "seconds": {"median": time}} for tip, time in runs]
    assert race.above_loosest(1e-4, rows) == 1.0
    assert race.above_loosest(5e-2, rows) == pytest.approx(50.0)
    assert race.seconds_at(5e-2, rows) == pytest.approx(race.seconds_at(1e-3, rows))


def test_both_panels_of_the_errors_of_models_have_the_same_limits(drawing):
    _, page = drawing("fidelity")
    (first, strip, second, _), time = page.axes, "CPU time [ms]"
    assert len({axes.get_ylim() for axes in page.axes}) == 1
    assert [axes.get_xlabel() for axes in (first, second)] == [time] * 2
    assert strip.get_xlabel() == "other K"
    assert not len(strip.get_xticks())
    assert first.get_xlim() != second.get_xlim()
    assert len(page.legends[0].get_texts()) == 5, "stiffnesses have their names at their lines"
    assert "right" not in " ".join(text.get_text() for text in page.texts)


def test_methods_that_complete_more_runs_come_first(drawing):
    _, page = drawing("stability")
    titles = [axes.get_title() for axes in page.axes if ": " in axes.get_title()]
    completed_runs = [
        int(title.rpartition(" ")[2]) for title in titles if not title.startswith("chain-impact")
    ]
    assert completed_runs == sorted(completed_runs, reverse=True)
    assert titles[0].startswith("chain-impact auto")
    assert [axes.get_ylabel() for axes in page.axes].count("restitution e") == 1


def test_a_peer_without_a_time_is_a_gap(charts):
    module, record = charts("work_precision"), stored("work_precision")
    results = record["results"]
    for row in results["rows"]:
        if row["name"] == "CVODE Adams":
            row.pop("seconds", None)
    results["at equal error"] = module.at_equal_error(results["rows"])
    del results["start-up [s]"]["CVODE Adams"]
    assert not [row for row in results["at equal error"] if "CVODE Adams" in row["times as long"]]
    _, page = title_and_page(module, record)
    assert "CVODE Adams" not in " ".join(text.get_text() for text in page.texts)
    assert module.headline([]) == ("", "")


@pytest.mark.full("takes long")
def test_the_title_of_the_speeds_has_one_contender_at_one_tolerance(charts, drawing):
    module, record = charts("work_precision"), stored("work_precision")
    title, page = drawing("work_precision")
    low, high = map(float, re.search(r"is ([\d.]+) to ([\d.]+) times as fast as CVODE", title).groups())
    times = [
        row["times as long"]
        for row in record["results"]["at equal error"]
        if row["setting"] == module.HEADLINE_TOLERANCE
    ]
    factors = {name: [row[name] for row in times if name in row] for name in module.LOOKS}
    assert [low, high] == pytest.approx([min(factors[module.PEER]), max(factors[module.PEER])], rel=0.05)
    assert title.endswith("at equal error (our tolerance 1e-8)")
    page_text = " ".join(text.get_text() for text in page.texts)
    peers = {name for name in factors if factors[name]} - {module.PEER, *("chain-impact", "kernel alone")}
    assert "times as fast as others: " in page_text
    assert all(f"{name} {min(factors[name]):.2g}" in page_text for name in peers if "FMU" not in name)


@pytest.mark.full("takes long")
def test_the_title_of_a_chain_at_rest_does_not_mix_methods(charts, drawing):
    module, record = charts("rest"), stored("rest")
    title, _ = drawing("rest")
    ratios = [row[module.CAREFUL]["time / ours"]["median"] for row in record["results"]]
    ends = " to ".join(f"{charts('common').rounded(end(ratios), 2):g}" for end in (min, max))
    assert f"is {ends} times as fast as CVODE BDF" in title


def test_the_title_of_the_map_names_the_methods_that_complete_all_runs(drawing):
    title, page = drawing("stability")
    assert "as do CVODE BDF and SciPy LSODA; others complete 12 to 70" in title.replace("\n", " ")
    assert "over budget (2 s)" in [text.get_text() for text in page.legends[0].get_texts()]


def test_the_title_of_the_map_names_no_others_if_all_complete_all_runs(charts):
    record = stored("stability")
    results, settings = record["results"], record["settings"]
    cells = len(settings["stiffnesses"]) * len(settings["restitutions"])
    results["tally"] = {method: {"completed": cells} for method in results["tally"]}
    assert "others" not in title_and_page(charts("stability"), record)[0]


def test_a_curve_without_a_free_place_has_a_key_below_the_panels(charts):
    page = Figure(layout="constrained")
    axes = page.subplots()
    for k in range(100):
        axes.plot([0.0, 1.0], [k, k], label="crowded" if k == 50 else "_other")
    page.legend(handles=[Line2D([], [], label="key")], loc="outside lower center")
    charts("looks").name_curves(page, [axes])
    assert not axes.texts
    (legend,) = page.legends
    assert [text.get_text() for text in legend.get_texts()] == ["crowded", "key"]
    assert legend.get_window_extent().y1 < axes.get_tightbbox().y0


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("name", ["work_precision", "friction", "rest"])
def test_each_curve_has_its_name_once_beside_it(charts, drawing, name):
    _, page = drawing(name)
    panels = [axes for axes in page.axes if axes.lines]
    curves = {line.get_label(): line for axes in panels for line in axes.lines}
    names = [text for axes in panels for text in axes.texts if text.get_text() in curves]
    curve_names = [text.get_text() for legend in page.legends for text in legend.get_texts()]
    curve_names = [text.get_text() for text in names] + [text for text in curve_names if text in curves]
    assert sorted(curve_names) == sorted(label for label in curves if not label.startswith("_"))
    for text in names:
        box, colour = text.get_window_extent(), curves[text.get_text()].get_color()
        ratio = np.array(to_rgb(text.get_color())) / np.maximum(to_rgb(colour), 1e-9)
        assert ratio[np.array(to_rgb(colour)) > 0.0] == pytest.approx(charts("looks").DARKENED)
        distances = {True: [], False: []}
        for line in (line for line in text.axes.lines if len(line.get_xydata())):
            places = line.get_transform().transform(line.get_xydata())
            ways = np.linspace(0.0, len(places) - 1.0, 100 * len(places))
            points = np.stack([np.interp(ways, np.arange(len(places)), part) for part in places.T], axis=1)
            gaps = np.hypot(*np.maximum(np.maximum(box.min - points, points - box.max), 0.0).T)
            distances[line.get_label() == text.get_text()].append(np.nanmin(gaps, initial=np.inf))
        assert 0.0 < min(distances[True]) < min(distances[False], default=np.inf), text.get_text()
        in_panel = [name.get_window_extent() for name in names if name.axes is text.axes]
        assert sum(map(box.overlaps, in_panel)) == 1


# --- measured impacts ---------------------------------------------------------------------------------------


@pytest.fixture
def impacts(charts, tmp_path):
    """Return the module, and a function that writes synthetic trials as the data set does and reads them."""
    module = charts("measured_impacts")

    def invent_impacts(restitution, friction, count=8):
        rng = np.random.default_rng(7)
        arm = np.stack([rng.uniform(-0.01, 0.01, count), rng.uniform(-0.035, -0.025, count)], axis=1)
        velocities = rng.uniform([-1.0, -3.0, -20.0], [1.0, -2.0, 20.0], (count, 3))
        inverse, end_velocities = np.diag([1.0, 1.0, module.GYRATION**-2]) / module.MASS, velocities.copy()
        for k, (arm_x, arm_y) in enumerate(arm):
            rows = np.array([[0.0, 1.0, arm_x], [1.0, 0.0, -arm_y]])
            w, (normal, slip_speed) = rows @ inverse @ rows.T, rows @ velocities[k]
            strike = Strike(w[0, 0], w[0, 1], w[1, 1], -normal, slip_speed, friction)
            end = stiff_limit(strike, exact_damping_factor(restitution))
            end_velocities[k] += inverse @ rows.T @ [end.normal, end.tangential]
        states = {
            f"states_{name}": np.hstack([0.0 * v, v * [-1, 1, 1]])
            for name, v in (("i", velocities), ("f", end_velocities))
        }
        ones = np.ones(count)
        places = {
            "n": np.stack([0 * ones, ones, arm[:, 0]], 1),
            "d": np.stack([ones, 0 * ones, -arm[:, 1]], 1),
        }
        savemat(tmp_path / "data_ellipse.mat", {"data": states | places})
        return module.read(tmp_path)

    return module, invent_impacts


def test_restitution_and_friction_of_made_up_impacts_are_found_again(impacts):
    module, invent_impacts = impacts
    trials = invent_impacts(0.7, 0.15)
    estimate = module.fitted(module.ellipse(), trials[::2])
    assert estimate.values == pytest.approx({"contact.restitution": 0.7, "contact.friction": 0.15}, rel=5e-3)
    assert module.errors(trials[1::2], module.predicted(estimate.scene, trials[1::2])).max() < 5e-3


def test_a_stiff_spring_along_the_wall_comes_to_a_rigid_elastic_impact(impacts):
    module, invent_impacts = impacts
    trials = invent_impacts(1.0, 0.2)
    assert module.errors(trials, module.compliant(trials, 1.0, 0.2, 100.0)).max() < 0.05
    assert module.errors(trials, module.compliant(trials, 1.0, 0.2, 1.0)).max() > 0.1


def test_the_measured_impacts_support_no_compliance_along_the_wall():
    rows = stored("measured_impacts")["results"]["odd trials"]
    medians = {name: row["median"] for name, row in rows.items() if "median" in row}
    assert (
        min(medians[name] for name in medians if name.startswith("compliance")) > 0.9 * medians["zhang_sharf"]
    )


# --- the measured arm ---------------------------------------------------------------------------------------


@pytest.mark.full("takes long")
def test_the_friction_of_a_made_up_arm_is_found_again(charts, tmp_path):
    module = charts("measured_arm")
    expected = {"link[1].joint_friction": 0.2, "link[2].joint_friction": 0.1, "link[2].joint_damping": 0.02}
    expected |= {"link[1].center_of_mass": 0.15, "link[2].center_of_mass": 0.2}
    torques = {
        "joint[1].torque": lambda t: math.sin(5 * t),
        "joint[2].torque": lambda t: 0.6 * math.cos(7 * t),
    }
    scene = module.arm().with_values(expected)
    run = chain_impact.simulate(scene, stop_time=4.0, output_step=2e-3, inputs=torques)
    first, second = run["link[1].angle"] + math.pi / 2, run["link[2].angle"] - run["link[1].angle"]
    drives = [[drive(time) for time in run.time] for drive in torques.values()]
    columns = np.stack([run.time, first, second, *drives], axis=1)
    names = "time,pos_meas1,pos_meas2,tau_meas1,tau_meas2"
    np.savetxt(tmp_path / "run.csv", columns, delimiter=",", header=names, comments="")
    result, _ = module.fitted(module.read(tmp_path / "run.csv"), dry=True)
    for name, value in expected.items():
        assert result[name]["value"] == pytest.approx(value, rel=0.05), name


def test_dry_friction_predicts_the_measured_arm_better():
    results = stored("measured_arm")["results"]
    dry, viscous = (result["rms, unseen"] for result in results.values())
    assert dry < 0.5 * viscous

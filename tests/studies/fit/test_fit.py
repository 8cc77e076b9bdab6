"""Fits from end to end: values, intervals, several data sets, bounds, omitted data."""

# Tests: studies/fit/remarks.py

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import SceneError, fit, load_scene, simulate
from chain_impact.studies.fit import horizon
from chain_impact.studies.fit.remarks import not_random
from tests.helpers.tools.measurements import FREE, NOISE, TIP, TRUE, impacts, motion, scene
from tests.helpers.tools.refusal import refusal

START = scene(K=3e7, e=0.5, w=1.6)
SIGMA = dict.fromkeys(TIP, NOISE)


@pytest.fixture(scope="module")
def found():
    return fit(START, motion(0.9)[0], FREE, sigma=SIGMA)


def test_values_and_their_errors(found):
    assert found.converged
    assert list(found.values) == list(FREE)
    for name, true in zip(FREE, TRUE, strict=True):
        low, high = found.intervals[name]
        assert low < found.values[name] < high
        assert abs(found.values[name] - true) < 4.0 * found.standard_errors[name]
    assert found.standard_errors[FREE[1]] < 0.01
    # symmetric on the scale of the search: 1.96 standard errors, as a factor for a positive value
    low, high = found.intervals[FREE[0]]
    relative = found.standard_errors[FREE[0]] / found.values[FREE[0]]
    assert math.log(high / low) == pytest.approx(2 * 1.959964 * relative, rel=1e-6)
    low, high = found.intervals[FREE[1]]
    assert high - low == pytest.approx(2 * 1.959964 * found.standard_errors[FREE[1]], rel=1e-6)


def test_a_table_of_pandas_is_a_table(found):
    import pandas  # here, because the import takes half a second

    samples = motion(0.9)[0]
    table = pandas.DataFrame({name: list(cells) for name, cells in samples.items()})
    for data in (table, [table], [[table]]):
        assert fit(START, data, FREE, sigma=SIGMA).values == found.values


def test_forces_in_joints_tell_mass_stiffness_and_restitution():
    true = {"link[2].mass": 1.1, "contact.stiffness": 1.2e7, "contact.restitution": 0.55}
    arm = load_scene("pinned_arm").with_values({"outputs.loads": True, "simulation.stop_time": 0.8})
    result = simulate(arm.with_values(true), output_step=0.02)
    names = ["joint[1].force.x", "joint[1].impulse.y", "joint[2].moment"]
    samples = {"time": result.time[1:]} | {name: result[name][1:] for name in names}
    impact = {
        "impact": [1],
        "joint_force": result.impacts["joint_force"],
        "peak_force": result.impacts["peak_force"],
    }
    sigma = dict.fromkeys(names, 1e-3) | dict.fromkeys(("joint_force", "peak_force"), 0.1)
    found = fit(arm, [[samples, impact]], list(true), sigma=sigma)
    assert found.converged
    for name, value in true.items():
        assert found.values[name] == pytest.approx(value, rel=1e-5)


def test_a_fit_tells_its_statistics(found):
    assert found.freedom == 397
    assert 0.8 < found.reduced_chi_squared < 1.2
    assert found.chi_squared == pytest.approx(found.deviance)
    assert found.aic == pytest.approx(found.chi_squared + 6.0)
    assert np.diag(found.correlation) == pytest.approx(1.0)
    assert (np.abs(found.correlation) <= 1.0 + 1e-12).all()
    assert found.estimated == ()
    assert found.evaluations > 5
    assert found.residuals[found.columns[TIP[0]]].std() == pytest.approx(NOISE, rel=0.2)


def test_the_fitted_scene_runs_and_follows_the_data(found):
    columns, _ = motion(0.9)
    result = simulate(found.scene, stop_time=0.9, output_step=0.9 / 200)
    residuals = np.stack([result[name][1:] - columns[name] for name in TIP], axis=1)
    assert residuals.ravel() == pytest.approx(found.residuals, abs=1e-5)
    assert found.scene.values["contact.stiffness"] == found.values["contact.stiffness"]
    assert found.scene.with_values(dict(zip(FREE, TRUE, strict=True))) == scene()


def test_a_search_that_ends_too_early_says_so(found, monkeypatch):
    assert not [note for note in found.notes if "converge" in note]
    for name in ("ROUGH_STEPS", "FINE_STEPS"):
        monkeypatch.setattr(horizon, name, 1)
    short = fit(START, motion(0.9)[0], FREE, sigma=SIGMA)
    assert not short.converged
    assert short.notes[0].startswith("The search did not converge in 1 steps: ")


def test_an_estimated_standard_deviation_widens_the_intervals():
    columns = {name: values[::10] for name, values in motion(0.9)[0].items()}
    given, estimated = fit(scene(), columns, FREE, sigma=SIGMA), fit(scene(), columns, FREE)
    assert estimated.estimated == TIP
    assert estimated.reduced_chi_squared == pytest.approx(1.0, rel=0.02)
    width = {estimate: np.ptp(np.log(estimate.intervals[FREE[0]])) for estimate in (given, estimated)}
    error = {
        estimate: estimate.standard_errors[FREE[0]] / estimate.values[FREE[0]]
        for estimate in (given, estimated)
    }
    assert width[estimated] / error[estimated] > 1.02 * width[given] / error[given]


@pytest.mark.full("takes long")
def test_few_values_give_wide_intervals_that_hold_the_truth():
    """K follows from three peak forces, as the tip's path hardly depends on K: two degrees of freedom."""
    path, result = motion(0.9)
    held, widths = 0, []
    for seed in range(40):
        noisy = {"time": path["time"]} | {
            name: result[name][1:] + NOISE * np.random.default_rng(seed).standard_normal((2, 200))[k]
            for k, name in enumerate(TIP)
        }
        plate = {name: values[:3] for name, values in impacts(result, ["peak_force"], 1e-3, seed).items()}
        found = fit(scene(), [[noisy, plate]], FREE[:2])
        low, high = found.intervals[FREE[0]]
        held += low < TRUE[0] < high
        widths.append(math.log(high / low) / (2 * found.standard_errors[FREE[0]] / found.values[FREE[0]]))
    assert min(widths) > 3.0
    assert held >= 35  # 40 runs at 95 %; fewer than 35 occur by chance once in 200 times
    assert any(note.startswith("peak_force has 3 values: a σ that is estimated") for note in found.notes)


def test_data_after_the_stop_time_are_not_used_and_that_is_said():
    columns, _ = motion(0.9)
    early = {name: values[:100] for name, values in columns.items()}
    wanted, found = fit(START, early, FREE[:2]), fit(START, columns, FREE[:2], stop_time=0.4501)
    assert found.values == wanted.values
    assert len(found.residuals) == 200
    assert found.notes[0] == "200 of 400 values lie after the stop time, 0.4501 s: they were not used."
    assert found.scene.simulation.stop_time == 0.4501
    told = refusal(lambda: fit(START, columns, FREE[:2], stop_time=0.001))
    assert told.endswith("no value was measured until the stop time, 0.001 s; the first is at 0.0045 s")


def test_impacts_after_the_stop_time_are_not_used():
    _, result = motion(0.9)
    table = impacts(result, ["onset", "peak_force"], 1e-3)
    found = fit(START, table, FREE[:2], sigma={"onset": 1e-4, "peak_force": "1%"}, stop_time=0.6)
    assert len(found.residuals) == 2 * (result.impacts["onset"] <= 0.6).sum() < 2 * len(result.impacts)


def test_several_data_sets_share_what_is_free():
    """Three throws have different speeds and different known heights; each speed is a separate parameter."""
    heights, speeds = (1.4, 1.3, 1.45), (1.5, 1.2, 1.8)
    tables = []
    for k, (y, vx) in enumerate(zip(heights, speeds, strict=True)):
        result = simulate(
            scene().with_values({"initial.y": y, "initial.vx": vx}), stop_time=0.6, output_step=0.01
        )
        noise = 1e-4 * np.random.default_rng(k).standard_normal((61, 2))
        tables.append({"time": result.time} | {n: result[n] + noise[:, i] for i, n in enumerate(TIP)})
    found = fit(
        scene(e=0.6),
        tables,
        ["contact.restitution"],
        free_each=["initial.vx"],
        set_each={"initial.y": heights},
        sigma=dict.fromkeys(TIP, 1e-4),
    )
    assert found.converged
    names = ["contact.restitution", *(f"initial.vx of data set {k}" for k in (1, 2, 3))]
    assert list(found.values) == names
    assert list(found.values.values()) == pytest.approx([0.7, *speeds], abs=1e-3)
    assert [one.values["initial.y"] for one in found.scenes] == list(heights)
    assert [one.values["initial.vx"] for one in found.scenes] == list(found.values.values())[1:]
    # the speed of one throw depends on the others only through shared parameters
    assert abs(found.correlation[1, 2]) < 0.5


def test_bounds_are_kept_and_said():
    found = fit(START, motion(0.7)[0], FREE, sigma=SIGMA, bounds={"contact.restitution": "0.4:0.65"})
    assert found.values["contact.restitution"] == pytest.approx(0.65)
    assert (
        "contact.restitution is at its upper bound, 0.65: its standard error and interval do not hold."
        in found.notes
    )
    assert any("the model does not follow the data within their σ" in note for note in found.notes)


@pytest.mark.parametrize("columns", [1, 2])
def test_a_sigma_that_is_too_large_is_said(columns):
    data, _ = motion(0.3, count=60)
    found = fit(START, data, FREE[2:], sigma=dict.fromkeys(TIP[:columns], 3.0 * NOISE))
    (said,) = [note for note in found.notes if note.startswith("χ²")]
    assert said.endswith("more closely than their σ allow, so the standard errors are too large.")
    right = fit(START, data, FREE[2:], sigma=dict.fromkeys(TIP[:columns], NOISE))
    assert not [note for note in right.notes if note.startswith("χ²")]


def test_a_value_that_nears_a_bound_is_on_it():
    """Negative damping would fit best: the search approaches 0 endlessly, and the fit is at 0."""
    arm = load_scene("triple_pendulum")
    truth = simulate(arm.with_values({"link[1].joint_damping": 0.0}), stop_time=1.0, output_step=0.01)
    columns = {"time": truth.time, "link[1].angle": truth["link[1].angle"] * (1.0 + 0.01 * truth.time)}
    found = fit(arm, columns, ["link[1].joint_damping", "link[1].mass"], sigma={"link[1].angle": 1e-3})
    assert found.values["link[1].joint_damping"] == 0.0
    assert found.scene.values["link[1].joint_damping"] == 0.0
    assert found.parameters[0].low == 0.0
    assert any(note.startswith("link[1].joint_damping is at its lower bound, 0:") for note in found.notes)
    assert not found.unknown


def test_a_small_value_is_not_taken_for_its_bound():
    """A damping in SI units is small: 1e-7 is far from 0 if the data determine it to a percent."""
    arm = load_scene("triple_pendulum")
    true = {f"link[{k}].joint_damping": 1e-7 for k in (1, 2, 3)}
    scaled = {
        f"link[{k}].{what}": 1e-4 * arm.values[f"link[{k}].{what}"]
        for k in (1, 2, 3)
        for what in ("mass", "inertia")
    }
    light = arm.with_values(scaled | true)
    result = simulate(light, stop_time=2.0, output_step=0.01)
    columns = {"time": result.time, "link[1].angle": result["link[1].angle"]}
    found = fit(
        light.with_values({"link[1].joint_damping": 2e-7}),
        columns,
        ["link[1].joint_damping"],
        sigma={"link[1].angle": 1e-4},
    )
    assert found.values["link[1].joint_damping"] == pytest.approx(1e-7, rel=0.02)
    assert not found.notes


def test_impacts_that_are_not_there_are_left_out_and_said():
    columns, result = motion(0.7)
    table = impacts(result, ["onset"]) | {"wall": ["y_min", "x_max"]}
    found = fit(scene(), [[columns, table]], FREE, sigma=SIGMA | {"onset": 1e-4})
    assert found.used.tolist() == [True] * 401 + [False]
    assert found.notes == (
        "1 of 402 values were left out, of onset: "
        "the model has no such impact, or its contact lasts to the end.",
    )


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("count", "wrong"), [(12, 9), (12, 3), (6, 4)])
def test_an_impact_with_a_wrong_number_is_named(count, wrong):
    rod = load_scene("rod_drop")
    numbers, onsets = np.arange(count) + 1, simulate(rod).impacts["onset"][:count]
    start, free = rod.with_values({"contact.restitution": 0.65}), ["contact.restitution"]
    noise = 1e-4 * np.random.default_rng(0).standard_normal(count)
    found = fit(start, {"impact": numbers, "onset": onsets + noise}, free)
    assert not any("impact" in note for note in found.notes)
    numbers[1] = wrong
    found = fit(start, {"impact": numbers, "onset": onsets + noise}, free)
    named = [re.findall(r"impact (\d+)", note) for note in found.notes if "impact" in note]
    assert named == [[str(wrong)]]
    assert not any(
        "impact" in note
        for note in fit(
            start, {"impact": numbers, "onset": onsets + noise}, free, sigma={"onset": 10.0}
        ).notes
    )


def test_a_peak_force_cannot_be_fitted_to_rigid_walls():
    rod = load_scene("rod_drop")
    table, free = impacts(simulate(rod), ["onset", "peak_force"]), ["contact.restitution"]
    rigid = rod.with_values({"contact.model": "newton_impact"})
    with pytest.raises(SceneError, match=r"newton_impact, has no peak_force"):
        fit(rigid, table, free)
    assert fit(rigid, table, free, columns=["onset"]).used.any()


def test_columns_of_impacts_that_rigid_walls_do_not_reach_are_left_out():
    rigid = load_scene("rod_drop").with_values({"contact.model": "newton_impact"})
    result = simulate(rigid)
    count = len(result.impacts)
    beyond = {"impact": [count + 1, count + 2], "impact_speed": [1.0, 0.9], "impulse": [0.2, 0.1]}
    found = fit(rigid, [[impacts(result, ["onset"]), beyond]], ["contact.restitution"])
    assert (found.used == (np.array(found.data[0].quantity) == "onset")).all()
    assert found.values["contact.restitution"] == pytest.approx(rigid.contact.restitution)


def test_residuals_that_are_no_noise_are_said():
    columns, _ = motion(0.45)
    columns[TIP[1]] += 5e-3 * np.sin(40.0 * columns["time"])
    found = fit(scene(), columns, ["initial.vy"])
    (said,) = found.notes
    assert said.startswith(
        "Neighbouring residuals are correlated, so they are not only noise: point[4].y (0.9"
    )


def test_residuals_of_two_data_sets_are_no_neighbours():
    def said(residuals):
        """Return the report on residuals with a row for each data set."""
        count = residuals.size
        made = SimpleNamespace(
            data=[[0.0] * len(row) for row in residuals],
            residuals=residuals.ravel(),
            sigma=np.ones(count),
            used=np.full(count, True),
            columns={"point[1].y": np.full(count, True)},
        )
        return list(not_random(made))

    grows = np.linspace(-1.0, 1.0, 40)
    assert said(grows.reshape(40, 1)) == [], "single values have no neighbours"
    assert said(np.stack([grows, -grows], axis=1)) == [], "within a data set they differ"
    assert len(said(grows.reshape(4, 10))) == len(said(grows.reshape(1, 40))) == 1


def test_data_in_another_unit_of_time_are_refused_before_the_first_run(monkeypatch):
    drop = load_scene("rod_drop")
    columns = {"time": [0.0, 1e3, 2e3], "point[1].y": [1.0, 0.5, 0.2]}
    asked = "data lasts 2000 s, 1000 times as long as the scene, 2 s: its time must be in s, not in ms"

    def run(*_):
        raise AssertionError("a run began")

    monkeypatch.setattr("chain_impact.studies.fit.fit.Problem", run)
    with pytest.raises(SceneError, match=re.escape(asked)):
        fit(drop, columns, ["contact.restitution"])
    with pytest.raises(AssertionError, match="a run"):
        fit(drop, columns, ["contact.restitution"], stop_time=2e3)


def test_an_input_can_be_free():
    arm = load_scene("pinned_arm")
    result = simulate(arm, stop_time=0.5, output_step=0.01, inputs={"joint[1].torque": 0.8})
    columns = {"time": result.time, "link[1].angle": result["link[1].angle"]}
    found = fit(arm, columns, ["joint[1].torque"], sigma={"link[1].angle": 1e-4})
    assert found.values["joint[1].torque"] == pytest.approx(0.8, abs=1e-3)
    assert found.notes == ("joint[1].torque is an input: the fitted scene does not hold it.",)
    assert found.scene == arm


def test_measured_impacts_of_a_golf_ball():
    """The data are times of nine impacts; the closed form by SciPy gives a second fit."""
    from scipy.optimize import least_squares

    ball, g = load_scene("golf_ball"), 9.81
    flights = np.array([0.7229, 0.6466, 0.5811, 0.5219, 0.4695, 0.4226, 0.3794, 0.3405])
    fall = math.sqrt(2 * 0.8 / g)
    onsets = fall + np.concatenate([[0.0], np.cumsum(flights)])
    found = fit(ball, {"impact": range(1, 10), "onset": onsets}, ["contact.restitution"])

    def residuals(e):
        return fall + np.concatenate([[0.0], np.cumsum(2.0 * fall * e ** np.arange(1, 9))]) - onsets

    other = least_squares(residuals, [0.9], xtol=1e-14)
    assert found.values["contact.restitution"] == pytest.approx(other.x[0], abs=1e-8)
    error = math.sqrt(2.0 * other.cost / 8.0 / (other.jac.T @ other.jac)[0, 0])
    assert found.standard_errors["contact.restitution"] == pytest.approx(error, rel=1e-4)
    assert "Neighbouring residuals are correlated" in found.notes[0]


def test_wrong_arguments_of_a_fit_are_refused():
    columns, _ = motion(0.3, count=5)
    assert refusal(lambda: fit(START, [], FREE)) == "data: must be at least one table"
    assert refusal(lambda: fit(START, columns, FREE, set_each={"initial.y": [1.0, 2.0]})) == (
        "FourLinkBox: initial.y has 2 values, must have 1, one for each data set"
    )
    assert "sigma of point[4].z: no such column was measured, but point[4].x, point[4].y" in refusal(
        lambda: fit(START, columns, FREE, sigma={"point[4].z": 1.0})
    )
    few = {"time": [0.1], "point[4].x": [2.3]}
    assert refusal(lambda: fit(START, few, FREE, sigma=SIGMA_X)) == (
        "FourLinkBox: 1 value can be fitted, must be at least 3, as many as parameters are free"
    )


SIGMA_X = {"point[4].x": 1e-3}

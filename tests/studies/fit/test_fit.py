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
def fit_result():
    return fit(START, motion(0.9)[0], FREE, sigma=SIGMA)


def test_values_and_their_errors(fit_result):
    assert fit_result.converged
    assert list(fit_result.values) == list(FREE)
    for name, expected in zip(FREE, TRUE, strict=True):
        low, high = fit_result.intervals[name]
        assert low < fit_result.values[name] < high
        assert abs(fit_result.values[name] - expected) < 4.0 * fit_result.standard_errors[name]
    assert fit_result.standard_errors[FREE[1]] < 0.01
    # symmetric on the scale of the search: 1.96 standard errors, as a factor for a positive value
    low, high = fit_result.intervals[FREE[0]]
    relative_error = fit_result.standard_errors[FREE[0]] / fit_result.values[FREE[0]]
    assert math.log(high / low) == pytest.approx(2 * 1.959964 * relative_error, rel=1e-6)
    low, high = fit_result.intervals[FREE[1]]
    assert high - low == pytest.approx(2 * 1.959964 * fit_result.standard_errors[FREE[1]], rel=1e-6)


def test_a_table_of_pandas_is_a_table(fit_result):
    import pandas  # here, because the import takes half a second

    samples = motion(0.9)[0]
    table = pandas.DataFrame({name: list(cells) for name, cells in samples.items()})
    for data in (table, [table], [[table]]):
        assert fit(START, data, FREE, sigma=SIGMA).values == fit_result.values


def test_forces_in_joints_tell_mass_stiffness_and_restitution():
    true_values = {"link[2].mass": 1.1, "contact.stiffness": 1.2e7, "contact.restitution": 0.55}
    arm = load_scene("pinned_arm").with_values({"outputs.loads": True, "simulation.stop_time": 0.8})
    result = simulate(arm.with_values(true_values), output_step=0.02)
    names = ["joint[1].force.x", "joint[1].impulse.y", "joint[2].moment"]
    samples = {"time": result.time[1:]} | {name: result[name][1:] for name in names}
    impact = {
        "impact": [1],
        "joint_force": result.impacts["joint_force"],
        "peak_force": result.impacts["peak_force"],
    }
    sigma = dict.fromkeys(names, 1e-3) | dict.fromkeys(("joint_force", "peak_force"), 0.1)
    fit_result = fit(arm, [[samples, impact]], list(true_values), sigma=sigma)
    assert fit_result.converged
    for name, value in true_values.items():
        assert fit_result.values[name] == pytest.approx(value, rel=1e-5)


def test_a_fit_tells_its_statistics(fit_result):
    assert fit_result.freedom == 397
    assert 0.8 < fit_result.reduced_chi_squared < 1.2
    assert fit_result.chi_squared == pytest.approx(fit_result.deviance)
    assert fit_result.aic == pytest.approx(fit_result.chi_squared + 6.0)
    assert np.diag(fit_result.correlation) == pytest.approx(1.0)
    assert (np.abs(fit_result.correlation) <= 1.0 + 1e-12).all()
    assert fit_result.estimated == ()
    assert fit_result.evaluations > 5
    assert fit_result.residuals[fit_result.columns[TIP[0]]].std() == pytest.approx(NOISE, rel=0.2)


def test_the_fitted_scene_runs_and_follows_the_data(fit_result):
    columns, _ = motion(0.9)
    result = simulate(fit_result.scene, stop_time=0.9, output_step=0.9 / 200)
    residuals = np.stack([result[name][1:] - columns[name] for name in TIP], axis=1)
    assert residuals.ravel() == pytest.approx(fit_result.residuals, abs=1e-5)
    assert fit_result.scene.values["contact.stiffness"] == fit_result.values["contact.stiffness"]
    assert fit_result.scene.with_values(dict(zip(FREE, TRUE, strict=True))) == scene()


def test_a_search_that_ends_too_early_says_so(fit_result, monkeypatch):
    assert not [note for note in fit_result.notes if "converge" in note]
    for name in ("ROUGH_STEPS", "FINE_STEPS"):
        monkeypatch.setattr(horizon, name, 1)
    short = fit(START, motion(0.9)[0], FREE, sigma=SIGMA)
    assert not short.converged
    assert short.notes[0].startswith("The search did not converge in 1 steps: ")


def test_an_estimated_standard_deviation_widens_the_intervals():
    columns = {name: values[::10] for name, values in motion(0.9)[0].items()}
    given_fit, estimated_fit = fit(scene(), columns, FREE, sigma=SIGMA), fit(scene(), columns, FREE)
    assert estimated_fit.estimated == TIP
    assert estimated_fit.reduced_chi_squared == pytest.approx(1.0, rel=0.02)
    widths = {
        sigma_fit: np.ptp(np.log(sigma_fit.intervals[FREE[0]])) for sigma_fit in (given_fit, estimated_fit)
    }
    errors = {
        sigma_fit: sigma_fit.standard_errors[FREE[0]] / sigma_fit.values[FREE[0]]
        for sigma_fit in (given_fit, estimated_fit)
    }
    assert widths[estimated_fit] / errors[estimated_fit] > 1.02 * widths[given_fit] / errors[given_fit]


@pytest.mark.full("takes long")
def test_few_values_give_wide_intervals_that_hold_the_truth():
    """K follows from three peak forces only, as the motion hardly depends on K: 3 − 1 degrees of freedom."""
    path, result = motion(0.9)
    hold_count, widths = 0, []
    for seed in range(40):
        noisy = {"time": path["time"]} | {
            name: result[name][1:] + NOISE * np.random.default_rng(seed).standard_normal((2, 200))[k]
            for k, name in enumerate(TIP)
        }
        plate = {name: values[:3] for name, values in impacts(result, ["peak_force"], 1e-3, seed).items()}
        fit_result = fit(scene(), [[noisy, plate]], FREE[:2])
        low, high = fit_result.intervals[FREE[0]]
        hold_count += low < TRUE[0] < high
        widths.append(
            math.log(high / low) / (2 * fit_result.standard_errors[FREE[0]] / fit_result.values[FREE[0]])
        )
    assert min(widths) > 3.0
    assert hold_count >= 35  # 40 intervals of 95 %; fewer than 35 hold the value by chance once in 70 times
    assert any(note.startswith("peak_force has 3 values: a σ that is estimated") for note in fit_result.notes)


def test_data_after_the_stop_time_are_not_used_and_that_is_said():
    columns, _ = motion(0.9)
    early = {name: values[:100] for name, values in columns.items()}
    expected, fit_result = fit(START, early, FREE[:2]), fit(START, columns, FREE[:2], stop_time=0.4501)
    assert fit_result.values == expected.values
    assert len(fit_result.residuals) == 200
    assert fit_result.notes[0] == "200 of 400 values lie after the stop time, 0.4501 s: they were not used."
    assert fit_result.scene.simulation.stop_time == 0.4501
    message = refusal(lambda: fit(START, columns, FREE[:2], stop_time=0.001))
    assert message.endswith("no value was measured until the stop time, 0.001 s; the first is at 0.0045 s")


def test_impacts_after_the_stop_time_are_not_used():
    _, result = motion(0.9)
    table = impacts(result, ["onset", "peak_force"], 1e-3)
    fit_result = fit(START, table, FREE[:2], sigma={"onset": 1e-4, "peak_force": "1%"}, stop_time=0.6)
    assert len(fit_result.residuals) == 2 * (result.impacts["onset"] <= 0.6).sum() < 2 * len(result.impacts)


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
    fit_result = fit(
        scene(e=0.6),
        tables,
        ["contact.restitution"],
        free_each=["initial.vx"],
        set_each={"initial.y": heights},
        sigma=dict.fromkeys(TIP, 1e-4),
    )
    assert fit_result.converged
    names = ["contact.restitution", *(f"initial.vx of data set {k}" for k in (1, 2, 3))]
    assert list(fit_result.values) == names
    assert list(fit_result.values.values()) == pytest.approx([0.7, *speeds], abs=1e-3)
    assert [fitted_scene.values["initial.y"] for fitted_scene in fit_result.scenes] == list(heights)
    assert [fitted_scene.values["initial.vx"] for fitted_scene in fit_result.scenes] == list(
        fit_result.values.values()
    )[1:]
    # the speed of one throw depends on the others only through shared parameters
    assert abs(fit_result.correlation[1, 2]) < 0.5


def test_bounds_are_kept_and_said():
    fit_result = fit(START, motion(0.7)[0], FREE, sigma=SIGMA, bounds={"contact.restitution": "0.4:0.65"})
    assert fit_result.values["contact.restitution"] == pytest.approx(0.65)
    assert (
        "contact.restitution is at its upper bound, 0.65: its standard error and interval do not hold."
        in fit_result.notes
    )
    assert any("the model does not follow the data within their σ" in note for note in fit_result.notes)


@pytest.mark.parametrize("columns", [1, 2])
def test_a_sigma_that_is_too_large_is_said(columns):
    data, _ = motion(0.3, count=60)
    fit_result = fit(START, data, FREE[2:], sigma=dict.fromkeys(TIP[:columns], 3.0 * NOISE))
    (note,) = [note for note in fit_result.notes if note.startswith("χ²")]
    assert note.endswith("more closely than their σ allow, so the standard errors are too large.")
    usual_fit = fit(START, data, FREE[2:], sigma=dict.fromkeys(TIP[:columns], NOISE))
    assert not [note for note in usual_fit.notes if note.startswith("χ²")]


def test_a_value_that_nears_a_bound_is_on_it():
    """Negative damping would fit best: the search approaches 0 endlessly, and the fit is at 0."""
    arm = load_scene("triple_pendulum")
    measured_run = simulate(arm.with_values({"link[1].joint_damping": 0.0}), stop_time=1.0, output_step=0.01)
    columns = {
        "time": measured_run.time,
        "link[1].angle": measured_run["link[1].angle"] * (1.0 + 0.01 * measured_run.time),
    }
    fit_result = fit(arm, columns, ["link[1].joint_damping", "link[1].mass"], sigma={"link[1].angle": 1e-3})
    assert fit_result.values["link[1].joint_damping"] == 0.0
    assert fit_result.scene.values["link[1].joint_damping"] == 0.0
    assert fit_result.parameters[0].low == 0.0
    assert any(
        note.startswith("link[1].joint_damping is at its lower bound, 0:") for note in fit_result.notes
    )
    assert not fit_result.unknown


def test_a_small_value_is_not_taken_for_its_bound():
    """A damping in SI units is small: 1e-7 is far from 0 if the data determine it to a percent."""
    arm = load_scene("triple_pendulum")
    true_values = {f"link[{k}].joint_damping": 1e-7 for k in (1, 2, 3)}
    light_values = {
        f"link[{k}].{key}": 1e-4 * arm.values[f"link[{k}].{key}"]
        for k in (1, 2, 3)
        for key in ("mass", "inertia")
    }
    light = arm.with_values(light_values | true_values)
    result = simulate(light, stop_time=2.0, output_step=0.01)
    columns = {"time": result.time, "link[1].angle": result["link[1].angle"]}
    fit_result = fit(
        light.with_values({"link[1].joint_damping": 2e-7}),
        columns,
        ["link[1].joint_damping"],
        sigma={"link[1].angle": 1e-4},
    )
    assert fit_result.values["link[1].joint_damping"] == pytest.approx(1e-7, rel=0.02)
    assert not fit_result.notes


def test_impacts_that_are_not_there_are_left_out_and_said():
    columns, result = motion(0.7)
    table = impacts(result, ["onset"]) | {"wall": ["y_min", "x_max"]}
    fit_result = fit(scene(), [[columns, table]], FREE, sigma=SIGMA | {"onset": 1e-4})
    assert fit_result.used.tolist() == [True] * 401 + [False]
    assert fit_result.notes == (
        "1 of 402 values were left out, of onset: "
        "the model has no such impact, or its contact lasts to the end.",
    )


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("count", "wrong_number"), [(12, 9), (12, 3), (6, 4)])
def test_an_impact_with_a_wrong_number_is_named(count, wrong_number):
    rod = load_scene("rod_drop")
    numbers, onsets = np.arange(count) + 1, simulate(rod).impacts["onset"][:count]
    start, names = rod.with_values({"contact.restitution": 0.65}), ["contact.restitution"]
    noise = 1e-4 * np.random.default_rng(0).standard_normal(count)
    fit_result = fit(start, {"impact": numbers, "onset": onsets + noise}, names)
    assert not any("impact" in note for note in fit_result.notes)
    numbers[1] = wrong_number
    fit_result = fit(start, {"impact": numbers, "onset": onsets + noise}, names)
    named_numbers = [re.findall(r"impact (\d+)", note) for note in fit_result.notes if "impact" in note]
    assert named_numbers == [[str(wrong_number)]]
    assert not any(
        "impact" in note
        for note in fit(
            start, {"impact": numbers, "onset": onsets + noise}, names, sigma={"onset": 10.0}
        ).notes
    )


def test_a_peak_force_cannot_be_fitted_to_rigid_walls():
    rod = load_scene("rod_drop")
    table, names = impacts(simulate(rod), ["onset", "peak_force"]), ["contact.restitution"]
    rigid = rod.with_values({"contact.model": "newton_impact"})
    with pytest.raises(SceneError, match=r"newton_impact, has no peak_force"):
        fit(rigid, table, names)
    assert fit(rigid, table, names, columns=["onset"]).used.any()


def test_columns_of_impacts_that_rigid_walls_do_not_reach_are_left_out():
    rigid = load_scene("rod_drop").with_values({"contact.model": "newton_impact"})
    result = simulate(rigid)
    count = len(result.impacts)
    later_impacts = {"impact": [count + 1, count + 2], "impact_speed": [1.0, 0.9], "impulse": [0.2, 0.1]}
    fit_result = fit(rigid, [[impacts(result, ["onset"]), later_impacts]], ["contact.restitution"])
    assert (fit_result.used == (np.array(fit_result.data[0].quantity) == "onset")).all()
    assert fit_result.values["contact.restitution"] == pytest.approx(rigid.contact.restitution)


def test_residuals_that_are_no_noise_are_said():
    columns, _ = motion(0.45)
    columns[TIP[1]] += 5e-3 * np.sin(40.0 * columns["time"])
    fit_result = fit(scene(), columns, ["initial.vy"])
    (note,) = fit_result.notes
    assert note.startswith(
        "Neighbouring residuals are correlated, so they are not only noise: point[4].y (0.9"
    )


def test_residuals_of_two_data_sets_are_no_neighbours():
    def notes_on(residuals):
        """Return the notes on residuals with a row for each data set."""
        count = residuals.size
        fit_like = SimpleNamespace(
            data=[[0.0] * len(row) for row in residuals],
            residuals=residuals.ravel(),
            sigma=np.ones(count),
            used=np.full(count, True),
            columns={"point[1].y": np.full(count, True)},
        )
        return list(not_random(fit_like))

    grows = np.linspace(-1.0, 1.0, 40)
    assert notes_on(grows.reshape(40, 1)) == [], "single values have no neighbours"
    assert notes_on(np.stack([grows, -grows], axis=1)) == [], "within a data set they differ"
    assert len(notes_on(grows.reshape(4, 10))) == len(notes_on(grows.reshape(1, 40))) == 1


def test_data_in_another_unit_of_time_are_refused_before_the_first_run(monkeypatch):
    drop = load_scene("rod_drop")
    columns = {"time": [0.0, 1e3, 2e3], "point[1].y": [1.0, 0.5, 0.2]}
    message = "data lasts 2000 s, 1000 times as long as the scene, 2 s: its time must be in s, not in ms"

    def run(*_):
        raise AssertionError("a run began")

    monkeypatch.setattr("chain_impact.studies.fit.fit.Problem", run)
    with pytest.raises(SceneError, match=re.escape(message)):
        fit(drop, columns, ["contact.restitution"])
    with pytest.raises(AssertionError, match="a run"):
        fit(drop, columns, ["contact.restitution"], stop_time=2e3)


def test_an_input_can_be_free():
    arm = load_scene("pinned_arm")
    result = simulate(arm, stop_time=0.5, output_step=0.01, inputs={"joint[1].torque": 0.8})
    columns = {"time": result.time, "link[1].angle": result["link[1].angle"]}
    fit_result = fit(arm, columns, ["joint[1].torque"], sigma={"link[1].angle": 1e-4})
    assert fit_result.values["joint[1].torque"] == pytest.approx(0.8, abs=1e-3)
    assert fit_result.notes == ("joint[1].torque is an input: the fitted scene does not hold it.",)
    assert fit_result.scene == arm


def test_measured_impacts_of_a_golf_ball():
    """The data are times of nine impacts; SciPy fits the closed form of these times."""
    from scipy.optimize import least_squares

    ball, g = load_scene("golf_ball"), 9.81
    flights = np.array([0.7229, 0.6466, 0.5811, 0.5219, 0.4695, 0.4226, 0.3794, 0.3405])
    fall = math.sqrt(2 * 0.8 / g)
    onsets = fall + np.concatenate([[0.0], np.cumsum(flights)])
    fit_result = fit(ball, {"impact": range(1, 10), "onset": onsets}, ["contact.restitution"])

    def residuals(e):
        return fall + np.concatenate([[0.0], np.cumsum(2.0 * fall * e ** np.arange(1, 9))]) - onsets

    closed_form = least_squares(residuals, [0.9], xtol=1e-14)
    assert fit_result.values["contact.restitution"] == pytest.approx(closed_form.x[0], abs=1e-8)
    error = math.sqrt(2.0 * closed_form.cost / 8.0 / (closed_form.jac.T @ closed_form.jac)[0, 0])
    assert fit_result.standard_errors["contact.restitution"] == pytest.approx(error, rel=1e-4)
    assert "Neighbouring residuals are correlated" in fit_result.notes[0]


def test_wrong_arguments_of_a_fit_are_refused():
    columns, _ = motion(0.3, count=5)
    assert refusal(lambda: fit(START, [], FREE)) == "data: must be at least one table"
    assert refusal(lambda: fit(START, columns, FREE, set_each={"initial.y": [1.0, 2.0]})) == (
        "FourLinkBox: initial.y has 2 values, must have 1, one for each data set"
    )
    assert "sigma of point[4].z: no such column was measured, but point[4].x, point[4].y" in refusal(
        lambda: fit(START, columns, FREE, sigma={"point[4].z": 1.0})
    )
    table = {"time": [0.1], "point[4].x": [2.3]}
    assert refusal(lambda: fit(START, table, FREE, sigma=SIGMA_X)) == (
        "FourLinkBox: 1 value can be fitted, must be at least 3, as many as parameters are free"
    )


SIGMA_X = {"point[4].x": 1e-3}

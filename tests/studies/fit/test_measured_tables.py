"""Measurements of one run, from its tables."""

# Tests: studies/fit/sigma.py

import numpy as np
import pytest

from chain_impact import fit, load_scene, simulate
from chain_impact.studies.fit.measured_tables import read_measurements
from chain_impact.studies.fit.measurements import MEASURED_OF_IMPACT
from chain_impact.studies.fit.sigma import standard_deviation
from tests.helpers.scenes.bodies import body, cart
from tests.helpers.scenes.stops import knee_scene
from tests.helpers.tools.refusal import refusal

SCENE = load_scene("four_link_box")
MOTION = {"time": [0.1, 0.2, 0.3], "point[4].x": [1.0, None, 3.0], "point[4].y": [4.0, 5.0, None]}


def read(tables, sigma=None, columns=None):
    return read_measurements(tables, SCENE, sigma or {}, columns)


def test_samples_with_gaps():
    measurements = read(MOTION)
    assert measurements.outputs == ("point[4].x", "point[4].y")
    assert measurements.times.tolist() == [0.1, 0.2, 0.3]
    assert list(
        zip(
            measurements.quantity,
            measurements.value,
            measurements.value_times,
            measurements.row,
            measurements.column,
            strict=True,
        )
    ) == [
        ("point[4].x", 1.0, 0.1, 0, 0),
        ("point[4].y", 4.0, 0.1, 0, 1),
        ("point[4].y", 5.0, 0.2, 1, 1),
        ("point[4].x", 3.0, 0.3, 2, 0),
    ]
    assert np.isnan(measurements.sigma).all()
    assert not measurements.of_impact.any()


def test_rows_of_impacts_beside_samples():
    table = {
        "time": [0.1, None, 0.2, None],
        "point[4].x": [1.0, None, 2.0, None],
        "impact": [None, 2, None, 3],
        "wall": [None, "y_min", None, None],
        "onset": [None, 0.15, None, None],
        "peak_force": [None, 100.0, None, 200.0],
    }
    measurements = read(table)
    assert measurements.quantity == ("point[4].x", "onset", "peak_force", "point[4].x", "peak_force")
    assert measurements.of_impact.tolist() == [False, True, True, False, True]
    np.testing.assert_array_equal(measurements.value_times, [0.1, 0.15, 0.15, 0.2, np.nan])
    second, third = measurements.impacts
    assert (second.number, second.wall, second.is_alike) == (2, SCENE.wall_names.index("y_min"), False)
    assert (third.number, third.wall) == (3, None)
    assert [MEASURED_OF_IMPACT[measurements.column[k]] for k in (1, 2)] == ["onset", "peak_force"]


def test_tables_of_one_run():
    measurements = read([MOTION, {"time": [0.15], "link[1].angle": [0.5]}])
    assert measurements.times.tolist() == [0.1, 0.15, 0.2, 0.3]
    assert measurements.value_times[-1] == 0.15
    assert measurements.row[-1] == 1


def test_an_impact_is_found_by_its_number_and_place():
    from chain_impact.recording.impacts import IMPACT_DTYPE

    impacts = np.zeros(4, IMPACT_DTYPE)
    impacts["point"], impacts["wall"] = [0, 4, 0, 4], [2, 2, 3, 2]

    def rows(**columns):
        return [
            impact.find(impacts)
            for impact in read({**columns, "onset": [0.1] * len(columns["wall"])}).impacts
        ]

    assert rows(impact=[1, 3, 5], wall=[None] * 3) == [0, 2, None]
    assert rows(impact=[2, 3], wall=["y_min", "y_min"]) == [1, None]
    assert rows(wall=["y_min", "y_max", "y_min", "y_min", "y_min"]) == [0, 2, 1, 3, None]
    assert rows(point=[4, 4, 0], wall=[None] * 3) == [1, 3, 0]


def test_the_table_of_impacts_of_a_result_is_one():
    from chain_impact import simulate

    table = simulate(SCENE, stop_time=0.6).impact_table().reset_index()
    measurements = read(
        {name: table[name].tolist() for name in table.columns}, columns=["peak_force", "onset"]
    )
    assert set(measurements.quantity) == {"peak_force", "onset"}
    assert len(measurements.impacts) == len(table) == 2
    assert "joint" in table
    all_measurements = read({name: table[name].tolist() for name in table.columns})
    assert {"impulse", "onset", "end"} <= {*all_measurements.quantity}
    assert {"x", "y"} & {*all_measurements.quantity} == set()
    assert "duration" not in all_measurements.quantity  # onset and end determine it
    assert "joint_force" not in all_measurements.quantity  # unknown without loads


def test_a_contact_that_ends_late_is_simulated_to_its_measured_end():
    ball = load_scene("bouncing_ball").with_values(
        {
            "contact.model": "zhang_sharf",
            "contact.stiffness": 1000.0,
            "contact.exponent": 1.0,
            "initial.y": 0.05,
            "simulation.stop_time": 3.0,
        }
    )
    first = simulate(ball).impacts[0]
    onset, end = float(first["onset"]), float(first["end"])
    assert end > 1.5 * onset
    table = {"onset": [onset], "end": [end]}
    data = read_measurements(table, ball, {"onset": 1e-4, "end": 1e-4})
    assert data.value_times.tolist() == [onset, end]
    assert data.end(3.0) > end
    fit_result = fit(
        ball.with_values({"contact.stiffness": 1300.0}),
        table,
        ["contact.stiffness"],
        sigma=dict.fromkeys(table, 1e-4),
    )
    assert fit_result.values["contact.stiffness"] == pytest.approx(1000.0, rel=1e-6)
    assert fit_result.used.all()


def test_a_force_in_a_joint_needs_a_scene_with_loads():
    assert refusal(read, {"impact": [1], "joint_force": [100.0]}) == (
        "data: row 0: joint_force = 100 needs the forces in joints: "
        "FourLinkBox: outputs.loads = false must be true"
    )


def test_standard_deviations_are_columns_percentages_or_numbers():
    table = MOTION | {"sigma(point[4].x)": [0.1, None, None]}
    measurements = read(table, {"point[4].x": "10%", "point[4].y": 2e-3})
    assert measurements.sigma.tolist() == pytest.approx([0.1, 2e-3, 2e-3, 0.3])
    assert standard_deviation("x", "2%", -50.0) == 1.0
    for value in ("0", "-1%", "much", "inf", -2.0, "nan", "nan%"):
        assert "must be a number > 0, or percent of each value: 2%" in refusal(
            standard_deviation, "x", value, 1.0
        )
    assert refusal(read, {"time": [0.1], "point[4].x": [0.0]}, {"point[4].x": "2%"}) == (
        "data: row 0: sigma(point[4].x) = 0 must be > 0"
    )


def test_columns_of_measurements_are_chosen_by_pattern():
    table = MOTION | {"speed of the camera": [1, 2, 3]}
    assert read(table, columns=["point[4].*"]).outputs == ("point[4].x", "point[4].y")
    measurements = read([table, {"impact": [1], "onset": [0.1]}], columns=["onset", "point[4].y"])
    assert set(measurements.quantity) == {"onset", "point[4].y"}
    assert refusal(read, table, None, ["camera"]).startswith(
        "data: camera is not a column; there are point[4].x"
    )


def test_wrong_measurements_are_refused():
    def message_for(**changes):
        return refusal(read, {name: cells for name, cells in (MOTION | changes).items() if cells})

    message = message_for(**{"point[4].z": [1, 2, 3]})
    assert message.startswith(
        "data: column point[4].z is not an output that changes over time, no input, and no quantity of an"
    )
    assert "; the nearest is point[4]." in message
    assert "impacts have onset, end" in message_for(camera=[1, 2, 3])
    assert message_for(camera=[1, 2, 3]).endswith(": --columns point[4].x,point[4].y")
    assert message_for(time=[]).startswith(
        "data: the column time is missing; it says to which of the outputs"
    )
    assert message_for(onset=[1, 2, 3]).startswith("data: the column impact or point or wall is missing")
    assert message_for(time=[0.1, 0.1, 0.2]) == (
        "data: row 1: time = 0.1 must be a time >= 0 [s] and > 0.1, the value of the row before"
    )
    assert message_for(time=[None, 0.1, 0.2]) == "data: row 0: time = nan must be a time >= 0 [s]"
    assert message_for(**{"sigma(point[4].z)": [1, 2, 3]}).endswith("has no column point[4].z beside it")
    assert refusal(read, [MOTION, MOTION]) == "data: column point[4].x is also in data"
    assert refusal(read, {"time": [0.1], "point[4].x": [None]}) == (
        "data: no value was measured: all cells are empty"
    )
    assert refusal(read, {"time": [0.1]}).startswith(
        "data: it has no column with values, of an output such as"
    )


def test_a_list_of_impacts_with_times_proposes_the_name_onset():
    place = {"wall": ["y_min"], "point": [2]}
    for name, table in {
        "time": place | {"time": [0.5], "peak_force": [100.0]},
        "Time (s)": place | {"Time (s)": [0.5]},
        "t": {"t": [0.5], "peak_force": [100.0]},
    }.items():
        message = refusal(read, table)
        assert message.endswith(
            f"; call the column {name} onset, if it has the onsets of impacts in seconds"
        ), message
        assert len(read({"onset" if key == name else key: cells for key, cells in (place | table).items()}))
    assert refusal(read, place | {"time": [0.5]}).endswith(
        "; call the column time onset" + message[message.index(", if") :]
    )
    mixed = {"time": [0.1, 0.5], "point[4].x": [1.0, None], "wall": [None, "y_min"], "end": [None, 0.6]}
    assert "row 1: time = 0.5 has no meaning for an impact; call" in refusal(read, mixed)
    assert len(read(mixed | {"onset": [None, 0.5]})) == 3


def test_rows_without_time_and_number_are_the_impacts_in_order():
    """A drop test needs no more than the onsets."""
    measurements = read({"onset": [0.1, 0.2, 0.4]})
    places = [(row.number, row.point, row.wall) for row in measurements.impacts]
    assert places == [(number, None, None) for number in (1, 2, 3)]
    assert read({"onset": [0.1, 0.2, 0.4], "impact": [None, None, None]}).impacts == measurements.impacts


@pytest.mark.parametrize(
    ("column", "cell", "requirement"),
    [
        ("impact", 0, "a whole number >= 1"),
        ("impact", 1.5, "a whole number >= 1"),
        ("point", 7, "one of the points 0, 1, 2, 3, 4"),
        ("wall", "floor", "a wall of the scene: x_min, x_max, y_min, y_max"),
    ],
)
def test_refusals_of_an_impact(column, cell, requirement):
    message = refusal(read, {column: [cell], "onset": [0.1]})
    assert message == f"data: row 0: {column} = {cell!r} must be {requirement}"


def test_impacts_at_stops_are_named_by_joint_and_stop():
    scene = knee_scene()
    table = {"point": [2, 2], "wall": ["joint_min", "x_max"], "onset": [0.4, 1.7]}
    measurements = read_measurements(table, scene, {}, None)
    assert [row.wall for row in measurements.impacts] == [4, 1]
    message = refusal(read_measurements, table | {"wall": ["joint_min", "y_min"]}, scene, {}, None)
    assert "must be a wall of the scene: x_max, joint_min, joint_max" in message


def test_impacts_of_points_of_links_and_at_stops_of_a_slider_are_named():
    table = {"point": ["heel", 4], "wall": ["y_min", "y_min"], "onset": [0.3, 0.4]}
    measurements = read_measurements(table, body(), {}, None)
    assert [row.point for row in measurements.impacts] == [3, 4]
    message = refusal(read_measurements, table | {"point": ["nose", 1]}, body(), {}, None)
    assert "must be one of the points 2, 3, 4, 5, 6, 7, 8, heel, toe" in message
    measurements = read_measurements({"wall": ["slider_max"], "onset": [0.3]}, cart(), {}, None)
    assert measurements.impacts[0].wall == cart().wall_names.index("slider_max")


@pytest.mark.parametrize("name", ["t", "Time", "time [ms]", "t_s", "tme"])
def test_without_a_column_time_the_likely_one_is_named(tmp_path, name):
    path = tmp_path / "motion.csv"
    path.write_text(f"{name},point[1].x\n0,0.86\n0.01,0.87\n", encoding="utf-8")
    message = refusal(fit, "rod_drop", path, ["contact.stiffness"])
    assert f"{path}: the column time is missing; the column {name} may be meant" in message

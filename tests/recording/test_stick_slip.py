"""Phases of dry friction: from a log of changes, from outputs, in results and on the screen."""

# Tests: recording/interactions.py

import math
from dataclasses import replace

import numpy as np

from chain_impact import Chain, simulate
from chain_impact.cli.screen import stick_slip_parts
from chain_impact.recording.csv_file import read_csv
from chain_impact.recording.recording import Recording
from chain_impact.recording.stick_slip import (
    CHANGE_DTYPE,
    STICK_SLIP_DTYPE,
    phase_cells,
    phases_from,
    phases_of,
)
from tests.helpers.scenes.friction import pendulum, sled, thrown

WALLS = ("x_min", "x_max", "y_min", "y_max", "slope")


def changes(*rows):
    return np.array([*rows], CHANGE_DTYPE)


def test_a_phase_lasts_until_the_next_change_of_its_own_contact():
    log = changes((0.1, 2, 4, 1), (0.15, 0, 4, -1), (0.2, 2, 4, 0), (0.4, 2, 4, 2), (0.5, 2, 4, 0))
    phases = phases_of(log)
    assert phases["point"].tolist() == [2, 0, 2, 2]
    assert phases["start"].tolist() == [0.1, 0.15, 0.2, 0.5]
    np.testing.assert_array_equal(phases["end"], [0.2, np.nan, 0.4, np.nan])
    assert phases["mode"].tolist() == [1, -1, 0, 0]
    assert set(phases["wall"]) == {4}


def test_phases_of_no_length_and_of_no_change_are_none():
    log = changes((0.1, 1, -1, 1), (0.1, 1, -1, 0), (0.3, 1, -1, 0), (0.4, 1, -1, 2))
    assert phases_of(log).tolist() == [(1, -1, 0.1, 0.4, 0)]
    assert len(phases_of(changes())) == 0


def test_the_words_of_a_phase():
    rows = np.array([(2, 4, 0.1, 0.25, -1), (3, -1, 0.5, np.nan, 0)], STICK_SLIP_DTYPE)
    assert phase_cells(rows[0], WALLS, {2: "heel"}) == (
        "0.100000",
        "0.250000",
        "point 2 (heel) at slope",
        "slip -",
    )
    assert phase_cells(rows[1], WALLS, {}) == ("0.500000", "", "joint 3", "stick")


def test_contacts_with_friction_have_phases_from_onset_to_end():
    result = simulate("sliding_rod", output_step=math.inf)
    for impact in result.impacts:
        phases = result.stick_slip[
            (result.stick_slip["point"] == impact["point"]) & (result.stick_slip["wall"] == impact["wall"])
        ]
        of_impact = phases[phases["start"] >= impact["onset"]]
        assert of_impact["start"][0] == impact["onset"]
        if np.isnan(impact["end"]):
            assert np.isnan(phases["end"][-1])
        else:
            assert impact["end"] in phases["end"]


def test_a_log_that_fills_is_collected_in_time():
    """Within a step, modes change more often than the log has room for."""
    result = simulate(thrown(), output_step=math.inf)
    phases = result.stick_slip[result.stick_slip["wall"] == -1]
    assert len(result.stick_slip) > 30
    assert phases["start"][0] == 0.0
    np.testing.assert_array_equal(phases["start"][1:], phases["end"][:-1])
    rows = simulate(thrown(), output_step=1e-3).stick_slip
    assert rows.tobytes() == result.stick_slip.tobytes()


def test_a_result_has_them_as_a_table_and_in_words():
    result = simulate(pendulum(), output_step=math.inf)
    table = result.stick_slip_table()
    assert list(table.columns) == list(STICK_SLIP_DTYPE.names)
    assert table.index.tolist() == list(range(1, len(result.stick_slip) + 1))
    assert table["mode"].tolist()[:2] == ["slip -", "slip +"]
    assert set(table["wall"]) == {""}
    assert table.attrs["units"] == {"start": "s", "end": "s"}
    sticking = sum(table["mode"] == "stick")
    assert f"friction {sticking} phases of sticking, {len(table) - sticking} of sliding" in repr(result)
    last = result.stick_slip[-1]
    assert f"sticks at the end: joint 2 since {result.stick_slip[-3]['start']:.6f} s" in repr(result)
    assert f"joint 1 since {last['start']:.6f} s" in repr(result)
    assert "sticks at the end" in result._repr_html_()


def test_a_result_without_friction_has_none_and_says_nothing():
    result = simulate("rod_drop", 0.1)
    assert (len(result.stick_slip), result.stick_slip.dtype) == (0, STICK_SLIP_DTYPE)
    assert "friction" not in repr(result)
    assert list(stick_slip_parts(result)) == []


def test_the_phases_alternate_with_the_outputs():
    result = simulate(pendulum(), output_step=0.001)
    for joint in (1, 2):
        phases = result.stick_slip[result.stick_slip["point"] == joint]
        np.testing.assert_array_equal(phases["start"][1:], phases["end"][:-1])
        for phase in phases:
            is_inside = (result.time > phase["start"]) & ~(result.time >= phase["end"])
            assert (result[f"joint[{joint}].sticking"][is_inside] == (phase["mode"] == 0)).all()
            moment = result[f"joint[{joint}].friction_moment"][is_inside]
            if phase["mode"]:
                assert (np.sign(moment) == -phase["mode"]).all()


def test_phases_from_outputs_of_an_fmu_are_those_of_its_walls():
    time = np.arange(6.0)
    columns = {
        **{f"contact[1].{wall}.force": np.ones(6) for wall in ("slope", "elsewhere")},
        "contact[1].slope.friction_force": np.array([0.0, -2.0, -2.0, 1.0, 0.0, 0.0]),
        "contact[1].slope.sticking": np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0]),
        "contact[1].elsewhere.friction_force": np.ones(6),
        "contact[1].elsewhere.sticking": np.ones(6),
        "joint[2].sticking": np.ones(6),
    }
    phases = phases_from(time, Recording("Test", time, columns).interactions, WALLS)
    assert phases.tolist() == [(1, 4, 1.0, 2.0, 1), (1, 4, 2.0, 4.0, 0)]


def test_a_table_of_outputs_has_them_again(tmp_path):
    result = simulate(sled(), output_step=0.01)
    recording = result
    recording.save_csv(tmp_path / "sled.csv")
    read_back = read_csv(tmp_path / "sled.csv", sled())
    sticking = read_back.stick_slip[read_back.stick_slip["mode"] == 0]
    assert sticking["point"].tolist() == [0, 1]
    starts = result.stick_slip[result.stick_slip["mode"] == 0]["start"]
    np.testing.assert_allclose(sticking["start"], starts, atol=0.01)


def test_the_screen_shows_the_first_ones():
    result = simulate(pendulum(), output_step=0.5)
    table, mode = stick_slip_parts(result)
    assert mode.startswith("mode     slip + along +x")
    assert (table.row_count, [column.header for column in table.columns][2]) == (
        len(result.stick_slip),
        "dry friction",
    )
    count = 4 * len(result.stick_slip)
    vars(result)["stick_slip"] = np.concatenate([result.stick_slip] * 4)
    table, more_text, _ = stick_slip_parts(result)
    assert table.row_count == 8
    rest = vars(result)["stick_slip"][8:]
    assert more_text.startswith(
        f"and {count - 8} more phases of dry friction, {(rest['mode'] == 0).sum()} of sticking"
    )
    assert f"{rest['start'][-1]:.6f} s" in more_text
    assert "Result.stick_slip" in more_text


def test_the_screen_points_to_a_result_only_where_there_is_one(tmp_path):
    simulate(pendulum(), output_step=0.01).save_csv(tmp_path / "pendulum.csv")
    recording = read_csv(tmp_path / "pendulum.csv", pendulum())
    longer_recording = replace(recording, stick_slip=np.concatenate([recording.stick_slip] * 4))
    more_line = next(part for part in stick_slip_parts(longer_recording) if "more phase" in str(part))
    assert "Result" not in str(more_line)


# --- a chain that is stepped by hand -----------------------------------------------------------------------


def test_a_chain_has_the_phases_of_a_simulation_in_any_steps():
    result, chain = simulate(pendulum(), 1.5), Chain(pendulum())
    assert chain.stick_slip["start"].tolist() == [0.0, 0.0]
    for k in range(1, 301):
        chain.step_to(0.005 * k)
    assert chain.stick_slip.tobytes() == result.stick_slip.tobytes()


def test_a_restored_chain_has_the_phases_so_far():
    chain = Chain(pendulum())
    chain.step_to(0.9)
    state, phases = chain.save(), chain.stick_slip
    chain.step_to(2.0)
    later_phases = chain.stick_slip
    assert len(later_phases) > len(phases) > 2
    chain.restore(state)
    assert chain.stick_slip.tobytes() == phases.tobytes()
    chain.step_to(2.0)
    assert chain.stick_slip.tobytes() == later_phases.tobytes()
    chain.reset()
    assert len(chain.stick_slip) == 2

"""The panel of the impacts over time."""

# Tests: pictures/over_time/time_axis.py

import re

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.colours import GREY
from chain_impact.pictures.over_time.energies import (
    ENERGIES,
)
from chain_impact.pictures.over_time.impacts import (
    LANE,
    MOST_OWN_MARKS,
    POINT_MARKS,
    STOP_MARKS,
    common_marks,
    marks_of,
    point_groups,
)
from chain_impact.pictures.overview import draw_overview
from chain_impact.pictures.texts.headline import impulses_of_hits
from chain_impact.pictures.texts.impact_numbers import NUMBER_SIGN
from chain_impact.recording.contact_times import impacts_at_peaks
from tests.pictures.pictures import (
    MODELS,
    impact_row,
    impacts_of,
    page_of,
    page_of_width,
    panel_of,
    recorded,
    swing,
    texts,
)


def numbers(axes):
    """Return the numbers of impacts in the axes, without the names of contacts at their left."""
    labels = [text.get_text() for text in axes.texts if text.get_gid() != LANE]
    assert all(text.startswith(NUMBER_SIGN) for text in labels)
    return [text.removeprefix(NUMBER_SIGN) for text in labels]


def strengths(recording):
    """Return the peak force of each impact; under a rigid law its impulse, 0 for a contact without an end.

    If all are 0, return the impulses of hits under a rigid law, else the impact speeds. All impacts are at
    walls, or all at stops.
    """
    impacts, law = recording.impacts, recording.parameters.get("contact.model")
    if recording.is_at_joint_stop.all():
        law = recording.stop_law or law
    impulses = np.where(np.isnan(impacts["end"]), 0.0, impacts["impulse"])
    if law == "newton_impact" and not impulses.any():
        return impulses_of_hits(recording)
    values = impulses if law == "newton_impact" else impacts["peak_force"]
    return values if values.any() else impacts["impact_speed"]


@pytest.mark.full("more cases", but="arm_at_stop")
@pytest.mark.parametrize("model", MODELS)
def test_every_impact_is_in_the_picture(model):
    recording = recorded(model)
    panels = {axes.get_label(): axes for axes in page_of(recording)[1:]}
    energy, speeds = panels["energy"], impacts_of(recording)
    lines = [path for item in speeds.collections for path in item.get_segments()]
    stems = [line for line in lines if np.ptp(line[:, 0]) == 0.0]
    expected = sorted(zip(impacts_at_peaks(recording)["onset"], strengths(recording), strict=True))
    assert sorted(tuple(stem[1]) for stem in stems) == expected
    assert {stem[0, 1] for stem in stems} == {0.0}
    (lines,) = (item for item in energy.collections if isinstance(item, LineCollection))
    assert [path[0, 0] for path in lines.get_segments()] == recording.impacts["onset"].tolist()


@pytest.mark.parametrize(("model", "is_late"), [("sliding_rod", True), ("rod_drop", False)])
def test_the_legend_says_that_impacts_stand_at_their_peaks(model, is_late):
    recording = recorded(model)
    late = impacts_at_peaks(recording)["onset"] - recording.impacts["onset"]
    assert (late.max() > 0.1) == is_late
    texts = [text.get_text() for text in recording.plot(panels="impacts").axes[0].get_legend().get_texts()]
    assert ("impact, at its peak force" in texts) == is_late
    page = recording.plot(panels=["energy", "impacts"], size=(84 / 25.4, 4.0))
    narrow_texts = [text.get_text() for text in panel_of(page, "impacts").get_legend().get_texts()]
    assert ("impact, at its peak force" in narrow_texts) == is_late


@pytest.mark.full("more cases", but=["arm_at_stop", "bouncing_ball"])
@pytest.mark.parametrize("model", MODELS)
def test_a_number_stands_near_its_impact_and_counts_in_time(model):
    recording = recorded(model)
    speeds = impacts_of(recording)
    for text in [text for text in speeds.texts if text.get_gid() != LANE]:
        row = int(re.split("[#,–:]", text.get_text())[1]) - 1
        assert text.xy == (impacts_at_peaks(recording)["onset"][row], strengths(recording)[row])
        box, place = text.get_window_extent(), speeds.transData.transform(text.xy)
        assert np.hypot(*(np.clip(place, box.min, box.max) - place)) < 20.0  # pixels


@pytest.mark.full("more cases", but=["thrown_brick-190", "four_link_box-84"])
@pytest.mark.parametrize("width", [84, 120, 190])
@pytest.mark.parametrize("model", ["thrown_brick", "four_link_box", "hopper", "rod_drop", "falling_arm"])
def test_no_mark_of_another_impact_is_nearer_to_a_number_than_its_own(model, width):
    recording = recorded(model)
    axes = panel_of(page_of_width(model, width), "impacts")
    times, heights = marks_of(recording)
    marks = axes.transData.transform(np.stack([times, heights], axis=-1))
    shared = common_marks(recording, times, heights).values()
    labels = [text for text in axes.texts if text.get_gid() != LANE]
    assert labels
    for text in labels:
        box, row = text.get_window_extent(), int(re.split("[#,–: ]", text.get_text())[1]) - 1
        own_rows = next(rows for rows in shared if row in rows)
        middle = 0.5 * (box.min + box.max)
        for low, high in ((middle, middle), (box.min, box.max)):
            gaps = np.hypot(*(marks - np.clip(marks, low, high)).T)
            assert gaps[own_rows].min() < gaps.min() + 0.1, text.get_text()  # pixels


@pytest.mark.full("takes long")
def test_impacts_of_two_points_with_a_common_mark_share_a_number():
    impacts = [
        impact_row(1.0, 0, "y_max", 2.0),
        impact_row(1.0, 1, "y_max", 2.0),
        impact_row(1.5, 1, "y_max", 1.0),
    ]
    *_, speeds = page_of(swing(impacts, {"y_max": 1.0}))
    assert sorted(numbers(speeds)) == ["1, 2", "3"]
    places = {mark["marker"]: set() for mark in POINT_MARKS[:2]}
    for line in speeds.lines:
        if line.get_marker() in places and 1.0 in line.get_xdata():
            at = line.get_xydata()[list(line.get_xdata()).index(1.0)]
            places[line.get_marker()].add(round(float(line.get_transform().transform(at)[0])))
    lower_places, upper_places = places.values()
    (upper_place,) = upper_places
    assert upper_place in lower_places  # the mark above covers this one
    # points to a copy at the left
    assert 2.0 < (upper_place - min(lower_places)) * 72.0 / speeds.figure.dpi < 5.0


def test_the_hardest_impacts_are_numbered_first():
    impacts = [impact_row(1.0 + 1e-4 * k, 1, "y_max", speed) for k, speed in enumerate((1.0, 1.01, 5.0))]
    *_, speeds = page_of(swing(impacts, {"y_max": 1.0}))
    assert numbers(speeds)[0] == "3"


def test_of_many_impacts_the_largest_and_the_last_are_numbered():
    impacts = [impact_row(1.0 + 1e-3 * k, 1, "y_max", 5.0 - 0.04 * k) for k in range(100)]
    impacts[50] = impact_row(1.0505, 1, "y_max", 3.0)  # the distances in time are not equal
    *_, speeds = page_of(swing(impacts, {"y_max": 1.0}))
    *first_numbers, last_number = map(int, numbers(speeds))
    assert first_numbers == [*range(1, len(first_numbers) + 1)]
    assert last_number == 100


@pytest.mark.full("takes long")
def test_every_kth_of_many_evenly_spaced_impacts_is_numbered():
    axes = panel_of(page_of_width("bouncing_table", 84), "impacts")
    assert numbers(axes) == [str(number) for number in range(5, 31, 5)]


def test_measured_quantities_name_their_units():
    _, motion, clock, energy, force = page_of(recorded("pinned_arm"))
    names = [motion.get_xlabel(), motion.get_ylabel(), clock.get_xlabel(), energy.get_ylabel()]
    assert [re.findall(r"\[(.*)\]", name) for name in names] == [["m"], ["m"], ["s"], ["J"]]
    assert impacts_of(recorded("pinned_arm")).get_ylabel().replace("\n", " ") == "peak force [kN]"
    assert (force.get_ylabel(), force.get_xlabel().partition(";")[0][-4:]) == ("force [kN]", "[ms]")


def test_points_have_marks_of_their_own_without_the_colours_of_energies():
    energies = {to_hex(colour) for name, colour in ENERGIES.items()}
    for marks in (POINT_MARKS, STOP_MARKS):
        assert len({mark["marker"] for mark in marks}) == len(marks) >= MOST_OWN_MARKS
        assert not energies & {to_hex(mark["color"]) for mark in marks}
    forms = [(mark["marker"], mark.get("markerfacecolor")) for mark in (*POINT_MARKS, *STOP_MARKS)]
    assert len({*forms}) == len(forms)  # points and joints differ, too
    recording = recorded("thrown_brick")
    (speeds,) = recording.plot(panels="impacts").axes
    markers = {line.get_label(): line.get_marker() for line in speeds.lines if line.get_label()[0] != "_"}
    assert len({*markers.values()}) == len(markers) == len({row["point"] for row in recording.impacts})


def test_many_points_are_not_told_apart():
    hits = [impact_row(0.1 * k, k, "y_min", float(k)) for k in range(15)]
    many, less = (swing(impacts, {"y_min": 0.0}) for impacts in (hits, hits[:3]))
    groups = point_groups(many, marks_of(many)[1])
    names = [name for name, _, _ in groups]
    assert names == ["others", *(f"point {k}" for k in range(15 - MOST_OWN_MARKS + 1, 15))]
    assert groups[0][1]["color"] == GREY
    assert len({(mark["marker"], mark["color"]) for _, mark, _ in groups}) == len(groups)
    assert sorted(np.concatenate([rows for _, _, rows in groups])) == list(range(15))
    few_groups = point_groups(less, marks_of(less)[1])
    assert [name for name, _, _ in few_groups] == ["point 0", "point 1", "point 2"]


def test_without_impacts_the_panel_says_so():
    page = Figure(layout="constrained")
    draw_overview(page, swing(), ["impacts"])
    assert texts(page.axes[-1]) == ["no impact"]


@pytest.mark.full("takes long")
def test_a_contact_that_lasts_has_a_band_to_its_end():
    recording = recorded("sliding_rod")
    (of_friction,) = (panel for panel in page_of(recording)[0].axes if panel.get_label() == "impacts")
    assert not [text for text in of_friction.texts if text.get_gid() == LANE], "the panel below has the rows"
    (speeds,) = recording.plot(panels=["impacts"]).axes
    bands = [line for lines in speeds.collections for line in lines.get_segments() if np.ptp(line[:, 1]) == 0]
    bands = {(round(float(x0), 9), round(float(x1), 9)) for (x0, _), (x1, _) in bands}
    expected = {
        (round(float(row["onset"]), 9), round(float(np.nan_to_num(row["end"], nan=recording.time[-1])), 9))
        for row in recording.impacts
    }
    long = {(onset, end) for onset, end in expected if end - onset > 0.02 * recording.time[-1]}
    assert long
    assert long <= bands <= expected
    assert "in contact" in [text.get_text() for text in speeds.get_legend().get_texts()]
    bars = [lines for lines in speeds.collections if lines.get_alpha()]
    rows = {round(float(lines.get_transform().transform((0.0, 0.0))[1]), 3) for lines in bars}
    assert len(rows) == len({row["point"] for row in recording.impacts})  # no two points share a row
    names = [text for text in speeds.texts if text.get_gid() == LANE]
    assert sorted(text.get_text() for text in names) == ["point 0", "point 1"]
    assert all(text.get_window_extent().x1 < speeds.bbox.x0 for text in names)
    assert max(rows) < speeds.transData.transform((0.0, recording.impacts["impact_speed"].max()))[1]


def test_few_impacts_keep_their_numbers_if_one_has_no_room():
    """The largest impacts alone would leave a far impact with much room without its number."""
    times, speeds = [0.2, 1.0, 1.5, 1.505, 1.51], [1.0, 2.0, 3.0, 1.5, 1.2]
    hits = [impact_row(t, 1, "y_min", v) for t, v in zip(times, speeds, strict=True)]
    numbers = texts(impacts_of(swing(hits, {"y_min": 0.0})))
    assert {"#1", "#2"} <= {*numbers}


@pytest.mark.full("takes long")
@pytest.mark.parametrize("width", [84, 190])
def test_the_impacts_with_numbers_are_the_largest_ones(width):
    axes = panel_of(page_of_width("bouncing_ball", width), "impacts")
    numbers = [int(re.match(r"#(\d+)", text)[1]) for text in texts(axes) if text.startswith(NUMBER_SIGN)]
    assert len(numbers) >= 2
    assert sorted(numbers) == [*range(1, len(numbers) + 1)], "the impulses fall, and no number is left out"

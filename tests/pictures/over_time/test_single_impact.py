"""A single impact is drawn as its force over its own time."""

import numpy as np
import pytest

from chain_impact import load_scene, record_slowly
from chain_impact.pictures.over_time.single_impact import course_of_hardest, is_alone
from tests.pictures.pictures import crowd, impact_row, page_of_width, panel_of, recorded, swing


def test_a_single_impact_has_its_force_over_its_time():
    recording = recorded("pinned_arm")
    (impact,) = recording.impacts
    panels = {axes.get_label(): axes for axes in recording.plot().axes}
    assert "impacts" not in panels
    times, force = panels["impact"].lines[0].get_data()
    assert 1e3 * force.max() == pytest.approx(impact["peak_force"], rel=1e-3)  # the axis has kN and ms
    assert times[-1] == pytest.approx(1e3 * impact["duration"])
    assert (
        f"lasts {1e3 * impact['duration']:.2f} ms" in panels["impact"].get_legend().get_texts()[0].get_text()
    )
    assert panels["impact"].get_xlabel() == "time after the onset [ms]"
    assert [text.get_text() for text in panels["impact"].texts] == ["1.02 kN"]
    assert panels["energy"].get_xlim() == panels["time"].get_xlim() != panels["impact"].get_xlim()


@pytest.mark.full("takes long")
def test_the_peak_of_a_low_panel_is_told_above_the_area_below_the_curve():
    page = page_of_width("stick_slip_belt", 84)
    axes = panel_of(page, "impact")
    (label,), curve = axes.texts, axes.lines[0]
    page.draw_without_rendering()
    top = curve.get_transform().transform(curve.get_xydata())[:, 1].max()
    assert top < label.get_window_extent().y0
    assert label.get_window_extent().y1 <= axes.get_window_extent().y1


def test_the_panels_that_are_asked_for_are_drawn():
    assert [axes.get_label() for axes in recorded("pinned_arm").plot(panels="impacts").axes] == ["impacts"]
    panels = {axes.get_label() for axes in recorded("four_link_box").plot(panels=["impact", "energy"]).axes}
    assert panels == {"impact", "energy"}
    (panel,) = recorded("pinned_arm").plot(panels="impact").axes
    assert panel.lines


def test_rows_replace_a_run_that_cannot_be_repeated():
    slow = record_slowly(load_scene("pinned_arm"))
    rows = slow.with_rows(np.arange(len(slow.time)))  # stored rows cannot repeat the run
    row, time, force = course_of_hardest(rows)
    assert (row, len(time) >= 20) == (0, True)
    assert force.max() == pytest.approx(rows.impacts["peak_force"][0], rel=1e-2)
    sparse = slow.with_rows(np.arange(0, len(slow.time), 50))
    assert not is_alone(sparse)


def test_several_impacts_are_drawn_over_the_time_of_the_run():
    assert not is_alone(recorded("four_link_box"))
    assert not is_alone(crowd())
    assert not is_alone(swing([impact_row(1.0, 1, "y_min", 1.0)], {"y_min": 0.0}))

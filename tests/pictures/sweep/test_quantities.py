"""The results that the picture of a sweep has a panel for, and their units."""

import numpy as np
import pytest

from chain_impact.pictures.sweep.quantities import MAIN_QUANTITIES, shown_quantities_of
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep.sweep import sweep
from tests.helpers.scenes.stops import knee_scene
from tests.pictures.sweep.drawn_sweeps import SCENE, labels_of, sweep_page


@pytest.mark.full("takes long")
def test_a_scene_with_stops_has_panels_for_them():
    outputs = ["point[2].x", "point[2].y", "joint[2].stop_moment", "impact.last_time"]
    runs = sweep(knee_scene(), {"stop.restitution": "0.2,0.5,0.8"}, outputs=outputs)
    page, changing = sweep_page(runs), [name for name in outputs if np.ptp(runs[name]) > 0.0]
    labels = labels_of(page)
    # joint forces are unknown without loads
    assert (
        labels[:6]
        == [
            quantity.label
            for quantity in shown_quantities_of(runs).all_quantities
            if quantity.column != "joint_force"
        ][:6]
    )
    assert len(labels) == 6 + len(changing)
    assert all(name in page.texts[1].get_text() for name in {*outputs} - {*changing})
    assert "kN falls with stop restitution,\npeak moment of stops of" in page.get_suptitle()


def test_a_scene_without_walls_has_no_panels_for_them():
    scene = load_scene("kneed_leg").with_values({"outputs.loads": True})
    page = sweep_page(sweep(scene, {"stop.restitution": "0.0,0.5"}))
    assert labels_of(page) == ["impacts", "energy dissipated [mJ]"]
    assert "the same in all runs: largest rotation beyond a stop 0 rad, largest force" in page.texts[
        1
    ].get_text().replace("\n", " ")
    assert "peak force" not in page.get_suptitle()


def test_rigid_walls_have_no_panel_for_a_force():
    scene = load_scene("pinned_arm").with_values({"contact.model": "newton_impact"})
    page = sweep_page(sweep(scene, {"contact.restitution": "0.2,0.5"}))
    assert labels_of(page) == ["energy dissipated [J]"]


def test_stops_of_a_slider_have_panels_for_their_forces():
    scene = load_scene("cart_pole").with_values({"outputs.loads": True, "simulation.stop_time": 1.0})
    quantities = shown_quantities_of(sweep(scene, {"slider.max": "0.2,0.3"})).all_quantities
    assert {"peak_force", "joint_force"} <= {quantity.column for quantity in quantities}


def test_the_unit_of_a_force_suits_its_values():
    scene = load_scene("bouncing_ball").with_values({"contact.model": "flores"})
    runs = sweep(scene, {"contact.stiffness": "1e2:1e4:3:log"})
    largest_force = runs["peak_force"].max()
    (axes,) = runs.plot(panels="peak_force").axes
    assert 1.0 <= largest_force < 1000.0
    assert axes.get_title() == "peak force [N]"
    assert np.nanmax(axes.lines[0].get_ydata()) == largest_force


def test_outputs_that_were_asked_for_have_panels():
    runs = sweep(SCENE, {"contact.restitution": "0.2:0.8:4"}, outputs=["point[4].x", "impact.last_wall"])
    page = sweep_page(runs)
    assert labels_of(page)[4:] == ["point[4].x at the end [m]"]
    # the quantity has no panel
    assert "the same in all runs: impact.last_wall at the end 3" in page.texts[1].get_text()


def test_results_that_never_change_still_have_a_picture():
    scene = load_scene("elastic_ball").with_values({"simulation.stop_time": 0.1})  # before the first impact
    page = sweep_page(sweep(scene, {"contact.stiffness": "1e6:2e6:2"}))
    assert "impacts" in labels_of(page)
    assert not any("the same" in text.get_text() for text in page.texts)


def test_forces_of_a_sweep_have_one_unit():
    scene = load_scene("carried_arm").with_values({"simulation.stop_time": 0.6})
    runs = sweep(scene, {"contact.restitution": "0.1,0.9"}, outputs=["joint[1].force.y", "point[2].y"])
    units = {quantity.column: quantity.unit for quantity in shown_quantities_of(runs).all_quantities}
    forces = {unit for name, unit in units.items() if "force" in name}
    assert forces <= {"N", "kN"}
    assert len(forces) == 1
    assert units["point[2].y"] == "m"
    assert {"peak_force", "joint_force", "joint[1].force.y"} <= units.keys()


@pytest.mark.parametrize(("values", "note"), [([1.0, 1.05, 0.99], ", varies by 5.7 %"), ([1.0, 1.2], "")])
def test_values_that_hardly_differ_do_not_fill_the_axis(values, note):
    values, quantity = np.array(values), MAIN_QUANTITIES[-1]
    assert quantity.label_for(values) == f"energy dissipated [J]{note}"
    ends = quantity.ends_for(values)
    assert (ends is not None) == bool(note)
    if ends:
        assert ends[0] < values.min() < values.max() < ends[1]
        assert ends[1] - ends[0] > 1.5 * np.ptp(values)

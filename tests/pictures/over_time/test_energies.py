"""The panel of the energies over time."""

import itertools

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from chain_impact.pictures.over_time.energies import (
    ENERGIES,
    VISIBLE_ELASTIC,
    energy_curves,
    energy_look,
    without_gap,
)
from chain_impact.scene.files.models import model_names
from tests.pictures.pictures import page_of, page_of_width, panel_of, recorded, swing


@pytest.mark.full("takes long")
def test_energy_from_inputs_is_drawn_if_there_is_any():
    _, _, _, energy, _ = page_of(recorded("pinned_arm"))
    assert "supplied" not in energy.get_legend_handles_labels()[1]
    recording = swing()
    recording.columns["energy.supplied"] = np.ones(50)
    _, _, _, energy = page_of(recording)
    assert energy.get_legend_handles_labels()[1][-1] == "supplied"


@pytest.mark.full("more cases", but="elastic_floor")
@pytest.mark.parametrize("model", sorted(model_names(), key=lambda name: name != "elastic_floor"))
def test_the_drawn_energies_add_up_to_the_drawn_total(model):
    recording = recorded(model)
    drawn_curves = {look["label"].split()[0]: energy for energy, look in energy_curves(recording)}
    added = sum(drawn_curves.get(name, 0.0) for name in ("kinetic", "potential", "elastic"))
    height = np.ptp([0.0, *itertools.chain(*drawn_curves.values())])
    assert np.abs(added - drawn_curves["total"]).max() <= VISIBLE_ELASTIC * height


@pytest.mark.full("takes long")
def test_a_gap_of_energy_is_closed_and_reported():
    recording = recorded("controlled_arm")
    page = page_of(recording)[0]
    (energy,) = (panel for panel in page.axes if panel.get_label() == "energy")
    curves = {line.get_label(): line.get_ydata() for line in energy.get_lines()}
    energies = recording.detailed_energies[1]
    for name in ("potential", "total"):
        (label,) = (label for label in curves if label.startswith(name))
        added = float(label.removeprefix(name).removesuffix("J").replace(" ", "").replace("−", "-"))
        assert curves[label] == pytest.approx(energies[name] + added, abs=1e-9)
        assert 0.0 <= curves[label].min() < 0.1 * added
    assert curves["kinetic"] == pytest.approx(energies["kinetic"])


@pytest.mark.parametrize(
    ("lowest", "text"), [(-150.0, "+ 150 J"), (1234.0, "− 1200 J"), (-0.0217, "+ 0.022 J")]
)
def test_the_shift_of_an_energy_is_told_in_plain_digits(lowest, text):
    potential, kinetic = (
        lowest + np.linspace(0.0, 0.1 * abs(lowest), 5),
        np.linspace(0.0, 1e-2 * abs(lowest), 5),
    )
    shifted, offset = without_gap({"potential": potential, "kinetic": kinetic})
    assert shifted["potential"] == pytest.approx(potential + offset)
    assert energy_look("potential", offset)["label"] == f"potential {text}"


@pytest.mark.parametrize("model", ["thrown_brick", "four_link_box"])
def test_without_a_gap_the_energies_have_their_usual_zero(model):
    recording = recorded(model)
    assert without_gap(dict(recording.energies))[1] == 0.0


def test_no_two_energies_are_alike_without_colours():
    looks = [energy_look(name) for name in ENERGIES]
    assert len({(str(look["linestyle"]), look["linewidth"]) for look in looks}) == len(looks)


def test_a_supplied_energy_that_is_the_dissipated_one_has_no_curve():
    recording = swing()
    recording.columns["energy.dissipated"] = recording.columns["energy.supplied"] = np.linspace(0.0, 9.0, 50)
    labels = [look["label"] for _, look in energy_curves(recording)]
    assert "dissipated = supplied" in labels
    assert "supplied" not in labels


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("width", [84, 190])
def test_marks_at_impacts_have_an_entry_in_the_legend(width):
    """A narrow page has neither the marks nor the entry; its panel of impacts tells the times."""
    energy = panel_of(page_of_width("four_link_box", width), "energy")
    has_entry = "impacts" in [text.get_text() for text in energy.get_legend().get_texts()]
    has_marks = any(isinstance(item, LineCollection) for item in energy.collections)
    assert has_entry == has_marks == (width == 190)

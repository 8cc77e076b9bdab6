"""The headline of a picture summarises the run with numbers of the recording."""

# Tests: pictures/texts/conditions.py

import re
from dataclasses import replace

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.pictures.drawing.colours import INK, LOAD, PEAK_COLOUR
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.texts.conditions import conditions
from chain_impact.pictures.texts.headline import (
    energy_texts,
    has_contact,
    headline,
    impact_count_text,
    largest_peaks,
    load_text,
    marked_peaks,
)
from chain_impact.scene.scene import with_values
from tests.helpers.scenes.stops import knee_scene
from tests.pictures.pictures import MODELS, impact_row, recorded, swing


@pytest.mark.parametrize("model", MODELS)
def test_the_numbers_are_those_of_the_recording(model):
    recording = recorded(model)
    assert headline(recording).startswith(recording.name + ": ")
    message = ", ".join([impact_count_text(recording), *energy_texts(recording)])
    match = re.search(r"(\d+) impact", message)
    assert (int(match[1]) if match else 0) == recording.impact_count
    time_text, prefix = re.search(r" in ([\d.]+) (m?)s\b", message).groups()
    assert float(time_text) * (1e-3 if prefix else 1.0) == pytest.approx(recording.time[-1], rel=1e-5)
    assert 0.1 <= float(time_text) < 1e3
    columns = recording.columns
    if match := re.search(r"([\d.]+) J dissipated", message):
        assert float(match[1]) == pytest.approx(columns["energy.dissipated"][-1], rel=5e-3)
    else:  # an elastic wall dissipates nothing
        assert abs(columns["energy.dissipated"]).max() < 1e-9


def test_the_headline_omits_energy_that_is_not_lost_or_not_known():
    recording = swing()
    recording.columns["energy.dissipated"] = np.zeros(50)
    assert energy_texts(recording) == []
    recording = swing()
    del recording.columns["energy.dissipated"]
    assert energy_texts(recording) == []


def test_the_headline_is_a_sentence():
    assert headline(swing()) == "Swing: nothing is hit in 2 s"
    hits = [impact_row(time, 1, "y_max", 1.0) for time in (0.5, 1.0)]
    assert headline(swing(hits[:1], {"y_max": 1.0})) == "Swing: 1 impact happens in 2 s"
    assert headline(swing(hits, {"y_max": 1.0})) == "Swing: 2 impacts happen in 2 s"
    assert headline(recorded("pinned_arm")) == "PinnedArm: the peak force is 1.02 kN"


def test_the_conditions_are_the_parameters_of_the_run():
    changes = {
        ("contact", "stiffness"): 2.145e10,
        ("contact", "model"): "flores",
        ("solver", "tolerance"): 1e-6,
    }
    scene = with_values(load_scene("rod_drop"), changes | {("simulation", "stop_time"): 0.1})
    assert conditions(simulate(scene)).split(SEPARATOR) == [
        "1 link",
        "law flores",
        "restitution e = 0.7",
        "stiffness K = 2.145e10 N/m$^{1.5}$",
        "method auto, tolerance 1e-6",
    ]
    of_arm = conditions(recorded("pinned_arm"))
    assert "joint damping ≤ 0.02 N·m·s/rad" in of_arm
    assert "tolerance" not in of_arm, "the usual settings of the solver"
    assert "radius 0.05 m" in conditions(recorded("ramp"))


@pytest.mark.parametrize(
    ("model", "damping"), [("arm_at_stop", "20"), ("ur5e", "200")], ids=["with targets", "with a limit"]
)
def test_the_damping_of_a_powered_drive_is_that_of_a_servo(model, damping):
    parts = conditions(recorded(model)).split(SEPARATOR)
    assert f"servo damping ≤ {damping} N·m·s/rad" in parts
    assert not [part for part in parts if part.startswith("joint damping")]


@pytest.mark.parametrize("title", ["", "Arm"])
def test_the_largest_force_and_its_impact_are_told(title):
    recording = recorded("four_link_box")
    row = int(np.argmax(recording.impacts["peak_force"]))
    (peak,) = largest_peaks(recording)
    value, prefix = re.fullmatch(r"([\d.]+) (k?)N", peak.value).groups()
    assert (peak.name, peak.row) == ("peak force", row)
    force = recording.impacts["peak_force"][row]
    assert float(value) * (1e3 if prefix else 1.0) == pytest.approx(force, rel=5e-3)
    page = recording.plot(title=title, panels="energy")
    head, *lines = [text.get_text().replace("\n", " ") for text in page.texts]
    assert (peak.value in head) == (not title)
    impact_text = f"impact {row + 1}: point 2 hits y_min at {recording.impacts['onset'][row]:.4g} s"
    (place,) = (text for text in lines if impact_text in text)
    assert (peak.value in place) == bool(title)  # the value is told once


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("panel", "colour"), [("impacts", PEAK_COLOUR), ("energy", INK)])
def test_a_narrow_picture_has_the_peak_as_its_headline(panel, colour):
    """The line on the impact has the colour of its mark, if the picture has the mark."""
    recording = recorded("pinned_arm")
    page = recording.plot(size=(84 / 25.4, None), panels=panel)
    assert page.get_suptitle() == "PinnedArm: the peak force is 1.02 kN"
    impact = recording.impacts[0]
    place = f"impact 1: point 2 hits x_max at {impact['onset']:.4g} s"
    words = f"{place} with {impact['impact_speed']:.3g} m/s"
    assert [text.get_color() for text in page.texts if text.get_text() == words] == [colour]
    assert any("1 impact in 2 s" in text.get_text().replace("\n", " ") for text in page.texts)


def test_a_moment_at_a_stop_and_an_impulse_have_words_of_their_own():
    moment, *other_peaks = largest_peaks(simulate(knee_scene(), 1.0))
    assert not other_peaks
    assert moment.name == "peak moment"
    assert moment.value.endswith("N·m")
    rigid = with_values(load_scene("rod_drop"), {("contact", "model"): "newton_impact"})
    run = simulate(rigid)
    (peak,) = largest_peaks(run)
    assert peak.name == "largest impulse"
    assert run.impacts["peak_force"].max() > 0.0, "the rod rests at the end with a force"
    assert float(peak.value.removesuffix(" N·s")) == pytest.approx(run.impacts["impulse"].max(), rel=5e-3)
    assert peak.row == int(np.argmax(run.impacts["impulse"]))
    assert largest_peaks(swing()) == []


def test_the_impulse_of_a_rest_is_no_largest_impulse():
    """The impulse of a ball that rests to the end of the run is its weight times the duration of the rest."""
    run = simulate(load_scene("bouncing_ball"))
    (peak,) = largest_peaks(run)
    assert int(np.argmax(run.impacts["impulse"])) == len(run.impacts) - 1
    assert peak.row == 0


@pytest.mark.parametrize("duration", [0.7, 1.5])
def test_the_weight_on_a_rigid_wall_is_no_part_of_the_impact(duration):
    """A rigid wall stops a ball by the impulse m v, and then bears its weight."""
    scene = load_scene("bouncing_ball").with_values({"contact.restitution": 0.0})
    run = simulate(scene, duration)
    (impact,) = run.impacts
    assert impact["peak_force"] > 0.0
    assert np.isnan(impact["end"])
    (peak,) = largest_peaks(run)
    momentum = sum(link.mass for link in scene.chain.links) * impact["impact_speed"]
    assert peak.name == "hit impulse"
    assert float(peak.value.removesuffix(" N·s")) == pytest.approx(momentum, rel=5e-3)
    assert "peak" not in headline(run)


def test_a_knee_that_stays_at_its_stop_tells_joint_time_speed_and_impulse():
    run = simulate(load_scene("kneed_leg"))
    short = simulate(load_scene("kneed_leg"), float(run.impacts["onset"][0]) + 1e-6)
    (peak,) = largest_peaks(run)
    assert peak.name == "hit impulse at a stop"
    assert run.impacts["impulse"][0] > 2.0 * short.impacts["impulse"][0]  # the stop then holds the knee
    value = float(peak.value.removesuffix(" mN·m·s"))
    assert value == pytest.approx(1e3 * short.impacts["impulse"][0], rel=5e-3)
    page = run.plot(size=(84 / 25.4, None))
    assert peak.value in page.get_suptitle()
    assert any("joint 3 hits joint_max at 0.3478 s with 7.69 rad/s" in t.get_text() for t in page.texts)
    panel = next(axes for axes in page.axes if axes.get_label() == "impacts")
    assert f"#1: {peak.value}" in [text.get_text() for text in panel.texts]
    assert panel.get_ylabel().split() == ["hit", "impulse", "[mN·m·s]"]


def test_none_of_equal_impulses_is_singled_out():
    run = recorded("bouncing_table")
    (peak,) = largest_peaks(run)
    assert peak.equal_count == len(run.impacts)
    assert marked_peaks(run) == []
    assert peak.text == f"{peak.equal_count} equal impulses of {run.impacts['impulse'].max():.3f} N·s"
    assert headline(run).endswith(f": there are {peak.text}")
    page = run.plot(panels=["motion", "impacts"])
    assert not any(line.get_color() == PEAK_COLOUR for axes in page.axes for line in axes.lines)
    assert any("the first in impact 1: ball hits y_min at " in text.get_text() for text in page.texts)
    assert recorded("rod_drop").plot(panels="impacts").axes[0].get_ylabel() == "peak force [kN]"
    assert page.axes[1].get_ylabel() == "impulse [N·s]"


@pytest.mark.parametrize(("supplied", "text"), [(0.5, "0.5 J supplied"), (-2.0, "2 J taken"), (1e-3, "")])
def test_energy_of_drives_is_told_beside_that_lost(supplied, text):
    recording = swing()
    recording.columns["energy.supplied"] = np.linspace(0.0, supplied, 50)
    assert energy_texts(recording) == ["1 J dissipated", *([f"{text} by drives"] if text else [])]


@pytest.mark.full("takes long")
def test_in_a_narrow_picture_the_load_stands_below_the_peak_force():
    result = simulate(with_values(load_scene("pinned_arm"), {("outputs", "loads"): True}))
    page = result.plot(size=(84 / 25.4, None))
    (peak,) = (text for text in page.texts if text.get_color() == PEAK_COLOUR)
    (load,) = (text for text in page.texts if text.get_color() == LOAD)
    assert load.get_text() == load_text(result)
    assert sum(load_text(result) in text.get_text() for text in page.texts) == 1
    head = page.get_window_extent().y1 - load.get_window_extent().y0
    assert load.get_window_extent().y1 <= peak.get_window_extent().y0
    assert head < 0.1 * page.bbox.height


@pytest.mark.full("takes long")
@pytest.mark.parametrize(("end", "touches"), [(0.05, False), (0.6, True)])
def test_the_law_of_contacts_is_told_if_something_touches(end, touches):
    recording = simulate(load_scene("rod_drop"), end)
    assert has_contact(recording) == touches == (len(recording.impacts) > 0)
    page_text = " ".join(text.get_text() for text in recording.plot(panels="energy").texts)
    assert ("law " in page_text) == ("restitution" in page_text) == ("stiffness" in page_text) == touches


def test_an_impulse_has_no_stiffness():
    parameters = recorded("rod_drop").parameters | {"contact.model": "newton_impact"}
    assert "stiffness" not in conditions(swing(parameters=parameters))


def test_without_parameters_only_the_links_are_known():
    assert conditions(swing()) == "1 link"


def test_a_law_without_losses_has_no_restitution():
    parameters = recorded("rod_drop").parameters | {"contact.model": "hertz"}
    text = conditions(swing(parameters=parameters))
    assert "law hertz" in text
    assert "restitution" not in text


STOPS = [(None, "stops e = 0.5"), ("flores", "stops law flores, e = 0.5"), ("hertz", "stops law hertz")]


@pytest.mark.parametrize(("law", "part"), STOPS)
def test_stops_have_their_restitution_and_a_law_of_their_own(law, part):
    scene = knee_scene(**({"stops.model": law} if law else {}))
    assert part in conditions(simulate(scene, 0.5)).split(SEPARATOR)


@pytest.mark.parametrize(
    ("loss", "texts"), [(0.5, ["0.5 J dissipated"]), (3.21e-5, ["3.21e-05 J dissipated"]), (1e-14, [])]
)
def test_a_small_loss_is_told_and_round_off_is_not(loss, texts):
    recording = swing([impact_row(1.0, 1, "y_max", 1.0)], {"y_max": 1.0})
    total = np.linspace(1.0, 1.0 - loss, 50)
    recording.columns.update({"energy.total": total, "energy.dissipated": 1.0 - total})
    assert energy_texts(recording) == texts


def test_the_joint_with_the_largest_force_is_told_with_its_number_and_time():
    scene = with_values(load_scene("pinned_arm"), {("outputs", "loads"): True})
    result = simulate(scene)
    page = result.plot()
    peaks_of = {n: result[f"joint[{n}].peak_force"] for n in (1, 2)}
    joint = max(peaks_of, key=lambda n: peaks_of[n][-1])
    fine = simulate(scene, output_step=1e-5)
    time = fine.time[np.hypot(*fine.joint_forces[joint].T).argmax()]
    (load_parts,) = re.findall(
        r"joint (\d) bears up to ([\d.]+) k?N in the run, at ([\d.]+) s", load_text(result)
    )
    assert (int(load_parts[0]), float(load_parts[2])) == (joint, pytest.approx(time, abs=1e-5))
    assert any(load_text(result) in text.get_text() for text in page.texts)
    motion = next(axes for axes in page.axes if axes.get_label() == "motion")
    assert any(load_parts[1] in text.get_text() for text in motion.texts)
    plain = simulate("pinned_arm")  # without the outputs of loads, a repeated run has the force
    assert load_text(plain) == load_text(result)
    assert any(load_text(result) in text.get_text() for text in plain.plot().texts)
    assert load_text(replace(plain, rerun=None)) == ""


def test_the_largest_force_in_a_joint_lacks_the_impulses_of_rigid_impacts():
    (load_line,) = [
        text.get_text() for text in simulate("falling_arm").plot().texts if "bears" in text.get_text()
    ]
    assert "joint 1 bears up to 38.5 N without impulses, at" in load_line.replace("\n", " ")


def test_without_impacts_the_headline_tells_joint_force_and_oscillation():
    recording = recorded("shaken_pendulum")
    title = recording.plot().get_suptitle().replace("\n", " ")
    assert title == "ShakenPendulum: nothing is hit in 3 s"  # no panel shows the force
    foot = " ".join(text.get_text() for text in recording.plot().texts).replace("\n", " ")
    assert "joint 1 bears up to 128 N in the run, at 1.4937 s" in foot
    supplied = recording.columns["energy.supplied"]
    low, high = (f"{end(supplied):.2g}".replace("-", "−") for end in (np.min, np.max))
    assert f"supplied energy oscillates between {low} and {high} J" in foot

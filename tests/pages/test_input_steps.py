"""Changed inputs during playback: they act from then on, also in the link, the command and the scene file."""

# Tests: pages/browser/scene/input_steps.js

import shlex

import numpy as np
import pytest

from chain_impact import Chain, load_scene, simulate
from tests.pages.in_pages import packed_module, page_contents, saved, until, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
STEPS = [(0.2, 1.5), (0.31, -2.0), (0.6, 0.5)]
RUN = function_of("input_steps", "run")
SLIDER, ITS_WORDS = "joint[1].torque", "Torque of joint 1"
TIME_OF_SLIDER = "Number(document.getElementById('scrub').value)"
IS_HELD = f"chart => document.querySelector('#inputs-over-time dt.of-curve')?.title === '{SLIDER}'"


def test_an_input_that_is_held_acts_as_when_a_chain_is_set_in_time(worker):
    scene, name = load_scene("pinned_arm"), "point[2].x"
    times = np.linspace(0.0, 1.0, 101).tolist()
    arguments = {"module": packed_module(), **page_contents(scene), "times": times, "name": name}
    result = worker.evaluate(RUN, {**arguments, "inputSteps": {SLIDER: STEPS}})
    chain, expected, steps = Chain(scene), [], list(STEPS)
    for time in times:
        while steps and steps[0][0] < time:
            at, value = steps.pop(0)
            chain.step_to(at)
            chain.set(SLIDER, value)
        chain.step_to(time)
        expected.append(chain.get(name))
    assert result == expected


def test_a_slider_moved_during_playback_is_held_from_then_on(show, tmp_path, capsys):
    page = show("pinned_arm")
    torque_text = page.evaluate("chainImpact.parameters['joint[1].torque']")
    page.get_by_label("Speed").select_option("¼ ×")
    page.get_by_role("button", name="Play").click()
    until(page, f"{TIME_OF_SLIDER} > 0.1")
    slider = page.get_by_role("slider", name=ITS_WORDS)
    for key in ("PageUp", "PageUp", "ArrowLeft"):
        slider.press(key)
        until(
            page, f"{TIME_OF_SLIDER} > {page.evaluate(TIME_OF_SLIDER) + 1e-3}"
        )  # each change at its own time
    page.get_by_role("button", name="Pause").click()
    # the address may have the three steps while the motion plays, and has the time a little later
    until(page, "/time=.*(:.*){3}/.test(decodeURIComponent(location.hash))")
    page.wait_for_function(IS_HELD)
    assert page.evaluate("chainImpact.parameters['joint[1].torque']") == torque_text, (
        "the value at the start stays"
    )
    parts = page.evaluate("decodeURIComponent(location.hash)").strip("#").split("&")
    link_parts = dict(part.split("=") for part in parts)
    assert (set(link_parts), link_parts["view"]) == ({f"{SLIDER}@", "time", "view"}, "0.25")  # pause, speed
    text = link_parts[f"{SLIDER}@"]
    steps = [tuple(map(float, step.split(":"))) for step in text.split(",")]
    assert len(steps) == 3
    assert 0.1 < steps[0][0] < steps[-1][0] < 2.0
    for time, value in ((0.05, 0.0), (1.99, steps[-1][1])):
        page.locator("#scrub").fill(str(time))
        until(page, f"document.getElementById('time').textContent.startsWith('{time}')")
        assert float(page.locator("#inputs-over-time dd").inner_text().split("\u202f")[0]) == pytest.approx(
            value
        )
        assert float(page.get_by_role("textbox", name=SLIDER).first.input_value()) == pytest.approx(value)
        row = page.locator(".main-parameter").filter(has=page.get_by_role("slider", name=f"{ITS_WORDS}, N·m"))
        since = f"Held since {steps[-1][0]:.4g} s." if time > steps[0][0] else ""
        assert row.locator(".sentence:not(.outcome)").inner_text() == since

    page.get_by_role("button", name="Export…").click()
    path = tmp_path / "held.toml"
    path.write_text(saved(page, "Scene file").read_text(encoding="utf-8"), encoding="utf-8")
    signal = load_scene(path).signals["held_joint_1_torque"]
    assert list(zip(signal.times, signal.values, strict=True)) == [(0.0, 0.0), *steps]
    table = saved(page, "Outputs as CSV").read_text(encoding="utf-8").splitlines()
    column = table[0].split(",").index("point[2].x")
    expected = simulate(path)["point[2].x"]
    assert [float(row.split(",")[column]) for row in table[1:]] == pytest.approx(expected.tolist(), abs=1e-6)
    words = shlex.split(page.get_by_label("The command that gives the same motion").input_value())
    assert words[:2] == ["python", "-c"]
    page.keyboard.press("Escape")
    page.reload()
    page.wait_for_function(IS_HELD)
    page.get_by_role("button", name=f"Reset {SLIDER}").first.click()
    until(page, "document.getElementById('inputs-over-time').closest('section').hidden")
    exec(words[2])  # the script prints the result
    assert f"{len(simulate(path).impacts)} impact" in capsys.readouterr().out


def test_command_file_and_pin_have_all_changed_inputs(show, tmp_path):
    changes = "joint[1].target_velocity=2&joint[2].target_angle=1&joint[1].target_angle@=0.1:0.5"
    page = show("ur5e", {"inputs.joint_targets": True}, hash_=f"#simulation.stop_time=0.3&{changes}")
    page.get_by_role("button", name="Pin").click()
    assert (
        "Target angle of joint 1 = 28.648\u202f° from 0.1 s"
        in page.locator("#pins tbody tr").last.inner_text()
    )
    page.get_by_role("button", name="Export…").click()
    path, results = tmp_path / "held.toml", []
    path.write_text(saved(page, "Scene file").read_text(encoding="utf-8"), encoding="utf-8")
    table = np.genfromtxt(saved(page, "Outputs as CSV"), delimiter=",", names=True, deletechars="")
    words = shlex.split(page.get_by_label("The command that gives the same motion").input_value())
    exec(words[2], {"print": results.append})
    for result in (*results, simulate(path)):
        assert result["point[2].x"] == pytest.approx(table["point[2].x"], abs=1e-6)
        assert set(result["joint[1].target_velocity"]) == {2.0}
        assert set(result["joint[2].target_angle"]) == {1.0}


def test_inputs_keep_their_changes_when_the_scene_is_edited(show):
    page = show("pinned_arm", hash_="#simulation.stop_time=0.2&joint[1].torque=1&joint[2].torque@=0.1:2")
    page.get_by_role("button", name="Edit…").click()
    page.get_by_label("link[1].length").fill("0.6")
    page.get_by_label("link[1].length").press("Enter")
    address = "decodeURIComponent(location.hash)"
    until(page, f"/^#scene=.*&joint.1..torque=1&joint.2..torque@=0.1:2$/s.test({address})")
    assert page.evaluate("chainImpact.parameters['link[1].length']") == "0.6"
    page.get_by_role("button", name="Remove link 2").click()
    until(page, f"{address}.endsWith('&joint[1].torque=1')")
    assert page.locator("#edit-text").inner_text() == ""


def test_a_link_whose_command_would_be_refused_is_refused(show):
    page = show("pinned_arm")
    for text in ("0:0.5", "0.1:0.5,0.1:0.7", "0.2:1,0.1:2", "0.1", "0.1:", ":1", "0.1:1:2", "Infinity:1"):
        page.evaluate(f"location.hash = '#{SLIDER}@={text}'")
        until_text(page, f"The link cannot be used: {SLIDER}@ = {text}: ", "status")
        until(page, "location.hash === ''")


def playing(page):
    """Play the motion slowly, and wait until inputs are held."""
    page.wait_for_function(IS_HELD)
    page.get_by_label("Speed").select_option("¼ ×")
    page.get_by_role("button", name="Play").click()
    until(page, f"{TIME_OF_SLIDER} > 0.03")


def after_frames(page):
    """Wait until the page has drawn a later time."""
    until(page, f"{TIME_OF_SLIDER} > {page.evaluate(TIME_OF_SLIDER) + 0.01}")


def test_fields_keep_a_typed_text_and_a_refusal_while_inputs_are_held(show):
    page = show("pinned_arm", hash_=f"#{SLIDER}@=0.02:3")
    playing(page)
    name = "contact.restitution"
    field = page.get_by_role("textbox", name=name).first
    for text in ("0.31", "2"):
        field.select_text()
        for key in text:
            page.keyboard.press(key)
            after_frames(page)
        page.keyboard.press("Enter")
    torque = page.get_by_role("textbox", name=SLIDER).first
    torque.fill("much")
    torque.blur()
    after_frames(page)
    assert page.evaluate(f"chainImpact.parameters['{name}']") == "0.31"
    refused = page.locator(".refusal").filter(has_text="Not taken").all_inner_texts()
    assert [refusal.split(" must")[0] for refusal in refused] == [
        "Not taken: Restitution = 2",
        f"Not taken: {ITS_WORDS} = much",
    ]
    assert torque.input_value() == "much"


def test_a_slider_dragged_back_to_its_value_follows_the_motion_again(show):
    page = show("pinned_arm", hash_=f"#{SLIDER}@=0.02:3")
    playing(page)
    slider = page.get_by_role("slider", name=ITS_WORDS)
    box = slider.bounding_box()
    at = box["x"] + 0.8 * box["width"], box["y"] + box["height"] / 2
    page.mouse.click(*at)  # its value is here the value of this pixel
    page.mouse.down()
    page.mouse.move(at[0] - 20, at[1])
    page.mouse.move(*at)
    page.mouse.up()
    page.get_by_role("button", name="Pause").click()
    assert slider.evaluate("slider => slider.value / slider.max") > 0.7
    page.locator("#scrub").fill("0.01")
    until(page, f"document.querySelector('input[aria-label^=\"{ITS_WORDS}\"][type=range]').value === '200'")


def test_a_map_and_its_runs_keep_inputs_at_their_starts(show):
    page = show("pinned_arm")
    page.evaluate("location.hash = '#simulation.stop_time=0.1&joint[1].torque@=0.05:3'")
    page.wait_for_function(IS_HELD)
    page.get_by_role("button", name="Map…").click()
    page.locator("#map-text").get_by_text("Inputs keep their start values.").wait_for()
    assert page.locator(".map-present").count() == 0
    page.locator("#map-canvas").click()
    until(page, "!location.hash.includes('torque')")
    until(page, "document.getElementById('inputs-over-time').closest('section').hidden")

"""A recording's page: playback, jumps, the list of impacts, keys, a phone and the dark theme."""

# Tests: pages/recorded.py, pages/browser/player/player.js
# Tests: pages/browser/player/clock.js, pages/browser/player/controls.js, pages/browser/player/impact_list.js
# Tests: pages/browser/player/recorded_page.js, pages/browser/recording/recording.js

import re

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.pages.assembly import program_text
from chain_impact.recording.impacts import IMPACT_DTYPE
from chain_impact.recording.recording import Recording
from chain_impact.scene.half_planes import half_planes
from chain_impact.studies.animate import record_slowly
from tests.pages.in_pages import (
    DARK_CHAIN,
    LIGHT_CHAIN,
    ON_ITS_SIDE,
    PHONE,
    TIME_TEXT,
    count_of,
    go_to,
    pixels,
    press,
    resize,
    time_of,
    until,
    until_drawn,
)
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser


def time_after(page, milliseconds):
    """Advance the page's clock, which stands still otherwise, and return the simulated time that is shown."""
    page.clock.run_for(milliseconds)
    return float(page.evaluate(TIME_TEXT).removesuffix(" s"))


def test_a_recording_plays_on_its_own_and_pauses(show_recording):
    page = show_recording(reduced_motion="no-preference", stopped=True)
    page.clock.run_for(200)
    page.get_by_role("button", name="Pause").click()
    stopped = time_after(page, 50)
    assert stopped > 0.1
    assert time_after(page, 500) == stopped
    page.keyboard.press("Space")  # the focused button receives the key
    assert time_after(page, 100) > stopped


def test_a_page_that_is_paused_asks_for_no_frames(show_recording):
    page, frames_in = show_recording(), function_of("playback", "framesIn")
    assert page.evaluate(frames_in, 300) == 0
    page.get_by_role("button", name="Play").click()
    assert page.evaluate(frames_in, 1000) > 2


def test_a_page_starts_paused_and_its_clock_keeps_its_rate(show_recording):
    """In 1/3 s the clock passes less than 3 ms at an impact; without slow motion 1/3 s, or twice as long."""
    page = show_recording(stopped=True)
    assert time_after(page, 500) == 0.0
    page.get_by_role("button", name="Play").click()
    assert time_after(page, 500) > 0.05
    page.keyboard.press("End")
    assert time_after(page, 50) == 2.0
    page.keyboard.press("Space")
    assert 0.0 < time_after(page, 100) < 1.0, "it starts anew"
    page.keyboard.press("Space")
    page.keyboard.press("Home")
    passed = []
    for key in ("Shift+ArrowRight", "s", "ArrowUp"):
        page.keyboard.press(key)
        time_before = time_after(page, 50)
        page.keyboard.press("Space")
        page.clock.run_for(330)
        page.keyboard.press("Space")
        passed.append(time_after(page, 50) - time_before)
    assert 1e-5 < passed[0] < 3e-3
    assert passed[1:] == pytest.approx([0.33, 0.66], abs=0.05)


def test_positions_alone_make_a_page(show_recording):
    """The table has positions only: no walls, no impacts, no energies."""
    time = np.linspace(0.0, 1.0, 20)
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(time), "point[1].y": np.sin(time)}
    page = show_recording(Recording("Bare", time, columns))
    page.keyboard.press("End")
    assert press(page, "Shift+ArrowLeft") == 0.0
    assert page.locator("h2:visible").all_inner_texts() == ["Impacts"]
    assert page.inner_text("#impacts") == "none"


def test_energies_below_zero_have_as_many_digits_as_those_above(show_recording):
    time = np.linspace(0.0, 1.0, 20)
    columns = {f"point[{k}].{axis}": k + 0 * time for k in (0, 1) for axis in "xy"}
    columns |= {"energy.supplied": -1234.5 + time}
    energy_text = show_recording(Recording("Deep", time, columns)).inner_text("#energies dd")
    assert energy_text in ("\u22121234", "\u22121235")


def test_impacts_between_two_rows_are_in_the_list(show_recording):
    coarse = simulate(load_scene("four_link_box"), output_step=5e-3)
    page = show_recording(coarse)
    press(page, "Shift+ArrowRight")
    assert page.locator("#impacts tbody tr").count() == 14
    assert page.inner_text("#impacts th:last-child") == "peak, kN"
    peak = f"{coarse.impacts['peak_force'][0] / 1e3:.1f}"
    assert page.inner_text("#impacts tr[aria-current] td:last-child") == peak


def peak_time(recording, impact):
    """Return the time of the largest force of an impact."""
    wall = recording.wall_names[impact["wall"]]
    during = (recording.time >= impact["onset"]) & (recording.time <= impact["end"])
    force = recording.columns[f"contact[{impact['point']}].{wall}.force"] * during
    return recording.time[np.argmax(force)]


def test_clicks_keys_slider_and_chart_go_to_a_moment(show_recording, recording):
    page = show_recording()
    for number in (3, 14, 1):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        impact = recording.impacts[number - 1]
        assert time_of(page) == pytest.approx(peak_time(recording, impact), abs=2e-5)
        newtons = page.text_content(".force-text").replace("kN", "e3").replace("N", "")
        assert float(newtons.replace("\u202f", "")) == pytest.approx(impact["peak_force"], rel=0.02)
        wall = {"y_min": "floor", "x_max": "right wall"}[recording.wall_names[impact["wall"]]]
        contact_text = f"point {impact['point']} at the {wall}"
        caption = page.inner_text("#caption")
        assert caption.startswith(f"Impact {number} of 14: {page.text_content('.force-text')}, ")
        assert caption.endswith(f"m/\u2060s, {contact_text}")
        assert page.inner_text("tr[aria-current] button") == str(number)
    assert press(page, "Home") == 0.0
    times = [press(page, key) for key in ["Shift+ArrowRight"] * 3 + ["Shift+ArrowLeft"]]
    expected = [peak_time(recording, recording.impacts[k]) for k in (0, 1, 2, 1)]
    assert times == pytest.approx(expected, abs=2e-5)
    assert go_to(page, 1.25) == pytest.approx(1.25, abs=1e-4)
    box = page.locator("#energy .u-over").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 4, box["y"] + 20)
    assert time_of(page) == pytest.approx(0.5, abs=0.01)
    page.get_by_role("button", name="Go to impact 2, ").click()
    impact, box = recording.impacts[1], page.locator("#force .u-over").bounding_box()
    for share in (0.1, 0.6):  # before the impact, which stays the present one, and in it
        page.mouse.click(box["x"] + share * box["width"], box["y"] + 40)
        since = (share * 1.7 - 0.35) * (impact["end"] - impact["onset"])
        assert time_of(page) == pytest.approx(impact["onset"] + since, abs=3e-5)
        assert page.inner_text("tr[aria-current] button") == "2"
    page.get_by_role("button", name="F(δ)").click()
    go_to(page, peak_time(recording, impact))
    dot = page.locator(".loop-now").bounding_box()
    go_to(page, impact["end"])
    page.mouse.click(dot["x"] + dot["width"] / 2, dot["y"] + dot["height"] / 2)
    assert time_of(page) == pytest.approx(peak_time(recording, impact), abs=1e-4)


def test_arrow_keys_step_in_time_on_the_screen(show_recording):
    page = show_recording()
    assert press(page, "ArrowRight") == pytest.approx(1 / 30, rel=0.01)
    assert press(page, "ArrowLeft") == 0.0
    # steps beyond either end have no effect: the next step back is visible at once
    assert [press(page, "ArrowLeft") for _ in range(3)] == [0.0] * 3
    assert press(page, "ArrowRight") == pytest.approx(1 / 30, rel=0.01)
    end = press(page, "End")
    assert [press(page, "ArrowRight") for _ in range(3)] == [end] * 3
    assert press(page, "ArrowLeft") < end


def named(page):
    """Return the numbers of the impact in the list, the caption and the force chart."""
    return (
        int(page.inner_text("tr[aria-current] button")),
        int(re.search(r"mpact (\d+) of 14", page.inner_text("#caption"))[1]),
        int(re.match(r"impact\u00a0(\d+): ", page.text_content("#contact-name"))[1]),
    )


def test_list_caption_and_force_chart_name_the_same_impact_at_every_moment(show_recording, recording):
    """From halfway between two impacts, the next impact is named before its onset."""
    page = show_recording()
    second, third = recording.impacts[1:3]
    middle = (second["end"] + third["onset"]) / 2
    assert named(page) == (1, 1, 1)
    page.get_by_role("button", name="Go to impact 2, ").click()
    states, present_time = set(), time_of(page)
    times_between = np.linspace(present_time, third["end"] + 1e-3, 12)
    for target in [present_time, *times_between, middle - 1e-4, middle + 1e-4]:
        present_time = go_to(page, target) if target != present_time else present_time
        number, is_next = 2 + (present_time >= middle), middle <= present_time < third["onset"]
        assert named(page) == (number,) * 3
        assert ("Next is impact " in page.inner_text("#caption")) == is_next
        states.add((number, is_next))
    assert states == {(2, False), (3, True), (3, False)}
    press(page, "End")
    assert named(page) == (14, 14, 14)


def twins(until_next=1e-3, force=1.0):
    """Return a recording in which a second point touches a wall soon after the first one."""
    time = np.linspace(0.0, 0.02, 401)
    columns = {f"point[{k}].{axis}": 0 * time + k * (axis == "x") for k in (0, 1) for axis in "xy"}
    onsets = [0.01, 0.01 + until_next]
    for k, onset in enumerate(onsets):
        columns[f"contact[{k}].y_min.force"] = force * np.maximum(0.0, 1.0 - abs(time - onset - 1e-3) / 1e-3)
    impacts = np.zeros(len(onsets), IMPACT_DTYPE)
    impacts["onset"], impacts["point"], impacts["impact_speed"] = onsets, range(len(onsets)), 1.0
    impacts["end"], impacts["peak_force"] = impacts["onset"] + 2e-3, force
    return Recording("Twins", time, columns, impacts, half_planes({"y_min": 0.0}, {}), ("y_min",))


@pytest.mark.parametrize("until_next", [1e-3, 0.0])
def test_the_latest_of_overlapping_contacts_is_named(show_recording, until_next):
    """If two contacts begin at the same time, the page names the contact whose button was pressed."""
    page = show_recording(twins(until_next))
    for number in (1, 2, 1):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        time_of(page)
        assert page.inner_text("tr[aria-current] button") == str(number)
        assert re.match(rf"Impact {number} of 2: .*, point {number - 1} at ", page.inner_text("#caption"))
        assert page.text_content("#contact-name").startswith(f"impact\u00a0{number}: point {number - 1} ")
    go_to(page, 0.0125)
    assert page.inner_text("tr[aria-current] button") == "2"


@pytest.mark.parametrize(("model", "unit"), [("bouncing_ball", "N·s"), ("kneed_leg", "N·m·s")])
def test_a_rigid_wall_or_stop_has_the_impulse_of_an_impact(show_recording, model, unit):
    scene = load_scene(model).with_values({"simulation.stop_time": 0.55})
    impact = simulate(scene).impacts[0]
    page = show_recording(record_slowly(scene))
    assert page.locator("#impacts th").last.inner_text().startswith("impulse, ")
    page.locator("#impacts tbody tr").first.click()
    assert time_of(page) == pytest.approx(impact["onset"], abs=2e-5)
    cells = [
        page.locator(f"#impacts {row}").first.locator("th, td").nth(6) for row in ("thead tr", "tbody tr")
    ]
    head, number = (cell.inner_text() for cell in cells)
    for text in (f"{number}\u202f{head.partition(', ')[2]}", page.inner_text("#caption")):
        number_text, prefix = re.search(rf"([\d.]+)\u202f(m?){unit}(?!·)", text).groups()
        impulse = float(number_text) * (1e-3 if prefix else 1.0)
        assert impulse == pytest.approx(impact["impulse"], rel=5e-3)


def test_the_largest_force_stands_out_in_the_list(show_recording, recording):
    page = show_recording()
    largest_cell = page.locator("#impacts .largest")
    assert largest_cell.count() == 1
    row = largest_cell.locator("xpath=..")
    assert int(row.locator("button").inner_text()) == 1 + int(np.argmax(recording.impacts["peak_force"]))
    weights = [
        int(cell.evaluate("cell => getComputedStyle(cell).fontWeight"))
        for cell in (largest_cell, row.locator("td").nth(2))
    ]
    assert weights[0] > weights[1]


def test_the_moment_that_holds_a_joint_is_told_from_the_impulse_before(show):
    page = show("kneed_leg")
    go_to(page, 0.45)
    assert page.inner_text("#contact-quantity") == "Holding moment after the impulse"
    assert page.text_content(".force-text").startswith("holds 0.0247")
    title = page.locator("#contact-name")
    assert title.evaluate("title => title.scrollWidth <= title.clientWidth")


def test_the_labels_of_a_force_are_not_cut_off(show_recording):
    page = show_recording(twins(force=2.345e-4))
    go_to(page, 0.011)
    picture = pixels(page.locator("#force canvas"))
    assert picture.min() < 128.0
    assert (picture[:, :2] == picture[0, 0]).all()


def test_a_long_list_ends_with_how_many_more_there_are(open_page):
    page = open_page("about:blank", begins=False)
    page.set_content(
        f"<small id='impacts-seen'></small><script>{program_text('player/impact_list.js')}</script>"
    )
    long_list = function_of("playback", "longList")
    assert page.evaluate(long_list, 2345) == [2000, "and 345 more, which the animation shows"]
    rows, table = page.evaluate(long_list, 2000)
    assert rows == 2000
    assert "more" not in table


def test_speed_help_and_what_has_the_focus(show_recording):
    page = show_recording()
    names = page.evaluate(
        """[...document.querySelectorAll('button, input, select')].map((element) =>
          element.ariaLabel || element.textContent.trim() || element.labels?.[0]?.textContent.trim())"""
    )
    assert all(names)
    focused = set()
    for _ in range(30):
        page.keyboard.press("Tab")
        focused.add(page.evaluate("document.activeElement.id"))
    assert {"help-open", "scrub", "previous", "play", "next", "speed", "slow", "trace"} <= focused
    page.get_by_label("Speed").select_option("½ ×")
    time_of(page)
    assert page.inner_text("#rate") == "2 × slower"
    page.get_by_label("Speed").evaluate("(select) => select.blur()")
    page.keyboard.press("ArrowUp")
    press(page, "ArrowUp")
    assert page.inner_text("#rate") == "2 × faster"
    page.keyboard.press("?")
    assert page.get_by_role("dialog").is_visible()
    assert press(page, "End") == 0.0, "keys rest while the help is open"
    page.keyboard.press("Escape")
    assert not page.get_by_role("dialog").is_visible()


def test_the_page_is_dark_where_that_is_wanted_and_changes_while_open(show_recording):
    page = show_recording(color_scheme="dark")
    dark = pixels(page)
    assert np.median(dark) < 60
    assert count_of(dark, DARK_CHAIN) > 1000
    page.emulate_media(color_scheme="light", reduced_motion="reduce")
    time_of(page)
    assert np.median(pixels(page)) > 200


def test_on_a_phone_all_fits_the_width_and_the_controls_are_in_sight(show_recording):
    page = show_recording(viewport=PHONE, has_touch=True)
    for viewport in (PHONE, {"width": 320, "height": 568}, ON_ITS_SIDE):
        resize(page, **viewport)
        assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
        assert page.evaluate("(({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth)(controls)")
        for name in ("Previous impact", "Play", "Next impact"):
            box = page.get_by_role("button", name=name, exact=True).bounding_box()
            assert box["y"] + box["height"] <= viewport["height"]
            assert min(box["width"], box["height"]) >= 32
        assert count_of(pixels(page), LIGHT_CHAIN) > 150


@pytest.mark.parametrize("name", ["help", "map"])
def test_the_motion_pauses_behind_a_dialog_and_goes_on_after_it(show, name):
    page = show(reduced_motion="no-preference", viewport={"width": 1100, "height": 768})
    playing = "document.body.classList.contains('playing')"
    until(page, playing)
    page.locator(f"#{name}-open").click()
    until(page, f"!{playing}")
    page.keyboard.press("Escape")
    until(page, playing)
    page.locator("#play").click()
    until(page, f"!{playing}")
    page.locator(f"#{name}-open").click()
    page.keyboard.press("Escape")
    until_drawn(page)
    assert not page.evaluate(playing), "a motion that the reader has paused stays paused"


def test_the_reader_can_turn_off_keys_of_one_letter(show_recording):
    page = show_recording()
    slow, box = page.locator("#slow"), page.locator("#shortcuts")
    page.keyboard.press("?")
    page.get_by_role("tab", name="Keys").click()
    box.uncheck()
    page.keyboard.press("Escape")
    until(page, "!document.getElementById('help').open")
    page.keyboard.press("s")
    assert slow.is_checked()
    page.keyboard.press("End")
    until(page, "document.getElementById('scrub').value === '2'")
    page.reload()
    assert not box.is_checked()
    page.locator("#help-open").click()
    page.get_by_role("tab", name="This page").press("ArrowRight")
    box.check()
    page.keyboard.press("Escape")
    page.keyboard.press("s")
    assert not slow.is_checked()

"""The page in a browser: it plays, it jumps, it is slow at impacts, on a phone and in the dark."""

import io
import re

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from chain_impact import load_scene, simulate
from chain_impact.results.animate import animate
from chain_impact.results.impacts import IMPACT_DTYPE
from chain_impact.results.recording import Recording
from chain_impact.scene.half_planes import half_planes
from chain_impact.studies.animate import record_slowly
from tests.tiers import needs_browser

pytestmark = needs_browser
DESK, PHONE = {"width": 1280, "height": 760}, {"width": 390, "height": 844}
TIME_TEXT = "document.getElementById('time').textContent"
LIGHT_CHAIN, DARK_CHAIN = "#2b4a9f", "#9db4ff"


@pytest.fixture(scope="module")
def recording():
    return record_slowly(load_scene("four_link_box"))


@pytest.fixture(scope="module")
def address(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "box.html"
    animate(recording, path)
    return path.as_uri()


@pytest.fixture(scope="module")
def pinned_arm(tmp_path_factory):
    path = tmp_path_factory.mktemp("arm") / "arm.html"
    animate(record_slowly("pinned_arm"), path)
    return path.as_uri()


@pytest.fixture
def show(browser, address):
    """Open the page, which must not complain, nor ask for anything; its clock may be ``stopped``."""
    said, opened = [], []

    def show(viewport=DESK, motion="reduce", address=address, stopped=False, **options):
        page = browser.new_page(viewport=viewport, reduced_motion=motion, **options)
        opened.append(page)
        if stopped:
            page.clock.install(time=0)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: said.append(request.url) if request.url != address else None)
        page.goto(address)
        if stopped:
            page.clock.pause_at(60)
        else:
            page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
        return page

    yield show
    for page in opened:
        page.close()
    assert [text for text in said if not text.startswith("data:")] == []


def time_after(page, milliseconds):
    """The simulated time that is shown after some time on the page's own clock, which stands still."""
    page.clock.run_for(milliseconds)
    return float(page.evaluate(TIME_TEXT).removesuffix(" s"))


def time_of(page):
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return float(page.evaluate(TIME_TEXT).removesuffix(" s"))


def press(page, key):
    """The simulated time that is shown after a key."""
    page.keyboard.press(key)
    return time_of(page)


def go_to(page, time):
    """The simulated time that is shown after a move of the slider."""
    page.get_by_role("slider", name="Time").fill(time)
    return time_of(page)


def pixels(page):
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(float)


def count_of(picture, colour):
    return int((abs(picture - 255 * np.array(mpl.colors.to_rgb(colour))).max(axis=-1) < 6).sum())


# --- playing ---------------------------------------------------------------------------------------------


def test_it_plays_on_its_own_and_pauses(show):
    page = show(motion="no-preference", stopped=True)
    page.clock.run_for(200)
    page.get_by_role("button", name="Pause").click()
    stopped = time_after(page, 50)
    assert stopped > 0.1
    assert time_after(page, 500) == stopped
    page.keyboard.press("Space")  # the button has the focus and takes it
    assert time_after(page, 100) > stopped


def test_it_stands_still_for_who_asked_for_less_motion(show):
    page = show(stopped=True)
    assert time_after(page, 500) == 0.0
    page.get_by_role("button", name="Play").click()
    assert time_after(page, 500) > 0.05


def test_the_chain_moves_on_the_screen(show):
    page = show()
    before = pixels(page)
    press(page, "End")
    after = pixels(page)
    assert count_of(before, LIGHT_CHAIN) > 1000
    assert count_of(after, LIGHT_CHAIN) > 1000
    assert (abs(before - after).max(axis=-1) > 50).sum() > 2000


def test_it_stops_at_the_end_and_starts_anew(show):
    page = show(stopped=True)
    page.keyboard.press("End")
    assert time_after(page, 50) == 2.0
    page.keyboard.press("Space")
    assert 0.0 < time_after(page, 100) < 1.0


def test_positions_alone_make_a_page(show, tmp_path):
    """Of a table with nothing but positions: no walls, no impacts, no energies."""
    time = np.linspace(0.0, 1.0, 20)
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(time), "point[1].y": np.sin(time)}
    animate(Recording("Bare", time, columns), tmp_path / "bare.html")
    page = show(address=(tmp_path / "bare.html").as_uri())
    page.keyboard.press("End")
    assert press(page, "Shift+ArrowLeft") == 0.0
    assert page.locator("h2:visible").all_inner_texts() == ["Impacts"]
    assert page.inner_text("#impacts") == "none"


def test_impacts_between_two_rows_are_in_the_list(show, tmp_path):
    coarse = simulate(load_scene("four_link_box"), output_step=5e-3)
    coarse.animate(tmp_path / "coarse.html")
    page = show(address=(tmp_path / "coarse.html").as_uri())
    press(page, "Shift+ArrowRight")
    assert page.locator("#impacts tbody tr").count() == 14
    peak = f"{coarse.impacts['peak_force'][0] / 1e3:.1f}\u202fkN"
    assert peak in page.inner_text("#impacts tr[aria-current]")


# --- jumping ---------------------------------------------------------------------------------------------


def test_a_click_on_an_impact_goes_to_its_moment(show, recording):
    page = show()
    for number in (3, 14, 1):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        impact = recording.impacts[number - 1]
        assert time_of(page) == pytest.approx(impact["onset"], abs=2e-5)
        assert (
            f"Impact {number} of 14: point {impact['point']} at {recording.wall_names[impact['wall']]}"
            in page.inner_text("#caption")
        )
        assert page.inner_text("tr[aria-current] button") == str(number)


def test_keys_go_from_impact_to_impact(show, recording):
    page = show()
    times = [press(page, key) for key in ["Shift+ArrowRight"] * 3 + ["Shift+ArrowLeft"]]
    expected = recording.impacts["onset"][[0, 1, 2, 1]].tolist()
    assert times == pytest.approx(expected, abs=2e-5)
    assert press(page, "Home") == 0.0


def test_arrow_keys_step_in_time_on_the_screen(show):
    page = show()
    assert press(page, "ArrowRight") == pytest.approx(1 / 30, rel=0.01)
    assert press(page, "ArrowLeft") == 0.0
    # nothing is kept of steps beyond either end: the next one back is seen at once
    assert [press(page, "ArrowLeft") for _ in range(3)] == [0.0] * 3
    assert press(page, "ArrowRight") == pytest.approx(1 / 30, rel=0.01)
    end = press(page, "End")
    assert [press(page, "ArrowRight") for _ in range(3)] == [end] * 3
    assert press(page, "ArrowLeft") < end


def test_the_slider_and_the_chart_go_to_a_time(show):
    page = show()
    assert go_to(page, "1.25") == pytest.approx(1.25, abs=1e-4)
    box = page.locator("#energy .u-over").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 4, box["y"] + 20)
    assert time_of(page) == pytest.approx(0.5, abs=0.01)


# --- slow motion, forces, energies -----------------------------------------------------------------------


def test_time_is_slow_at_an_impact_and_real_in_flight(show):
    page = show()
    page.keyboard.press("ArrowRight")
    assert page.inner_text("#rate") == "real time"
    page.keyboard.press("Shift+ArrowRight")
    press(page, "ArrowRight")
    # 0.6 s for an impact of 0.3 ms to 3 ms
    assert 200 < int(re.fullmatch(r"(\d+) × slower", page.inner_text("#rate"))[1]) < 2000
    press(page, "s")
    assert page.inner_text("#rate") == "real time"


def test_the_clock_passes_as_it_says(show):
    """For a third of a second on the screen: at an impact some tenths of a millisecond, else as long."""
    page = show(stopped=True)
    passed = []
    for key in ("Shift+ArrowRight", "s"):
        page.keyboard.press(key)
        before = time_after(page, 50)
        page.keyboard.press("Space")
        page.clock.run_for(330)
        page.keyboard.press("Space")
        passed.append(time_after(page, 50) - before)
    assert 1e-5 < passed[0] < 3e-3
    assert passed[1] == pytest.approx(0.33, abs=0.05)


def test_the_force_is_an_arrow_from_the_wall_and_a_curve(show):
    page = show()
    assert page.locator(".arrow").count() == 0
    page.keyboard.press("Shift+ArrowRight")
    for _ in range(6):
        press(page, "ArrowRight")
    (arrow,) = page.locator(".arrow").all()
    assert float(arrow.get_attribute("y2")) < float(arrow.get_attribute("y1"))  # up, from the floor
    assert arrow.get_attribute("x2") == arrow.get_attribute("x1")
    assert re.fullmatch(r"[\d.]+\skN", page.text_content(".force-text"))
    assert page.text_content("#close-what").startswith("impact 1: point 2 at y_min, ")


def named(page):
    """The numbers of the impact that list, caption and force chart tell of."""
    return (
        int(page.inner_text("tr[aria-current] button")),
        int(re.match(r"Impact (\d+) of 14", page.inner_text("#caption"))[1]),
        int(re.match(r"impact (\d+): ", page.text_content("#close-what"))[1]),
    )


def test_list_caption_and_force_chart_name_the_same_impact_at_every_moment(show, recording):
    """Before its onset it is the next one, from the middle of the time since the end of the one before."""
    page = show()
    second, third = recording.impacts[1:3]
    middle = (second["end"] + third["onset"]) / 2
    assert named(page) == (1, 1, 1)
    page.get_by_role("button", name="Go to impact 2, ").click()
    seen, shown = set(), time_of(page)
    while shown < third["end"] + 1e-3:
        number, is_next = 2 + (shown >= middle), middle <= shown < third["onset"]
        assert named(page) == (number,) * 3
        assert (" is next: " in page.inner_text("#caption")) == is_next
        seen.add((number, is_next))
        page.keyboard.press("ArrowRight")
        shown = time_of(page)
    assert seen == {(2, False), (3, True), (3, False)}
    press(page, "End")
    assert named(page) == (14, 14, 14)


def twins(path, until_next=1e-3, force=1.0):
    """Write a page in which a second point touches a wall soon after the first; return its address."""
    time = np.linspace(0.0, 0.02, 401)
    columns = {f"point[{k}].{axis}": 0 * time + k * (axis == "x") for k in (0, 1) for axis in "xy"}
    onsets = [0.01, 0.01 + until_next]
    for k, onset in enumerate(onsets):
        columns[f"contact[{k}].y_min.force"] = force * np.maximum(0.0, 1.0 - abs(time - onset - 1e-3) / 1e-3)
    impacts = np.zeros(len(onsets), IMPACT_DTYPE)
    impacts["onset"], impacts["point"], impacts["impact_speed"] = onsets, range(len(onsets)), 1.0
    impacts["end"], impacts["peak_force"] = impacts["onset"] + 2e-3, force
    animate(Recording("Twins", time, columns, impacts, half_planes({"y_min": 0.0}, {}), ("y_min",)), path)
    return path.as_uri()


@pytest.mark.parametrize("until_next", [1e-3, 0.0])
def test_of_contacts_that_overlap_the_latest_is_named(show, tmp_path, until_next):
    """Where both begin at once, it is the one whose button was pressed."""
    page = show(address=twins(tmp_path / "twins.html", until_next))
    for number in (1, 2, 1):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        time_of(page)
        assert page.inner_text("tr[aria-current] button") == str(number)
        assert page.inner_text("#caption").startswith(f"Impact {number} of 2: point {number - 1} ")
        assert page.text_content("#close-what").startswith(f"impact {number}: point {number - 1} ")
    go_to(page, "0.0125")
    assert page.inner_text("tr[aria-current] button") == "2"


def test_the_labels_of_a_force_are_not_cut_off(show, tmp_path):
    page = show(address=twins(tmp_path / "faint.html", force=2.345e-4))
    go_to(page, "0.011")
    picture = pixels(page.locator("#force canvas"))
    assert picture.min() < 128.0
    assert (picture[:, :2] == picture[0, 0]).all()


def test_the_ledger_is_that_of_the_recording(show, recording):
    page = show()
    go_to(page, "0.9")
    names, values = (page.locator(f"#energies {tag}").all_inner_texts() for tag in ("dt", "dd"))
    shown = dict(zip(names, values, strict=True))
    for name in ("kinetic", "potential", "dissipated", "total"):
        expected = np.interp(0.9, recording.time, recording.columns[f"energy.{name}"])
        assert float(shown[name]) == pytest.approx(expected, abs=0.02)


def test_the_speed_is_chosen_by_list_and_keys(show):
    page = show()
    page.get_by_label("Speed").select_option("½ ×")
    time_of(page)
    assert page.inner_text("#rate") == "2 × slower"
    page.locator("h1").click()
    page.get_by_label("Speed").evaluate("(select) => select.blur()")
    page.keyboard.press("ArrowUp")
    press(page, "ArrowUp")
    assert page.inner_text("#rate") == "2 × faster"


def test_the_trace_can_be_left_out(show):
    page = show()
    go_to(page, "0.9")
    assert len(page.get_attribute(".trace", "points")) > 1000
    press(page, "t")
    assert len(page.get_attribute(".trace", "points")) < 100


def test_help_opens_and_keys_rest_while_it_is_open(show):
    page = show()
    page.keyboard.press("?")
    assert page.get_by_role("dialog").is_visible()
    assert press(page, "End") == 0.0
    page.keyboard.press("Escape")
    assert not page.get_by_role("dialog").is_visible()


# --- how it looks ----------------------------------------------------------------------------------------


def test_it_is_dark_where_that_is_wanted_and_changes_while_open(show):
    page = show(color_scheme="dark")
    dark = pixels(page)
    assert np.median(dark) < 60
    assert count_of(dark, DARK_CHAIN) > 1000
    page.emulate_media(color_scheme="light", reduced_motion="reduce")
    time_of(page)
    assert np.median(pixels(page)) > 200


@pytest.mark.parametrize("viewport", [PHONE, {"width": 320, "height": 568}, {"width": 844, "height": 390}])
def test_on_a_phone_all_fits_the_width_and_the_controls_are_in_sight(show, viewport):
    page = show(viewport, has_touch=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
    for name in ("Previous impact", "Play", "Next impact"):
        box = page.get_by_role("button", name=name, exact=True).bounding_box()
        assert box["y"] + box["height"] <= viewport["height"]
        assert min(box["width"], box["height"]) >= 36
    assert count_of(pixels(page), LIGHT_CHAIN) > 150


@pytest.mark.parametrize("viewport", [DESK, PHONE, {"width": 844, "height": 390}])
def test_the_chain_never_comes_under_the_scale_bar(show, viewport, pinned_arm):
    page = show(viewport, address=pinned_arm)
    press(page, "End")
    bar, trace, mark = (page.locator(kind).first.bounding_box() for kind in (".bar", ".trace", ".pin"))
    lowest = bar["y"] + bar["height"]
    assert min(trace["y"], mark["y"]) > lowest
    places = [dot.bounding_box()["y"] for dot in page.locator(".joint").all()]
    assert min(places) > lowest


def test_a_pinned_base_stands_on_ground_and_a_free_one_does_not(show, pinned_arm):
    page = show(address=pinned_arm)
    joint = page.locator(".joint").first.bounding_box()
    lines = [line.bounding_box() for line in page.locator(".pin").all()]
    left, right = min(b["x"] for b in lines), max(b["x"] + b["width"] for b in lines)
    assert (left + right) / 2 == pytest.approx(joint["x"] + joint["width"] / 2, abs=3.0)
    assert max(b["y"] + b["height"] for b in lines) < joint["y"] + joint["height"]  # above a chain that hangs
    assert show().locator(".pin").count() == 0


def test_everything_that_can_be_used_has_a_name_and_gets_the_focus(show):
    page = show()
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

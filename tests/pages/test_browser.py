"""A recording's page in a browser: playback, jumps, slow motion at impacts, a phone and the dark theme."""

import io
import math
import re

import matplotlib as mpl
import numpy as np
import pytest
from PIL import Image

from chain_impact import load_scene, simulate
from chain_impact.pages.recorded import program
from chain_impact.recording.impacts import IMPACT_DTYPE
from chain_impact.recording.recording import Recording
from chain_impact.results.animate import animate
from chain_impact.scene.half_planes import half_planes
from chain_impact.studies.animate import record_slowly
from tests.helpers.friction import SLOPE, pendulum, sled
from tests.helpers.stops import knee
from tests.pages.conftest import DESK, ON_ITS_SIDE, PHONE
from tests.tiers import needs_browser

pytestmark = needs_browser
TIME_TEXT = "document.getElementById('time').textContent"
LIGHT_CHAIN, DARK_CHAIN = "#2b4a9f", "#9db4ff"
SLIDES, STICKS = 0.5, 1.5  # s, of the sled
WEIGHT = 1.2 * 9.81  # N


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
def show(open_page, address, tmp_path):
    """Open the page of the box with four links, or of another recording."""

    def show(recording=None, address=address, **options):
        if recording is not None:
            animate(recording, tmp_path / "page.html")
            address = (tmp_path / "page.html").as_uri()
        return open_page(address, **options)

    return show


def time_after(page, milliseconds):
    """Return the simulated time that is shown after some time on the page's own clock, which stands still."""
    page.clock.run_for(milliseconds)
    return float(page.evaluate(TIME_TEXT).removesuffix(" s"))


def time_of(page):
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return float(page.evaluate(TIME_TEXT).removesuffix(" s"))


def press(page, key):
    """Return the simulated time that is shown after a key."""
    page.keyboard.press(key)
    return time_of(page)


def go_to(page, time):
    """Return the simulated time that is shown after a move of the slider."""
    page.locator("#scrub").evaluate(
        "(e, t) => { e.value = t; e.dispatchEvent(new Event('input', { bubbles: true })); }", time
    )
    return time_of(page)


def pixels(page):
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(float)


def count_of(picture, colour):
    return int((abs(picture - 255 * np.array(mpl.colors.to_rgb(colour))).max(axis=-1) < 6).sum())


# --- playing ---------------------------------------------------------------------------------------------


def test_it_plays_on_its_own_and_pauses(show):
    page = show(reduced_motion="no-preference", stopped=True)
    page.clock.run_for(200)
    page.get_by_role("button", name="Pause").click()
    stopped = time_after(page, 50)
    assert stopped > 0.1
    assert time_after(page, 500) == stopped
    page.keyboard.press("Space")  # the focused button receives the key
    assert time_after(page, 100) > stopped


def test_it_stands_still_for_who_asked_for_less_motion_and_its_clock_passes_as_it_says(show):
    """In 1/3 s: a fraction of a millisecond at an impact, otherwise as long or twice as long."""
    page = show(stopped=True)
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
        before = time_after(page, 50)
        page.keyboard.press("Space")
        page.clock.run_for(330)
        page.keyboard.press("Space")
        passed.append(time_after(page, 50) - before)
    assert 1e-5 < passed[0] < 3e-3
    assert passed[1:] == pytest.approx([0.33, 0.66], abs=0.05)


def test_positions_alone_make_a_page(show):
    """The table has positions only: no walls, no impacts, no energies."""
    time = np.linspace(0.0, 1.0, 20)
    columns = {"point[0].x": 0 * time, "point[0].y": 0 * time}
    columns |= {"point[1].x": np.cos(time), "point[1].y": np.sin(time)}
    page = show(Recording("Bare", time, columns))
    page.keyboard.press("End")
    assert press(page, "Shift+ArrowLeft") == 0.0
    assert page.locator("h2:visible").all_inner_texts() == ["Impacts"]
    assert page.inner_text("#impacts") == "none"


def test_energies_below_zero_have_as_many_digits_as_those_above(show):
    time = np.linspace(0.0, 1.0, 20)
    columns = {f"point[{k}].{axis}": k + 0 * time for k in (0, 1) for axis in "xy"}
    columns |= {"energy.potential": -1234.5 + time}
    assert show(Recording("Deep", time, columns)).inner_text("#energies dd") in ("-1234", "-1235")


def test_impacts_between_two_rows_are_in_the_list(show):
    coarse = simulate(load_scene("four_link_box"), output_step=5e-3)
    page = show(coarse)
    press(page, "Shift+ArrowRight")
    assert page.locator("#impacts tbody tr").count() == 14
    peak = f"{coarse.impacts['peak_force'][0] / 1e3:.1f}\u202fkN"
    assert peak in page.inner_text("#impacts tr[aria-current]")


# --- jumping ---------------------------------------------------------------------------------------------


def test_clicks_keys_slider_and_chart_go_to_a_moment(show, recording):
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
    assert press(page, "Home") == 0.0
    times = [press(page, key) for key in ["Shift+ArrowRight"] * 3 + ["Shift+ArrowLeft"]]
    assert times == pytest.approx(recording.impacts["onset"][[0, 1, 2, 1]].tolist(), abs=2e-5)
    assert go_to(page, 1.25) == pytest.approx(1.25, abs=1e-4)
    box = page.locator("#energy .u-over").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 4, box["y"] + 20)
    assert time_of(page) == pytest.approx(0.5, abs=0.01)


def test_arrow_keys_step_in_time_on_the_screen(show):
    page = show()
    assert press(page, "ArrowRight") == pytest.approx(1 / 30, rel=0.01)
    assert press(page, "ArrowLeft") == 0.0
    # steps beyond either end have no effect: the next step back is visible at once
    assert [press(page, "ArrowLeft") for _ in range(3)] == [0.0] * 3
    assert press(page, "ArrowRight") == pytest.approx(1 / 30, rel=0.01)
    end = press(page, "End")
    assert [press(page, "ArrowRight") for _ in range(3)] == [end] * 3
    assert press(page, "ArrowLeft") < end


# --- slow motion, forces, energies -----------------------------------------------------------------------


def test_what_is_shown_of_time_force_energies_and_trace(show, recording):
    page = show()
    before = pixels(page)
    assert [page.locator(kind).count() for kind in (".joint", ".tip")] == [4, 1]
    assert page.locator(".arrow").count() == page.locator(".pin").count() == 0
    press(page, "ArrowRight")
    assert page.inner_text("#rate") == "real time"
    press(page, "Shift+ArrowRight")
    # 0.6 s for an impact of 0.3 ms to 3 ms
    assert 200 < int(re.fullmatch(r"(\d+) × slower", page.inner_text("#rate"))[1]) < 2000
    for _ in range(6):
        press(page, "ArrowRight")
    (arrow,) = page.locator(".arrow").all()
    assert float(arrow.get_attribute("y2")) < float(arrow.get_attribute("y1"))  # up, from the floor
    assert arrow.get_attribute("x2") == arrow.get_attribute("x1")
    assert re.fullmatch(r"[\d.]+\skN", page.text_content(".force-text"))
    assert page.text_content("#close-what").startswith("impact 1: point 2 at y_min, ")
    press(page, "s")
    assert page.inner_text("#rate") == "real time"
    go_to(page, 0.9)
    names, values = (page.locator(f"#energies {tag}").all_inner_texts() for tag in ("dt", "dd"))
    shown = dict(zip(names, values, strict=True))
    for name in ("kinetic", "potential", "dissipated", "total"):
        expected = np.interp(0.9, recording.time, recording.columns[f"energy.{name}"])
        assert float(shown[name]) == pytest.approx(expected, abs=0.02)
    assert len(page.get_attribute(".trace", "points")) > 1000
    press(page, "t")
    assert len(page.get_attribute(".trace", "points")) < 100
    press(page, "End")
    after = pixels(page)
    assert min(count_of(picture, LIGHT_CHAIN) for picture in (before, after)) > 1000
    assert (abs(before - after).max(axis=-1) > 50).sum() > 2000, "the chain moves"


def named(page):
    """Return the numbers of the impact in the list, the caption and the force chart."""
    return (
        int(page.inner_text("tr[aria-current] button")),
        int(re.match(r"Impact (\d+) of 14", page.inner_text("#caption"))[1]),
        int(re.match(r"impact (\d+): ", page.text_content("#close-what"))[1]),
    )


def test_list_caption_and_force_chart_name_the_same_impact_at_every_moment(show, recording):
    """From halfway between two impacts, the next impact is named before its onset."""
    page = show()
    second, third = recording.impacts[1:3]
    middle = (second["end"] + third["onset"]) / 2
    assert named(page) == (1, 1, 1)
    page.get_by_role("button", name="Go to impact 2, ").click()
    seen, shown = set(), time_of(page)
    between = np.linspace(shown, third["end"] + 1e-3, 12)
    for wanted in [shown, *between, middle - 1e-4, middle + 1e-4]:
        shown = go_to(page, wanted) if wanted != shown else shown
        number, is_next = 2 + (shown >= middle), middle <= shown < third["onset"]
        assert named(page) == (number,) * 3
        assert (" is next: " in page.inner_text("#caption")) == is_next
        seen.add((number, is_next))
    assert seen == {(2, False), (3, True), (3, False)}
    press(page, "End")
    assert named(page) == (14, 14, 14)


def twins(until_next=1e-3, force=1.0):
    """Return a second point touches a wall soon after the first."""
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
def test_of_contacts_that_overlap_the_latest_is_named(show, until_next):
    """If two contacts begin at the same time, the page names the contact whose button was pressed."""
    page = show(twins(until_next))
    for number in (1, 2, 1):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        time_of(page)
        assert page.inner_text("tr[aria-current] button") == str(number)
        assert page.inner_text("#caption").startswith(f"Impact {number} of 2: point {number - 1} ")
        assert page.text_content("#close-what").startswith(f"impact {number}: point {number - 1} ")
    go_to(page, 0.0125)
    assert page.inner_text("tr[aria-current] button") == "2"


def test_the_labels_of_a_force_are_not_cut_off(show):
    page = show(twins(force=2.345e-4))
    go_to(page, 0.011)
    picture = pixels(page.locator("#force canvas"))
    assert picture.min() < 128.0
    assert (picture[:, :2] == picture[0, 0]).all()


def test_a_long_list_ends_with_how_many_more_there_are(open_page):
    page = open_page("about:blank", begins=False)
    page.set_content(f"<script>{program('player/impact_list.js')}</script>")
    made = """(count) => {
      const impact = (k) => ({ onset: k / count, what: "point 1", wall: "y_min", speed: 1, peak: 2 });
      const element = document.body.appendChild(document.createElement("div"));
      const impacts = Array.from({ length: count }, (_, k) => impact(k));
      new ImpactList(element, () => {}).show({ impacts });
      return [element.querySelectorAll("tbody tr").length, element.lastChild.textContent];
    }"""
    assert page.evaluate(made, 2345) == [2000, "and 345 more, which the animation shows"]
    rows, table = page.evaluate(made, 2000)
    assert rows == 2000
    assert "more" not in table


# --- dry friction, and stops of joints -------------------------------------------------------------------


def lean(page):
    """Return the angle [rad] from upright of the arrow of the first force, positive to the left."""
    x1, y1, x2, y2 = (
        float(page.locator("line.arrow").first.get_attribute(name)) for name in ("x1", "y1", "x2", "y2")
    )
    return math.atan2(x1 - x2, y1 - y2)


def test_arrows_lean_against_the_motion_and_a_bar_shows_what_sticks(show):
    page = show(record_slowly(sled()))
    go_to(page, SLIDES)
    assert lean(page) == pytest.approx(math.atan(0.5) - SLOPE, abs=0.01)
    assert page.locator(".stick-bar").count() == 0
    go_to(page, STICKS)
    assert lean(page) == pytest.approx(0.0, abs=0.01), "it holds the weight"
    assert page.locator(".stick-bar").count() == 2
    told = [float(re.match(r"[\d.]+", text)[0]) for text in page.locator(".force-text").all_text_contents()]
    assert told == pytest.approx([0.5 * WEIGHT] * 2, abs=0.01)
    assert page.text_content("#close-what").endswith("brown: friction")
    assert "friction" in page.text_content("#energies")


def test_forces_in_joints_are_arrows_with_a_key(show):
    recording = record_slowly(load_scene("pinned_arm").with_values({"outputs.loads": True}))
    page, forces = show(recording), np.array(list(recording.loads.values()))
    sizes = np.hypot(forces[..., 0], forces[..., 1])
    joint, row = np.unravel_index(sizes.argmax(), sizes.shape)
    go_to(page, recording.time[row])
    assert page.locator(".key").all_text_contents() == ["➝ joint", "➝ wall"]
    assert page.locator("line.arrow.load").count() == len(recording.loads) == 2
    told = page.text_content(".force-text.load")
    assert float(re.match(r"[\d.]+", told)[0]) == pytest.approx(sizes.max(), rel=0.02)
    arrow = page.locator("line.arrow.load").nth(joint)
    x1, y1, x2, y2 = (float(arrow.get_attribute(name)) for name in ("x1", "y1", "x2", "y2"))
    along, up = forces[joint, row]
    assert math.atan2(y1 - y2, x2 - x1) == pytest.approx(math.atan2(up, along), abs=0.02)


def test_a_full_dot_shows_a_joint_that_sticks(show):
    page = show(record_slowly(pendulum()))
    for time, count in ((0.2, 0), (0.6, 1), (3.0, 2)):
        go_to(page, time)
        assert page.locator(".stuck-joint").count() == count


def test_a_joint_with_stops_has_an_arc_and_its_impacts_are_told_in_the_units_of_the_angle(show):
    page = show(record_slowly(knee()))
    assert page.locator("polyline.range").count() == 1
    assert page.locator("polyline.range-mark").count() == 2
    assert page.locator(".stop-dot").count() == 0, "in flight"
    rows = page.locator("tbody tr").all_inner_texts()
    assert all(text in rows[0] for text in ("joint_min", "rad/s", "N·m"))
    wall = next(row for row in rows if "x_max" in row)
    assert "m/s" in wall
    assert "N·m" not in wall
    page.get_by_role("button", name="Go to impact 1, ").click()
    for _ in range(4):
        press(page, "ArrowRight")
    assert page.locator(".stop-dot").count() == 1
    assert page.locator(".force-text").text_content().endswith("N·m")
    assert page.inner_text("#caption").startswith("Impact 1 of ")
    assert ": joint 2 at joint_min, " in page.inner_text("#caption")
    assert "joint 2 at joint_min" in page.text_content("#close-what")


# --- how it is used, and how it looks --------------------------------------------------------------------


def test_speed_help_and_what_has_the_focus(show):
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


def test_it_is_dark_where_that_is_wanted_and_changes_while_open(show):
    page = show(color_scheme="dark")
    dark = pixels(page)
    assert np.median(dark) < 60
    assert count_of(dark, DARK_CHAIN) > 1000
    page.emulate_media(color_scheme="light", reduced_motion="reduce")
    time_of(page)
    assert np.median(pixels(page)) > 200


@pytest.mark.parametrize("viewport", [PHONE, {"width": 320, "height": 568}, ON_ITS_SIDE])
def test_on_a_phone_all_fits_the_width_and_the_controls_are_in_sight(show, viewport):
    page = show(viewport=viewport, has_touch=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
    for name in ("Previous impact", "Play", "Next impact"):
        box = page.get_by_role("button", name=name, exact=True).bounding_box()
        assert box["y"] + box["height"] <= viewport["height"]
        assert min(box["width"], box["height"]) >= 32
    assert count_of(pixels(page), LIGHT_CHAIN) > 150


@pytest.mark.parametrize("viewport", [DESK, PHONE, ON_ITS_SIDE])
def test_the_chain_never_comes_under_the_scale_bar_and_a_pinned_base_stands_on_ground(
    show, viewport, pinned_arm
):
    page = show(address=pinned_arm, viewport=viewport)
    joint = page.locator(".joint").first.bounding_box()
    lines = [line.bounding_box() for line in page.locator(".pin").all()]
    left, right = min(b["x"] for b in lines), max(b["x"] + b["width"] for b in lines)
    assert (left + right) / 2 == pytest.approx(joint["x"] + joint["width"] / 2, abs=3.0)
    assert max(b["y"] + b["height"] for b in lines) < joint["y"] + joint["height"]  # above a hanging chain
    press(page, "End")
    bar, trace, mark = (page.locator(kind).first.bounding_box() for kind in (".bar", ".trace", ".pin"))
    lowest = bar["y"] + bar["height"]
    assert min(trace["y"], mark["y"]) > lowest
    assert min(dot.bounding_box()["y"] for dot in page.locator(".joint").all()) > lowest


def test_the_ground_mark_goes_with_a_base_that_moves(show):
    way = {"base.x": lambda t: 0.3 * math.sin(t)}
    scene = load_scene("pinned_arm").with_values({"inputs.base_motion": True})
    page = show(record_slowly(scene, inputs=way))
    for time in (0.0, 0.9, 1.8):
        go_to(page, time)
        support = page.locator("polyline.pin").first.get_attribute("points").split()[0]
        base = page.locator("#scene circle.joint").first
        for at, axis in zip(support.split(","), ("cx", "cy"), strict=True):
            assert float(at) == pytest.approx(float(base.get_attribute(axis)), abs=0.1)

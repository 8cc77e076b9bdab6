"""The drawing of a recording: arrows of forces and their scale, friction, stops and the trace."""

# Tests: pages/browser/drawing/chain_drawing.js, pages/browser/drawing/trace.js
# Tests: pages/browser/drawing/scale_strip.js, pages/browser/drawing/slider_rail.js

import math
import re

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.results.animation import write_animation
from chain_impact.studies.animate import record_slowly
from tests.helpers.scenes.friction import SLOPE, pendulum, sled
from tests.helpers.scenes.stops import knee_scene
from tests.pages.in_pages import (
    DESK,
    LIGHT_CHAIN,
    ON_ITS_SIDE,
    ON_OTHERS,
    PHONE,
    count_of,
    go_to,
    pixels,
    press,
    until,
)
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
LENGTHS = function_of("drawing", "lengths")
SELECTED = "getSelection().toString()"
RULER = """() => [...document.querySelectorAll('.ruler-text')].map((text) =>
  [text.textContent, text.x.baseVal[0].value - document.querySelector('.ruler').x1.baseVal.value])"""
SLIDES, STICKS = 0.5, 1.5  # s, of the sled
WEIGHT = 1.2 * 9.81  # N


@pytest.fixture(scope="module")
def pinned_arm(tmp_path_factory):
    path = tmp_path_factory.mktemp("arm") / "arm.html"
    write_animation(record_slowly("pinned_arm"), path)
    return path.as_uri()


def test_the_page_shows_time_forces_energies_and_the_trace(show_recording, recording):
    page = show_recording()
    picture_before = pixels(page)
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
    assert page.text_content("#contact-name").startswith("impact\u00a01: point 2 at the floor, ")
    press(page, "s")
    assert page.inner_text("#rate") == "real time"
    go_to(page, 0.9)
    names, values = (page.locator(f"#energies {tag}").all_inner_texts() for tag in ("dt", "dd"))
    energies = dict(zip(names, values, strict=True))
    for name in ("kinetic", "potential", "dissipated", "total"):
        expected = np.interp(0.9, recording.time, recording.columns[f"energy.{name}"])
        assert float(energies[name]) == pytest.approx(expected, abs=0.02)
    assert len(page.get_attribute(".trace", "points")) > 1000
    press(page, "t")
    assert len(page.get_attribute(".trace", "points")) < 100
    press(page, "End")
    picture_after = pixels(page)
    assert min(count_of(picture, LIGHT_CHAIN) for picture in (picture_before, picture_after)) > 1000
    assert (abs(picture_before - picture_after).max(axis=-1) > 50).sum() > 2000, "the chain moves"


def lean(page):
    """Return the angle [rad] from upright of the arrow of the first force, positive to the left."""
    x1, y1, x2, y2 = (
        float(page.locator("line.arrow").first.get_attribute(name)) for name in ("x1", "y1", "x2", "y2")
    )
    return math.atan2(x1 - x2, y1 - y2)


@pytest.mark.parametrize("opened", ["show", "show_recording"])
def test_a_ball_is_a_circle_with_the_trace_of_its_centre(request, opened):
    """The mark on the ball, at the end of its link, has no dot and no trace."""
    model = "ramp" if opened == "show" else record_slowly("ramp")
    page = request.getfixturevalue(opened)(model)
    go_to(page, 1.0)
    assert [page.locator(kind).count() for kind in (".disc", ".tip", ".joint", ".link", ".radius")] == [
        1,
        1,
        0,
        0,
        1,
    ]
    centres = page.evaluate(
        "['.disc', '.tip'].map((kind) => document.querySelector(kind)).map(({ cx, cy }) => [cx, cy])"
        ".map((pair) => pair.map(({ baseVal }) => baseVal.value))"
    )
    assert centres[0] == pytest.approx(centres[1])
    last = page.get_attribute(".trace", "points").split()[-1]
    assert [float(value) for value in last.split(",")] == pytest.approx(centres[0], abs=1.0)


@pytest.mark.parametrize("opened", ["show", "show_recording"])
def test_a_ball_without_a_radius_is_a_disc_without_a_line(request, opened):
    model = "bouncing_ball" if opened == "show" else record_slowly("bouncing_ball")
    page = request.getfixturevalue(opened)(model)
    go_to(page, 1.0)
    kinds = (".ball", ".tip", ".joint", ".link", ".radius", ".disc")
    assert [page.locator(f"#scene {kind}").count() for kind in kinds] == [1, 0, 0, 0, 0, 0]
    assert page.locator(".point-number").all_text_contents() == ["0", ""]
    last = page.get_attribute(".trace", "points").split()[-1]
    centre = page.locator(".ball").evaluate("({ cx, cy }) => [cx, cy].map(({ baseVal }) => baseVal.value)")
    assert [float(value) for value in last.split(",")] == pytest.approx(centre, abs=1.0)
    if opened == "show":
        page.get_by_role("button", name="Pin").click()
        page.evaluate("chainImpact.show({'contact.restitution': 0.5})")
        until(page, "document.querySelectorAll('.compared-tip').length === 1")
        assert page.locator("polyline.compared").count() == 0


def test_arrows_lean_against_the_motion_and_a_bar_shows_what_sticks(show_recording):
    page = show_recording(record_slowly(sled()))
    go_to(page, SLIDES)
    assert lean(page) == pytest.approx(math.atan(0.5) - SLOPE, abs=0.01)
    assert page.locator(".stick-bar").count() == 0
    go_to(page, STICKS)
    assert lean(page) == pytest.approx(0.0, abs=0.01), "it holds the weight"
    assert page.locator(".stick-bar").count() == 2
    forces = [float(re.match(r"[\d.]+", text)[0]) for text in page.locator(".force-text").all_text_contents()]
    assert forces == pytest.approx([0.5 * WEIGHT] * 2, abs=0.01)
    assert page.get_by_text("dotted: friction").is_visible()
    assert "friction" in page.text_content("#energies")


def test_forces_in_joints_are_arrows_with_a_key(show_recording):
    recording = record_slowly(load_scene("pinned_arm").with_values({"outputs.loads": True}))
    page, forces = show_recording(recording), np.array(list(recording.joint_forces.values()))
    (text,) = page.locator("#impacts tbody td:last-child").all_inner_texts()
    assert text == f"{recording.impacts['joint_force'][0]:.0f}"
    assert page.inner_text("#impacts th:last-child") == "in joint, N"
    ground, *keys = (mark.bounding_box() for mark in page.locator(".key-ground, .key").all())
    assert all(ground["x"] <= key["x"] for key in keys), "walls are not seen behind the legend"
    sizes = np.hypot(forces[..., 0], forces[..., 1])
    joint, row = np.unravel_index(sizes.argmax(), sizes.shape)
    go_to(page, recording.time[row])
    assert page.locator(".key").all_text_contents() == ["➝ joint", "➝ wall"]
    assert page.locator("line.arrow.load").count() == len(recording.joint_forces) == 2
    text = page.text_content(".force-text.load")
    assert float(re.match(r"[\d.]+", text)[0]) == pytest.approx(sizes.max(), rel=0.02)
    arrow = page.locator("line.arrow.load").nth(joint)
    x1, y1, x2, y2 = (float(arrow.get_attribute(name)) for name in ("x1", "y1", "x2", "y2"))
    force_x, force_y = forces[joint, row]
    assert math.atan2(y1 - y2, x2 - x1) == pytest.approx(math.atan2(force_y, force_x), abs=0.02)


def test_a_full_dot_shows_a_joint_that_sticks(show_recording):
    page = show_recording(record_slowly(pendulum()))
    for time, count in ((0.2, 0), (0.6, 1), (3.0, 2)):
        go_to(page, time)
        assert page.locator(".stuck-joint").count() == count


def test_a_joint_with_stops_has_an_arc_and_impacts_in_angles(show_recording):
    page = show_recording(record_slowly(knee_scene()))
    assert page.locator("polyline.range").count() == 1
    assert page.locator("polyline.range-mark").count() == 2
    assert page.locator(".stop-dot").count() == 0, "in flight"
    rows = page.locator("tbody tr").all_inner_texts()
    assert all(text in rows[0] for text in ("min", "rad/s", "N·m"))
    wall = next(row for row in rows if "right" in row)
    assert "m/s" in wall
    assert "N·m" not in wall
    page.get_by_role("button", name="Go to impact 1, ").click()
    for _ in range(4):
        press(page, "ArrowRight")
    assert page.locator(".stop-dot").count() == 1
    assert page.locator(".force-text").text_content().endswith("N·m")
    assert page.get_attribute("#caption", "title") == page.inner_text("#caption")
    assert page.inner_text("#caption").startswith("Impact 1 of ")
    assert page.inner_text("#caption").endswith(", joint 2 at min (point 1)")
    assert "joint 2 at min (point 1)" in page.text_content("#contact-name")


def test_the_scale_bar_is_free_and_a_pinned_base_has_ground(show_recording, pinned_arm):
    page = show_recording(address=pinned_arm)
    for viewport in (DESK, PHONE, ON_ITS_SIDE):
        page.set_viewport_size(viewport)
        press(page, "Home")
        joint = page.locator(".joint").first.bounding_box()
        lines = [line.bounding_box() for line in page.locator(".pin").all()]
        left_end, right_end = min(b["x"] for b in lines), max(b["x"] + b["width"] for b in lines)
        assert (left_end + right_end) / 2 == pytest.approx(joint["x"] + joint["width"] / 2, abs=3.0)
        joint_bottom = joint["y"] + joint["height"]
        assert max(b["y"] + b["height"] for b in lines) < joint_bottom, "the ground is above a hanging chain"
        press(page, "End")
        bar, trace, mark = (page.locator(kind).first.bounding_box() for kind in (".bar", ".trace", ".pin"))
        lowest = bar["y"] + bar["height"]
        assert min(trace["y"], mark["y"]) > lowest
        assert min(dot.bounding_box()["y"] for dot in page.locator(".joint").all()) > lowest


def test_the_ground_mark_goes_with_a_base_that_moves(show_recording):
    way = {"base.x": lambda t: 0.3 * math.sin(t)}
    scene = load_scene("pinned_arm").with_values({"inputs.base_motion": True})
    page = show_recording(record_slowly(scene, inputs=way))
    for time in (0.0, 0.9, 1.8):
        go_to(page, time)
        support = page.locator("polyline.pin").first.get_attribute("points").split()[0]
        base = page.locator("#scene circle.joint").first
        for at, axis in zip(support.split(","), ("cx", "cy"), strict=True):
            assert float(at) == pytest.approx(float(base.get_attribute(axis)), abs=0.1)


def newtons(text):
    """Return the force [N] in a text."""
    value, unit = text.split("\u202f")
    return float(value) * {"mN": 1e-3, "N": 1.0, "kN": 1e3, "MN": 1e6}[unit]


def test_arrows_show_a_weight_and_a_peak_with_a_ruler(show_recording):
    recording = record_slowly("thrown_brick")
    page, hardest = show_recording(recording), recording.impacts[recording.impacts["peak_force"].argmax()]
    marks = {newtons(text): at for text, at in page.evaluate(RULER)}
    top = max(marks)
    assert len(marks) > 1
    for force, at in marks.items():
        assert at == pytest.approx(marks[top] * (force / top) ** (1 / 3), abs=0.5)
    press(page, "End")
    lengths, texts = page.evaluate(LENGTHS), page.locator(".force-text").all_text_contents()
    for length, force in zip(sorted(lengths), sorted(map(newtons, texts)), strict=True):
        assert force < 1e-2 * hardest["peak_force"]
        assert length == pytest.approx(marks[top] * (force / top) ** (1 / 3), rel=0.01)
        assert length > 15.0  # pixels
    go_to(page, hardest["onset"] + 0.4 * (hardest["end"] - hardest["onset"]))
    assert 1.0 < max(page.evaluate(LENGTHS)) / max(lengths) < 10.0


def test_arrows_of_impulses_have_a_ruler_of_their_own(show_recording):
    """Whether a force is drawn at the same time decides on the ruler of a motion that has both."""
    table, rod = (record_slowly(model) for model in ("bouncing_table", "clattering_rod"))
    page = show_recording(table)
    for viewport in (DESK, PHONE):
        page.set_viewport_size(viewport)
        impact = table.impacts[0]
        go_to(page, impact["onset"] + 1e-3)
        marks = {newtons(text.removesuffix("·s")): at for text, at in page.evaluate(RULER)}
        top = max(marks)
        assert page.evaluate(LENGTHS) == [
            pytest.approx(marks[top] * (impact["impulse"] / top) ** (1 / 3), rel=0.01)
        ]
        assert page.text_content(".ruler-name").startswith("impulse")
        assert page.evaluate(ON_OTHERS) == []
    page = show_recording(rod)
    names = [page.text_content(".ruler-name")]
    go_to(page, rod.impacts["onset"][0] + 1e-3)
    names.append(page.text_content(".ruler-name"))
    press(page, "End")
    names.append(page.text_content(".ruler-name"))
    assert [name.removesuffix(" (cube root)") for name in names] == ["force", "impulse", "force"]


def test_a_drag_in_the_drawing_selects_no_text(show_recording):
    page = show_recording()
    box = page.locator("#view").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] - 20)
    page.mouse.down()
    page.mouse.move(box["x"] + 10, box["y"] + 8, steps=4)
    page.mouse.up()
    assert page.evaluate(SELECTED) == ""


@pytest.mark.parametrize("model", ["four_link_box", "thrown_brick", "cart_pole", "pinned_arm"])
def test_the_ruler_of_forces_is_apart_from_the_scale_bar(show_recording, model):
    page = show_recording(record_slowly(model))
    bars = "all => all.map((mark) => mark.x1.baseVal.value)"
    for viewport in (PHONE, ON_ITS_SIDE):
        page.set_viewport_size(viewport)
        press(page, "Shift+ArrowRight")
        assert page.evaluate(ON_OTHERS) == []
        assert len(page.evaluate(RULER)) > 1
        assert page.text_content(".ruler-name").startswith("force")
        marks = page.locator("line.bar:not(.ruler)").evaluate_all(bars)
        head = page.locator(".ruler-head").evaluate("head => Math.min(...[...head.points].map(({ x }) => x))")
        assert max(marks) < head - 4.0


def test_no_scale_bar_reaches_into_the_key(show_recording):
    scene = load_scene("pinned_arm").with_values({"outputs.loads": True})
    page, bar_counts = show_recording(record_slowly(scene), viewport={"width": 260, "height": 600}), set()
    for width in (260, 300, 420, 1100):
        page.set_viewport_size({"width": width, "height": 600})
        press(page, "ArrowRight")
        bars = [bar.bounding_box() for bar in page.locator("polyline.bar").all()]
        assert all(bar["x"] + bar["width"] <= page.locator(".key-ground").bounding_box()["x"] for bar in bars)
        assert page.locator(".bar-text").count() == len(bars)
        bar_counts.add(len(bars))
    assert bar_counts == {0, 1}


def test_no_force_is_written_on_the_rail_of_a_slider(show_recording):
    page = show_recording(record_slowly("cart_pole"), viewport=PHONE)
    texts = 0
    for _ in range(4):
        press(page, "Shift+ArrowRight")
        rail, *_ = page.locator("polyline.pin").all()
        bar = rail.bounding_box()
        for text in page.locator(".force-text").all():
            box = text.bounding_box()
            assert box["y"] > bar["y"] + bar["height"] or box["y"] + box["height"] < bar["y"] + 1
            texts += 1
    assert texts
    numbers = page.locator("#scene .point-number").all_text_contents()
    assert {"min −0.4\u202fm", "max 0.4\u202fm"} <= set(numbers), "positions of the carriage at its stops"
    notes = [note.bounding_box() for note in page.locator("#scene .rail-note").all()]
    assert max(note["y"] + note["height"] for note in notes) < bar["y"], "the pole hangs below the rail"
    shapes = page.locator("#scene :is(.link, .rail-note)").evaluate_all(
        "all => all.map(element => element.tagName)"
    )
    assert shapes[-2:] == ["text", "text"], "texts are in front of the pole"


def test_a_motion_without_forces_at_walls_has_no_ruler(show_recording):
    page = show_recording(record_slowly("kneed_leg"))
    press(page, "Shift+ArrowRight")  # to the impact, after which the stop holds the knee
    press(page, "ArrowRight")
    assert page.locator(".stop-dot").count() == 1, "a moment has no arrow"
    assert page.locator(".ruler, .ruler-text").count() == 0
    assert page.locator(".bar-text").count() == 1


def test_a_force_with_friction_says_so_beside_its_arrow(show_recording):
    """The list has the largest force at a right angle to the wall, which is smaller."""
    page = show_recording(record_slowly("thrown_brick"), viewport=PHONE)
    page.get_by_role("button", name="Go to impact 4, ").click()
    assert re.fullmatch(r"[\d.]+\skN with friction", page.text_content(".force-text"))
    name = page.locator("#contact-name")
    assert name.evaluate("element => element.scrollWidth <= element.clientWidth"), (
        "no word of the contact is cut"
    )
    legend, button = (
        page.locator(selector).bounding_box() for selector in ("#contact-legend", "#force-loop")
    )
    assert legend["x"] + legend["width"] < button["x"]


def test_a_wall_and_a_button_leave_the_motion_in_the_middle(show):
    page = show("pinned_arm", {"initial.angle[1]": np.pi / 3})
    view, button, wall = (
        page.locator(name).bounding_box() for name in ("#view", "#at-contact", "#scene .wall")
    )
    assert button["y"] + button["height"] <= view["y"]
    assert 0.6 < (wall["x"] - view["x"]) / view["width"] < 0.9
    base = page.locator("#scene .joint").first.bounding_box()
    assert base["x"] - view["x"] < 0.4 * view["width"]

"""The screen and its handles: dragging, the room, the trace, small screens, touch."""

# Tests: pages/browser/explore/handles.js, pages/browser/explore/handle_text.js

import re

import numpy as np
import pytest

from chain_impact import load_scene
from tests.pages.in_pages import DESK, ON_ITS_SIDE, PHONE, impacts_of, resize, until, until_drawn, until_text
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
AT_REST = {"initial.velocity": (0.0, 0.0), "initial.angular_velocities": (0.0,) * 4}
PLACES = """() => document.querySelector('.trace').getAttribute('points').trim().split(/\\s+/).map((place) =>
  place.split(',').map(Number))"""
IS_STILL = "document.getElementById('stage').ariaBusy === 'false'"


def settle(page):
    """Wait until the page has drawn the last change and finished the following run."""
    until_drawn(page)
    until(page, IS_STILL)


def middle(page, grip):
    """Return the middle of a grip [pixels], once the page is still: each run ends with all grips redrawn."""
    settle(page)
    grip_element = f"document.querySelector('[data-grip=\"{grip}\"]')"
    until(page, f"{grip_element} !== null")
    box = page.evaluate(f"{grip_element}.getBoundingClientRect().toJSON()")
    return np.array([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2])


def parameters(page):
    """Return name → value of all numbers among the parameters."""
    texts = page.evaluate("Object.entries(chainImpact.parameters)")
    return {name: float(text) for name, text in texts if re.fullmatch(r"[-+.\de]+", text)}


# the position of a handle, if no other element covers the handle
REACHABLE = function_of("screen", "reachable")


def reachable(page, grip):
    """Return the middle of a grip [pixels], once the page is still and nothing covers the grip."""
    settle(page)
    return np.array(page.wait_for_function(REACHABLE, arg=grip).json_value(), float)


def drag(page, grip, shift, origin=None):
    """Drag a handle to some pixels from its place, or from an origin; return the changed parameters."""
    x, y = reachable(page, grip)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(*(middle(page, origin or grip) + shift), steps=4)
    page.mouse.up()
    settle(page)
    return parameters(page)


def test_an_arrow_key_moves_a_wall_whose_grip_is_beside_it(show):
    """The grip of a wall at the edge of the view is inside the view, as a whole."""
    page = show()
    for wall, key, sign in (("y_max", "ArrowUp", 1), ("y_min", "ArrowDown", -1)):
        position = parameters(page)[f"box.{wall}"]
        page.locator(f'[data-grip="wall {wall}"]').focus()
        page.keyboard.press(key)
        settle(page)
        assert sign * (parameters(page)[f"box.{wall}"] - position) > 0.0


def test_a_dragged_handle_changes_the_value_that_it_stands_for(show):
    """A joint rotates its link, the base moves the chain, and a wall moves along its normal."""
    page, scene = show(), load_scene("four_link_box")
    values_before = {name: value for name, value in parameters(page).items() if name in scene.values}
    for grip, shift, signs in (
        ("joint 4", (-20, -60), {"initial.angle[4]": 1}),
        ("joint 0", (15, 25), {"initial.x": 1, "initial.y": -1}),
        ("wall y_min", (40, -30), {"box.y_min": 1}),
        ("velocity 0", (30, -20), {"initial.vx": 1, "initial.vy": 1}),
        ("velocity 4", (0, -25), {"initial.angular_velocity[4]": 1}),
    ):
        values_after = drag(page, grip, shift)
        changes = {
            name: values_after[name] - value
            for name, value in values_before.items()
            if values_after[name] != value
        }
        assert {name: np.sign(difference) for name, difference in changes.items()} == signs
        until_text(page, f"{impacts_of({name: values_after[name] for name in signs})}s")
        page.locator("#reset-all").click()
        until_text(page, impacts_of({}))


def test_the_view_fits_again_when_a_wall_is_let_go(show):
    page, aspect = show(), "document.querySelector('#view').style.getPropertyValue('--aspect')"
    aspect_before = page.evaluate(aspect)
    page.mouse.move(*middle(page, "wall x_max"))
    page.mouse.down()
    page.mouse.move(*(middle(page, "wall x_max") + np.array([30.0, 0.0])), steps=4)
    settle(page)
    assert page.evaluate(aspect) == aspect_before
    page.mouse.up()
    until(page, f"{aspect} !== '{aspect_before}'")


def test_a_wall_beyond_the_view_has_its_grip_at_the_edge(show):
    page = show("four_link_box", {"box.y_max": 40.0})
    box = page.locator("#view").bounding_box()
    x, y = reachable(page, "wall y_max")
    assert box["y"] <= y <= box["y"] + 0.3 * box["height"]
    assert abs(x - box["x"] - 0.5 * box["width"]) < 0.1 * box["width"]
    assert 1.0 < drag(page, "wall y_max", (0, 10))["box.y_max"] < 10.0


def test_grips_of_walls_keep_off_the_line_that_tells_what_can_be_dragged(show):
    """The floor is at the foot of the drawing or, in an enlarged drawing, beyond it."""
    page = show("hopper")
    page.get_by_role("button", name="Map…").click()
    for _ in range(2):
        line = page.locator(".by-hand-line").bounding_box()
        grip = page.locator('[data-grip="wall y_min"]').bounding_box()
        is_beside = grip["x"] > line["x"] + line["width"]
        assert is_beside or grip["y"] + grip["height"] <= line["y"] + 1.0
        page.keyboard.press("+")
        page.keyboard.press("+")
        page.locator(".wall-beyond").wait_for()


def test_joints_at_rest_are_given_velocities(show):
    page = show("four_link_box", AT_REST)
    for joint in range(5):
        way = reachable(page, f"velocity {joint}") - middle(page, f"joint {joint}")
        values = drag(page, f"velocity {joint}", 0.7 * way)
        if joint == 0:
            assert values["initial.vx"] < 0.0 < abs(values["initial.vy"])
        else:
            assert values[f"initial.angular_velocity[{joint}]"] > 0.0
        page.get_by_role("button", name="Reset all").click()
        settle(page)


def test_a_dragged_arrow_ends_at_the_pointer_and_rests_at_its_stem(show):
    page = show("four_link_box", AT_REST)
    x, y = middle(page, "velocity 0")
    drag(page, "velocity 0", (-30.0, -60.0))
    assert tuple(middle(page, "velocity 0")) == pytest.approx((x - 30.0, y - 60.0), abs=1.5)
    values = drag(page, "velocity 0", 10.0, "joint 0")
    assert (values["initial.vx"], values["initial.vy"]) == (0.0, 0.0)


def test_the_velocity_of_a_slider_is_an_arrow_along_its_line(show):
    """The line of the hopper is vertical: horizontal movements of a pointer or a key have no effect."""
    page, name = show("hopper", {"initial.slider_velocity": 0.0}), "initial.slider_velocity"
    reachable(page, "velocity 0")
    assert drag(page, "velocity 0", (25.0, -30.0))[name] > 0.0
    change_across, change_upwards = middle(page, "velocity 0") - middle(page, "joint 0")
    assert (change_across, change_upwards < -32.0) == (pytest.approx(0.0, abs=1.0), True)
    page.locator('[data-grip="velocity 0"]').focus()
    velocities = []
    for key in ("ArrowLeft", "ArrowUp", *["Shift+ArrowDown"] * 3):
        velocities.append(parameters(page)[name])
        page.keyboard.press(key)
        settle(page)
    change_across, change_upwards, *changes_downwards = np.diff([*velocities, parameters(page)[name]])
    assert (change_across, change_upwards > 0.0, max(changes_downwards) < 0.0) == (0.0, True, True)
    assert parameters(page)[name] < 0.0
    assert middle(page, "velocity 0")[1] > middle(page, "joint 0")[1]


def test_handles_exist_at_the_start_only(show):
    page = show()
    values_before = parameters(page)
    page.mouse.move(*middle(page, "joint 4"))
    page.mouse.down(button="right")
    page.mouse.move(*(middle(page, "joint 4") - (20, 60)))
    page.mouse.up(button="right")
    assert parameters(page) == values_before
    assert page.locator("[data-grip]").count() > 9
    page.keyboard.press("Shift+ArrowRight")
    until(page, "document.querySelectorAll('[data-grip]').length === 0")
    page.get_by_role("button", name="Set the start by hand").click()
    until(page, "document.querySelectorAll('[data-grip]').length > 9")


STEMS = function_of("screen", "numbersOnArrows")
"""The numbers of points that lie on arrows of velocities or on the stems of the arrows."""


@pytest.mark.parametrize("model", ["four_link_box", "thrown_brick", "hopper", "pinned_arm"])
def test_no_number_of_a_point_lies_on_an_arrow_of_a_velocity(show, model):
    page = show(model)
    settle(page)
    assert page.locator(".velocity-stem").count() > 0
    assert page.evaluate(STEMS) == []


GRIPS = function_of("screen", "wallGripsOnOthers")
"""The objects that lie below a grip of a wall, and the grips that an edge of the drawing cuts off."""


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("four_link_box", {"box.x_max": 30.0, "box.y_max": 20.0}),
        ("sliding_rod", {}),
        ("stick_slip_belt", {}),
    ],
)
def test_the_grip_of_a_wall_lies_on_nothing_else(show, model, changes):
    page = show(model, changes)
    for viewport in (DESK, PHONE, ON_ITS_SIDE):
        page.set_viewport_size(viewport)
        settle(page)
        assert page.locator(".wall-grip").count() > 0
        assert page.evaluate(GRIPS) == []


def test_a_closed_box_is_drawn_unless_it_is_much_larger(show):
    page = show("four_link_box", {"box.x_min": -9.0, "box.y_max": 12.0})
    walls = page.locator("#scene polyline.wall")
    assert walls.count() == 2
    page.evaluate("chainImpact.show({ 'box.x_min': 0, 'box.y_max': 2.5 })")
    until(page, "document.querySelectorAll('#scene polyline.wall').length === 4")
    view = page.locator("#view").bounding_box()
    ends = walls.evaluate_all("lines => lines.flatMap((line) => [...line.points]).map(({ x, y }) => [x, y])")
    assert np.min(ends) > 0.0
    assert (np.max(ends, axis=0) < [view["width"], view["height"]]).all()


def test_the_trace_has_corners_at_impacts_only(show):
    """A rod rotates about its pin at 5 turns per second: 30° from frame to frame."""
    spin = {"gravity": (0.0, 0.0), "initial.angular_velocities": (30.0,), "simulation.stop_time": 0.15}
    page = show("simple_pendulum", spin)
    page.locator("#scrub").press("End")
    until(page, "document.getElementById('time').textContent === '0.15000 s'")
    places = np.array(page.evaluate(PLACES))
    centre = page.evaluate("""() => {
      const joint = document.querySelector('.joint');
      return [joint.cx.baseVal.value, joint.cy.baseVal.value];
    }""")
    middles = np.concatenate([places, 0.5 * (places[1:] + places[:-1])])
    assert np.ptp(np.hypot(*(middles - centre).T)) < 0.5


@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm", "kneed_leg"])
def test_on_a_phone_on_its_side_all_of_the_chain_is_seen(show, model):
    page = show(model, viewport=ON_ITS_SIDE)
    lowest = page.locator("footer").bounding_box()["y"]
    for k in range(len(load_scene(model).chain.links) + 1):
        box = page.locator(f'[data-grip="joint {k}"]').bounding_box()
        assert 0.0 < box["x"] < ON_ITS_SIDE["width"]
        assert 0.0 < box["y"] < box["y"] + box["height"] < lowest


# --- under a finger --------------------------------------------------------------------------------------


def touch(page, kind, *points):
    """Touch the screen with fingers at points, in continuation of earlier touches."""
    page.touches = getattr(page, "touches", None) or page.context.new_cdp_session(page)
    touches = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
    page.touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})


def angle(page, link=4):
    return parameters(page)[f"initial.angle[{link}]"]


def test_only_the_first_finger_drags_a_joint_and_the_page_does_not_scroll(show):
    page = show(viewport=PHONE, has_touch=True)
    first, second = middle(page, "joint 4"), middle(page, "joint 1")
    lower = second + np.array([0, 40])
    start_angle = angle(page)
    touch(page, "touchStart", first)
    touch(page, "touchMove", first - (0, 20))
    angle_of_tip, angle_of_first = angle(page), angle(page, 1)
    touch(page, "touchStart", first - (0, 20), second)
    touch(page, "touchMove", first - (0, 20), lower)
    assert (angle(page), angle(page, 1)) == (angle_of_tip, angle_of_first)
    touch(page, "touchMove", first - (0, 40), lower)
    assert angle(page) > angle_of_tip
    for k in range(2, 11):
        touch(page, "touchMove", first - (3 * k, 6 * k), lower)
        page.wait_for_timeout(10)
    touch(page, "touchEnd")
    assert angle(page) > start_angle + 0.5
    assert page.evaluate("scrollY") == 0


def test_a_finger_reads_a_run_of_a_map_and_then_opens_it(show):
    page = show(hash_="#simulation.stop_time=0.2", viewport=PHONE, has_touch=True)
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    assert not re.search("click|keys", page.inner_text("#map-text"))
    page.locator("#map-canvas").tap()
    page.locator("#map-text").get_by_text("Largest force at a wall = ").wait_for()
    assert page.locator("#map").is_visible()
    page.locator("#map-canvas").tap()
    page.locator("#map").wait_for(state="hidden")
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "0.675", "the middle of the map"


def test_the_controls_cover_no_part_of_the_motion(show):
    """The page has the size of a frame in a notebook."""
    page = show()
    ends = "[document.getElementById('view').getBoundingClientRect().bottom, "
    for size in ((1100, 640), (900, 640), (1366, 640), (1000, 1000)):
        resize(page, *size)
        view, controls = page.evaluate(ends + "document.querySelector('footer').getBoundingClientRect().top]")
        assert view <= controls, size


SMALL_CONTROLS = function_of("screen", "smallControls")


CUT_OFF = """[...document.querySelectorAll("#controls > :not([hidden])")]
  .filter((control) => control.getBoundingClientRect().right > innerWidth).map((cut) => cut.textContent)"""


def test_fingers_meet_every_control_of_a_phone(show):
    page = show("kneed_leg", hash_="#gravity.y=-9", viewport=PHONE, has_touch=True)
    page.evaluate("document.querySelector('summary').click(), document.getElementById('pin').click()")
    for size in (PHONE, ON_ITS_SIDE):
        resize(page, **size)
        assert page.evaluate(SMALL_CONTROLS, 32) == [], size
        for name in ("edit", "map", "curves", "export", "help"):
            page.evaluate(f"document.getElementById('{name}-open').click()")
            assert page.evaluate(SMALL_CONTROLS, 32) == [], (size, name)
            cut_off = CUT_OFF.replace("#controls > :not([hidden])", f"#{name} :is(input, button)")
            assert page.evaluate(cut_off) == [], (size, name)
            page.keyboard.press("Escape")


def test_on_a_phone_controls_take_a_tenth_of_the_height(show):
    page = show(viewport=PHONE, has_touch=True)
    for size in (PHONE, ON_ITS_SIDE):
        resize(page, **size)
        share = "document.querySelector('footer').getBoundingClientRect().height / innerHeight"
        assert page.evaluate(share) <= 0.1, size
        assert page.evaluate(CUT_OFF) == [], size
        page.locator("#loop").tap()
        assert page.locator("#loop").is_checked()
        page.locator("#loop").tap()


def test_a_dragged_handle_tells_its_angle_until_it_is_dropped(show):
    page = show()
    x, y = reachable(page, "joint 1")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y + 20, steps=4)
    text = page.locator(".handle-text")
    text.wait_for()
    page.wait_for_timeout(500)  # the drawing follows the pointer in the next frames
    shown_angle = float(text.text_content().replace("\u2212", "-").removesuffix("°"))
    box = text.bounding_box()
    for number in page.locator(".point-number").all():
        box_of_number = number.bounding_box()
        sides = (("x", "width"), ("y", "height"))
        x, y = (
            abs(box[at] + box[size] / 2 - box_of_number[at] - box_of_number[size] / 2) for at, size in sides
        )
        assert (
            x >= (box["width"] + box_of_number["width"]) / 2
            or y >= (box["height"] + box_of_number["height"]) / 2
        )
    page.mouse.up()
    text.wait_for(state="detached")
    page.wait_for_timeout(500)  # the address follows the drawing later
    assert shown_angle == pytest.approx(np.degrees(float(parameters(page)["initial.angle[1]"])), abs=0.06)

"""What stands on the screen: grips that can be taken, refusals, the room, the trace, small screens."""

import numpy as np
import pytest

from chain_impact import explore, load_scene
from tests.tiers import needs_browser

pytestmark = needs_browser
ON_ITS_SIDE = {"width": 844, "height": 390}
AT_REST = {"initial.velocity": (0.0, 0.0), "initial.angular_velocities": (0.0,) * 4}
PLACES = """() => document.querySelector('.trace').getAttribute('points').trim().split(/\\s+/).map((place) =>
  place.split(',').map(Number))"""


@pytest.fixture
def show_scene(browser, tmp_path):
    """Open the page of a scene with other values."""
    opened = []

    def show_scene(model, changes=None, viewport=None):
        explore(load_scene(model).with_values(changes or {}), tmp_path / "page.html")
        page = browser.new_page(reduced_motion="reduce", **({"viewport": viewport} if viewport else {}))
        opened.append(page)
        page.goto((tmp_path / "page.html").as_uri())
        page.wait_for_function("performance.getEntriesByName('first-frame').length === 1")
        return page

    yield show_scene
    for page in opened:
        page.close()


def middle(page, grip):
    box = page.locator(f'[data-grip="{grip}"]').bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def parameter(page, name):
    return float(page.evaluate(f"chainImpact.parameters['{name}']"))


def drag_to(page, grip, x, y):
    page.mouse.move(*middle(page, grip))
    page.mouse.down()
    page.mouse.move(x, y, steps=4)
    page.mouse.up()
    page.wait_for_timeout(300)


@pytest.mark.parametrize("joint", range(5))
def test_a_joint_at_rest_is_given_a_velocity(show_scene, joint):
    page = show_scene("four_link_box", AT_REST)
    x, y = middle(page, f"velocity {joint}")
    at = page.evaluate("([x, y]) => document.elementFromPoint(x, y).dataset.grip", [x, y])
    assert at == f"velocity {joint}"
    x0, y0 = middle(page, f"joint {joint}")
    drag_to(page, f"velocity {joint}", x + 0.7 * (x - x0), y + 0.7 * (y - y0))
    if joint == 0:
        assert parameter(page, "initial.vx") < 0.0 < abs(parameter(page, "initial.vy"))
    else:
        assert parameter(page, f"initial.angular_velocity[{joint}]") > 0.0


def test_an_arrow_that_is_dragged_ends_where_the_pointer_is_and_on_its_stem_the_joint_rests(show_scene):
    page = show_scene("four_link_box", AT_REST)
    x, y = middle(page, "velocity 0")
    drag_to(page, "velocity 0", x - 30.0, y - 60.0)
    assert middle(page, "velocity 0") == pytest.approx((x - 30.0, y - 60.0), abs=1.5)
    drag_to(page, "velocity 0", *(place + 10.0 for place in middle(page, "joint 0")))
    assert (parameter(page, "initial.vx"), parameter(page, "initial.vy")) == (0.0, 0.0)


COLOUR = "field => getComputedStyle(field).borderTopColor"


def test_a_refused_value_is_marked_and_told_until_it_is_changed(show):
    page = show()
    field = page.get_by_role("textbox", name="contact.stiffness")
    usual = field.evaluate(COLOUR)
    field.fill("-1")
    field.press("Enter")
    page.get_by_role("textbox", name="gravity.y").focus()
    told = page.get_by_role("alert").filter(has_text="Not taken")
    assert (
        told.inner_text() == "Not taken: contact.stiffness = -1 must be a finite number > 0 [N/m^exponent]."
    )
    assert field.evaluate(COLOUR) != usual
    assert parameter(page, "contact.stiffness") == 1e8
    field.fill("1e7")
    field.press("Enter")
    assert told.count() == 0
    assert field.evaluate(COLOUR) == usual


def test_a_refused_value_in_the_list_is_told_and_another_change_shows_the_value_that_holds(show):
    page = show()
    page.get_by_text("All parameters").click()
    row = page.locator(".parameter").filter(has_text="link[2].\u200bmass").first
    row.locator("input").fill("heavy")
    row.locator("input").press("Enter")
    told = "Not taken: link[2].mass = heavy must be a finite number > 0 [kg]."
    assert row.locator(".refusal").inner_text() == told
    page.get_by_role("slider", name="Restitution").press("ArrowLeft")
    assert row.locator("input").input_value() == "1"
    assert not row.locator(".refusal").is_visible()


def sides(page):
    """How many straight walls are drawn."""
    return page.locator("#scene polyline.wall").count()


def test_a_closed_box_is_drawn_closed_unless_it_is_much_larger_than_the_motion(show_scene):
    page = show_scene("four_link_box")
    view = page.locator("#view").bounding_box()
    ends = page.locator("#scene polyline.wall").evaluate_all(
        "lines => lines.flatMap((line) => [...line.points]).map(({ x, y }) => [x, y])"
    )
    assert len(ends) == 8
    assert np.min(ends) > 0.0
    assert (np.max(ends, axis=0) < [view["width"], view["height"]]).all()
    assert sides(show_scene("four_link_box", {"box.x_min": -9.0, "box.y_max": 12.0})) == 2


def test_the_trace_has_corners_at_impacts_only(show_scene):
    """A rod that spins about its pin: with 5 turns in a second, it turns by 30° from frame to frame."""
    spin = {"gravity": (0.0, 0.0), "initial.angular_velocities": (30.0,)}
    page = show_scene("simple_pendulum", {**spin, "simulation.stop_time": 0.15})
    page.locator("#scrub").press("End")
    page.wait_for_timeout(300)
    places = np.array(page.evaluate(PLACES))
    centre = np.array(middle_of_pin(page))
    middles = np.concatenate([places, 0.5 * (places[1:] + places[:-1])])
    radii = np.hypot(*(middles - centre).T)
    assert np.ptp(radii) < 0.5


def middle_of_pin(page):
    return page.evaluate("""() => {
      const joint = document.querySelector('.joint');
      return [joint.cx.baseVal.value, joint.cy.baseVal.value];
    }""")


@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm", "kneed_leg"])
def test_on_a_phone_on_its_side_all_of_the_chain_is_seen(show_scene, model):
    page = show_scene(model, viewport=ON_ITS_SIDE)
    lowest = page.locator("footer").bounding_box()["y"]
    links = load_scene(model).chain.links
    for k in range(len(links) + 1):
        box = page.locator(f'[data-grip="joint {k}"]').bounding_box()
        assert 0.0 < box["x"] < ON_ITS_SIDE["width"]
        assert 0.0 < box["y"] < box["y"] + box["height"] < lowest

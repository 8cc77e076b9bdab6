"""The page under a finger."""

from tests.results.page.conftest import PHONE
from tests.tiers import needs_browser

pytestmark = needs_browser


def touch(page, kind, *points):
    """Let fingers touch the screen at points; what they did before goes on."""
    page.touches = getattr(page, "touches", None) or page.context.new_cdp_session(page)
    given = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
    page.touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": given})


def middle(page, selector):
    box = page.locator(selector).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def angle(page, link=4):
    return float(page.evaluate(f"chainImpact.parameters['initial.angle[{link}]']"))


def test_a_finger_drags_a_joint_and_does_not_scroll(show):
    page = show(PHONE, has_touch=True)
    x, y = middle(page, '[data-grip="joint 4"]')
    before = angle(page)
    touch(page, "touchStart", (x, y))
    for k in range(1, 11):
        touch(page, "touchMove", (x - 3 * k, y - 6 * k))
        page.wait_for_timeout(10)
    touch(page, "touchEnd")
    assert angle(page) > before + 0.5
    assert page.evaluate("scrollY") == 0


def test_a_second_finger_does_not_take_a_joint_away(show):
    page = show(PHONE, has_touch=True)
    first, second = middle(page, '[data-grip="joint 4"]'), middle(page, '[data-grip="joint 1"]')
    touch(page, "touchStart", first)
    touch(page, "touchMove", (first[0], first[1] - 20))
    held, other = angle(page), angle(page, 1)
    touch(page, "touchStart", (first[0], first[1] - 20), second)
    touch(page, "touchMove", (first[0], first[1] - 20), (second[0], second[1] + 40))
    assert (angle(page), angle(page, 1)) == (held, other)
    touch(page, "touchMove", (first[0], first[1] - 40), (second[0], second[1] + 40))
    assert angle(page) > held
    touch(page, "touchEnd")


def test_the_right_button_drags_nothing(show):
    page = show()
    x, y = middle(page, '[data-grip="joint 4"]')
    before = angle(page)
    page.mouse.move(x, y)
    page.mouse.down(button="right")
    page.mouse.move(x - 20, y - 60)
    page.mouse.up(button="right")
    assert angle(page) == before


def test_a_finger_reads_a_run_of_a_map_and_then_opens_it(show):
    page = show(PHONE, hash_="#simulation.stop_time=0.2", has_touch=True)
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    page.locator("#map-canvas").tap()
    page.locator("#map-text").get_by_text("impact.count = ").wait_for()
    assert page.locator("#map").is_visible()
    page.locator("#map-canvas").tap()
    page.locator("#map").wait_for(state="hidden")
    assert page.evaluate("chainImpact.parameters['contact.restitution']") == "0.5"

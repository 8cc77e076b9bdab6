"""The curves of pinned motions in charts: their axes, letters, and the sentences in place of a curve."""

# Tests: pages/browser/charts/letters.js
# Tests: pages/browser/charts/contact_course.js

import io

import numpy as np
import pytest
from PIL import Image

from chain_impact import load_scene, simulate
from tests.pages.in_pages import PIXELS, ROWS, impacts_of, partners, until, until_drawn, until_text
from tests.tiers import needs_browser

pytestmark = needs_browser
PIN_COLOUR = (0xD2, 0x00, 0xB4)
"""The colour of the first pin in the light style."""
BELOW_PEAK = 30
"""Number of pixels at the top of the chart, which have the number of the peak and no curve."""


def test_a_chart_of_force_tells_why_it_has_no_curve_of_a_pin(show):
    page, changes = show(), {"contact.restitution": 0.4}
    first, other_impacts = (
        simulate(load_scene("four_link_box").with_values(values)).impacts for values in ({}, changes)
    )
    expected = [k is not None for k in partners(other_impacts, first)]
    page.get_by_role("button", name="Pin").click()
    page.evaluate("changes => chainImpact.show(changes)", changes)
    until_text(page, impacts_of(changes))
    for number in (expected.index(True) + 1, expected.index(False) + 1):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        until(
            page, f"document.getElementById('contact-name').textContent.startsWith('impact\u00a0{number}: ')"
        )
        assert (page.evaluate(PIXELS, ["force", "pin-1"]) > 20) is expected[number - 1]
        assert ("; A: " not in page.text_content("#contact-name")) is expected[number - 1]
        assert page.locator("#contact-name").evaluate(
            "element => element.scrollWidth <= element.clientWidth"
        ), "it is not cut off"


def test_the_force_of_a_pin_beside_an_impulse_is_whole(show):
    """The curve falls to zero before the right end of the chart."""
    page = show("pinned_arm")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact'})")
    until(page, "document.getElementById('contact-quantity').textContent === 'Contact force of A'")
    until_drawn(page)
    with Image.open(io.BytesIO(page.locator("#force").screenshot())) as image:
        colours = np.asarray(image.convert("RGB")).astype(int)
    rows, columns = np.nonzero(abs(colours - PIN_COLOUR).max(axis=-1) < 60)
    height, width = colours.shape[:2]
    assert rows.min() < 0.4 * height
    assert rows[columns > 0.85 * width].min() > 0.6 * height


def test_a_chart_with_curves_of_pins_alone_is_titled_by_their_letters(show):
    """The letters of pins without a curve at an impact stand together before their common reason."""
    page = show()
    for changes in ({"contact.restitution": 0.4}, {"contact.restitution": 0.2}):
        page.evaluate("changes => chainImpact.show(changes)", changes)
        until_text(page, impacts_of(changes))
        page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.model': 'newton_impact'})")
    until_text(page, impacts_of({"contact.model": "newton_impact", "contact.restitution": 0.2}))
    assert page.inner_text("#contact-quantity") == "Contact force of A, B"
    name = page.text_content("#contact-name")
    assert "N·s, present: an impulse only" in name
    assert "no force over time is known" not in name
    names = set()
    for number in range(1, 15):
        page.get_by_role("button", name=f"Go to impact {number}, ").click()
        until(
            page, f"document.getElementById('contact-name').textContent.startsWith('impact\u00a0{number}: ')"
        )
        names.add(page.text_content("#contact-name").partition("; ")[2])
    assert "A, B: no such impact near" in names
    assert "A: no such impact near; B: no such impact near" not in names


def test_the_card_of_the_force_stays_at_a_stop_with_impulses_alone(show):
    page = show("kneed_leg", {"stop.restitution": 0.5})
    assert page.text_content("#contact-name").startswith(
        "impact\u00a01: joint 3 at max (point 2), 6.35\u202fmN·m·s, "
    )
    assert page.locator("#contact").is_visible()


def test_a_stiff_pin_does_not_flatten_the_curve_of_the_present_contact(show):
    page = show("rod_drop", hash_="#contact.stiffness=1e8")
    page.get_by_role("button", name="Pin").click()
    for stiffness, is_cut in ((3e7, False), (1e6, True)):
        page.evaluate("value => chainImpact.show({'contact.stiffness': value})", stiffness)
        until_text(page, impacts_of({"contact.stiffness": stiffness}, "rod_drop"))
        rows = [row for row in page.evaluate(ROWS, ["force", "force"]) if row > BELOW_PEAK]
        height = page.evaluate("document.querySelector('#force canvas').height")
        assert max(rows) - min(rows) > 0.25 * height
        assert page.evaluate(PIXELS, ["force", "pin-1"]) > 20
        peak = simulate(load_scene("rod_drop").with_values({"contact.stiffness": 1e8})).impacts["peak_force"][
            0
        ]
        ending = f"; A: up to {peak / 1e3:.2f}\u202fkN"
        assert page.text_content("#contact-name").endswith(ending) is is_cut
        page.get_by_role("button", name="F(δ)").click()
        assert page.text_content("#contact-name").endswith(ending) is is_cut
        assert ("; A: loss\xa0" in page.text_content("#contact-name")) is not is_cut, "of the pin, too"
        page.get_by_role("button", name="F(δ)").click()


def test_an_axis_of_square_roots_holds_a_far_higher_pin(show, script):
    page = show("rod_drop", hash_="#contact.stiffness=1e8")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("chainImpact.show({'contact.stiffness': 1e6})")
    until_text(page, impacts_of({"contact.stiffness": 1e6}, "rod_drop"))
    until_text(page, "Contact force (square roots)", "contact-quantity")
    rows = [page.evaluate(ROWS, ["force", name]) for name in ("pin-1", "force")]
    top, peak = (min(row for row in rows_of_curve if row > BELOW_PEAK - 10) for rows_of_curve in rows)
    bottom = max(rows[1])
    scenes = [load_scene("rod_drop").with_values({"contact.stiffness": k}) for k in (1e8, 1e6)]
    peaks = [simulate(scene).impacts["peak_force"][0] for scene in scenes]
    assert (bottom - top) / (bottom - peak) == pytest.approx(np.sqrt(peaks[0] / peaks[1]), rel=0.1)
    ticks = script.evaluate("([...of]) => rootTicks(...of)", [{"height": 140}, 2100.0])
    assert ticks == [0, 100, 500, 1000, 2000]


def test_letters_stand_where_their_curve_is_far_from_others(script):
    """A leaves the present curve at the right, B is far from it, and C lies on it."""
    box = {"left": 0, "top": 0, "width": 300, "height": 100}
    present_courses = [[[0, 90], [300, 90]]]
    courses = {"A": [[0, 90], [200, 90], [300, 60]], "B": [[0, 50], [300, 50]], "C": [[0, 90], [300, 90]]}
    compared = [{"letter": letter, "course": course} for letter, course in courses.items()]
    find = "([...of]) => letterPositions(...of, [], {box}, 1)".replace("{box}", str(box))
    a, b, c = script.evaluate(find, [compared, present_courses])
    assert a[0] > 250
    assert b[1] == 50
    assert abs(b[0] - 0.29 * 300) < 30, "equally good places are at different times for different letters"
    assert abs(c[0] - a[0]) > 15


def test_a_chart_of_inputs_tells_why_it_has_no_curve_of_a_pin(show):
    page = show("pinned_arm")
    page.get_by_role("button", name="Pin").click()
    page.evaluate("location.hash = '#joint[1].torque@=0.1:5'")
    page.locator("#inputs-note").get_by_text("curves of A:").wait_for()
    page.get_by_role("button", name="Pin").click()
    page.locator(".unpin").first.click()
    page.locator("#inputs-note").wait_for(state="hidden")


def test_the_loss_of_a_contact_is_the_area_of_its_loop(script):
    depth = np.concatenate([np.linspace(0.0, 0.002, 41), np.linspace(0.002, 0.0, 41)])

    def loss_text(peak, back, step=1):
        force = np.concatenate([np.linspace(0.0, peak, 41), back * np.linspace(peak, 0.0, 41)])
        loop = {"penetration": depth[::step].tolist(), "force": force[::step].tolist()}
        return script.evaluate("lossText", loop)

    assert loss_text(2000.0, 0.75) == "loss\u00a00.50\u202fJ"
    assert loss_text(0.02, 0.75) == "loss\u00a05.0\u202fµJ"
    assert loss_text(2000.0, 1.0) == "loss below 0.2\u202f%"
    assert loss_text(2000.0, 0.75, step=3) == "", "too few rows for a number"
    assert loss_text(2000.0, 1.1) == "", "no loss"

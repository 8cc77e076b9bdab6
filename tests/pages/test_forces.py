"""The scale of force arrows, and the placement of texts in the scene."""

import numpy as np
import pytest

from chain_impact.studies.animate import record_slowly
from tests.pages.conftest import PHONE, go_to, press
from tests.tiers import needs_browser

pytestmark = needs_browser
LENGTHS = """() => [...document.querySelectorAll('.arrow-head.force')].map((head) => {
  const [tip] = head.points, { x1, y1 } = head.previousElementSibling;
  return Math.hypot(tip.x - x1.baseVal.value, tip.y - y1.baseVal.value); })"""
RULER = """() => [...document.querySelectorAll('.ruler-text')].map((text) =>
  [text.textContent, text.x.baseVal[0].value - document.querySelector('.ruler').x1.baseVal.value])"""
ON_OTHERS = """() => {
  const seen = (kinds) => [...document.querySelectorAll(kinds)]
    .filter((one) => getComputedStyle(one).visibility === 'visible')
    .map((one) => [one.textContent || 'a dot', one.getBoundingClientRect()]);
  const shared = (a, b, low, high) => Math.min(a[high], b[high]) - Math.max(a[low], b[low]);
  const meet = ([, a], [, b]) => shared(a, b, 'left', 'right') > 1 && shared(a, b, 'top', 'bottom') > 3;
  const texts = seen('.point-number, .force-text, .ring-number, .ruler-text, .ruler-name, .bar-text');
  const others = [...texts, ...seen('circle.joint, circle.tip, circle.site')];
  return texts.flatMap((one, k) => others.slice(k + 1).filter((other) => meet(one, other))
    .map((other) => [one[0], other[0]])); }"""
"""Pairs of an overlapping text and object. The boxes of texts include space above the letters."""


def newtons(text):
    """Return the force [N] in a text."""
    value, unit = text.split("\u202f")
    return float(value) * {"N": 1.0, "kN": 1e3, "MN": 1e6}[unit]


def test_a_resting_weight_and_a_peak_are_both_seen_and_a_ruler_tells_the_scale(show_recording):
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


@pytest.mark.parametrize("model", ["thrown_brick", "four_link_box", "hopper"])
def test_numbers_and_forces_are_on_no_other_text_and_no_dot(show_recording, model):
    recording = record_slowly(model)
    page, numbers = show_recording(recording), set()
    for impact in recording.impacts[:8]:
        lasting = np.nan_to_num(impact["end"] - impact["onset"], nan=1e-3)
        for share in (0.5, 1.5):
            go_to(page, impact["onset"] + share * lasting)
            assert page.evaluate(ON_OTHERS) == []
            numbers |= set(page.locator(".ring-number").all_text_contents())
    assert {"#1", "#2", "#3"} <= numbers


def test_ruler_and_scale_bar_are_apart_on_a_phone(show_recording):
    page = show_recording(viewport=PHONE)
    press(page, "Shift+ArrowRight")
    assert page.evaluate(ON_OTHERS) == []

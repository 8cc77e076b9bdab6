"""Rings and numbers of impacts, and the places of labels."""

# Tests: pages/browser/drawing/rings.js

import math
import re

import numpy as np
import pytest

from chain_impact.studies.animate import record_slowly
from tests.pages.in_pages import DESK, ON_ITS_SIDE, ON_OTHERS, PHONE, go_to
from tests.pages.javascript import function_of
from tests.tiers import needs_browser

pytestmark = needs_browser
RINGS = function_of("drawing", "ringsAndNumbers")
"""The middles of the rings, in the order of their impacts, and of their numbers."""
CROSSED = function_of("drawing", "crossedTexts")
"""The texts that a ring, a link or an edge of the drawing crosses."""
CROSSED_RINGS = function_of("drawing", "crossedRings")
"""The pairs of rings whose lines meet."""
DISTANCES = function_of("drawing", "distancesOfNumbers")
"""The distances of the visible numbers from their points [pixels]."""
SIDES = function_of("drawing", "sidesOfNumbers")
PLACE = function_of("drawing", "placeOfLabel")
CONTRASTS = function_of("drawing", "contrasts")


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


@pytest.mark.parametrize("model", ["sliding_rod", "stick_slip_belt", "thrown_brick"])
def test_no_label_is_on_a_ring_a_link_or_an_edge(show_recording, model):
    recording = record_slowly(model)
    page = show_recording(recording)
    times = (*np.linspace(0.1, 0.9, 5) * recording.time[-1], *(recording.impacts["onset"][:5] + 2e-3))
    for viewport in (DESK, PHONE, ON_ITS_SIDE):
        page.set_viewport_size(viewport)
        texts = set()
        for time in times:
            go_to(page, time)
            assert page.evaluate(ON_OTHERS) == []
            assert page.evaluate(CROSSED) == []
            texts |= set(page.locator(".force-text, .ring-number, .point-number").all_text_contents())
        assert any(text.endswith("with friction") for text in texts)


def test_the_numbers_of_a_disc_are_apart_and_not_on_its_outline(show_recording):
    recording = record_slowly("ramp")
    page = show_recording(recording)
    for viewport in (DESK, PHONE):
        page.set_viewport_size(viewport)
        for time in (0.0, *(recording.impacts["onset"][:4] + 1e-3)):
            go_to(page, time)
            assert page.evaluate(CROSSED) == []
            numbers = page.locator(".point-number:visible")
            assert numbers.count() == 2
            boxes = [number.bounding_box() for number in numbers.all()]
            distances = [abs(boxes[0][axis] - boxes[1][axis]) for axis in "xy"]
            assert distances[0] > 14 or distances[1] > 8, "0 and 1 do not read as 01"


def test_the_number_of_an_impact_is_at_its_own_ring(show_recording):
    recording = record_slowly("thrown_brick")
    page, onsets = show_recording(recording), recording.impacts["onset"]
    for viewport in (DESK, PHONE, ON_ITS_SIDE):
        page.set_viewport_size(viewport)
        assert_numbers_at_their_rings(page, onsets)


def assert_numbers_at_their_rings(page, onsets):
    texts = set()
    for time in onsets[1:6] + 2e-3:
        go_to(page, time)
        rings, numbers = page.evaluate(RINGS)
        recent = np.flatnonzero((onsets <= time) & (onsets > time - 0.25)) + 1
        assert len(numbers) <= len(rings) <= len(recent)
        places_of_rings = []
        for text, middle in numbers:
            distances = [math.dist(middle, ring) for ring in rings]
            places_of_rings.append(distances.index(min(distances)))
            if len(rings) == len(recent):
                assert recent[places_of_rings[-1]] == int(re.findall(r"\d+", text)[-1]), (
                    "each ring has its own number"
                )
            texts |= {text}
        assert len(places_of_rings) == len(set(places_of_rings))
        last = [int(re.findall(r"\d+", text)[-1]) for text, _ in numbers]
        assert [last[k] for k in np.argsort(places_of_rings)] == sorted(last), "in the order of impacts"
    assert len(texts) > 1


def test_a_ring_leaves_room_to_a_later_one_or_joins_it(script):
    """Impacts 2 and 7 are alone; the ring of 5 is 23 pixels from that of 10, which has 10 pixels of them."""
    positions = [5, 90, 5, 5, 28, 5, 200, 5, 5, 5]
    rings = script.evaluate(function_of("drawing", "rings"), [[0.01 * k for k in range(10)], positions])
    grown = {number: 10.0 * (1.0 + (0.04 * (10 - number)) ** 0.5) for number in (2, 7, 10)}
    assert [ring[:2] for ring in rings] == [[2, "#"], [5, "#5"], [7, "#7"], [10, "#3, 4, 6, 8–10"]]
    assert [radius for *_, radius in rings] == pytest.approx([grown[2], 10.0, grown[7], grown[10]])


@pytest.mark.parametrize("model", ["rod_drop", "four_link_box", "arm_at_stop"])
def test_no_ring_is_on_another_ring(show_recording, model):
    recording = record_slowly(model)
    page, ring_count, joined_count = show_recording(recording), 0, 0
    for onset in recording.impacts["onset"][:12]:
        go_to(page, onset + 5e-3)
        assert page.evaluate(CROSSED_RINGS) == []
        ring_count += page.locator(".ring").count()
        joined_count += sum(
            "," in text or "–" in text for text in page.locator(".ring-number").all_text_contents()
        )
    assert ring_count > 1
    assert joined_count > 0


def test_a_label_avoids_the_trace_if_another_place_is_near(script):
    """The trace goes along y = 50 until the frame 2, and then upwards from its right end."""
    trace = {"frames": [0, 2, 4], "positions": [[0, 50], [90, 50], [90, 5]]}
    for box, frame, is_crossed in (
        ([30, 45, 60, 55], 2, True),
        ([30, 45, 60, 55], 1, False),
        ([85, 10, 95, 20], 2, False),
        ([85, 10, 95, 20], 4, True),
        ([30, 60, 60, 70], 4, False),
    ):
        assert (
            script.evaluate("([trace, ...at]) => traceFinder(trace, 100)(...at)", [trace, box, frame])
            is is_crossed
        )
    candidates = [[10, 50], [60, 50], [70, 50]]
    assert [script.evaluate(PLACE, [left, candidates]) for left in (0, 20, 99)] == [
        candidates[0],
        candidates[1],
        candidates[0],
    ]


def test_numbers_stay_beside_the_points_of_a_body_that_is_small_on_a_phone(show_recording):
    recording = record_slowly("thrown_brick")
    page, distance_count = show_recording(recording, viewport=PHONE), 0
    for impact in recording.impacts[:4]:
        go_to(page, impact["onset"] + 1e-3)
        distances = page.evaluate(DISTANCES)
        distance_count += len(distances)
        assert max(distances, default=0.0) < 32.0
    assert distance_count > 4


def test_numbers_of_impacts_are_readable(show_recording, recording):
    page, text_count = show_recording(), 0
    for delay in np.linspace(0.01, 0.3, 8):
        go_to(page, recording.impacts["onset"][1] + delay)
        for scheme in ("dark", "light"):
            page.emulate_media(color_scheme=scheme)
            contrasts = page.evaluate(CONTRASTS, ".ring-number")
            text_count += len(contrasts)
            assert min(contrasts, default=21.0) >= 4.5, scheme  # WCAG 2.2, 1.4.3
    assert text_count > 2


def test_numbers_of_points_keep_their_sides_while_an_impact_lasts(show_recording):
    """A number gives way to an arrow that grows, but does not come back when the arrow becomes short."""
    recording = record_slowly("four_link_box")
    page, impact = show_recording(recording, viewport=DESK), recording.impacts[0]
    angles = {}
    for share in np.linspace(0.02, 0.98, 25):
        go_to(page, impact["onset"] + share * (impact["end"] - impact["onset"]))
        for name, (x, y) in page.evaluate(SIDES).items():
            angles.setdefault(name, []).append(math.atan2(y, x))
    assert set(angles) == set("01234")
    has_turned = [
        np.abs((np.diff(values) + np.pi) % (2.0 * np.pi) - np.pi) > 0.6 for values in angles.values()
    ]
    assert np.count_nonzero(has_turned) <= 4

"""The look of all pictures: colours that can be told apart, and a headline over the panels."""

import itertools

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from chain_impact.results.plots.style import PALETTE, SEPARATOR, TIME_COLOURS, headline, number

# what red-blind, green-blind and blue-blind eyes see of linear RGB, at full severity: Machado, Oliveira and
# Fernandes, A physiologically-based model for simulation of color vision deficiency, IEEE Transactions on
# Visualization and Computer Graphics 15 (2009), table 1
BLIND = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def lab(linear):
    """CIE L*a*b* of linear RGB, for the white of daylight."""
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(to_xyz @ np.clip(linear, 0.0, 1.0) / [0.9505, 1.0, 1.089])
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def linear(colour):
    value = np.array(to_rgb(colour))
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("eyes", [None, *BLIND])
def test_the_palette_is_told_apart_by_all_eyes(eyes):
    seen = [lab((np.array(BLIND[eyes]) if eyes else np.eye(3)) @ linear(colour)) for colour in PALETTE]
    for one, other in itertools.combinations(seen, 2):
        assert np.linalg.norm(one - other) > 10.0  # 2.3 is just noticed


def test_the_palette_is_dark_enough_for_lines_on_white():
    assert all(lab(linear(colour))[0] < 80.0 for colour in PALETTE)
    assert len(PALETTE) <= 10


def test_time_goes_from_dark_to_light():
    lightness = [lab(linear(TIME_COLOURS(part)))[0] for part in np.linspace(0.0, 1.0, 20)]
    assert np.all(np.diff(lightness) > 0.0)
    assert lightness[-1] < 85.0


@pytest.mark.parametrize("conditions", ["", "4 links"])
def test_the_headline_leaves_the_panels_room(conditions):
    page = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = page.add_subplot()
    headline(page, "What it says", conditions)
    page.draw_without_rendering()
    boxes = [text.get_window_extent() for text in page.texts if text.get_text()]
    assert not any(box.overlaps(axes.get_tightbbox()) for box in boxes)
    assert all(page.bbox.contains(*corner) for box in boxes for corner in box.corners())
    if conditions:
        assert boxes[1].y1 <= boxes[0].y0 + 2.0


@pytest.mark.parametrize(
    ("value", "text"),
    [(1e8, "1e8"), (2.145e10, "2.145e10"), (1e-10, "1e-10"), (0.7, "0.7"), (30.0, "30"), (1e5, "1e5")],
)
def test_numbers_without_zeros_that_say_nothing(value, text):
    assert number(value) == text


LONG = [
    "4 links",
    "joint friction ≤ 0.02 N·m",
    "law zhang_sharf",
    "stiffness K = 1e8 N/m$^{1.5}$",
    "friction µ = 0.3 (static 0.4), 0.1 (static 0.2) at y_min, 0.5 (static 0.6) at ramp",
    "stops law newton_impact, e = 0.5",
    "method auto, tolerance 1e-8",
]


@pytest.mark.parametrize("width", [3.0, 6.0, 10.0])
def test_a_headline_and_its_conditions_are_broken_into_lines_that_fit_the_page(width):
    page = Figure(figsize=(width, 5.0), layout="constrained")
    axes = page.subplots()
    headline(
        page,
        "Box: 14 impacts, 82 % of the energy dissipated, 12 % of it by dry friction",
        SEPARATOR.join(LONG),
    )
    page.draw_without_rendering()
    message, conditions = page.texts
    boxes = [text.get_window_extent() for text in (message, conditions)]
    for box in boxes:
        assert page.bbox.x0 <= box.x0 < box.x1 <= page.bbox.x1
    assert axes.get_tightbbox().y1 < boxes[1].y0
    assert boxes[1].y1 < boxes[0].y0
    lines = conditions.get_text().split("\n")
    assert len(lines) > 1
    if width > 5.0:
        assert [part for line in lines for part in line.split(SEPARATOR)] == LONG


def test_what_fits_stays_in_a_line():
    page = Figure(figsize=(10.0, 5.0))
    headline(page, "Box: 14 impacts", SEPARATOR.join(LONG[:3]))
    assert [text.get_text() for text in page.texts] == ["Box: 14 impacts", SEPARATOR.join(LONG[:3])]

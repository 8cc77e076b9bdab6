"""The style of all pictures: distinguishable colours, and a headline over the panels."""

# Tests: pictures/drawing/axis_numbers.py, pictures/drawing/colours.py, pictures/drawing/head_and_foot.py

import itertools

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.axis_numbers import force_text
from chain_impact.pictures.drawing.colours import LOAD, PALETTE
from chain_impact.pictures.drawing.dark_ground import Ground
from chain_impact.pictures.drawing.head_and_foot import fitted_lines, write_headline
from chain_impact.pictures.drawing.law_looks import LAW_LOOKS
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.over_time.energies import ENERGIES
from chain_impact.text import number_text
from tests.pictures.pictures import contrast, lab_colour

# what readers without one kind of cones see (Machado, Oliveira and Fernandes 2009, severity 1)
SIGHTS = {
    "all cones": np.eye(3),
    "no long waves": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "no middle waves": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "no short waves": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}


@pytest.mark.parametrize("colour", sorted({*PALETTE, *ENERGIES.values(), LOAD}))
def test_a_line_on_white_has_the_contrast_of_graphical_objects(colour):
    assert contrast("white", colour) >= 3.0  # WCAG 2.1, 1.4.11


@pytest.mark.parametrize("sight", SIGHTS)
def test_the_colours_of_curves_differ_for_each_kind_of_sight(sight):
    """A difference of 10 in CIELAB is seen at a glance, but not between thin lines."""
    for first, second in itertools.combinations(PALETTE, 2):
        assert np.linalg.norm(lab_colour(first, SIGHTS[sight]) - lab_colour(second, SIGHTS[sight])) > 15.0


@pytest.mark.parametrize("sight", SIGHTS)
def test_laws_with_the_same_dashes_differ_for_each_kind_of_sight(sight):
    assert len({look["color"] for look in LAW_LOOKS.values()}) == len(LAW_LOOKS)
    for law_look, other_look in itertools.combinations(LAW_LOOKS.values(), 2):
        if law_look.get("linestyle") == other_look.get("linestyle"):
            for drawn_colour, least_distance in (
                (to_hex, 15.0),
                (Ground("black", "white").suited_colour, 12.0),
            ):
                first, second = (
                    lab_colour(drawn_colour(look["color"]), SIGHTS[sight]) for look in (law_look, other_look)
                )
                assert np.linalg.norm(first - second) > least_distance


@pytest.mark.parametrize("conditions", ["", "4 links"])
def test_the_headline_leaves_the_panels_room(conditions):
    page = Figure(figsize=(6.0, 4.0), layout="constrained")
    axes = page.add_subplot()
    write_headline(page, "What it says", conditions)
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
    assert number_text(value) == text


LONG = [
    "4 links",
    "joint friction ≤ 0.02 N·m",
    "law zhang_sharf",
    "stiffness K = 1e8 N/m$^{1.5}$",
    "friction µ = 0.3 (static 0.4), 0.1 (static 0.2) at y_min, 0.5 (static 0.6) at ramp",
    "stops law newton_impact, e = 0.5",
    "method auto, tolerance 1e-8",
]


def single_line(page):
    """Return the height of a line of conditions [pixels]."""
    return page.text(0.0, 0.5, "K", fontsize="small").get_window_extent().height


def test_the_lines_of_a_headline_end_after_a_part():
    page = Figure(figsize=(7.5, 4.0), layout="constrained")
    write_headline(
        page, "Arm: 30 equal impulses of 0.981 N·s, 30 impacts in 3 s, 4.81 J dissipated, 4.81 J supplied"
    )
    assert page.get_suptitle().count("\n") == 1
    assert ",\n" in page.get_suptitle()


@pytest.mark.parametrize("width", [4.0, 6.0, 10.0])
def test_a_headline_and_its_conditions_fit_the_page(width):
    page = Figure(figsize=(width, 5.0), layout="constrained")
    axes = page.subplots()
    write_headline(
        page,
        "Box: 14 impacts, 82 % of the energy dissipated, 12 % of it by dry friction",
        SEPARATOR.join(LONG),
    )
    page.draw_without_rendering()
    message, conditions = page.texts
    boxes = [text.get_window_extent() for text in (message, conditions)]
    for box in boxes:
        assert page.bbox.x0 <= box.x0 < box.x1 <= page.bbox.x1
    top_of_conditions, bottom_of_message = boxes[1].y1, boxes[0].y0
    if width < 6.0:  # the conditions are at the bottom of a narrow page
        assert top_of_conditions < axes.get_tightbbox().y0
    else:
        assert axes.get_tightbbox().y1 < boxes[1].y0
        assert top_of_conditions < bottom_of_message
    assert boxes[1].height > 1.5 * single_line(page)


def test_a_text_that_fits_stays_in_one_line():
    page = Figure(figsize=(10.0, 5.0))
    write_headline(page, "Box: 14 impacts", SEPARATOR.join(LONG[:3]))
    assert [text.get_text() for text in page.texts] == ["Box: 14 impacts", SEPARATOR.join(LONG[:3])]


@pytest.mark.parametrize(("value", "text"), [(9.9996, "10.0 N"), (999.96, "1.00 kN"), (12.34, "12.3 N")])
def test_a_force_has_three_digits_after_rounding(value, text):
    assert force_text(value, "N") == text


def test_no_line_begins_with_a_number_inside_a_part():
    page, text = Figure(figsize=(1.8, 3.0)), "impact 1: point 2 hits y_min at 0.497 s, with 2.92 m/s"
    assert not any(line[0].isdigit() for line in fitted_lines(page, text).split("\n"))


def test_no_line_ends_between_a_name_and_its_number():
    page, text = (
        Figure(figsize=(3.0, 3.0)),
        SEPARATOR.join(f"restitution e = 0.{k}, most ≤ {k} J, 1{k} kN, 2 %" for k in range(9)),
    )
    lines = fitted_lines(page, text).split("\n")
    assert len(lines) > 3
    assert not any(line.endswith(("=", "≤")) or line.startswith(("=", "≤", "J", "kN", "%")) for line in lines)

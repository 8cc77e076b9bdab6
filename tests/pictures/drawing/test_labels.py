"""Labels stand beside their places, and never overlap another label, a line or a mark."""

# Tests: pictures/drawing/used_pixels.py, pictures/texts/impact_numbers.py, pictures/drawing/line_breaks.py

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from chain_impact.pictures.drawing.labels import Label, folded_label, place_labels
from chain_impact.pictures.drawing.used_pixels import UsedPixels
from chain_impact.pictures.texts.impact_numbers import number_list


@pytest.fixture
def axes():
    return Figure(figsize=(4.0, 3.0), layout="constrained").add_subplot()


def test_the_first_keeps_its_place_and_those_that_have_no_room_are_told(axes):
    labels = [Label(str(k), (0.5 + 0.001 * k, 0.5)) for k in range(60)]
    left = place_labels(axes, labels, UsedPixels(axes.figure), fontsize=7)
    shown_texts = [text.get_text() for text in axes.texts]
    assert shown_texts[0] == "0"
    assert 1 < len(shown_texts) < 60
    assert sorted([*shown_texts, *(label.text for label in left)]) == sorted(map(str, range(60)))
    for first, second in itertools.combinations([text.get_window_extent() for text in axes.texts], 2):
        assert not first.overlaps(second)


def test_a_label_turns_to_where_it_keeps_inside(axes):
    assert (
        place_labels(
            axes, [Label("wide label", (1.0, 0.5)), Label("high", (0.5, 1.0))], UsedPixels(axes.figure)
        )
        == []
    )
    axes_box = axes.get_window_extent()
    for text in axes.texts:
        box = text.get_window_extent()
        assert axes_box.x0 <= box.x0 <= box.x1 <= axes_box.x1
        assert axes_box.y0 <= box.y0 <= box.y1 <= axes_box.y1


def test_a_label_without_a_leader_is_nearest_to_its_own_place(axes):
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    labels = [Label(f"1{k}", (0.5 + 0.04 * (k % 5), 0.05 * (k // 5))) for k in range(25)]
    place_labels(axes, labels, UsedPixels(axes.figure))
    places = axes.transData.transform([label.position for label in labels])
    assert len(axes.texts) > 2
    for text in axes.texts:
        box = text.get_window_extent()
        distances = np.hypot(*(places - 0.5 * (box.min + box.max)).T)
        place = axes.transData.transform(text.xy)
        assert (places[distances.argmin()] == place).all(), text.get_text()
        assert text.arrow_patch is None


def test_a_label_stands_on_the_side_it_is_meant_for(axes):
    sides = [Label("left", (0.5, 0.2), (-1.0, 0.0)), Label("below", (0.5, 0.8), (0.0, -1.0))]
    place_labels(axes, sides, UsedPixels(axes.figure))
    left_box, lower_box = (text.get_window_extent() for text in axes.texts)
    assert left_box.x1 < axes.transData.transform((0.5, 0.2))[0]
    assert lower_box.y1 < axes.transData.transform((0.5, 0.8))[1]


def test_a_wide_label_leaves_the_best_position_of_the_next_place_free(axes):
    axes.axhline(0.5, color="black")
    downwards = (0.0, -1.0)
    wide_label, next_label = (
        Label("7, 10 + 4 more", (0.5, 0.5), downwards),
        Label("2", (0.45, 0.5), downwards),
    )
    assert place_labels(axes, [wide_label, next_label], UsedPixels(axes.figure), lines=True) == []
    first, second = axes.texts
    assert second.get_text() == "2"
    assert second.get_window_extent().y1 > axes.transData.transform((0.0, 0.5))[1] - 25.0  # at its place
    assert not first.get_window_extent().overlaps(second.get_window_extent())


def test_a_label_meets_no_line(axes):
    axes.plot([0.0, 1.0], [0.55, 0.55], color="0.8", linewidth=1.0)
    axes.set(ylim=(0.0, 1.0))
    place_labels(axes, [Label("above", (0.5, 0.5))], UsedPixels(axes.figure))
    (text,) = axes.texts
    y = axes.transData.transform((0.5, 0.55))[1]
    box = text.get_window_extent()
    assert box.y1 < y or box.y0 > y


def test_a_line_leads_to_a_label_that_is_far_from_its_place(axes):
    axes.plot([0.5], [0.5], "o", color="0.8", markersize=40.0)
    label = [Label("1", (0.5, 0.5))]
    assert place_labels(axes, label, UsedPixels(axes.figure)) == label
    assert place_labels(axes, label, UsedPixels(axes.figure), lines=True) == []
    assert axes.texts[0].arrow_patch is not None


def test_a_label_finds_room_between_rays(axes):
    """Eighths of a turn, at which labels are first tried, all have a ray."""
    for angle in np.linspace(0.0, 2.0 * np.pi, 9):
        axes.plot([0.5, 0.5 + np.cos(angle)], [0.5, 0.5 + np.sin(angle)], color="0.8", linewidth=0.6)
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    assert place_labels(axes, [Label("1", (0.5, 0.5))], UsedPixels(axes.figure), lines=True, fontsize=7) == []


def test_a_line_to_a_label_passes_no_other_label(axes):
    axes.plot([0.5], [0.5], "o", color="0.8", markersize=40.0)
    place_labels(axes, [Label(str(k), (0.5, 0.5)) for k in range(8)], UsedPixels(axes.figure), lines=True)
    axes.figure.draw_without_rendering()
    boxes = [Text.get_window_extent(text) for text in axes.texts]
    assert len(boxes) > 2
    place = axes.transData.transform((0.5, 0.5))
    for box, other_box in itertools.permutations(boxes, 2):
        middle = 0.5 * (box.min + box.max)
        ray = place + np.linspace(0.0, 1.0, 200)[:, None] * (middle - place)
        assert not any(other_box.contains(*point) for point in ray)


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [([3], "3"), ([9, 3, 8, 7, 3], "3, 7–9"), ([1, 2], "1, 2"), ([], ""), ([9, 1, 3, 7, 5], "1, 3 … 9")],
)
def test_numbers_in_a_row_are_told_by_the_first_and_the_last(numbers, expected):
    assert number_list(numbers) == expected


def test_a_line_to_a_label_goes_around_a_strong_line_if_it_can():
    page = Figure((4.0, 4.0), dpi=100)
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 4.0), ylim=(0.0, 4.0))
    axes.axis("off")
    # this area covers all positions next to the place
    axes.fill([1.7, 2.3, 2.3, 1.7], [1.7, 1.7, 2.3, 2.3], color="0.93")
    wall = axes.plot([2.45, 2.45], [0.0, 4.0], color="black")[0].get_xdata()[0]
    assert not place_labels(axes, [Label("1", (2.0, 2.0), (1.0, 0.0))], UsedPixels(page), lines=True)
    (label,) = axes.texts
    page.draw_without_rendering()
    box = label.get_window_extent().transformed(axes.transData.inverted())
    assert box.x1 < wall


def ruled_page(count, colour, width):
    """Return a page with lines across all of it, and its axes."""
    page = Figure((4.0, 4.0), dpi=100)
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 4.0), ylim=(0.0, 4.0))
    axes.axis("off")
    for y in np.linspace(0.0, 4.0, count):
        axes.plot([0.0, 4.0], [y, y], color=colour, linewidth=width)
    return page, axes


def test_a_number_without_free_room_is_outlined_on_pale_lines():
    page, axes = ruled_page(200, "0.85", 0.6)
    label = Label("1, 3", (2.0, 2.0))
    assert place_labels(axes, [label], UsedPixels(page)) == [label]
    assert place_labels(axes, [label], UsedPixels(page), lines=True) == []
    (text,) = axes.texts
    assert text.get_path_effects()
    page, axes = ruled_page(200, "0.3", 0.6)
    assert place_labels(axes, [label], UsedPixels(page), lines=True) == [label]


def test_a_label_on_pale_lines_is_better_than_a_line_across_a_link():
    page, axes = ruled_page(200, "0.85", 0.6)
    axes.fill([2.3, 4.0, 4.0, 2.3], [0.0, 0.0, 4.0, 4.0], color="white", zorder=3)
    link = 2.25
    axes.plot([link, link], [0.0, 4.0], color="black", linewidth=3.0, zorder=4)
    assert not place_labels(
        axes, [Label("1", (2.1, 2.0), (1.0, 0.0))], UsedPixels(page), lines=True, fontsize=7
    )
    page.draw_without_rendering()
    (text,) = axes.texts
    assert Text.get_window_extent(text).transformed(axes.transData.inverted()).x1 < link


def test_leaders_avoid_rims_of_marks_and_other_leaders():
    page = Figure((4.0, 4.0), dpi=100)
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 4.0), ylim=(0.0, 4.0))
    axes.axis("off")
    axes.plot([2.5, 2.5], [0.0, 4.0], color="black", linewidth=3.0)
    axes.plot([2.5], [2.0], "o", color="black", markeredgecolor="white", markeredgewidth=1.0, markersize=10.0)
    used_pixels, points = UsedPixels(page), 100 / 72.0
    low, high = np.array([300.0, 206.0]), np.array([320.0, 226.0])
    assert not used_pixels.take(low, high, np.array([200.0, 205.0]), 6.0 * points, crossed=0.0)
    assert used_pixels.take(np.array([100.0, 300.0]), np.array([110.0, 310.0]), np.array([10.0, 200.0]))
    assert not used_pixels.take(np.array([100.0, 190.0]), np.array([110.0, 200.0]), np.array([10.0, 305.0]))


def test_a_label_in_a_narrow_area_has_two_lines():
    page = Figure((4.0, 4.0), dpi=100)
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 4.0), ylim=(0.0, 4.0))
    axes.axis("off")
    axes.fill([1.0, 4.0, 4.0, 1.0], [0.0, 0.0, 4.0, 4.0], color="black")
    assert not place_labels(axes, [Label("3, 5 + 13 more", (0.5, 2.0))], UsedPixels(page), lines=True)
    (text,) = axes.texts
    assert text.get_text() == "3, 5\n+ 13 more"


@pytest.mark.parametrize(
    ("words", "expected"), [("3", "3"), ("1, 3, 5", "1, 3,\n5"), ("2, 6 + 13 more", "2, 6\n+ 13 more")]
)
def test_a_text_with_several_parts_is_folded(words, expected):
    assert folded_label(words) == expected


def test_no_leader_ends_inside_a_strong_body():
    page = Figure((4.0, 4.0), dpi=100)
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 4.0), ylim=(0.0, 4.0))
    axes.axis("off")
    axes.fill([1.6, 2.4, 2.4, 1.6], [1.6, 1.6, 2.4, 2.4], color="black")
    label_inside, label_at_edge = Label("6, 9", (2.0, 2.0)), Label("4", (2.38, 2.0), (1.0, 0.0))
    assert place_labels(axes, [label_inside, label_at_edge], UsedPixels(page), lines=True) == [label_inside]


def test_another_order_is_tried_if_a_label_has_no_room():
    page = Figure((4.0, 4.0), dpi=100)
    axes = page.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, 4.0), ylim=(0.0, 4.0))
    axes.axis("off")
    axes.fill([0.0, 4.0, 4.0, 0.0], [0.0, 0.0, 4.0, 4.0], color="black")
    for x in (1.57, 1.91):  # of the two free areas, the right one is near both positions
        axes.fill([x, x + 0.18, x + 0.18, x], [1.91, 1.91, 2.09, 2.09], color="white")
    labels = [Label("1", (1.83, 2.0), (1.0, 0.0)), Label("2", (2.17, 2.0))]
    assert place_labels(axes, labels, UsedPixels(page), lines=True, fontsize=9) == []
    page.draw_without_rendering()
    first, second = sorted(axes.texts, key=Text.get_text)
    assert Text.get_window_extent(first).x1 < 183.0 < Text.get_window_extent(second).x0


def test_labels_in_a_row_do_not_read_as_one(axes):
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    texts, point = ("5 + 14 more", "2, 6 + 13 more"), axes.figure.dpi / 72.0
    axes.figure.draw_without_rendering()
    widths = [axes.text(0.0, 0.0, text).get_window_extent().width for text in texts]
    for text in [*axes.texts]:
        text.remove()
    way = (0.5 * sum(widths) + 3.0 * point) / axes.get_window_extent().width
    assert (
        place_labels(
            axes, [Label(texts[0], (0.3, 0.5)), Label(texts[1], (0.3 + way, 0.5))], UsedPixels(axes.figure)
        )
        == []
    )
    first, second = (text.get_window_extent() for text in axes.texts)
    assert second.x0 - first.x1 > 5.0 * point or second.y0 > first.y1 or first.y0 > second.y1


def test_a_line_behind_a_label_is_not_seen_between_its_words(axes):
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    for height in np.linspace(0.0, 1.0, 60):
        axes.axhline(height, color="0.8")
    assert (
        place_labels(
            axes, [Label("joint 2: 670 N", (0.5, 0.5))], UsedPixels(axes.figure), lines=True, fontsize="small"
        )
        == []
    )
    (text,) = axes.texts
    box = text.get_window_extent()
    canvas = FigureCanvasAgg(axes.figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[::-1, :, 0]
    words = pixels[int(box.y0) + 2 : int(box.y1) - 2, int(box.x0) : int(box.x1)]
    assert (words[:, :-3] == round(0.8 * 255)).mean() < 0.01

"""The height that a figure needs."""

# Tests: pictures/drawing/axis_labels.py

import pytest

from chain_impact.pictures.drawing.figures import fitting_figure, least_figure


@pytest.mark.parametrize("lines", [12, 40])
def test_the_least_height_is_found_by_bisection(lines):
    heights = []

    def fill(figure):
        heights.append(float(figure.get_figheight()))
        figure.text(0.1, 0.02, "\n".join("x" * lines), fontsize=12)

    lowest = float(least_figure(fill, 4.0, 0.5).get_figheight())
    assert lowest == min(height for height in heights if height >= lowest)
    assert max(height for height in heights if height < lowest) == lowest - 0.25
    assert len(heights) <= 6  # a bisection of 39 heights


def test_a_height_at_which_only_texts_overlap_is_exceeded_in_small_steps():
    heights = []

    def fill(figure):
        heights.append(float(figure.get_figheight()))
        for row, place in ((0.01, "bottom"), (0.99, "top")):
            figure.text(0.5, row, "\n".join("x" * 6), fontsize=12, va=place)

    assert least_figure(fill, 4.0, 0.5, lacking=1.2).get_figheight() == 2.5
    assert heights == [1.75, 2.0, 2.5, 2.25]


def test_a_figure_as_high_as_a_page_is_drawn_once_for_usual_and_low_axes():
    heights = []

    def fill(figure):
        heights.append(float(figure.get_figheight()))
        for axes in figure.subplots(6, 1):
            axes.set(ylabel="y")

    figure = fitting_figure(fill, 4.0, (4.0, 9.0))
    assert heights == [figure.get_figheight()]
    assert 0.7 < sum(axes.bbox.height / figure.dpi for axes in figure.axes) / 6 < 1.0


@pytest.mark.parametrize("panels", [4, 7])
def test_a_figure_of_several_panels_fits_on_a_page(panels):
    """4 panels have room for axes of the usual height, 7 panels only for lower ones."""

    def fill(figure):
        for axes in figure.subplots(panels, 1):
            axes.set(ylabel="y", xlabel="x")

    figure = fitting_figure(fill, 4.0, (10.0, 2.9 * panels))
    assert figure.get_figheight() <= 8.75  # [inch] a printed page with margins has room for this height
    assert min(axes.bbox.height / figure.dpi for axes in figure.axes) >= 0.65

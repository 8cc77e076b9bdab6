"""The height that a figure needs."""

import pytest

from chain_impact.pictures.drawing.figures import fitting_figure, least_figure


@pytest.mark.parametrize("lines", [12, 40])
def test_the_least_height_is_found_by_bisection(lines):
    heights = []

    def fill(figure):
        heights.append(float(figure.get_figheight()))
        figure.text(0.1, 0.02, "\n".join("x" * lines), fontsize=12)

    least = float(least_figure(fill, 4.0, 0.5).get_figheight())
    assert least == min(height for height in heights if height >= least)
    assert max(height for height in heights if height < least) == least - 0.25
    assert len(heights) <= 6  # 39 heights, halved


@pytest.mark.parametrize("panels", [4, 7])
def test_a_figure_of_several_panels_fits_on_a_page(panels):
    """Beside 4 panels there is room for axes with their usual height, beside 7 only for lower ones."""

    def fill(figure):
        for axes in figure.subplots(panels, 1):
            axes.set(ylabel="y", xlabel="x")

    figure = fitting_figure(fill, 4.0, (10.0, 2.9 * panels))
    assert figure.get_figheight() <= 8.75  # [inch] a printed page with margins has room for this height
    assert min(axes.bbox.height / figure.dpi for axes in figure.axes) >= 0.65

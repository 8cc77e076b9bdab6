"""The height that a figure needs."""

import pytest

from chain_impact.pictures.drawing.figures import least_figure


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

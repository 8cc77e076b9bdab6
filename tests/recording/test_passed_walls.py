"""Results, summaries and pictures tell which points pass through a wall."""

import pytest

from chain_impact import simulate
from chain_impact.cli import screen
from tests.helpers.scenes.problems import default_scene


@pytest.mark.parametrize("points", [[1], [0, 1, 2, 3, 4]])
def test_points_that_pass_through_a_wall_are_reported(points):
    """A chain that falls onto the floor: points that may not touch it fall through it."""
    result = simulate(default_scene().with_values({"contact.points": points}), stop_time=0.8)
    through = [
        k for k in range(5) if result[f"point[{k}].y"].min() < -0.01 < 0.01 < result[f"point[{k}].y"].max()
    ]
    assert len(through) == (4 if points == [1] else 0)
    notes = [
        f"points {', '.join(map(str, through))} pass through y_min without touching it: see contact.points"
    ]
    assert result.points_through_walls == (notes if through else [])
    for line in notes:
        assert (f"note     {line}" in repr(result).splitlines()) == bool(through)
        assert (f"note     {line}" in list(screen.summary(result))) == bool(through)
        texts = [text.get_text().replace("\n", " ") for text in result.plot(panels="energy").texts]
        assert any(line in text for text in texts) == bool(through)

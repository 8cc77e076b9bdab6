"""The estimate of errors by a second run at a tighter tolerance."""

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.studies.accuracy import TOLERANCE_RATIO, differences
from tests.helpers.scenes.problems import default_scene


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_the_estimate_is_the_error_within_a_fifth(tolerance):
    """The true error is the distance from the result at the tightest tolerance."""
    run, tighter, exact = (
        simulate(default_scene(), 1.2, tolerance=t) for t in (tolerance, TOLERANCE_RATIO * tolerance, 1e-13)
    )
    found = differences(run, tighter)
    onset = np.abs(run.impacts["onset"] - exact.impacts["onset"]).max()
    position = np.linalg.norm(run.points - exact.points, axis=-1)
    assert found.impacts == len(exact.impacts) == 6
    assert not found.parted
    assert found.onset == pytest.approx(onset, rel=0.2)
    assert found.position == pytest.approx(position.max(), rel=0.2)
    assert found.time == run.time[position.max(axis=1).argmax()]
    assert found.point == f"point {position.max(axis=0).argmax()}"


def test_only_what_comes_before_other_impacts_is_compared():
    """Two runs with different restitutions have the same motion until the first impact has begun."""
    run, other = (simulate(default_scene().with_values({"contact.restitution": e}), 1.2) for e in (0.7, 0.1))
    found = differences(run, other)
    points = [[tuple(impact) for impact in each.impacts[["point", "wall"]]] for each in (run, other)]
    assert points[0][: found.impacts] == points[1][: found.impacts]
    assert points[0][found.impacts] != points[1][found.impacts]
    assert found.parted
    assert found.end == min(each.impacts["onset"][found.impacts] for each in (run, other))
    assert found.time <= found.end < 1.2


def test_a_run_that_ends_early_is_compared_as_far_as_it_goes():
    run, whole = simulate(default_scene(), 0.4), simulate(default_scene(), 0.6)
    found = differences(run, whole)
    assert (found.impacts, found.onset, found.position, found.end, found.parted) == (0, 0.0, 0.0, 0.4, False)

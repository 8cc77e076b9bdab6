"""The estimate of errors by a second run at a tighter tolerance."""

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.studies.accuracy import TOLERANCE_RATIO, differences
from tests.helpers.scenes.problems import default_scene


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_the_estimate_is_the_error_within_a_fifth(tolerance):
    """The true error is the distance from the result at the tightest tolerance."""
    run, tighter, exact_run = (
        simulate(default_scene(), 1.2, tolerance=t) for t in (tolerance, TOLERANCE_RATIO * tolerance, 1e-13)
    )
    difference = differences(run, tighter)
    onset = np.abs(run.impacts["onset"] - exact_run.impacts["onset"]).max()
    position = np.linalg.norm(run.points - exact_run.points, axis=-1)
    assert difference.impacts == len(exact_run.impacts) == 6
    assert not difference.parted
    assert difference.onset == pytest.approx(onset, rel=0.2)
    assert difference.position == pytest.approx(position.max(), rel=0.2)
    assert difference.time == run.time[position.max(axis=1).argmax()]
    assert difference.point == f"point {position.max(axis=0).argmax()}"


def test_only_what_comes_before_other_impacts_is_compared():
    """Two runs with different restitutions have the same motion until the first impact has begun."""
    run, other_run = (
        simulate(default_scene().with_values({"contact.restitution": e}), 1.2) for e in (0.7, 0.1)
    )
    difference = differences(run, other_run)
    points = [[tuple(impact) for impact in result.impacts[["point", "wall"]]] for result in (run, other_run)]
    assert points[0][: difference.impacts] == points[1][: difference.impacts]
    assert points[0][difference.impacts] != points[1][difference.impacts]
    assert difference.parted
    assert difference.end == min(result.impacts["onset"][difference.impacts] for result in (run, other_run))
    assert difference.time <= difference.end < 1.2


def test_a_run_that_ends_early_is_compared_as_far_as_it_goes():
    run, longer_run = simulate(default_scene(), 0.4), simulate(default_scene(), 0.6)
    difference = differences(run, longer_run)
    assert (difference.impacts, difference.onset, difference.position, difference.end, difference.parted) == (
        0,
        0.0,
        0.0,
        0.4,
        False,
    )

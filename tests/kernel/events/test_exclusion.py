"""What is known of clearances without looking: never more than is there."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from chain_impact.kernel.events.exclusion import FAR, WITH_CURVES, known_clearances
from chain_impact.scene.scene import load_scene, with_values
from chain_impact.simulation.instance import Instance
from tests.plain import Plain


def steps(instance, until):
    """The record after each step; its `step` is the one that was taken."""
    d = instance.record
    while d["step"]["end"] < until:
        instance.advance(math.nextafter(d["step"]["end"], math.inf))
        yield d


def least_clearance(d):
    """Of the candidates that are apart at the end of the last step [m], from angles and position."""
    y, lengths = d["step"]["state_end"], d["model"]["length"]
    angles = y[2 : 2 + len(lengths)]
    turns = np.cumsum(np.column_stack([np.cos(angles), np.sin(angles)]) * lengths[:, None], axis=0)
    points = y[:2] + np.vstack([np.zeros(2), turns])
    wall, point = d["candidate"]["wall"], d["candidate"]["point"]
    gaps = (1 - 2 * (wall % 2)) * (points[point, wall // 2] - d["model"]["wall"][wall])
    return gaps[d["touch"]["active"] == 0].min()


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    angles=st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4),
    speeds=st.lists(st.floats(-20.0, 20.0), min_size=4, max_size=4),
    tolerance=st.sampled_from([1e-2, 1e-4, 1e-8]),
)
def test_there_is_at_least_the_room_that_is_remembered(angles, speeds, tolerance):
    place = {("initial", "position"): (2.0, 2.0), ("initial", "angles"): tuple(angles)}
    walls = {("box", name): value for name, value in zip(("x_min", "y_min"), (-0.5, -0.5), strict=True)}
    walls |= {("box", name): 4.5 for name in ("x_max", "y_max")}
    more = {("initial", "angular_velocities"): tuple(speeds), ("solver", "tolerance"): tolerance}
    instance = Instance(with_values(load_scene("four_link_box"), place | walls | more))
    seen = 0
    for d in steps(instance, 0.8):
        if known_clearances(Plain(d)) in (WITH_CURVES, FAR):
            seen += 1
            assert d["search"]["safe_distance"] <= least_clearance(d) + 1e-12
    assert seen > 0 or tolerance == 1e-2  # whose steps can turn links by more than the test is made for


def test_far_walls_are_left_alone_through_an_impact():
    instance = Instance(load_scene("four_link_box"))
    kinds = [
        known_clearances(Plain(d))
        for d in steps(instance, 0.5012)
        if d["step"]["start"] > 0.49945 and d["touch"]["active_count"] == 1
    ]
    assert len(kinds) > 8
    assert kinds.count(FAR) >= len(kinds) - 2

"""What a search for crossings goes by: bounds on speeds and accelerations, and the intervals of a step."""

import numpy as np
import pytest

from chain_impact.kernel.chain.state import omega_at, sundman_u_at, velocity_at
from chain_impact.kernel.events import crossing
from chain_impact.kernel.events.crossing import QUIET, SPLIT, bound_curvature, find_crossing, motion_bounds
from chain_impact.kernel.events.exclusion import suspect_all
from chain_impact.kernel.integration.dense import rate_bounds, rate_bounds_along
from chain_impact.kernel.integration.sundman import NO_CONTACT
from tests.kernel.chains import stopped_chain, stops_of

LINKS = 3


@pytest.fixture
def moving():
    """A chain with stops in its joints, a step of any motion, and the bounds of its base along the axes."""
    rng = np.random.default_rng(29)
    _, d = stopped_chain(LINKS, "pinned")
    d.step.state[:] = rng.uniform(-1.0, 1.0, d.step.state.shape)
    d.step.dense[:] = rng.uniform(-1.0, 1.0, d.step.dense.shape)
    d.step.size = 0.2
    suspect_all(d)
    first = velocity_at(LINKS)
    return d, rate_bounds(d.step, first), rate_bounds(d.step, first + 1)


def test_a_point_is_bounded_along_the_normal_of_its_wall(moving):
    d, along_x, along_y = moving
    seen = set()
    for c in set(range(d.candidates)) - set(stops_of(d)):
        nx, ny = d.candidate.normal_x[c], d.candidate.normal_y[c]
        right = rate_bounds_along(d.step, velocity_at(LINKS), nx, ny)
        assert motion_bounds(d, c, along_x, along_y) == pytest.approx(right, rel=1e-12)
        seen.add((abs(nx) > 0.5, nx * ny == 0.0))
    assert len(seen) > 2


def test_a_joint_is_bounded_by_the_turn_of_its_link_relative_to_the_one_before(moving):
    d, along_x, along_y = moving
    at, joints = omega_at(LINKS), set()
    for c in stops_of(d):
        joint = int(d.candidate.point[c])
        joints.add(joint)
        found = motion_bounds(d, c, along_x, along_y)
        values, dense = d.step.state[at + joint - 1], d.step.dense[:, at + joint - 1].copy()
        if joint > 1:
            values, dense = values - d.step.state[at + joint - 2], dense - d.step.dense[:, at + joint - 2]
        before, kept = d.step.state[0], d.step.dense[:, 0].copy()
        d.step.state[0], d.step.dense[:, 0] = values, dense
        turn, change = rate_bounds(d.step, 0)
        d.step.state[0], d.step.dense[:, 0] = before, kept
        # at the lever arm of a stop, the longest link
        assert found == pytest.approx((d.model.size * turn, d.model.size * change), rel=1e-12)
    assert joints == {1, 2, 3}


@pytest.mark.parametrize(
    ("near", "ends"),
    [
        (0.0, [1.0, 0.5, 0.25, 0.125, 0.25, 0.5, 1.0]),
        (0.3, [1.0, 0.5, 0.25, 0.5, 0.375, 0.5, 1.0]),
        (0.6, [1.0, 0.5, 1.0, 0.75, 0.625, 0.75, 1.0]),
    ],
)
def test_intervals_are_halved_where_they_must_and_as_wide_as_they_can_be_after_that(monkeypatch, near, ends):
    """Those of the bisection: [k/2ⁿ, (k+1)/2ⁿ], here down to 1/8 where they hold some moment."""
    _, d = stopped_chain(1, "pinned")
    seen = []
    monkeypatch.setattr(crossing, "measure", lambda _, b: seen.append(b))
    monkeypatch.setattr(crossing, "keep_start", lambda _: None)
    monkeypatch.setattr(
        crossing, "check_interval", lambda _, a, b: SPLIT if a <= near < b and b - a > 0.125 else QUIET
    )
    assert find_crossing(d) == -1.0
    assert seen == ends


def test_the_curvature_of_a_stop_is_that_of_its_joint_and_of_a_point_that_of_the_links_before_it(moving):
    d, along_x, along_y = moving
    d.step.regularized = NO_CONTACT
    bound_curvature(d)
    reach = [0.0]
    for i in range(LINKS):
        omega, alpha = rate_bounds(d.step, omega_at(LINKS) + i)
        reach.append(reach[-1] + d.model.length[i] * (alpha + omega**2))
    for c in range(d.candidates):
        _, bend = motion_bounds(d, c, along_x, along_y)
        links = 0.0 if d.candidate.stop[c] else reach[d.candidate.point[c]]
        assert d.search.curvature[c] == pytest.approx(bend + links, rel=1e-12)


def test_in_another_variable_it_is_that_of_the_motion_at_its_pace(moving):
    """d²g/ds² = p² g̈ + p′ ġ, with p and p′ at most u and u′."""
    d, along_x, along_y = moving
    d.step.regularized = 0
    bound_curvature(d)
    p, change = rate_bounds(d.step, sundman_u_at(LINKS))
    reach = [0.0]
    for i in range(LINKS):
        omega, alpha = rate_bounds(d.step, omega_at(LINKS) + i)
        reach.append(reach[-1] + d.model.length[i] * (p * (alpha + p * omega**2) + change * omega))
    for c in range(d.candidates):
        speed, bend = motion_bounds(d, c, along_x, along_y)
        links = 0.0 if d.candidate.stop[c] else reach[d.candidate.point[c]]
        assert d.search.curvature[c] == pytest.approx(p * bend + change * speed + links, rel=1e-12)

"""Walls as the kernel finds them from the record, against NumPy."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.model.geometry import (
    HARMLESS,
    NORMALS,
    WALLS,
    add_along_normal,
    add_impedance,
    along_normal,
    clearance,
    harmless_depth,
    normal,
    place_side,
    place_slope,
    place_walls,
)
from chain_impact.kernel.status import OK, PARAMETER_OUT_OF_RANGE
from chain_impact.scene.scene import with_values
from chain_impact.variables.model import Model
from tests.plain import Plain
from tests.problems import default_scene

# angle and point; the last angle is beyond what the kernel's own sines are for
SLOPES = [
    (-0.3, (-1.0, 0.2)),
    (math.pi / 2, (40.0, 3.0)),
    (3.0, (0.5, 30.0)),
    (-1.9, (-9.0, -7.0)),
    (1e7, (0, 30)),
]


def prepared(box):
    """The record of the default chain between walls at any angle, and in its box or without one."""
    walls = [{"name": f"w{w}", "point": point, "angle": angle} for w, (angle, point) in enumerate(SLOPES)]
    scene = with_values(default_scene(), {("walls",): walls} | ({} if box else {("box",): {}}))
    return scene, Plain(Model(scene).new_instance()[0])


@pytest.fixture(params=[True, False], ids=["box", "no box"])
def placed(request):
    scene, d = prepared(request.param)
    place_walls(d)
    return scene, d


def vectors(d, seed):
    """Any vectors of all points, in the record and as an array (N+1, 2)."""
    values = np.random.default_rng(seed).normal(size=(d.links + 1, 2))
    d.work.motion.x[:], d.work.motion.y[:] = values.T
    return d.work.motion, values


def test_each_candidate_has_the_normal_and_the_offset_of_its_wall(placed):
    scene, d = placed
    planes = list(scene.half_planes.values())
    for c in range(d.candidates):
        expected = planes[c % len(planes)]
        np.testing.assert_allclose(normal(d, c), expected.normal, rtol=0, atol=3e-16)
        assert d.candidate.offset[c] == pytest.approx(expected.offset, rel=1e-14, abs=1e-14)


def test_the_normals_of_the_box_are_exact():
    _, d = prepared(box=True)
    place_walls(d)
    sides = [c for c in range(d.candidates) if d.candidate.wall[c] < len(WALLS)]
    assert len(sides) == 4 * 5
    for c in sides:
        wall = d.candidate.wall[c]
        assert normal(d, c) == NORMALS[wall]
        assert abs(d.candidate.offset[c]) == abs(d.model.wall[wall])


def test_a_clearance_and_its_rate_are_those_of_the_point(placed):
    scene, d = placed
    d.contact.radius = 0.07
    y = np.random.default_rng(3).normal(size=len(d.work.y))
    locate_points(d, y)
    names = list(scene.half_planes)
    for c in range(d.candidates):
        point, wall = d.candidate.point[c], scene.half_planes[names[c % len(names)]]
        gap, rate = clearance(d, c)
        place = d.work.position.x[point], d.work.position.y[point]
        speed = np.array([d.work.velocity.x[point], d.work.velocity.y[point]])
        assert gap == pytest.approx(wall.clearance(*place) - 0.07, abs=1e-14)
        assert rate == pytest.approx(speed @ wall.normal, abs=1e-14)


def test_what_is_added_along_a_normal_is_found_along_it(placed):
    _, d = placed
    for c in range(d.candidates):
        motion, values = vectors(d, c)
        point, n = d.candidate.point[c], np.array(normal(d, c))
        assert along_normal(d, c, motion) == pytest.approx(values[point] @ n, abs=1e-15)
        add_along_normal(d, c, motion, 2.5)
        found = np.transpose([motion.x, motion.y])
        values[point] += 2.5 * n
        np.testing.assert_allclose(found, values, rtol=0, atol=1e-15)


def test_an_impedance_acts_along_the_normal_alone(placed):
    _, d = placed
    total = np.zeros((d.links + 1, 2, 2))
    for c in range(d.candidates):
        add_impedance(d, c, d.work.impedance, 1.0 + c)
        total[d.candidate.point[c]] += (1.0 + c) * np.outer(normal(d, c), normal(d, c))
    impedance = d.work.impedance
    for name, found in (("xx", total[:, 0, 0]), ("xy", total[:, 0, 1]), ("yy", total[:, 1, 1])):
        np.testing.assert_allclose(impedance[name], found, rtol=1e-14, atol=1e-13)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("name", ["x", "y", "angle"])
def test_a_wall_that_is_nowhere_is_refused(name, bad):
    _, d = prepared(box=True)
    assert initialize(d, 0.0) == OK
    d.walls[name][3] = bad
    assert initialize(d, 0.0) == PARAMETER_OUT_OF_RANGE


@pytest.mark.parametrize("c", [0, 3])
def test_a_candidate_can_be_given_any_wall(c):
    """Points on the wall have no clearance and those to its free side have their distance."""
    scene, d = prepared(box=True)
    planes = list(scene.half_planes.values())
    for side in range(len(WALLS)):
        place_side(d, c, side)
        assert normal(d, c) == planes[side].normal
        assert d.candidate.offset[c] == planes[side].offset
    for w, (angle, point) in enumerate(SLOPES):
        place_slope(d, c, w)
        along, n = np.array([math.cos(angle), math.sin(angle)]), np.array(normal(d, c))
        assert along[0] * n[1] - along[1] * n[0] == pytest.approx(1.0, abs=1e-15)  # n is to the left
        for distance in (0.0, 0.7):
            place = np.array(point) - 3.0 * along + distance * n
            d.work.position.x[:], d.work.position.y[:] = place
            gap, _ = clearance(d, c)
            assert gap + d.contact.radius == pytest.approx(distance, abs=3e-14)


def test_a_depth_is_harmless_by_round_off_of_a_link_and_none_in_a_rigid_wall():
    _, d = prepared(box=True)
    d.model.size, d.contact.impulsive = 2.5, 0
    assert harmless_depth(d) == 2.5 * HARMLESS
    # a force of 1e-10 N at 1e8 N/m^1.5, and more than round-off of positions
    assert 1e8 * harmless_depth(d) ** 1.5 < 1e-9
    assert harmless_depth(d) > 1e3 * 2.0**-53 * d.model.size
    d.contact.impulsive = 1
    assert harmless_depth(d) == 0.0

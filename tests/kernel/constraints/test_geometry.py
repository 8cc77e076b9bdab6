"""Walls as the kernel computes them from the record, against NumPy."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain import kinematics, mass_matrix_solver
from chain_impact.kernel.constraints.geometry import (
    BOX_NORMALS,
    add_along_row,
    add_forces_at_joint_places,
    add_impedance,
    add_joint_impedances,
    clear_used_forces,
    clearance_acceleration,
    clearance_and_rate,
    coordinate_sum,
    dot,
    length_bound,
    lever_of_candidate,
    normal_row,
    set_box_wall,
    set_candidate_rows,
    set_sloped_wall,
    tangent_row,
    tangential_rate,
)
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.record.constants import WALLS
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import with_values
from tests.helpers.kernel.plain import record_of
from tests.helpers.scenes.problems import default_scene
from tests.helpers.tools.differences import slope
from tests.kernel.chains import random_state, stopped_chain, stops_of

# angle and point; the last angle exceeds the range of the kernel's own sines
SLOPES = [
    (-0.3, (-1.0, 0.2)),
    (math.pi / 2, (40.0, 3.0)),
    (3.0, (0.5, 30.0)),
    (-1.9, (-9, -7)),
    (1e7, (0, 30)),
]


def prepared(box, changes=None):
    """Return the default chain between inclined walls, in its box or without one: scene and record."""
    walls = [{"name": f"w{w}", "point": point, "angle": angle} for w, (angle, point) in enumerate(SLOPES)]
    scene = with_values(
        default_scene(), {("walls",): walls} | ({} if box else {("box",): {}}) | (changes or {})
    )
    return scene, record_of(scene)


@pytest.fixture(params=[True, False], ids=["box", "no box"])
def placed(request):
    scene, d = prepared(request.param)
    set_candidate_rows(d)
    return scene, d


def test_each_candidate_has_the_normal_and_the_offset_of_its_wall(placed):
    scene, d = placed
    planes = list(scene.half_planes.values())
    for c in range(d.candidate_count):
        expected = planes[c % len(planes)]
        np.testing.assert_allclose(normal_row(d, c)[1:], expected.normal, rtol=0, atol=3e-16)
        assert d.candidate.offset[c] == pytest.approx(expected.offset, rel=1e-14, abs=1e-14)
        wall = d.candidate.wall[c]
        if wall < len(WALLS):  # walls of the box are exact
            assert normal_row(d, c)[1:] == BOX_NORMALS[wall]
            assert abs(d.candidate.offset[c]) == abs(d.chain.box_wall[wall])


def test_a_clearance_and_its_rate_are_those_of_the_point(placed):
    scene, d = placed
    d.contact_settings.radius = 0.07
    set_candidate_rows(d)
    y = np.random.default_rng(3).normal(size=len(d.scratch.state))
    kinematics.locate_points(d, y)
    names = list(scene.half_planes)
    for c in range(d.candidate_count):
        point, wall = d.candidate.point[c], scene.half_planes[names[c % len(names)]]
        gap, rate = clearance_and_rate(d, c)
        place = d.scratch.position.x[point], d.scratch.position.y[point]
        speed = np.array([d.scratch.velocity.x[point], d.scratch.velocity.y[point]])
        assert gap == pytest.approx(wall.clearance(*place) - 0.07, abs=1e-14)
        assert rate == pytest.approx(speed @ wall.normal, abs=1e-14)


@pytest.mark.parametrize("c", [0, 3])
def test_a_candidate_can_be_given_any_wall(c):
    """Points on the wall have no clearance, and points on its free side have their distance."""
    scene, d = prepared(box=True)
    planes = list(scene.half_planes.values())
    for side in range(len(WALLS)):
        set_box_wall(d, c, side)
        assert normal_row(d, c)[1:] == planes[side].normal
        assert d.candidate.offset[c] == planes[side].offset
    for w, (angle, point) in enumerate(SLOPES):
        set_sloped_wall(d, c, w)
        along, n = np.array([math.cos(angle), math.sin(angle)]), np.array(normal_row(d, c)[1:])
        assert along[0] * n[1] - along[1] * n[0] == pytest.approx(1.0, abs=1e-15)  # n is to the left
        for distance in (0.0, 0.7):
            place = np.array(point) - 3.0 * along + distance * n
            d.scratch.position.x[:], d.scratch.position.y[:] = place
            gap, _ = clearance_and_rate(d, c)
            assert gap + d.contact_settings.radius == pytest.approx(distance, abs=3e-14)


@pytest.fixture(params=["free", "pinned"])
def stopped(request):
    """Return a chain of three links with stops in its joints, located in some state: its record and state."""
    d = stopped_chain(3, request.param)[1]
    y = random_state(np.random.default_rng(7), d)
    kinematics.locate_points(d, y)
    return d, y


def differenced(d, y, change):
    """Return the changes of all clearances along a change of the coordinates, by central differences."""

    def gaps(shift):
        moved = y.copy()
        moved[: d.link_count + 2] += shift * change
        kinematics.locate_points(d, moved)
        return np.array([clearance_and_rate(d, c)[0] for c in range(d.candidate_count)])

    changes = slope(gaps, 0.0, 1e-6)
    kinematics.locate_points(d, y)
    return changes


def test_the_clearance_of_a_stop_is_angle_times_lever_arm(stopped):
    """g = s (ψ − joint_min) or s (joint_max − ψ); its rate equals a difference along the motion."""
    d, y = stopped
    size = d.chain.longest_link
    angles = np.diff(y[2:5], prepend=0.0)
    joints = [1, 2, 3] if d.chain.has_base_joint else [2, 3]
    assert lever_of_candidate(d, 0) == 1.0
    assert d.candidate.point[stops_of(d)].tolist() == list(np.repeat(joints, 2))
    for c in stops_of(d):
        joint, side = d.candidate.point[c] - 1, d.candidate.stop[c]
        limit = (d.drive.min if side > 0 else d.drive.max)[joint]
        assert clearance_and_rate(d, c)[0] == pytest.approx(size * side * (angles[joint] - limit), rel=1e-13)
        assert lever_of_candidate(d, c) == size
        assert (d.candidate.place[c], d.candidate.normal_x[c]) == (d.link_count + joint + 1, side)
    rates = np.array([clearance_and_rate(d, c)[1] for c in range(d.candidate_count)])
    np.testing.assert_allclose(rates, differenced(d, y, y[5:10]), rtol=0, atol=1e-6)


def assert_adjoint(d, rows, change):
    """Assert F·(J v) = (Jᵀ F)·v for directions of points and joints, and the energy D (J v)² of impedances.

    Also check loads and impedances of joints that have been converted into moments.
    """
    rng = np.random.default_rng(9)
    motion = d.scratch.place_change
    load = d.scratch.applied_force
    own = d.scratch.impedance
    turns, points = np.diff(change[2:], prepend=0.0), slice(0, d.link_count + 1)
    for row in rows:
        speed, force = dot(row, motion), rng.normal()
        load.x[:] = load.y[:] = load.joint[:] = own.xx[:] = own.xy[:] = own.yy[:] = own.joint[:] = 9.0
        clear_used_forces(d, load)
        add_along_row(row, load, 0.25 * force)
        add_along_row(row, load, 0.75 * force)
        assert load.x @ motion.x + load.y @ motion.y == pytest.approx(force * speed, rel=1e-12, abs=1e-14)
        add_forces_at_joint_places(d, load)
        power = load.x[points] @ motion.x[points] + load.y[points] @ motion.y[points] + load.joint @ turns
        assert power == pytest.approx(force * speed, rel=1e-12, abs=1e-14)
        mass_matrix_solver.clear_impedance(d, own)
        own.xy[d.link_count + 1 :] = own.yy[d.link_count + 1 :] = 0.0  # no function reads these numbers
        add_impedance(row, own, 1.0)
        add_impedance(row, own, 1.5)
        energy = own.xx @ motion.x**2 + 2.0 * (own.xy @ (motion.x * motion.y)) + own.yy @ motion.y**2
        assert energy == pytest.approx(2.5 * speed**2, rel=1e-12, abs=1e-14)
        add_joint_impedances(d, own)
        if row[0] > d.link_count:
            assert own.joint @ turns**2 == pytest.approx(2.5 * speed**2, rel=1e-12, abs=1e-14)


def any_change(d):
    """Return some change of the coordinates, along which the points and joints move."""
    change = np.random.default_rng(8).normal(size=d.link_count + 2)
    change[: 2 * d.chain.has_base_joint] = 0.0
    kinematics.move_points(d, d.scratch.link_vector, change, d.scratch.place_change)
    return change


def test_the_motion_and_the_load_of_contacts_are_adjoint(stopped):
    d, y = stopped
    change, bound = any_change(d), length_bound(d, d.scratch.place_change)
    rows = [normal_row(d, c) for c in range(d.candidate_count)]
    assert_adjoint(d, rows, change)
    speeds = [dot(row, d.scratch.place_change) for row in rows]
    assert np.abs(speeds).max() <= bound
    np.testing.assert_allclose(speeds, differenced(d, y, change), rtol=0, atol=1e-6)


def test_the_acceleration_of_a_joint_is_that_of_its_angle(stopped):
    """g̈ of a stop has no centripetal part."""
    d, y = stopped
    rate = np.zeros(len(y))
    rate[:5], rate[5:10] = y[5:10], np.random.default_rng(1).normal(size=5)
    kinematics.accelerate_points(d, y, rate)
    for c in stops_of(d):
        joint = d.candidate.point[c] - 1
        turn = rate[7 + joint] - (rate[6 + joint] if joint else 0.0)
        expected = d.candidate.stop[c] * d.chain.longest_link * turn
        assert clearance_acceleration(d, c) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("place", range(1, 7))
def test_any_place_may_be_the_fastest(place):
    """The places are points 0 to 3, and the joints of three links."""
    d = stopped_chain(3)[1]
    for axis in "xy":
        d.scratch.place_change[axis][:] = 0.25
    d.scratch.place_change.x[place] = -4.0
    assert length_bound(d, d.scratch.place_change) == (4.25 if place <= 3 else 4.0)
    d.chain.has_joint_stops = 0
    assert length_bound(d, d.scratch.place_change) == (4.25 if place <= 3 else 0.5)


def test_round_off_of_clearances_is_that_of_coordinates_or_angles():
    d = stopped_chain(3, "pinned")[1]
    y, position, size = np.zeros(len(d.step.state)), d.scratch.position, d.chain.longest_link
    position.x[:], position.y[:] = np.linspace(-3.0, 3.0, len(position.x)), 2.5
    y[2:5] = 0.5, -1.5, 4.0
    joints = {1: 0.5, 2: 2.0, 3: 5.5}
    for c in range(d.candidate_count):
        point = d.candidate.point[c]
        expected = size * joints[int(point)] if d.candidate.stop[c] else abs(position.x[point]) + 2.5
        assert coordinate_sum(d, c, y) == pytest.approx(expected, rel=1e-13)
    position.y[:] = -2.5
    c = next(c for c in range(d.candidate_count) if not d.candidate.stop[c])
    assert coordinate_sum(d, c, y) == pytest.approx(abs(position.x[d.candidate.point[c]]) + 2.5, rel=1e-13)


@pytest.fixture(params=["free", "pinned"])
def rubbing(request):
    """Return a chain of four links with dry joints between walls at any angle, located in some state."""
    pinned = {("contact", "points"): [1, 2, 3, 4]} if request.param == "pinned" else {}
    joints = {("chain", "links", i, "joint_friction"): 0.1 for i in range(1, 4)}
    changes = {("chain", "base"): request.param, ("initial", "velocity"): [0, 0]} | joints | pinned
    scene, d = prepared(True, changes | {("contact", "friction"): 0.3})
    assert initialize(d, 0.0) == OK
    y = random_state(np.random.default_rng(3), d)
    kinematics.locate_points(d, y)
    return scene, d, y


def test_the_tangent_of_a_wall_is_its_normal_turned_backward(rubbing):
    """t = (n_y, −n_x): to the right along a floor."""
    scene, d, _ = rubbing
    planes = scene.half_planes
    for c in range(d.candidate_count):
        place, *t = tangent_row(d, c)
        assert place == d.candidate.point[c]
        nx, ny = list(planes.values())[c % len(planes)].normal
        assert t == pytest.approx([ny, -nx], abs=3e-16)
        if d.candidate.wall[c] == WALLS.index("y_min"):
            assert t == [1.0, 0.0]


def test_the_tangent_of_a_joint_is_its_angle_at_the_arm(rubbing):
    """J v by the angle's rate, ψ̇ = θ̇_i − θ̇_{i−1}; motions and loads along tangents are adjoint."""
    _, d, y = rubbing
    n = d.link_count
    rates = np.diff(y[n + 4 : 2 * n + 4], prepend=0.0)
    for i in range(n):
        e = d.candidate_count + i
        assert tangent_row(d, e) == (n + 1 + i, 1.0, 0.0)
        speed = tangential_rate(d, e)
        assert speed == pytest.approx(d.chain.longest_link * rates[i], rel=1e-12, abs=1e-14)
    change = any_change(d)
    assert_adjoint(d, [tangent_row(d, e) for e in range(d.friction_element_count)], change)

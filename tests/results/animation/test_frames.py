"""The motion that an animation shows, of a real scene: against the recording, and where walls are seen."""

from dataclasses import replace

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.results.animation.frames import MARGIN, motion_of
from chain_impact.scene.half_planes import HalfPlane
from chain_impact.studies.slow_motion import record_slowly


@pytest.fixture(scope="module")
def recording():
    return record_slowly(load_scene("four_link_box"))


def test_frames_are_on_the_recorded_path(recording):
    motion = motion_of(recording)
    for point in (0, 4):
        path = np.interp(motion.time, recording.time, recording.columns[f"point[{point}].y"])
        np.testing.assert_allclose(motion.points[:, point, 1], path, atol=1e-12)
    assert set(motion.energies) == {"kinetic", "potential", "elastic", "dissipated", "total"}


def test_every_impact_is_seen_with_its_force(recording):
    motion = motion_of(recording)
    impacts = [contact for contact in motion.contacts if contact.speed is not None]
    assert [contact.onset for contact in impacts] == [impact.time for impact in recording.impacts]
    for contact in impacts:
        within = (motion.time >= contact.onset) & (motion.time <= contact.end)
        peak = motion.forces[contact.point, contact.wall][within].max()
        assert contact.resolved
        if contact.speed > 0.1:
            assert peak == pytest.approx(contact.peak_force, rel=0.02)
            assert within.sum() > 10


def test_the_view_holds_the_motion_and_the_walls_near_it(recording):
    motion = motion_of(recording)
    low, high = motion.view
    assert (motion.points.min(axis=(0, 1)) > low).all()
    assert (motion.points.max(axis=(0, 1)) < high).all()
    assert low[1] < 0.0 < low[1] + 2 * MARGIN * (high - low).max()
    assert high[0] > 3.0


def test_a_closed_room_is_seen_whole_unless_it_is_far_larger_than_the_motion(recording):
    motion = motion_of(recording)
    assert (motion.view[0] < 0.0).all()
    assert (motion.view[1] > [3.0, 2.5]).all()
    assert motion.anchor == (0.5, 0.5)
    walls = recording.walls | {"y_max": HalfPlane((0.0, -1.0), -5.0)}
    low, high = motion_of(replace(recording, walls=walls)).view
    assert low[0] > 0.0
    assert high[1] < 2.5


def test_what_room_is_left_is_on_the_side_without_a_wall(recording):
    walls = {"y_min": recording.walls["y_min"]}
    assert motion_of(replace(recording, walls=walls)).anchor[1] == 0.0  # all above, none below the floor


def test_points_with_a_radius_have_it():
    scene = load_scene("ramp")
    assert motion_of(record_slowly(scene)).radius == pytest.approx(scene.contact.radius, rel=1e-6)


def test_a_long_chain_has_fewer_frames(recording, monkeypatch):
    monkeypatch.setattr("chain_impact.results.animation.frames.NUMBERS", 5000)
    assert len(motion_of(recording).time) == 500

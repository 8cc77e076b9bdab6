"""A caller that stops at every onset: the times, the outputs, and an unchanged motion."""

# Tests: kernel/entry.py

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.kernel.status import OK, ONSET_DUE
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.kernel_calls import advance_to_onset, event_update

RIGID = {("contact", "model"): "newton_impact"}


class Stopping:
    """An instance that can stop at onsets."""

    def __init__(self, scene):
        self.instance = Instance(scene)
        self.record = self.instance.record

    def to_onset(self, time):
        return advance_to_onset(self.instance, time)

    def event_update(self):
        return event_update(self.instance)

    def outputs(self):
        self.instance.observe()
        return self.record["output"].tobytes(), self.record["latest"].tobytes()

    @property
    def count(self):
        return int(self.record["impact"]["count"])

    def run(self, stop, step):
        """Run with steps of one size that end at each onset; return their final rows and the onset times."""
        rows, onsets = [], []
        for time in np.arange(1, round(stop / step) + 1) * step:
            while (status := self.to_onset(time)) == ONSET_DUE:
                onsets.append(self.instance.time)
                count, before = self.count, self.outputs()
                assert self.event_update() == OK
                assert self.instance.time == onsets[-1]
                assert self.count > count
                assert self.record["impact"]["last_time"] == onsets[-1]
                assert self.outputs() != before
            assert status == OK
            assert self.instance.time == time
            rows.append(self.outputs())
        return rows, onsets


@pytest.mark.parametrize("step", [1e-3, 0.1, 2.0])
@pytest.mark.parametrize("model", ["four_link_box", "rod_drop", "pinned_arm", "ramp", "rigid"])
def test_a_run_that_stops_at_each_onset_is_otherwise_unchanged(model, step):
    scene = with_values(load_scene("four_link_box"), RIGID) if model == "rigid" else load_scene(model)
    stop = 1.0 if step < 1.0 else 2.0
    stopping, plain = Stopping(scene), Instance(scene)
    rows, onsets = stopping.run(stop, step)
    expected = simulate(scene, stop, output_step=stop).impacts
    assert onsets == sorted(set(expected["onset"]))
    for time, row in zip(np.arange(1, round(stop / step) + 1) * step, rows, strict=True):
        assert plain.advance(time) == OK
        plain.observe()
        assert (plain.record["output"].tobytes(), plain.record["latest"].tobytes()) == row
    assert stopping.instance.statistics == plain.statistics


def dropped(height=0.0, speed=-1.0, **contact):
    """Return a rod that falls without turning; both its ends arrive at the same time."""
    scene = {"name": "Flat", "chain": {"links": [{"length": 1.0, "mass": 1.0}]}, "box": {"y_min": 0.0}}
    scene["initial"] = {"position": [0.0, height], "angles": [0.0], "velocity": [0.0, speed]}
    return scene_from_dict(scene | {"contact": contact}, "flat")


@pytest.mark.parametrize("contact", [{}, {"model": "newton_impact"}], ids=["force law", "rigid"])
def test_an_onset_at_the_very_start_is_one(contact):
    stopping = Stopping(dropped(**contact))
    assert stopping.to_onset(0.5) == ONSET_DUE
    assert (stopping.instance.time, stopping.count) == (0.0, 0)
    assert stopping.event_update() == OK
    assert (stopping.instance.time, stopping.count) == (0.0, 2)


def test_a_caller_that_ignores_an_onset_can_go_on():
    stopping, plain = Stopping(dropped(0.1)), Instance(dropped(0.1))
    counts = []
    while stopping.to_onset(0.5) == ONSET_DUE:
        counts.append(stopping.count)
    assert counts == [0, 2, 4]
    assert plain.advance(0.5) == OK
    assert stopping.record["step"].tobytes() == plain.record["step"].tobytes()


def test_the_restitution_set_at_an_onset_is_that_of_its_impact():
    """A rod falls flat; each bounce has another restitution, set at its onset."""
    stopping = Stopping(dropped(0.1, 0.0, model="newton_impact"))
    ratios = []
    for restitution in (0.9, 0.5, 0.7):
        assert stopping.to_onset(10.0) == ONSET_DUE
        stopping.instance.observe()
        speed = -stopping.record["output"]["point_velocity"][0, 1]
        stopping.record["given"]["restitution"] = restitution
        stopping.record["given"]["pending"] = 1
        stopping.instance.observe()
        # still before the impact
        assert stopping.record["output"]["point_velocity"][0, 1] == pytest.approx(-speed, rel=1e-14)
        assert stopping.event_update() == OK
        stopping.instance.observe()
        ratios.append(stopping.record["output"]["point_velocity"][0, 1] / speed)
    assert ratios == pytest.approx([0.9, 0.5, 0.7], rel=1e-12)
    assert stopping.count == 6


def test_a_law_set_at_an_onset_is_that_of_its_impact():
    """The first impact has a rigid wall, and the second a wall with a force law, under which it lasts."""
    stopping = Stopping(dropped(0.1, 0.0))
    lasting = []
    for law in (CONTACT_LAWS[name].number for name in ("newton_impact", "hunt_crossley")):
        assert stopping.to_onset(10.0) == ONSET_DUE
        stopping.record["given"]["law"] = law
        stopping.record["given"]["pending"] = 1
        assert stopping.event_update() == OK
        lasting.append(int(stopping.record["contacts"]["active_count"]))
    assert lasting == [0, 2]
    assert stopping.count == 4

"""The log of contacts: those that have ended, those that last, and the peaks of all."""

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events.contact_log import (
    clear_log,
    clear_peaks,
    collect,
    end_contact,
    list_latest,
    log_active,
)
from chain_impact.kernel.model.contact import begin_contact, clear_contacts, list_touching
from chain_impact.kernel.model.geometry import clearance
from chain_impact.kernel.record.contacts import LATEST
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.kernel.chains import chain, random_state, stopped_chain, stops_of
from tests.kernel.events.test_contact_log import pressed
from tests.plain import make_rigid


@pytest.mark.parametrize("rate", [0.4, -0.4])
@pytest.mark.parametrize("impulsive", [0, 1])
def test_a_contact_that_ends_is_a_row_of_the_log(impulsive, rate):
    d, _ = pressed([0.0, rate, 0.0])
    make_rigid(d, impulsive)
    size = len(d.finished.point)
    for count in (0, 5, size + 2):  # the oldest are lost
        d.finished.count = count
        values = {"onset": 1.5, "onset_speed": 0.7, "peak_force": 9.0, "max_penetration": 0.3}
        for name, value in (values | {"effective_mass": 2.5}).items():
            d.touch[name][1] = value + count
        d.impulse.total[1], d.impulse.onset[1] = 8.0, 6.5
        d.touch.active[1] = 1
        end_contact(d, 1, impulsive)
        assert not d.touch.active[1]
        log, row = d.finished, count % size
        assert log.number[row] == d.touch.number[1]
        assert log.count == count + 1
        assert (log.point[row], log.wall[row]) == (d.candidate.point[1], d.candidate.wall[1])
        assert log.onset[row] == 1.5 + count
        assert log.end[row] == d.step.end
        assert log.impact_speed[row] == 0.7 + count
        leaves = max(0.0, rate) if impulsive else rate
        assert log.separation_speed[row] == pytest.approx(leaves, rel=1e-12)
        assert log.peak_force[row] == 9.0 + count
        assert log.max_penetration[row] == 0.3 + count
        assert log.effective_mass[row] == 2.5 + count
        assert log.impulse[row] == 1.5


def test_a_contact_of_a_stop_is_logged_as_an_angle_and_a_moment():
    """At the lever arm s: φ = δ/s, M = F s, and the inertia m s²."""
    _, d = stopped_chain(2)
    c, arm = stops_of(d)[0], 1.4
    d.model.size = arm
    for name, value in {
        "onset_speed": 0.7,
        "peak_force": 9.0,
        "max_penetration": 0.3,
        "effective_mass": 2.5,
    }.items():
        d.touch[name][c] = value
    d.impulse.total[c], d.impulse.onset[c] = 8.0, 6.5
    rate = clearance(d, c)[1]
    end_contact(d, c, 0)
    log = d.finished
    assert log.impact_speed[0] == pytest.approx(0.7 / arm)
    assert log.separation_speed[0] == pytest.approx(rate / arm)
    assert log.peak_force[0] == pytest.approx(9.0 * arm)
    assert log.max_penetration[0] == pytest.approx(0.3 / arm)
    assert log.effective_mass[0] == pytest.approx(2.5 * arm**2)
    assert log.impulse[0] == pytest.approx(1.5 * arm)
    assert (d.peaks.moment, d.peaks.rotation) == (log.peak_force[0], log.max_penetration[0])
    assert (d.peaks.force, d.peaks.penetration) == (0.0, 0.0)


@pytest.mark.parametrize("count", [0, 5, -1])
def test_contacts_that_last_are_logged_behind_those_that_have_ended(count):
    """In the order of the candidates; at the end of the log they go on at its beginning."""
    _, d = stopped_chain(2)
    log, size, stop, arm = d.finished, len(d.finished.point), stops_of(d)[0], 1.4
    d.model.size, log.count = arm, count % size
    active = [0, stop]
    for c in range(d.candidates):
        d.touch.active[c] = c in active
        d.touch.onset[c], d.touch.peak_force[c], d.touch.max_penetration[c] = 0.1 * c, 3.0 + c, 0.2 + c
    log_active(d)
    assert log.count == count % size
    for k, c in enumerate(active):
        row, lever = (count + k) % size, arm if c == stop else 1.0
        assert (log.point[row], log.wall[row]) == (d.candidate.point[c], d.candidate.wall[c])
        assert log.onset[row] == d.touch.onset[c]
        assert log.peak_force[row] == d.touch.peak_force[c] * lever
        assert log.max_penetration[row] == d.touch.max_penetration[c] / lever
        assert np.isnan([log.end[row], log.separation_speed[row]]).all()
    assert (d.peaks.force, d.peaks.moment) == (3.0, (3.0 + stop) * arm)


def test_peaks_are_the_largest_of_all_contacts():
    d, _ = pressed([0.0, 0.0, 0.0])
    clear_peaks(d)
    for c, (force, penetration) in enumerate([(2.0, 1e-3), (1.0, 5e-3), (3.0, 2e-3)]):
        d.touch.peak_force[c], d.touch.max_penetration[c] = force, penetration
        end_contact(d, c, 0)
    assert (d.peaks.force, d.peaks.penetration) == (3.0, 5e-3)
    assert (d.peaks.moment, d.peaks.rotation) == (0.0, 0.0)
    clear_peaks(d)
    assert (d.peaks.force, d.peaks.penetration) == (0.0, 0.0)


# --- the list of the latest impacts ------------------------------------------------------------------------

FIELDS = {
    "time": "onset",
    "point": "point",
    "speed": "impact_speed",
    "end": "end",
    "separation_speed": "separation_speed",
    "peak_force": "peak_force",
    "max_penetration": "max_penetration",
    "impulse": "impulse",
}


@pytest.mark.parametrize("kept", [0, 1, 3, LATEST])
def test_each_row_of_the_list_is_an_impact_and_keeps_what_it_has_come_to(kept):
    """Against a list in Python: contacts begin and end at random candidates, and are collected at times."""
    rng = np.random.default_rng(kept)
    _, d = chain(rng, 2)
    y = random_state(rng, d)
    locate_points(d, y)
    make_rigid(d, 1)
    clear_contacts(d, 0.0)
    clear_log(d)
    d.latest.kept, d.step.size, d.step.regularized = kept, 1.0, -1
    rows, lasting = [], {}
    for moment in range(1, 6 * LATEST):
        d.step.start, d.step.end = moment - 1.0, float(moment)
        d.step.time = d.step.end
        c = int(rng.integers(d.candidates))
        rate = float(clearance(d, c)[1])
        if d.touch.active[c]:
            ended = lasting.pop(c)
            ended.update(end=moment, separation_speed=rate, impulse=d.impulse.total[c] - ended.pop("before"))
            end_contact(d, c, False)
        else:
            begin_contact(d, c)
            own = {"point": d.candidate.point[c], "wall": d.candidate.wall[c] + 1, "time": moment}
            own |= {"speed": max(0.0, -rate), "before": float(d.impulse.total[c]), "max_penetration": 0.0}
            lasting[c] = own
            rows.insert(0, own)
        list_touching(d)
        for other, row in lasting.items():
            d.touch.peak_force[other] = d.output.impulse[other] = rng.uniform()
            d.impulse.total[other] = d.output.impulse[other]
            row |= {"end": moment, "separation_speed": clearance(d, other)[1]}
            row |= {
                "peak_force": d.touch.peak_force[other],
                "impulse": d.output.impulse[other] - row["before"],
            }
        list_latest(d)
        for place, expected in enumerate(rows[:kept]):
            for name in (*FIELDS, "wall"):
                assert d.latest[name][place] == expected[name]
        if rng.uniform() < 0.05:
            collect(d)
    assert len(rows) > 2 * LATEST
    assert (d.latest.point[kept:] == -1).all()
    clear_log(d)
    assert (d.latest.point == -1).all()
    assert (d.finished.count, d.finished.collected) == (0, 0)
    for name in (*FIELDS, "wall"):
        assert name == "point" or not d.latest[name].any()


def look(scene, time):
    """The list after an advance to a time."""
    instance = Instance(scene)
    assert instance.advance(time) == 0
    instance.observe()
    return {name: instance.record["latest"][name].copy() for name in (*FIELDS, "wall")}


@pytest.mark.parametrize("law", ["zhang_sharf", "hertz", "newton_impact"])
@pytest.mark.parametrize("kept", [1, 8, LATEST])
def test_it_is_that_of_the_log(law, kept):
    scene = with_values(load_scene("four_link_box"), {"contact.model": law, "outputs.impacts": kept})
    impacts = simulate(scene, 1.9).impacts[::-1][:kept]
    listed = look(scene, 1.9)
    assert np.isfinite(impacts["end"]).all()
    for name, column in FIELDS.items():
        np.testing.assert_array_equal(listed[name][: len(impacts)], impacts[column])
    np.testing.assert_array_equal(listed["wall"][: len(impacts)], impacts["wall"] + 1)
    assert (listed["wall"][len(impacts) :] == 0).all()
    assert (listed["point"][len(impacts) :] == -1).all()


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("method", ["auto", "implicit"])
@pytest.mark.parametrize("part", [0.1, 0.4, 0.6, 0.9])
def test_an_impact_that_lasts_has_its_values_so_far(method, part):
    """Against the largest values of many looks on the way, and the impulse of the output."""
    scene = with_values(load_scene("four_link_box"), {"solver.method": method, "solver.tolerance": 1e-8})
    first = simulate(scene).impacts[0]
    now = first["onset"] + part * (first["end"] - first["onset"])
    listed = look(scene, now)
    fine = simulate(scene, now, (now - first["onset"]) / 200, tolerance=1e-8)
    forces, depths = fine.outputs["force"], fine.outputs["penetration"]
    assert listed["end"][0] == now
    assert listed["peak_force"][0] == pytest.approx(forces.max(), rel=1e-4)
    assert listed["max_penetration"][0] == pytest.approx(depths.max(), rel=1e-4)
    assert listed["impulse"][0] == pytest.approx(fine.outputs["impulse"][-1].max(), rel=1e-6)
    assert (listed["separation_speed"][0] < 0) == (part < 0.5)


def test_a_look_changes_nothing():
    scene = load_scene("four_link_box")
    looked, blind = Instance(scene), Instance(scene)
    for time in np.linspace(0.01, 2.0, 2000):
        looked.advance(time)
        looked.observe()
    blind.advance(2.0)
    blind.observe()
    assert looked.statistics == blind.statistics
    for name in ("latest", "output", "impulse"):
        assert looked.record[name].tobytes() == blind.record[name].tobytes()


@pytest.mark.parametrize("method", ["auto", "implicit"])
@pytest.mark.parametrize("parts", [(0.46,), (0.54,), (0.3, 0.5, 0.7), (0.48, 0.49, 0.5, 0.51, 0.52)])
def test_a_restart_inside_of_an_impact_loses_no_peak(method, parts):
    """Not even where an input or the stiffness is set: to what it was."""
    scene = with_values(load_scene("four_link_box"), {"solver.method": method, "solver.tolerance": 1e-8})
    first = simulate(scene).impacts[0]
    instance = Instance(scene)
    for part in parts:
        instance.advance(first["onset"] + part * (first["end"] - first["onset"]))
        instance.record["given"]["changed"] = 1
    instance.advance(first["end"] + 1e-3)
    found = instance.collect()[0]
    assert found["peak_force"] == pytest.approx(first["peak_force"], rel=1e-6)
    assert found["max_penetration"] == pytest.approx(first["max_penetration"], rel=1e-6)
    assert found["impulse"] == pytest.approx(first["impulse"], rel=1e-7)


def test_a_peak_before_the_wall_got_softer_is_kept():
    scene = load_scene("four_link_box")
    first = simulate(scene).impacts[0]
    instance = Instance(scene)
    instance.advance(first["onset"] + 0.6 * (first["end"] - first["onset"]))
    instance.record["given"]["stiffness"] *= 0.1
    instance.record["given"]["changed"] = 1
    instance.advance(first["onset"] + 0.1)
    assert instance.collect()[0]["peak_force"] == pytest.approx(first["peak_force"], rel=1e-6)

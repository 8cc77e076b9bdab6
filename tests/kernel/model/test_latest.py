"""The list of the latest impacts is that of the log, and an impact that lasts has its values so far."""

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.kernel.model.latest import LATEST, forget_impacts, list_impact, note_impact
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.kernel.chains import chain

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


NOTED = ("end", "separation_speed", "peak_force", "max_penetration", "impulse")


@pytest.mark.parametrize("kept", [0, 1, 3, LATEST])
def test_each_row_is_an_impact_and_keeps_what_it_has_come_to(kept):
    """Against a list in Python: impacts begin at random candidates, and lasting ones are noted later."""
    rng = np.random.default_rng(kept)
    _, d = chain(rng, 2)
    d.latest.kept = kept
    forget_impacts(d)
    rows, lasting = [], {}
    for number in range(1, 2 * LATEST):
        c, time, speed = int(rng.integers(d.candidates)), float(number), rng.uniform()
        impact = d.impact
        impact.count, impact.last_time, impact.last_speed = number, time, speed
        d.touch.onset_speed[c] = speed
        impact.last_point, impact.last_wall = number % 3, number % 4 + 1
        list_impact(d, c)
        assert d.touch.number[c] == number
        own = {"time": time, "point": number % 3, "wall": number % 4 + 1, "speed": speed}
        rows.insert(0, own | dict(zip(NOTED, (time, -speed, 0.0, 0.0, 0.0), strict=True)))
        lasting[c] = rows[0]
        other = list(lasting)[int(rng.integers(len(lasting)))]
        values = rng.uniform(size=5)
        note_impact(d, other, *values)
        lasting[other].update(zip(NOTED, values, strict=True))
        for row, expected in enumerate(rows[:kept]):
            for name, value in expected.items():
                assert d.latest[name][row] == value
    # no row is written that is not wanted, but for the newest
    assert (d.latest.point[max(1, kept) :] == -1).all()
    assert not d.latest.end[kept:].any()
    forget_impacts(d)
    assert (d.latest.point == -1).all()
    for name in ("time", "wall", "speed", *NOTED):
        assert not d.latest[name].any()

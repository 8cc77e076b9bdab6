"""Results, recordings and comparisons are equal if their numbers are equal."""

import math
from dataclasses import replace

import numpy as np
import pytest

from chain_impact import DifferentiatedRun, Recording, compare, load_scene, simulate
from chain_impact.recording.equality import are_equal

SCENE = load_scene("rod_drop").with_values({"simulation.stop_time": 0.5})


def differentiated(scene):
    return DifferentiatedRun(scene, ["contact.stiffness"], ["point[1].y"]).run([1e8], np.array([0.1, 0.4]))


KINDS = {
    "result": simulate,
    "sensitivities": lambda scene: simulate(scene, sensitivities=["gravity.y"]).sensitivities,
    "derivatives": differentiated,
    "comparison": lambda scene: compare(scene, laws=["zhang_sharf", "newton_impact"]),
    "law": lambda scene: compare(scene, laws=["zhang_sharf"])["zhang_sharf"],
}


@pytest.mark.parametrize("kind", KINDS)
def test_equal_runs_are_equal_and_others_are_not(kind):
    first_run, same_run, other_run = (
        KINDS[kind](scene) for scene in (SCENE, SCENE, SCENE.with_values({"link[1].mass": 1.1}))
    )
    assert first_run == same_run
    assert first_run != other_run
    assert first_run not in (other_run, None, "text")
    assert first_run in [other_run, same_run]


def test_a_number_makes_the_difference():
    result = simulate(SCENE)
    recording = Recording("Rod", result.time, result.columns, result.impacts)
    assert recording == replace(recording)
    assert recording != result
    for name in ("point[1].y", "energy.total"):
        column = recording.columns[name].copy()
        column[-1] = np.nextafter(column[-1], np.inf)
        assert recording != replace(recording, columns={**recording.columns, name: column})
    assert recording != replace(recording, time=recording.time[:-1])


def test_unknown_numbers_are_equal():
    table = np.zeros(2, [("time", float), ("point", int)])
    table["time"] = math.nan
    assert are_equal({"a": [math.nan, table]}, {"a": [math.nan, table.copy()]})
    assert not are_equal({"a": [math.nan, table]}, {"a": [0.0, table]})
    assert not are_equal(table, None)
    assert not are_equal(None, table)
    assert not are_equal(table, table.tolist())

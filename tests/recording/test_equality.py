"""Results, recordings and comparisons are equal if their numbers are equal.

The comparison raises no error.
"""

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
    one, same, other = (
        KINDS[kind](scene) for scene in (SCENE, SCENE, SCENE.with_values({"link[1].mass": 1.1}))
    )
    assert one == same
    assert one != other
    assert one not in (other, None, "text")
    assert one in [other, same]


def test_a_number_makes_the_difference():
    result = simulate(SCENE)
    one = Recording("Rod", result.time, result.columns, result.impacts)
    assert one == replace(one)
    assert one != result
    for name in ("point[1].y", "energy.total"):
        column = one.columns[name].copy()
        column[-1] = np.nextafter(column[-1], np.inf)
        assert one != replace(one, columns={**one.columns, name: column})
    assert one != replace(one, time=one.time[:-1])


def test_unknown_numbers_are_equal():
    table = np.zeros(2, [("time", float), ("point", int)])
    table["time"] = math.nan
    assert are_equal({"a": [math.nan, table]}, {"a": [math.nan, table.copy()]})
    assert not are_equal({"a": [math.nan, table]}, {"a": [0.0, table]})
    assert not are_equal(table, None)
    assert not are_equal(None, table)
    assert not are_equal(table, table.tolist())

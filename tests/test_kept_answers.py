"""The kept answers of independent models are their answers."""

import numpy as np
import pytest

from chain_impact import load_scene
from chain_impact.scene.models import models_folder
from tests import kept_answers
from tests.derivative_scenes import AT_STOPS, DICTIONARIES, exact, pinned_chain, struck_twice
from tests.derivatives import differentiate
from tests.friction_derivative_scenes import dry_joints
from tests.independent import moved
from tests.kernel.integration import stiff_problems

pytestmark = pytest.mark.full("takes long")

# Columns are compared to 1e-10 of their largest number, or of this where that is smaller: what is zero but
# for rounding depends on the processor.
LEAST_SCALE = 1e-6
# of each kind of scene the one that takes least
CASES = {
    "rigid walls": struck_twice("newton_impact"),
    "a law of force": struck_twice("kelvin_voigt"),
    "pinned": pinned_chain("newton_impact"),
    "stops": AT_STOPS["rigid stop and wall"],
    "dry friction": dry_joints(2),
}


def live(case):
    return differentiate(case.scene, case.parameters, case.times, case.inputs, 1e-12)


def assert_same(found, right):
    for name in DICTIONARIES:
        assert getattr(found, name).keys() == getattr(right, name).keys()
        for key, value in getattr(right, name).items():
            scale = np.max(np.abs(value), initial=LEAST_SCALE, where=np.isfinite(value))
            np.testing.assert_allclose(getattr(found, name)[key], value, rtol=1e-9, atol=1e-10 * scale)
    assert found.points.tolist() == right.points.tolist()
    assert found.walls.tolist() == right.walls.tolist()
    assert found.steps == right.steps
    np.testing.assert_allclose(np.reshape(found.modes, (-1, 3)), np.reshape(right.modes, (-1, 3)), rtol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_a_kept_answer_is_that_of_the_oracle(name):
    assert_same(exact(CASES[name]), live(CASES[name]))


def test_a_kept_motion_is_that_of_the_integration(tmp_path, monkeypatch):
    """The motion that tests/test_models.py takes."""
    model = "pinned_arm"
    times = np.loadtxt(models_folder() / model / "reference.csv", delimiter=",", skiprows=1, usecols=0)
    known = moved(load_scene(model), times)[1]
    monkeypatch.setattr(kept_answers, "FOLDER", tmp_path / "answers")
    live = moved(load_scene(model), times)[1]
    assert len(live["onsets"]) == 1
    for name, value in live.items():
        np.testing.assert_allclose(known[name], value, rtol=1e-9, atol=1e-10)


def test_a_kept_end_of_a_stiff_problem_is_that_of_the_integration():
    scene = stiff_problems.swinging()
    live = stiff_problems.integrated(scene, scene.simulation.stop_time)
    np.testing.assert_allclose(stiff_problems.exact("swinging"), live, rtol=1e-9, atol=1e-10)


def test_an_answer_is_worked_out_once_for_what_is_given_and_the_sources(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_answers, "FOLDER", tmp_path / "answers")
    scene, asked = load_scene("rod_drop"), []

    def work_out():
        asked.append(1)
        return {"number": np.array([0.25, np.nan]), "names": np.array(["a", "ä"])}

    def answer(tolerance=1e-9, scene=scene):
        return kept_answers.kept(work_out, "tests.textbook", scene, {"of": (1, tolerance)}, np.arange(3.0))

    for found in (answer(), answer()):
        np.testing.assert_array_equal(found["number"], [0.25, np.nan])
        assert found["names"].tolist() == ["a", "ä"]
    assert len(asked) == 1
    answer(1e-8)
    answer(scene=scene.with_values({"gravity": (0.0, -1.0)}))
    assert len(asked) == 3
    answer(scene=scene.with_values({"solver.method": "explicit"}))
    assert len(asked) == 3
    monkeypatch.setattr(kept_answers, "sources", lambda _: "others")
    answer()
    assert len(asked) == 4
    assert len(list((tmp_path / "answers").iterdir())) == 4


def test_the_sources_of_a_model_are_all_that_it_imports_from_the_tests():
    source = "from tests import a, b\nimport numpy\nfrom tests.c.d import e\nfrom chain_impact import f\n"
    assert sorted(kept_answers.imported(source)) == ["tests.a", "tests.b", "tests.c.d"]
    assert kept_answers.sources("tests.coulomb") != kept_answers.sources("tests.assembled")

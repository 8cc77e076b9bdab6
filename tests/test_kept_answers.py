"""The kept answers of the oracle of derivatives are its answers."""

import numpy as np
import pytest

from tests import kept_answers
from tests.derivative_scenes import AT_STOPS, exact, pinned_chain, struck_twice
from tests.derivatives import differentiate
from tests.friction_derivative_scenes import dry_joints
from tests.kept_answers import DICTIONARIES

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
            scale = np.max(np.abs(value), initial=0.0, where=np.isfinite(value))
            np.testing.assert_allclose(getattr(found, name)[key], value, rtol=1e-9, atol=1e-10 * scale)
    assert found.points.tolist() == right.points.tolist()
    assert found.walls.tolist() == right.walls.tolist()
    assert found.steps == right.steps
    np.testing.assert_allclose(np.reshape(found.modes, (-1, 3)), np.reshape(right.modes, (-1, 3)), rtol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_a_kept_answer_is_that_of_the_oracle(name):
    assert_same(exact(CASES[name]), live(CASES[name]))


def test_an_answer_is_worked_out_once(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_answers, "FOLDER", tmp_path / "answers")
    case, asked = CASES["rigid walls"], []

    def work_out(*arguments, **given):
        asked.append(given)
        return differentiate(*arguments, **given)

    def answer(tolerance=1e-9):
        given = {"inputs": case.inputs, "tolerance": tolerance}
        return kept_answers.kept(work_out, case.scene, case.parameters, case.times, **given)

    first, again = answer(), answer()
    assert len(asked) == 1
    assert_same(first, again)
    answer(1e-8)
    assert len(asked) == 2
    monkeypatch.setattr(kept_answers, "sources", lambda: "others")
    answer()
    assert len(asked) == 3
    assert len(list((tmp_path / "answers").iterdir())) == 3

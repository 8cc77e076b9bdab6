"""Older names of attributes have the values of the present names, and warn."""

# Tests: recording/older_names.py

import pytest

from chain_impact import SceneError, SimulationError, load_scene, simulate


@pytest.mark.parametrize(
    ("make", "older", "name"),
    [
        (lambda: SceneError("is wrong", ("chain", "base")), "place", "path"),
        (lambda: SimulationError(1, 0.5, None, "point 1"), "place", "part"),
        (lambda: simulate(load_scene("rod_drop"), 0.01), "model", "prepared_scene"),
        (lambda: simulate(load_scene("rod_drop"), 0.01), "end_speeds", "linear_impact_speeds"),
        (lambda: simulate(load_scene("rod_drop"), 0.01), "touches", "interactions"),
        (
            lambda: simulate(load_scene("rod_drop"), 0.01, sensitivities="gravity.y").sensitivities,
            "parts",
            "step_factors",
        ),
    ],
    ids=[
        "SceneError.place",
        "SimulationError.place",
        "Result.model",
        "Result.end_speeds",
        "Result.touches",
        "Sensitivities.parts",
    ],
)
def test_an_older_name_works_and_warns(make, older, name):
    owner = make()
    what = rf"^{type(owner).__name__}\.{older} is deprecated, use {name}: version 1\.0 removes {older}\.$"
    with pytest.warns(DeprecationWarning, match=what) as warned:
        assert getattr(owner, older) is getattr(owner, name)
    assert warned[0].filename == __file__

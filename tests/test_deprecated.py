"""Older names of attributes have the values of the present names, and warn."""

# Tests: recording/older_names.py

import inspect

import pytest

import chain_impact
from chain_impact import SceneError, SimulationError, load_scene, simulate
from chain_impact.deprecated import OlderName
from chain_impact.simulation.run import RepeatableSceneRun

EXPORTS = [getattr(chain_impact, name) for name in chain_impact.__all__]
CLASSES = {RepeatableSceneRun, *filter(inspect.isclass, EXPORTS)}
OLDER_NAMES = [
    (kind, older, attribute.name)
    for kind in sorted(CLASSES, key=lambda kind: kind.__name__)
    for older in dir(kind)
    if isinstance(attribute := inspect.getattr_static(kind, older), OlderName)
]
"""Each class with older names of its own or of its bases, the older name and the present one."""


@pytest.mark.parametrize(
    ("make", "older", "name"),
    [
        (lambda: SceneError("is wrong", ("chain", "base")), "place", "path"),
        (lambda: SimulationError(1, 0.5, None, "point 1"), "place", "part"),
        (lambda: simulate(load_scene("rod_drop"), 0.01), "model", "prepared_scene"),
        (lambda: simulate(load_scene("rod_drop"), 0.01), "end_speeds", "linear_impact_speeds"),
        (lambda: simulate(load_scene("rod_drop"), 0.01), "touches", "interactions"),
        (lambda: simulate(load_scene("rod_drop"), 0.01).rerun, "prepared", "prepared_scene"),
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
        "Result.rerun.prepared",
        "Sensitivities.parts",
    ],
)
def test_an_older_name_works_and_warns(make, older, name):
    owner = make()
    message = rf"^{type(owner).__name__}\.{older} is deprecated, use {name}: version 1\.0 removes {older}\.$"
    with pytest.warns(DeprecationWarning, match=message) as warned:
        assert getattr(owner, older) is getattr(owner, name)
    assert warned[0].filename == __file__


@pytest.mark.parametrize(
    ("kind", "older", "name"), OLDER_NAMES, ids=[f"{kind.__name__}.{older}" for kind, older, _ in OLDER_NAMES]
)
def test_each_older_name_gives_the_value_of_a_name_that_is_there(kind, older, name):
    arguments_of_bases = [inspect.signature(base.__init__).parameters for base in kind.__mro__]
    assert hasattr(kind, name) or any(name in arguments for arguments in arguments_of_bases)
    value = object()
    owner = (with_value := type(kind.__name__, (kind,), {name: value})).__new__(with_value)
    with pytest.warns(DeprecationWarning, match=rf"^{kind.__name__}\.{older} is deprecated, use {name}: "):
        assert getattr(owner, older) is value

"""Every function that takes a scene also takes a path or a model's name, and refuses all else alike."""

# Tests: scene/files/models.py

import inspect
from pathlib import Path

import numpy as np
import pytest

import chain_impact
from chain_impact import load_scene, simulate
from chain_impact.scene.files.models import models_folder
from tests.helpers.scenes.problems import own_law
from tests.helpers.tools.refusal import refusal

MODEL = "bouncing_ball"
STOP = "simulation.stop_time"


def animated(scene, folder):
    chain_impact.animate(scene, folder / "ball.html", impact_time=0.0)
    return (folder / "ball.html").read_bytes()


def explored(scene, folder):
    chain_impact.explore(scene, folder / "ball.html", command=["ball"])
    return (folder / "ball.html").read_bytes()


def fitted(scene, _):
    data = {"time": [0.1, 0.2, 0.3], "point[0].y": [0.95, 0.8, 0.56]}
    return chain_impact.fit(scene, data, ["gravity.y"]).values


def differentiated(scene, _):
    run = chain_impact.DifferentiatedRun(scene, ["initial.y"], ["point[0].y"])
    return run.run(np.array([1.0]), np.array([0.1])).values


def stepped(scene, _):
    chain = chain_impact.Chain(scene)
    chain.step(0.5)
    return chain.save()


TAKERS = {
    "Chain": stepped,
    "DifferentiatedRun": differentiated,
    "animate": animated,
    "build_fmu": lambda scene, folder: chain_impact.build_fmu(scene, folder).read_bytes(),
    "compare": lambda scene, _: [run.peak_force for run in chain_impact.compare(scene).runs],
    "explore": explored,
    "fit": fitted,
    "record_slowly": lambda scene, _: chain_impact.record_slowly(scene, 0.0).columns,
    "simulate": lambda scene, _: simulate(scene, 0.5).columns,
    "sweep": lambda scene, _: chain_impact.sweep(scene, {STOP: [0.1, 0.2]}).rows.tobytes(),
    "with_law": lambda scene, _: chain_impact.with_law(scene, own_law()),
    "with_values": lambda scene, _: chain_impact.with_values(scene, {STOP: 2.0}),
}
"""Public name → a call of it with a scene, in a folder for files."""
SCENES = {"scene", "source", "recording"}
"""The names of parameters for scenes."""


def test_the_tested_functions_are_all_that_take_a_scene():
    public = {name: getattr(chain_impact, name) for name in chain_impact.__all__}
    takers = {
        name
        for name, public_object in public.items()
        if callable(public_object)
        and "Scene" in str(getattr(first_parameter(public_object), "annotation", ""))
        and first_parameter(public_object).name in SCENES
    }
    # the package makes these objects, which contain a scene
    records = {"Result", "Comparison", "Fit", "Sweep"}
    assert takers - records == set(TAKERS)


def first_parameter(public_object):
    try:
        parameters = inspect.signature(public_object).parameters.values()
    except ValueError:  # a class of exceptions may have no signature
        return None
    return next(iter(parameters), None)


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("name", TAKERS)
def test_a_models_name_and_a_path_mean_its_scene(name, tmp_path):
    sources = load_scene(MODEL), MODEL, models_folder() / MODEL
    expected, *results = (TAKERS[name](source, tmp_path) for source in sources)
    for result in results:
        np.testing.assert_equal(result, expected)


@pytest.mark.parametrize("name", TAKERS)
def test_anything_else_is_refused_in_one_sentence(name, tmp_path):
    requirement = "must be a scene file, a folder with scene.toml, or a model; "
    for source in ("no_such_model", Path("nowhere", "scene.toml"), 5, None):
        message = refusal(TAKERS[name], source, tmp_path)
        assert message.startswith(f"{source}: cannot be read (")
        assert requirement in message

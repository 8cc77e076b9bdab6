"""A trial by an importer: it sets something, reads outputs and sets it back; the run goes on as without."""

import pytest

from chain_impact import load_scene
from chain_impact.fmu.build import build_fmu
from tests.fmu.conftest import KINDS
from tests.fmu.importer import Instance

STEP, STEPS = 0.0625, 16  # s
SCENES = {
    "kneed_leg": {"inputs.tip_force": True},
    "falling_arm": {"inputs.tip_force": True, "contact.model": "newton_impact", "contact.restitution": 0.0},
}


@pytest.fixture(scope="module", params=SCENES)
def fmu(request, target, tmp_path_factory):
    scene = load_scene(request.param).with_values(SCENES[request.param])
    return str(build_fmu(scene, tmp_path_factory.mktemp("fmu"), **KINDS[target]))


def tunable(fmu):
    import fmpy

    variables = fmpy.read_model_description(fmu).modelVariables
    return next(one.name for one in variables if one.name.endswith(".restitution"))


# The functions before each test run in the clean process: they hold all that they use.


def tried(fmu, step, steps, held, parameter):
    """The outputs of each step of two instances, of which one has trials, and what each trial moved."""
    one, two = Instance(fmu).start(), Instance(fmu).start()
    rows, moved = [], set()
    for k in range(1, steps + 1):
        for instance in (one, two):
            instance.step(k * step)
        before = one.get(held)
        one.set({"tip.force.x": 3.0, parameter: 0.6})
        one.get(one.outputs)
        one.set({parameter: two[parameter]})
        moved.update(name for name, a, b in zip(held, before, one.get(held), strict=True) if a != b)
        one.set({"tip.force.x": 0.0})
        rows.append((one.get(one.outputs), two.get(two.outputs)))
    return rows, sorted(moved)


def test_a_trial_moves_only_what_is_declared_and_leaves_no_trace(fmu, clean):
    rows, moved = clean(tried, fmu, STEP, STEPS, undeclared(fmu), tunable(fmu))
    assert all(one == two for one, two in rows)
    assert moved == []


def undeclared(fmu):
    """The outputs on which no input acts at once, by the model description."""
    import fmpy

    description = fmpy.read_model_description(fmu)
    return [
        one.variable.name
        for one in description.outputs
        if not one.dependencies and not one.variable.dimensions
    ]

"""Derivatives of runs in which values change at some times, against differences of changed runs."""

# Tests: kernel/tangent/entry.py

import numpy as np
import pytest

from chain_impact import Chain
from chain_impact.scene.texts.names import sensitivity_name
from chain_impact.simulation.derivatives import DifferentiatedInstance
from chain_impact.simulation.instance import Instance
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.selection import differentiable_named
from tests.helpers.kernel.kernel_calls import advance_to_onset, event_update, tangents_of
from tests.helpers.scenes.derivative_scenes import table
from tests.helpers.tools.differences import slope

PARAMETERS = ("link[1].mass", "gravity.y")
OUTPUTS = ("link[2].angle", "link[2].angular_velocity")


def pressed_arm(model):
    """Return an arm whose tip is held at the floor by a force."""
    links = (0.5, 0.8, 0.05), (0.4, 0.5, 0.02)
    return table(
        [dict(zip(("length", "mass", "joint_damping"), link, strict=True)) for link in links],
        base="pinned",
        box={"y_min": -0.5},
        contact={"model": model, "stiffness": 2e4, "restitution": 0.4, "points": [2]},
        inputs={"joint_torques": True, "tip_force": True},
        initial={"position": [0.0, 0.0], "angles": [-0.3, -0.95], "angular_velocities": [0.0, -0.2]},
        solver={"tolerance": 1e-12},
    )


def played(scene, script, stop, names):
    """Return the outputs at the end of a run in which values are set at some times [s]."""
    chain = Chain(scene)
    for time, changes in script:
        chain.step_to(time)
        chain.set(changes)
    chain.step_to(stop)
    return np.array(chain.get(names), float)


def difference(run, scene, name, relative=1e-4):
    """Return the derivative of a run's results, by differences of order 4."""
    value = scene.values[name]
    return slope(lambda other: run(scene.with_values({name: other})), value, relative * abs(value), 4)


@pytest.mark.parametrize(
    ("model", "changes"),
    [
        ("newton_impact", {"contact.model": "hunt_crossley", "tip.force.y": 12.0}),
        ("newton_impact", {"contact.restitution": 0.9, "tip.force.y": 12.0}),
        ("hunt_crossley", {"contact.model": "lankarani_nikravesh"}),
        ("hunt_crossley", {"contact.stiffness": 5e4, "joint[2].torque": 0.5}),
    ],
)
def test_derivatives_by_a_value_set_while_a_point_is_held_are_right(model, changes):
    script = [(0.0, {"tip.force.y": -40.0}), (0.15, changes), (0.2, {"tip.force.y": -20.0})]
    scene = pressed_arm(model)
    asking = scene.with_values({"outputs.sensitivities": PARAMETERS})
    names = [sensitivity_name(output, name) for name in PARAMETERS for output in OUTPUTS]
    derivatives = played(asking, script, 0.26, names).reshape(len(PARAMETERS), -1)
    for slopes, name in zip(derivatives, PARAMETERS, strict=True):
        expected = difference(lambda changed_scene: played(changed_scene, script, 0.26, OUTPUTS), scene, name)
        np.testing.assert_allclose(slopes, expected, rtol=0, atol=1e-5 * np.abs(expected).max())


def falling_link(model):
    return table(
        [{"length": 1.0, "mass": 1.0}],
        box={"y_min": 0.0},
        contact={"model": model, "stiffness": 1e5, "restitution": 0.6, "points": [1]},
        initial={
            "position": [0.0, 0.5],
            "angles": [-0.4],
            "velocity": [0.0, -2.0],
            "angular_velocities": [-1.0],
        },
        solver={"tolerance": 1e-12},
    )


def through_onset(instance, changes, stop):
    """Run to the first onset, as FMI 3.0's event mode does, set values, continue; return the impacts."""
    advance_to_onset(instance, stop)
    given = instance.record["given"]
    for name, value in changes.items():
        given[name], given["pending"] = value, 1
    event_update(instance)
    instance.advance(stop)
    instance.observe()
    return instance.collect()


@pytest.mark.parametrize("model", ["hunt_crossley", "newton_impact"])
@pytest.mark.parametrize("changes", [{}, {"restitution": 0.8}, {"stiffness": 3e5}])
def test_derivatives_by_a_value_set_at_an_onset_that_is_due_are_right(model, changes):
    scene, names, stop = falling_link(model), ("initial.y", "initial.vy", "gravity.y"), 0.15
    compiled = PreparedScene(scene)
    instance = DifferentiatedInstance(compiled, differentiable_named(compiled, names))
    impacts = through_onset(instance, changes, stop)
    onsets = instance.slopes_of_impacts(np.arange(len(impacts)))["onset"]
    looks = [compiled.output_index[name] for name in ("point[1].y", "link[1].angular_velocity")]
    output_slopes = tangents_of(instance)["output"].view(np.float64).reshape(-1, 5)[looks, 1 : 1 + len(names)]

    def plain(scene_of_run):
        run = Instance(scene_of_run)
        rows = through_onset(run, changes, stop)
        outputs = np.frombuffer(run.record["output"].tobytes())
        return np.array([*outputs[looks], rows["onset"][0]])

    for k, name in enumerate(names):
        expected = difference(plain, scene, name)
        np.testing.assert_allclose([*output_slopes[:, k], onsets[0, k]], expected, rtol=1e-6, atol=1e-8)

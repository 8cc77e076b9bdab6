"""The inputs of the FMU: torques at the joints; in a clean process."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact import load_scene, simulate
from chain_impact.variables.model import Model
from tests.fmu.clean import importing
from tests.fmu.importer import Instance

# The functions without an assertion run in the clean process: they hold all that they use.


def driven(fmu, torques, period, steps, values):
    """Torques at joints 1 and 2, constant over each period, in some communication steps per period."""
    instance = Instance(fmu).start(**values)
    names = [*instance.outputs]
    rows = [instance.get(names)]
    for k, (first, second) in enumerate(torques):
        instance.set({"joint[1].torque": first, "joint[2].torque": second})
        for j in range(steps):
            instance.step((k + (j + 1) / steps) * period)
        rows.append(instance.get(names))
    return [names, rows]


TORQUES = [(2.0, 0.5), (-1.0, 0.5), (3.0, -1.0), (0.0, 0.0), (0.0, 0.0), (1.5, 0.25), (-4.0, 1.0), (0.5, 0.0)]
PERIOD = 0.0625  # s


def arm_rate(scene, torques, state):
    """Lagrange's equations of the two-link arm in absolute angles, with the work of the torques [J]."""
    (t1, t2, w1, w2, _work), (a, b) = state, scene.chain.links
    c, s = math.cos(t1 - t2), math.sin(t1 - t2)
    coupling = b.mass * a.length * b.center_of_mass
    first = a.inertia + a.mass * a.center_of_mass**2 + b.mass * a.length**2
    inertia = [[first, coupling * c], [coupling * c, b.inertia + b.mass * b.center_of_mass**2]]
    g = -scene.gravity[1]
    elbow = torques[1] - b.joint_damping * (w2 - w1) - b.joint_stiffness * (t2 - t1 - b.joint_rest_angle)
    shoulder = torques[0] - a.joint_damping * w1 - a.joint_stiffness * (t1 - a.joint_rest_angle)
    weight = (a.mass * a.center_of_mass + b.mass * a.length) * g * math.cos(t1)
    moments = [
        shoulder - elbow - coupling * s * w2**2 - weight,
        elbow + coupling * s * w1**2 - b.mass * b.center_of_mass * g * math.cos(t2),
    ]
    return [w1, w2, *np.linalg.solve(inertia, moments), torques[0] * w1 + torques[1] * (w2 - w1)]


SPRINGS = {"link[1].joint_stiffness": 20.0, "link[1].joint_rest_angle": -1.0}
SPRINGS |= {"link[2].joint_stiffness": 8.0, "link[2].joint_rest_angle": 0.5}


@pytest.mark.parametrize("springs", [{}, SPRINGS], ids=["no springs", "springs"])
def test_torques_do_what_the_equations_of_the_arm_say(springs, fmus, clean):
    values = {"box.x_max": 10.0, "solver.tolerance": 1e-11} | springs
    names, rows = clean(driven, fmus["pinned_arm"], TORQUES, PERIOD, 1, values)
    scene = load_scene("pinned_arm").with_values(springs)
    state = np.array([*scene.initial.angles, *scene.initial.angular_velocities, 0.0])
    chosen = [f"link[{i}].{name}" for name in ("angle", "angular_velocity") for i in (1, 2)]
    columns = [names.index(name) for name in [*chosen, "energy.supplied"]]
    for torques, row in zip(TORQUES, rows[1:], strict=True):
        solution = solve_ivp(
            lambda _t, y, torques=torques: arm_rate(scene, torques, y),
            (0.0, PERIOD),
            state,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
        )
        state = solution.y[:, -1]
        np.testing.assert_allclose([row[column] for column in columns], state, rtol=0, atol=1e-9)


def test_inputs_depend_neither_on_the_communication_step_nor_on_the_kind(fmus, all_fmus, clean):
    torques = list(itertools.islice(itertools.cycle(TORQUES), 24))  # into contact
    names, coarse = clean(driven, fmus["pinned_arm"], torques, PERIOD, 1, {})
    _, fine = clean(driven, fmus["pinned_arm"], torques, PERIOD, 64, {})
    assert coarse[-1][names.index("impact.count")] > 0
    np.testing.assert_array_equal(fine, coarse)
    assert [names, coarse] == clean(driven, all_fmus["native"]["pinned_arm"], torques, PERIOD, 1, {})


@importing("pinned_arm")
def test_setting_what_is_already_set_changes_nothing(fmu):
    """The torque at every step, and once; and a parameter to what it is."""
    often, once = Instance(fmu).start(), Instance(fmu).start()
    for instance in (often, once):
        instance.set({"joint[1].torque": 1.0})
    for i in range(500):
        often.set({"joint[1].torque": 1.0, "contact.stiffness": often["contact.stiffness"]})
        often.step((i + 1) * 2.0**-9)
    once.step(500 * 2.0**-9)
    assert often.get(often.outputs) == once.get(once.outputs)


@importing("pinned_arm")
def test_an_input_acts_at_once_on_accelerations(fmu):
    instance = Instance(fmu).start()
    instance.step(0.25)
    names = ["link[1].angle", "link[1].angular_acceleration"]
    angle, acceleration = instance.get(names)
    instance.set({"joint[1].torque": 5.0})
    assert instance.get(names)[0] == angle
    assert instance.get(names)[1] > acceleration + 1.0


def followed(fmu, columns, stop_time, step, names):
    """What fmpy's own loop gives, with a table of inputs: name → values at communication points."""
    import fmpy
    import numpy as np

    signals = np.array(list(zip(*columns.values(), strict=True)), dtype=[(name, float) for name in columns])
    rows = fmpy.simulate_fmu(fmu, stop_time=stop_time, output_interval=step, input=signals, output=names)
    return [rows[name].tolist() for name in ("time", *names)]


def test_simulate_follows_inputs_as_the_fmu_does(fmus, clean):
    """Through impacts, too: fmpy's loop sets the inputs at each communication point."""
    scene = load_scene("pinned_arm")
    times = np.arange(801) * 1e-3
    signals = {"joint[1].torque": 3.0 * np.sin(9.0 * times), "joint[2].torque": np.cos(7.0 * times)}
    result = simulate(scene, stop_time=0.8, inputs={name: (times, u) for name, u in signals.items()})
    assert len(result.impacts) > 0
    expected = Model(scene).series(result.outputs)
    table = {"time": times.tolist()} | {name: values.tolist() for name, values in signals.items()}
    time, *columns = clean(followed, fmus["pinned_arm"], table, 0.8, 1e-3, list(expected))
    np.testing.assert_allclose(time, result.time, rtol=0, atol=1e-12)
    for name, column in zip(expected, columns, strict=True):
        scale = max(1.0, np.abs(expected[name]).max())
        np.testing.assert_allclose(column, expected[name], rtol=0, atol=1e-9 * scale, err_msg=name)

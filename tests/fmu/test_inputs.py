"""The inputs of the FMU in a clean process: torques and targets of joints, motions of a base and walls."""

import itertools

import numpy as np

from chain_impact import Chain
from tests.fmu.clean import importing
from tests.fmu.importer import Instance
from tests.fmu.scenes import scene_of

# Functions for ``clean``, and the test with importing(), run in the clean process with their own imports.


def driven(fmu, torques, period, steps):
    """Run with torques at joints 1 and 2, constant in each period of ``steps`` communication steps.

    Return the names of the outputs, and a row of values at the start and at the end of each period.
    """
    instance = Instance(fmu).start()
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


def test_inputs_depend_neither_on_the_communication_step_nor_on_the_kind(fmus, all_fmus, clean):
    torques = list(itertools.islice(itertools.cycle(TORQUES), 24))  # into contact
    names, coarse = clean(driven, fmus["pinned_arm"], torques, PERIOD, 1)
    _, fine = clean(driven, fmus["pinned_arm"], torques, PERIOD, 64)
    assert coarse[-1][names.index("impact.count")] > 0
    np.testing.assert_array_equal(fine, coarse)
    assert [names, coarse] == clean(driven, all_fmus["native"]["pinned_arm"], torques, PERIOD, 1)


def followed(fmu, targets, period):
    """Run with target angles and velocities of joint 2, each constant for a period.

    Return the names of the outputs, and a row of values at the end of each period.
    """
    targets_by_name = [
        {"joint[2].target_angle": angle, "joint[2].target_velocity": velocity} for angle, velocity in targets
    ]
    instance, rows = Instance(fmu).start(**targets_by_name[0]), []
    for k, values_of_period in enumerate(targets_by_name):
        instance.set(values_of_period)
        instance.step((k + 1) * period)
        rows.append(instance.get(instance.outputs))
    return [[*instance.outputs], rows]


def test_targets_act_as_they_do_on_a_chain_in_python(fmus, clean):
    targets = [(0.5, 0.0), (3.0, 0.0), (3.0, -2.0), (-3.0, 0.0), (0.0, 0.5)]
    names, rows = clean(followed, fmus["servo"], targets, 0.125)
    chain = Chain(scene_of("servo"))
    motion = [name for name in names if name.startswith(("joint[", "link[", "energy."))]
    for k, (angle, velocity) in enumerate(targets):
        chain.set({"joint[2].target_angle": angle, "joint[2].target_velocity": velocity})
        chain.step_to(0.125 * (k + 1))
        outputs = dict(zip(names, rows[k], strict=True))
        assert [outputs[name] for name in motion] == chain.get(motion).tolist()
    assert abs(chain.get("joint[2].angular_velocity")) > 0.1


MOTIONS = [
    {
        "base.x": 0.02 * np.sin(3.0 * t),
        "base.vx": 0.06 * np.cos(3.0 * t),
        "base.ax": -0.18 * np.sin(3.0 * t),
        "wall.x_max.displacement": 0.01 * t * t,
        "wall.x_max.velocity": 0.02 * t,
        "wall.x_max.belt_speed": 0.3 * t,
    }
    for t in np.arange(48) * 0.03125
]


def moved(fmu, motions, period):
    """Run with a base and a wall whose motions are given at communication points.

    Return the names of the outputs, their rows, and the rows of the second half again, from a saved state.
    """
    instance, rows = Instance(fmu).start(**motions[0]), []
    state, repeated_rows = None, []
    for k, motion in enumerate(motions):
        if k == len(motions) // 2:
            state = instance.fmu.getFMUstate()
        instance.set(motion)
        instance.step((k + 1) * period)
        rows.append(instance.get(instance.outputs))
    instance.fmu.setFMUstate(state)
    instance.time = len(motions) // 2 * period
    for k in range(len(motions) // 2, len(motions)):
        instance.set(motions[k])
        instance.step((k + 1) * period)
        repeated_rows.append(instance.get(instance.outputs))
    return [[*instance.outputs], rows, repeated_rows]


def test_a_base_and_walls_move_as_those_of_a_chain_in_python(fmus, clean):
    motions = [{name: float(value) for name, value in motion.items()} for motion in MOTIONS]
    names, rows, repeated_rows = clean(moved, fmus["moved_arm"], motions, 0.03125)
    chain = Chain(scene_of("moved_arm"))
    chain.set(motions[0])
    compared_names = [
        name for name in names if name.startswith(("point[", "link[", "energy.", "contact[", "wall."))
    ]
    for k, motion in enumerate(motions):
        chain.set(motion)
        chain.step_to(0.03125 * (k + 1))
        outputs = dict(zip(names, rows[k], strict=True))
        assert [outputs[name] for name in compared_names] == chain.get(compared_names).tolist()
    assert abs(chain.get("point[0].x") - motions[-1]["base.x"]) < 0.01
    assert chain.get("impact.count") > 0
    assert repeated_rows == rows[len(rows) - len(repeated_rows) :]


@importing("pinned_arm")
def test_setting_what_is_already_set_changes_nothing(fmu):
    """Set the same torque at every step or once, and a parameter to its present value."""
    set_often, set_once = Instance(fmu).start(), Instance(fmu).start()
    for instance in (set_often, set_once):
        instance.set({"joint[1].torque": 1.0})
    for i in range(500):
        set_often.set({"joint[1].torque": 1.0, "contact.stiffness": set_often["contact.stiffness"]})
        set_often.step((i + 1) * 2.0**-9)
    set_once.step(500 * 2.0**-9)
    assert set_often.get(set_often.outputs) == set_once.get(set_once.outputs)

"""The inputs of the FMU: torques at the joints; in a clean process."""

import itertools

import numpy as np

from chain_impact import Chain
from tests.fmu.clean import importing
from tests.fmu.conftest import scene_of
from tests.fmu.importer import Instance

# The functions without an assertion run in the clean process: they hold all that they use.


def driven(fmu, torques, period, steps):
    """Torques at joints 1 and 2, constant over each period, in some communication steps per period."""
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
    """Targets of joint 2, held for a period each."""
    values = [{"joint[2].target_angle": one, "joint[2].target_velocity": other} for one, other in targets]
    instance, rows = Instance(fmu).start(**values[0]), []
    for k, given in enumerate(values):
        instance.set(given)
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
        found = dict(zip(names, rows[k], strict=True))
        assert [found[name] for name in motion] == chain.get(motion).tolist()
    assert abs(chain.get("joint[2].angular_velocity")) > 0.1


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

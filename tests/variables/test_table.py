"""The table of FMU variables: the designed names, with their words of the record and their features."""

# Tests: variables/scene_variables.py

import re
from collections import Counter

import numpy as np
import pytest

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.record.constants import SOLVER_METHODS, WALLS
from chain_impact.kernel.record.instance import output_dtype
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.scene import with_values
from chain_impact.scene.signals import signal_inputs_of
from chain_impact.variables.indices import word_index
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.units import UNITS
from tests.helpers.scenes.variable_scenes import SCENES, names, variables

LEGAL = {("parameter", "fixed", "exact"), ("parameter", "tunable", "exact"), ("input", "continuous", None)}
LEGAL |= {("output", "continuous", "calculated"), ("output", "discrete", "calculated")}


def test_variables_have_legal_names_units_and_descriptions():
    """Names are structured and unique; parameters, inputs and outputs come in this order."""
    part = r"[a-z_]\w*(\[\d+\])?"
    for scene in SCENES.values():
        variables = PreparedScene(scene).variables
        variable_names = [variable.name for variable in variables]
        assert len(set(variable_names)) == len(variable_names)
        assert all(re.fullmatch(rf"{part}(\.{part})*", name) for name in variable_names)
        layout = PreparedScene(scene).new_instance().dtype
        words = [word_index(layout, variable.record_path) for variable in variables]
        assert len(set(words)) == len(words)
        assert 0 <= min(words) <= max(words) < layout.itemsize // 8
        causalities = [variable.causality for variable in variables]
        assert causalities == sorted(causalities, key=["parameter", "input", "output"].index)
        for variable in variables:
            assert (variable.causality, variable.variability, variable.initial) in LEGAL
            assert variable.variability != "continuous" or variable.type == "real"
            assert variable.description.strip() == variable.description != ""
            assert (variable.unit in UNITS) == (variable.type == "real")
            assert bool(variable.items) == (variable.type == "enumeration")
    units = {variable.unit for scene in SCENES.values() for variable in PreparedScene(scene).variables}
    assert units - {""} == set(UNITS)


def test_word_index_counts_as_numpy_does():
    instance = PreparedScene(SCENES["four_link_box"]).new_instance()
    instance.view(np.int64)[:] = np.arange(instance.nbytes // 8)
    record = instance.view(instance.dtype)[0]
    assert word_index(instance.dtype, ("candidate", 7, "wall")) == record["candidate"]["wall"][7]
    place = ("step", "dense", 2, 5)
    assert word_index(instance.dtype, place) == record["step"]["dense"].view(np.int64)[2, 5]


NOWHERE = [
    ("chain", "length", 4),
    ("chain", "length", -1),
    ("chain", "lengths", 0),
    ("chain",),
    ("chain", "length"),
]


@pytest.mark.parametrize("place", [*NOWHERE, ("chain",), ("chain", "length"), ("step", "dense", 1)])
def test_word_index_refuses_what_is_not_there_or_not_one_number(place):
    with pytest.raises((KeyError, IndexError)):
        word_index(PreparedScene(SCENES["four_link_box"]).new_instance().dtype, place)


# --- variables of a scene's features -------------------------------------------------------------------


def test_parameters_of_the_four_link_box():
    expected = ["gravity.x", "gravity.y"]
    keys = ("length", "mass", "center_of_mass", "inertia")
    keys += ("joint_damping", "joint_stiffness", "joint_rest_angle")
    expected += [f"link[{i}].{key}" for i in range(1, 5) for key in keys]
    expected += [f"box.{wall}" for wall in WALLS]
    contact = ("model", "stiffness", "exponent", "restitution", "radius", "minimum_impact_speed")
    expected += [f"contact.{key}" for key in contact]
    expected += ["initial.x", "initial.y", "initial.vx", "initial.vy"]
    expected += [f"initial.angle[{i}]" for i in range(1, 5)]
    expected += [f"initial.angular_velocity[{i}]" for i in range(1, 5)]
    expected += ["solver.method", "solver.tolerance", "solver.work_limit"]
    assert names(SCENES["four_link_box"], "parameter") == expected


CONTACT = ("force", "penetration", "penetration_rate", "impulse")
IMPACT = ("time", "point", "wall", "speed", "end", "separation_speed")
IMPACT += ("peak_force", "max_penetration", "impulse")


def test_outputs_of_the_four_link_box():
    counts = Counter(re.sub(r"\d+", "#", name) for name in names(SCENES["four_link_box"], "output"))
    expected = {f"point[#].{key}": 5 for key in ("x", "y", "vx", "vy", "ax", "ay")}
    expected |= {f"link[#].{key}": 4 for key in ("angle", "angular_velocity", "angular_acceleration")}
    expected |= dict.fromkeys(("joint[#].angle", "joint[#].angular_velocity"), 3)
    for wall in WALLS:
        expected |= {f"contact[#].{wall}.{key}": 5 for key in CONTACT}
    single = [f"energy.{key}" for key in ("kinetic", "potential", "elastic", "dissipated", "total")]
    single += [f"impact.{key}" for key in ("count", "last_time", "last_point", "last_wall", "last_speed")]
    expected |= {f"impact[#].{key}": 8 for key in IMPACT}
    keys = ("steps", "rejected_steps", "rhs_evaluations", "implicit_steps", "status")
    single += [f"solver.{key}" for key in keys]
    assert counts == expected | dict.fromkeys(single, 1)


def test_outputs_are_those_asked_for():
    groups = dict.fromkeys(("points", "links", "contacts", "energies", "solver"), False) | {"impacts": 2}
    scene = SCENES["four_link_box"].with_values({f"outputs.{key}": value for key, value in groups.items()})
    output_names = names(scene, "output")
    last = [f"joint[{i}].{key}" for i in (2, 3, 4) for key in ("angle", "angular_velocity")]
    last += [f"impact.{key}" for key in ("count", "last_time", "last_point", "last_wall", "last_speed")]
    assert output_names == last + [f"impact[{j}].{key}" for j in (1, 2) for key in IMPACT]
    none = scene.with_values({"outputs.impacts": 0})
    assert names(none, "output") == last


def test_inputs_exist_only_if_asked_for():
    assert names(SCENES["four_link_box"], "input") == []
    driven_inputs = ["joint[2].torque", "joint[3].torque", "joint[4].torque", "tip.force.x", "tip.force.y"]
    assert names(SCENES["driven"], "input") == driven_inputs
    assert names(SCENES["pinned_arm"], "input") == ["joint[1].torque", "joint[2].torque"]
    assert "energy.supplied" in names(SCENES["driven"], "output")


def test_only_the_walls_and_points_of_the_scene():
    arm = [variable.name for variable in PreparedScene(SCENES["pinned_arm"]).variables]
    assert [name for name in arm if name.startswith("box.")] == ["box.x_max"]
    touching = {name.rpartition(".")[0] for name in arm if name.startswith("contact[")}
    assert touching == {"contact[1].x_max", "contact[2].x_max"}
    assert "initial.x" in arm
    assert "initial.vx" not in arm
    output_names = names(SCENES["two points"], "output")
    assert {name.partition(".")[0] for name in output_names if "contact" in name} == {
        "contact[0]",
        "contact[3]",
    }


def test_walls_at_any_angle_have_their_own_variables():
    ramp = names(SCENES["ramp"], "parameter")
    walls = [f"wall.{wall}.{key}" for wall in ("ramp", "stop") for key in ("x", "y", "angle")]
    assert [name for name in ramp if name.startswith("wall.")] == walls
    assert not [name for name in ramp if name.startswith("box")]
    slanted = variables(SCENES["slanted"])
    assert slanted["wall.slope.x"].record_path == ("walls", "x", 0)
    assert slanted["contact[4].slope.force"].record_path == ("output", "force", 24)
    assert (
        slanted["contact[4].slope.force"].description
        == "point 4 at slope: force of the wall, along its normal"
    )
    assert slanted["impact.last_wall"].description.endswith("3 y_min, 4 y_max, 5 slope")
    # a wall without candidates, and a removed wall
    assert not [
        name for name in variables(SCENES["walls without points"]) if name.startswith(("wall", "contact"))
    ]
    assert not [name for name in variables(SCENES["without walls"]) if name.startswith(("contact", "box"))]


# --- parameters ----------------------------------------------------------------------------------------

ALLOWED_VALUES = {
    "box.x_min": lambda _: -1.0,  # the start must stay outside the wall
    "box.y_min": lambda _: -1.0,
    "initial.angle[3]": lambda present: present - 0.01,  # the start must stay within the stop of a knee
    "contact.exponent": lambda _: 1.25,  # at least 1
    "stop.exponent": lambda _: 1.25,
    ".static_friction": lambda _: 1.1,  # at least the sliding friction
}
"""End of a parameter's name, if values near the present one are forbidden → function to an allowed value."""


@pytest.mark.full("more cases", but=14)
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_each_parameter_sets_its_place_and_nothing_else(scene):
    """Only values that the scene derives, such as corners of a box, change as well."""
    if scene is SCENES["rocking_block"]:  # the block stands on the floor, where a radius has no room
        scene = scene.with_values({"initial.y": 0.1})
    # with a rise, a sine of a position may begin at any time, because it begins at rest
    sines = [name for name, signal in scene.signals.items() if signal.form == "sine"]
    scene = scene.with_values({f"signal.{name}.rise": 0.1 for name in sines})
    paths = PreparedScene(scene).parameter_paths
    before_change = PreparedScene(scene).new_instance()
    derived_words = {
        word_index(before_change.dtype, v.record_path) for v in PreparedScene(scene).parameters if v.rule
    }
    if any(link.shape for link in scene.chain.links):  # the corners of a box
        sites = before_change.dtype["site"]
        derived_words |= {
            word_index(before_change.dtype, ("site", name, s))
            for name in ("x", "y", "given_radius", "radius")
            for s in range(sites[name].shape[0])
        }
    for variable in PreparedScene(scene).variables:
        if variable.causality != "parameter":
            continue
        path, word = paths[variable.name], word_index(before_change.dtype, variable.record_path)
        if variable.items:
            value, stored = variable.items[0].name, 1
            view = np.int64
        else:
            view = np.float64
            value = stored = 0.999 * before_change.view(view)[word].item() + 1e-4
        if key := next(filter(variable.name.endswith, ALLOWED_VALUES), None):
            value = stored = ALLOWED_VALUES[key](stored)
        after_change = PreparedScene(with_values(scene, {path: value})).new_instance()
        assert after_change.view(view)[word] == stored
        changed_words = np.flatnonzero(after_change.view(np.int64) != before_change.view(np.int64))
        places = {word, word_index(before_change.dtype, variable.set_path)}
        assert set(changed_words) <= places | derived_words, variable.name


def test_enumerations_number_laws_and_methods_as_the_kernel_does():
    choices = {variable.name: variable.items for variable in PreparedScene(SCENES["rod_drop"]).variables}
    for number, item in enumerate(choices["contact.model"], 1):
        assert CONTACT_LAWS[item.name].number == number
    assert tuple(item.name for item in choices["solver.method"]) == SOLVER_METHODS


def test_limits_come_from_the_scene():
    variables_found = variables(SCENES["rod_drop"])
    assert (
        variables_found["contact.restitution"].minimum,
        variables_found["contact.restitution"].maximum,
    ) == (0.0, 1.0)
    assert variables_found["link[1].mass"].exclusive_minimum == 0.0
    assert variables_found["link[1].mass"].allowed == "a finite number > 0 [kg]"
    assert variables_found["contact.model"].allowed.startswith("one of 1 (hertz), 2 (hunt_crossley), ")
    tunable = {name for name, variable in variables_found.items() if variable.variability == "tunable"}
    assert tunable == {"contact.model", "contact.stiffness", "contact.restitution"}


def test_every_status_is_in_the_description():
    status = variables(SCENES["friction"])["solver.status"]
    assert all(text in status.description for text in STATUS_TEXT.values())
    assert status.maximum == max(STATUS_TEXT)


# --- outputs -------------------------------------------------------------------------------------------


def test_columns_are_those_of_the_recorded_outputs():
    for scene in SCENES.values():
        outputs = np.zeros(3, PreparedScene(scene).output_layout)
        links, pairs = len(scene.chain.links), len(candidates_of(scene))
        rubbing = pairs + links + (scene.chain.slider is not None)
        rows = (
            rubbing if scene.has_friction else 0,
            links + len(scene.wall_names) if scene.outputs.loads else 0,
        )
        counts = (
            PreparedScene(scene).counts.channel_count,
            len(scene.chain.sites),
            len(signal_inputs_of(scene)),
        )
        assert outputs.dtype == output_dtype(links, pairs, *rows, *counts)
        width = outputs.dtype.itemsize // 8
        outputs.view(np.float64)[:] = np.arange(3 * width)
        columns, layout = PreparedScene(scene).series(outputs), PreparedScene(scene).new_instance().dtype
        start = layout.fields["output"][1] // 8
        for variable in PreparedScene(scene).variables:
            if variable.record_path[0] == "output":
                offset = word_index(layout, variable.record_path) - start
                assert columns.pop(variable.name).tolist() == [offset, offset + width, offset + 2 * width]
        assert not columns

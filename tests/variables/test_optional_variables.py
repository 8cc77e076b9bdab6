"""The variables that only some scenes have: of stops, materials and dry friction."""

# Tests: variables/structure.py

from functools import reduce
from operator import getitem

import pytest

from chain_impact import Chain
from chain_impact.kernel.record.constants import WALLS
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATUS_TEXT
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.keys.chain_tables import Link, Site, Slider
from chain_impact.scene.keys.tables import Contact, Initial, Material, Solver, Stops
from chain_impact.scene.rules.key_rules import key_fields, simple_default
from chain_impact.scene.scene import scene_from_dict, with_values
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.scenes.friction import pendulum, sled
from tests.helpers.scenes.stops import knee_scene
from tests.helpers.scenes.variable_scenes import MATERIALS, SCENES, STOPS, names, variables

# --- stops and materials -------------------------------------------------------------------------------


def test_a_scene_with_stops_has_their_variables():
    variables_found = variables(SCENES["stops"])
    new_names = variables_found.keys() - variables(SCENES["four_link_box"]).keys()
    parameters = {"link[2].joint_min", "link[2].joint_max", "link[4].joint_max"}
    parameters |= {f"stop.{key}" for key in ("stiffness", "exponent", "restitution", "minimum_impact_speed")}
    keys = ("stop_moment", "stop_penetration", "stop_impulse")
    assert new_names == parameters | {f"joint[{i}].{key}" for i in (2, 4) for key in keys}
    tunable = {name for name in new_names if variables_found[name].variability == "tunable"}
    assert tunable == {"stop.stiffness", "stop.restitution"}
    assert variables_found["stop.stiffness"].record_path == ("given", "stop_stiffness")
    assert variables_found["stop.exponent"].record_path == ("stops", "exponent")
    # behind the 20 pairs of points and walls come two stops of joint 2 and one of joint 4
    assert variables_found["joint[2].stop_moment"].record_path == ("output", "force", 20)
    assert variables_found["joint[4].stop_penetration"].record_path == ("output", "penetration", 22)
    assert variables_found["joint[4].stop_impulse"].record_path == ("output", "impulse", 22)
    assert [variables_found[f"joint[2].{key}"].unit for key in keys] == ["N.m", "rad", "N.m.s"]
    assert variables_found["stop.stiffness"].unit == "N.m/rad^exponent"


def test_the_list_of_impacts_says_what_it_holds_of_a_stop():
    variables_found = variables(SCENES["stops"])
    assert variables_found["impact.last_wall"].description.endswith("4 y_max, 5 joint_min, 6 joint_max")
    assert variables_found["impact[1].wall"].maximum == 6
    assert variables_found["impact[1].point"].description.endswith("; at a stop its joint")
    for key, unit in (("speed", "rad/s"), ("peak_force", "N·m"), ("impulse", "N·m·s")):
        assert variables_found[f"impact[1].{key}"].description.endswith(f" in {unit}")


def test_a_law_that_only_stops_use_can_be_chosen():
    parameters_of_stops = names(SCENES["stops only"], "parameter")
    stops = [f"stop.{key}" for key in ("stiffness", "exponent", "restitution", "minimum_impact_speed")]
    assert [name for name in parameters_of_stops if name.startswith(("contact", "stop"))] == [
        "contact.model",
        *stops,
    ]
    own_law_scene = with_values(SCENES["stops only"], {"stops.model": "flores"})
    assert "contact.model" not in names(own_law_scene, "parameter")


def test_a_scene_with_materials_has_what_it_gives_of_them():
    variables_found = variables(SCENES["materials"])
    new_names = variables_found.keys() - variables(SCENES["four_link_box"]).keys()
    assert new_names == MATERIALS.keys()
    assert {variables_found[name].variability for name in new_names} == {"tunable"}
    assert variables_found["wall.y_min.stiffness"].record_path == ("walls", "stiffness", 2)
    assert variables_found["wall.x_max.restitution"].record_path == ("walls", "restitution", 1)


def test_stops_and_materials_have_derivatives_but_for_the_least_speed():
    differentiable = (
        PreparedScene(SCENES["stops"]).differentiable | PreparedScene(SCENES["materials"]).differentiable
    )
    expected = {*STOPS, *MATERIALS, "stop.exponent", "stop.restitution"}
    assert expected <= differentiable.keys()
    assert not [
        name for name in differentiable if "minimum_impact_speed" in name or name.startswith("solver")
    ]


def test_walls_that_no_point_can_touch_have_no_number():
    walls = [{"name": f"slope_{w}", "point": (0.0, -2.0 - w), "angle": 0.1} for w in range(6)]
    lonely_scene = with_values(
        knee_scene(), {("walls",): walls, ("contact", "points"): (), ("contact", "wall"): {}}
    )
    assert lonely_scene.wall_names == (*WALLS, "joint_min", "joint_max")
    assert candidates_of(lonely_scene) == [(2, 4), (2, 5)]
    assert not any(variable.name.startswith("wall.") for variable in PreparedScene(lonely_scene).variables)
    chain = Chain(lonely_scene)
    chain.step(0.5)
    chain.restore(chain.save())
    touched = with_values(knee_scene(), {("walls",): walls})
    assert touched.wall_names.index("joint_min") == 10


# --- dry friction ----------------------------------------------------------------------------------------

RUBBING = {"contact.friction": 0.3, "wall.x_max.static_friction": 0.5, "link[3].joint_friction": 0.2}
RUBBING = with_values(SCENES["four_link_box"], RUBBING)


def is_dry(variable):
    return "friction" in f"{variable.name}{variable.description}" or "stick" in variable.name


def test_a_scene_without_friction_has_no_variable_more_and_no_status():
    other_features = {"link[2].joint_max": 2.0, "inputs.joint_torques": True}
    variables_found = variables(SCENES["four_link_box"].with_values(other_features))
    assert not [variable.name for variable in variables_found.values() if is_dry(variable)]
    # the status of friction at rigid walls exists only in scenes with friction at walls
    text = STATUS_TEXT[FRICTION_WITH_RIGID_WALLS]
    assert text not in variables_found["solver.status"].description
    assert text in variables(RUBBING)["solver.status"].description


def test_a_scene_with_friction_has_its_variables():
    variables_found = variables(RUBBING)
    parameters = {"contact.friction", "contact.static_friction", "wall.x_max.static_friction"}
    touches = ("friction_force", "friction_impulse", "sticking")
    outputs = {f"contact[{k}].{wall}.{key}" for k in range(5) for wall in WALLS for key in touches}
    of_joint = {"link[3].joint_friction", "joint[3].friction_moment", "joint[3].sticking"}
    new_names = variables_found.keys() - variables(SCENES["four_link_box"]).keys()
    assert new_names == parameters | outputs | of_joint | {"energy.friction"}
    assert {name for name in new_names if variables_found[name].variability == "tunable"} == parameters
    assert variables_found["contact.friction"].record_path == ("given", "friction")
    assert variables_found["wall.x_max.static_friction"].record_path == ("walls", "static_friction", 1)
    assert variables_found["contact[1].x_min.friction_force"].record_path == (
        "output",
        "friction",
        "force",
        4,
    )
    of_joint = {"friction_moment": "drive_friction", "sticking": "drive_sticking"}
    for name, field in of_joint.items():
        assert variables_found[f"joint[3].{name}"].record_path == ("output", "friction", field, 2)
    units = [variables_found[f"contact[4].y_max.{key}"].unit for key in touches]
    assert (units, variables_found["joint[3].friction_moment"].unit) == (["N", "N.s", "1"], "N.m")
    assert (variables_found["joint[3].sticking"].minimum, variables_found["joint[3].sticking"].maximum) == (
        0.0,
        1.0,
    )
    assert "dry friction" in variables_found["energy.dissipated"].description


def test_only_the_joints_with_friction_have_variables():
    one_joint = variables(pendulum(**{"link[2].joint_friction": None}))
    new_names = {name for name, variable in one_joint.items() if is_dry(variable)} - {"energy.dissipated"}
    of_joint = {"link[1].joint_friction", "joint[1].friction_moment", "joint[1].sticking"}
    assert new_names == of_joint | {"energy.friction"}
    free_base = variables(with_values(SCENES["four_link_box"], {"link[1].joint_friction": 0.2}))
    assert free_base.keys() == variables(SCENES["four_link_box"]).keys()


def test_friction_is_there_with_the_group_of_outputs_that_it_belongs_to():
    no_contacts = variables(RUBBING.with_values({"outputs.contacts": False}))
    assert not [name for name in no_contacts if "stick" in name or name.endswith("friction_moment")]
    assert "energy.friction" in no_contacts
    assert "energy.friction" not in variables(RUBBING.with_values({"outputs.energies": False}))


def test_a_sticking_element_answers_to_an_input_at_once():
    variables_found = variables(sled())
    at_once = {
        name
        for name in variables_found
        if name.startswith("contact[0]") and variables_found[name].feedthrough
    }
    assert at_once == {f"contact[0].slope.{key}" for key in ("force", "friction_force", "sticking")}


TABLE_CLASSES = {
    ("chain", "slider"): Slider,
    ("chain", "links", 1): Link,
    ("chain", "links", 0, "points", 0): Site,
    ("contact",): Contact,
    ("contact", "wall", "y_min"): Material,
    ("stops",): Stops,
    ("initial",): Initial,
    ("solver",): Solver,
}
"""Path of a table in the file of ``rod_on_a_slider`` → dataclass of the table."""


def rod_on_a_slider(*path, **given):
    """Return the scene of two links on a slider; its file has values ``given`` in the table at ``path``."""
    links = [{"length": 1, "mass": 1, "joint_min": -2, "points": [{"x": 0.3}]}, {"length": 1, "mass": 1}]
    data = {"name": "Rod", "chain": {"base": "slider", "slider": {}, "links": links}, "box": {"y_min": -3}}
    data |= {"contact": {"wall": {"y_min": {}}}, "stops": {}, "initial": {"angles": [0, 0]}, "solver": {}}
    reduce(getitem, path, data).update(given)
    return scene_from_dict(data, "rod.toml")


def numbers_with_defaults():
    """Yield the path and the default of each key whose default is a number in every scene."""
    for path, table_class in TABLE_CLASSES.items():
        for entry in key_fields(table_class):
            default = simple_default(entry.metadata)
            if isinstance(default, int | float) and not isinstance(default, bool):
                yield (*path, entry.name), default


@pytest.mark.parametrize(("path", "default"), list(numbers_with_defaults()))
def test_a_number_that_the_file_gives_is_a_parameter(path, default):
    *table_path, key = path
    scene = rod_on_a_slider(*table_path, **{key: default})
    assert path in {variable.scene_path for variable in PreparedScene(scene).parameters}


def test_a_zero_that_the_file_does_not_give_is_no_variable():
    plain_scene, link_path = rod_on_a_slider(), ("chain", "links", 1)
    absent_paths = {("contact", "friction"), ("contact", "static_friction"), ("chain", "slider", "friction")}
    absent_paths |= {
        (*link_path, key) for key in ("center_of_mass_offset", "joint_armature", "joint_friction")
    }
    assert not absent_paths & {variable.scene_path for variable in PreparedScene(plain_scene).variables}
    assert not any(is_dry(variable) for variable in PreparedScene(plain_scene).variables)
    zeros_scene = rod_on_a_slider(*link_path, joint_armature=0, joint_friction=0)
    restored_scene = zeros_scene.with_values({"link[2].joint_armature": None, "link[2].joint_friction": None})
    assert restored_scene == plain_scene
    assert (
        PreparedScene(restored_scene).new_instance().tobytes()
        == PreparedScene(plain_scene).new_instance().tobytes()
    )

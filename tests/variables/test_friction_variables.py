"""The variables of dry friction: those that the scene has, each at its place, and none without friction."""

from chain_impact import load_scene
from chain_impact.kernel.status import FRICTION_WITH_RIGID_WALLS, STATUS_TEXT
from chain_impact.scene.scene import WALLS, with_values
from chain_impact.variables.model import Model
from tests.friction import pendulum, sled

BOX = load_scene("four_link_box")
RUBBING = with_values(
    BOX, {"contact.friction": 0.3, "wall.x_max.static_friction": 0.5, "link[3].joint_friction": 0.2}
)


def variables(scene):
    return {variable.name: variable for variable in Model(scene).variables}


def is_dry(variable):
    return "friction" in f"{variable.name}{variable.description}" or "stick" in variable.name


def test_a_scene_without_friction_has_no_variable_more_and_no_status():
    found = variables(BOX.with_values({"link[2].joint_max": 2.0, "inputs.joint_torques": True}))
    assert not [variable.name for variable in found.values() if is_dry(variable)]
    # the status of friction at rigid walls is one of scenes with friction at walls only
    text = STATUS_TEXT[FRICTION_WITH_RIGID_WALLS]
    assert text not in found["solver.status"].description
    assert text in variables(RUBBING)["solver.status"].description


def test_a_scene_with_friction_has_its_variables():
    found = variables(RUBBING)
    parameters = {"contact.friction", "contact.static_friction", "wall.x_max.static_friction"}
    touches = ("friction_force", "friction_impulse", "sticking")
    outputs = {f"contact[{k}].{wall}.{key}" for k in range(5) for wall in WALLS for key in touches}
    of_joint = {"link[3].joint_friction", "joint[3].friction_moment", "joint[3].sticking"}
    new = found.keys() - variables(BOX).keys()
    assert new == parameters | outputs | of_joint | {"energy.friction"}
    assert {name for name in new if found[name].variability == "tunable"} == parameters
    assert found["contact.friction"].place == ("given", "friction")
    assert found["wall.x_max.static_friction"].place == ("walls", "static_friction", 1)
    assert found["contact[1].x_min.friction_force"].place == ("output", "friction", "force", 4)
    assert found["joint[3].friction_moment"].place == ("output", "friction", "joint_moment", 2)
    assert found["joint[3].sticking"].place == ("output", "friction", "joint_sticking", 2)
    units = [found[f"contact[4].y_max.{key}"].unit for key in touches]
    assert (units, found["joint[3].friction_moment"].unit) == (["N", "N.s", "1"], "N.m")
    assert (found["joint[3].sticking"].minimum, found["joint[3].sticking"].maximum) == (0.0, 1.0)
    assert "dry friction" in found["energy.dissipated"].description


def test_only_the_joints_with_friction_have_variables():
    one = variables(pendulum(**{"link[2].joint_friction": 0.0}))
    new = {name for name, variable in one.items() if is_dry(variable)} - {"energy.dissipated"}
    assert new == {
        "link[1].joint_friction",
        "joint[1].friction_moment",
        "joint[1].sticking",
        "energy.friction",
    }
    free = variables(with_values(BOX, {"link[1].joint_friction": 0.2}))
    assert free.keys() == variables(BOX).keys()


def test_friction_is_there_with_the_group_of_outputs_that_it_belongs_to():
    no_contacts = variables(RUBBING.with_values({"outputs.contacts": False}))
    assert not [name for name in no_contacts if "stick" in name or name.endswith("friction_moment")]
    assert "energy.friction" in no_contacts
    assert "energy.friction" not in variables(RUBBING.with_values({"outputs.energies": False}))


def test_what_sticks_answers_to_an_input_at_once():
    found = variables(sled())
    at_once = {name for name in found if name.startswith("contact[0]") and found[name].feedthrough}
    assert at_once == {f"contact[0].slope.{key}" for key in ("force", "friction_force", "sticking")}


def test_the_field_and_the_index_of_a_place():
    found = variables(RUBBING)
    force = found["contact[1].x_min.friction_force"]
    assert (force.field, force.index) == ("friction.force", (4,))
    assert (found["point[2].vy"].field, found["point[2].vy"].index) == ("point_velocity", (2, 1))
    assert (found["energy.total"].field, found["energy.total"].index) == ("total", ())

"""The rows of the table of variables: their references exist, and their statements hold for all variables."""

# Tests: variables/key_kinds.py, variables/nominal_values.py, variables/parameters.py
# Tests: variables/description_texts.py

import pytest

from chain_impact import load_scene
from chain_impact.kernel.record.instance import output_dtype
from chain_impact.scene.facts import TRUE_FACT
from chain_impact.scene.texts.input_table import INPUT_KINDS
from chain_impact.scene.texts.names import is_like
from chain_impact.variables.description_texts import owner_texts, scene_texts
from chain_impact.variables.nominal_values import nominal_values
from chain_impact.variables.outputs import INPUTS, OUTPUTS
from chain_impact.variables.parameters import PARAMETERS
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.scene_variables import absent_hint
from chain_impact.variables.structure import structure_of
from tests.variables.everything import CART, EVERYTHING

KINDS = [kind for block in (*PARAMETERS, *INPUTS, *OUTPUTS) for kind in block.kinds]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.pattern)
def test_owner_conditions_and_texts_of_a_row_exist(kind):
    structure = structure_of(CART if kind.owner_kind == "slider" else EVERYTHING)
    (owner, *_) = structure.owners(kind.owner_kind)
    words = scene_texts(structure) | owner.values | owner_texts(kind.owner_kind, structure, owner.values)
    assert {*kind.when, kind.tunable or TRUE_FACT, kind.stores_given_if or TRUE_FACT} <= {*owner.conditions}
    assert "{" not in kind.description.format_map(words)
    assert all(name in words for name in (kind.minimum, kind.maximum) if isinstance(name, str))
    assert kind.nominal == "" or kind.nominal in nominal_values(EVERYTHING)
    assert kind.rate_of == "" or kind.rate_of in output_dtype(1, 0, 0, 0, 0).names


def test_variables_of_a_kind_are_described_at_once():
    descriptions = {
        variable.kind.pattern: variable.kind_description for variable in PreparedScene(EVERYTHING).variables
    }
    assert descriptions["link[i].length"] == "link i: length; must be > 0"
    assert descriptions["wall.<wall>.x"] == "wall at any angle: x of a point on the wall"
    assert descriptions["contact[k].<wall>.penetration"] == "point k at a wall: penetration, 0 when apart"
    assert descriptions["joint[i].angle"] == "joint i: angle of link i relative to the link before"
    pinned_descriptions = {
        variable.kind.pattern: variable.kind_description
        for variable in PreparedScene(load_scene("triple_pendulum")).variables
    }
    assert (
        pinned_descriptions["joint[i].angle"]
        == "joint i: angle of link i relative to the link before, or the ground"
    )


def test_the_derivatives_of_a_kind_are_a_kind():
    prepared_scene = PreparedScene(
        load_scene("four_link_box").with_values({"outputs.sensitivities": ["link[*].mass"]})
    )
    kinds = {
        variable.kind.pattern: variable.kind_description
        for variable in prepared_scene.variables
        if variable.name.startswith("sens")
    }
    assert (
        kinds["sensitivity.link[i].mass.point[k].x"]
        == "derivative of point[k].x with respect to link[i].mass"
    )
    assert len(kinds) == len({output.kind.pattern for output in prepared_scene.continuous_outputs})


def test_a_name_is_like_its_template_only():
    names = ["joint[12].torque", "wall.ramp.belt_speed", "tip.force.x"]
    assert [sum(is_like(name, template) for template in INPUT_KINDS) for name in names] == [1, 1, 1]
    for name in (
        "joint[].torque",
        "joint[a].torque",
        "joint[1.torque",
        "joint.torque",
        "wall.a[1].belt_speed",
    ):
        assert not any(is_like(name, template) for template in INPUT_KINDS)


def test_a_parameter_that_a_scene_lacks_has_a_hint():
    lacking = ("wall.ramp.friction", "contact.friction", "link[3].joint_friction", "link[1].joint_armature")
    assert all(absent_hint(name) for name in lacking)
    assert absent_hint("link[1].joint_rest_angle") != absent_hint("link[1].joint_friction")
    assert absent_hint("link[1].mass") is absent_hint("friction") is None

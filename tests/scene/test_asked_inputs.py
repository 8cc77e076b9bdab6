"""Advice for an input that a scene lacks makes this input or the one that it names, or says why it cannot."""

import re

import pytest

from chain_impact import load_scene
from chain_impact.scene.asked_inputs import inputs_of, request_hint
from chain_impact.scene.texts.input_table import INPUT_KINDS
from chain_impact.scene.texts.names import is_like
from tests.helpers.tools.refusal import refusal

ASKS = re.compile(r"set inputs\.(\w+) = (true|\[\"(\w+)\"\])$")


@pytest.mark.parametrize("model", ["four_link_box", "pinned_arm", "cart_pole", "bouncing_table", "golf_ball"])
def test_what_is_advised_makes_the_input(model):
    scene = load_scene(model)
    links, walls = len(scene.chain.links), [*scene.half_planes, "nowhere"]
    names = {
        form.format(n=number, name=wall)
        for form in INPUT_KINDS
        for number in (1, links, links + 1)
        for wall in walls
    }
    for name in sorted(names - {*inputs_of(scene)}):
        advice = request_hint(scene, name)
        nearest_name = re.search(r"the nearest is ([^,;]+)", advice)
        expected_input = nearest_name[1] if nearest_name else name
        if request := ASKS.search(advice):
            value = [request[3]] if request[3] else True
            assert expected_input in inputs_of(scene.with_values({f"inputs.{request[1]}": value})), advice
        elif nearest_name:
            assert expected_input in inputs_of(scene), advice
        elif "chain.base" in advice:
            key = "slider_force" if name.startswith("slider") else "base_motion"
            assert refusal(scene.with_values, {f"inputs.{key}": True})
        else:
            assert advice.startswith(("there is no wall nowhere", "no point can touch a wall", "it has "))


def test_a_free_base_has_no_joint_1():
    scene = load_scene("rod_drop").with_values({"inputs.joint_torques": True})
    assert 'chain.base = "free"' in request_hint(scene, "joint[1].torque")
    assert "chain.base" not in request_hint(load_scene("pinned_arm"), "joint[3].torque")


def test_a_scene_can_ask_for_the_inputs_of_each_row_of_the_table():
    scenes = (
        load_scene(model).with_values({"inputs.wall_motion": ["*"]}) for model in ("pinned_arm", "cart_pole")
    )
    names = {name for scene in scenes for name in inputs_of(scene, are_asked=False)}
    assert [row for row in INPUT_KINDS if not any(is_like(name, row) for name in names)] == []

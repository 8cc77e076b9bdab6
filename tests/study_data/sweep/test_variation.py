"""Variations of a parameter as text and as numbers, and refused variations with one-sentence messages."""

import numpy as np
import pytest

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.errors import SceneError, SceneWarning
from chain_impact.scene.scene import load_scene
from chain_impact.study_data.sweep.variation import sweepable_variables, variations_of

SCENE = load_scene("four_link_box")


def variation_of(name, values):
    (variation,) = variations_of(SCENE, {name: values})
    return variation


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.5", [0.5]),
        ("0.1, 0.5,0.2", [0.1, 0.5, 0.2]),
        ("0.1:0.9:5", [0.1, 0.3, 0.5, 0.7, 0.9]),
        ("0.9:0.1:3", [0.9, 0.5, 0.1]),
        ("0.001:1:4:log", [0.001, 0.01, 0.1, 1.0]),
        ([0.1, 0.5], [0.1, 0.5]),
        (np.linspace(0.0, 1.0, 3), [0.0, 0.5, 1.0]),
        (0.3, [0.3]),
    ],
)
def test_texts_and_numbers_give_the_values_of_a_variation(text, values):
    variation = variation_of("contact.restitution", text)
    assert not variation.interval
    assert variation.values == pytest.approx(values, rel=1e-15)
    assert variation.values[[0, -1]].tolist() == [values[0], values[-1]]


@pytest.mark.parametrize(
    ("name", "text", "values"),
    [
        ("contact.restitution", "0.1:1:10", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]),
        ("gravity.x", "-0.3:0.3:7", [-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3]),
        ("contact.stiffness", "1e5:1e10:6:log", [1e5, 1e6, 1e7, 1e8, 1e9, 1e10]),
        ("gravity.x", "0:0:3", [0.0, 0.0, 0.0]),
    ],
)
def test_the_values_of_a_range_have_no_round_off(name, text, values):
    assert variation_of(name, text).values.tolist() == values


def test_choices_by_name_and_by_number():
    for values in ("flores,hertz", "10,1", ["flores", "hertz"], [10, "hertz"]):
        variation = variation_of("contact.model", values)
        assert variation.values.tolist() == [CONTACT_LAWS["flores"].number, CONTACT_LAWS["hertz"].number]
        assert variation.shown_values(variation.values).tolist() == ["flores", "hertz"]


def test_an_interval_gives_values_at_fractions():
    parts = np.array([0.0, 0.5, 1.0 - 1e-16])
    assert variation_of("contact.restitution", "0.2:0.4").values_at(parts) == pytest.approx([0.2, 0.3, 0.4])
    assert variation_of("contact.stiffness", "1e6:1e8:log").values_at(parts) == pytest.approx([1e6, 1e7, 1e8])
    assert variation_of("contact.model", "flores,hertz").values_at(np.array([0.0, 0.49, 0.5])).tolist() == [
        10,
        10,
        1,
    ]


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        (
            "contact.restitutio",
            "0.1",
            "not a parameter that can be varied; the nearest is contact.restitution",
        ),
        ("point[4].x", "0.1", "not a parameter that can be varied"),
        ("base.vx", "0,1", "not a parameter that can be varied; it is an input"),
        ("contact.points", "0,1", "not a parameter that can be varied; change it in the scene file"),
        (
            "initial.joint_angles[1]",
            "0,1",
            r"not a parameter that can be varied; set initial.angle\[1\] and so on",
        ),
        ("contact.restitution", "0.1:1.4:3", "= 1.4 must"),
        ("contact.restitution", "0.5,1.5", "= 1.5 must be a finite number >= 0 and <= 1"),
        ("contact.restitution", "nan", "= nan must be a finite number"),
        ("contact.restitution", "0.5,half", "= half must be a finite number"),
        ("contact.stiffness", "0:1e8:3", r"= 0 must be a finite number > 0 \[N/m"),
        ("contact.stiffness", "0:1e8:3:log", "must have ends > 0"),
        ("contact.stiffness", "1:2:1", "must have 2 to 10000000 values"),
        ("contact.stiffness", "1:2:3:4", "must be a list"),
        ("contact.stiffness", "1:two", "must be a list"),
        ("contact.stiffness", "1:log", "must be a list"),
        ("contact.stiffness", [], "must be a list"),
        ("contact.model", "1:3:3", "must be a list of choices"),
        ("contact.model", "florez", "must be one of 1 .*; the nearest is flores$"),
        ("contact.model", "19", "= 19 must be one of 1"),
        ("contact.model", "1.5", "= 1.5 must be one of 1"),
        ("simulation.stop_time", "0,1", "= 0 must be a finite number > 0"),
    ],
)
def test_wrong_variations_are_refused(name, values, words):
    with pytest.raises(
        SceneError, match=f"^FourLinkBox: {name.replace('[', '.').replace(']', '.')}.*{words}"
    ):
        variation_of(name, values)


def test_a_sweep_that_varies_nothing_is_refused():
    with pytest.raises(SceneError, match="nothing is varied"):
        variations_of(SCENE, {})


def test_each_parameter_and_the_stop_time_can_be_varied():
    variables = sweepable_variables(SCENE)
    assert {"gravity.x", "link[4].mass", "solver.method", "initial.angle[1]", "box.y_max"} <= variables.keys()
    assert "simulation.stop_time" in variables
    assert "solver.steps" not in variables


@pytest.mark.parametrize("values", ["0:90:3", [-90.0, 3.0]])
def test_angles_of_more_than_a_turn_are_pointed_at(values):
    with pytest.warns(SceneWarning, match=r"initial\.angle\[1\] = -?90 rad is 14\.3 turns: if degrees"):
        variation_of("initial.angle[1]", values)


def test_angles_of_less_than_a_turn_are_not(recwarn):
    variation_of("initial.angle[1]", "0 deg:360 deg:5")
    variation_of("initial.angular_velocity[1]", "0:90:3")
    assert not recwarn.list

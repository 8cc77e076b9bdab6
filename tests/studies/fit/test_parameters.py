"""Fitted parameters, their scale and their bounds."""

import math

import pytest

from chain_impact import load_scene, simulate
from chain_impact.scene.scene import scene_from_dict
from chain_impact.studies.fit.parameters import fitted_parameters
from tests.helpers.tools.refusal import refusal

SCENE = load_scene("four_link_box")


def make(names, free_each=(), bounds=None, scenes=(SCENE,)):
    return fitted_parameters(scenes, names, free_each, bounds or {})


def test_positive_parameters_are_sought_as_logarithms():
    stiffness, e, rate, damping = make(
        ["contact.stiffness", "contact.restitution", "initial.angular_velocity[3]", "link[2].joint_damping"]
    )
    assert stiffness.logarithmic
    assert stiffness.coordinate(1e8) == pytest.approx(math.log(1e8))
    assert stiffness.value(stiffness.coordinate(1e8)) == pytest.approx(1e8)
    assert stiffness.slope(1e8) == 1e8
    assert (stiffness.low, stiffness.high) == (0.0, math.inf)
    assert stiffness.ends == pytest.approx((0.0, math.log(1e16)))
    assert not e.logarithmic
    assert (e.low, e.high, e.start, e.ends) == (0.0, 1.0, 0.7, (0.0, 1.0))
    assert rate.ends == (-math.inf, math.inf)
    assert (damping.low, damping.high, damping.slope(0.0)) == (0.0, math.inf, 1.0)


def test_given_bounds_stay_within_the_range_of_the_key():
    (e,) = make(["contact.restitution"], bounds={"contact.restitution": "0.3:2"})
    assert (e.low, e.high) == (0.3, 1.0)
    (x,) = make(["initial.x"], bounds={"initial.x": ":2"})
    assert (x.low, x.high) == (-math.inf, 2.0)
    (x,) = make(["initial.x"], bounds={"initial.x": (0.5, None)})
    assert (x.low, x.high) == (0.5, math.inf)


def test_parameters_of_each_data_set():
    other_scene = SCENE.with_values({"initial.vx": 1.0})
    shared, first, second = make(["contact.stiffness"], ["initial.vx"], scenes=(SCENE, other_scene))
    assert (shared.data_set, first.data_set, second.data_set) == (None, 0, 1)
    assert (first.start, second.start) == (1.5, 1.0)
    assert second.label == "initial.vx of data set 2"


def test_the_search_for_a_target_starts_at_the_rest_angle():
    values = {"joint_stiffness": 5.0, "joint_rest_angle": 0.7}
    scene = scene_from_dict(
        {
            "name": "Servo",
            "chain": {"base": "pinned", "links": [{"length": 0.4, "mass": 1.0} | values]},
            "inputs": {"joint_targets": True, "joint_torques": True},
            "initial": {"angles": [0.5]},
        },
        "servo",
    )
    target, torque = make(["joint[1].target_angle", "joint[1].torque"], scenes=(scene,))
    assert (target.start, torque.start) == (0.7, 0.0)
    result = simulate(scene, 0.1, sensitivities=["joint[1].target_angle"])
    assert result.sensitivities.parameters == {"joint[1].target_angle": 0.7}
    input_result = simulate(
        scene,
        0.1,
        sensitivities=["joint[1].target_angle"],
        inputs={"joint[1].target_angle": [(0.0, 0.1), (1, 2)]},
    )
    assert input_result.sensitivities.parameters == {"joint[1].target_angle": 0.0}


def test_wrong_parameters_are_refused():
    assert refusal(make, []) == "FourLinkBox: no parameter is free; name at least one"
    assert (
        "contact.stifness is not a parameter that can be fitted; the nearest is contact.stiffness"
        in refusal(make, ["contact.stifness"])
    )
    for name in ("contact.model", "solver.tolerance", "contact.minimum_impact_speed"):
        assert "is not a parameter that can be fitted" in refusal(make, [name])
    assert "is named twice" in refusal(make, ["initial.x"], ["initial.x"])
    assert "bounds of initial.y: the parameter is not free; free is initial.x" in refusal(
        make, ["initial.x"], (), {"initial.y": "0:1"}
    )
    for text, message in (
        ("1", "must be LOW:HIGH"),
        ("a:b", "must be LOW:HIGH"),
        ("nan:1", "must be numbers"),
        ("2:1", "must be <"),
        ("1:2", "where the search starts, must be within"),
    ):
        assert message in refusal(make, ["initial.x"], (), {"initial.x": text})

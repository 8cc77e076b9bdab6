"""Bodies and points on links, against conserved quantities, closed forms and equivalent scenes."""

import re

import numpy as np
import pytest
from scipy.special import ellipk

from chain_impact import Chain, SimulationError, simulate
from chain_impact.scene.scene import SceneError
from tests.helpers.tools.differences import slope
from tests.scenarios.changed_scenes import changed, scene

ROD = {
    "name": "Rod",
    "chain": {"links": [{"length": 0.5, "mass": 1.0}]},
    "box": {"y_min": 0.0},
    "contact": {"stiffness": 1e6, "friction": 0.3},
    "initial": {"position": [0.0, 0.5], "angles": [0.3], "angular_velocities": [2.0]},
}


@pytest.mark.parametrize("method", ["auto", "explicit", "implicit"])
def test_points_at_the_ends_of_a_link_touch_as_the_ends_do(method):
    twin = changed(ROD, contact={"points": []})
    twin["chain"]["links"][0]["points"] = [{"x": 0.0, "y": 0.0}, {"x": 0.5, "y": 0.0}]
    ends, points = (simulate(scene(data), stop_time=1.5, method=method) for data in (ROD, twin))
    assert len(ends.impacts) == len(points.impacts) > 10
    np.testing.assert_allclose(points.angles, ends.angles, rtol=0.0, atol=1e-10)
    for name in ("onset", "end", "peak_force", "impulse"):
        np.testing.assert_allclose(points.impacts[name], ends.impacts[name], rtol=1e-8, atol=1e-10)
    assert set(points.impacts["point"]) == {2, 3}
    np.testing.assert_allclose(points["point[3].x"], ends["point[1].x"], rtol=0.0, atol=1e-10)
    assert points.points.shape[1:] == (2, 2)
    assert points.sites.shape[1:] == (2, 2)


def test_a_box_comes_to_rest_on_two_of_its_corners():
    data = changed(ROD, contact={"points": [], "friction": 0.4, "restitution": 0.5})
    data["chain"]["links"][0] |= {"shape": "box", "height": 0.2}
    box = scene(data)
    assert box.chain.links[0].inertia == pytest.approx((0.5**2 + 0.2**2) / 12, rel=1e-15)
    run = simulate(box, stop_time=4.0)
    depth = (1.0 * 9.81 / 2 / 1e6) ** (1 / 1.5)  # half of the weight on each corner
    np.testing.assert_allclose(run.sites[-1, :2, 1], -depth, rtol=1e-6)
    assert run.angles[-1, 0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("center", [{}, {"center_of_mass": 0.1}, {"center_of_mass_offset": -0.07}])
@pytest.mark.parametrize("height", [0.2, 0.45])
def test_a_box_swings_by_the_inertia_of_its_rectangle_and_parallel_axes(center, height):
    """The inertia about the centre of mass is that of the rectangle, wherever the centre of mass is."""
    length, mass, start = 0.5, 1.3, 1.1
    link = {"length": length, "mass": mass, "shape": "box", "height": 0.2, **center}
    along, beside = center.get("center_of_mass", length / 2), center.get("center_of_mass_offset", 0.0)
    arm, hanging = np.hypot(along, beside), -np.pi / 2 - np.arctan2(beside, along)
    about_pivot = mass * (length**2 + height**2) / 12 + mass * arm**2
    # a quarter of the period of a pendulum that starts from rest at an angle from its rest position
    quarter = np.sqrt(about_pivot / (mass * 9.81 * arm)) * ellipk(np.sin(start / 2) ** 2)
    data = {
        "name": "Box",
        "chain": {"base": "pinned", "links": [link]},
        "box": {},
        "initial": {"angles": [hanging + start]},
    }
    run = simulate(scene(data).with_values({"link[1].height": height}), stop_time=quarter, tolerance=1e-12)
    fastest = np.sqrt(2 * mass * 9.81 * arm * (1 - np.cos(start)) / about_pivot)
    assert run.angles[-1, 0] == pytest.approx(hanging, abs=1e-10)
    assert run["link[1].angular_velocity"][-1] == pytest.approx(-fastest, rel=1e-10)


def test_an_offset_of_the_centre_of_mass_is_that_of_a_link_turned_by_it():
    """A pendulum with its centre of mass at (0.2, 0.1) equals a pendulum whose straight link points there."""
    reach, turned = np.hypot(0.2, 0.1), np.arctan2(0.1, 0.2)

    def swing(link, angle):
        chain = {"base": "pinned", "links": [{"length": 0.5, "mass": 1.0, "inertia": 0.02, **link}]}
        return simulate(
            scene(
                {
                    "name": "P",
                    "chain": chain,
                    "box": {},
                    "contact": {"points": []},
                    "initial": {"angles": [angle]},
                }
            ),
            stop_time=2.0,
            tolerance=1e-11,
        )

    beside = swing({"center_of_mass": 0.2, "center_of_mass_offset": 0.1}, 0.3)
    along = swing({"center_of_mass": float(reach)}, 0.3 + turned)
    np.testing.assert_allclose(beside.angles + turned, along.angles, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(beside["energy.total"], along["energy.total"], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "number", "part", "key"),
    [
        ("slider.min", 0.6, "the slider", "min"),
        ("link[2].joint_max", -0.6, "joint 2", "max"),
        ("slider.mass", 0.0, "link[1]", "slider.mass"),
    ],
)
def test_a_refused_stop_or_mass_is_told_with_its_owner(name, number, part, key):
    link = {"length": 0.5, "mass": 1.0, "inertia": 0.0}
    links = [link, link | {"joint_min": -0.5, "joint_max": 0.5}]
    chain = {"base": "slider", "slider": {"min": -0.5, "max": 0.5}, "links": links}
    chain = Chain(scene({"name": "Cart", "chain": chain, "box": {}, "initial": {"angles": [0.1, 0.1]}}))
    chain.set(name, number)
    with pytest.raises(SimulationError, match=re.escape(key)) as caught:
        chain.step(0.1)
    assert caught.value.part == part


@pytest.mark.parametrize(
    "name", ["link[1].center_of_mass_offset", "link[1].point[1].x", "link[1].point[1].y", "contact.radius"]
)
def test_derivatives_by_what_a_body_is_are_those_of_differences(name):
    data = changed(
        ROD, contact={"points": [], "friction": 0.0, "radius": 0.01}, initial={"angular_velocities": [0.5]}
    )
    link = data["chain"]["links"][0]
    link |= {"center_of_mass_offset": 0.02, "points": [{"x": 0.45, "y": -0.1}]}
    body = scene(data)
    run = simulate(body, stop_time=0.4, tolerance=1e-11, sensitivities=[name])
    assert len(run.impacts) == 1
    assert run.impacts["end"][0] < 0.4
    outputs = ("point[1].y", "point[2].x", "link[1].angular_velocity")

    def ends(number):
        varied = simulate(body.with_values({name: number}), stop_time=0.4, tolerance=1e-12)
        return np.array([varied[output][-1] for output in outputs])

    for output, expected in zip(outputs, slope(ends, body.values[name], 1e-6), strict=True):
        assert run.sensitivity(output, name)[-1] == pytest.approx(expected, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize(
    ("tables", "key"),
    [
        (
            {
                "chain": {
                    "links": [{"length": 1.0, "mass": 1.0, "points": [{"x": 0.5, "y": -0.8, "name": "heel"}]}]
                }
            },
            "heel",
        ),
        (
            {"chain": {"links": [{"length": 1.0, "mass": 1.0, "points": [{"x": 0.5, "radius": -1.0}]}]}},
            "radius",
        ),
        ({"chain": {"links": [{"length": 1.0, "mass": 1.0, "shape": "box"}]}}, "height"),
        ({"chain": {"base": "slider", "slider": {"min": 0.1, "max": 0.0}}}, "slider.max"),
        ({"chain": {"base": "slider", "slider": {"min": 0.1}}}, "slider.min"),
        ({"chain": {"base": "slider"}, "inputs": {"base_motion": True}}, "inputs.base_motion"),
        ({"chain": {"base": "slider"}, "initial": {"velocity": [1.0, 0.0]}}, "initial.slider_velocity"),
        ({"chain": {"slider": {"mass": 1.0}}}, "chain.slider"),
        (
            {
                "chain": {"base": "slider"},
                "walls": [{"name": "slider_max", "point": [0, -5], "angle": 0}],
            },
            "slider_max",
        ),
        ({"inputs": {"slider_force": True}}, "inputs.slider_force"),
        (
            {
                "chain": {
                    "base": "slider",
                    "slider": {"mass": 0.0},
                    "links": [{"length": 1.0, "mass": 1.0, "inertia": 0.0}],
                }
            },
            "inertia",
        ),
    ],
)
def test_impossible_bodies_are_refused_by_their_key(tables, key):
    with pytest.raises(SceneError, match=key.replace(".", r"\.")):
        scene(changed(ROD, **tables))

"""Links that are boxes: length and height move their corners and, with the mass, change their inertia."""

import tomllib
from functools import partial

import numpy as np
import pytest
import tomlkit

from chain_impact import fit, simulate, sweep
from chain_impact.scene.scene import SceneError, load_scene, parse_scene, scene_from_dict, scene_to_dict
from chain_impact.studies.fit.scene_file import text_with_values
from tests.helpers.tools.differences import slope

BRICK = """
name = "Brick"
[[chain.links]]
length = 0.3
mass = 2.0
shape = "box"
height = 0.1
points = [{ x = 0.15, y = 0.06, radius = 0.01, name = "knob" }]
[box]
y_min = 0.0
[contact]
stiffness = 1e6
points = []
[initial]
position = [0.0, 0.4]
angles = [0.4]
angular_velocities = [3.0]
"""
CHANGES = {"link[1].length": 0.4, "link[1].height": 0.15, "link[1].mass": 1.5, "contact.radius": 0.005}


def brick(**values):
    return parse_scene(BRICK, "brick.toml").with_values(values)


def edited(**keys):
    data = tomllib.loads(BRICK)
    data["chain"]["links"][0] |= keys
    return scene_from_dict(data, "brick.toml")


def test_a_changed_box_is_that_of_an_edited_file():
    for name in ("length", "height", "mass"):
        value = CHANGES[f"link[1].{name}"]
        assert brick(**{f"link[1].{name}": value}) == edited(**{name: value})
    link = brick(**CHANGES).chain.links[0]
    corners = [(site.x, site.y, site.radius) for site in link.points]
    box = [(0.0, -0.075, 0.005), (0.4, -0.075, 0.005), (0.0, 0.075, 0.005), (0.4, 0.075, 0.005)]
    assert corners == [*box, (0.15, 0.06, 0.01)]
    assert link.inertia == pytest.approx(1.5 * (0.4**2 + 0.15**2) / 12, rel=1e-15)
    assert brick(**{"link[1].inertia": 0.5, "link[1].length": 0.4}).chain.links[0].inertia == 0.5


def test_a_written_box_is_a_box_unless_all_that_is_derived_is_given():
    plain = scene_to_dict(brick())
    assert plain["chain"]["links"][0]["points"] == [{"x": 0.15, "y": 0.06, "radius": 0.01, "name": "knob"}]
    assert scene_from_dict(plain, "again") == brick()
    link_with_all_values = scene_from_dict(scene_to_dict(brick(), derived=True), "brick").chain.links[0]
    assert link_with_all_values.shape is link_with_all_values.height is None
    assert [site.x for site in link_with_all_values.points] == [
        site.x for site in brick().chain.links[0].points
    ]


def test_a_corner_is_no_parameter():
    names = brick().values
    assert {"link[1].height", "link[1].point[5].x"} <= names.keys()
    assert "link[1].point[1].x" not in names
    for change in ("link[1].point[2].x", ("chain", "links", 0, "points", 1, "x")):
        with pytest.raises(SceneError, match=r"link\[1\]"):
            brick(**{change: 0.1}) if isinstance(change, str) else brick().with_values({change: 0.1})
    assert brick(**{"link[1].point[5].x": 0.1}).chain.links[0].points[4].x == 0.1


def test_an_index_below_0_counts_from_the_end():
    link, points = ("chain", "links", -1), ("chain", "links", -1, "points")
    assert brick().with_values({(*points, -1, "x"): 0.1}) == brick(**{"link[1].point[5].x": 0.1})
    assert brick().with_values({(*link, "mass"): 3.0}) == brick(**{"link[1].mass": 3.0})
    for index in (-2, -5):
        with pytest.raises(SceneError, match=rf"link\[1\]\.point\[{6 + index}\] is a corner of a box"):
            brick().with_values({(*points, index): {"x": 0.1}})
    for path in ((*points, -6, "x"), ("chain", "links", -2, "points", 0, "x")):
        with pytest.raises(SceneError, match="is not a path to a value of the scene"):
            brick().with_values({path: 0.1})


def test_a_sweep_moves_the_corners_as_a_changed_scene_does():
    heights = [0.1, 0.15]
    rows = sweep(brick(), {"link[1].height": heights}, outputs=["link[1].angle", "point[5].y"])
    for k, height in enumerate(heights):
        run = simulate(brick(**{"link[1].height": height}))
        assert rows["link[1].angle"][k] == run["link[1].angle"][-1]
        assert rows["point[5].y"][k] == run["point[5].y"][-1]


def test_derivatives_move_the_corners_too():
    run = simulate(brick(), 0.5, sensitivities=["link[1].length", "link[1].height", "link[1].mass"])
    assert len(run.impacts) == 1

    def end(name, value):
        return simulate(brick(**{name: value}), 0.5, tolerance=1e-12)["link[1].angle"][-1]

    for name in ("link[1].length", "link[1].height", "link[1].mass"):
        by_runs = slope(partial(end, name), brick().values[name], 1e-6)
        assert run.sensitivity("link[1].angle", name)[-1] == pytest.approx(by_runs, rel=1e-4, abs=1e-5)


def test_a_fitted_box_stays_a_box_in_its_file():
    text = text_with_values(BRICK, brick(**CHANGES), "brick.toml")
    link = tomlkit.parse(text)["chain"]["links"][0]
    assert (link["shape"], link["height"], link["length"], len(link["points"])) == ("box", 0.15, 0.4, 1)
    assert parse_scene(text, "again") == brick(**CHANGES)


def test_a_height_is_fitted():
    measured = simulate(brick(**{"link[1].height": 0.12}), 0.35, output_step=0.01)
    data = {"time": measured.time[1:], "point[3].y": measured["point[3].y"][1:]}
    result = fit(brick(), data, ["link[1].height"])
    assert result.values["link[1].height"] == pytest.approx(0.12, rel=1e-6)


def test_a_centre_of_mass_may_lie_behind_its_joint():
    """The centre of mass may also be at −1 m: no number stands for a value that is not given."""
    scene = load_scene("simple_pendulum")
    scene_ahead, scene_behind = (
        scene.with_values({"link[1].center_of_mass": c, "initial.angles": [angle]})
        for c, angle in ((1.0, 0.3), (-1.0, 0.3 + np.pi))
    )
    runs = [simulate(scene_of_side, 2.0) for scene_of_side in (scene_ahead, scene_behind)]
    np.testing.assert_allclose(runs[1].angles, runs[0].angles + np.pi, rtol=0.0, atol=1e-9)

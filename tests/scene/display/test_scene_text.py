"""The repr of a scene."""

from chain_impact import Scene, load_scene, model_names
from tests.helpers.scenes.friction import pendulum, sled
from tests.helpers.scenes.stops import knee_scene
from tests.helpers.tools.reprs import is_short


def test_the_repr_of_a_scene_is_some_short_lines():
    for scene in map(load_scene, model_names()):
        assert is_short(repr(scene))
        assert repr(scene).startswith(f"Scene {scene.name}: ")
        assert f"{scene.simulation.stop_time:g} s in steps of {scene.simulation.step_size:g} s" in repr(scene)
        assert scene.contact.model in repr(scene)


def test_a_long_chain_has_a_short_repr():
    scene = Scene.with_values(
        load_scene("rod_drop"),
        {
            ("chain", "links"): [{"length": 0.1, "mass": 1.0, "count": 40}],
            ("initial", "angles"): [0.01 * i for i in range(40)],
            ("initial", "angular_velocities"): None,
            ("contact", "points"): None,
        },
    )
    assert is_short(repr(scene))
    assert "40 links, 4 m, 40 kg" in repr(scene)
    assert "angles 0, 0.01, 0.02, 0.03, …, 0.39 rad" in repr(scene)


def test_stops_and_materials_are_in_the_repr():
    text = repr(knee_scene(**{"link[1].joint_max": 3.0, "wall.x_max.stiffness": 1e6}))
    assert "at x_max e = 0.25, K = 1e+06" in text
    line = next(line for line in text.splitlines() if line.startswith("  stops"))
    assert line.split(maxsplit=1)[1] == (
        "zhang_sharf, e = 0.5, K = 10000 N·m/rad^1.5; joint 1 ≤ 3 rad, joint 2 0 to 2 rad"
    )


def test_dry_friction_is_in_the_repr():
    text = repr(sled(**{"contact.static_friction": 0.6, "wall.slope.friction": 0.2}))
    assert "K = 1e+06 N/m^1.5, µ = 0.5, static µ = 0.6; points 0, 1" in text
    assert "at slope µ = 0.2" in text
    assert "base pinned; dry friction in joints 1, 2" in repr(pendulum())

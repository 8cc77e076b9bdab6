"""Scenes written to files that keep as much as possible of their source file."""

import shutil

import pytest

from chain_impact import SceneError, load_scene, model_names, with_law
from chain_impact.scene.scene import parse_scene, scene_file_path
from chain_impact.studies.fit.scene_file import text_with_values, write_scene

TEXT = """# first line
name = "Ball"
[chain]
base = "free"  # it falls

[[chain.links]]
mass = 0.5      # kg, weighed
length = 0.1
count = 1

[box]
y_min = 0
[contact]
restitution = 0.5       # a guess
points = [0]
[initial]
position = [0.0, 1.0]   # m
angles = [0.0]
"""


@pytest.mark.parametrize("name", model_names())
def test_unchanged_values_stay_as_they_are_written(name):
    path = scene_file_path(name)
    text = path.read_text(encoding="utf-8")
    assert text_with_values(text, load_scene(name), str(path)) == text


@pytest.mark.parametrize("name", model_names())
def test_the_text_holds_the_scene(name):
    path, scene = scene_file_path(name), load_scene(name)
    changed_scene = scene.with_values(
        {
            "link[1].mass": 1.2345,
            "gravity.y": -9.7,
            "contact.restitution": 0.321,
            "link[1].joint_damping": 0.1,
        }
    )
    text = text_with_values(path.read_text(encoding="utf-8"), changed_scene, str(path))
    assert parse_scene(text, str(path)) == changed_scene
    assert text.startswith(path.read_text(encoding="utf-8").splitlines()[0])


def test_only_values_change_and_comments_keep_their_column():
    scene = parse_scene(TEXT, "ball.toml")
    text = text_with_values(
        TEXT, scene.with_values({"contact.restitution": 0.625, "initial.y": 1.5}), "ball.toml"
    )
    assert text == TEXT.replace("0.5       # a guess", "0.625     # a guess").replace(
        "[0.0, 1.0]", "[0.0, 1.5]"
    )


def test_derived_values_are_not_written():
    """The inertia of a fitted scene follows from the new mass; the file does not give it."""
    source_text = TEXT.replace("count = 1\n", "")
    scene = parse_scene(source_text, "ball.toml").with_values({"link[1].mass": 0.625})
    text = text_with_values(source_text, scene, "ball.toml")
    assert text == source_text.replace("mass = 0.5      # kg", "mass = 0.625    # kg")
    assert parse_scene(text, "ball.toml") == scene


def test_a_given_value_that_is_derived_again_is_removed():
    text = TEXT.replace("count = 1\n", "inertia = 0.2\n")
    scene = parse_scene(text, "ball.toml").with_values({"link[1].inertia": None})
    assert text_with_values(text, scene, "ball.toml") == TEXT.replace("count = 1\n", "")


def test_equal_links_that_differ_are_written_one_by_one():
    three = TEXT.replace("count = 1", "count = 3").replace("angles = [0.0]", "angles = [0.0, 0.0, 0.0]")
    scene = parse_scene(three, "chain.toml")
    text = text_with_values(three, scene.with_values({"link[2].mass": 0.75}), "chain.toml")
    assert [link.mass for link in parse_scene(text, "chain.toml").chain.links] == [0.5, 0.75, 0.5]
    assert "# it falls" in text


def test_a_table_that_is_missing_is_added():
    scene = parse_scene(TEXT, "ball.toml").with_values({"solver.tolerance": 1e-10})
    assert parse_scene(text_with_values(TEXT, scene, "ball.toml"), "ball.toml") == scene


def test_a_file_without_another_that_it_is_like(tmp_path):
    scene = parse_scene(TEXT, "ball.toml")
    write_scene(scene, tmp_path / "new.toml")
    assert load_scene(tmp_path / "new.toml") == scene


def test_a_law_of_ones_own_is_found_from_another_folder(tmp_path):
    law = "def spring(penetration, rate, stiffness, exponent):\n"
    law += '    """A spring."""\n    return stiffness * penetration**exponent\n'
    (tmp_path / "spring.py").write_text(law)
    (tmp_path / "deep").mkdir()
    scene_text = TEXT.replace("[contact]", '[contact]\nlaw_file = "spring.py"\nmodel = "spring"')
    (tmp_path / "ball.toml").write_text(scene_text)
    scene = load_scene(tmp_path / "ball.toml").with_values({"contact.stiffness": 2e7})
    write_scene(scene, tmp_path / "deep" / "fitted.toml", tmp_path / "ball.toml")
    assert load_scene(tmp_path / "deep" / "fitted.toml").contact.stiffness == 2e7
    assert 'law_file = "../spring.py"' in (tmp_path / "deep" / "fitted.toml").read_text(encoding="utf-8")


def springy(penetration, stiffness):
    """Return a spring."""
    return stiffness * penetration


@pytest.mark.parametrize("source_name", [None, "ball.toml"])
def test_a_law_that_only_the_cache_has_is_written_beside_the_scene(tmp_path, monkeypatch, source_name):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    (tmp_path / "ball.toml").write_text(TEXT)
    scene, file = with_law(load_scene(tmp_path / "ball.toml"), springy), tmp_path / "fitted.toml"
    write_scene(scene, file, source_name and tmp_path / source_name)
    shutil.rmtree(tmp_path / "cache")
    loaded = load_scene(file)
    assert loaded.contact.law_file == str(tmp_path / "springy.py")
    assert loaded == scene.with_values({"contact.law_file": str(tmp_path / "springy.py")})
    assert 'law_file = "springy.py"' in file.read_text(encoding="utf-8")


def test_the_file_of_another_law_is_not_replaced(tmp_path, monkeypatch):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path / "cache"))
    scene, law_file = with_law(parse_scene(TEXT, "ball.toml"), springy), tmp_path / "springy.py"
    write_scene(scene, tmp_path / "one.toml")
    write_scene(scene, tmp_path / "two.toml")  # the file of the same law may exist already
    law_file.write_text("mine")
    with pytest.raises(SceneError, match=r"springy\.py is another file than that of the contact law springy"):
        write_scene(scene, tmp_path / "three.toml")
    assert law_file.read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "three.toml").exists()


STOPPED = """
name = "Finger"
chain.base = "pinned"
initial.angles = [0.0, 0.5]
[[chain.links]]
length = 0.1
mass = 0.2
[[chain.links]]
length = 0.1
mass = 0.2
joint_max = "90 deg"  # as far as it bends
[box]
x_max = 1.0
y_max = 1.0
[contact.wall.x_max]
restitution = 0.25  # rubber
[stops]
stiffness = 500.0  # N·m/rad^1.5
"""


def test_stops_and_materials_are_written_where_they_are_or_added():
    scene = parse_scene(STOPPED, "finger.toml")
    changes = {"wall.x_max.restitution": 0.5, "wall.y_max.stiffness": 1e6, "stop.restitution": 0.375}
    changed_scene = scene.with_values({**changes, "link[1].joint_min": -1.0})
    text = text_with_values(STOPPED, changed_scene, "finger.toml")
    assert parse_scene(text, "again") == changed_scene
    assert "# rubber" in text
    assert "restitution = 0.5 " in text
    assert 'joint_max = "90 deg"  # as far as it bends' in text
    assert "stiffness = 500.0  # N·m/rad^1.5" in text

"""The function explore(): its files, and the name of the scene on the page."""

import pytest

from chain_impact import BuildError, SceneError, explore, load_scene
from chain_impact.compilation import prebuilt
from tests.helpers.tools.page_data import data_of

LAW = "def mine(penetration, stiffness):\n    return stiffness * penetration\n"
SCENE = """name = "Mine"
[[chain.links]]
length = 0.6
mass = 0.5
[box]
y_min = 0.0
[contact]
law_file = "mine.py"
model = "mine"
stiffness = 2e4
exponent = 1.0
[initial]
position = [0.0, 0.5]
angles = [0.4]
"""


@pytest.mark.parametrize(
    ("scene", "command"),
    [("rod_drop", "rod_drop"), (load_scene("ramp"), "ramp"),
     (load_scene("ramp").with_values({"gravity.y": -1.0}), "scene.toml")],
)  # fmt: skip
def test_the_page_knows_what_the_command_line_calls_its_scene(tmp_path, scene, command):
    explore(scene, tmp_path / "a.html")
    assert data_of((tmp_path / "a.html").read_text(encoding="utf-8"))["command"] == [command]


def test_a_scene_that_cannot_be_read_leaves_no_file(tmp_path):
    with pytest.raises(SceneError):
        explore("no_such_scene", tmp_path / "a.html")
    assert list(tmp_path.iterdir()) == []


def test_a_law_of_the_users_own_needs_the_compilers_and_says_so(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(LAW)
    (tmp_path / "mine.toml").write_text(SCENE)
    monkeypatch.setattr(prebuilt, "find_spec", lambda _: None)
    with pytest.raises(BuildError, match=r"mine\.py: a contact law of your own needs a compiler: "):
        explore(tmp_path / "mine.toml", tmp_path / "a.html")


def test_without_a_path_the_page_is_for_a_notebook(tmp_path):
    explore("rod_drop", tmp_path / "page.html")
    assert explore("rod_drop").html == (tmp_path / "page.html").read_text(encoding="utf-8")

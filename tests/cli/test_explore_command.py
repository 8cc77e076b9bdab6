"""`chain-impact explore`: the page, its command, and refused arguments."""

# Tests: cli/explore.py

import re
import sys
import webbrowser

import pytest

from chain_impact import console
from chain_impact.compilation.library import browser_module
from tests.helpers.tools.page_data import data_of


def test_a_scene_becomes_a_page(run, here):
    browser_module()
    code, said, errors = run("explore", "rod_drop")
    assert (code, errors) == (0, "")
    assert re.fullmatch(r"page       explore\.html, 0\.\d+ MB\n", said)
    assert data_of((here / "explore.html").read_text(encoding="utf-8"))["file"]["name"] == "RodDrop"


@pytest.mark.parametrize(
    ("case", "opened"),
    [(([], True, ":0"), 1), ((["-o", "a.html"], True, ":0"), 0), (([], False, ":0"), 0), (([], True, ""), 0)],
)
def test_the_page_is_opened_on_a_screen(run, here, monkeypatch, case, opened):
    (arguments, terminal, screen), found = case, []
    monkeypatch.setattr(webbrowser, "open", found.append)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal, raising=False)
    monkeypatch.setattr(console, "SYSTEM", "Linux")
    monkeypatch.setenv("DISPLAY", screen)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert run("explore", "rod_drop", *arguments)[0] == 0
    assert found == opened * [(here / "explore.html").as_uri()]


def test_settings_are_in_the_page_and_in_its_command(run, here):
    run("explore", "rod_drop", "-o", "a.html", "--set", "contact.restitution=0.4", "--stop-time", "0.5")
    data = data_of((here / "a.html").read_text(encoding="utf-8"))
    file = data["file"]
    assert (file["contact"]["restitution"], file["simulation"]["stop_time"]) == (0.4, 0.5)
    changes = ["--set", "contact.restitution=0.4", "--set", "simulation.stop_time=0.5"]
    assert data["command"] == ["rod_drop", *changes]


def test_a_table_of_inputs_is_in_the_page_and_in_its_command(run, here):
    (here / "push.csv").write_text("time,joint[2].torque\n0.0,0.5\n0.4,0.0\n")
    given = ["--inputs", "push.csv", "--interpolation", "linear"]
    assert run("explore", "pinned_arm", "-o", "a.html", *given)[0] == 0
    text = (here / "a.html").read_text(encoding="utf-8")
    data = data_of(text)
    assert data["command"] == ["pinned_arm", *given]
    assert data["file"]["signals"]["inputs"] == {
        "input": ["joint[2].torque"],
        "form": "table",
        "file": "push.csv",
        "interpolation": "linear",
    }
    assert str(here) not in text
    code, _, errors = run("explore", "rod_drop", "--inputs", "push.csv", "-o", "b.html")
    assert code != 0
    assert "joint[2].torque" in errors
    assert not (here / "b.html").exists()

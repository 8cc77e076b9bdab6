"""`chain-impact explore`: the page, its command, and refused arguments."""

# Tests: cli/explore.py

import re
import sys
import webbrowser

import pytest

from chain_impact import console
from chain_impact.compilation.library import browser_module
from tests.helpers.tools.page_data import data_of


def test_a_scene_becomes_a_page(run, work_folder):
    browser_module()
    code, output, errors = run("explore", "rod_drop")
    assert (code, errors) == (0, "")
    assert re.fullmatch(r"page       explore\.html, 0\.\d+ MB\n", output)
    assert data_of((work_folder / "explore.html").read_text(encoding="utf-8"))["file"]["name"] == "RodDrop"


@pytest.mark.parametrize(
    ("case", "page_count"),
    [(([], True, ":0"), 1), ((["-o", "a.html"], True, ":0"), 0), (([], False, ":0"), 0), (([], True, ""), 0)],
)
def test_the_page_is_opened_on_a_screen(run, work_folder, monkeypatch, case, page_count):
    (arguments, terminal, screen), addresses = case, []
    monkeypatch.setattr(webbrowser, "open", addresses.append)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal, raising=False)
    monkeypatch.setattr(console, "SYSTEM", "Linux")
    monkeypatch.setenv("DISPLAY", screen)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert run("explore", "rod_drop", *arguments)[0] == 0
    assert addresses == page_count * [(work_folder / "explore.html").as_uri()]


def test_settings_are_in_the_page_and_in_its_command(run, work_folder):
    run("explore", "rod_drop", "-o", "a.html", "--set", "contact.restitution=0.4", "--stop-time", "0.5")
    data = data_of((work_folder / "a.html").read_text(encoding="utf-8"))
    file = data["file"]
    assert (file["contact"]["restitution"], file["simulation"]["stop_time"]) == (0.4, 0.5)
    changes = ["--set", "contact.restitution=0.4", "--set", "simulation.stop_time=0.5"]
    assert data["command"] == ["rod_drop", *changes]


def test_a_table_of_inputs_is_in_the_page_and_in_its_command(run, work_folder):
    (work_folder / "push.csv").write_text("time,joint[2].torque\n0.0,0.5\n0.4,0.0\n")
    options = ["--inputs", "push.csv", "--interpolation", "linear"]
    assert run("explore", "pinned_arm", "-o", "a.html", *options)[0] == 0
    text = (work_folder / "a.html").read_text(encoding="utf-8")
    data = data_of(text)
    assert data["command"] == ["pinned_arm", *options]
    assert data["file"]["signals"]["inputs"] == {
        "input": ["joint[2].torque"],
        "form": "table",
        "file": "push.csv",
        "interpolation": "linear",
    }
    assert str(work_folder) not in text
    code, _, errors = run("explore", "rod_drop", "--inputs", "push.csv", "-o", "b.html")
    assert code != 0
    assert "joint[2].torque" in errors
    assert not (work_folder / "b.html").exists()

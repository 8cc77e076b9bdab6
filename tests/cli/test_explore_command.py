"""`chain-impact explore`: the page, its command, and what it refuses."""

import json
import re

import pytest


def data_of(path):
    return json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', path.read_text(), re.DOTALL)[1])


def test_a_scene_becomes_a_page(run, here):
    code, said, errors = run("explore", "rod_drop")
    assert (code, errors) == (0, "")
    assert re.fullmatch(r"page       explore\.html, 0\.\d+ MB\n", said)
    assert data_of(here / "explore.html")["name"] == "RodDrop"


def test_settings_are_in_the_page_and_in_its_command(run, here):
    run("explore", "rod_drop", "-o", "a.html", "--set", "contact.restitution=0.4", "--stop-time", "0.5")
    data = data_of(here / "a.html")
    starts = {one["name"]: one["start"] for one in data["parameters"]}
    assert (starts["contact.restitution"], starts["simulation.stop_time"]) == (0.4, 0.5)
    assert data["command"] == [
        "rod_drop",
        "--set",
        "contact.restitution=0.4",
        "--set",
        "simulation.stop_time=0.5",
    ]


@pytest.mark.parametrize(
    ("arguments", "pattern"),
    [
        (["explore", "nothing"], "nothing: cannot be read"),
        (["explore", "-o", "a.txt"], "a.txt must end in .html"),
        (["explore", "-o", "missing/a.html"], "missing/a.html: No such folder"),
        (["explore", "--set", "contact.restitution=2"], "contact.restitution = 2 must be"),
    ],
)
def test_what_cannot_be_is_refused(run, arguments, pattern):
    code, said, errors = run(*arguments)
    assert (code, said) == (2, "")
    assert re.search(pattern, errors)

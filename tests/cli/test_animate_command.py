"""`chain-impact animate`: scenes, FMUs, tables, and refused arguments."""

# Tests: cli/animate.py

import re

import pytest
from PIL import Image

from tests.helpers.tools.page_data import data_of


def test_a_scene_becomes_a_page_that_is_named_after_it(run, work_folder):
    code, output, errors = run("animate", "rod_drop")
    assert (code, errors) == (0, "")
    assert re.fullmatch(r"animation  RodDrop\.html, 0\.\d+ MB\n", output)
    assert data_of((work_folder / "RodDrop.html").read_text(encoding="utf-8"))["impacts"]


def test_settings_and_speed_reach_the_page(run, work_folder):
    run("animate", "rod_drop", "-o", "a.html", "--set", "simulation.stop_time=0.1", "--speed", "0.25")
    data = data_of((work_folder / "a.html").read_text(encoding="utf-8"))
    assert (data["speed"], data["impacts"]) == (0.25, [])


def test_an_fmu_becomes_a_page(run, work_folder, fmu):
    assert run("animate", fmu, "-o", "fmu.html", "--set", "simulation.stop_time=0.8")[0] == 0
    data = data_of((work_folder / "fmu.html").read_text(encoding="utf-8"))
    assert [contact["point"] for contact in data["impacts"]] == [2, 4, 0]
    assert set(data["walls"]) == {"x_min", "x_max", "y_min", "y_max"}


@pytest.mark.full("takes long")
def test_a_table_becomes_a_film_with_the_walls_of_its_scene(run, work_folder):
    run("simulate", "rod_drop", "--csv", "rod.csv")
    code, _, errors = run("animate", "rod.csv", "--scene", "rod_drop", "-o", "rod.gif", "--size", "320x180",
                          "--impact-time", "0")  # fmt: skip
    assert (code, errors) == (0, "")
    with Image.open(work_folder / "rod.gif") as film:
        assert film.size == (320, 180)
        assert film.n_frames == pytest.approx(41, abs=1)


def test_walls_of_a_table_can_be_set_as_those_of_its_scene(run, work_folder):
    run("simulate", "rod_drop", "--csv", "rod.csv", "--set", "box.y_min=-1")
    run("animate", "rod.csv", "--scene", "rod_drop", "-o", "rod.html", "--set", "box.y_min=-1")
    assert data_of((work_folder / "rod.html").read_text(encoding="utf-8"))["walls"]["y_min"]["offset"] == -1.0


def test_a_run_that_fails_is_shown_up_to_its_fault(run, work_folder):
    code, output, errors = run("animate", "-o", "a.html", "--set", "solver.work_limit=1500")
    assert code == 3
    assert "stopped at t = " in errors
    assert "a.html" in output
    assert (work_folder / "a.html").is_file()


def test_a_table_of_another_chain_is_refused(run, work_folder):
    run("simulate", "rod_drop", "--csv", "rod.csv")
    code, _, errors = run("animate", "rod.csv", "--scene", "falling_arm", "-o", "rod.html")
    assert code == 2
    assert errors == "chain-impact: rod.csv has 1 link, and --scene falling_arm has 2\n"
    assert not (work_folder / "rod.html").exists()


def test_a_film_has_a_style_and_a_page_has_none(run, work_folder):
    short_run = ("rod_drop", "--set", "simulation.stop_time=0.1", "--size", "320x180", "--impact-time", "0")
    assert run("animate", *short_run, "-o", "dark.gif", "--style", "dark_background")[0] == 0
    with Image.open(work_folder / "dark.gif") as film:
        assert film.convert("RGB").getpixel((1, 1)) == (0, 0, 0)
    code, _, errors = run("animate", *short_run, "-o", "dark.html", "--style", "dark_background")
    assert code == 2
    assert "--style" in errors
    assert not (work_folder / "dark.html").exists()

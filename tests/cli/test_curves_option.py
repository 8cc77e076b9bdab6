"""`chain-impact simulate --curves`."""

# Tests: cli/simulate.py, pictures/curves.py

import re

import pytest


def test_curves_are_drawn_into_a_file(run, work_folder):
    command = ("simulate", "pinned_arm", "--stop-time", "0.6", "--curves", "contact[*].x_max.force")
    code, output, errors = run(*command, "--curves", "point[2].x,energy.total", "--plot", "curves.svg")
    assert (code, errors) == (0, "")
    assert "picture  curves.svg" in output
    assert "the largest peak looks like a line; --around 1 shows impact 1" in output
    picture = (work_folder / "curves.svg").read_text(encoding="utf-8")
    for name in ("contact[2].x_max", "force [kN]", "point[2]", "position x [m]", "energy.total"):
        assert name in picture
    for size in ("84", "84x120"):
        assert run(*command, "--around", "1", "--plot", "near.svg", "--size", size)[0] == 0
        picture = (work_folder / "near.svg").read_text(encoding="utf-8")
        assert "time after the onset at" in picture
        width = re.search(r'width="([\d.]+)pt"', picture)[1]
        assert float(width) == pytest.approx(72.0 * 84.0 / 25.4)
    for options, text in (
        (
            ("--curves", "energy.*,*.x", "--plot", "a.svg", "--size", "84x60"),
            "no room for its panels: it must be at least",
        ),
        (("--csv", "a.csv", "--size", "84"), "--size: it is the size of a picture: give --plot FILE too"),
        (("--plot", "a.svg", "--size", "6in"), "6in must be a width in millimetres, or WIDTHxHEIGHT"),
        (
            ("--curves", "joint[1].torque", "--plot", "a.svg"),
            "it is an input; a signal in the scene, inputs={…} in Python or --inputs FILE",
        ),
        (("--around", "2", "--plot", "a.svg"), "--around 2 must be 1: the run has 1 impact"),
        ((), "give --plot FILE or --show too"),
        (("--plot", "a.svg", "--rank", "peak_force"), "curves or derivatives"),
        (("--plot", "a.svg", "--curves", "*"), "must be <= "),
    ):
        code, _, errors = run(*command, *options)
        assert code == 2
        assert text in errors
    assert not (work_folder / "a.svg").exists()

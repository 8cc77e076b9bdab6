"""The command `chain-impact fit`."""

# Tests: cli/fit.py

import csv

import pytest

from chain_impact import load_scene
from tests.helpers.tools.measurements import impacts, motion

FREE_OPTIONS = ("--free", "contact.stiffness,contact.restitution")
START = ("--set", "contact.stiffness=5e7", "--set", "contact.restitution=0.6")


@pytest.fixture
def data(work_folder):
    """Write motion.csv and impacts.csv; return their folder."""
    columns, result = motion(0.6)
    table = impacts(result, ["onset", "peak_force"], noise=1e-3)
    for name, table_columns in (("motion.csv", columns), ("impacts.csv", table)):
        with (work_folder / name).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(table_columns)
            writer.writerows(zip(*table_columns.values(), strict=True))
    return work_folder


def test_a_stop_time(run, data):
    code, output, _ = run("fit", "four_link_box", "motion.csv", *START, *FREE_OPTIONS, "--stop-time", "0.3")
    assert code == 0
    assert output.splitlines()[0].endswith("200 values, 2 free parameters")
    assert "200 of 400 values lie after the stop time, 0.3 s: they were not used." in output


def test_a_fit_prints_its_values(run, data):
    code, output, _ = run(
        "fit", "four_link_box", "motion.csv,impacts.csv", *START, *FREE_OPTIONS, "--sigma", "peak_force=0.1%",
        "--bounds", "contact.restitution=0.5:0.9", "--plot", "fit.svg", "-o", "fitted.toml",
    )  # fmt: skip
    assert code == 0
    lines = output.splitlines()
    assert [*lines[:2], lines[-1]] == [
        "scene    fitted.toml",
        "FourLinkBox  zhang_sharf, 404 values, 2 free parameters",
        "picture  fit.svg",
    ]
    assert (data / "fit.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")
    fitted = load_scene(data / "fitted.toml").values
    assert fitted["contact.stiffness"] == pytest.approx(1e8, rel=0.02)
    assert fitted["contact.restitution"] == pytest.approx(0.7, abs=0.01)
    assert "# N/m^exponent" in (data / "fitted.toml").read_text(encoding="utf-8")
    assert run("simulate", "fitted.toml", "--stop-time", "0.1", "-q")[0] == 0


def test_data_sets_with_their_own_values(run, data):
    code, output, _ = run(
        "fit", "four_link_box", "motion.csv", "motion.csv", "--free", "contact.restitution",
        "--free-each", "initial.vx", "--set-each", "initial.y=1.4,1.4", "--columns", "point[4].*",
    )  # fmt: skip
    assert code == 0
    assert "2 data sets, 800 values, 3 free parameters" in output
    assert "initial.vx of data set 2" in output


def test_laws_are_compared_by_a_fit(run, data):
    code, output, _ = run("fit", "four_link_box", "motion.csv", "--free", "contact.restitution", "--laws")
    assert code == 0
    assert "ΔAIC" in output

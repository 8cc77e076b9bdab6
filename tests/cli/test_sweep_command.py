"""The command `chain-impact sweep`."""

# Tests: cli/sweep.py

import csv

from tests.tiers import needs_interop

SHORT = ("--set", "simulation.stop_time=0.6", "--set", "solver.tolerance=1e-6")


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_grid_is_swept_into_a_file(run, work_folder):
    code, output, _ = run(
        "sweep", *SHORT, "--vary", "contact.restitution=0:0.8:3", "--vary", "contact.model=flores,hertz",
        "--output", "point[4].x", "-o", "out.csv",
    )  # fmt: skip
    assert code == 0
    assert output == "table    out.csv\nFourLinkBox  6 runs: 5 ok, 1 restitution_not_allowed\n"
    table_rows = rows(work_folder / "out.csv")
    assert [(row["contact.restitution"], row["contact.model"]) for row in table_rows] == [
        (e, law) for e in ("0.0", "0.4", "0.8") for law in ("flores", "hertz")
    ]
    assert {row["time"] for row in table_rows[1:]} == {"0.6"}
    assert float(table_rows[1]["point[4].x"]) > 0.0


@needs_interop
def test_a_picture_and_parquet(run, work_folder):
    arguments = ("--vary", "contact.restitution=0.2:0.8:3", "-o", "out.parquet", "--plot", "out.svg")
    code, output, _ = run("sweep", *SHORT, *arguments)
    assert code == 0
    lines = output.splitlines()
    assert [lines[0], lines[-1]] == ["table    out.parquet", "picture  out.svg"]
    assert (work_folder / "out.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")
    assert (work_folder / "out.parquet").read_bytes()[:4] == b"PAR1"


def test_samples_are_swept_into_a_file(run, work_folder):
    arguments = ("sweep", *SHORT, "--vary", "contact.stiffness=1e6:1e9:log", "--samples", "8")
    seeds = {"a": (), "b": ("--seed", "0"), "c": ("--seed", "1"), "d": ("--sampling", "sobol")}
    for name, options in seeds.items():
        code, output, _ = run(*arguments, *options, "-o", f"{name}.csv")
        assert code == 0
        assert output.endswith("FourLinkBox  8 runs: 8 ok\n")
    a, b, c, d = ((work_folder / f"{name}.csv").read_bytes() for name in "abcd")
    assert a == b
    assert len({a, c, d}) == 3

"""The command `chain-impact sweep`."""

# Tests: cli/sweep.py

import csv

from tests.tiers import needs_interop

SHORT = ("--set", "simulation.stop_time=0.6", "--set", "solver.tolerance=1e-6")


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_grid_is_swept_into_a_file(run, here):
    code, said, _ = run(
        "sweep", *SHORT, "--vary", "contact.restitution=0:0.8:3", "--vary", "contact.model=flores,hertz",
        "--output", "point[4].x", "-o", "out.csv",
    )  # fmt: skip
    assert code == 0
    assert said == "table    out.csv\nFourLinkBox  6 runs: 5 ok, 1 restitution_not_allowed\n"
    found = rows(here / "out.csv")
    assert [(row["contact.restitution"], row["contact.model"]) for row in found] == [
        (e, law) for e in ("0.0", "0.4", "0.8") for law in ("flores", "hertz")
    ]
    assert {row["time"] for row in found[1:]} == {"0.6"}
    assert float(found[1]["point[4].x"]) > 0.0


@needs_interop
def test_a_picture_and_parquet(run, here):
    arguments = ("--vary", "contact.restitution=0.2:0.8:3", "-o", "out.parquet", "--plot", "out.svg")
    code, said, _ = run("sweep", *SHORT, *arguments)
    assert code == 0
    lines = said.splitlines()
    assert [lines[0], lines[-1]] == ["table    out.parquet", "picture  out.svg"]
    assert (here / "out.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")
    assert (here / "out.parquet").read_bytes()[:4] == b"PAR1"


def test_samples_are_swept_into_a_file(run, here):
    arguments = ("sweep", *SHORT, "--vary", "contact.stiffness=1e6:1e9:log", "--samples", "8")
    seeds = {"a": (), "b": ("--seed", "0"), "c": ("--seed", "1"), "d": ("--sampling", "sobol")}
    for name, more in seeds.items():
        code, said, _ = run(*arguments, *more, "-o", f"{name}.csv")
        assert code == 0
        assert said.endswith("FourLinkBox  8 runs: 8 ok\n")
    a, b, c, d = ((here / f"{name}.csv").read_bytes() for name in "abcd")
    assert a == b
    assert len({a, c, d}) == 3

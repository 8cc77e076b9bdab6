"""Work against precision of all peers: ``python benchmarks/work_precision.py [--quick] [problem …]``.

Each contender at tolerances from 1e-2 to 1e-12 on the problems of problems.py, judged by the references of
reference.py. Peers that are not installed are named and left out. ``--quick``: two rounds. With problems
named, the others keep the rows that are stored.
"""

from __future__ import annotations

import common  # isort: skip

import argparse

import peers
from equal_error import at_equal_error, usable
from peers.ours import Kernel
from problems import PROBLEMS, Problem
from race import FAST, ROUNDS, judge, race
from work_precision_chart import SIZE, draw

TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
PATIENCE = 5.0  # s


def measure(
    problem: Problem, tolerance: float, stop: float, expected: dict, rounds: int
) -> tuple[list, dict]:
    """All contenders at one tolerance up to one time; and who is missing."""
    contenders, missing = peers.contenders(problem, tolerance, stop)
    case = {"problem": problem.name, "stop": stop, "tolerance": tolerance}
    return race(case, contenders, lambda one: judge(one.outcome(), expected, stop), rounds, PATIENCE), missing


def levelled(rows: list[dict]) -> list[dict]:
    """The rows with times as if all of them had been timed at once."""
    keys = ("problem", "stop", "tolerance")
    cases = dict.fromkeys(tuple(row[key] for key in keys) for row in rows)
    ours = {case: Kernel(PROBLEMS[case[0]].scene(case[2]), case[1]).run for case in cases}
    return common.levelled(rows, keys, ours)


def compared(rows: list[dict]) -> list[dict]:
    """For each of our runs the peers' times at equal error, as multiples of ours, and the best of them."""
    names = list(dict.fromkeys(r["name"] for r in rows if not r["name"].startswith("ours")))
    found = []
    for mine in (r for r in rows if r["name"] == "ours" and "seconds" in r and r["onsets_right"]):
        problem, stop = mine["problem"], mine["stop"]
        ratios = {name: at_equal_error(mine, usable(rows, problem, stop, name)) for name in names}
        ratios = {name: value for name, value in ratios.items() if value is not None}
        found.append(
            {
                "problem": problem,
                "stop": stop,
                "tolerance": mine["tolerance"],
                "error": mine["error"],
                "best scipy": best(ratios, ("scipy",)),
                "best compiled": best(ratios, peers.COMPILED),
                "all": ratios,
            }
        )
    return found


def best(ratios: dict[str, float], families: tuple[str, ...]) -> dict | None:
    """The fastest peer of some families."""
    those = {name: value for name, value in ratios.items() if name.split()[0] in families}
    name = min(those, key=those.__getitem__, default=None)
    return {"name": name, "times ours": those[name]} if name else None


def main() -> None:
    """Measure and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problems", nargs="*", help="of problems.py")
    parser.add_argument("--quick", action="store_true", help="two rounds")
    chosen = parser.parse_args()
    names = chosen.problems or list(PROBLEMS)
    started = common.environment(peers.PACKAGES)
    references = common.load("reference")["results"]
    rows: list[dict] = []
    if chosen.problems and (common.RESULTS / "work_precision.json").exists():
        rows = [r for r in common.load("work_precision")["results"]["rows"] if r["problem"] not in names]
    missing: dict[str, str] = {}
    rounds = 2 if chosen.quick else ROUNDS
    for name in names:
        for stop in PROBLEMS[name].times:
            for tolerance in TOLERANCES:
                found, absent = measure(PROBLEMS[name], tolerance, stop, references[name], rounds)
                rows += found
                missing |= absent
    for family, reason in missing.items():
        print(f"left out: {family}: {reason}")
    settings = {
        "tolerances": TOLERANCES, "rounds": rounds, "rounds of fast ones": rounds * FAST, "left out": missing,
        "tolerance of peers": "rtol = atol; see peers/ for everything else",
    }  # fmt: skip
    rows = levelled(rows)
    results = {"rows": rows, "at equal error": compared(rows)}
    for row in results["at equal error"]:
        print({key: value for key, value in row.items() if key != "all"})
    common.save("work_precision", started, settings, results)
    common.picture("work_precision", draw, SIZE)


if __name__ == "__main__":
    main()

"""Cost against the stiffness of the contact: ``python benchmarks/stiffness.py [--quick]``.

four_link_box up to 0.6 s, with its two or three impacts, for K from 1e5 to 1e12 at one tolerance. Errors are
against the solver of reference.py, run for each K. Sustained contact, where stiffness matters more: rest.py.
"""

from __future__ import annotations

import common  # isort: skip

import math

import peers
import reference
from looks import LOOKS, curve, headline, label, look, names_at_ends, number
from problems import Problem
from race import ROUNDS, judge, race

STIFFNESSES = tuple(10.0**k for k in range(5, 13))
STOP, TOLERANCE = 0.6, 1e-6
FAMILIES = ("ours", "scipy", "numbalsoda", "cvode", "heyoka")
LEFT_OUT = ("ours, simulate()",)


def expected(problem: Problem) -> dict:
    """State and onsets by the independent solver."""
    states, impacts = reference.run(problem, *reference.SETTINGS["check"])
    return {"times": [STOP], "states": [states[0].astype(float)], "impacts": impacts}


def measure(stiffness: float, rounds: int) -> tuple[list[dict], dict]:
    """All contenders at one stiffness; and who is missing."""
    changes = {("contact", "stiffness"): stiffness}
    problem = Problem(f"K = {stiffness:.0e}", "", "four_link_box", (STOP,), changes)
    truth = expected(problem)
    contenders, missing = peers.contenders(problem, TOLERANCE, STOP, FAMILIES)
    chosen = {name: contender for name, contender in contenders.items() if name not in LEFT_OUT}
    case = {"stiffness": stiffness}
    return race(case, chosen, lambda one: judge(one.outcome(), truth, STOP), rounds), missing


SIZE = (10.5, 4.4)  # inches, of the chart


def draw(page, record) -> None:
    """Time and error over stiffness."""
    panels, rows, ends = page.subplots(1, 2), record["results"], {}
    time, error = panels
    ends[time] = []
    for name in LOOKS:
        mine = [row for row in rows if row["name"] == name and "seconds" in row]
        if mine:
            points = [(row["stiffness"], 1e3 * row["seconds"]) for row in mine]
            ends[time].append(curve(time, points, look(name), label(name)))
            right = [row["error"] if row["onsets_right"] else math.nan for row in mine]
            error.loglog([row["stiffness"] for row in mine], right, **look(name))
    for axes, text in zip(panels, ("CPU time [ms]", "error of the final state"), strict=True):
        axes.set(xlabel="contact stiffness K [N/m$^{1.5}$]", ylabel=text)
        axes.set_xticks([row["stiffness"] for row in rows if row["name"] == "ours"])
        axes.minorticks_off()
    ours = [(row["stiffness"], row["seconds"]) for row in rows if row["name"] == "ours"]
    most = max(seconds for _, seconds in ours) / min(seconds for _, seconds in ours)
    settings = record["settings"]
    headline(
        page,
        f"From K = {number(ours[0][0])} to {number(ours[-1][0])} the cost of impacts varies {most:.2g}-fold",
        f"four_link_box, {settings['stop [s]']:g} s  ·  tolerance {number(settings['tolerance'])}",
    )
    names_at_ends(page, ends)


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    started, rows, missing = common.environment(peers.PACKAGES), [], {}
    for stiffness in STIFFNESSES:
        found, absent = measure(stiffness, rounds)
        rows += found
        missing |= absent
    for family, reason in missing.items():
        print(f"left out: {family}: {reason}")
    settings = {"stop [s]": STOP, "tolerance": TOLERANCE, "rounds": rounds, "left out": missing}
    common.save("stiffness", started, settings, rows)
    common.picture("stiffness", draw, SIZE)


if __name__ == "__main__":
    main()

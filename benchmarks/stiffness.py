"""Cost against the stiffness of the contact: ``python benchmarks/stiffness.py [--quick]``.

four_link_box up to 0.6 s, with its two or three impacts, for K from 1e5 to 1e12 at one tolerance. Errors are
against the solver of reference.py, run for each K. Sustained contact, where stiffness matters more: rest.py.
"""

from __future__ import annotations

import common  # isort: skip

import argparse
import math

import peers
import reference
from problems import Problem
from work_precision import judge

STIFFNESSES = tuple(10.0**k for k in range(5, 13))
STOP, TOLERANCE = 0.6, 1e-6
FAMILIES = ("ours", "scipy", "numbalsoda", "cvode", "heyoka", "casadi")
LEFT_OUT = ("ours, simulate()", "scipy BDF")
ROUNDS, SPAN, PATIENCE = 5, 0.02, 1.0


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
    rows, able = {}, {}
    for name, contender in contenders.items():
        if name in LEFT_OUT:
            continue
        rows[name] = judge(contender.outcome(), truth, STOP)
        if "failed" not in rows[name]:
            able[name] = contender.run
    timings = common.interleave(able, rounds, SPAN, PATIENCE)
    for name, values in timings.items():
        rows[name] |= {"seconds": common.median(values), "times_ours": common.ratio(timings, name, "ours")}
    table = [{"stiffness": stiffness, "name": name, **row} for name, row in rows.items()]
    for row in table:
        print({key: value for key, value in row.items() if key != "times_ours"}, flush=True)
    return table, missing


def draw(page, record) -> None:
    """Time and error over stiffness."""
    from work_precision_chart import LOOKS, look

    time, error = page.subplots(1, 2)
    rows = record["results"]
    for name in LOOKS:
        mine = [row for row in rows if row["name"] == name and "seconds" in row]
        if mine:
            x = [row["stiffness"] for row in mine]
            time.loglog(x, [1e3 * row["seconds"] for row in mine], label=name, **look(name))
            right = [row["error"] if row["onsets_right"] else math.nan for row in mine]
            error.loglog(x, right, **look(name))
    for axes, label in ((time, "CPU time [ms]"), (error, "error of the final state")):
        axes.set(xlabel="contact stiffness K [N/m$^{1.5}$]", ylabel=label)
        axes.set_xticks([row["stiffness"] for row in rows if row["name"] == "ours"])
        axes.minorticks_off()
    handles, labels = time.get_legend_handles_labels()
    page.legend(handles, labels, loc="outside right center", fontsize=9)


def main() -> None:
    """Measure and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two rounds")
    rounds = 2 if parser.parse_args().quick else ROUNDS
    started, rows, missing = common.environment(peers.PACKAGES), [], {}
    for stiffness in STIFFNESSES:
        found, absent = measure(stiffness, rounds)
        rows += found
        missing |= absent
    for family, reason in missing.items():
        print(f"left out: {family}: {reason}")
    settings = {"stop [s]": STOP, "tolerance": TOLERANCE, "rounds": rounds, "left out": missing}
    common.save("stiffness", started, settings, rows)
    common.picture("stiffness", draw, (11.5, 4.4))


if __name__ == "__main__":
    main()

"""A chain comes to rest, against CVODE from C: ``python -m benchmarks rest``; needs libsundials-dev and gcc.

The default chain falls into its box and comes to rest, in 10 s at the tolerance 1e-6. CVODE integrates the
kernel's own equations, compiled in the same way, with the kernel's events (peers/cvode.py).
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

import numpy as np

from benchmarks import common
from benchmarks.kernel_model import MARGIN, POSITION_ERROR
from benchmarks.looks import OUR_COLOUR, WIDTH, name_curves, strong
from benchmarks.peers import MissingError
from benchmarks.peers.cvode import BUDGET, COUNTS, Cvode, driver
from benchmarks.peers.ours import OnInstance
from chain_impact.pictures.drawing.colours import BLUE, INK
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.scene.scene import Scene, load_scene, with_values
from chain_impact.simulation.instance import Instance
from chain_impact.text import number_text
from tests.helpers.kernel.kernel_calls import advance

STIFFNESSES = (1e6, 1e8, 1e10, 1e12)
RESTITUTIONS = (0.05, 0.1, 0.3, 0.7)
TOLERANCE, FINE = 1e-6, 1e-9
STOP = 10  # [s] end of a run
ROUNDS = 5
USERS, CAREFUL, ADAMS = "BDF as users have it", "BDF, careful", "Adams, careful"
CVODES = {USERS: (0, 0), CAREFUL: (0, 1), ADAMS: (1, 1)}  # name → the arguments adams, careful of Cvode
FINE_ONSETS = f"onsets at tolerance {FINE:g}"
# restitution and stiffness [N/m^1.5] of the case in which our kernel also runs without implicit steps
EXPLICIT_CASE = (0.1, 1e10)


class Ours(OnInstance):
    """Our kernel; ``rows`` has the counts after each second."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene, float(STOP))
        self.rows = np.zeros(STOP, COUNTS)

    def run(self) -> None:
        """Run once, and stop at each second to look at the counts, which takes almost no time."""
        self.block[:] = self.fresh
        record = self.instance.record
        for second in range(STOP):
            assert self.kernel.advance_to(self.address, second + 1.0) == 0
            counts, row = record["statistics"], self.rows[second]
            row["steps"], row["rejected"] = counts["steps"], counts["rejected_steps"]
            row["rhs"], row["restarts"] = counts["rhs_evaluations"], record["impact"]["count"]


def energy(run: OnInstance) -> float:
    """Return the present energy plus the dissipated energy [J]."""
    run.kernel.observe_now(run.address)
    output = run.instance.record["output"]
    return float(output["total"] + output["dissipated"])


def outcome(run: Any) -> dict[str, Any]:
    """Return the results of a run, at the end and at rest."""
    run.block[:] = run.fresh
    start = energy(run)
    run.run()
    drift, record, last = energy(run) - start, run.instance.record, run.rows[-1]
    output, chain = record["output"], record["chain"]
    floor = record["candidate"]["wall"] == 2
    weight = float(chain["mass"].sum() * -chain["gravity"][1])
    return {
        **{name: int(last[name]) for name in ("steps", "rejected", "rhs", "jacobians", "flag")},
        "onsets": int(record["impact"]["count"]),
        "floor / weight": round(float(output["force"][floor].sum()) / weight, 5),
        "energy drift": common.rounded(drift, 2),
        "rhs a second at rest": at_rest(run.rows),
    }


def at_rest(rows: np.ndarray) -> float | None:
    """Return the mean number of evaluations in a second at rest; None if there is none or the run failed.

    A second counts as at rest if neither this second nor the one before has an event.
    """
    rhs = np.diff(rows["rhs"])
    events = np.diff(rows["restarts"])
    quiet = [s for s in range(1, len(rhs)) if events[s] == 0 and events[s - 1] == 0]
    return round(float(rhs[quiet].mean()), 1) if quiet and rows[-1]["flag"] == 0 else None


def compare(scene: Scene) -> dict[str, Any]:
    """Return results, times and their ratios of our kernel and of CVODE on one scene."""
    fine = Instance(with_values(scene, {("solver", "tolerance"): FINE}))
    assert advance(fine, float(STOP)) == 0
    seconds = np.arange(1.0, STOP + 1.0)
    runs: dict[str, Ours | Cvode] = {"ours": Ours(scene)}
    runs |= {name: Cvode(scene, seconds, *arguments) for name, arguments in CVODES.items()}
    row: dict[str, Any] = {
        "restitution": scene.contact.restitution,
        "stiffness": scene.contact.stiffness,
        FINE_ONSETS: int(fine.record["impact"]["count"]),
        **{name: outcome(run) for name, run in runs.items()},
    }
    timings = common.interleave({name: run.run for name, run in runs.items()}, ROUNDS)
    for name in runs:
        row[name]["milliseconds"] = common.median([1e3 * value for value in timings[name]])
        if name != "ours":
            row[name]["time / ours"] = common.ratio(timings, name, "ours")
            row[name]["steps / ours"] = round(row[name]["steps"] / row["ours"]["steps"], 2)
    if (scene.contact.restitution, scene.contact.stiffness) == EXPLICIT_CASE:
        row["ours explicit"] = outcome(Ours(with_values(scene, {("solver", "method"): "explicit"})))
    return row


SIZE = (WIDTH, 5.2)  # [inch] of the chart


def draw(figure: Any, record: dict[str, Any]) -> None:
    """Draw the time above and the steps below; one column for each restitution."""
    looks = {
        "ours": (OUR_COLOUR, "o", "-"),
        CAREFUL: (BLUE, "^", "-"),
        USERS: (BLUE, "s", ":"),
        ADAMS: (INK, "v", "--"),
    }
    panels = figure.subplots(2, len(RESTITUTIONS), sharex=True, sharey="row")
    for column, restitution in zip(panels.T, RESTITUTIONS, strict=True):
        rows = [row for row in record["results"] if row["restitution"] == restitution]
        stiffness = [row["stiffness"] for row in rows]
        for axes, key in zip(column, ("milliseconds", "steps"), strict=True):
            for name, (colour, marker, line) in looks.items():
                # a failed run has no mark in the chart
                values = [row[name][key] if row[name]["flag"] == 0 else np.nan for row in rows]
                text = "chain-impact" if name == "ours" else name
                axes.loglog(stiffness, values, label=text, **strong(name == "ours", colour, marker, line))
        column[0].set_title(f"e = {restitution:g}")
        column[1].set_xlabel("stiffness K [N/m$^{1.5}$]")
        column[1].set_xticks(STIFFNESSES)
        for axes in column:
            axes.minorticks_off()
    panels[0, 0].set_ylabel("CPU time for 10 s [ms]")
    panels[1, 0].set_ylabel("accepted steps")
    settings = record["settings"]
    ratios = {
        name: number_range(
            row[name]["time / ours"]["median"] for row in record["results"] if not row[name]["flag"]
        )
        for name in (CAREFUL, USERS, ADAMS)
    }
    write_headline(
        figure,
        f"chain-impact is {ratios[CAREFUL]} times as fast as CVODE BDF for a chain that comes to rest",
        f"four_link_box for {settings['stop time']:g} s, tolerance {number_text(settings['tolerance'])}  ·  "
        f"CVODE: {CAREFUL} (title), {USERS} ({ratios[USERS]} times), {ADAMS} ({ratios[ADAMS]} times)  ·  "
        f"careful: {100.0 * POSITION_ERROR:g} % of the static penetration is the allowed error of positions, "
        f"and a contact ends {100.0 * MARGIN:g} % of it above the wall",
    )
    name_curves(figure, panels.ravel())


def number_range(values: Iterable[float]) -> str:
    """Return the least and the largest of some numbers as words, with two digits."""
    numbers = list(values)
    return " to ".join(f"{common.rounded(end(numbers), 2):g}" for end in (min, max))


def main() -> None:
    """Measure and draw."""
    base = with_values(load_scene("four_link_box"), {("solver", "tolerance"): TOLERANCE})
    try:
        driver(len(base.chain.links))
    except MissingError as error:
        sys.exit(f"rest.py: {error}")
    started = common.environment()
    results = []
    for restitution in RESTITUTIONS:
        for stiffness in STIFFNESSES:
            changes = {("contact", "stiffness"): stiffness, ("contact", "restitution"): restitution}
            results.append(compare(with_values(base, changes)))
            print(results[-1], flush=True)
    settings: dict[str, Any] = {"stop time": STOP, "tolerance": TOLERANCE, "rounds": ROUNDS, "budget": BUDGET}
    settings |= {"careful": {"position error": POSITION_ERROR, "margin": MARGIN}}
    common.save("rest", started, settings, results)
    common.picture("rest", draw, SIZE)


if __name__ == "__main__":
    main()

"""Cost against the number of links: ``python benchmarks/scaling.py [--quick] [--most N]``.

Flight: a folded, turning chain for 1 s. Heap: a chain of short links falls on a floor, with every
point of it, and comes to rest; 1 s.
"""

from __future__ import annotations

import common  # isort: skip

import argparse
import time
from dataclasses import dataclass, replace

import numpy as np
import peers
from looks import LOOKS, curve, headline, label, look, names_at_ends, number
from peers import Contender, Outcome, cvode
from peers.ours import Kernel, OnInstance
from problems import Problem, flight
from race import ROUNDS, race
from scipy.integrate import solve_ivp

from chain_impact.scene.scene import Scene, scene_from_dict
from tests.textbook import Textbook

SIZES = (1, 4, 10, 30, 100, 300, 1000)
BASE = 10  # links: from here on the cost for each of them should be one
STOP, TOLERANCE = 1.0, 1e-6
# heyoka's expressions grow with N², NumPy's work with N³
LIMITS = {"numbalsoda": 1000, "cvode": 1000, "scipy": 1000, "NumPy": 300, "heyoka": 10}
HEAP_LIMIT = 100  # links, of CVODE: its dense Jacobian costs N² evaluations
SHOWN = ("numbalsoda DOP853", "CVODE Adams", "scipy DOP853", "heyoka")


@dataclass(frozen=True)
class Made(Problem):
    """A problem whose scene is made for a number of links."""

    links: int = 0

    def scene(self, tolerance: float | None = None) -> Scene:
        """The scene, with a tolerance."""
        made = flight(self.links) if self.model == "flight" else heap(self.links)
        return replace(made, solver=replace(made.solver, tolerance=tolerance or TOLERANCE))


def heap(links: int) -> Scene:
    """A chain with links of 0.1 m, folded, above a floor."""
    return scene_from_dict(
        {
            "name": "Heap",
            "gravity": [0.0, -9.81],
            "chain": {"base": "free", "links": [{"length": 0.1, "mass": 0.1}] * links},
            "box": {"y_min": 0.0},
            "contact": {"stiffness": 1e6, "restitution": 0.3},
            "initial": {"position": [0.0, 0.3], "angles": list(1.2 * np.sin(1.0 + 2.4 * np.arange(links)))},
        },
        "heap",
    )


class NumPy:
    """What people write: the assembled matrix in NumPy, and solve_ivp."""

    def __init__(self, problem: Problem) -> None:
        self.book, self.start = Textbook(problem.scene()), problem.start()

    def run(self) -> Outcome:
        """Once."""
        sol = solve_ivp(
            lambda _t, y: self.book.rate(y), (0.0, STOP), self.start, "DOP853", rtol=TOLERANCE, atol=TOLERANCE
        )
        return Outcome(sol.y[:, -1], [], len(sol.t) - 1, sol.nfev)

    outcome = run


def in_flight(links: int) -> Made:
    """The problem without contacts."""
    return Made(f"flight of {links}", "", "flight", (STOP,), {}, links)


def flying(links: int) -> dict[str, Contender]:
    """Who takes part in flight."""
    problem = in_flight(links)
    families = [name for name, most in LIMITS.items() if name != "NumPy" and links <= most]
    found, missing = peers.contenders(problem, TOLERANCE, STOP, families)
    for family, reason in missing.items():
        print(f"left out: {family}: {reason}")
    able: dict[str, Contender] = {"ours": Kernel(problem.scene(), STOP)}
    able |= {name: found[name] for name in SHOWN if name in found}
    if links <= LIMITS["NumPy"]:
        able["NumPy, scipy DOP853"] = NumPy(problem)
    return able


def resting(links: int) -> dict[str, Contender]:
    """Who takes part in the heap."""
    problem = Made(f"heap of {links}", "", "heap", (STOP,), {}, links)
    able: dict[str, Contender] = {"ours": Kernel(problem.scene(), STOP)}
    if links <= HEAP_LIMIT:
        try:
            able |= cvode.contenders(problem, TOLERANCE, STOP, careful=1)
        except peers.MissingError as reason:
            print(f"left out: CVODE: {reason}")
    return able


def measure(links: int, able: dict[str, Contender], rounds: int) -> list[dict]:
    """Time them; the difference is to ours, which the heap amplifies beyond any use."""
    mine = None

    def judged(contender: Contender) -> dict:
        nonlocal mine
        found, onsets = contender.outcome(), None
        mine = found.state if mine is None else mine  # ours is the first
        if isinstance(contender, OnInstance):  # its log may be shorter
            onsets = int(contender.instance.record["impact"]["count"])
        return {
            "steps": found.steps,
            "rhs": found.rhs,
            "onsets": len(found.onsets) if onsets is None else onsets,
            "difference": common.rounded(np.abs(found.state - mine).max(), 2),
            **({"failed": found.failed} if found.failed else {}),
        }

    return race({"links": links}, able, judged, rounds)


def levelled(rows: list[dict]) -> list[dict]:
    """The rows of the flight with times as if all numbers of links had been timed at once."""
    sizes = dict.fromkeys(row["links"] for row in rows)
    ours = {(links,): Kernel(in_flight(links).scene(), STOP).run for links in sizes}
    return common.levelled(rows, ("links",), ours)


def flatness(rows: list[dict]) -> dict[int, float]:
    """Our time in flight for each right-hand side and link, over that at BASE links: links → ratio."""
    mine = [row for row in rows if row["name"] == "ours" and "seconds" in row]
    each = {row["links"]: row["seconds"] / (row["rhs"] * row["links"]) for row in mine}
    return {links: value / each[BASE] for links, value in each.items()} if BASE in each else {}


SIZE = (10.5, 4.4)  # inches, of the chart


def draw(page, record) -> None:
    """Time over N, in flight and in the heap."""
    panels, ends = page.subplots(1, 2), {}
    for axes, key in zip(panels, ("flight", "heap"), strict=True):
        ends[axes] = []
        for name in LOOKS:
            rows = [r for r in record["results"][key] if r["name"] == name and "seconds" in r]
            points = [(r["links"], 1e3 * r["seconds"]) for r in rows]
            if points:
                ends[axes].append(curve(axes, points, look(name), label(name)))
        axes.set(title=f"{key}, 1 s", xlabel="links N")
    panels[0].set_ylabel("CPU time [ms]")
    flat = flatness(record["results"]["flight"])
    headline(
        page,
        f"In flight the cost of a link stays the same up to {max(flat)} links",
        f"time for each right-hand side and link: {flat[max(flat)]:.2g} of that at {BASE} links  ·  "
        f"tolerance {number(record['settings']['tolerance'])}",
    )
    names_at_ends(page, ends)


def main() -> None:
    """Measure and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two rounds")
    parser.add_argument("--most", type=int, default=SIZES[-1], help=f"most links, {BASE} or more")
    chosen = parser.parse_args()
    rounds = 2 if chosen.quick else ROUNDS
    started, results = common.environment(peers.PACKAGES), {"flight": [], "heap": []}
    for links in (size for size in SIZES if size <= chosen.most):
        for key, entrants in (("flight", flying), ("heap", resting)):
            begin = time.time()
            able = entrants(links)
            print(f"{key}, {links} links: ready after {time.time() - begin:.0f} s", flush=True)
            results[key] += measure(links, able, rounds)
    results["flight"] = levelled(results["flight"])
    for links, ratio in flatness(results["flight"]).items():
        print(f"flight, {links} links: {ratio:.3g} of the time for each right-hand side and link at {BASE}")
    settings = {
        "stop [s]": STOP, "tolerance": TOLERANCE, "rounds": rounds, "limits": LIMITS,
        "limit of CVODE in the heap": HEAP_LIMIT,
    }  # fmt: skip
    common.save("scaling", started, settings, results)
    common.picture("scaling", draw, SIZE)


if __name__ == "__main__":
    main()

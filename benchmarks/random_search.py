"""The random search of tests/random_scenes.py, longer: ``python benchmarks/random_search.py --count 20000``.

Special kinds of scenes begin at whole millions (``--first``), which tests/random_scenes.py lists. Every scene
runs in a process apart, is ended after ``--cpu`` seconds of CPU time and judged by tests/oracle.py. What is
found is listed by kind, law and method, with the seeds, in benchmarks/results/random_search.json.
``--shrink SEED`` makes the scene of a seed as small and plain as its finding allows, and prints it.
"""

from __future__ import annotations

import common  # isort: skip

import argparse
import math
import os
import pprint
import statistics
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Any

from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.scene import Scene, SceneError, scene_from_dict, scene_to_dict
from tests.oracle import CPU
from tests.random_scenes import scene as scene_of
from tests.search import Verdict, verdict, verdicts

SEEDS_SHOWN = 3
ENDED = "ended by the timer"
PLAIN: dict[str, dict[str, Any]] = {
    "contact": {"radius": 0.0, "minimum_impact_speed": 1e-3, "restitution": 0.5, "exponent": 1.5},
    "inputs": {"joint_torques": False, "tip_force": False},
    "chain": {"base": "free"},
    "solver": {"method": "auto", "tolerance": 1e-6, "work_limit": 1e7},
}
PLAIN_LAWS = ("hertz", "zhang_sharf", "newton_impact")


def main() -> None:
    """Search, print a table and save it; or shrink one scene."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=20000, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--cores", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--cpu", type=float, default=CPU, help="CPU time that a run may take [s]")
    parser.add_argument(
        "--shrink", type=int, metavar="SEED", help="make the scene of this seed small instead"
    )
    parser.add_argument("--kind", help="the finding that it shall keep; its first by default")
    options = parser.parse_args()
    if options.shrink is not None:
        shrink(options.shrink, options.cpu, options.kind)
        return
    started, begin = common.environment(), time.time()
    seeds = range(options.first, options.first + options.count)
    judged = list(watched(verdicts(seeds, options.cpu, options.cores), options.count))
    results = summary(judged)
    show(results, options.count, time.time() - begin)
    settings = {"first": options.first, "count": options.count, "cpu [s]": options.cpu}
    common.save("random_search", started, settings, results)


def watched(judged: Iterator[Verdict], count: int) -> Iterator[Verdict]:
    """Say now and then how far the search is."""
    found, said = 0, time.time()
    for done, one in enumerate(judged, 1):
        found += bool(one.findings)
        if time.time() - said > 10.0:
            said = time.time()
            print(f"{done} of {count} scenes, {found} with findings", file=sys.stderr)
        yield one


def summary(judged: list[Verdict]) -> dict[str, Any]:
    """Counts, seeds and numbers of all findings, and what came of the runs."""
    kinds: dict[str, list[Verdict]] = defaultdict(list)
    for one in judged:
        for kind in one.kinds:
            kinds[kind].append(one)
    findings = {
        kind: by_kind(kind, rows) for kind, rows in sorted(kinds.items(), key=lambda item: -len(item[1]))
    }
    stops = Counter(ENDED if one.status is None else STATUS_TEXT[one.status] for one in judged)
    cpu = sorted(one.cpu for one in judged)
    closeness: dict[str, tuple[float, int]] = {}
    for one in judged:
        for kind, ratio in one.closeness.items():
            if ratio <= 1.0:
                closeness[kind] = max(closeness.get(kind, (0.0, -1)), (ratio, one.seed))
    return {
        "scenes": len(judged),
        "with findings": sum(bool(one.findings) for one in judged),
        "findings": findings,
        "ends": dict(stops.most_common()),
        "cpu [s]": {
            "sum": round(sum(cpu), 3),
            "mean": common.rounded(statistics.fmean(cpu)),
            "99th of 100": common.rounded(cpu[min(len(cpu) - 1, math.ceil(0.99 * len(cpu)))]),
        },
        "closest to a bound without a finding": {
            kind: {"of the bound": common.rounded(ratio, 3), "seed": seed}
            for kind, (ratio, seed) in closeness.items()
        },
    }


def by_kind(kind: str, rows: list[Verdict]) -> dict[str, Any]:
    """The findings of one kind: how many by law and method, the seeds, and the worst."""
    table = Counter(f"{one.law}, {one.method}" for one in rows)
    own = {one.seed: next(finding for finding in one.findings if finding.kind == kind) for one in rows}
    worst = max(own, key=lambda seed: own[seed].value / own[seed].bound if own[seed].bound > 0.0 else 1.0)
    return {
        "count": len(rows),
        "by law and method": dict(table.most_common()),
        "worst": f"scene({worst}): {own[worst]}",
        "median value": statistics.median(finding.value for finding in own.values()),
        "seeds": list(own),
    }


def show(results: dict[str, Any], count: int, seconds: float) -> None:
    """Print the table."""
    print(f"{count} scenes in {seconds:.0f} s, {results['with findings']} with findings")
    print(f"ends of the runs: {results['ends']}")
    print(f"CPU time of a run [s]: {results['cpu [s]']}")
    for kind, rows in results["findings"].items():
        print(f"\n{kind}: {rows['count']}, as in seeds {rows['seeds'][:SEEDS_SHOWN]}; {rows['worst']}")
        cells = Counter[tuple[str, str]]()
        for key, number in rows["by law and method"].items():
            cells[tuple(key.split(", "))] = number  # type: ignore[index]
        methods = sorted({method for _, method in cells})
        print(f"  {'':22}" + "".join(f"{method:>10}" for method in methods))
        for law in sorted({law for law, _ in cells}, key=lambda law: -sum(cells[law, m] for m in methods)):
            print(f"  {law:22}" + "".join(f"{cells[law, method] or '':>10}" for method in methods))


# --- a smaller scene ---------------------------------------------------------------------------------------


def shrink(seed: int, cpu: float, kind: str | None) -> None:
    """Print the smallest scene that has a finding of a seed."""
    scene = scene_of(seed)
    start = verdict(scene, seed, cpu)
    print(start)
    if not start.findings:
        return
    kind = kind or start.findings[0].kind
    last, table, progress = start, scene_to_dict(scene), True
    while progress:
        progress = False
        for smaller in simpler(table):
            made = read(smaller)
            if made is None:
                continue
            one = verdict(made, seed, cpu)
            if kind in one.kinds:
                last, table, progress = one, smaller, True
                break
    pprint.pp(scene_to_dict(scene_from_dict(table, "shrunk")), width=110, compact=True)
    print(last)


def read(table: dict[str, Any]) -> Scene | None:
    """The scene of a table, or None if it is not valid."""
    try:
        return scene_from_dict(table, "shrunk")
    except SceneError:
        return None


def simpler(table: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Tables of scenes that are simpler than this one, the boldest changes first."""
    for change in (_fewer, _shorter, _plainer, _slower, _rods, _less_gravity):
        yield from change(table)


def _fewer(table: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Links, walls, points."""
    count, points = len(table["chain"]["links"]), table["contact"]["points"]
    if count > 1:
        yield _with_links(table, range(count - 1))  # without the tip
        yield _with_links(table, range(1, count))
    for wall in table["box"] if len(table["box"]) > 1 else ():
        yield {**table, "box": {name: at for name, at in table["box"].items() if name != wall}}
    for i in range(len(table["walls"])):
        yield {**table, "walls": [wall for k, wall in enumerate(table["walls"]) if k != i]}
    for point in points if len(points) > 1 else ():
        yield _changed(table, "contact", points=[one for one in points if one != point])


def _shorter(table: dict[str, Any]) -> Iterator[dict[str, Any]]:
    stop = table["simulation"]["stop_time"]
    if stop > 1e-6:
        yield _changed(table, "simulation", stop_time=0.5 * stop, step_size=0.01 * stop)


def _plainer(table: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for part, values in PLAIN.items():
        for key, value in values.items():
            if table[part][key] != value:
                yield _changed(table, part, **{key: value})
    if table["contact"]["model"] not in PLAIN_LAWS:
        for law in PLAIN_LAWS[:2]:
            yield _changed(table, "contact", model=law)


def _slower(table: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for key in ("velocity", "angular_velocities", "angles"):
        values = table["initial"][key]
        for i, value in enumerate(values):
            for simple in (0.0, common.rounded(value, 1)):
                if value not in (0.0, simple):
                    yield _changed(table, "initial", **{key: [*values[:i], simple, *values[i + 1 :]]})


def _rods(table: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for i, link in enumerate(table["chain"]["links"]):
        joint = ("joint_damping", "joint_stiffness", "joint_rest_angle")
        rod = {key: link[key] for key in ("length", "mass", *joint)}
        if set(link) - set(rod):
            yield _with_link(table, i, rod)
        for key, simple in (("mass", 1.0), ("length", 1.0), *((key, 0.0) for key in joint)):
            if link[key] != simple:
                yield _with_link(table, i, {**rod, key: simple})


def _less_gravity(table: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for pull in ([0.0, 0.0], [0.0, -9.81]):
        if table["gravity"] not in (pull, [0.0, 0.0]):
            yield {**table, "gravity": pull}


def _changed(table: dict[str, Any], part: str, **values: Any) -> dict[str, Any]:
    return {**table, part: {**table[part], **values}}


def _with_link(table: dict[str, Any], index: int, link: dict[str, float]) -> dict[str, Any]:
    links = list(table["chain"]["links"])
    links[index] = link
    return _changed(table, "chain", links=links)


def _with_links(table: dict[str, Any], kept: range) -> dict[str, Any]:
    """Without the first or the last link; the points keep their places."""
    initial, links = dict(table["initial"]), table["chain"]["links"]
    for i in range(kept.start):
        angle, length = initial["angles"][i], links[i]["length"]
        x, y = initial["position"]
        initial["position"] = [x + length * math.cos(angle), y + length * math.sin(angle)]
    for key in ("angles", "angular_velocities"):
        initial[key] = [initial[key][i] for i in kept]
    points = [point - kept.start for point in table["contact"]["points"] if kept.start <= point <= kept.stop]
    if table["chain"]["base"] == "pinned":
        points = [point for point in points if point > 0]
    made = _changed(table, "chain", links=[links[i] for i in kept])
    return _changed({**made, "initial": initial}, "contact", points=points)


if __name__ == "__main__":
    main()

"""The random search of the tests, with many seeds: ``python benchmarks/random_search.py --count 20000``.

Special kinds of scenes begin at whole millions (``--first``), which tests/random_scenes.py lists. Every scene
runs in a process of its own, which ends after some CPU time, and is judged by tests/oracle.py. ``--folds``:
chains that are folded until two points almost coincide, held against Newton's law by tests/folds.py.
What is found is printed by kind, with its seeds.
"""

from __future__ import annotations

import common  # isort: skip  # noqa: F401 - adds the tests to Python's path

import argparse
import os
from collections import Counter, defaultdict
from collections.abc import Iterator

from chain_impact.kernel.status import STATUS_TEXT
from tests.folds import faults
from tests.oracle import CPU
from tests.random_scenes import fold
from tests.search import verdicts

ENDED = "ended by the timer"


def found_in_scenes(seeds: range, cpu: float, cores: int) -> Iterator[tuple[str, int, str]]:
    """Kind, seed and text of each finding; then how the runs ended."""
    ends: Counter[str] = Counter()
    for one in verdicts(seeds, cpu, cores):
        ends[ENDED if one.status is None else STATUS_TEXT[one.status]] += 1
        for finding in one.findings:
            yield finding.kind, one.seed, f"{one.law}, {one.method}: {finding}"
    for text, count in ends.most_common():
        print(f"{count} runs: {text}")


def found_in_folds(seeds: range) -> Iterator[tuple[str, int, str]]:
    """Kind, seed and size of each fault."""
    for seed in seeds:
        for kind, value in faults(fold(seed)).items():
            yield kind, seed, f"{value:.3g} times what is allowed"


def main() -> None:
    """Search, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--count", type=int, default=20000, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--cores", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--cpu", type=float, default=CPU, help="CPU time that a run may take [s]")
    parser.add_argument("--folds", action="store_true", help="folded chains instead")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.count)
    found: dict[str, dict[int, str]] = defaultdict(dict)
    search = found_in_folds(seeds) if options.folds else found_in_scenes(seeds, options.cpu, options.cores)
    for kind, seed, text in search:
        found[kind][seed] = text
    print(f"{options.count} scenes, {len({seed for rows in found.values() for seed in rows})} with findings")
    for kind, rows in found.items():
        print(f"\n{kind}: {len(rows)}")
        for seed, text in rows.items():
            print(f"  {seed}: {text}")


if __name__ == "__main__":
    main()

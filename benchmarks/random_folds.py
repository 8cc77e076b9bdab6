"""Chains folded so far that two points all but coincide: ``python benchmarks/random_folds.py --count 20000``.

Each of the scenes of tests/folds.py is followed from impact to impact, and every impact held against Newton's
law. What is found is listed by kind, with its seeds, in benchmarks/results/random_folds.json.
"""

from __future__ import annotations

import common  # isort: skip

import argparse
import time
from collections import defaultdict

from tests.folds import faults
from tests.random_scenes import fold


def main() -> None:
    """Search, print what was found and save it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=20000, help="scenes")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    options = parser.parse_args()
    started, begin = common.environment(), time.time()
    found: dict[str, dict[int, float]] = defaultdict(dict)
    for seed in range(options.first, options.first + options.count):
        for kind, value in faults(fold(seed)).items():
            found[kind][seed] = common.rounded(value, 3)
    print(f"{options.count} scenes in {time.time() - begin:.0f} s")
    for kind, seeds in found.items():
        print(f"{kind}: {len(seeds)}, {seeds}")
    settings = {"first": options.first, "count": options.count}
    common.save("random_folds", started, settings, {"scenes": options.count, "found": dict(found)})


if __name__ == "__main__":
    main()

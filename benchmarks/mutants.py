"""Whether the tests see faults: some are put into the kernel and the variables, one at a time, at random.

The tests run in this process, with the kernel as plain Python in the place of the compiled one
(plain_kernel.py): no fault is compiled. First each test runs once, which tells what it calls. Then, for each
fault, a copy of the process (fork) takes the faulty function and runs tests that call it until one fails:
those of files that import its module first, then of all others in turn, the fastest first. What runs when a
module is imported needs the modules anew.

    python benchmarks/mutants.py                  a sample, by --seed and --count
    python benchmarks/mutants.py --again          those that survived last, once more
"""

from __future__ import annotations

import argparse
import ast
import cProfile
import functools
import hashlib
import json
import os
import random
import re
import signal
import time
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from types import CodeType
from typing import Any

from common import ROOT, environment, load, save
from faulty import PACKAGE, PYTEST, apart, module_name, names_at_import, passes, stand_in, too_slow
from mutations import KINDS, Mutant, mutants_of

PARTS = ("kernel", "variables")
# what runs with the plain kernel in seconds, and says something about the kernel
SCENES = "simulate inputs"  # of tests/simulation
ALL = "damping faults impacts newton_impact newton_law_change newton_rest springs stops walls"  # of tests
TESTS = [
    "tests/kernel",
    "tests/variables",
    *(f"tests/simulation/test_{name}.py" for name in SCENES.split()),
    *(f"tests/test_{name}.py" for name in ALL.split()),
]
SLOWEST = 2.0  # s of CPU time, of a test that takes part


@dataclass
class Run:
    """A plugin of pytest, which runs the tests in its own way."""

    mutants: list[Mutant]
    seconds: float  # of CPU time for the tests of a mutant
    profile: Path  # what each test takes and calls
    survivors: list[dict[str, Any]] = field(default_factory=list)

    def pytest_runtestloop(self, session: Any) -> bool:
        """Run each test once, then some for each mutant."""
        stand_in()
        signal.signal(signal.SIGPROF, too_slow)
        profile = self.measure(session.items)
        items = {item.nodeid: item for item in session.items if item.nodeid in profile}
        seconds = {key: one["seconds"] for key, one in profile.items()}
        print(f"{len(items)} of {len(session.items)} tests, {sum(seconds.values()):.0f} s")
        for number, mutant in enumerate(self.mutants, 1):
            chosen = selected(mutant, profile, self.seconds)
            began, row = time.monotonic(), described(mutant)
            killer, ran = apart(mutant, items, {key: seconds[key] for key in chosen})
            if not killer:
                self.survivors.append(row | {"tests": ran})
            print(
                number, f"{time.monotonic() - began:.1f} s", *row.values(), f"[{killer or 'SURVIVED'}]", ran
            )
        return True

    def measure(self, items: list[Any]) -> dict[str, Any]:
        """What each test that passes takes and calls, as it was measured or is now."""
        known = json.loads(self.profile.read_text()) if self.profile.exists() else {}
        file = None
        for item in items:
            key, source = item.nodeid, hashlib.sha256(item.path.read_bytes()).hexdigest()
            if known.get(key, {}).get("source") != source:
                known[key] = {"source": source} | measured(item)
                if item.path != file:
                    file = item.path
                    self.profile.write_text(json.dumps(known))
                    print(f"{time.process_time():6.1f} s", file.relative_to(ROOT))
        self.profile.write_text(json.dumps(known))
        return {item.nodeid: one for item in items if (one := known[item.nodeid])["passed"]}


def described(mutant: Mutant) -> dict[str, Any]:
    """A mutant for the results."""
    file = mutant.file.relative_to(PACKAGE).as_posix()
    return {"file": file, "line": mutant.line, "in": mutant.owner, "kind": mutant.kind, "change": mutant.text}


def measured(item: Any) -> dict[str, Any]:
    """What a test takes [s], and the functions at the top of modules that it calls."""
    profiler, began = cProfile.Profile(builtins=False), time.process_time()
    profiler.enable()
    passed = passes(item, SLOWEST)
    profiler.disable()
    calls = {call for entry in profiler.getstats() if (call := owner_of(entry.code))}
    return {"passed": passed, "seconds": time.process_time() - began, "calls": sorted(calls)}


def owner_of(code: CodeType | str) -> str:
    """The function at the top of a module that a code is in; empty outside of the parts."""
    own = tuple(f"{PACKAGE}/{part}/" for part in PARTS)
    if isinstance(code, str) or not code.co_filename.startswith(own):
        return ""
    return f"{code.co_filename}:{code.co_qualname.partition('.')[0]}"


def selected(mutant: Mutant, profile: dict[str, Any], seconds: float) -> list[str]:
    """The tests for a mutant, in their order: those that call it, of files that import its module first."""
    wanted, room = users(mutant), f"tests/{mutant.file.relative_to(PACKAGE).parent}/"
    files: dict[str, list[str]] = defaultdict(list)
    for key in sorted(profile, key=lambda key: profile[key]["seconds"]):
        file = key.partition("::")[0]
        # what is used as modules are imported may be seen by any test of the room that it is in
        if wanted.intersection(profile[key]["calls"]) if wanted else file.startswith(room):
            files[file].append(key)
    near = [files.pop(file) for file in list(files) if imports(file, module_name(mutant))]
    chosen, total = [], 0.0
    for part, some in ((0.7, near), (1.0, [files[file] for file in sorted(files)])):
        for key in (key for turn in zip_longest(*some) for key in turn if key):
            if total + profile[key]["seconds"] <= part * seconds:
                total += profile[key]["seconds"]
                chosen.append(key)
    return chosen


def imports(file: str, module: str) -> bool:
    """Whether a file imports a module, or names of it."""
    package, _, name = module.rpartition(".")
    text = (ROOT / file).read_text(encoding="utf-8")
    return re.search(rf"{module}\b|from {package} import .*\b{name}\b", text) is not None


def users(mutant: Mutant) -> set[str]:
    """The functions that a fault may change: its own, or those that name what it is in; or nobody knows."""
    if mutant.owner in functions_of(mutant.file):
        own = f"{mutant.file}:{mutant.owner}"
        return set() if mutant.owner in names_at_import() else {own}
    return set()


@functools.cache
def functions_of(file: Path) -> set[str]:
    """The functions at the top of a module."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def of_each(mutants: list[dict[str, Any]], survivors: list[dict[str, Any]], key: str) -> dict[str, str]:
    """How many are killed of how many, for each value of a key."""
    every, left = (Counter(str(one[key]) for one in ones) for ones in (mutants, survivors))
    return {name: f"{count - left[name]} of {count}" for name, count in sorted(every.items())}


def main() -> None:
    """Run a sample, or the survivors of the last."""
    import pytest

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seconds", type=float, default=10.0, help="of CPU time for the tests of a mutant")
    parser.add_argument("--profile", type=Path, default=ROOT / "build" / "mutants.json")
    parser.add_argument("--name", default="mutants", help="of the results")
    parser.add_argument("--again", action="store_true", help="only what survived last")
    options = parser.parse_args()
    options.profile.parent.mkdir(exist_ok=True)
    os.chdir(ROOT)
    files = [file for part in PARTS for file in sorted((PACKAGE / part).rglob("*.py"))]
    every = [mutant for file in files for mutant in mutants_of(file)]
    old = load(options.name) if options.again else {"settings": vars(options), "results": {}}
    settings = {key: old["settings"][key] for key in ("seed", "count")}
    sample = random.Random(settings["seed"]).sample(every, settings["count"])
    before, first = old["results"].get("survivors", []), old["results"].get("survived_at_first")
    left = [name(row) for row in before]
    chosen = [one for one in sample if name(described(one)) in left] if options.again else sample
    started, run = environment(("pytest",)), Run(chosen, options.seconds, options.profile)
    pytest.main([*PYTEST, "-s", *TESTS], plugins=[run])
    reasons = {name(row): row["reason"] for row in before if "reason" in row}
    survivors = [row | {"reason": reasons.get(name(row), "")} for row in run.survivors]
    rows = [described(mutant) for mutant in sample]
    results = {
        "killed": len(rows) - len(survivors),
        "survived_at_first": len(survivors) if first is None else first,
        "of_each_kind": of_each(rows, survivors, "kind"),
        "of_each_module": of_each(rows, survivors, "file"),
        "survivors": survivors,
    }
    print(f"{results['killed']} of {len(rows)} killed")
    settings |= {"seconds": options.seconds, "all": len(every), "kinds": KINDS}
    save(options.name, started, settings, results)


def name(row: dict[str, Any]) -> tuple[str, ...]:
    """What tells a mutant from others, wherever its line is."""
    return tuple(str(row[key]) for key in ("file", "in", "kind", "change"))


if __name__ == "__main__":
    main()

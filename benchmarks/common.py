"""Shared code of the benchmarks: interleaved timing, the record of a run, charts."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeVar

from chain_impact.compilation.prebuilt import is_release_build

ROOT = Path(__file__).parents[1]
RESULTS = Path(__file__).parent / "results"
IMAGES = ROOT / "docs" / "images"
PACKAGES = ("numpy", "numba", "llvmlite", "scipy", "ziglang", "fmpy", "pythonfmu")
Name = TypeVar("Name")
"""The name of a contender: a text, or several values."""
Timings = dict[Name, list[float]]
"""CPU seconds per call of each contender, one number for each round in which it is timed (``interleave``)."""


def interleave(
    contenders: Mapping[Name, Callable[[], object]],
    rounds: int = 7,
    span: float = 0.05,
    patience: float = 3.0,
) -> Timings[Name]:
    """Return the times of several contenders, timed in turn, so that a busy moment of the machine hits all.

    Args:
        contenders: name → function of one call; each has run once before, so that nothing is compiled here.
        rounds: the number of rounds; a contender is timed once in a round.
        span: shortest time that is measured at once [s]; a fast call is repeated to fill it.
        patience: a contender whose single call takes longer than this [s] is timed in two rounds only.
    """
    repeats = {}
    for name, call in contenders.items():
        once = _seconds(call, 1)
        repeats[name] = max(1, round(span / max(once, 1e-9)))
        if repeats[name] > 1:
            once = _seconds(call, max(1, repeats[name] // 10))
            repeats[name] = max(1, round(span / once))
    timings: Timings[Name] = {name: [] for name in contenders}
    for turn in range(rounds):
        for name, call in contenders.items():
            if turn < 2 or timings[name][0] < patience:
                timings[name].append(_seconds(call, repeats[name]))
    return timings


def _seconds(call: Callable[[], object], repeats: int) -> float:
    # CPU time of this process; other processes do not count
    start = time.process_time()
    for _ in range(repeats):
        call()
    return (time.process_time() - start) / repeats


def rounds(text: str | None, default: int) -> int:
    """Return the number of rounds: ``default``, or two if the command line has ``--quick``."""
    parser = argparse.ArgumentParser(description=text)
    parser.add_argument("--quick", action="store_true", help="two rounds")
    return 2 if parser.parse_args().quick else default


def rounded(value: float, digits: int = 4) -> float:
    """Return a number with ``digits`` significant digits."""
    return float(f"{value:.{digits}g}")


def median(values: Iterable[float]) -> float:
    """Return the median, to four digits."""
    return rounded(statistics.median(values))


def spread(values: list[float]) -> dict[str, float]:
    """Return median, least and largest, to four digits."""
    return {"median": median(values), "least": rounded(min(values)), "largest": rounded(max(values))}


def ratio(timings: Timings[Name], name: Name, base: Name) -> dict[str, float]:
    """Return median, least and largest ratio of a contender's time to that of ``base`` in the same round."""
    return spread([a / b for a, b in zip(timings[name], timings[base], strict=False)])


def needed(package: str) -> None:
    """End this script unless a package of the extra ``bench`` is installed."""
    try:
        importlib.import_module(package)
    except ImportError as reason:
        sys.exit(f"{reason}; pip install -e '.[bench]'")


def environment(packages: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return machine, versions, commit and date of this run; ``packages`` are further packages.

    The process ends if it lacks the settings of a release, which ``python -m benchmarks`` makes.
    """
    if not is_release_build():
        sys.exit("run: python -m benchmarks NAME")
    further = {name: _version(name) for name in packages}
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": _git("rev-parse", "HEAD"),
        "sources_changed_since": _git("status", "--porcelain", "--", "fmu_src").splitlines(),
        "machine": {
            "processor": _processor(),
            "cores": os.cpu_count(),
            "system": platform.platform(),
            "load_at_start": [round(value, 2) for value in os.getloadavg()],
        },
        "versions": {
            "python": platform.python_version(),
            **{name: _version(name) for name in PACKAGES},
            **{name: value for name, value in further.items() if value != "absent"},
        },
    }


def save(name: str, started: dict[str, Any], settings: dict[str, Any], results: Any) -> None:
    """Write benchmarks/results/<name>.json."""
    RESULTS.mkdir(exist_ok=True)
    record = {**started, "settings": settings, "results": results}
    path = RESULTS / f"{name}.json"
    path.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"wrote {path.relative_to(ROOT)}")


def load(name: str) -> dict[str, Any]:
    """Return the record in benchmarks/results/<name>.json."""
    record: dict[str, Any] = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return record


def picture(
    name: str, draw: Callable[[Any, Any], None], size: tuple[float, float], record: str | None = None
) -> None:
    """Draw docs/images/bench_<name>.png from <record or name>.json: ``draw(figure, record)``."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from benchmarks.looks import STYLE
    from chain_impact.pictures.drawing.style import DPI

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=size, dpi=DPI, layout="constrained")
        draw(figure, load(record or name))
        path = IMAGES / f"bench_{name}.png"
        figure.savefig(path, dpi="figure")
    print(f"wrote {path.relative_to(ROOT)}")


def _git(*arguments: str) -> str:
    process = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    return process.stdout.rstrip()


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "absent"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()

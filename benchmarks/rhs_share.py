"""The share of a run that is spent in right-hand sides: ``python benchmarks/rhs_share.py``.

Evaluations that a run counts × the cost of one, over the time of the run as work_precision.py has it. What an
evaluation costs is timed apart for each set of active contacts, on the record as it is in a step of this very
run, by calls in a row in code compiled as the kernel is.
"""

from __future__ import annotations

import common  # isort: skip

import ctypes
import math
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from functions_library import built
from numba import int32, int64
from peers.ours import Kernel
from problems import PROBLEMS

from chain_impact.compilation.entry_points import Entries
from chain_impact.compilation.record_type import INSTANCE
from chain_impact.kernel.model.equations import state_rate

PLACES = (("box", 0.6), ("box", 1.2), ("flight", 2.0))
TOLERANCE = 1e-8
CALLS = 1000  # right-hand sides in a row
ROUNDS = 9
RUN = "run"


def rates(d, calls):
    """Right-hand sides in a row, from the start of a step; the last one is left in ``work.stage[1]``."""
    y, rate = d.work.y, d.work.stage[1]
    for j in range(len(y)):
        y[j] = d.step.state[j]
    for _ in range(calls):
        state_rate(d, y, rate)
        # each depends on the last one, as the stages of a step do
        for j in range(len(y)):
            y[j] += 1e-30 * rate[j]
    return 0


def entry_points() -> Entries:
    """``int32 share_rates(instance*, int64 calls)``."""
    return {"share_rates": (int32(INSTANCE, int64), rates)}


@cache
def load(links: int) -> ctypes.CDLL:
    """The library, compiled if it is not cached."""
    library = ctypes.CDLL(str(built("rhs_share", links)))
    library.share_rates.argtypes = [ctypes.c_void_p, ctypes.c_int64]
    return library


@dataclass
class State:
    """What a run spends while certain contacts are active."""

    evaluations: int = 0
    blocks: list[np.ndarray] = field(default_factory=list)  # the record in each of the steps


def follow(run: Kernel) -> dict[tuple[int, ...], State]:
    """Go through a run step by step: active candidates → what is spent with these."""
    record, spent = run.instance.record, 0
    states: dict[tuple[int, ...], State] = {}
    run.block[:] = run.fresh
    run.kernel.initialize(run.address, 0.0)
    while record["step"]["end"] < run.stop:
        assert run.kernel.advance(run.address, math.nextafter(record["step"]["end"], math.inf)) == 0
        state = states.setdefault(tuple(np.flatnonzero(record["touch"]["active"])), State())
        state.evaluations += int(record["statistics"]["rhs_evaluations"]) - spent
        state.blocks.append(run.block.copy())
        spent = int(record["statistics"]["rhs_evaluations"])
    return states


def timed(run: Kernel, states: dict[tuple[int, ...], State]) -> dict:
    """Seconds of the run, and of its right-hand sides with each set of active contacts, round by round."""
    library = load(int(run.instance.record["links"]))
    contenders = {RUN: run.run}
    for active, state in states.items():
        block = state.blocks[len(state.blocks) // 2]
        contenders[active] = lambda address=block.ctypes.data: library.share_rates(address, CALLS)
    timings = common.interleave(contenders, ROUNDS)
    each = {active: np.array(timings[active]) / CALLS for active in states}
    return {RUN: timings[RUN]} | {active: states[active].evaluations * each[active] for active in states}


def measure(name: str, stop: float) -> dict:
    """The share of one run."""
    run = Kernel(PROBLEMS[name].scene(TOLERANCE), stop)
    states = follow(run)
    seconds = timed(run, states)
    row = {"problem": name, "stop": stop, "microseconds": common.median([1e6 * t for t in seconds[RUN]])}
    for kind, touching in (("flight", False), ("contact", True)):
        those = [active for active in states if bool(active) == touching]
        if those:
            evaluations = sum(states[active].evaluations for active in those)
            each = sum(seconds[active] for active in those) / evaluations
            row[kind] = {"evaluations": evaluations, "nanoseconds": common.median(list(1e9 * each))}
    seconds["inside"] = sum(seconds[active] for active in states)
    row["share"] = common.ratio(seconds, "inside", RUN)
    print(row, flush=True)
    return row


def main() -> None:
    """Measure."""
    started = common.environment()
    settings = {"tolerance": TOLERANCE, "rounds": ROUNDS, "calls in a row": CALLS}
    common.save("rhs_share", started, settings, [measure(*place) for place in PLACES])


if __name__ == "__main__":
    main()

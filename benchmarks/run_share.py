"""What a run is made of: ``python benchmarks/run_share.py [--quick]``.

The share of right-hand sides: evaluations that a run counts × the cost of one, over the time of the run as
work_precision.py has it. What an evaluation costs is timed apart for each set of active contacts, on the
record as it is in a step of this very run, by calls in a row in code compiled as the kernel is (rhs_loop.py).
What Python adds to the kernel: a call of ``simulate()`` with two rows of outputs and with one for each
millisecond; and a step of a ``Chain`` with an input set and ten outputs read, against the kernel's own call
for a step after a changed input.
"""

from __future__ import annotations

import common  # isort: skip

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from peers.ours import Kernel
from problems import PROBLEMS
from rhs_loop import kernel_rates

from chain_impact import Chain, load_scene, simulate
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import Instance

PLACES = (("box", 0.6), ("box", 1.2), ("flight", 2.0))
TOLERANCE = 1e-8
CALLS = 1000  # right-hand sides in a row
ROW = 1e-3  # s, from one row of simulate() to the next
BY_HAND, ANEW = 1e-4, 1e-2  # s: a step of the Chain; when it starts anew, as it has not touched anything yet
FORCE = "tip.force.x"
OUTPUTS = [f"point[4].{name}" for name in ("x", "y", "vx", "vy")] + [f"link[{i}].angle" for i in range(1, 5)]
OUTPUTS += ["energy.total", "impact.count"]
ROUNDS = 15


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


def seconds_of(scene: Scene, run: Kernel, states: dict[tuple[int, ...], State], rounds: int) -> dict:
    """Seconds of the run, of ``simulate()``, and of one right-hand side in each state, round by round."""
    rates = kernel_rates(int(run.instance.record["links"]))
    contenders: dict = {
        "kernel": run.run,
        "two rows": lambda: simulate(scene, output_step=math.inf),
        "all rows": lambda: simulate(scene, output_step=ROW),
    }
    for active, state in states.items():
        block = state.blocks[len(state.blocks) // 2]
        contenders[active] = lambda address=block.ctypes.data: rates(address, CALLS)
    for call in contenders.values():
        call()
    timings = {name: np.array(row) for name, row in common.interleave(contenders, rounds).items()}
    return timings | {active: timings[active] / CALLS for active in states}


def measure(name: str, stop: float, rounds: int) -> dict:
    """What one run is made of."""
    scene = PROBLEMS[name].scene(TOLERANCE).with_values({"simulation.stop_time": stop})
    run = Kernel(scene, stop)
    states = follow(run)
    seconds = seconds_of(scene, run, states, rounds)
    row = {"problem": name, "stop": stop, "microseconds": micro(seconds["kernel"])}
    for kind, touching in (("flight", False), ("contact", True)):
        those = [active for active in states if bool(active) == touching]
        if those:
            evaluations = sum(states[active].evaluations for active in those)
            each = sum(states[active].evaluations * seconds[active] for active in those) / evaluations
            row[kind] = {"evaluations": evaluations, "nanoseconds": common.median(list(1e9 * each))}
    seconds["inside"] = sum(state.evaluations * seconds[active] for active, state in states.items())
    row["share"] = common.ratio(seconds, "inside", "kernel")
    row["simulate() adds [µs]"] = micro(seconds["two rows"] - seconds["kernel"])
    more = seconds["all rows"] - seconds["two rows"]
    row["and for each row [µs]"] = micro(more / (round(stop / ROW) - 1))
    print(row, flush=True)
    return row


def micro(seconds: np.ndarray) -> float:
    """The median over the rounds [µs]."""
    return common.median(list(1e6 * seconds))


def by_hand(scene: Scene) -> Callable[[], object]:
    """A step with an input set and outputs read."""
    chain = Chain(scene)
    force = 0.0

    def step() -> object:
        nonlocal force
        force = 1.0 - force
        if chain.time > ANEW:
            chain.reset()
        chain.set({FORCE: force})
        chain.step(BY_HAND)
        return chain.get(OUTPUTS)

    return step


def by_kernel(scene: Scene) -> Callable[[], object]:
    """The kernel's part of it."""
    instance = Instance(scene)
    given, time = instance.record["given"], instance.record["step"]
    force = given["tip_force"]
    at, row = np.zeros(1), np.zeros(1, instance.record.dtype["output"])

    def step() -> None:
        if time["time"] > ANEW:
            instance.initialize()
            at[0] = 0.0
        force[0] = 1.0 - force[0]
        given["changed"] = 1
        at[0] += BY_HAND
        instance.trajectory(at, row)

    return step


def steps(rounds: int) -> dict[str, float]:
    """Microseconds of a step of the ``Chain`` and of the kernel, and what lies between them."""
    scene = load_scene("four_link_box").with_values({"inputs.tip_force": True})
    timings = common.interleave({"Chain": by_hand(scene), "kernel": by_kernel(scene)}, rounds)
    chain, kernel = (np.array(row) for row in timings.values())
    row = {"Chain": micro(chain), "kernel": micro(kernel), "Chain adds": micro(chain - kernel)}
    print(row, flush=True)
    return row


def main() -> None:
    """Measure."""
    rounds = common.rounds(__doc__, ROUNDS)
    started = common.environment()
    results = {"runs": [measure(*place, rounds) for place in PLACES], "a step [µs]": steps(rounds)}
    settings = {"tolerance": TOLERANCE, "rounds": rounds, "calls in a row": CALLS, "row [s]": ROW}
    common.save("run_share", started, settings, results)


if __name__ == "__main__":
    main()

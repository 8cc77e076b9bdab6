"""What Python adds to the kernel: ``python benchmarks/overhead.py``.

A call of ``simulate()`` for a scene so short that little is computed, against the kernel's own calls on an
instance that is there; and a step of a ``Chain`` with an input set and ten outputs read, against the kernel's
call for a step after a changed input. The kernel's calls go through ctypes in both.
"""

from __future__ import annotations

import common  # isort: skip

from collections.abc import Callable

import numpy as np

from chain_impact import Chain, load_scene, simulate
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import Instance

STOP, STEP = 1e-2, 1e-3  # s
STEP_BY_HAND = 1e-4  # s
ROUNDS = 15
FORCE = "tip.force.x"
OUTPUTS = [f"point[4].{name}" for name in ("x", "y", "vx", "vy")] + [f"link[{i}].angle" for i in range(1, 5)]
OUTPUTS += ["energy.total", "impact.count"]


def kernel_alone(scene: Scene) -> Callable[[], object]:
    """The calls that ``simulate()`` makes of the kernel."""
    instance = Instance(scene)
    times = np.append(np.arange(round(STOP / STEP)) * STEP, STOP)
    rows = np.zeros(len(times), instance.record.dtype["output"])

    def run() -> None:
        instance.initialize()
        instance.trajectory(times, rows)
        instance.open_contacts()

    return run


def by_hand(scene: Scene) -> Callable[[], object]:
    """A step with an input set and outputs read; the chain starts anew before it touches anything."""
    chain = Chain(scene)
    force = 0.0

    def step() -> object:
        nonlocal force
        force = 1.0 - force
        if chain.time > STOP:
            chain.reset()
        chain.set({FORCE: force})
        chain.step(STEP_BY_HAND)
        return chain.get(OUTPUTS)

    return step


def by_kernel(scene: Scene) -> Callable[[], object]:
    """The kernel's part of it."""
    instance = Instance(scene)
    given, time = instance.record["given"], instance.record["step"]
    force = given["tip_force"]
    at, row = np.zeros(1), np.zeros(1, instance.record.dtype["output"])

    def run() -> None:
        if time["time"] > STOP:
            instance.initialize()
            at[0] = 0.0
        force[0] = 1.0 - force[0]
        given["changed"] = 1
        at[0] += STEP_BY_HAND
        instance.trajectory(at, row)

    return run


def main() -> None:
    """Measure, print and save."""
    started = common.environment()
    scene = load_scene("four_link_box").with_values(
        {"simulation.stop_time": STOP, "simulation.step_size": STEP}
    )
    pushed = scene.with_values({"inputs.tip_force": True})
    contenders: dict[str, Callable[[], object]] = {
        "simulate(scene)": lambda: simulate(scene),
        "simulate(scene, stop_time, tolerance)": lambda: simulate(scene, STOP, tolerance=1e-9),
        "simulate(scene, inputs)": lambda: simulate(pushed, inputs={FORCE: 1.0}),
        "kernel, a run": kernel_alone(scene),
        "Chain: set, step, get ten": by_hand(pushed),
        "kernel, a step": by_kernel(pushed),
    }
    for call in contenders.values():
        call()
    timings = common.interleave(contenders, ROUNDS)
    times = {name: common.median([1e6 * value for value in values]) for name, values in timings.items()}
    for name, value in times.items():
        base = times["kernel, a step" if name.startswith("Chain") else "kernel, a run"]
        more = "" if name.startswith("kernel") else f"  {value - base:8.1f} µs more than the kernel alone"
        print(f"{name:40}{value:8.1f} µs{more}")
    common.save("overhead", started, {"stop": STOP, "step": STEP, "by_hand": STEP_BY_HAND}, times)


if __name__ == "__main__":
    main()

"""The kernel itself, and ``simulate()`` around it."""

from __future__ import annotations

import numpy as np
from problems import Problem

from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.simulate import simulate
from peers import Contender, Outcome


class OnInstance:
    """One instance, set back to its start for each run."""

    def __init__(self, scene: Scene, stop: float) -> None:
        self.instance, self.stop = Instance(scene), stop
        # as bytes: a copy of a record goes through its fields one by one
        self.block = self.instance._block.view(np.uint8)
        self.fresh = self.block.copy()
        self.kernel, self.address = self.instance._kernel, self.instance._address

    def observed(self) -> tuple[np.ndarray, list[tuple[int, float]]]:
        """State, and onsets by candidate."""
        self.kernel.observe(self.address)
        record = self.instance.record
        out, candidate = record["output"], record["candidate"]
        state = np.concatenate(
            [out["point_position"][0], out["angle"], out["point_velocity"][0], out["angular_velocity"]]
        )
        pairs = list(zip(candidate["point"], candidate["wall"], strict=True))
        # of a run with more contacts than the log holds the oldest are lost
        log = record["finished"]
        log["count"] = min(log["count"], len(log["point"]))
        found = np.concatenate([self.instance.collect(), self.instance.open_contacts()])
        onsets = [(pairs.index((row["point"], row["wall"])), float(row["onset"])) for row in found]
        return state, sorted(onsets, key=lambda row: row[1])


class Kernel(OnInstance):
    """``initialize`` and ``advance``."""

    def run(self) -> None:
        """From parameters to the end."""
        self.block[:] = self.fresh
        self.kernel.initialize(self.address, 0.0)
        assert self.kernel.advance(self.address, self.stop) == 0

    def outcome(self) -> Outcome:
        """State, onsets and the counts of the statistics."""
        self.run()
        counts = self.instance.statistics
        state, onsets = self.observed()
        return Outcome(state, onsets, counts["steps"], counts["rhs_evaluations"])


class Simulate(Kernel):
    """``simulate()``, with its validation and a row of outputs for each millisecond."""

    def __init__(self, scene: Scene, stop: float) -> None:
        super().__init__(scene, stop)
        self.scene = scene

    def run(self) -> None:
        """One call."""
        simulate(self.scene, stop_time=self.stop)

    def outcome(self) -> Outcome:
        """That of the kernel, which it is."""
        return Kernel.outcome(Kernel(self.scene, self.stop))


def contenders(problem: Problem, tolerance: float, stop: float) -> dict[str, Contender]:
    """Both."""
    scene = problem.scene(tolerance)
    return {"ours": Kernel(scene, stop), "ours, simulate()": Simulate(scene, stop)}

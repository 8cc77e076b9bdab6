"""The motion of a scene by an integration that shares nothing with the kernel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene, scene_to_dict
from tests import coulomb
from tests.kept_answers import Arrays, kept
from tests.places import separated
from tests.textbook import Chain
from tests.walker import Walker

Inputs = Mapping[str, tuple[np.ndarray, np.ndarray]]


class Rubbing(Chain):
    """A chain with dry friction: its motion is that of tests/coulomb.py."""

    def run(self, times):
        scene, friction = separated(scene_to_dict(self.scene, derived=True))
        motion, walls = coulomb.simulate(scene, friction, times), self.scene.wall_names
        onsets = [
            (one.time, one.place[0], walls.index(one.place[1]), one.speed)
            for one in motion.changes
            if one.kind == "onset"
        ]
        return motion.states, onsets


# what has no stops in joints and no dry friction moves as the chain of the textbook
OTHERS: dict[str, Any] = {"KneedLeg": Walker, "SlidingRod": Rubbing}


def moved(scene: Scene, times: np.ndarray, inputs: Inputs | None = None) -> tuple[Any, Arrays]:
    """The chain, and its ``states`` at some times and ``onsets`` (time, point, wall, speed) by then."""
    chain = OTHERS.get(scene.name, Chain)(scene, inputs)

    def integrate() -> Arrays:
        states, onsets = chain.run(times)
        return {"states": states, "onsets": np.array(onsets, float).reshape(-1, 4)}

    return chain, kept(integrate, __name__, scene, times, dict(inputs or {}))

"""What the tests of rigid walls share."""

from __future__ import annotations

from typing import Any

import numpy as np

from chain_impact.scene.scene import Scene, with_values
from tests.problems import GRAVITY

LAW = "newton_impact"
WEIGHT = 4 * GRAVITY  # N, of the default chain


def rigid(scene: Scene, **contact: Any) -> Scene:
    """The scene with rigid walls, and with some keys of its [contact] table changed."""
    changes = {("contact", key): value for key, value in contact.items()}
    return with_values(scene, {("contact", "model"): LAW} | changes)


def floor_forces(row: np.void) -> np.ndarray:
    """Forces [N] of the floor on the five points of the default chain, from a row of outputs."""
    return row["force"].reshape(5, 4)[:, 2]

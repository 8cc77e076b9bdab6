"""The textbook's chain with armatures in its joints, in flight: an independent model of drives."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from chain_impact.scene.scene import Scene
from tests.textbook import Textbook


class DrivenChain(Textbook):
    """As ``Textbook``, with I_a g gᵀ of each joint in M, g the gradient of its relative rotation."""

    def __init__(self, scene: Scene, **more: Any):
        super().__init__(scene, **more)
        armature = np.array([link.joint_armature for link in self.links])
        if not self.free.start:
            armature[0] = 0.0
        gradient = np.eye(self.n) - np.eye(self.n, k=-1)
        self.inertia = self.inertia + gradient.T @ np.diag(armature) @ gradient

    def reached(self, time: float) -> np.ndarray:
        """The state y at a time [s]."""
        options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
        return solve_ivp(lambda _, y: self.rate(y), (0.0, time), self.start, **options).y[:, -1]

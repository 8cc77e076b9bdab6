"""What a simulation returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chain_impact.scene import Scene

IMPACT_DTYPE = np.dtype(
    [
        ("point", np.int64),
        ("wall", np.int64),
        ("onset", np.float64),
        ("end", np.float64),
        ("impact_speed", np.float64),
        ("separation_speed", np.float64),
        ("peak_force", np.float64),
        ("max_penetration", np.float64),
        ("effective_mass", np.float64),
        ("impulse", np.float64),
    ]
)
"""One contact: point 0…N; wall as index into ``scene.wall_names``; onset and end [s]; impact and separation
speed [m/s]; peak force [N]; largest penetration [m]; effective mass at onset [kg]. The end and the separation
speed of a contact that lasts to the end of the simulation are NaN. Under the law ``newton_impact`` a bounce
has no duration and an infinite peak force; that of a contact that lasts is the largest force that held it."""


@dataclass(frozen=True)
class Result:
    """What happened in a simulation.

    Attributes:
        scene: the scene as it was simulated.
        time: communication points, shape (T,) [s].
        outputs: all outputs at these times, a structured array of shape (T,), see
            ``instance.output_dtype``.
        impacts: one row for each contact in order of onset, see ``IMPACT_DTYPE``.
        statistics: steps, rejected_steps, rhs_evaluations, implicit_steps, status.
    """

    scene: Scene
    time: np.ndarray
    outputs: np.ndarray
    impacts: np.ndarray
    statistics: dict[str, int]

    @property
    def points(self) -> np.ndarray:
        """Positions of the points 0…N, shape (T, N+1, 2) [m]."""
        return self.outputs["point_position"]

    @property
    def angles(self) -> np.ndarray:
        """Absolute angles of the links, shape (T, N) [rad]."""
        return self.outputs["angle"]

    @property
    def angular_velocities(self) -> np.ndarray:
        """Angular velocities of the links, shape (T, N) [rad/s]."""
        return self.outputs["angular_velocity"]

    @property
    def energy(self) -> np.ndarray:
        """The ledger [J], a structured array of shape (T,).

        Fields kinetic, potential, elastic, dissipated, supplied and total = kinetic + potential + elastic;
        total + dissipated − supplied is constant.
        """
        return self.outputs[["kinetic", "potential", "elastic", "dissipated", "supplied", "total"]]

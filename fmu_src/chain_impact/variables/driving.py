"""The data of a scene's signals in a new record (kernel/chain/signals.py)."""

from __future__ import annotations

from typing import Any

from chain_impact.kernel.chain import signals as kernel
from chain_impact.scene.names import DataPath
from chain_impact.scene.scene import Scene
from chain_impact.scene.signal_values import write_signal
from chain_impact.variables.kind import MOTION
from chain_impact.variables.listing import inputs_asked
from chain_impact.variables.structure import Structure

_DRIVEN = {
    "joint_torque": kernel.TORQUE,
    "joint_target_angle": kernel.TARGET,
    "joint_target_velocity": kernel.TARGET_VELOCITY,
    "tip_force": kernel.TIP_FORCE,
    "slider_force": kernel.SLIDER_FORCE,
    "slider_target_position": kernel.SLIDER_TARGET,
    "slider_target_velocity": kernel.SLIDER_TARGET_VELOCITY,
}
"""Field of the record that holds an input → the number by which the kernel knows the input."""


def fill_signals(d: Any, scene: Scene, structure: Structure) -> None:
    """Write the signals of a scene into a new instance."""
    if not scene.signals:
        return
    fields, stop = d["signal"], scene.simulation.stop_time
    paths = {variable.name: variable.record_path for variable in inputs_asked(structure)}
    first, knot = dict[str, int](), 0
    for j, signal in enumerate(structure.signals):
        fields["input"][j], fields["index"][j] = acting(paths[signal.input])
        fields["source"][j] = first.setdefault(signal.signal, j)
        fields["order"][j], fields["first"][j] = signal.order, knot
        write_signal(d, j, scene.signals[signal.signal], signal.input, stop)
        knot += signal.knots


def acting(path: DataPath) -> tuple[int, str | int]:
    """Return the number by which the kernel knows an input, and the index of the input's joint or channel.

    ``path`` is the path of the input in the record. The index is 0 if there is only one such input.
    """
    part, field, *index = path
    return kernel.CHANNEL if part == MOTION else _DRIVEN[str(field)], index[0] if index else 0

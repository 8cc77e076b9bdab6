"""Writes the signals of a scene into a new record; kernel/chain/signals.py evaluates them in a run.

The twin in JavaScript is pages/browser/scene/record.js.
"""

from __future__ import annotations

from typing import Any

from chain_impact.kernel.record.input_fields import CHANNEL, INPUT_NAMES
from chain_impact.scene.scene import Scene
from chain_impact.scene.signal_polynomials import write_signal
from chain_impact.scene.texts.names import DataPath
from chain_impact.variables.kind import GIVEN_CHANNEL
from chain_impact.variables.scene_variables import requested_inputs_of
from chain_impact.variables.structure import Structure


def fill_signals(d: Any, scene: Scene, structure: Structure) -> None:
    """Write the signals of a scene into the new instance ``d``.

    The record has an entry for each input that a signal drives. The entry has the number of the input, the
    form and the values of the signal, and how often the kernel integrates the input over time: twice for an
    acceleration of the base or a wall, once for a velocity of these or a belt's speed, else not at all.
    """
    if not scene.signals:
        return
    fields, stop_time = d["signal"], scene.simulation.stop_time
    paths = {variable.name: variable.record_path for variable in requested_inputs_of(structure)}
    first, knot = dict[str, int](), 0
    for j, signal in enumerate(structure.signals):
        fields["input"][j], fields["index"][j] = input_at(paths[signal.input])
        fields["source"][j] = first.setdefault(signal.signal, j)
        fields["order"][j], fields["first_knot"][j] = signal.order, knot
        write_signal(d, j, scene.signals[signal.signal], signal.input, stop_time)
        knot += signal.knot_count


def input_at(path: DataPath) -> tuple[int, str | int]:
    """Return the number of an input's field (kernel/record/input_fields.py), and the index in this field.

    ``path`` is the path of the input in the record. All prescribed motions have the number CHANNEL.
    """
    part, field, index = path
    return CHANNEL if part == GIVEN_CHANNEL else INPUT_NAMES.index(str(field)), index

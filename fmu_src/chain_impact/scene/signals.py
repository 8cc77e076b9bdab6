"""Signals, functions of time that drive inputs of the scene: defaults, table files, and the driven inputs.

kernel/chain/signals.py computes the values of signals.
The twin in JavaScript is pages/browser/scene/signals.js.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from chain_impact.scene.contents import AnyScene, SceneContents
from chain_impact.scene.errors import SceneError, error_at, refusal
from chain_impact.scene.files.table_file import read_table, samples_of
from chain_impact.scene.keys.signal_tables import FORMS, Samples, Signal
from chain_impact.scene.signal_polynomials import knots_of
from chain_impact.scene.texts.input_table import determined_quantities
from chain_impact.scene.texts.similar_names import nearest_hint

Numbers = tuple[float, ...]
TARGET_RATE = ".target_velocity"
"""The end of the names of target velocities. Signals that drive these come last in the record, because their
values replace the derivatives of target angles and positions that other signals drive."""


class SignalInput(NamedTuple):
    """An input that a signal drives.

    Attributes:
        signal: the name of the signal.
        input: the name of the input.
        outputs: the names of the quantities that the signal determines (``determined_quantities``): integrals
            of the input over time, the input, and derivatives of the input, in this order.
        knot_count: the number of polynomials for the input in the record.
        is_steps: whether the form of the signal is "steps", with lists of times and values.
    """

    signal: str
    input: str
    outputs: tuple[str, ...]
    knot_count: int
    is_steps: bool

    @property
    def order(self) -> int:
        """The number of integrations over time from the driven input to the first of ``outputs``.

        It is 2 for ``base.ax``, 1 for ``base.vx`` or a belt's speed, and 0 for ``base.x`` or a force.
        """
        return self.outputs.index(self.input)


def signal_inputs_of(scene: SceneContents) -> tuple[SignalInput, ...]:
    """Return the inputs that signals drive, in the order of signals; target velocities come last."""
    if not scene.signals:
        return ()
    signal_inputs = [
        SignalInput(
            name,
            input_name,
            determined_quantities(input_name),
            knots_of(signal, input_name),
            signal.form == "steps",
        )
        for name, signal in scene.signals.items()
        for input_name in signal.input
    ]
    return tuple(sorted(signal_inputs, key=lambda signal_input: signal_input.input.endswith(TARGET_RATE)))


def with_signals(scene: AnyScene, folder: Path) -> AnyScene:
    """Return the scene with the defaults of its signals, and with the contents of the signals' table files.

    Relative paths of files begin at ``folder``.
    """
    if not scene.signals:
        return scene
    completed = {name: _with_defaults(name, signal) for name, signal in scene.signals.items()}
    stop_time = scene.simulation.stop_time
    completed = {
        name: _with_samples(name, signal, folder, stop_time) if signal.form == "table" else signal
        for name, signal in completed.items()
    }
    return replace(scene, signals=completed)


def _with_samples(name: str, signal: Signal, folder: Path, stop_time: float) -> Signal:
    """Return the signal with the contents of its table file, and with the absolute path of this file.

    Refuse a file that cannot be read, is no table of inputs, or lacks a column for an input. ``stop_time`` is
    the end of the run [s].
    """
    path, key = (folder / (signal.file or "")).absolute(), ("signals", name, "file")
    try:
        status = path.stat()
        times, columns = _read_samples(path, status.st_mtime_ns, status.st_size, stop_time)
    except OSError as error:
        raise error_at(key, f"cannot be read ({error.strerror})", repr(signal.file)) from None
    except SceneError as error:
        raise error_at(key, f": {error}") from None
    for input_name in signal.input:
        if input_name not in columns:
            hint = nearest_hint(input_name, columns, f"it has {', '.join(columns)}")
            raise error_at(key, f"has no column {input_name}; {hint}", repr(signal.file))
    return replace(
        signal,
        file=str(path),
        samples=Samples(times, tuple((input_name, columns[input_name]) for input_name in signal.input)),
    )


@lru_cache(16)
def _read_samples(
    path: Path, _change_time: int, _size: int, stop_time: float
) -> tuple[Numbers, dict[str, Numbers]]:
    """Return the times [s] of a table file, and its other columns by name; the results are cached.

    ``_change_time`` is the time of the file's last change, ``_size`` the size of the file [byte]: with other
    values of these, the file is read again. ``stop_time`` is the end of the run [s].
    """
    times, columns = samples_of(read_table(path), stop_time)
    return tuple(times.tolist()), {name: tuple(column.tolist()) for name, column in columns.items()}


def _with_defaults(name: str, signal: Signal) -> Signal:
    """Return the signal with the defaults of its form.

    Refuse a ``name`` that is no identifier, a signal without a required key, and one with a key that its form
    does not have.
    """
    signal_form = FORMS[signal.form]
    if not name.isidentifier():
        raise refusal(("signals", name), "signal_name")
    for form in FORMS.values():
        for key in form.keys:
            if key not in signal_form.keys and getattr(signal, key) is not None:
                template_values = {"form": signal.form, "keys": ", ".join(signal_form.keys)}
                raise refusal(("signals", name, key), "other_form", **template_values)
    for key in signal_form.required:
        if getattr(signal, key) is None:
            raise refusal(("signals", name, key), "needs_key", form=signal.form)
    default_values = {
        key: value for key, value in signal_form.optional.items() if getattr(signal, key) is None
    }
    return replace(signal, **default_values)

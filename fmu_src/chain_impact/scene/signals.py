"""Signals, functions of time that drive inputs of the scene: their defaults, table files and inputs.

kernel/chain/signals.py computes their values.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import chain, count
from pathlib import Path
from typing import Any, NamedTuple

from chain_impact.scene.contents import AnyScene, Contents
from chain_impact.scene.names import INPUTS_OF, input_asked, input_key
from chain_impact.scene.reading import SceneError, refusal
from chain_impact.scene.signal import FORMS, Samples, Signal
from chain_impact.scene.signal_values import is_motion, knots_of
from chain_impact.scene.similar_names import nearest
from chain_impact.scene.table_file import read_table, samples_of

Numbers = tuple[float, ...]
TARGET_RATE = ".target_velocity"
"""The end of the names of target velocities, which come last, because they replace the rates of targets."""


class Driven(NamedTuple):
    """An input that a signal drives.

    Attributes:
        signal: the name of the signal.
        input: the name of the input.
        outputs: the names of the driven quantities in order: the integrals of the input, the input, and the
            derivatives of the input.
        knots: the number of polynomials that the signal needs.
        is_steps: whether the signal has lists of times and values.
    """

    signal: str
    input: str
    outputs: tuple[str, ...]
    knots: int
    is_steps: bool

    @property
    def order(self) -> int:
        """How many times the input must be integrated to give the first of the ``outputs``."""
        return self.outputs.index(self.input)


def driven_by(scene: Contents) -> tuple[Driven, ...]:
    """Return the inputs that signals drive; target velocities come last."""
    if not scene.signals:
        return ()
    driven = [
        Driven(name, input_name, family(input_name), knots_of(signal), signal.form == "steps")
        for name, signal in scene.signals.items()
        for input_name in signal.input
    ]
    return tuple(sorted(driven, key=lambda each: each.input.endswith(TARGET_RATE)))


def family(name: str) -> tuple[str, ...]:
    """Return the names of an input's integrals, the input, and its derivatives, in this order.

    Only names of inputs are returned, but "" for the integral of a belt's speed.
    """
    head, _, last = name.rpartition(".")
    if head == "base":
        return tuple(f"base.{prefix}{last[-1]}" for prefix in ("", "v", "a"))
    if head.startswith("wall.") and last != "belt_speed":
        return tuple(f"{head}.{key}" for key in ("displacement", "velocity", "acceleration"))
    if last == "belt_speed":
        return "", name  # the integral of a belt's speed is not an input
    if last in ("target_angle", "target_position"):
        return name, head + TARGET_RATE
    return (name,)


def driven_alone(name: str) -> tuple[str, ...]:
    """Return the inputs that no second signal may drive if a signal drives the input ``name``.

    For a motion these are the position, the velocity and the acceleration; else only the input itself.
    """
    return family(name) if is_motion(name) else (name,)


def with_signals(scene: AnyScene, folder: Path) -> AnyScene:
    """Return the scene with defaults for its signals and with the contents of their table files.

    Relative paths of files begin at ``folder``.
    """
    if not scene.signals:
        return scene
    completed = {name: _completed(name, signal) for name, signal in scene.signals.items()}
    stop = scene.simulation.stop_time
    completed = {
        name: _with_samples(name, signal, folder, stop) if signal.form == "table" else signal
        for name, signal in completed.items()
    }
    return replace(scene, signals=completed)


def with_inputs(scene: Any, file: Path, interpolation: str | None = None) -> Any:
    """Return the scene with one more signal: a table that drives each input with a column in a file.

    Args:
        scene: the scene, which must have these inputs.
        file: CSV or Parquet, with the column ``time`` [s].
        interpolation: ``hold``, ``linear`` or ``spline``; by default the usual interpolation of each input.

    Raises:
        SceneError: when the table cannot drive the scene.
        OSError: when the file cannot be read.
    """
    _, columns = samples_of(read_table(file), scene.simulation.stop_time)
    numbered = (f"inputs_{k}" for k in count(2))
    name = next(free for free in chain(("inputs",), numbered) if free not in scene.signals)
    owners = {
        driven: owner
        for owner, signal in scene.signals.items()
        for column in signal.input
        for driven in driven_alone(column)
    }
    for column in columns:
        for driven in driven_alone(column):
            if driven in owners:
                by = f"signals.{owners[driven]} of {scene.name} drives {driven}"
                raise SceneError(f"{file}: column {column} must be left out: {by}")
        if column not in inputs_of(scene):
            raise SceneError(
                f"{file}: column {column} is not an input of {scene.name}; {how_asked(scene, column)}"
            )
    table = {"input": list(columns), "form": "table", "file": str(file.absolute())}
    table |= {"interpolation": interpolation} if interpolation else {}
    return scene.with_values({("signals", name): table})


def _with_samples(name: str, signal: Signal, folder: Path, stop: float) -> Signal:
    """Return the signal with the contents of its file, and with the full path of the file.

    Refuse a file that cannot be read, or lacks a column for an input.
    """
    path, where = (folder / (signal.file or "")).absolute(), f"signals.{name}.file = {signal.file!r}"
    try:
        status = path.stat()
        times, columns = _read(path, status.st_mtime_ns, status.st_size, stop)
    except OSError as error:
        raise SceneError(f"{where} cannot be read ({error.strerror})", ("signals", name, "file")) from None
    except SceneError as error:
        raise SceneError(f"signals.{name}.file: {error}", ("signals", name, "file")) from None
    for input_name in signal.input:
        if input_name not in columns:
            near = nearest(input_name, columns)
            hint = f"; the nearest is {near}" if near else f"; it has {', '.join(columns)}"
            raise SceneError(f"{where} has no column {input_name}{hint}", ("signals", name, "file"))
    return replace(
        signal,
        file=str(path),
        samples=Samples(times, tuple((input_name, columns[input_name]) for input_name in signal.input)),
    )


@lru_cache(16)
def _read(path: Path, _changed: int, _size: int, stop: float) -> tuple[Numbers, dict[str, Numbers]]:
    """Return the times and columns of a file; a changed file is read again."""
    times, columns = samples_of(read_table(path), stop)
    return tuple(times.tolist()), {name: tuple(column.tolist()) for name, column in columns.items()}


def _completed(name: str, signal: Signal) -> Signal:
    """Return the signal with its defaults; refuse an unfit name, a missing key, and a key of another form."""
    own = FORMS[signal.form]
    if not name.isidentifier():
        raise refusal(("signals", name), "signal_name")
    for form in FORMS.values():
        for key in form.keys:
            if key not in own.keys and getattr(signal, key) is not None:
                words = {"form": signal.form, "keys": ", ".join(own.keys)}
                raise refusal(("signals", name, key), "other_form", **words)
    for key in own.required:
        if getattr(signal, key) is None:
            raise refusal(("signals", name, key), "needs_key", form=signal.form)
    missing = {key: value for key, value in own.optional.items() if getattr(signal, key) is None}
    return replace(signal, **missing)


def how_asked(scene: Contents, name: str) -> str:
    """Return words for an error on an input that is not there: how to get it, or which inputs are there."""
    key, there = input_key(name), list(inputs_of(scene))
    if key == "wall_motion" and (wall := name.split(".")[1]) not in scene.half_planes:
        return f"there is no wall {wall}"
    if key == "wall_motion" and not scene.may_touch:
        return "no point can touch a wall"
    if key and (key == "wall_motion" or not getattr(scene.inputs, key)):
        return f"{input_asked(name)} makes it"
    if near := nearest(name, there):
        return f"the nearest is {near}"
    return f"it has {', '.join(there)}" if there else "it has none"


def inputs_of(scene: Contents) -> Iterator[str]:
    """Yield the names of the inputs that the scene asks for, with or without a signal that drives them."""
    templates = [name for key, names in INPUTS_OF.items() if getattr(scene.inputs, key) for name in names]
    owners: dict[str, Sequence[dict[str, Any]]] = {
        "joint[{n}]": [{"n": n} for n in scene.chain.joints],
        "slider": [{}] * (scene.chain.base == "slider"),
        "tip": [{}],
        "base": [{}],
        "wall": [{"name": wall} for wall in scene.moving_walls],
    }
    for head, words in owners.items():
        of_head = [template for template in templates if template.startswith(f"{head}.")]
        for word in words:
            yield from (template.format(**word) for template in of_head)

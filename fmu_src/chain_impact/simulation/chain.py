"""A chain that a program advances step by step, for controllers and machine learning."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import astuple
from functools import cached_property
from typing import Any

import numpy as np

from chain_impact.kernel.chain.inputs import REINITIALIZE
from chain_impact.kernel.status import OK
from chain_impact.recording.impacts import LOG_DTYPE, sorted_impacts
from chain_impact.recording.stick_slip import phases_of
from chain_impact.results.result import Result
from chain_impact.scene.asked_inputs import request_hint
from chain_impact.scene.errors import SceneError, UnknownNameError, names_matching, value_text
from chain_impact.scene.scene import Scene, SceneSource, fixed_hint, scene_of
from chain_impact.scene.texts.angles import or_degrees, radians_of
from chain_impact.scene.texts.input_table import input_key
from chain_impact.scene.warning import warn
from chain_impact.simulation.chain_access import (
    Selection,
    VariableInRecord,
    variable_in_record,
    with_present_values,
)
from chain_impact.simulation.chain_rows import ChainRows
from chain_impact.simulation.chain_states import DAMAGED, ChainState, state_from
from chain_impact.simulation.errors import SimulationError, fault_text
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.output_rows import spans_of
from chain_impact.text import count_text
from chain_impact.variables.indices import word_index
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.scene_variables import absent_hint


class Chain:
    """An instance of a scene that a program advances step by step.

    Names and rules are the same as in the FMU: until the first step, all variables except outputs can be set;
    after the first step, only inputs and tunable parameters. A value acts from the present time on, until the
    variable is set again. If values are set at the same times, the size of the steps changes the solution
    only where inputs move the base, walls or belts (docs/drive.md). After a ``SimulationError``, ``restore``
    and ``reset`` return to an earlier state.

    Attributes:
        scene: the scene, without the values that ``set`` has changed.
    """

    def __init__(self, scene: SceneSource, *, record: bool | str | Iterable[str] = False) -> None:
        """Begin at the start of the scene, t = 0.

        Args:
            scene: a scene, or an argument of ``load_scene``. The chain has the inputs that the scene asks for
                in its table ``inputs``.
            record: True keeps a row of all outputs and inputs at the start and after each step, for
                ``result``; names, in which ``*`` stands for any text, choose outputs and inputs.

        Raises:
            SceneError: when the scene is invalid.
            SimulationError: when the scene cannot start.
            BuildError: when the kernel cannot be compiled.
        """
        self.scene: Scene = scene_of(scene)
        prepared_scene = PreparedScene(self.scene)
        self._prepared_scene, self._record = prepared_scene, record
        self._rows = ChainRows(prepared_scene, record) if record is not False else None
        self._instance = Instance(prepared_scene)
        self._reals = self._instance.words
        self._integers = self._reals.view(np.int64)
        self._start = self._reals.copy()
        dtype = self._instance.record.dtype
        self._variables = {
            v.name: variable_in_record(v, prepared_scene.table_row(v)) for v in prepared_scene.variables
        }
        self._signal_of = prepared_scene.signals_by_input
        self._time_word = word_index(dtype, ("step", "communication_point"))
        self._pending_word = word_index(dtype, ("given", "pending"))
        self._ended_word = word_index(dtype, ("contact_log", "count"))
        self._collected_word = word_index(dtype, ("contact_log", "collected"))
        self._contradiction_word = word_index(dtype, ("channel", "contradiction"))
        self._has_warned = False
        self._friction_changes_word = word_index(dtype, ("friction_changes", "count"))
        self._selections: dict[str | tuple[str, ...], Selection] = {}
        self._instant = np.zeros(1)
        self._no_words = spans_of(np.zeros(0, int))
        self._has_stepped, self._is_initialized, self._is_observed = False, True, False
        self._impacts: list[np.ndarray] = []

    @property
    def time(self) -> float:
        """The present time [s]."""
        return float(self._reals[self._time_word])

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all variables: parameters, inputs, outputs."""
        return tuple(self._variables)

    @property
    def impacts(self) -> np.ndarray:
        """The contacts up to the present time in the order of their onsets, see ``IMPACT_DTYPE``.

        The end of a contact that still lasts is NaN.
        """
        self._ensure_initialized()
        words_before = self._reals.copy()
        # ``open_contacts`` ends the solver's last step at the present time; the copy ``words_before`` undoes
        # this
        lasting_contacts = self._instance.open_contacts()
        self._reals[:] = words_before
        return sorted_impacts([*self._impacts, lasting_contacts], self.scene.wall_names)[1]

    @property
    def stick_slip(self) -> np.ndarray:
        """The phases of dry friction up to the present time, see ``STICK_SLIP_DTYPE``.

        The end of a phase that still lasts is NaN.
        """
        self._ensure_initialized()
        self._collect()
        return phases_of(self._instance.all_changes)

    def result(self) -> Result:
        """Return what has been run up to the present time, with a row at the start and after each step.

        A chain keeps rows only with ``record``. After ``restore`` there are the rows up to the restored
        state; if this has no row here, as a state of another chain, the rows begin with it.

        Raises:
            SceneError: when the chain keeps no rows, or has no row yet and the run cannot continue with the
                values that were set.
            SimulationError: when the scene cannot start with the values that were set.
        """
        if self._rows is None:
            raise SceneError(f"{self.scene.name}: result() needs rows: create Chain(…, record=True)")
        self._begin_rows(self._rows)
        prepared_scene = with_present_values(self._prepared_scene, self._variables, self._start, self._reals)
        statistics = self._instance.statistics
        return self._rows.result(prepared_scene, self.impacts, self.stick_slip, statistics)

    def step(self, duration: float) -> None:
        """Advance by a duration > 0 [s].

        Raises:
            SceneError: when the duration is not a finite number > 0.
            SimulationError: when the scene cannot start with the values that were set, or the solver cannot
                continue.
        """
        if not 0.0 < duration < math.inf:
            raise SceneError(
                f"{self.scene.name}: step({value_text(duration)}) must be a finite number > 0 [s]"
            )
        self.step_to(self.time + duration)

    def step_to(self, time: float) -> None:
        """Advance to a time [s], which must not be before the present time.

        The first time at which given positions of a motion contradict its velocity gives a SceneWarning.

        Raises:
            SceneError: when the time lies in the past, or is not a finite number.
            SimulationError: when the scene cannot start with the values that were set, or the solver cannot
                continue.
        """
        if not self.time <= time < math.inf:
            needed_text = f"a finite number >= {self.time!r} [s], the present time"
            raise SceneError(f"{self.scene.name}: step_to({value_text(time)}) must be {needed_text}")
        self._ensure_initialized()
        row, spans = self._instant, self._no_words
        if self._rows is not None:
            self._begin_rows(self._rows)
            row, spans = self._rows.new_row(), self._rows.spans
        self._has_stepped, self._is_observed = True, False
        self._instant[0] = time
        while not self._instance.trajectory(self._instant, row, spans):
            # the kernel also returns when a fault occurs, when the log of contacts is full, and from time to
            # time so that Python notices Ctrl-C
            self._collect()
            if self._instance.status != OK:
                status, part = self._instance.status, self._instance.part
                recording = self.result() if self._rows else None
                raise SimulationError(status, self.time, recording, part, self.scene.name)
        self._collect()
        self._is_observed = True
        if self._rows is not None:
            self._rows.add(self._instance, row[0])
        if not self._has_warned and self._integers[self._contradiction_word]:
            self._has_warned = True
            warn(self.scene.name, self._instance.contradictions)

    def get(self, names: str | Iterable[str]) -> Any:
        """Return the present values of variables in SI units; a choice is its number in the FMU.

        Args:
            names: one name gives a number. A list of names, or a name with ``*`` for any text, gives an
                array, shape (M,), with M variables in the order of the names; those that match one name are
                in the order of the FMU.

        Raises:
            UnknownNameError: when no variable has one of the names.
            SceneError: when the names need outputs, and the run cannot continue with the values that were
                set.
            SimulationError: when the scene cannot start with the values that were set.
        """
        key = names if isinstance(names, str) else tuple(names)
        selection = self._selections.get(key) or self._select(key)
        if selection.observed and not self._is_observed:
            self._ensure_initialized()
            self._observe()
            self._is_observed = True
        values = self._reals[selection.words]
        if selection.integer_positions.size:
            values[selection.integer_positions] = self._integers[selection.words[selection.integer_positions]]
        if isinstance(key, str) and "*" not in key:
            return int(values[0]) if selection.integer_positions.size else float(values[0])
        return values

    def set(self, values: Mapping[str, Any] | str, value: Any = None) -> None:
        """Set variables by name: ``set({"joint[2].torque": 0.5})`` or ``set("joint[2].torque", 0.5)``.

        If one value is refused, no value is set.

        Values are in SI units. A contact law or a solver method may be given by its name or its number in the
        FMU, an angle also as "90 deg".

        Raises:
            UnknownNameError: when no variable has the name.
            SceneError: when a variable is an output, is fixed after the first step, or cannot have the value.
        """
        given_values = {values: value} if isinstance(values, str) else values
        checked = [self._checked_value(name, value) for name, value in given_values.items()]
        for variable, number in checked:
            memory = self._integers if variable.is_integer else self._reals
            if memory[variable.row.set_word] != number:
                memory[variable.row.word] = memory[variable.row.set_word] = number
                self._is_observed = False
                if self._has_stepped:
                    self._integers[self._pending_word] = REINITIALIZE
                else:
                    self._is_initialized = False
                    self._clear_rows()

    def save(self) -> bytes:
        """Return the whole present state; any chain of the same scene continues from this state bit by bit.

        Raises:
            SimulationError: when the scene cannot start with the values that were set.
        """
        self._ensure_initialized()
        self._collect()
        impacts = np.concatenate([np.zeros(0, LOG_DTYPE), *self._impacts])
        changes = self._instance.all_changes
        return ChainState(self._has_stepped, impacts, changes, self._reals).as_bytes(self._digest)

    def restore(self, state: bytes) -> None:
        """Return to a saved state.

        Raises:
            SceneError: when ``state`` does not belong to a chain of this scene, or is damaged.
        """
        if not isinstance(state, bytes | bytearray | memoryview):
            subject = f"restore({value_text(state)})"
            raise SceneError(f"{self.scene.name}: {subject} must be given the bytes that save() returned")
        subject = f"{self.scene.name}: restore"
        saved = state_from(bytes(state), self._digest, self._reals.nbytes, subject)
        if not self._instance.is_sound(saved.words):
            raise SceneError(f"{subject}: {DAMAGED}")
        self._reals[:] = saved.words
        self._impacts, self._instance.changes = [saved.impacts], [saved.changes]
        self._has_stepped, self._is_initialized, self._is_observed = saved.has_stepped, True, False
        if self._rows is not None:
            self._rows.restore(self._instance)

    def reset(self) -> None:
        """Return to the start of the scene, with all values as the scene gives them."""
        self._reals[:] = self._start
        self._impacts, self._instance.changes, self._has_warned = [], [], False
        self._clear_rows()
        self._has_stepped, self._is_initialized, self._is_observed = False, True, False

    def __reduce__(self) -> tuple[Callable[..., Chain], tuple[Any, ...]]:
        """Pickle scene, state and rows, so that the chain can be copied or sent to another process."""
        return _restored, (self.scene, self.save(), self._record, self._rows and self._rows.stored_rows)

    def __repr__(self) -> str:
        """Return a text with the name of the scene, its number of links and the present time."""
        links = count_text(len(self.scene.chain.links), "link")
        return f"Chain({self.scene.name}) of {links} at t = {self.time:.9g} s"

    def _ensure_initialized(self) -> None:
        """Compute the start again if ``set`` has changed a value before the first step."""
        if not self._is_initialized:
            self._instance.initialize()
            self._is_initialized, self._is_observed = True, False

    def _begin_rows(self, rows: ChainRows) -> None:
        """Add a row at the present time if there is none yet."""
        if not rows.times:
            self._ensure_initialized()
            self._observe()
            rows.add(self._instance)

    def _clear_rows(self) -> None:
        if self._rows is not None:
            self._rows.clear()

    def _observe(self) -> None:
        """Compute the outputs.

        Raise a SceneError if the run cannot continue with the values that were set.
        """
        status = self._instance.observe()
        if status != self._instance.status:
            time_text = f"{self.scene.name}: at t = {self.time:.9g} s"
            text = fault_text(status, self._instance.part)
            raise SceneError(f"{time_text} the values that are set cannot take effect: {text}")

    def _collect(self) -> None:
        has_ended = self._integers[self._ended_word] != self._integers[self._collected_word]
        if has_ended or self._integers[self._friction_changes_word]:
            self._impacts.append(self._instance.collect())

    def _select(self, key: str | tuple[str, ...]) -> Selection:
        names = (key,) if isinstance(key, str) else key
        selected_names = [
            match
            for name in names
            for match in names_matching(self.scene.name, name, self._variables, "not a variable", self._hint)
        ]
        selection = self._selections[key] = Selection.from_variables(
            [self._variables[name] for name in selected_names]
        )
        return selection

    def _checked_value(self, name: str, value: Any) -> tuple[VariableInRecord, float]:
        """Return a variable in the record, and its new value as a number in SI units, after checks.

        Refused are an unknown name, a variable that cannot be set now, and a value that is not allowed.
        """
        variable = self._variables.get(name)
        if variable is None:
            raise UnknownNameError(self.scene.name, name, self._variables, "not a variable", self._hint(name))
        if variable.row.role == "output" or (variable.row.role == "fixed" and self._has_stepped):
            fault = "is a fixed parameter and cannot be set after the first step"
            if variable.row.role == "output":
                signal_name = self._signal_of.get(name)
                fault = (
                    f"cannot be set: signals.{signal_name} drives it"
                    if signal_name
                    else "is an output and cannot be set"
                )
            raise SceneError(f"{self.scene.name}: {name} {fault}")
        try:
            number = variable.choices.index(value) + 1 if value in variable.choices else value
            number = radians_of(number, variable.unit)
            is_in_range = variable.row.low <= number <= variable.row.high and (
                not variable.is_integer or number == int(number)
            )
        except (TypeError, ValueError):
            is_in_range = False
        if not is_in_range or isinstance(value, bool):
            allowed_text = f"{variable.row.allowed}{or_degrees(variable.unit)}"
            raise SceneError(f"{self.scene.name}: {name} = {value_text(value)} must be {allowed_text}")
        return variable, number

    def _hint(self, name: str) -> str | None:
        """Return a hint for a name that is no variable of the chain; None if no hint is known.

        The hint tells how a scene gets this variable or, for a value of the scene that cannot change in a
        run, how to change this value.
        """
        if input_key(name):
            return request_hint(self.scene, name)
        return absent_hint(name) or fixed_hint(self.scene, name)

    @cached_property
    def _digest(self) -> bytes:
        return hashlib.sha256(repr(astuple(self.scene)).encode()).digest()[:16]


def _restored(scene: Scene, state: bytes, record: Any, rows: Any) -> Chain:
    """Return a chain of a scene in the ``state`` that ``save`` returned; used to unpickle a chain."""
    chain = Chain(scene, record=record)
    chain.restore(state)
    if chain._rows is not None:
        chain._rows.stored_rows = rows
    return chain

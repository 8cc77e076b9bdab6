"""An instance: a record, and the runs of a kernel on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.kernel.record.fields import WORD
from chain_impact.kernel.status import OK, PAUSED
from chain_impact.progress import Progress, no_progress
from chain_impact.recording.impacts import LOG_DTYPE
from chain_impact.recording.stick_slip import CHANGE_DTYPE
from chain_impact.scene.candidates import part_texts
from chain_impact.scene.scene import Scene
from chain_impact.simulation.errors import SimulationError
from chain_impact.simulation.input_schedule import InputSchedule
from chain_impact.simulation.kernels import kernel_for
from chain_impact.simulation.output_rows import Rows, spans_of
from chain_impact.variables.indices import HEAD_WORDS, log_words
from chain_impact.variables.kind import GIVEN_CHANNEL
from chain_impact.variables.parameters import DERIVED_DURING_RUN
from chain_impact.variables.prepared import PreparedScene, as_prepared
from chain_impact.variables.scene_variables import TANGENTS
from chain_impact.variables.variable import Variable

NO_CONTACTS = np.zeros(0, LOG_DTYPE)


class Instance:
    """An initialized instance and the kernel that works on it.

    Attributes:
        prepared_scene: the prepared scene.
        record: the data of the instance.
        words: a view of the whole record as numbers, one for each word.
        changes: the changes between sticking and sliding since the start, as far as ``collect`` has read
            them.
    """

    def __init__(
        self,
        source: Scene | PreparedScene,
        schedule: InputSchedule | None = None,
        parameters: Sequence[Variable] | None = None,
    ) -> None:
        """Load or compile the kernel; set the instance to its start, with the first values of the inputs.

        The derivatives are those with respect to ``parameters``; None stands for those in
        ``outputs.sensitivities`` of the scene.

        Raises:
            SimulationError: when the scene cannot start.
            BuildError: when the kernel cannot be compiled.
        """
        self.prepared_scene = as_prepared(source)
        parameters = self.prepared_scene.differentiated if parameters is None else parameters
        self._use(self.prepared_scene.new_instance(parameters))
        self._log_at = log_words(self.prepared_scene.counts)
        if schedule:
            schedule.set(self.record, 0)
        scope = self.prepared_scene.kernel_scope
        self._kernel = kernel_for(self.prepared_scene.scene, derivatives=bool(parameters), scope=scope)
        self.initialize()

    def _use(self, memory: np.ndarray) -> None:
        """Use an array of one record as the memory of the instance."""
        self._memory, self.record, self._address = memory, memory[0], memory.ctypes.data
        self.words = np.ndarray(memory.nbytes // WORD, np.float64, memory)
        self._integers = self.words.view(np.int64)

    def initialize(self) -> None:
        """Set the instance to its start, t = 0, with the parameters, initial values and inputs in its record.

        Raises:
            SimulationError: when the scene cannot start.
        """
        self.changes: list[np.ndarray] = []
        if self._kernel.initialize(self._address, 0.0) != OK:
            raise SimulationError(self.status, 0.0, None, self.part, self.prepared_scene.scene.name)

    def observe(self) -> int:
        """Compute the outputs of the record at the present time; return the status."""
        if not self.record["given"]["pending"]:
            status: int = self._kernel.observe_now(self._address)
            return status
        # outputs are computed in a copy, because reading them must not change the run
        copied_memory = self._memory.copy()
        status = self._kernel.observe_now(copied_memory.ctypes.data)
        self.record["fault"], self.record["output"] = copied_memory[0]["fault"], copied_memory[0]["output"]
        for part, field in DERIVED_DURING_RUN:
            self.record[part][field] = copied_memory[0][part][field]
        if self.record["tangent_count"]:
            self._memory[0][TANGENTS]["output"] = copied_memory[0][TANGENTS]["output"]
        return status

    def is_sound(self, words: np.ndarray) -> bool:
        """Return whether the words of a record are a valid record for this kernel."""
        # a record with other counts would make the kernel read outside of its memory
        has_same_sizes = words[:HEAD_WORDS].tobytes() == self.words[:HEAD_WORDS].tobytes()
        return has_same_sizes and bool(self._kernel.is_sound(words.ctypes.data))

    def advance(self, time: float) -> int:
        """Advance to a time [s], which must not be before the present time, and return the status."""
        status: int = PAUSED
        while status == PAUSED:  # the kernel pauses now and then, so that Python notices Ctrl-C
            status = self._kernel.advance_awhile(self._address, time)
        return status

    def trajectory(
        self, times: np.ndarray, rows: np.ndarray, spans: np.ndarray | None = None, *, of_state: bool = False
    ) -> int:
        """Advance to each of the times [s] and fill a row at each; return the number of filled rows.

        Fewer rows than times are filled after a fault, if the log of contacts or that of dry friction is
        full, or after about a second of computing.

        Args:
            times: shape (T,).
            rows: result, T rows of W numbers.
            spans: the indices of a row's numbers in the record, see ``spans_of``; None for all outputs.
            of_state: as for ``WordRows``; if true, the kernel computes no other outputs.
        """
        spans = spans_of(self.prepared_scene.output_words) if spans is None else spans
        span_arguments, row_arguments = (
            (spans.ctypes.data, len(spans)),
            (rows.ctypes.data, rows.strides[0] // WORD),
        )
        count: int = self._kernel.trajectory(
            self._address, times.ctypes.data, len(times), *span_arguments, *row_arguments, of_state
        )
        return count

    def run(
        self, schedule: InputSchedule, rows: Rows, progress: Progress = no_progress
    ) -> tuple[int, list[np.ndarray]]:
        """Fill rows at all communication points of a run.

        Returns the number of filled rows, which a fault makes smaller, and the contacts that have ended.
        """
        finished_rows, impacts, last = 0, [], len(schedule.times)
        ends = np.append(schedule.first_row[1:], last) if schedule.paths else None
        while finished_rows < last and self.status == OK:
            # no call of ``rows.write`` goes beyond a piece of the inputs, because each piece has other inputs
            end_row = last if ends is None else ends[np.searchsorted(ends, finished_rows, side="right")]
            end = min(finished_rows + rows.chunk, end_row)
            schedule.set(self.record, finished_rows)
            finished_rows += rows.write(self, schedule.times[finished_rows:end], finished_rows)
            impacts.append(self.collect())
            progress(finished_rows / last)
        return finished_rows, impacts

    def collect(self) -> np.ndarray:
        """Return the contacts that have ended since the last call.

        Also add the new changes between sticking and sliding to ``changes``.
        """
        log, numbers = self._log_at, self._integers
        if numbers[log.friction_changes]:
            self.changes.append(self._take_changes())
        ended_count = self._ended_contacts
        numbers[log.collected] = numbers[log.ended]
        return self._impacts(ended_count)

    @property
    def _ended_contacts(self) -> np.ndarray:
        """The numbers, from 0, of the contacts that have ended since ``collect`` was last called.

        If the log has no room for all of these and for the contacts that last, those that ended first are
        left out.
        """
        log, number = self._log_at, self._integers.item
        ended_count = number(log.ended)
        return np.arange(max(number(log.collected), ended_count + number(log.active) - log.room), ended_count)

    @property
    def all_changes(self) -> np.ndarray:
        """The changes of mode of dry friction collected since the start of the run, see ``CHANGE_DTYPE``."""
        return np.concatenate([np.zeros(0, CHANGE_DTYPE), *self.changes])

    def _take_changes(self) -> np.ndarray:
        """Return the changes of mode of dry friction that the log has, and empty the log."""
        log = self.record["friction_changes"]
        count, room = int(log["count"]), len(log["time"])
        # if the log is full before it is read, its oldest changes are lost
        slots = np.arange(max(0, count - room), count) % max(1, room)
        rows = np.zeros(len(slots), CHANGE_DTYPE)
        for name in CHANGE_DTYPE.names or ():
            rows[name] = log[name][slots]
        log["count"] = 0
        return rows

    def open_contacts(self) -> np.ndarray:
        """Return the contacts that still last, with their values up to the present time.

        The call ends the solver's last step at the present time: motion computed beyond this time is dropped.
        """
        self._kernel.log_contacts(self._address)
        return self._impacts(self._lasting_contacts)

    @property
    def _lasting_contacts(self) -> np.ndarray:
        """The numbers of the contacts that still last; they follow those of the ended contacts in the log."""
        ended_count = self._integers.item(self._log_at.ended)
        return np.arange(ended_count, ended_count + self._integers.item(self._log_at.active))

    def _impacts(self, numbers: np.ndarray) -> np.ndarray:
        """Return the contacts with ``numbers``; impulses and joint forces that are not computed are NaN."""
        if not len(numbers):
            return NO_CONTACTS
        log, columns = self._log_at, len(LOG_DTYPE.names or ())
        # the log has the columns of LOG_DTYPE one after the other; the first follows the last row
        table = self.words[log.first : log.first + columns * log.room].reshape(columns, log.room)
        impacts = table.T.take(numbers, 0, mode="wrap")
        rows = np.ndarray(len(impacts), LOG_DTYPE, impacts)
        if not self._integers.item(log.integrates):
            rows["impulse"] = np.nan
        if not self.prepared_scene.counts.transmitted_row_count:
            rows["joint_force"] = np.nan
        return rows

    @property
    def status(self) -> int:
        """The status code of the run; 0 if there is no fault."""
        return self._integers.item(self._log_at.status)

    @property
    def part(self) -> str:
        """Words for the part of the scene that causes a fault, such as a point and a wall.

        The result is "" without a fault, and if no single part causes the fault.
        """
        number = int(self.record["fault"]["part"])
        return part_texts(self.prepared_scene.scene)[number - 1] if number else ""

    @property
    def contradictions(self) -> list[str]:
        """A list with one sentence if the positions given for a motion contradict its velocity; else []."""
        channels = self.record["channel"]
        channel = int(channels["contradiction"])
        names = {variable.record_path: variable.name for variable in self.prepared_scene.inputs}
        name = names.get((GIVEN_CHANNEL, "position", channel - 1))
        if not name:
            return []
        distance, duration, velocity = (
            channels[f"contradiction_{quantity}"] for quantity in ("distance", "duration", "velocity")
        )
        motion_text = f"{name} has been moved by {distance:.9g} m in {duration:.9g} s"
        return [f"{motion_text}, which contradicts its velocity of {velocity:.9g} m/s: give both"]

    @property
    def time(self) -> float:
        """The time [s] that the run has reached."""
        return float(self.record["step"]["communication_point"])

    @property
    def statistics(self) -> dict[str, int]:
        """Name → number: the solver's counts and its status."""
        counts = self.record["statistics"]
        return dict(zip(counts.dtype.names, counts.item(), strict=True))

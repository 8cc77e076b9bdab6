"""The job of a sweep: the data that all runs share, and the simulation of many runs in the kernel.

Each run starts from the scene's instance record, with its own varied values written into it. So a varied
parameter acts as if it had been set in the FMU: the kernel computes all quantities that depend on it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass

import numpy as np

from chain_impact.compilation.errors import BuildError
from chain_impact.kernel.status import OK
from chain_impact.progress import log
from chain_impact.scene.candidates import candidates_of, stop_pairs
from chain_impact.scene.errors import SceneError, UnknownNameError
from chain_impact.scene.scene import Scene
from chain_impact.scene.texts.names import SENSITIVITY, DataPath
from chain_impact.simulation.kernels import counts_and_flags, kernel_for
from chain_impact.study_data.sweep.runs import END_COLUMN, STATUS
from chain_impact.study_data.sweep.variation import Variation
from chain_impact.variables.indices import word_index
from chain_impact.variables.peaks import JOINT_FORCE, PEAKS
from chain_impact.variables.prepared import PreparedScene, as_prepared
from chain_impact.variables.scene_variables import TANGENTS
from chain_impact.variables.selection import missing_output_hint
from chain_impact.variables.variable import Variable


@dataclass(frozen=True)
class Job:
    """The data that all runs of a sweep share.

    Attributes:
        prepared_scene: the prepared scene; the runs differ from this scene only in the values that vary.
        varied_paths: the path of each varied parameter in the instance record; an empty path stands for the
            stop time.
        types: the type of each varied parameter: ``real`` or ``enumeration``.
        outputs: names of the additional outputs, whose values at the end of each run are columns.
    """

    prepared_scene: PreparedScene
    varied_paths: tuple[DataPath, ...]
    types: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The scene, which has the values of all parameters that do not vary."""
        return self.prepared_scene.scene

    @property
    def peaks(self) -> dict[str, DataPath]:
        """The columns with the largest value of a quantity during a run: name → path in the record."""
        has_stops = bool(self.scene.chain.stops)
        return {name: peak.path for name, peak in PEAKS.items() if has_stops or not peak.at_stops}

    @property
    def rigid_hit_paths(self) -> dict[str, list[DataPath]]:
        """The columns of peak forces and moments: name → paths in the record that tell of rigid impacts.

        The first path leads to a flag: 1 if the column's walls or stops are rigid. Each other path belongs to
        a candidate at one of these, and leads to the number of its latest onset, 0 before the first onset.
        """
        joints, pair_paths = stop_pairs(self.scene), dict[str, list[DataPath]]()
        for c, pair in enumerate(candidates_of(self.scene)):
            name = "stop.peak_moment" if pair in joints else "peak_force"
            pair_paths.setdefault(name, [("law", c, "rigid")]).append(("contacts", "impact_number", c))
        return pair_paths

    @property
    def columns(self) -> dict[str, Variable]:
        """The columns with the value of an output of the FMU at the end of each run: name → output."""
        outputs = self.prepared_scene.outputs_by_name
        standard = [name for name in outputs if outputs[name].kind.parts.owner in ("energy", "solver")]
        wanted_columns = dict.fromkeys(["impact.count", *standard, *self.outputs])
        return {name: outputs[name] for name in wanted_columns}

    @property
    def differentiated(self) -> list[Variable]:
        """The parameters and inputs with respect to which the runs compute derivatives.

        If a column is a derivative, the list has all that the scene asks for; otherwise the list is empty.
        """
        asks_sensitivities = any(name.startswith(SENSITIVITY) for name in self.columns)
        return self.prepared_scene.differentiated if asks_sensitivities else []

    @property
    def joint_peaks(self) -> dict[str, Variable]:
        """Name → output with the largest force in each joint; empty if the scene asks for no loads.

        The column ``joint_force`` has the largest of these forces.
        """
        outputs = self.prepared_scene.outputs_by_name
        names = (f"joint[{n}].peak_force" for n in range(1, len(self.scene.chain.links) + 1))
        return {name: outputs[name] for name in names if name in outputs}

    @property
    def largest_columns(self) -> tuple[str, ...]:
        """The columns with the largest values of a run: the peaks and, with loads, JOINT_FORCE."""
        return (*self.peaks, *((JOINT_FORCE,) if self.joint_peaks else ()))

    @property
    def dtype(self) -> np.dtype:
        """The NumPy type of a run's row of results.

        The fields are ``largest_columns``, ``time``, and ``columns``.
        """
        kinds = {"integer": np.int64, "real": np.float64}
        columns = [(name, kinds[variable.type]) for name, variable in self.columns.items()]
        return np.dtype([*((name, np.float64) for name in (*self.largest_columns, END_COLUMN)), *columns])


def job_of(source: Scene | PreparedScene, variations: Sequence[Variation], outputs: Sequence[str]) -> Job:
    """Return the job of a sweep, after a check of the additional outputs.

    Raises:
        UnknownNameError: when an output does not exist.
        SceneError: when the scene does not have the solver's status as an output.
    """
    prepared_scene = as_prepared(source)
    available_outputs = prepared_scene.outputs_by_name
    for name in outputs:
        if not (isinstance(name, str) and name in available_outputs):
            raise UnknownNameError(
                prepared_scene.scene.name,
                name,
                available_outputs,
                "not an output",
                missing_output_hint(prepared_scene, str(name)),
            )
    if STATUS not in available_outputs:
        name = prepared_scene.scene.name
        raise SceneError(f"{name}: outputs.solver = false must be true: each run has its status")
    variables = [variation.variable for variation in variations]
    return Job(
        prepared_scene,
        tuple(variable.set_path for variable in variables),
        tuple(variable.type for variable in variables),
        tuple(dict.fromkeys(outputs)),
    )


def has_own_kernel(job: Job) -> bool:
    """Return whether there is a kernel for exactly the counts of the scene, which is compiled if necessary.

    Runs do not need this kernel, so a failure of the compiler only causes a warning. With derivatives the
    result is False, because runs with derivatives have one kernel for all scenes.
    """
    if job.differentiated:
        return False
    try:
        Runner(job, own_kernel=True)
    except BuildError as error:
        name = job.scene.name
        log.warning("%s: no kernel for its counts, so the sweep takes longer: %s", name, error)
        return False
    return True


class Runner:
    """Simulates many runs of a job in the kernel, one after the other in one thread, with one instance."""

    def __init__(self, job: Job, *, own_kernel: bool = False) -> None:
        """Load the kernel, or compile it.

        Args:
            job: the job of the runs.
            own_kernel: whether the kernel is for exactly the counts of the scene, which gives the same bits
                in less time; not used for runs with derivatives.

        Raises:
            BuildError: when the kernel cannot be compiled.
        """
        parameters = job.differentiated
        self._instance = job.prepared_scene.new_instance(parameters)
        scope = counts_and_flags(self._instance) if own_kernel and not parameters else None
        self._kernel = kernel_for(job.scene, derivatives=bool(parameters), scope=scope)
        layout, self._job, self._dtype = self._instance.dtype, job, job.dtype
        self._columns, self._joint_peaks = job.columns, job.joint_peaks
        read_parts = {
            part
            for column in (*self._columns.values(), *self._joint_peaks.values())
            for part in column.record_path
        }
        # Lists of impacts, and integrals over time such as the impulse at a wall, take time. If no column
        # needs the lists, none is written, and integrals are computed only if a column needs one of them.
        if "latest" not in read_parts:
            self._instance["latest"]["requested_count"] = 0
            self._instance["quadrature"]["computed"] = bool(
                read_parts & {"impulse", "friction", "transmitted"}
            )
        in_record = [k for k, path in enumerate(job.varied_paths) if path]
        self._in_record, self._is_choice = in_record, [job.types[k] == "enumeration" for k in in_record]
        self._varied_indices = np.array(
            [word_index(layout, job.varied_paths[k]) for k in in_record], np.int64
        )
        paths = [
            *job.peaks.values(),
            ("step", "communication_point"),
            *(variable.record_path for variable in self._columns.values()),
            *(variable.record_path for variable in self._joint_peaks.values()),
            *(path for hit_paths in job.rigid_hit_paths.values() for path in hit_paths),
        ]
        kept_fields = [(name, self._dtype[name]) for name in self._dtype.names or () if name != JOINT_FORCE]
        joint_peaks = [(f"joint_peak[{joint}]", np.dtype(float)) for joint in range(len(self._joint_peaks))]
        rigid_hits = [
            (f"rigid hits of {name}", np.dtype(np.int64), (len(hit_paths),))
            for name, hit_paths in job.rigid_hit_paths.items()
        ]
        self._rigid_columns = list(job.rigid_hit_paths)
        self._row_type = np.dtype([*kept_fields, *joint_peaks, *rigid_hits])
        self._output_indices = np.array([word_index(layout, path) for path in paths], np.int64)

    def run(self, values: np.ndarray, is_wanted: Callable[[], bool] = lambda: True) -> np.ndarray:
        """Simulate R runs, and return their rows of results, shape (R,).

        Args:
            values: the values of the K varied parameters in each run, shape (R, K).
            is_wanted: function that is called about once a second; it returns whether to continue.

        Raises:
            CancelledError: when ``is_wanted`` returns False.
        """
        record_values = np.ascontiguousarray(values[:, self._in_record], np.float64)
        for k, is_choice in enumerate(self._is_choice):
            if is_choice:
                record_values[:, k] = record_values[:, k].astype(np.int64).view(np.float64)
        stop_times = np.full(len(values), self._job.scene.simulation.stop_time)
        if () in self._job.varied_paths:
            stop_times = np.ascontiguousarray(values[:, self._job.varied_paths.index(())], np.float64)
        rows = np.zeros(len(values), self._row_type)
        finished_count, continuing = 0, 0
        while finished_count < len(rows):
            if not is_wanted():
                raise CancelledError
            finished_count += self._kernel.run_each(
                self._instance.ctypes.data,
                self._varied_indices.ctypes.data,
                len(self._varied_indices),
                record_values[finished_count:].ctypes.data,
                stop_times[finished_count:].ctypes.data,
                len(rows) - finished_count,
                self._output_indices.ctypes.data,
                len(self._output_indices),
                rows[finished_count:].ctypes.data,
                continuing,
            )
            continuing = 1
        # after a fault, the kernel may return the end of the last step, which can lie after the stop time
        rows["time"] = np.minimum(rows["time"], stop_times)
        return self._table_rows(rows)

    def _table_rows(self, kernel_rows: np.ndarray) -> np.ndarray:
        """Return the rows of the table, of the type ``Job.dtype``, from the kernel's rows.

        A kernel's row ends with the largest force in each joint, of which the table has the largest, and with
        the values at the paths of ``Job.rigid_hit_paths``. The values at these paths tell in which runs a
        peak is NaN, because a rigid wall or stop was hit.
        """
        rows = np.zeros(len(kernel_rows), self._dtype)
        for name in rows.dtype.names or ():
            rows[name] = kernel_rows[name] if name != JOINT_FORCE else 0.0
        for joint in range(len(self._joint_peaks)):
            np.maximum(rows[JOINT_FORCE], kernel_rows[f"joint_peak[{joint}]"], out=rows[JOINT_FORCE])
        for name in self._rigid_columns:
            flag, *onsets = kernel_rows[f"rigid hits of {name}"].T
            # an impulse has no peak force, and a force with which a rigid wall holds the point afterwards is
            # not the peak force of an impact
            rows[name][(flag == 1) & np.any(onsets, axis=0)] = np.nan
        self._forget_unknown(rows)
        return rows

    def _forget_unknown(self, rows: np.ndarray) -> None:
        """Set the results that a run does not have after a fault to NaN.

        These are the largest values of the run, energies, other outputs of the motion, and derivatives.
        Outputs of the impacts before the fault and of the solver stay.
        """
        is_failed = rows[STATUS] != OK
        outputs = [
            name
            for name, variable in self._columns.items()
            if variable.record_path[0] in {"output", TANGENTS}
        ]
        for name in (*self._job.largest_columns, *outputs):
            rows[name][is_failed] = np.nan

"""Simulate a scene in this process, with the compiled kernel that its FMU would carry."""

from __future__ import annotations

import ctypes
import functools
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from chain_impact.compilation import cache
from chain_impact.compilation.library import kernel_library
from chain_impact.compilation.work import Notify, announce
from chain_impact.instance import new_instance
from chain_impact.kernel.status import OK, PAUSED, STATUS_TEXT
from chain_impact.law_file import LawError, source_of
from chain_impact.reading import SceneError
from chain_impact.scene import Scene, with_values
from chain_impact.signals import Drive, Signal, drive

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
    ]
)
"""One contact: point 0…N; wall as index into ``scene.wall_names``; onset and end [s]; impact and separation
speed [m/s]; peak force [N]; largest penetration [m]; effective mass at onset [kg]. The end and the separation
speed of a contact that lasts to the end of the simulation are NaN. Under the law ``newton_impact`` a bounce
has no duration and an infinite peak force; that of a contact that lasts is the largest force that held it."""


class SimulationError(RuntimeError):
    """The solver could not go on.

    Attributes:
        status: the code, see ``chain_impact.kernel.status``.
        time: where it stopped [s].
        result: the ``Result`` up to there.
    """

    def __init__(self, status: int, time: float, result: Result | None) -> None:
        """Say what happened and when."""
        super().__init__(f"the simulation stopped at t = {time:.9g} s: {STATUS_TEXT[status]}")
        self.status, self.time, self.result = status, time, result

    def __reduce__(self) -> tuple[type[SimulationError], tuple[int, float, Result | None]]:
        """So that it can come back from another process."""
        return type(self), (self.status, self.time, self.result)


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


def simulate(
    scene: Scene,
    stop_time: float | None = None,
    output_step: float | None = None,
    method: str | None = None,
    tolerance: float | None = None,
    *,
    inputs: Mapping[str, Signal] | None = None,
    interpolation: Literal["hold", "linear"] = "hold",
    notify: Notify = announce,
    progress: Callable[[float], None] = lambda _: None,
) -> Result:
    """Simulate a scene from t = 0.

    Inputs are constant between two communication points, as those of the FMU are. Communication points are
    the rows of the result and, between them, the times of samples.

    - ``hold``: a function is called at each communication point, and its value acts until the next. A sample
      acts from its time on, so that a signal of steps is followed exactly, whatever the output step.
    - ``linear``: between samples, and between a function's values at communication points, the signal is a
      line, of which its mean acts from each communication point to the next. The impulse is exact; the
      motion has an error that falls with the square of the distance of communication points.

    The first sample acts before its time, too, and the last one until the end. A row of the result has the
    accelerations and forces that the inputs until then cause, as an importer sees them that reads the FMU
    after each step. Functions are called before the simulation begins, in order of time: they cannot depend
    on its state. For a controller, connect one to the FMU.

    Args:
        scene: what to simulate.
        stop_time: end [s]; the scene's by default.
        output_step: distance of the rows of the result [s]; the scene's communication step by default. It
            changes neither the solution nor its cost, but for inputs that are functions or lines.
        method: solver method instead of the scene's.
        tolerance: relative tolerance instead of the scene's.
        inputs: name of an input of the scene's FMU, as ``joint[2].torque`` [N·m] or ``tip.force.x`` [N] →
            a number, a function of the time [s], or a pair (times [s], values), each of shape (T,), times
            increasing. An input that is not named is zero.
        interpolation: of inputs between samples and communication points.
        notify: called with a sentence before a kernel is compiled; by default that is said on standard error.
        progress: called with the fraction done.

    Raises:
        SceneError: when one of the arguments is outside its range.
        SimulationError: when the solver cannot go on; it holds the result up to there.
        BuildError: when the kernel cannot be compiled.
    """
    settings: dict[tuple[str | int, ...], float | str | None] = {
        ("simulation", "stop_time"): stop_time,
        ("simulation", "step_size"): output_step,
        ("solver", "method"): method,
        ("solver", "tolerance"): tolerance,
    }
    changes = {path: value for path, value in settings.items() if value is not None}
    scene = with_values(scene, changes) if changes else scene
    # n steps and, if the stop time is no multiple of the step, a shorter one
    step, stop = scene.simulation.step_size, scene.simulation.stop_time
    times = np.append(np.arange(np.ceil(stop / step * (1 - 1e-12))) * step, stop)
    driven = drive(scene, inputs or {}, interpolation, times)
    instance = Instance(scene, notify, driven)
    outputs = np.zeros(len(driven.times), instance.record.dtype["output"])
    done, impacts, ends = 0, [], driven.changes
    while done < len(outputs) and instance.status == OK:
        # in chunks, for the progress bar's sake, in which the inputs are constant
        end = min(done + 5000, ends[np.searchsorted(ends, done, side="right")])
        driven.set(instance.record["inputs"], done)
        done += instance.trajectory(driven.times[done:end], outputs[done:end])
        impacts.append(instance.collect())
        progress(done / len(outputs))
    impacts.append(instance.open_contacts())
    asked = driven.asked[:done]
    result = Result(
        scene=scene,
        time=driven.times[:done][asked],
        outputs=outputs[:done][asked],
        impacts=np.sort(np.concatenate(impacts), order=["onset", "point", "wall"]),
        statistics=instance.statistics,
    )
    if instance.status != OK:
        raise SimulationError(instance.status, instance.time, result)
    return result


def with_law(scene: Scene, law: Callable[..., float]) -> Scene:
    """Return the scene with a Python function as its contact law.

    Args:
        scene: the scene.
        law: a function that returns the force [N], as in a ``contact.law_file``. Its source, which has to be
            known, is kept as a file in the cache folder. It knows the module ``math`` and nothing else that
            is defined outside it.

    Raises:
        SceneError: when it cannot be a law.
    """
    try:
        source = source_of(law)
    except LawError as error:
        raise SceneError(f"{scene.name}: the contact law {law!r} {error}") from None

    def write(folder: Path) -> None:
        folder.mkdir()
        (folder / f"{law.__name__}.py").write_text(source, encoding="utf-8")

    digest = hashlib.sha256(source.encode()).hexdigest()[:16]
    file = cache.made(f"law-{digest}", write) / f"{law.__name__}.py"
    return with_values(scene, {("contact", "law_file"): str(file), ("contact", "model"): law.__name__})


class Instance:
    """An initialized instance and the kernel that works on it."""

    def __init__(self, scene: Scene, notify: Notify = announce, driven: Drive | None = None) -> None:
        """Load or compile the kernel and set the instance to its start, with the first of the inputs, if any.

        Raises:
            SimulationError: when the scene cannot start.
        """
        self._block = new_instance(scene)
        self.record = self._block[0]
        if driven:
            driven.set(self.record["inputs"], 0)
        links, law_file = len(scene.chain.links), scene.contact.law_file
        library = kernel_library(links, notify=notify, law_file=law_file)
        self._kernel = load_kernel(library)
        self._address = self._block.ctypes.data
        if self._kernel.initialize(self._address, 0.0) != OK:
            raise SimulationError(self.status, 0.0, None)

    def advance(self, time: float) -> int:
        """Advance to a time [s], not before the present one; return the status."""
        status: int = PAUSED
        while status == PAUSED:  # in between, Python looks after Ctrl-C
            status = self._kernel.advance_awhile(self._address, time)
        return status

    def trajectory(self, times: np.ndarray, outputs: np.ndarray) -> int:
        """Advance to each of the times [s], filling a row of outputs for each; return how many are filled."""
        rows: int = self._kernel.trajectory(self._address, times.ctypes.data, len(times), outputs.ctypes.data)
        return rows

    def collect(self) -> np.ndarray:
        """Take the finished contacts out of the log."""
        log = self.record["finished"]
        rows = _impact_rows(int(log["count"]), {name: log[name] for name in IMPACT_DTYPE.names or ()})
        log["count"] = 0
        return rows

    def open_contacts(self) -> np.ndarray:
        """The contacts that have not ended yet, with their peaks so far; drops what was solved ahead."""
        self._kernel.follow(self._address)
        touch, candidate = self.record["touch"], self.record["candidate"]
        active = touch["active"] == 1
        columns = {name: touch[name] for name in ("onset", "peak_force", "max_penetration", "effective_mass")}
        columns |= {"point": candidate["point"], "wall": candidate["wall"]}
        columns["impact_speed"] = touch["onset_speed"]
        columns |= {name: np.full(len(active), np.nan) for name in ("end", "separation_speed")}
        return _impact_rows(int(active.sum()), {name: column[active] for name, column in columns.items()})

    @property
    def status(self) -> int:
        """The status code, 0 when all is well."""
        return int(self.record["statistics"]["status"])

    @property
    def time(self) -> float:
        """The time reached [s]."""
        return float(self.record["step"]["time"])

    @property
    def statistics(self) -> dict[str, int]:
        """The solver's counts."""
        counts = self.record["statistics"]
        return {name: int(counts[name]) for name in counts.dtype.names or ()}


def _impact_rows(count: int, columns: dict[str, np.ndarray]) -> np.ndarray:
    rows = np.zeros(count, IMPACT_DTYPE)
    for name in IMPACT_DTYPE.names or ():
        rows[name] = columns[name][:count]
    return rows


@functools.cache
def load_kernel(library: Path) -> ctypes.CDLL:
    """Load a compiled kernel and declare its entry points (see kernel/entry.py)."""
    kernel = ctypes.CDLL(str(library))
    pointer, real = ctypes.c_void_p, ctypes.c_double
    kernel.initialize.argtypes = kernel.advance.argtypes = [pointer, real]
    kernel.advance_awhile.argtypes = [pointer, real]
    kernel.observe.argtypes = kernel.follow.argtypes = [pointer]
    kernel.trajectory.argtypes = [pointer, pointer, ctypes.c_int64, pointer]
    kernel.trajectory.restype = ctypes.c_int64
    return kernel

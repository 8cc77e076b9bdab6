"""Simulate a scene in this process, with the compiled kernel that its FMU would carry."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from chain_impact.compilation import cache
from chain_impact.compilation.work import Notify, announce
from chain_impact.kernel.status import OK
from chain_impact.law_file import LawError, source_of
from chain_impact.reading import SceneError
from chain_impact.results.result import Result
from chain_impact.running import Instance, SimulationError
from chain_impact.scene import Scene
from chain_impact.signals import Signal, drive


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
    settings = {
        "simulation.stop_time": stop_time,
        "simulation.step_size": output_step,
        "solver.method": method,
        "solver.tolerance": tolerance,
    }
    changes = {name: value for name, value in settings.items() if value is not None}
    scene = scene.with_values(changes) if changes else scene
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
    return scene.with_values({"contact.law_file": str(file), "contact.model": law.__name__})

"""Animations of recordings and scenes; a scene is simulated with dense rows near impacts for slow motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from chain_impact.pages.inline import InlinePage
from chain_impact.progress import Progress, no_progress
from chain_impact.recording.contact_times import contact_ends
from chain_impact.recording.curves import EARLIEST_SHARE, EARLY_TIMES, LONG_CONTACT
from chain_impact.recording.pacing import (
    CONTACT_SHARES,
    IMPACT_TIME,
    frame_rate,
    frame_times,
    impact_ends,
    slow_spans,
)
from chain_impact.recording.recording import Recording
from chain_impact.results.animation import FILM_SIZE, write_animation
from chain_impact.results.result import Result
from chain_impact.scene.scene import SceneSource, scene_of
from chain_impact.simulation.given_inputs import GivenInputs, Interpolation
from chain_impact.simulation.simulate import simulate

MOST_FILM_ROWS = 40_000


def animate(
    recording: Recording | SceneSource,
    path: Path | str | None = None,
    *,
    speed: float | None = None,
    impact_time: float = IMPACT_TIME,
    size: tuple[int, int] = FILM_SIZE,
    progress: Progress | None = None,
) -> InlinePage | None:
    """Write an animation, or show it in a notebook.

    Args:
        recording: a recording, such as a result, of which denser rows give better slow motion; or a scene or
            an argument of ``load_scene``, which ``record_slowly`` simulates.
        path: the file, whose suffix determines the kind: ``.html`` is a page for a browser that needs no
            other file, ``.gif`` and ``.mp4`` are films. Without a path the page is returned, for a notebook.
        speed: simulated seconds in a second on the screen, far from impacts; 1 by default. A film with slow
            motion gets a lower default if a sine that drives an input would otherwise have fewer than 8
            frames in a period, but the film then has at most about 1500 frames.
        impact_time: time on the screen [s] of an impact in slow motion at the speed 1; at another speed this
            time is divided by the speed. An impulse of a rigid wall takes a tenth of this time. With 0 the
            speed is constant.
        size: width and height of a film [pixels].
        progress: called with the finished fraction of the animation, 0 to 1, if given.

    Warns:
        SceneWarning: when a sine that drives an input is too fast for the frames of a film.

    Raises:
        AnimationError: when the suffix is unknown, a number is out of its range, the recording has fewer than
            two rows or no position of a point.
        MissingExtraError: when PyAV is not installed, for an mp4.
        SceneError, SimulationError: when the scene cannot be read, or the solver cannot continue.
        BuildError: when the kernel cannot be compiled.
        OSError: when the file cannot be written.
    """
    if not isinstance(recording, Recording):
        recording = record_slowly(recording, impact_time)
    options: dict[str, Any] = {"speed": speed, "impact_time": impact_time, "size": size}
    return write_animation(recording, path, **options, progress=progress)


def record_slowly(
    scene: SceneSource,
    impact_time: float = IMPACT_TIME,
    progress: Progress | None = None,
    *,
    inputs: GivenInputs | None = None,
    interpolation: Interpolation = "follow",
) -> Result:
    """Return the result of a scene, with dense rows near impacts, as slow motion needs them.

    The scene is simulated twice, the first time to find the impacts. The impacts in slow motion have dense
    rows and, up to about MOST_FILM_ROWS rows, so have the first of all other impacts. The rows do not change
    the solution: inputs act as in ``simulate``, with the communication step of the scene.

    Args:
        scene: a scene, or an argument of ``load_scene``.
        impact_time: as for ``animate`` [s].
        progress: called with the finished fraction, 0 to 1, if given.
        inputs: as for ``simulate``.
        interpolation: as for ``simulate``.

    Raises:
        SceneError: when the scene cannot be read, or an input is invalid.
        SimulationError: when the solver cannot continue; the error holds the result so far, with evenly
            spaced rows.
        BuildError: when the kernel cannot be compiled.
    """
    scene, show = scene_of(scene), progress or no_progress
    result = simulate(
        scene, inputs=inputs, interpolation=interpolation, progress=lambda share: show(share / 2)
    )
    stop, onsets = float(result.time[-1]), result.impacts["onset"]
    spans, usual_rate = slow_spans(result), frame_rate(result)
    shown_times, _ = frame_times(0.0, stop, spans, impact_time, MOST_FILM_ROWS, usual_rate=usual_rate)
    # an impact that is too weak for slow motion gets dense rows, too, because the usual rows could miss the
    # peak force of this impact
    durations = (impact_ends(result.impacts, stop) - onsets)[:, None]
    contact_times = (onsets[:, None] + durations * CONTACT_SHARES).ravel()[:MOST_FILM_ROWS]
    touch_durations = contact_ends(result) - onsets
    is_long = touch_durations > LONG_CONTACT * stop
    early_times = (
        onsets[is_long] + touch_durations[is_long] * np.geomspace(EARLIEST_SHARE, 1.0, EARLY_TIMES)[:, None]
    )
    contact_times = np.append(contact_times, early_times.ravel()[:MOST_FILM_ROWS])
    times = np.union1d(shown_times, contact_times.clip(0.0, stop))
    assert result.rerun is not None  # simulate() always gives it
    outputs = result.rerun(times, lambda share: show(0.5 + share / 2))
    times = times[: len(outputs)]
    return replace(
        result,
        time=times,
        outputs=outputs,
        stepwise={},
        sensitivities=None,
        input_values=result.rerun.inputs(times),
    )

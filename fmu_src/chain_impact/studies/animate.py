"""An animation of a recording, a result, or a scene."""

from __future__ import annotations

from pathlib import Path

from chain_impact.progress import Progress
from chain_impact.results import animation
from chain_impact.results.recording import Recording
from chain_impact.results.result import Result, recording_of
from chain_impact.scene.scene import SceneSource
from chain_impact.studies.slow_motion import record_slowly


def animate(
    recording: Recording | Result | SceneSource,
    path: Path | str,
    *,
    speed: float = 1.0,
    impact_time: float = animation.IMPACT_TIME,
    size: tuple[int, int] = animation.SIZE,
    progress: Progress | None = None,
) -> None:
    """Write an animation.

    Args:
        recording: what to show: a recording or a result, in which slow motion shows more where rows are close
            in time; or a scene, or what ``load_scene`` takes, which ``record_slowly`` simulates.
        path: the file, whose suffix says the kind: ``.html`` is a page that a browser opens and that needs no
            other file, ``.gif`` and ``.mp4`` are films.
        speed: simulated seconds in a second on the screen, but for impacts.
        impact_time: what each impact takes on the screen [s] at the speed 1: shortly before, the animation
            slows down. 0 shows all at one speed.
        size: width and height of a film [pixels].
        progress: called with the fraction done of a film, if given.

    Raises:
        AnimationError: when the suffix is unknown, a number is out of its range, or the recording has fewer
            than two rows or no position of a point.
        SceneError, SimulationError: when the scene cannot be read, or the solver cannot go on.
        MissingExtraError: when PyAV is not there, for an mp4: ``pip install 'chain-impact[video]'``.
        OSError: when the file cannot be written.
    """
    if isinstance(recording, Result):
        recording = recording_of(recording)
    elif not isinstance(recording, Recording):
        recording = record_slowly(recording, impact_time)
    animation.animate(recording, path, speed=speed, impact_time=impact_time, size=size, progress=progress)

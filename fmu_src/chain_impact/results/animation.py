"""Writes an animation of a recording as a file; the file's suffix says whether it is a page or a film."""

from __future__ import annotations

import math
import os
from pathlib import Path

from chain_impact.files import written_atomically
from chain_impact.pages.inline import InlinePage
from chain_impact.pages.recorded import recorded_page
from chain_impact.progress import Progress, no_progress
from chain_impact.recording.pacing import IMPACT_TIME
from chain_impact.recording.recording import Recording
from chain_impact.scene.errors import RefusalError

FORMATS = (".html", ".gif", ".mp4")
FILM_SIZE = (960, 540)  # [pixels] default width and height of a film
LEAST_SIDE, MOST_SIDE = 160, 4096  # [pixels] the range of the width and of the height of a film


class AnimationError(RefusalError):
    """Raised when an animation cannot be made; the message is one line."""


def write_animation(
    recording: Recording,
    path: str | os.PathLike[str] | None = None,
    *,
    speed: float | None = None,
    impact_time: float = IMPACT_TIME,
    size: tuple[int, int] = FILM_SIZE,
    progress: Progress | None = None,
) -> InlinePage | None:
    """Write an animation of a recording to a file; without ``path``, return the animation as a page.

    ``chain_impact.animate`` describes the arguments.
    """
    path, progress = None if path is None else Path(path), progress or no_progress
    kind = path.suffix.lower() if path else ".html"
    if kind not in FORMATS:
        raise AnimationError(f"{path}: the name must end in {', '.join(FORMATS)}")
    if speed is not None and not 0.0 < speed < math.inf:
        raise AnimationError("must be a finite number > 0", argument="speed", value=f"{speed:g}")
    if not 0.0 <= impact_time < math.inf:
        requirement = "must be a finite number >= 0 [s]"
        raise AnimationError(requirement, argument="impact_time", value=f"{impact_time:g}")
    if not all(LEAST_SIDE <= length <= MOST_SIDE for length in size):
        requirement = f": width and height must be {LEAST_SIDE} … {MOST_SIDE} [pixels]"
        raise AnimationError(requirement, argument="size", value=str(size))
    if len(recording.time) <= 1 or not recording.points.shape[1]:
        raise AnimationError(f"{recording.name}: an animation needs two rows at least, with point[0].x")
    if path is None:
        return InlinePage(recorded_page(recording, speed or 1.0, impact_time))
    with written_atomically(path) as new_file:
        if kind == ".html":
            new_file.write_text(recorded_page(recording, speed or 1.0, impact_time), encoding="utf-8")
        else:
            from chain_impact.pictures.film.writing import write_film

            write_film(
                recording, new_file, speed=speed, impact_time=impact_time, size=size, progress=progress
            )
    progress(1.0)
    return None

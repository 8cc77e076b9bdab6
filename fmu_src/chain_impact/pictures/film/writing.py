"""A film of a recording: matplotlib draws the frames."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from chain_impact.pictures.drawing.dark_ground import Ground
from chain_impact.pictures.film.file_formats import write_gif, write_mp4
from chain_impact.pictures.film.film import FILM_COLOURS, FILM_STYLE, Film
from chain_impact.pictures.film.film_layout import SIZE_WITH_CHARTS
from chain_impact.progress import Progress
from chain_impact.recording.pacing import fastest_sine, frame_times, slow_spans
from chain_impact.recording.recording import Recording
from chain_impact.scene.warning import warn

# [1/s] frames per second for each suffix; a gif stores the time of a frame in hundredths of a second
RATES = {".gif": 20, ".mp4": 30}
# the least number of frames in a period of the fastest sine that drives an input; with fewer frames the
# motion may look slower than it is
FRAMES_OF_SINE = 8.0
# If the user gives no speed, a film with slow motion is slowed down to show a fast sine, but only until the
# film has MOST_SLOWED_FRAMES frames, because more frames take minutes to draw.
MOST_SLOWED_FRAMES = 1500
# Pixels per inch. LEAST_DPI: the least number in a film with charts; SMALL_DPI: the number in a film that is
# too small for charts.
LEAST_DPI, SMALL_DPI = 60, 80


def write_film(
    recording: Recording,
    path: Path,
    *,
    speed: float | None,
    impact_time: float,
    size: tuple[int, int],
    progress: Progress,
) -> None:
    """Write a film of a recording, a gif or an mp4 according to the suffix of ``path``.

    Args:
        recording: the recording to show.
        path: the file.
        speed: simulated seconds per second on the screen, outside of slow motion; if it is None,
            ``pace`` chooses the speed.
        impact_time: the time [s] to which slow motion stretches a shorter impact on the screen if the speed
            is 1; 0 for a film without slow motion.
        size: width and height [pixels]; an odd number is reduced by 1, because an mp4 needs even numbers.
        progress: called with the finished fraction, 0 to 1.

    Warns:
        SceneWarning: when a sine that drives an input is too fast for the frames.

    Raises:
        MissingExtraError: when PyAV is not installed, for an mp4.
    """
    rate, (width, height) = RATES[path.suffix.lower()], (length // 2 * 2 for length in size)
    start, end = (float(recording.time[row]) for row in (0, -1))
    times, usual_speed = frame_times(start, end, slow_spans(recording), impact_time)
    frames = (len(times) - 1) * rate / usual_speed  # the number of frames if ``speed`` is 1
    speed = pace(recording, speed, rate, frames / MOST_SLOWED_FRAMES if impact_time > 0.0 else 1.0)
    count = 1 + int(np.ceil(frames / speed))
    shown_times = np.interp(np.linspace(0, len(times) - 1, count), np.arange(len(times)), times)
    rates = np.interp(shown_times, times, np.gradient(times) * usual_speed * speed)
    pictures = draw_frames(recording, shown_times, rates, (width, height), progress)
    if path.suffix.lower() == ".gif":
        ground = Ground.current()
        colours = [ground.suited_colour(colour) for colour in FILM_COLOURS] if ground else FILM_COLOURS
        write_gif(pictures, path, rate, colours, ground.ground if ground else "white")
    else:
        write_mp4(pictures, path, rate, (width, height))


def pace(recording: Recording, speed: float | None, rate: int, slowest_speed: float) -> float:
    """Return the speed of a film: simulated seconds per second on the screen, outside of slow motion.

    A SceneWarning is given if the returned speed is too high to show a sine that drives an input.

    Args:
        recording: the recording to show.
        speed: the speed that the user gives, which is returned. If it is None, the speed is 1 or, to show a
            fast sine that drives an input, a lower one, but at least ``slowest_speed``.
        rate: frames per second on the screen.
        slowest_speed: the least speed that is chosen for a sine; a number above 1 counts as 1.
    """
    fastest_frequency = fastest_sine(recording)
    sine_speed = rate / (FRAMES_OF_SINE * fastest_frequency) if fastest_frequency else np.inf
    if speed is None:
        speed = min(1.0, max(sine_speed, slowest_speed))
    if speed > sine_speed:
        count_text = f"{rate / (speed * fastest_frequency):.2g}"
        frames_text = f"only {count_text} frames in a period of its sine of {fastest_frequency:g} Hz"
        warn(
            recording.name,
            [f"the film has {frames_text}, which may look slow or still; speed = {sine_speed:.2g} shows it"],
        )
    return speed


def draw_frames(
    recording: Recording, times: np.ndarray, rates: np.ndarray, size: tuple[int, int], progress: Progress
) -> Iterator[np.ndarray]:
    """Draw the frames of a film, and yield each as red, green, blue of its pixels, shape (height, width, 3).

    Args:
        recording: the recording to show.
        times: the time of the recording that each frame shows, shape (F,) [s].
        rates: simulated seconds per second on the screen, at each frame, shape (F,).
        size: width and height [pixels].
        progress: called with the finished fraction, 0 to 1.
    """
    ground = Ground.current()
    with matplotlib.style.context(["default", FILM_STYLE]):
        dpi = resolution(size)
        figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
        canvas: Any = FigureCanvasAgg(figure)  # matplotlib has no type information for the canvas
        film = Film(figure, recording, times, ground)
        canvas.draw()
        # the ground contains the parts that do not move
        ground = canvas.copy_from_bbox(figure.bbox)
        for frame, rate in enumerate(rates.tolist()):
            canvas.restore_region(ground)
            for artist in film.show(frame, rate):
                figure.draw_artist(artist)
            yield np.asarray(canvas.buffer_rgba())[..., :3].copy()
            progress((frame + 1) / len(times))


def resolution(size: tuple[int, int]) -> float:
    """Return the pixels per inch of a film, at least LEAST_DPI: the more, the larger the film is.

    So the texts keep their size relative to the film. A film that is too small for charts at LEAST_DPI has
    SMALL_DPI. ``size``: width and height [pixels].
    """
    density = min(pixels / inches for pixels, inches in zip(size, SIZE_WITH_CHARTS, strict=True))
    return density if density >= LEAST_DPI else SMALL_DPI

"""The rate of a film: simulated seconds per second on the screen; it is smaller near impacts in slow motion.

The twin in JavaScript is pages/browser/recording/pacing.js.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.recording.recording import Recording
from chain_impact.scene.texts.names import grouped_by_owner

IMPACT_TIME = 0.6  # [s] default time on the screen for one impact
SPEED_RAMP = 0.05  # [s] simulated time in which a film slows down before an impact, or speeds up after it
# [s] the largest simulated time after an onset that is shown in slow motion; in a longer contact the chain
# mostly rests or leans
LONGEST_SLOW = 0.1
# [s] least duration that a film assumes for an impact, because an impulse of a rigid wall has none
LEAST_DURATION = 1e-4
# [1] an impact without a duration, such as that of a rigid wall, and the ramps before and after such an
# impact are shown for this fraction of the time of other impacts, because nothing moves during the impact
INSTANT = 0.1
# [1/s] frames per second on the screen; more if a sine needs them, fewer in a film with MOST_FRAMES
FRAME_RATE = 60.0
# least number of frames in a period of the fastest sine that drives an input; with fewer, the motion would
# look wrong
FRAMES_OF_A_PERIOD = 16.0
FLIGHT_STEP = 1 / 240  # [s] far from impacts, the rate is computed at simulated times with this distance
# [1] the rate is computed at these distances in time before and after an impact, relative to SPEED_RAMP
RAMP_DISTANCES = np.geomspace(1e-3, 1.0, 48)
# [1] within a contact, the rate is computed at these times after the onset, relative to the contact's
# duration
CONTACT_SHARES = np.linspace(0.0, 1.0, 25)
# [1] an impact is shown in slow motion only if its speed, relative to the fastest impact, is at least this
SLOW_SPEED = 0.05
SLOW_COUNT = 100  # largest number of impacts that are shown in slow motion: the fastest ones
# [1] in films and pages, an impact with the largest penetration δ and the impact speed v ends at the latest
# LONGEST_IMPACT times δ/v after the onset: in a longer contact the point counts as resting from then on
LONGEST_IMPACT = 5.0
# [m/s; rad/s at a stop of a joint] least speed v in δ/v: a point that rests at a wall from the start on has v
# = 0, and δ/v would be infinite
LEAST_SPEED = 1e-6
MOST_FRAMES = 20_000  # largest number of frames of a film; a longer film has fewer frames per second
TAIL = 0.3  # [s] simulated time in which the drawn trace of the tip fades
REAL = 0.05  # a rate is called real time if it differs from 1 by less than this
SLOW_RATE = 0.5  # pages and films show a rate below this in a stronger colour
TENS = 9.95  # a factor that is at least this is written without decimals

Span = tuple[float, float]


def impact_ends(impacts: np.ndarray, end_time: float) -> np.ndarray:
    """Return the times at which impacts end for a film, shape (I,) [s], at the latest at ``end_time`` [s].

    For a film, a contact ends at the latest a time LONGEST_IMPACT δ/v after its onset, also if it lasts to
    the end of the run; δ is the largest penetration, 0 if unknown, v the impact speed. An impact takes
    2.9 δ/v with Hertz's law, π δ/v with a linear spring, and longer with losses.
    """
    speeds = np.maximum(impacts["impact_speed"], LEAST_SPEED)
    longest_durations = LONGEST_IMPACT * np.nan_to_num(impacts["max_penetration"]) / speeds
    return np.asarray(np.fmin(impacts["end"], np.minimum(impacts["onset"] + longest_durations, end_time)))


def slow_spans(recording: Recording) -> list[Span]:
    """Return onset and end [s] (``impact_ends``) of each impact that is shown in slow motion."""
    impacts, speeds = recording.impacts, recording.linear_impact_speeds
    ends = impact_ends(impacts, float(recording.time[-1]))
    fastest_rows = np.argsort(-speeds, kind="stable")[:SLOW_COUNT]
    fastest_rows = fastest_rows[speeds[fastest_rows] >= SLOW_SPEED * speeds.max(initial=0.0)]
    return sorted(zip(impacts["onset"][fastest_rows].tolist(), ends[fastest_rows].tolist(), strict=True))


def rates_over_time(time: np.ndarray, spans: Sequence[Span], impact_time: float) -> np.ndarray:
    """Return the rate at each time, simulated seconds per second on the screen, shape (T,).

    The rate is 1 far from impacts. During an impact that is shorter than ``impact_time``, the rate is the
    duration of the impact divided by ``impact_time``, so that the impact takes ``impact_time`` on the screen.
    Before and after the impact, the rate grows linearly with the distance in time from the impact, by 1 in
    SPEED_RAMP [s], until it is 1. An impact without a duration has INSTANT times ``impact_time`` and
    SPEED_RAMP. An impact shorter than LEAST_DURATION counts as that long. Of several impacts, the one with
    the smallest rate counts.

    Args:
        time: simulated times, shape (T,) [s].
        spans: onset and end of each impact that is shown in slow motion [s].
        impact_time: the time [s] that each of these impacts takes on the screen.
    """
    slowest_speeds = np.ones_like(time)
    for onset, end in spans:
        share, last = 1.0 if end > onset else INSTANT, max(end, onset + LEAST_DURATION)
        speed_limit = min(1.0, (last - onset) / (share * impact_time))
        distance = np.maximum(0.0, np.maximum(onset - time, time - last))
        slowest_speeds = np.minimum(slowest_speeds, speed_limit + distance / (share * SPEED_RAMP))
    return slowest_speeds


def fastest_sine(recording: Recording) -> float:
    """Return the largest frequency [Hz] of the sines that drive inputs during the run; 0 without a sine."""
    end, highest_frequency = float(recording.time[-1]), 0.0
    for (owner, _, _), signal in grouped_by_owner(recording.parameters).items():
        if owner == "signal" and "frequency" in signal:
            begin, value = float(signal.get("start", 0.0)), float(signal["frequency"])
            if begin >= end or float(signal.get("amplitude", 1.0)) == 0.0:
                continue
            # f + ḟ s is the frequency at the time s after the signal's start: |f + ḟ s| is largest at s = 0
            # or at the end
            change = float(signal.get("frequency_rate", 0.0)) * (end - begin)
            highest_frequency = max(highest_frequency, abs(value), abs(value + change))
    return highest_frequency


def frame_rate(recording: Recording) -> float:
    """Return the frames per second of a page: FRAME_RATE, or more to show the fastest sine of an input."""
    return max(FRAME_RATE, FRAMES_OF_A_PERIOD * fastest_sine(recording))


def frame_times(
    start: float,
    end_time: float,
    spans: Sequence[Span],
    impact_time: float = IMPACT_TIME,
    most_frames: int = MOST_FRAMES,
    *,
    usual_rate: float = FRAME_RATE,
) -> tuple[np.ndarray, float]:
    """Return the simulated times of a film's frames, and the frames per second on the screen.

    Successive frames have equal distances in time on the screen.

    Args:
        start: the start of the simulation [s].
        end_time: the end of the simulation [s].
        spans: onset and end of each impact that is shown in slow motion [s].
        impact_time: the time [s] that each of these impacts, at most its first LONGEST_SLOW, takes on the
            screen (``rate``); 0 if no impact is shown in slow motion.
        most_frames: the largest number of frames; a film that would have more has fewer frames per second
            than ``usual_rate``.
        usual_rate: the frames per second, except for rounding up, of a film with fewer frames than
            ``most_frames``.

    Returns:
        The times, shape (F,) [s], from ``start`` to ``end_time``, and the frames per second on the screen.
    """
    spans = spans if impact_time > 0.0 else []
    shown_spans = [(a, min(b, a + LONGEST_SLOW)) for a, b in spans]
    parts = [np.linspace(start, end_time, 2 + min(int((end_time - start) / FLIGHT_STEP), 2 * most_frames))]
    ramp_length = SPEED_RAMP * RAMP_DISTANCES
    for onset, end in ((a, max(b, a + LEAST_DURATION)) for a, b in shown_spans):
        parts += [onset - ramp_length, onset + (end - onset) * CONTACT_SHARES, end + ramp_length]
    grid = np.unique(np.concatenate(parts).clip(start, end_time))
    slowness = 1.0 / rates_over_time(grid, shown_spans, impact_time)
    # the time on the screen is the integral of 1/rate over the simulated time, by the trapezoidal rule
    screen = np.concatenate([[0.0], np.cumsum(np.diff(grid) * (slowness[1:] + slowness[:-1]) / 2)])
    frames = min(most_frames, 2 + int(screen[-1] * usual_rate))
    return np.interp(np.linspace(0.0, screen[-1], frames), screen, grid), (frames - 1) / screen[-1]


def rate_text(rate: float) -> str:
    """Return words for a film's rate relative to real time, for example: 480 × slower."""
    if abs(rate - 1.0) < REAL:
        return "real time"
    times, word = (1.0 / rate, "slower") if rate < 1.0 else (rate, "faster")
    number_text = f"{times:.1f}".removesuffix(".0") if times < TENS else f"{float(f'{times:.2g}'):.0f}"
    return "real time" if number_text == "1" else f"{number_text} × {word}"

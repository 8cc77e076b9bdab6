"""The rate of a film: simulated seconds per second on the screen; it is smaller during impacts.

``pages/browser/recording/pacing.js`` computes the same rate for pages, with the constants of this module.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.recording.recording import Recording
from chain_impact.scene.names import by_owner

IMPACT_TIME = 0.6  # [s] the default time on the screen for one impact
RAMP = 0.05  # [s] the simulated time in which a film slows down before an impact, or speeds up after it
# [s] the longest time after an onset that is shown in slow motion; in a contact that lasts longer, the chain
# only rests or leans
LONGEST_SLOW = 0.1
LEAST_DURATION = 1e-4  # [s] the least duration assumed for an impact; an impulse has none
FRAME_RATE = 60.0  # [1/s] frames per second on the screen
FRAMES_OF_A_PERIOD = 16.0  # the least number of frames in a period of the fastest sine that drives an input
FLIGHT_STEP = 1 / 240  # [s] far from impacts, the distance of the times at which the rate is computed
# before and after an impact, the distances from the impact at which the rate is computed, relative to RAMP
RAMP_DISTANCES = np.geomspace(1e-3, 1.0, 48)
# within a contact, the times after the onset at which the rate is computed, relative to the contact's
# duration
CONTACT_SHARES = np.linspace(0.0, 1.0, 25)
# the least speed of an impact that is shown in slow motion, relative to the speed of the fastest impact
SLOW_SPEED = 0.05
SLOW_COUNT = 100  # the largest number of impacts that are shown in slow motion; these are the fastest impacts
# For a film, an impact ends at the latest LONGEST_IMPACT times δ/v after its onset, where δ is the
# penetration and v the approach speed: a contact that lasts longer rests from then on.
LONGEST_IMPACT = 5.0
# [m/s; rad/s at a stop of a joint] the least v in δ/v: a point that rests at a wall from the onset on (v = 0)
# would otherwise give an infinite time
SLOWEST = 1e-6
MOST_FRAMES = 20_000  # the largest number of frames for which simulated times are computed
TAIL = 0.3  # [s] the simulated time in which the trace of the tip fades
# REAL: a rate that differs less than this from 1 is called real time; SLOW_RATE: a smaller rate than this has
# a stronger colour; TENS: a factor from this one on has no decimals.
REAL, SLOW_RATE, TENS = 0.05, 0.5, 9.95

Span = tuple[float, float]


def impact_ends(impacts: np.ndarray, stop: float) -> np.ndarray:
    """Return the times at which impacts end for a film, shape (I,) [s], at the latest at ``stop``.

    With penetration δ and approach speed v, an impact takes 2.9 δ/v with Hertz's law, π δ/v with a linear
    spring, and longer with losses. A contact that lasts longer ends after LONGEST_IMPACT times δ/v.
    """
    speeds = np.maximum(impacts["impact_speed"], SLOWEST)
    lasting = LONGEST_IMPACT * np.nan_to_num(impacts["max_penetration"]) / speeds
    return np.asarray(np.fmin(impacts["end"], np.minimum(impacts["onset"] + lasting, stop)))


def slow_spans(recording: Recording) -> list[Span]:
    """Return the onsets and the ends [s] of the impacts that are shown slowly."""
    impacts, speeds = recording.impacts, recording.end_speeds
    ends = impact_ends(impacts, float(recording.time[-1]))
    fastest = np.argsort(-speeds, kind="stable")[:SLOW_COUNT]
    fastest = fastest[speeds[fastest] >= SLOW_SPEED * speeds.max(initial=0.0)]
    return sorted(zip(impacts["onset"][fastest].tolist(), ends[fastest].tolist(), strict=True))


def rate(time: np.ndarray, spans: Sequence[Span], impact_time: float) -> np.ndarray:
    """Return simulated seconds per second on the screen, shape (T,); 1 far from impacts.

    During an impact the rate is so small that the impact takes ``impact_time`` on the screen; an impact that
    lasts longer is shown at the rate 1. Before and after the impact the rate grows in proportion to the
    distance in time from the impact.

    Args:
        time: shape (T,) [s].
        spans: onset and end of each impact that is shown slowly [s].
        impact_time: the time [s] that an impact takes on the screen.
    """
    slowest = np.ones_like(time)
    for onset, end in spans:
        within = min(1.0, (end - onset) / impact_time)
        distance = np.maximum(0.0, np.maximum(onset - time, time - end))
        slowest = np.minimum(slowest, within + distance / RAMP)
    return slowest


def fastest_sine(recording: Recording) -> float:
    """Return the largest frequency of the sines that move inputs during the run [Hz]; 0 without a sine."""
    stop, fastest = float(recording.time[-1]), 0.0
    for (owner, _, _), signal in by_owner(recording.parameters).items():
        if owner == "signal" and "frequency" in signal:
            begin, value = float(signal.get("start", 0.0)), float(signal["frequency"])
            if begin >= stop or float(signal.get("amplitude", 1.0)) == 0.0:
                continue
            # at the time s after the start of the signal the frequency is f + ḟ s: largest at s = 0 or at the
            # end
            change = float(signal.get("frequency_rate", 0.0)) * (stop - begin)
            fastest = max(fastest, abs(value), abs(value + change))
    return fastest


def frame_rate(recording: Recording) -> float:
    """Return the frames per second of a page: enough to see the sines that drive inputs."""
    return max(FRAME_RATE, FRAMES_OF_A_PERIOD * fastest_sine(recording))


def frame_times(
    start: float,
    stop: float,
    spans: Sequence[Span],
    impact_time: float = IMPACT_TIME,
    most: int = MOST_FRAMES,
    *,
    usual: float = FRAME_RATE,
) -> tuple[np.ndarray, float]:
    """Return the simulated times of the frames of a film, which follow each other evenly on the screen.

    Args:
        start: the start of the simulation [s].
        stop: the end of the simulation [s].
        spans: onset and end of each impact that is shown slowly [s].
        impact_time: the time [s] that an impact takes on the screen; 0 for no slow motion.
        most: the largest number of frames; a longer film has fewer frames per second.
        usual: frames per second of a film that is not too long.

    Returns:
        The times, shape (F,) [s], from ``start`` to ``stop``, and the frames per second on the screen.
    """
    spans = spans if impact_time > 0.0 else []
    shown = [(a, a + min(max(b - a, LEAST_DURATION), LONGEST_SLOW)) for a, b in spans]
    parts = [np.linspace(start, stop, 2 + min(int((stop - start) / FLIGHT_STEP), 2 * most))]
    far = RAMP * RAMP_DISTANCES
    for onset, end in shown:
        parts += [onset - far, onset + (end - onset) * CONTACT_SHARES, end + far]
    grid = np.unique(np.concatenate(parts).clip(start, stop))
    slowness = 1.0 / rate(grid, shown, impact_time)
    # the time on the screen is ∫ dt / rate, computed by the trapezoidal rule
    screen = np.concatenate([[0.0], np.cumsum(np.diff(grid) * (slowness[1:] + slowness[:-1]) / 2)])
    frames = min(most, 2 + int(screen[-1] * usual))
    return np.interp(np.linspace(0.0, screen[-1], frames), screen, grid), (frames - 1) / screen[-1]


def rate_text(rate: float) -> str:
    """Return words for the rate of a film relative to real time, for example: 480 × slower."""
    if abs(rate - 1.0) < REAL:
        return "real time"
    times, word = (1.0 / rate, "slower") if rate < 1.0 else (rate, "faster")
    number = f"{times:.1f}".removesuffix(".0") if times < TENS else f"{float(f'{times:.2g}'):.0f}"
    return "real time" if number == "1" else f"{number} × {word}"

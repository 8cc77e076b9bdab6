"""The speed at which a film shows the simulated time: slower during impacts, so that they can be seen.

The pages pace themselves likewise, in ``pages/browser/pacing.js``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.recording.recording import Recording

IMPACT_TIME = 0.6  # s, the time on the screen that an impact takes
RAMP = 0.05  # s of simulated time: the slowing down begins so long before an impact
LONGEST = 0.1  # s, the part of a contact shown in slow motion; in a longer one the chain rests or leans
SHORTEST = 1e-4  # s, the duration assumed for a contact without one, as between rigid walls
FRAME_RATE = 60.0  # frames per second on the screen
FRAMES_OF_A_PERIOD = 16.0  # the least number of frames in a period of the fastest sine that drives an input
FLIGHT_STEP = 1 / 240  # s, the step of the grid on which the rate is computed, far from impacts
NEAR = np.geomspace(1e-3, 1.0, 48)  # the points of this grid near an impact, as fractions of RAMP
WITHIN = np.linspace(0.0, 1.0, 25)  # the points of this grid within a contact, as fractions of its duration
SLOW_SPEED = 0.05  # fraction of the speed of the fastest impact: slower impacts are not shown in slow motion
SLOW_COUNT = 100  # the largest number of impacts shown in slow motion: the fastest ones
LONGEST_IMPACT = 5.0  # the longest impact, in units of penetration over approach speed
SLOWEST = 1e-6  # m/s, the least approach speed: a point that comes to rest at a wall has none

Span = tuple[float, float]


def impact_ends(impacts: np.ndarray, stop: float) -> np.ndarray:
    """Return the ends of the impacts, shape (I,) [s]; a contact that lasts has an end of its impact, too.

    By Hertz an impact takes 2.9 δ/v, at a linear spring π δ/v, and longer with losses.
    """
    speeds = np.maximum(impacts["impact_speed"], SLOWEST)
    lasting = LONGEST_IMPACT * np.nan_to_num(impacts["max_penetration"]) / speeds
    return np.asarray(np.fmin(impacts["end"], np.minimum(impacts["onset"] + lasting, stop)))


def slow_spans(recording: Recording) -> list[Span]:
    """Return onset and end [s] of the impacts to be shown slowly."""
    impacts, speeds = recording.impacts, recording.end_speeds
    ends = impact_ends(impacts, float(recording.time[-1]))
    fastest = np.argsort(-speeds, kind="stable")[:SLOW_COUNT]
    fastest = fastest[speeds[fastest] >= SLOW_SPEED * speeds.max(initial=0.0)]
    return sorted(zip(impacts["onset"][fastest].tolist(), ends[fastest].tolist(), strict=True))


def rate(time: np.ndarray, spans: Sequence[Span], impact_time: float) -> np.ndarray:
    """Return the simulated seconds per second on the screen, shape (T,); the rate is 1 far from impacts.

    During an impact the rate is such that the impact takes ``impact_time``. Before and after it the rate
    grows in proportion to the distance in time from the impact.

    Args:
        time: shape (T,) [s].
        spans: onset and end of each impact to be seen [s].
        impact_time: the time [s] that an impact takes on the screen.
    """
    slowest = np.ones_like(time)
    for onset, end in spans:
        within = min(1.0, (end - onset) / impact_time)
        distance = np.maximum(0.0, np.maximum(onset - time, time - end))
        slowest = np.minimum(slowest, within + distance / RAMP)
    return slowest


def frame_rate(recording: Recording) -> float:
    """Return the frames per second of a page: so many that the sines that drive inputs are seen."""
    known, stop, fastest = recording.parameters, float(recording.time[-1]), 0.0
    for name, value in known.items():
        if name.startswith("signal.") and name.endswith(".frequency"):
            ends = float(value), float(value) + stop * float(known.get(f"{name}_rate", 0.0))
            fastest = max(fastest, *map(abs, ends))
    return max(FRAME_RATE, FRAMES_OF_A_PERIOD * fastest)


def frame_times(
    start: float,
    stop: float,
    spans: Sequence[Span],
    impact_time: float = IMPACT_TIME,
    most: int = 20_000,
    *,
    usual: float = FRAME_RATE,
) -> tuple[np.ndarray, float]:
    """Return the simulated times of frames that follow each other evenly on the screen.

    Args:
        start: the start of the simulation [s].
        stop: the end of the simulation [s].
        spans: onset and end of each impact to be seen slowly [s].
        impact_time: the time [s] that an impact takes on the screen; 0 for no slow motion.
        most: the largest number of frames; a longer film has fewer frames per second.
        usual: frames per second where there are not too many.

    Returns:
        The times, shape (F,) [s], from ``start`` to ``stop``, and the frames per second on the screen.
    """
    shown = [(a, a + min(max(b - a, SHORTEST), LONGEST)) for a, b in spans] if impact_time > 0.0 else []
    parts = [np.linspace(start, stop, 2 + int((stop - start) / FLIGHT_STEP))]
    for onset, end in shown:
        parts += [onset - RAMP * NEAR, onset + (end - onset) * WITHIN, end + RAMP * NEAR]
    grid = np.unique(np.concatenate(parts).clip(start, stop))
    slowness = 1.0 / rate(grid, shown, impact_time)
    # the time on the screen: ∫ dt / rate, by the trapezoidal rule
    screen = np.concatenate([[0.0], np.cumsum(np.diff(grid) * (slowness[1:] + slowness[:-1]) / 2)])
    frames = min(most, 2 + int(screen[-1] * usual))
    return np.interp(np.linspace(0.0, screen[-1], frames), screen, grid), (frames - 1) / screen[-1]

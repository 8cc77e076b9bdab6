"""How fast a film shows the simulated time: slower through impacts, so that they are seen.

The pages pace themselves likewise, in ``page/browser/pacing.js``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chain_impact.results.recording import Recording

IMPACT_TIME = 0.6  # s on the screen that an impact takes
RAMP = 0.05  # s: so far from an impact in simulated time the slowing down begins
LONGEST = 0.1  # s of a contact that are shown slowly; a longer one is of a chain that rests or leans
SHORTEST = 1e-4  # s that a contact without a duration is taken to last, as one of rigid walls
FRAME_RATE = 60.0  # frames in a second on the screen
FLIGHT_STEP = 1 / 240  # s between the points at which the rate is worked out, far from impacts
NEAR = np.geomspace(1e-3, 1.0, 48)  # of RAMP: the same near them
WITHIN = np.linspace(0.0, 1.0, 25)  # of a contact: the same in it
SLOW_SPEED = 0.05  # of the fastest impact: slower ones are not shown slowly
SLOW_COUNT = 100  # impacts, the fastest ones, that are shown slowly
LONGEST_IMPACT = 5.0  # of penetration over approach speed
SLOWEST = 1e-6  # m/s, approach speed of a point that comes to rest at a wall

Span = tuple[float, float]


def impact_ends(impacts: np.ndarray, stop: float) -> np.ndarray:
    """When impacts are over, shape (I,) [s], also where the chain stays at the wall.

    An impact takes 2.9 δ/v by Hertz, π δ/v at a linear spring, and longer with losses.
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
    """Return simulated seconds that pass in a second on the screen, shape (T,), 1 far from impacts.

    In an impact the rate is such that it takes ``impact_time``. Before and after it the rate changes with the
    distance in time: each stretch, half as far from the impact as the one before, takes as long.

    Args:
        time: shape (T,) [s].
        spans: onset and end of each impact to be seen [s].
        impact_time: [s] on the screen.
    """
    slowest = np.ones_like(time)
    for onset, end in spans:
        within = min(1.0, (end - onset) / impact_time)
        distance = np.maximum(0.0, np.maximum(onset - time, time - end))
        slowest = np.minimum(slowest, within + distance / RAMP)
    return slowest


def frame_times(
    start: float, stop: float, spans: Sequence[Span], impact_time: float = IMPACT_TIME, most: int = 20_000
) -> tuple[np.ndarray, float]:
    """Return the simulated times of frames that follow each other evenly on the screen.

    Args:
        start: of the simulation [s].
        stop: of the simulation [s].
        spans: onset and end of each impact to be seen slowly [s].
        impact_time: that an impact takes on the screen [s], 0 for no slow motion.
        most: how many frames there may be; beyond, they follow each other more slowly.

    Returns:
        The times, shape (F,) [s], from ``start`` to ``stop``, and the frames in a second on the screen.
    """
    shown = [(a, a + min(max(b - a, SHORTEST), LONGEST)) for a, b in spans] if impact_time > 0.0 else []
    parts = [np.linspace(start, stop, 2 + int((stop - start) / FLIGHT_STEP))]
    for onset, end in shown:
        parts += [onset - RAMP * NEAR, onset + (end - onset) * WITHIN, end + RAMP * NEAR]
    grid = np.unique(np.concatenate(parts).clip(start, stop))
    slowness = 1.0 / rate(grid, shown, impact_time)
    # the time on the screen: ∫ dt / rate, by the trapezoidal rule
    screen = np.concatenate([[0.0], np.cumsum(np.diff(grid) * (slowness[1:] + slowness[:-1]) / 2)])
    frames = min(most, 2 + int(screen[-1] * FRAME_RATE))
    return np.interp(np.linspace(0.0, screen[-1], frames), screen, grid), (frames - 1) / screen[-1]

"""Some outputs over time as they are drawn: also within impacts, where a result has few rows or none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from chain_impact.results.course import Rerun
from chain_impact.results.impacts import lasts
from chain_impact.results.recording import Recording
from chain_impact.scene.reading import matching
from chain_impact.variables.model import Model, elsewhere

WITHIN, FOLLOWED = 50, 400  # times within an impact, and impacts that have them
CLOSE = 1000  # times of a view of one impact
BEFORE, AFTER = 0.5, 1.0  # of an impact, what is seen before and after it
LONGEST = 0.02  # of the run, what is seen of a contact that lasts
LEAST = 1e-3  # of the run, what is seen around an impulse


@dataclass(frozen=True, eq=False)
class Curves:
    """Some outputs over time.

    Attributes:
        time: shape (T,) [s].
        values: name → shape (T,).
        units: name → unit; "" where there is none.
        onset: of the impact that is seen closely [s]; None if all of the run is seen.
        number: of that impact, from 1.
    """

    time: np.ndarray
    values: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    onset: float | None = None
    number: int = 0

    @property
    def panels(self) -> list[list[str]]:
        """The names by unit, in the order in which the units come."""
        found: dict[str, list[str]] = {}
        for name in self.values:
            found.setdefault(self.units.get(name, ""), []).append(name)
        return list(found.values())


def curves_of(
    recording: Recording,
    names: Iterable[str],
    units: Mapping[str, str],
    *,
    around: int | None = None,
    model: Model | None = None,
    rerun: Rerun | None = None,
) -> Curves:
    """Return the curves of some outputs.

    Args:
        recording: has them in its rows.
        names: of the outputs, in which ``*`` stands for any text.
        units: name → unit.
        around: the number of an impact, to see it closely.
        model: of the scene, if there is one.
        rerun: gives outputs at other times; without it there is nothing between the rows.

    Raises:
        UnknownNameError: when there is no output of a name.
        ValueError: when there is no impact of that number.
    """
    like = (matching(recording.name, one, recording.columns, "no output", elsewhere) for one in names)
    chosen = list(dict.fromkeys(name for found in like for name in found))
    onset, low, high = window(recording, around)
    time = recording.time
    if rerun and model:
        seen = time[(time >= low) & (time <= high)]
        time = np.unique(np.concatenate([seen, between(recording, low, high, close=around is not None)]))
        outputs = rerun(time)
        time, moving = time[: len(outputs)], model.series(outputs)
    else:
        rows = (time >= low) & (time <= high)
        time, moving = time[rows], {name: values[rows] for name, values in recording.columns.items()}
    # what changes at events and steps only has the value of the row before
    row = np.searchsorted(recording.time, time, side="right") - 1
    values = {
        name: moving[name] if name in moving else recording.columns[name][row.clip(0)] for name in chosen
    }
    return Curves(time, values, {name: units.get(name, "") for name in chosen}, onset, around or 0)


def window(recording: Recording, around: int | None) -> tuple[float | None, float, float]:
    """Return the onset of an impact, and from when until when it is seen [s]; without one, all of the run."""
    start, end = float(recording.time[0]), float(recording.time[-1])
    if around is None:
        return None, start, end
    count = len(recording.impacts)
    if not 1 <= around <= count:
        there = f"1 to {count}" if count else "left out: there is no impact"
        raise ValueError(f"{recording.name}: around = {around!r} must be {there}")
    impact = recording.impacts[around - 1]
    onset, run = float(impact["onset"]), end - start
    lasting = LONGEST * run if lasts(impact) else float(impact["end"]) - onset
    if not lasting > 0.0:
        lasting = LEAST * run
    return onset, max(start, onset - BEFORE * lasting), min(end, onset + (1.0 + AFTER) * lasting)


def between(recording: Recording, low: float, high: float, *, close: bool) -> np.ndarray:
    """Return times between rows [s]: of a close view everywhere, else within impacts."""
    if close:
        return np.linspace(low, high, CLOSE)
    impacts = recording.impacts[:FOLLOWED]
    known = impacts[impacts["end"] > impacts["onset"]]
    inside = np.linspace(known["onset"], known["end"], WITHIN).ravel()
    return np.asarray(inside[(inside >= low) & (inside <= high)])

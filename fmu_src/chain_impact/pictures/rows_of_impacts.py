"""The rows of a recording within impacts, and those where impacts are with another value of a parameter."""

from __future__ import annotations

import numpy as np

from chain_impact.recording.contact_times import SEEN_CONTACT
from chain_impact.recording.recording import Recording
from chain_impact.recording.sensitivity import Sensitivities


def is_outside_impacts(recording: Recording) -> np.ndarray:
    """Return whether each row is outside of all impacts that end in the run, shape (T,).

    A change of a parameter shifts impacts in time. Within an impact, where quantities change fast, the
    derivatives are therefore very large.
    """
    return ~rows_within(recording, recording.impacts)


def short_contacts(recording: Recording) -> np.ndarray:
    """Return whether each row is within an impact too short to be visible (SEEN_CONTACT), shape (T,)."""
    impacts, span = recording.impacts, recording.duration
    return rows_within(recording, impacts[impacts["duration"] < SEEN_CONTACT * span])


def rows_within(recording: Recording, impacts: np.ndarray) -> np.ndarray:
    """Return whether each row is within one of ``impacts``, except those without an end, shape (T,)."""
    rows = np.zeros(len(recording.time), bool)
    for impact in impacts:
        rows |= (recording.time >= impact["onset"]) & (recording.time <= impact["end"])
    return rows


def is_shifted(recording: Recording, sensitivities: Sensitivities) -> np.ndarray:
    """Return whether each row lies between a jump at an impact and its shifted time, shape (T, P).

    A step of a parameter shifts onset and end of an impact. Between the old and the new time, the change of a
    quantity that jumps there, or whose slope jumps, is not its change to first order. The shift is known only
    to first order, so that rows at both sides of the old time count, up to the impacts before and after.
    """
    rows = np.zeros((len(recording.time), len(sensitivities.parameters)), bool)
    time, onsets = recording.time[:, None], sensitivities.impacts["onset"]
    for name in ("onset", "end"):
        shifts = np.abs(np.nan_to_num(sensitivities.impact_changes(name)))
        for k, shift in enumerate(shifts):
            impact_time, earlier_onsets, later_onsets = (
                sensitivities.impacts[name][k],
                onsets[:k],
                onsets[k + 1 :],
            )
            low = np.maximum(impact_time - shift, earlier_onsets.max(initial=-np.inf))
            high = np.minimum(impact_time + shift, later_onsets.min(initial=np.inf))
            rows |= (low < time) & (time < high)
    return rows

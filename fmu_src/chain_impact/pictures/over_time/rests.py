"""The times without motion, which are shaded in pictures, and the time that pictures show."""

from __future__ import annotations

from typing import NamedTuple

from matplotlib.axes import Axes

from chain_impact.pictures.drawing.colours import SHADE, faint_colour
from chain_impact.recording.recording import Recording
from chain_impact.recording.rest import rest_spans, rest_word

# times without motion at start and end are cut if together they take at least this part of the whole time
CUT_REST = 0.4
# the longest shown part of a cut time without motion, REST_AT_START at the start and REST_AT_END at the end
# of the run, both relative to the whole time without these two times
REST_AT_START, REST_AT_END = 0.1, 0.25


class ShownTime(NamedTuple):
    """The time that a picture shows.

    Attributes:
        start: the start of the axis [s].
        end: the end of the axis [s].
        rest_spans: start and end [s] of each time without motion, with the part that the axis cuts off.
        word: "at rest" or a similar word for the times without motion; "" if there are none.
        cuts: words on cut ends of the run, such as "the run ends at 10 s"; "" if none is cut.
    """

    start: float
    end: float
    rest_spans: list[tuple[float, float]]
    word: str
    cuts: str

    @property
    def note(self) -> str:
        """Return words on times without motion and on cut ends: "shaded: at rest; the run ends at 10 s"."""
        return "; ".join(filter(None, (f"shaded: {self.word}" if self.word else "", self.cuts)))


def shown_time(recording: Recording) -> ShownTime:
    """Return the time that a picture shows: the run, but long times without motion at its ends are cut.

    They are cut to REST_AT_START and REST_AT_END if CUT_REST says so.
    """
    resting = rest_spans(recording)
    first, last = (float(recording.time[row]) for row in (0, -1))
    start, end = first, last
    rest_before = resting[0][1] - first if resting and resting[0][0] == first else 0.0
    rest_after = last - resting[-1][0] if resting and resting[-1][1] == last else 0.0
    moving_time = last - first - rest_before - rest_after
    if moving_time > 0.0 and rest_before + rest_after >= CUT_REST * (last - first):
        start, end = (
            max(first, first + rest_before - REST_AT_START * moving_time),
            min(last, last - rest_after + REST_AT_END * moving_time),
        )
    cuts = [f"starts at {first:g} s"] * (start > first) + [f"ends at {last:g} s"] * (end < last)
    cut_text = f"the run {' and '.join(cuts)}" if cuts else ""
    return ShownTime(start, end, resting, rest_word(recording) if resting else "", cut_text)


def shade_rests(axes: Axes, shown_span: ShownTime) -> None:
    """Shade each time without motion in axes over time [s]."""
    for low, high in shown_span.rest_spans:
        axes.axvspan(low, high, color=faint_colour(axes, SHADE), linewidth=0.0, zorder=-1)

"""The caption of a film: words for the impact that the film shows, and for how hard this impact is."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from chain_impact.pictures.film.scale_bar import NUMBER_SIZE
from chain_impact.pictures.texts.headline import (
    energy_texts,
    hardness_text,
    hit_text,
    impact_count_text,
    largest_peaks,
)
from chain_impact.pictures.texts.point_names import brief_hit, short_names
from chain_impact.recording.contact_times import contact_ends
from chain_impact.recording.recording import Recording

# number of frames for which a caption stays after the end of its contact, and becomes fainter; 2 s in a gif
CAPTION_FRAMES = 40
LEAST_OPACITY = 0.3  # the opacity of a caption just before it disappears, from 0 to 1
# a frame is in slow motion if the time until the next frame is less than this part of the longest one
SLOW_STEP = 0.5
CAPTION_END = 0.99  # the right end of the room for the caption, relative to the width of the figure

CAPTION_GAP = 2.0  # [points] the least space below the caption


class Caption:
    """The caption of a film, a text of two lines."""

    def __init__(
        self, figure: Figure, position: tuple[float, float], recording: Recording, times: np.ndarray
    ) -> None:
        """Make the text, which is empty at first.

        Args:
            figure: the figure of the film.
            position: the left edge of the text and the middle of its height, relative to the figure's size.
            recording: the recording to show.
            times: the time of the recording that each frame shows [s]; empty for a film without captions.
        """
        self.figure, self.recording, self.times = figure, recording, times
        self.ends = contact_ends(recording)
        self.shown_number = 0  # the number of the impact in the caption, from 1; 0 for an empty caption
        self.is_next = False  # whether the impact in the caption has not yet begun
        steps = np.diff(times, append=times[-1:])
        self.is_slow = steps < SLOW_STEP * steps.max(initial=0.0)
        self.text = figure.text(*position, "\n", fontsize=NUMBER_SIZE, animated=True, va="center")
        self.lowest = self.text.get_window_extent().y0 - CAPTION_GAP * figure.dpi / 72.0  # [pixels]
        self.text.set_text("")

    def show(self, frame: int) -> None:
        """Write the caption for frame ``frame``, from 0, with the longest words that have room.

        The caption tells the latest impact that has begun or, in slow motion that is nearer to the onset of
        the next impact than to the end of this one, the next impact. It is empty before the first impact, and
        more than CAPTION_FRAMES frames after the end of the told contact; until then it becomes fainter. In
        the last of several frames, the caption tells the result of the run. A film without captions has none.
        """
        if not len(self.times):
            return
        if 0 < frame == len(self.times) - 1:
            self.shown_number, self.is_next = 0, False
            self.text.set_alpha(1.0)
            self._write(self._result())
            return
        onsets, time = self.recording.impacts["onset"], self.times[frame]
        number = int(np.searchsorted(onsets, time, side="right"))
        passed_time = time - self.ends[number - 1] if number else np.inf
        is_next = bool(self.is_slow[frame] and number < len(onsets) and onsets[number] - time < passed_time)
        if is_next:
            number += 1
        elif number and self.ends[number - 1] < self.times[max(frame - CAPTION_FRAMES, 0)]:
            number = 0
        if number and is_next:
            self.text.set_alpha(1.0)
        elif number:
            end_frame = int(np.searchsorted(self.times, self.ends[number - 1]))
            passed_share = max(0, frame - end_frame) / CAPTION_FRAMES
            self.text.set_alpha(1.0 - (1.0 - LEAST_OPACITY) * min(1.0, passed_share))
        if (number, is_next) != (self.shown_number, self.is_next):
            self.shown_number, self.is_next = number, is_next
            self._write(self._caption_text(number, is_next=is_next) if number else [""])

    def _caption_text(self, number: int, *, is_next: bool) -> list[str]:
        """Return words for impact ``number``, from 1, the longest first; ``is_next``: it has not begun."""
        recording, impacts = self.recording, self.recording.impacts
        beginning, impact = "next: " if is_next else "", impacts[number - 1]
        count_text = f"{beginning}impact {number} of {len(impacts)}"
        whole_text, brief = (
            short_names(recording, hit_text(recording, impact)),
            brief_hit(recording, impact),
        )
        hard = "" if is_next else hardness_text(recording, number - 1)
        return [
            f"{text}\n{hard}" for text in (f"{count_text}: {whole_text}", f"{count_text}: {brief}", brief)
        ]

    def _result(self) -> list[str]:
        """Return words for the largest value of all impacts, and for the energies, the longest first."""
        recording = self.recording
        largest_texts = [
            f"{peak.text} in impact {peak.row + 1}" if peak.equal_count == 1 else peak.text
            for peak in largest_peaks(recording)[:1]
        ]
        count, energies = impact_count_text(recording), energy_texts(recording)[:1]
        tries = [[count, *energies], [count.partition(" in ")[0], *energies], [count]]
        return ["\n".join([*largest_texts, ", ".join(parts)]) for parts in tries]

    def _write(self, texts: list[str]) -> None:
        """Write the first of some texts that has room, or else the last one."""
        for text in texts:
            self.text.set_text(text)
            if self.text.get_window_extent().x1 <= CAPTION_END * self.figure.bbox.x1:
                break

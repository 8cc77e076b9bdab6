"""The pictures of a recording, which methods of results and the command line draw into files and windows."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from typing import NamedTuple

from matplotlib.figure import Figure

from chain_impact.pictures.curves import curves_size, draw_curve_figure
from chain_impact.pictures.drawing.figures import FIGURE_SIZE, DrawContents, NoRoomError, draw_figure
from chain_impact.pictures.drawing.sizes import Size
from chain_impact.pictures.impact import IMPACT_SIZE, draw_impact
from chain_impact.pictures.overview import draw_overview, panels_to_draw, usual_overview_size
from chain_impact.pictures.overview_layout import is_motion_beside
from chain_impact.pictures.ranking import draw_ranking, ranking_size
from chain_impact.pictures.sensitivities import draw_sensitivities
from chain_impact.recording.curves import Curves
from chain_impact.recording.impact_course import ImpactCourse
from chain_impact.recording.recording import Recording
from chain_impact.study_data.ranking.ranked_effects import RankedEffects


class Picture(NamedTuple):
    """A picture that is not drawn yet.

    Attributes:
        draw: the function that draws the picture on an empty figure.
        usual_size: the width and height of its figure [inches] if the user gives no size.
        spare: the picture that replaces this one in a figure where this one has no room; None without one.
    """

    draw: DrawContents
    usual_size: tuple[float, float] = FIGURE_SIZE
    spare: Picture | None = None

    def plot(self, path: str | os.PathLike[str] | None = None, *, size: Size | None = None) -> Figure | None:
        """Draw the picture into a file, or return its figure, as ``draw_figure`` does."""
        try:
            return draw_figure(self.draw, path, size, self.usual_size)
        except NoRoomError:
            if self.spare is not None:
                with suppress(NoRoomError):
                    return self.spare.plot(path, size=size)
            raise


def overview_picture(
    recording: Recording, panels: Sequence[str] = (), size: Size | None = None, title: str | None = ""
) -> Picture:
    """Return the picture with the panels of a recording: motion, energy, impacts.

    If a motion beside the other panels leaves these no room, it stands above them.
    The arguments are those of ``draw_overview`` and of ``usual_overview_size``, which raise errors.
    """
    draw = partial(draw_overview, recording=recording, panels=panels, title=title)
    usual_size, spare = usual_overview_size(recording, panels, size), None
    if is_motion_beside(recording, panels_to_draw(recording, panels), usual_size[0]):
        spare_size = usual_overview_size(recording, panels, size, is_above=True)
        spare = Picture(partial(draw, is_above=True), spare_size)
    return Picture(draw, usual_size, spare)


def curves_picture(recording: Recording, curves: Curves, title: str | None = "") -> Picture:
    """Return the picture with curves of outputs; the arguments are those of ``draw_curve_figure``."""
    draw = partial(draw_curve_figure, recording=recording, curves=curves, title=title)
    return Picture(draw, curves_size(curves))


def impact_picture(recording: Recording, number: int, course: ImpactCourse) -> Picture:
    """Return the picture of one impact; the arguments are those of ``draw_impact``."""
    return Picture(partial(draw_impact, recording=recording, number=number, course=course), IMPACT_SIZE)


def sensitivities_picture(recording: Recording, outputs: Sequence[str] = ()) -> Picture:
    """Return the picture of derivatives; the arguments are those of ``draw_sensitivities``."""
    return Picture(partial(draw_sensitivities, recording=recording, outputs=outputs))


def ranking_picture(ranking: RankedEffects) -> Picture:
    """Return the picture of a ranking: its largest effects as bars."""
    return Picture(partial(draw_ranking, ranking=ranking), ranking_size(ranking))

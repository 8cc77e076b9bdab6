"""The picture of a ranking of contact laws by a fit: a dot for each law."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from chain_impact.pictures.bars import Bars, draw_bars
from chain_impact.pictures.drawing.colours import GREY, INK, PALETTE
from chain_impact.pictures.drawing.figures import settle
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.style import drawing_style, is_narrow
from chain_impact.pictures.fit.contents import RankedLaw
from chain_impact.text import number_text

SUPPORT_LIMIT = 10.0  # the ΔAIC from which on the data hardly support a law (Burnham & Anderson 2004)
# the free space left of ΔAIC = 0, relative to the linear part of the axis, so that no dot touches a name
ZERO_MARGIN = 0.12


@drawing_style()
def draw_law_ranking(figure: Figure, *, title: str, notes: Sequence[str], laws: Sequence[RankedLaw]) -> None:
    """Draw the ranking of contact laws on an empty figure: ΔAIC of each law as a dot.

    The best law is on top. A law without a fit has no dot. If a dot is beyond SUPPORT_LIMIT, the axis is
    logarithmic beyond SUPPORT_LIMIT. ``notes`` stand below the headline ``title``.
    """
    excesses = [law.excess for law in laws]
    largest_excess = float(np.nanmax(excesses))
    bars = Bars(
        names=[law.law for law in laws],
        values=excesses,
        texts=[
            "–"
            if math.isnan(value)
            else number_text(round(value, 1), 2)
            if value < SUPPORT_LIMIT
            else f"{value:.0f}"
            for value in excesses
        ],
        label="ΔAIC",
        heading="ΔAIC",
        dots=True,
        colours=[PALETTE[0] if law.is_best else GREY for law in laws],
    )
    texts = [*notes, "blue: as good as the best law"]
    if largest_excess > SUPPORT_LIMIT:
        texts.append(f"from {SUPPORT_LIMIT:g} on (dashed): hardly supported")
    write_headline(figure, title, SEPARATOR.join(texts))
    axes = figure.subplots()
    draw_bars(axes, bars, (0.0, largest_excess or 1.0), is_small=is_narrow(figure))
    axes.axvline(SUPPORT_LIMIT, color=INK, linewidth=0.8, linestyle="--")
    linear_end = largest_excess or 1.0
    if largest_excess > SUPPORT_LIMIT:
        axes.set_xscale("symlog", linthresh=SUPPORT_LIMIT)
        linear_end = SUPPORT_LIMIT
    axes.set_xlim(-ZERO_MARGIN * linear_end, 2.0 * largest_excess if largest_excess > SUPPORT_LIMIT else None)
    settle(figure)

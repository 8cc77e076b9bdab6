"""The picture of a comparison of contact laws: force over penetration in the first impact, and energy."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from chain_impact.pictures.compare.grey_loops import draw_grey_loops
from chain_impact.pictures.compare.headline import (
    comparison_headline,
    laws_with_e,
    peak_range_text,
    rest_of_headline,
)
from chain_impact.pictures.compare.looks import (
    REFERENCE_LAYER,
    Looks,
    are_loops_equal,
    brief_law_names,
    looks_of_laws,
)
from chain_impact.pictures.drawing.axis_numbers import force_text, give_ticks, raise_exponents
from chain_impact.pictures.drawing.colours import GREY, INK
from chain_impact.pictures.drawing.distinct_curves import MOST_GREY, dash_lines, draw_band
from chain_impact.pictures.drawing.end_labels import EndLabel, spread, write_end_labels
from chain_impact.pictures.drawing.figures import check_alone, draw_figure, settle
from chain_impact.pictures.drawing.head_and_foot import write_foot, write_headline
from chain_impact.pictures.drawing.legends import legend_at_head
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.sizes import Size
from chain_impact.pictures.drawing.style import drawing_style, is_narrow
from chain_impact.pictures.drawing.users_axes import draw_into, fit_into_figure
from chain_impact.pictures.over_time.energies import offset_text, shown_energies
from chain_impact.pictures.over_time.rests import shown_time
from chain_impact.pictures.over_time.time_axis import name_time
from chain_impact.recording.recording import Recording
from chain_impact.scene.texts.unit_text import stiffness_unit
from chain_impact.study_data.compared_impact import LOSSLESS_LAW, compared_impact
from chain_impact.study_data.law_runs import LawRecording, LawRuns, with_jump
from chain_impact.text import count_text, number_text, prefixed_unit
from chain_impact.variables.impact_units import unit_at

SIZE = (10.0, 4.8)  # [inch] default width and height of the figure
# the heights of the panels of loops and energy, relative to each other, in a narrow figure
LOOPS_ABOVE: Any = (1.5, 1.0)
LEAST_NAMED = 4.3  # [inch] the least width of a figure with names of laws at the ends of lines
LEAD_SHARE = 0.1  # longest time shown before the first impact, relative to the time shown after its onset
# SETTLED: a change of an energy counts if it is larger than this part of the range of all energies;
# TRAIL_SHARE: the time shown after the last change that counts, relative to the time from the first impact to
# this change
SETTLED, TRAIL_SHARE = 0.02, 0.15


def plot_comparison(
    comparison: LawRuns[LawRecording],
    path: str | os.PathLike[str] | None = None,
    size: Size | None = None,
    ax: Any = None,
) -> Any:
    """Draw the picture of a comparison, as ``Comparison.plot`` describes."""
    if ax is None:
        return draw_figure(partial(draw_comparison, comparison=comparison), path, size, SIZE)
    check_alone(path, size)
    with draw_into([ax]):
        draw_loops(ax, comparison, looks_of_laws(comparison))
        dash_laws(ax)
        ax.legend(handles=legend_handles(looks_of_laws(comparison), ax))
        fit_into_figure([ax])
    return ax


@drawing_style()
def draw_comparison(figure: Figure, comparison: LawRuns[LawRecording]) -> None:
    """Draw the two panels of the picture on an empty figure."""
    is_small = is_narrow(figure)
    looks = looks_of_laws(comparison, is_small=is_small)
    write_headline(
        figure,
        comparison_headline(comparison, is_small=is_small),
        comparison_conditions(comparison, looks, is_small=is_small),
    )
    panels: dict[str, Any] = {"nrows": 2, "height_ratios": LOOPS_ABOVE} if is_small else {"ncols": 2}
    loops, energy = figure.subplots(**panels)
    draw_loops(loops, comparison, looks)
    draw_compared_energy(energy, comparison, looks)
    names = name_ends(energy, comparison, looks) if figure.get_figwidth() >= LEAST_NAMED else []
    dash_laws(loops, energy)
    handles = legend_handles(looks, energy, loops)
    legend_at_head(figure, move_to_foot(figure, handles) if is_small else handles)
    settle(figure)
    spread(energy, names)


def name_ends(axes: Axes, comparison: LawRuns[LawRecording], looks: Looks) -> list[EndLabel]:
    """Write the laws with a colour, and those of impulses, at the right ends of their lines of energy.

    The result has the written texts, for ``spread``.
    """
    lines, (_, end), reference = [], axes.get_xlim(), comparison[comparison.reference].result
    assert reference is not None
    offset = shown_energies(reference)[1]
    for law, look in looks.items():
        result = comparison[law].result
        if result is not None and look["color"] != GREY:
            value = float(np.interp(end, *energy_course(result, offset)))
            lines.append((brief_law_names(look["label"]), value, look["color"]))
    return write_end_labels(axes, lines)


def comparison_conditions(comparison: LawRuns[LawRecording], looks: Looks, *, is_small: bool = False) -> str:
    """Return the text below the headline.

    The text has these parts: effective mass and speed of the first impact; the reason if the e′ do not
    describe the contact alone (``no_restitution``); a remark if the impact is not free; the e′ without losses
    with a remark, if this e′ is known, the contact is not ``pressed_again``, and e′ is not 1.00 or the impact
    is not free; stiffness and tolerance; the peak force of the law without e; the number of grey lines,
    unless the grey lines are drawn as a band; the end of the runs, if the panel of energy does not show it.
    If ``is_small``, for a narrow figure, ``rest_of_headline`` comes first.
    """
    contact, impact = comparison.contact, comparison.first_impact
    names = ("effective_mass", "impact_speed", "peak_force", "max_penetration")
    mass, speed, force, depth = (unit_at(name, is_stop=comparison.is_at_stop) for name in names)
    unit_text = f"{force}/{depth}"
    motion_text = f"{impact['effective_mass']:.3g} {mass} at {impact['impact_speed']:.3g} {speed}"
    hit_text = f"{compared_impact(comparison.scene)} of {motion_text}"
    unit = raise_exponents(stiffness_unit(unit_text, contact.exponent))
    stiffness_text = f"stiffness K = {number_text(contact.stiffness)} {unit}"
    tolerance_text = f"tolerance {number_text(comparison.scene.solver.tolerance)}"
    grey = sum(look["color"] == GREY for look in looks.values())
    # whether the laws in the grey band have an entry in the legend, which tells their number
    is_told = bool(laws_in_band(comparison, looks))
    other_texts = [f"grey: {count_text(grey, 'other law')}"] if grey and not is_told else []
    results = [run.result for run in comparison.runs if run.result is not None]
    last = max(result.time[-1] for result in results)
    if shown_span(comparison)[1] < last:
        other_texts.append(f"the runs end at {last:g} s")
    is_free = comparison.is_free or bool(comparison.no_restitution)
    limits_text, limit = "" if is_free else "not free", comparison.reached[0].lossless
    if math.isfinite(limit) and not comparison.pressed_again and (limits_text or f"{limit:.2f}" != "1.00"):
        limits_text = (
            f"{limits_text or 'with other forces during the impact'}: e′ = {limit:.2f} without losses"
        )
    lossless_laws = [
        run for run in comparison.runs if run.law == LOSSLESS_LAW and laws_with_e(comparison) != [run]
    ]
    lossless_text = (
        f"{LOSSLESS_LAW}, without e: {top}"
        if lossless_laws and (top := peak_range_text(comparison, lossless_laws))
        else ""
    )
    texts = (hit_text, comparison.no_restitution, limits_text, stiffness_text, tolerance_text, lossless_text)
    return SEPARATOR.join(
        filter(None, (rest_of_headline(comparison) if is_small else "", *texts, *other_texts))
    )


def draw_loops(axes: Axes, comparison: LawRuns[LawRecording], looks: Looks) -> None:
    """Draw force over penetration in the first impact; an impulse is a vertical line at penetration 0.

    The loops of the laws of ``laws_in_band`` are drawn by ``draw_grey_loops``. A law whose ``LawRun.loop`` is
    None has no line.
    """
    band = laws_in_band(comparison, looks)
    loops = {law: loop for law in looks if (loop := comparison[law].loop) is not None}
    name = "moment" if comparison.is_at_stop else "force"
    units = [
        unit_at(quantity, is_stop=comparison.is_at_stop) for quantity in ("max_penetration", "peak_force")
    ]
    # no loop at all: the largest values are 0
    maxima = [(0.0, 0.0), *(loop.max(axis=1) for loop in loops.values() if loop.size)]
    largest_values = np.max(maxima, axis=0)
    factors, (depth_unit, force_unit) = zip(*map(prefixed_unit, largest_values, units), strict=True)
    loops = {law: loop * np.reshape(factors, (2, 1)) if loop.size else loop for law, loop in loops.items()}
    draw_grey_loops(axes, [loops[law] for law in band if law in loops and loops[law].size])
    for law in (law for law, loop in loops.items() if not loop.size):
        axes.axvline(0.0, **looks[law])
    lines = {law: with_jump(law, loop) for law, loop in loops.items() if loop.size and law not in band}
    draw_lines(axes, lines, looks)
    axes.set(
        xlabel=f"penetration in the {compared_impact(comparison.scene)} [{depth_unit}]",
        ylabel=f"{name} [{force_unit}]",
    )
    give_ticks(axes)


def laws_in_band(comparison: LawRuns[LawRecording], looks: Looks) -> list[str]:
    """Return the laws in ``looks`` that are grey and whose runs have a result.

    If at most MOST_GREY laws are so, the result is empty.
    """
    grey = [
        law for law, look in looks.items() if look["color"] == GREY and comparison[law].result is not None
    ]
    return grey if len(grey) > MOST_GREY else []


def band_label(comparison: LawRuns[LawRecording], band: Sequence[str], *, is_small: bool = False) -> str:
    """Return the label of the grey band: the number of its laws, and the laws with the extreme e′.

    If the e′ do not describe the contact alone (``has_restitution``), peak forces replace them.

    ``is_small``: whether the label is for a narrow figure, and must be short.
    """
    count = sum(
        run.law == law or are_loops_equal(comparison[law].loop, run.loop)
        for law in band
        for run in comparison.runs
    )
    if not comparison.has_restitution:
        others_text = f"{count} others" if is_small else count_text(count, "other law")
        return f"{others_text}{peaks_of_band(comparison, band)}"
    laws = [law for law in band if math.isfinite(comparison[law].restitution)] or list(band)
    order = sorted(laws, key=lambda law: comparison[law].restitution)
    prefix = "" if is_small else "e′ = "
    extremes_text = " to ".join(
        f"{law} ({prefix}{comparison[law].restitution:.2f})" for law in (order[0], order[-1])
    )
    return (
        f"{count} others: {extremes_text}"
        if is_small
        else f"{count_text(count, 'other law')}: {extremes_text}"
    )


def peaks_of_band(comparison: LawRuns[LawRecording], band: Sequence[str]) -> str:
    """Return the laws with the extreme peak forces: ": ye (1 kN) to flores (2 kN)"; "" without forces."""
    forces = {law: force for law in band if (force := comparison[law].peak_force) > 0.0}
    if not forces:
        return ""
    unit = unit_at("peak_force", is_stop=comparison.is_at_stop)
    extremes = (choose(forces, key=lambda law: forces[law]) for choose in (min, max))
    end_texts = (f"{law} ({force_text(forces[law], unit)})" for law in extremes)
    return f": {' to '.join(dict.fromkeys(end_texts))}"


def draw_compared_energy(axes: Axes, comparison: LawRuns[LawRecording], looks: Looks) -> None:
    """Draw the total energy over time; the laws of ``laws_in_band`` share one grey band.

    The line of a law has a cross in the colour of the line at ``LawRun.divergence_time``, the onset of the
    first impact that differs between this law and the reference law, if there is such an impact. The energy
    has the same zero as in the picture of the motion under the reference law.
    """
    reference = comparison[comparison.reference].result
    assert reference is not None
    offset = shown_energies(reference)[1]
    band = laws_in_band(comparison, looks)
    results = [result for law in band if (result := comparison[law].result) is not None]
    if results:
        totals = [energy_course(result, offset) for result in results]
        time = np.unique(np.concatenate([moments for moments, _ in totals]))
        curves = [np.interp(time, moments, total, right=np.nan) for moments, total in totals]
        figure = axes.get_figure(root=True)
        is_small = figure is not None and is_narrow(figure)
        draw_band(axes, time, curves, band_label(comparison, band, is_small=is_small))
    courses = {
        law: energy_course(result, offset)
        for law in looks
        if (result := comparison[law].result) is not None and law not in band
    }
    draw_lines(axes, courses, looks)
    mark: dict[str, Any] = {"marker": "x", "s": 22.0, "linewidth": 1.3}
    times = {law: comparison[law].divergence_time for law in courses}
    parted = {law: moment for law, moment in times.items() if math.isfinite(moment)}
    for law, moment in parted.items():
        energy = np.interp(moment, *courses[law])
        axes.scatter(moment, energy, color=looks[law]["color"], zorder=5.0, **mark)
    if parted:
        label = f"first impact that differs from {comparison.reference}"
        axes.scatter([], [], color=INK, label=label, **mark)
    start, end = shown_span(comparison)
    axes.set_xlabel(name_time(axes, end))
    label = f"total {offset_text(offset)} [J]" if offset else "total energy [J]"
    axes.set(ylabel=label, xlim=(start, end))
    give_ticks(axes)


def energy_course(result: Recording, offset: float) -> np.ndarray:
    """Return times [s], with those within impacts, and the total energy plus ``offset`` [J], shape (2, S)."""
    time, energies = result.detailed_energies
    return np.array([time, offset + energies["total"]])


def shown_span(comparison: LawRuns[LawRecording]) -> tuple[float, float]:
    """Return start and end of the axis of time of the energies [s].

    The axis starts shortly before the first impact, because all curves are equal before it, and ends shortly
    after the last moment at which an energy under a law with losses differs from its end (SETTLED); without
    such a moment after the first impact, it ends with the longest run.
    """
    results = [run.result for run in comparison.runs if run.result is not None]
    spans = [shown_time(result) for result in results]
    start, end = min(span.start for span in spans), max(span.end for span in spans)
    first = min((result.impacts["onset"][0] for result in results if len(result.impacts)), default=start)
    totals = {run.law: run.result.energies["total"] for run in comparison.runs if run.result is not None}
    least_change = SETTLED * float(np.ptp(np.concatenate([*totals.values()])))
    moving_ends = [
        float(result.time[np.flatnonzero(np.abs(total - total[-1]) > least_change)].max(initial=start))
        for result, (law, total) in zip(results, totals.items(), strict=True)
        if law != LOSSLESS_LAW
    ]
    settled = max(moving_ends, default=end)
    if settled > first:
        end = min(end, settled + TRAIL_SHARE * (settled - first))
    return max(start, first - LEAD_SHARE * (end - first)), end


def draw_lines(axes: Axes, lines: dict[str, np.ndarray], looks: Looks) -> None:
    """Draw a line for each law; ``lines``: law → points of the line, shape (2, S)."""
    for law, (x, y) in lines.items():
        axes.plot(x, y, **looks[law])


def dash_laws(*panels: Axes) -> None:
    """Give coloured lines in each panel dashes where they coincide, so that each of them is visible.

    The line of the reference needs no dashes, because it is wide and below all others.
    """
    for axes in panels:
        dash_lines(
            axes,
            [
                line
                for line in axes.lines
                if line.get_zorder() > REFERENCE_LAYER and line.get_color() not in (GREY, INK)
            ],
        )


def move_to_foot(figure: Figure, handles: Sequence[Any]) -> list[Any]:
    """Explain the entries of a legend that are no lines of laws at the foot of a figure, if there is room.

    These entries are the crosses and the grey band. The result has the entries that the legend then needs:
    those of lines of laws or, if nothing is written at the foot, all ``handles``.
    """
    laws = [handle for handle in handles if isinstance(handle, Line2D)]
    other_handles = [handle for handle in handles if handle not in laws]
    marks = [
        f"{'×' if isinstance(key, PathCollection) else 'grey'}: {key.get_label()}" for key in other_handles
    ]
    return laws if marks and write_foot(figure, "; ".join(marks)) else list(handles)


def legend_handles(looks: Looks, *panels: Axes) -> list[Any]:
    """Return the entries of the legend of panels: laws with a colour, laws of impulses, crosses, a band."""
    styles = {look["label"]: Line2D([], [], **look) for look in looks.values() if look["color"] != GREY}
    lines = dict.fromkeys(line.get_label() for axes in panels for line in axes.lines)
    bands: list[Any] = [collection for axes in panels for collection in axes.collections]
    drawn_styles = [styles[label] for label in lines if label in styles]
    keys = [band for band in bands if str(band.get_label())[:1] != "_"]
    return [*drawn_styles, *keys]

"""The picture of a comparison of contact laws: force over penetration in the first impact, and energy.

At most six laws have a colour: the reference, the scene's own law, the law without losses, a law whose force
jumps at the onset, the law with losses whose realised restitution differs most from that of the reference,
and laws in USED_LAWS. One law can be several of these. The reference is the law with which every other law is
compared. A law without a colour is grey or, if it is a law of impulses, dotted in the colour of text.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from chain_impact.pictures.drawing.distinct_curves import MOST_GREY, fill_band, parts_with_dashes
from chain_impact.pictures.drawing.end_labels import EndLabel, spread, write_end_labels
from chain_impact.pictures.drawing.figures import check_alone, draw_figure, settle
from chain_impact.pictures.drawing.law_looks import LAW_LOOKS, law_look
from chain_impact.pictures.drawing.legends import legend_at_head
from chain_impact.pictures.drawing.line_breaks import SEPARATOR
from chain_impact.pictures.drawing.sizes import Size
from chain_impact.pictures.drawing.style import (
    GREY,
    INK,
    drawing_style,
    give_ticks,
    is_narrow,
    raise_exponents,
    write_headline,
)
from chain_impact.pictures.drawing.users_axes import draw_into, fit_into_figure
from chain_impact.pictures.over_time.energies import offset_text, shown_energies
from chain_impact.pictures.over_time.rests import shown_time
from chain_impact.pictures.over_time.time_axis import name_time
from chain_impact.scene.texts.unit_text import stiffness_unit
from chain_impact.studies.compare.grey_loops import HAIRLINE, fill_loops
from chain_impact.studies.compare.headline import headline, laws_with_e, peaks
from chain_impact.studies.compare.runs import LawRuns, has_jump, with_jump
from chain_impact.studies.law_exchange import LOSSLESS_LAW, compared_impact
from chain_impact.text import count_text, number_text, prefixed_unit
from chain_impact.variables.impact_units import unit_at

SIZE = (10.0, 4.8)  # [inch] default width and height of the figure
# matplotlib's zorder for the line of the reference law; lines with a larger zorder are drawn over it
REFERENCE_LAYER = 3
# the reason for the colour of a law whose force is above 0 at penetration 0
JUMP_NOTE_OF_LAW = "force jumps at the onset"
IMPULSE_ENDING = " (impulse)"  # the end of the label of a law of impulses, if the law has no colour
IMPULSE: dict[str, Any] = {**LAW_LOOKS["newton_impact"], "linewidth": 1.2, "zorder": 3.5}
"""The look of the line of a law of impulses that has no colour."""
# the heights of the panels of loops and energy, relative to each other, in a narrow figure
LOOPS_ABOVE: Any = (1.5, 1.0)
LEAST_NAMED = 4.3  # [inch] the least width of a figure with names of laws at the ends of lines
LEAD_SHARE = 0.1  # longest time shown before the first impact, relative to the time shown after its onset
COLOURED_LAWS = 6  # largest number of laws with a colour
USED_LAWS = ("hunt_crossley", "lankarani_nikravesh", "flores", "kelvin_voigt", "newton_impact")
"""Ids of laws that many programs and papers use; they get the colours that other laws leave free."""

Looks = dict[str, dict[str, Any]]


def plot_comparison(
    comparison: LawRuns,
    path: str | os.PathLike[str] | None = None,
    size: Size | None = None,
    ax: Any = None,
) -> Any:
    """Draw the picture of a comparison, as ``Comparison.plot`` describes."""
    if ax is None:
        return draw_figure(partial(fill, comparison=comparison), path, size, SIZE)
    check_alone(path, size)
    with draw_into([ax]):
        draw_loops(ax, comparison, looks_of(comparison))
        dash_lines(ax)
        ax.legend(handles=legend_handles(looks_of(comparison), ax))
        fit_into_figure([ax])
    return ax


@drawing_style()
def fill(figure: Figure, comparison: LawRuns) -> None:
    """Draw the two panels of the picture on an empty figure."""
    is_small = is_narrow(figure)
    looks = looks_of(comparison, is_small=is_small)
    write_headline(figure, headline(comparison, is_small=is_small), conditions(comparison, looks))
    panels: dict[str, Any] = {"nrows": 2, "height_ratios": LOOPS_ABOVE} if is_small else {"ncols": 2}
    loops, energy = figure.subplots(**panels)
    draw_loops(loops, comparison, looks)
    draw_energy(energy, comparison, looks)
    names = name_ends(energy, comparison, looks) if figure.get_figwidth() >= LEAST_NAMED else []
    dash_lines(loops, energy)
    legend_at_head(figure, legend_handles(looks, energy, loops))
    settle(figure)
    spread(energy, names)


def name_ends(axes: Axes, comparison: LawRuns, looks: Looks) -> list[EndLabel]:
    """Write the laws with a colour, and those of impulses, at the right ends of their lines of energy."""
    lines, (_, end), reference = [], axes.get_xlim(), comparison[comparison.reference].result
    assert reference is not None
    offset = shown_energies(reference)[1]
    for law, look in looks.items():
        result = comparison[law].result
        if result is not None and look["color"] != GREY:
            value = float(np.interp(end, result.time, offset + result.energy["total"]))
            lines.append((law, value, look["color"]))
    return write_end_labels(axes, lines)


def conditions(comparison: LawRuns, looks: Looks) -> str:
    """Return the text below the headline.

    The text has these parts: effective mass and speed of the first impact; the reason if the e′ do not
    describe the contact alone (``no_restitution``); a remark if the impact is not free; the e′ without
    losses, if e′ is known, the contact is not ``pressed_again``, and e′ is not 1.00 or the impact not free;
    stiffness and tolerance; the peak force of the law without e; the number of grey lines, unless the grey
    lines are drawn as a band; the end of the runs, if the panel of energy does not show it.
    """
    contact, impact = comparison.contact, comparison.first_impact
    names = ("effective_mass", "impact_speed", "peak_force", "max_penetration")
    mass, speed, force, depth = (unit_at(name, stop=comparison.is_at_stop) for name in names)
    per = f"{force}/{depth}"
    motion_text = f"{impact['effective_mass']:.3g} {mass} at {impact['impact_speed']:.3g} {speed}"
    hit = f"{compared_impact(comparison.scene)} of {motion_text}"
    unit = raise_exponents(stiffness_unit(per, contact.exponent))
    stiffness = f"stiffness K = {number_text(contact.stiffness)} {unit}"
    tolerance = f"tolerance {number_text(comparison.scene.solver.tolerance)}"
    grey = sum(look["color"] == GREY for look in looks.values())
    # whether the laws in the grey band have an entry in the legend, which tells their number
    is_told = bool(laws_in_band(comparison, looks))
    other_texts = [f"grey: {count_text(grey, 'other law')}"] if grey and not is_told else []
    results = [run.result for run in comparison.runs if run.result is not None]
    last = max(result.time[-1] for result in results)
    if max(shown_time(result).end for result in results) < last:
        other_texts.append(f"the runs end at {last:g} s")
    is_free = comparison.is_free or bool(comparison.no_restitution)
    limits, limit = "" if is_free else "not free", comparison.reached[0].lossless
    if math.isfinite(limit) and not comparison.pressed_again and (limits or f"{limit:.2f}" != "1.00"):
        limits = f"{limits or 'with other forces during the impact'}: e′ = {limit:.2f} without losses"
    lossless_laws = [
        run for run in comparison.runs if run.law == LOSSLESS_LAW and laws_with_e(comparison) != [run]
    ]
    without_e = (
        f"{LOSSLESS_LAW}, without e: {top}"
        if lossless_laws and (top := peaks(comparison, lossless_laws))
        else ""
    )
    return SEPARATOR.join(
        filter(None, (hit, comparison.no_restitution, limits, stiffness, tolerance, without_e, *other_texts))
    )


def named_laws(comparison: LawRuns) -> dict[str, str]:
    """Return the laws that get a colour, at most COLOURED_LAWS: law → reason, "" for a law in USED_LAWS.

    A law with several reasons has them all, with commas between them. The reasons are: "reference"; "of the
    scene", unless the scene's law is the reference; "no losses", for the law LOSSLESS_LAW, if the
    restitution in the first impact under LOSSLESS_LAW differs from that under the reference; "differs most
    with losses", for the law whose restitution is farthest from that under the reference; and
    JUMP_NOTE_OF_LAW. LOSSLESS_LAW does not count as the farthest, because it ignores the prescribed
    restitution. No law is the farthest if the restitutions do not describe the contact alone
    (``has_restitution``).
    """
    reference = comparison.reference
    reasons = {reference: "reference"}
    reasons.setdefault(comparison.contact.model, "of the scene")
    reference_restitution = comparison[reference].restitution
    deviations = {run.law: abs(run.restitution - reference_restitution) for run in comparison.runs}
    if deviations.pop(LOSSLESS_LAW, math.nan) > 0.0:
        _add_reason(reasons, LOSSLESS_LAW, "no losses")
    differ = sorted((law for law in deviations if deviations[law] > 0.0), key=lambda law: -deviations[law])
    for law in differ[:1] if comparison.has_restitution else ():
        _add_reason(reasons, law, "differs most with losses")
    for law in (run.law for run in comparison.runs if run.loop is not None and run.loop.size):
        if has_jump(law):
            _add_reason(reasons, law, JUMP_NOTE_OF_LAW)
    for run in comparison.runs:
        if run.law in USED_LAWS and run.result is not None and len(reasons) < COLOURED_LAWS:
            reasons.setdefault(run.law, "")
    return reasons


def _add_reason(reasons: dict[str, str], law: str, reason: str) -> None:
    """Add a reason for the colour of a law to ``reasons`` (law → reasons, separated by commas)."""
    reasons[law] = f"{reasons[law]}, {reason}" if law in reasons else reason


def looks_of(comparison: LawRuns, *, is_small: bool = False) -> Looks:
    """Return the looks of the lines: law → keywords of matplotlib's ``plot``, with colour and label.

    Laws with equal loops share one line, under the first of these laws; its label names all of them. A label
    has the reasons of ``named_laws`` for the first of these laws that has any and, if the e′ describe the
    contact alone, e′ of the first impact. With ``is_small`` only the labels of the reference and of
    LOSSLESS_LAW have reasons, and only that of the reference has the sign e′. The label of a law that acts by
    impulses and has no colour is only the law's id with IMPULSE_ENDING. The laws are in the order of their
    e′, the largest first.
    """
    chosen_reasons = named_laws(comparison)
    twins: dict[str, list[str]] = {}
    for run in comparison.runs:
        loop = run.loop
        twin = next((rival for rival in twins if _are_loops_equal(comparison[rival].loop, loop)), run.law)
        twins.setdefault(twin, []).append(run.law)
    looks: Looks = {}
    for first in sorted(twins, key=lambda law: -np.nan_to_num(comparison[law].restitution)):
        laws = twins[first]
        reasons = [chosen_reasons[law] for law in laws if law in chosen_reasons]
        first_reason = next(filter(None, reasons), "")
        is_brief = is_small and comparison.reference not in laws
        if is_brief and LOSSLESS_LAW not in laws:
            first_reason = ""
        restitution = comparison[first].restitution
        is_told = comparison.has_restitution and math.isfinite(restitution)
        restitution_text = f"{'' if is_brief else 'e′ = '}{restitution:.2f}" if is_told else ""
        reason_text = ", ".join(filter(None, (first_reason, restitution_text)))
        label = ", ".join(laws) + (f" ({reason_text})" if reason_text else "")
        if comparison.reference in laws:
            look = law_look(comparison.reference) | {"linewidth": 2.4, "zorder": REFERENCE_LAYER}
        elif reasons:
            named_law = next(law for law in laws if law in chosen_reasons)
            look = law_look(named_law) | {"linewidth": 1.7, "zorder": 4}
        elif (loop := comparison[first].loop) is not None and not loop.size:
            label, look = f"{first}{IMPULSE_ENDING}", IMPULSE
        else:
            look = {"color": GREY, "linewidth": 0.9, "zorder": 2}
        looks[first] = {"label": label, **look}
    return looks


def _are_loops_equal(loop: np.ndarray | None, twin: np.ndarray | None) -> bool:
    """Return whether two loops of force over penetration (``LawRun.loop``) are equal.

    An empty loop, that of an impulse, and None, for an impact that has not ended, equal no loop.
    """
    return loop is not None and twin is not None and loop.size > 0 and np.array_equal(loop, twin)


def draw_loops(axes: Axes, comparison: LawRuns, looks: Looks) -> None:
    """Draw force over penetration in the first impact; an impulse is a vertical line at penetration 0.

    The loops of the laws of ``laws_in_band`` are drawn by ``fill_loops``. A law whose ``LawRun.loop`` is None
    has no line.
    """
    band = laws_in_band(comparison, looks)
    loops = {law: loop for law in looks if (loop := comparison[law].loop) is not None}
    name = "moment" if comparison.is_at_stop else "force"
    units = [unit_at(quantity, stop=comparison.is_at_stop) for quantity in ("max_penetration", "peak_force")]
    largest_values = np.max([loop.max(axis=1) for loop in loops.values() if loop.size], axis=0, initial=0.0)
    factors, (depth_unit, force_unit) = zip(*map(prefixed_unit, largest_values, units), strict=True)
    loops = {law: loop * np.reshape(factors, (2, 1)) if loop.size else loop for law, loop in loops.items()}
    fill_loops(axes, [loops[law] for law in band if law in loops and loops[law].size])
    for law in (law for law, loop in loops.items() if not loop.size):
        axes.axvline(0.0, **looks[law])
    lines = {law: with_jump(law, loop) for law, loop in loops.items() if loop.size and law not in band}
    draw_lines(axes, lines, looks)
    axes.set(
        xlabel=f"penetration in the {compared_impact(comparison.scene)} [{depth_unit}]",
        ylabel=f"{name} [{force_unit}]",
    )
    give_ticks(axes)


def laws_in_band(comparison: LawRuns, looks: Looks) -> list[str]:
    """Return the laws in ``looks`` that are grey and whose runs have a result.

    If at most MOST_GREY laws are so, the result is empty.
    """
    grey = [
        law for law, look in looks.items() if look["color"] == GREY and comparison[law].result is not None
    ]
    return grey if len(grey) > MOST_GREY else []


def band_label(comparison: LawRuns, band: Sequence[str], *, is_small: bool = False) -> str:
    """Return the label of the grey band: the number of its laws, and the laws with the extreme e′.

    If the e′ do not describe the contact alone (``has_restitution``), the label has only the number.

    ``is_small``: whether the label is for a narrow figure, and must be short.
    """
    count = sum(
        run.law == law or _are_loops_equal(comparison[law].loop, run.loop)
        for law in band
        for run in comparison.runs
    )
    if not comparison.has_restitution:
        return count_text(count, "other law")
    laws = [law for law in band if math.isfinite(comparison[law].restitution)] or list(band)
    order = sorted(laws, key=lambda law: comparison[law].restitution)
    prefix = "" if is_small else "e′ = "
    extremes = " to ".join(
        f"{law} ({prefix}{comparison[law].restitution:.2f})" for law in (order[0], order[-1])
    )
    return f"{count} others: {extremes}" if is_small else f"{count_text(count, 'other law')}: {extremes}"


def draw_energy(axes: Axes, comparison: LawRuns, looks: Looks) -> None:
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
        time = max((result.time for result in results), key=len)
        totals = [(result.time, offset + result.energy["total"]) for result in results]
        curves = [np.interp(time, *total, right=np.nan) for total in totals]
        figure = axes.get_figure(root=True)
        is_small = figure is not None and is_narrow(figure)
        fill_band(axes, time, curves, band_label(comparison, band, is_small=is_small))
    courses = {
        law: np.array([result.time, offset + result.energy["total"]])
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
    run_results = [run.result for run in comparison.runs if run.result is not None]
    time_spans = [shown_time(result) for result in run_results]
    end = max(time.end for time in time_spans)
    axes.set_xlabel(name_time(axes, end))
    start = min(time.start for time in time_spans)
    first = min((result.impacts["onset"][0] for result in run_results if len(result.impacts)), default=start)
    # before the first impact all curves are equal, so only the last part of the time before it is shown
    label = f"total {offset_text(offset)} [J]" if offset else "total energy [J]"
    axes.set(ylabel=label, xlim=(max(start, first - LEAD_SHARE * (end - first)), end))
    give_ticks(axes)


def draw_lines(axes: Axes, lines: dict[str, np.ndarray], looks: Looks) -> None:
    """Draw a line for each law; ``lines``: law → points of the line, shape (2, S)."""
    for law, (times, energies) in lines.items():
        axes.plot(times, energies, **looks[law])


def dash_lines(*panels: Axes) -> None:
    """Give coloured lines in each panel dashes where they coincide, so that each of them is visible.

    The line of the reference needs no dashes, because it is wide and below all others. A line keeps its label
    and its solid parts; the parts with dashes are further lines.
    """
    for axes in panels:
        lines = [
            line
            for line in axes.lines
            if line.get_zorder() > REFERENCE_LAYER and line.get_color() not in (GREY, INK)
        ]
        parts = parts_with_dashes([np.array(line.get_data(), float) for line in lines])
        for line, own_parts in zip(lines, parts, strict=True):
            styles: dict[Any, list[np.ndarray]] = {}
            for points, dashes in own_parts:
                styles.setdefault(dashes, []).append(np.append(points, [[math.nan]] * 2, axis=1))
            if len(own_parts) == 1 and None in styles:
                continue
            line.set_data(np.concatenate(styles.pop(None, [np.zeros((2, 0))]), axis=1))
            look: dict[str, Any] = {"color": line.get_color(), "linewidth": line.get_linewidth()}
            for dashes, pieces in styles.items():
                joined_part = np.concatenate(pieces, axis=1)
                axes.plot(*joined_part, **look, linestyle=dashes, zorder=line.get_zorder(), label="_")


def legend_handles(looks: Looks, *panels: Axes) -> list[Any]:
    """Return the entries of the legend of panels: laws with a colour, laws of impulses, crosses, a band."""
    styles = {look["label"]: Line2D([], [], **look) for look in looks.values() if look["color"] != GREY}
    lines = dict.fromkeys(line.get_label() for axes in panels for line in axes.lines)
    bands: list[Any] = [collection for axes in panels for collection in axes.collections]
    drawn_styles = [styles[label] for label in lines if label in styles]
    keys = [band for band in bands if str(band.get_label())[:1] != "_"]
    # without an area in the panel of loops, the entry of an area is a thin line, as there
    if not any(isinstance(area, PolyCollection) for area in panels[-1].collections):
        line: dict[str, Any] = {"color": GREY, "linewidth": 2.0 * HAIRLINE}
        areas = [k for k, key in enumerate(keys) if isinstance(key, PolyCollection)]
        for k in areas:
            keys[k] = Line2D([], [], label=keys[k].get_label(), **line)
    return [*drawn_styles, *keys]

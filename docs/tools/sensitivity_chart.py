"""Draw the influence of the default scene's parameters over time: ``python -m docs.tools.sensitivity_chart``.

The chart shows the displacement of the tip, and the change of each impact's peak force, if one parameter p
grows by 1 %: to first order 0.01 p ∂y/∂p, from one run with derivatives. Of several parameters of a kind, the
chart shows the largest effect.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chain_impact import Result, simulate
from chain_impact.pictures.drawing.colours import BLACK, PALETTE
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.style import DPI, STYLE
from chain_impact.pictures.over_time.time_axis import mark_impacts
from chain_impact.pictures.rows_of_impacts import is_outside_impacts
from chain_impact.pictures.sensitivity_table import SIGNED_COLOURS, cell_text, colour_norm
from chain_impact.recording.sensitivity import Sensitivities
from docs.tools import DOCS

WIDTH = 190.0 / 25.4  # [inch] that of a printed page
PICTURE = DOCS / "images" / "sensitivity_chart.png"
SCENE, STOP, TIP = "four_link_box", 1.2, 4  # scene; stop time [s], after six impacts; number of the tip
KINDS = {
    "contact stiffness": ("contact.stiffness",),
    "restitution": ("contact.restitution",),
    "a mass": tuple(f"link[{i}].mass" for i in range(1, 5)),
    "an initial rate": tuple(f"initial.angular_velocity[{i}]" for i in range(1, 5)),
    "an initial angle": tuple(f"initial.angle[{i}]" for i in range(1, 5)),
    "gravity": ("gravity.y",),
}
LABELS_APART = 2.2  # the least ratio of the heights of two names at the ends of curves
COLOURS = dict(zip(KINDS, (*PALETTE[: len(KINDS) - 1], BLACK), strict=True))
LEAST_DISPLACEMENT = 1e-6  # [m] lower limit of the axis of displacements
COLOUR_RANGE = 10.0  # [%] end of the colours; the first order does not predict a larger change
# a displacement is predicted up to this part of the range of the tip; from then on, its curve is pale
MOST_PREDICTED, PALE = 0.01 * COLOUR_RANGE, 0.3
CONDITIONS = (
    "default scene; + 1 %, to first order; of masses, rates and angles the one that matters most; "
    f"pale curves, and changes beyond ± {COLOUR_RANGE:g} %: no prediction; "
    "grey lines: impacts, in which curves have gaps"
)


def slopes_of(result: Result) -> Sensitivities:
    """Return the derivatives of a run that has derivatives."""
    assert result.sensitivities is not None
    return result.sensitivities


def by_kind(changes: np.ndarray, result: Result) -> dict[str, np.ndarray]:
    """Return kind → that of its parameters' changes with the largest size, shape (…), with its sign.

    ``changes``: shape (…, P).
    """
    names = list(slopes_of(result).parameters)
    changes_by_kind = {}
    for kind, members in KINDS.items():
        member_changes = changes[..., [names.index(name) for name in members]]
        largest_member = np.abs(np.nan_to_num(member_changes)).argmax(axis=-1)[..., np.newaxis]
        changes_by_kind[kind] = np.take_along_axis(member_changes, largest_member, axis=-1)[..., 0]
    return changes_by_kind


def moved(result: Result) -> dict[str, np.ndarray]:
    """Return kind → largest displacement of the tip, shape (T,) [m]; NaN within impacts."""
    slopes = slopes_of(result)
    sizes = np.hypot(slopes.changes(f"point[{TIP}].x"), slopes.changes(f"point[{TIP}].y"))
    sizes[~is_outside_impacts(result)] = np.nan
    return by_kind(sizes, result)


def is_predicted(result: Result) -> dict[str, np.ndarray]:
    """Return kind → whether its displacement is small enough for a prediction up to a time, shape (T,)."""
    span = max(float(np.ptp(result[f"point[{TIP}].{axis}"])) for axis in "xy")
    return {
        kind: np.maximum.accumulate(np.nan_to_num(size)) <= MOST_PREDICTED * span
        for kind, size in moved(result).items()
    }


def message(result: Result) -> str:
    """Return words for the ratio of the largest to the smallest effect on the tip at the last prediction.

    This is the last time at which all displacements are predicted and all parameters have an effect.
    """
    sizes, are_predicted = moved(result), is_predicted(result)
    is_known = np.all([*are_predicted.values()], axis=0) & np.all([*sizes.values()], axis=0)
    is_known &= np.isfinite([*sizes.values()]).all(axis=0)
    row = int(np.flatnonzero(is_known)[-1])
    ends = {kind: size[row] for kind, size in sizes.items()}
    strongest, weakest = max(ends, key=ends.__getitem__), min(ends, key=ends.__getitem__)
    ratio = float(f"{ends[strongest] / ends[weakest]:.2g}")
    count = int((result.impacts["onset"] <= result.time[row]).sum())
    time_text = f"{result.time[row]:.2g} s, after {count} impacts"
    return f"1 % of {strongest} moves the tip {ratio:.0f} times as far as 1 % of {weakest} at {time_text}"


def draw_motion(axes: Axes, result: Result) -> None:
    """Draw the displacement of the tip over time, with the name of each kind at the end of its curve."""
    sizes, are_predicted, height = moved(result), is_predicted(result), 0.0
    for kind in sorted(sizes, key=lambda name: sizes[name][-1]):
        for is_shown, opacity in ((are_predicted[kind], 1.0), (~are_predicted[kind], PALE)):
            shown_sizes = np.where(is_shown, sizes[kind], np.nan)
            axes.plot(result.time, shown_sizes, color=COLOURS[kind], linewidth=1.5, alpha=opacity)
        height = max(sizes[kind][-1], LABELS_APART * height)
        look: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": "small"}
        axes.annotate(kind, (result.time[-1], height), (4.0, 0.0), color=COLOURS[kind], **look)
    mark_impacts(axes, result)
    axes.set(yscale="log", ylim=(LEAST_DISPLACEMENT, 5.0), xlabel="time [s]")
    axes.set_title(f"how far point {TIP} moves [m]", fontsize="medium", loc="left")
    axes.margins(x=0.0)


def far_text(share: float) -> str:
    """Return the text of a change beyond the end of the colours: "> +10" or "< −10" [%]."""
    return f"> +{COLOUR_RANGE:g}" if share > 0.0 else f"< −{COLOUR_RANGE:g}"


def draw_forces(axes: Axes, result: Result) -> None:
    """Draw the change of each peak force in percent, as the table of a picture of derivatives."""
    shares = by_kind(100.0 * slopes_of(result).relative("peak_force"), result)
    table = np.array(list(shares.values()))
    axes.imshow(table, SIGNED_COLOURS, aspect="auto", norm=colour_norm(COLOUR_RANGE))
    for (row, column), share in np.ndenumerate(table):
        look: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "small", "color": BLACK}
        is_known = abs(share) <= COLOUR_RANGE
        axes.text(column, row, cell_text(share) if is_known else far_text(share), **look)
    names = [f"{k + 1}\n{hit['onset']:.2f} s" for k, hit in enumerate(result.impacts)]
    axes.set_xticks(range(len(names)), names)
    axes.set_yticks(range(len(KINDS)), list(KINDS))
    for label, colour in zip(axes.get_yticklabels(), COLOURS.values(), strict=True):
        label.set_color(colour)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.set_xlabel("impact")
    axes.set_title("change of peak force [%]", fontsize="medium", loc="left")


def draw(path: Path) -> None:
    """Draw the motion on the left, and the forces on the right."""
    names = [name for members in KINDS.values() for name in members]
    result = simulate(SCENE, STOP, tolerance=1e-10, sensitivities=names)
    assert result.sensitivity_limits == ()
    with mpl.rc_context(STYLE):
        page = Figure(figsize=(WIDTH, 4.4), dpi=DPI, layout="constrained")
        motion, forces = page.subplots(1, 2, width_ratios=(1.0, 1.05))
        draw_motion(motion, result)
        draw_forces(forces, result)
        write_headline(page, message(result), CONDITIONS)
        page.savefig(path, dpi="figure")


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)

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
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from chain_impact import Result, simulate
from chain_impact.pictures.drawing.dark_ground import is_dark
from chain_impact.pictures.drawing.style import BLACK, DPI, PALETTE, STYLE, write_headline
from chain_impact.pictures.over_time.time_axis import mark_impacts
from chain_impact.pictures.rows_of_impacts import is_outside_impacts
from chain_impact.recording.sensitivity import Sensitivities
from chain_impact.text import number_text
from docs.tools import DOCS

WIDTH = 190.0 / 25.4  # [inch] that of a printed page
PICTURE = DOCS / "images" / "sensitivity_chart.png"
SCENE, STOP, TIP = "four_link_box", 1.2, 4  # scene; stop time [s], after six impacts; number of the tip
KINDS = {
    "contact stiffness": ("contact.stiffness",),
    "contact exponent": ("contact.exponent",),
    "restitution": ("contact.restitution",),
    "a mass": tuple(f"link[{i}].mass" for i in range(1, 5)),
    "an initial rate": tuple(f"initial.angular_velocity[{i}]" for i in range(1, 5)),
    "an initial angle": tuple(f"initial.angle[{i}]" for i in range(1, 5)),
    "gravity": ("gravity.y",),
}
TITLE = "Effect of 1 % of each parameter: on the tip [m] and on peak forces [%]"
COLOURS = dict(zip(KINDS, (*PALETTE, BLACK), strict=True))
LEAST_DISPLACEMENT = 1e-6  # [m] lower limit of the axis of displacements
# [%] range of the colours; the first order does not predict a change above COLOUR_RANGE
COLOUR_RANGE = 10.0
RANGE = (1e-2, COLOUR_RANGE)
CONDITIONS = (
    "default scene; + 1 %, to first order; of masses, rates and angles the one that matters most; "
    f"> {COLOUR_RANGE:g} %: too large for a prediction to first order"
)


def slopes_of(result: Result) -> Sensitivities:
    """Return the derivatives of a run that has derivatives."""
    assert result.sensitivities is not None
    return result.sensitivities


def by_kind(changes: np.ndarray, result: Result) -> dict[str, np.ndarray]:
    """Return kind → the largest of its parameters' changes, shape (…), from ``changes``, shape (…, P)."""
    names = list(slopes_of(result).parameters)
    return {
        kind: np.abs(changes[..., [names.index(name) for name in members]]).max(axis=-1)
        for kind, members in KINDS.items()
    }


def moved(result: Result) -> dict[str, np.ndarray]:
    """Return kind → largest displacement of the tip, shape (T,) [m]; NaN within impacts."""
    slopes = slopes_of(result)
    sizes = np.hypot(slopes.changes(f"point[{TIP}].x"), slopes.changes(f"point[{TIP}].y"))
    sizes[~is_outside_impacts(result)] = np.nan
    return by_kind(sizes, result)


def message(result: Result) -> str:
    """Return words for the ratio of the largest to the smallest effect on the tip at the end."""
    ends = {kind: size[-1] for kind, size in moved(result).items()}
    most, least = max(ends, key=ends.__getitem__), min(ends, key=ends.__getitem__)
    ratio = float(f"{ends[most] / ends[least]:.2g}")
    return f"after {len(result.impacts)} impacts, the effect of {most} is {ratio:.0f} times that of {least}"


def draw_motion(axes: Axes, result: Result) -> None:
    """Draw the displacement of the tip over time; ``draw_forces`` writes the kinds in the same colours."""
    for kind, size in moved(result).items():
        axes.plot(result.time, size, color=COLOURS[kind], linewidth=1.5)
    mark_impacts(axes, result)
    axes.set(
        yscale="log",
        ylim=(LEAST_DISPLACEMENT, 5.0),
        xlabel="time [s]",
        ylabel=f"how far point {TIP} moves [m]",
    )
    axes.margins(x=0.0)


def draw_forces(axes: Axes, result: Result) -> None:
    """Draw the change of each peak force in percent, as colours and numbers."""
    shares = by_kind(100.0 * slopes_of(result).relative("peak_force"), result)
    table = np.array(list(shares.values()))
    image = axes.imshow(table, "Greys", aspect="auto", norm=LogNorm(*RANGE))
    for (row, column), share in np.ndenumerate(table):
        look: dict[str, Any] = {
            "ha": "center",
            "va": "center",
            "fontsize": "small",
            "color": "white" if is_dark(image.to_rgba(share)) else BLACK,
        }
        axes.text(
            column, row, number_text(share, 2) if share <= COLOUR_RANGE else f"> {COLOUR_RANGE:g}", **look
        )
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
        motion, forces = page.subplots(1, 2, width_ratios=(1.25, 1.0))
        draw_motion(motion, result)
        draw_forces(forces, result)
        write_headline(page, TITLE, f"{CONDITIONS}; {message(result)}")
        page.savefig(path, dpi="figure")


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURE)

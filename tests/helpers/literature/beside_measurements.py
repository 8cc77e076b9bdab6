"""Draw simulations beside measurements, or beside another theory, for docs/models.

``python -m tests.helpers.literature.beside_measurements``. The measured values are in
models/<model>/measured.csv.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from chain_impact import load_scene, simulate
from chain_impact.pictures import draw_figure
from chain_impact.pictures.drawing.colours import BLACK, BLUE, PALETTE, VERMILLION
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.style import STYLE
from tests.helpers.literature.measured import heard_impacts, measured
from tests.helpers.models.beam import Bar, impulse

IMAGES = Path(__file__).parents[3] / "docs" / "images"
SIZE = (8.5, 4.6)
BEAM = "Euler–Bernoulli beam"


def triple_pendulum(figure: Figure) -> None:
    """Draw angles above, and differences below."""
    columns, result = measured("triple_pendulum"), simulate("triple_pendulum")
    time = columns["time"]
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    above.tick_params(labelbottom=True)
    off = []
    for link, colour in zip((1, 2, 3), PALETTE, strict=False):
        angle = columns[f"link[{link}].angle"]
        off.append(1000 * (result.angles[:, link - 1] - angle))
        above.plot(result.time, result.angles[:, link - 1] + np.pi / 2, color=colour, linewidth=1.4)
        above.plot(time[::8], angle[::8] + np.pi / 2, ".", color=BLACK, markersize=3)
        above.annotate(
            f"link {link}",
            (time[-1], angle[-1] + np.pi / 2),
            xytext=(6, 0),
            textcoords="offset points",
            color=colour,
            va="center",
        )
        below.plot(time, off[-1], color=colour, linewidth=1.2)
    above.plot([], [], ".", color=BLACK, label="measured")
    above.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0))
    above.set(ylabel="angle from the vertical [rad]")
    below.set(xlabel="time [s]", ylabel="difference\n[mrad]", xlim=(0, time[-1]))
    below.grid(visible=True)
    write_headline(
        figure,
        "Triple pendulum: measured and simulated angles [rad]",
        "of Kaheman et al. 2023, with the parameters that its authors estimated  ·  largest difference: "
        f"{np.abs(off).max():.0f} mrad",
    )


def golf_ball(figure: Figure) -> None:
    """Draw height over time, and the time from each simulated impact to the impact that was heard."""
    heard, result = heard_impacts(), simulate("golf_ball")
    late = 1000 * (heard - result.impacts["onset"])
    height, delay = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    height.tick_params(labelbottom=True)
    height.plot(result.time, result["point[0].y"], color=BLUE, linewidth=1.4, label="simulated")
    height.plot(heard, 0 * heard, "v", color=VERMILLION, markersize=6, clip_on=False, label="heard")
    height.set(ylabel="height [m]", ylim=(0, 0.85))
    height.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    delay.plot(heard, late, "v", color=VERMILLION, markersize=5, clip_on=False)
    delay.set(
        xlabel="time [s]",
        ylabel="heard later\nby [ms]",
        xlim=(0, result.time[-1]),
        ylim=(0, 80),
        yticks=(0, 20, 40, 60, 80),
    )
    delay.grid(visible=True)
    write_headline(
        figure,
        f"Golf ball: the ninth impact is heard {late[-1]:.0f} ms after the simulated one",
        "dropped from 0.8 m, mean of four drops  ·  rigid floor, restitution 0.893 at all impacts",
    )


def steel_bar(figure: Figure) -> None:
    """Draw force over time, and the restitution of bars of several lengths."""
    scene, result = load_scene("steel_bar"), simulate("steel_bar", output_step=4e-6)
    times = np.linspace(0.0, scene.simulation.stop_time, 201)
    force, lengths = figure.subplots(1, 2, width_ratios=(3, 2))
    theory, _ = Bar(0.4).impact(times)
    first, peak = result.impacts["onset"][0], result.impacts["peak_force"].max()
    force.plot(
        1e3 * result.time,
        result["contact[0].y_min.force"],
        color=BLUE,
        linewidth=1.4,
        label="chain of 20 links",
    )
    touching = theory > 0
    force.plot(1e3 * (times + first)[touching], theory[touching], ".", color=BLACK, markersize=4, label=BEAM)
    force.set(xlabel="time [ms]", ylabel="force [N]", xlim=(0, 3), ylim=(0, None))
    some = np.linspace(0.1, 0.5, 33)
    restitutions = [bar.restitution(impulse(bar.chain(scene, 20, 1e-8))) for bar in map(Bar, some)]
    lengths.plot(some, restitutions, color=BLUE, linewidth=1.4)
    few = (0.3, 0.4, 0.5)
    exact = [bar.restitution(bar.impact(times)[1]) for bar in map(Bar, few)]
    lengths.plot(few, exact, ".", color=BLACK, markersize=7)
    lengths.set(xlabel="length of the bar [m]", ylabel="restitution without vibration", ylim=(0.6, 1.02))
    force.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
    write_headline(
        figure,
        f"Steel bar of 0.4 m: {len(result.impacts)} contacts, peak force {peak:.0f} N",
        "12 mm thick, drops flat at 0.5 m/s on an elastic support under one end  ·  "
        "right: bars of other lengths",
    )


CHARTS = {"golf_ball": golf_ball, "steel_bar": steel_bar, "triple_pendulum": triple_pendulum}


def draw(folder: Path) -> None:
    """Draw all charts, each as <model>.png."""
    for model, fill in CHARTS.items():
        with mpl.rc_context(STYLE):
            draw_figure(fill, folder / f"{model}.png", usual_size=SIZE)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else IMAGES)

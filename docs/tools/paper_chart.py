"""Draw curves of an impact of the default scene in the paper's layout: ``python -m docs.tools.paper_chart``.

The curves are deformation, its rate and acceleration, force, impulse and energy in the first impact, for some
contact laws.
"""

from __future__ import annotations

import sys

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from chain_impact import Chain, load_scene, simulate
from chain_impact.pictures.drawing.head_and_foot import write_headline
from chain_impact.pictures.drawing.law_looks import law_look
from chain_impact.pictures.drawing.legends import legend_at_head
from chain_impact.pictures.drawing.style import DPI, STYLE
from docs.tools import DOCS

PICTURE = DOCS / "images" / "paper.png"
SCENE, LAWS = "four_link_box", ("hertz", "hunt_crossley", "lankarani_nikravesh", "flores", "zhang_sharf")
POINTS = 201  # number of times from the onset to the end of the contact; curves leave out these two
WALL = "y_min"


def curves(law: str) -> dict[str, np.ndarray]:
    """Return title with unit → values in the first impact with a law, shape (POINTS − 2,); first the time."""
    scene = load_scene(SCENE).with_values({"contact.model": law})
    first = simulate(scene, stop_time=0.52, output_step=0.52).impacts[0]
    contact, point = f"contact[{first['point']}].{WALL}", f"point[{first['point']}]"
    outputs = ("penetration", "penetration_rate", "force", "impulse")
    names = [*(f"{contact}.{name}" for name in outputs), f"{point}.ay", "energy.total"]
    chain = Chain(scene)
    chain.step_to(first["onset"])
    rows = []
    for time in np.linspace(first["onset"], first["end"], POINTS)[1:-1]:
        chain.step_to(time)
        rows.append([time - first["onset"], *chain.get(names)])
    time, depth, rate, force, impulse, acceleration, energy = np.array(rows).T
    return {
        "time since the onset [ms]": 1e3 * time,
        "deformation [mm]": 1e3 * depth,
        "rate of deformation [m/s]": rate,
        "acceleration [km/s²]": -1e-3 * acceleration,
        "force [kN]": 1e-3 * force,
        "impulse [N·s]": impulse - impulse[0],
        "energy of the chain [J]": energy,
    }


def draw() -> Figure:
    """Return a figure with six panels over the time since the onset."""
    figure = Figure((9.0, 5.0), layout="constrained")
    panels = figure.subplots(2, 3).ravel()
    peaks = {}
    for law in LAWS:
        time, *other_curves = curves(law).items()
        peaks[law] = {title.partition(" [")[0]: float(values.max()) for title, values in other_curves}
        for axes, (title, values) in zip(panels, other_curves, strict=True):
            axes.plot(time[1], values, **law_look(law), linewidth=1.3, label=law)
            axes.set(ylabel=title)
    for axes in panels:
        axes.margins(x=0.0)
        axes.set(xlabel="time since the onset [ms]")
    ends = {
        name: " to ".join(f"{choose(peaks[law][name] for law in LAWS):.3g}" for choose in (min, max))
        for name in ("force", "impulse")
    }
    write_headline(
        figure,
        f"{len(LAWS)} laws give peak forces of {ends['force']} kN and impulses of {ends['impulse']} N·s",
        f"first impact of {SCENE}, on {WALL}",
    )
    legend_at_head(figure, panels[0].get_legend_handles_labels()[0])
    return figure


if __name__ == "__main__":
    with mpl.rc_context(STYLE):
        draw().savefig(sys.argv[1] if len(sys.argv) > 1 else PICTURE, dpi=DPI)

"""Co-simulate the cart and the controller that balances its pole, two FMUs; a signal pushes the pole.

``python models/cart_pole/co_simulation.py`` builds both FMUs and writes a table and a picture. The masters
are those of the controlled arm.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "controlled_arm"))
from masters import run  # noqa: E402

STOP_TIME, STEP = 6.0, 5e-3  # s


def main():
    """Build, co-simulate, write the table and the picture."""
    from chain_impact import Recording

    arguments, _, columns = run(
        __doc__,
        HERE,
        plant="cart",
        slave=(HERE / "balancer.py", "Balancer"),
        stop_time=STOP_TIME,
        step=STEP,
        plot="a picture of cart, pole and force",
    )
    time = columns.pop("time")
    Recording("CartPole", time, columns).save_csv(arguments.output / "CartPole.csv")
    if arguments.plot:
        draw(arguments.plot, time, columns)
    for name in ("slider.position", "link[1].angle", "impact.count"):
        print(f"{name:<20}{columns[name][-1]:.6f}")


def draw(path, time, columns):
    """Draw the positions of cart and pole, and the force; a band shows the push."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from chain_impact.pictures.drawing.colours import BLUE, GREEN, INK, VERMILLION
    from chain_impact.pictures.drawing.dark_ground import ORANGE
    from chain_impact.pictures.drawing.head_and_foot import write_headline
    from chain_impact.pictures.drawing.style import DPI, STYLE

    tilts = [math.degrees(angle) - 90.0 for angle in columns["link[1].angle"]]
    pushed = [t for t, push in zip(time, columns["tip.force.x"], strict=True) if push]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 5.4), layout="constrained")
        write_headline(
            figure,
            f"CartPole: balanced, largest lean {max(map(abs, tilts)):.0f}°",
            "two FMUs, cart and controller",
        )
        place, tilt, force = figure.subplots(3, 1, sharex=True)
        place.axhline(0.4, color=INK, linewidth=1.0)
        small = {"textcoords": "offset points", "fontsize": "small", "color": INK}
        place.annotate(
            "stop", (1, 0.4), (-2, -2), xycoords=place.get_yaxis_transform(), ha="right", va="top", **small
        )
        place.annotate("push on the pole", (pushed[-1], 0.2), (4, 0), va="center", **small)
        place.plot(time, columns["slider.position"], color=BLUE)
        place.set(ylabel="position of\nthe cart [m]", xlim=(0, time[-1]))
        tilt.plot(time, tilts, color=GREEN)
        tilt.set_ylabel("pole from\nupright [deg]")
        force.plot(time, columns["slider.force"], color=VERMILLION)
        force.set(xlabel="time [s]", ylabel="force [N]")
        for panel in (place, tilt, force):
            panel.axvspan(pushed[0], pushed[-1], color=ORANGE, alpha=0.35, linewidth=0.0)
            panel.tick_params(labelbottom=True)
        figure.align_ylabels()
        figure.savefig(path, dpi=DPI)


if __name__ == "__main__":
    main()

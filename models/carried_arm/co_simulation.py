"""Co-simulate the arm and its carriage, two FMUs: impulses one way, motion the other.

``python models/carried_arm/co_simulation.py`` builds both FMUs and writes a table and a picture. The masters
are those of the controlled arm.
"""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "controlled_arm"))
from masters import run  # noqa: E402

STOP_TIME, STEP = 2.0, 1e-3  # s


def main():
    """Build, co-simulate, write the table and the picture."""
    from chain_impact import Recording

    arguments, _, columns = run(
        __doc__,
        HERE,
        plant="arm",
        slave=(HERE / "carriage.py", "Carriage"),
        stop_time=STOP_TIME,
        step=STEP,
        plot="a picture of the carriage and the force in its joint",
    )
    time = columns.pop("time")
    Recording("CarriedArm", time, columns).save_csv(arguments.output / "CarriedArm.csv")
    if arguments.plot:
        draw(arguments.plot, time, columns)
    for name in ("base.x", "joint[1].impulse.x", "joint[1].peak_force"):
        print(f"{name:<24}{columns[name][-1]:.6f}")


def draw(path, time, columns):
    """Draw the position of the carriage, and the force and the impulse in its joint."""
    import matplotlib as mpl
    import numpy as np
    from matplotlib.figure import Figure

    from chain_impact.pictures.drawing.colours import BLUE, INK, PEAK_COLOUR, VIOLET
    from chain_impact.pictures.drawing.head_and_foot import write_headline
    from chain_impact.pictures.drawing.style import DPI, STYLE

    forces = np.hypot(columns["joint[1].force.x"], columns["joint[1].force.y"])
    # a new largest force lies within a communication step, at whose end it is drawn
    peaks = columns["joint[1].peak_force"]
    forces = np.where(np.diff(peaks, prepend=peaks[0]) > 0.0, peaks, forces)
    row = forces.argmax()
    peak = forces[row]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 5.6), layout="constrained")
        write_headline(
            figure,
            f"CarriedArm: peak force on the carriage {peak:.0f} N at {time[row]:.3f} s",
            f"two FMUs, carriage and arm  ·  communication step {time[1]:g} s  ·  dot: the arm hits a wall",
        )
        panels = figure.subplots(3, 1, sharex=True)
        place, force, impulse = panels
        place.plot(time, 1000 * columns["base.x"], color=BLUE)
        place.set_ylabel("position of the\ncarriage [mm]")
        force.plot(time, forces, color=INK)
        force.plot(time[row], peak, "o", color=PEAK_COLOUR)
        force.annotate(
            f"{peak:.0f} N",
            (time[row], peak),
            (8, 0),
            textcoords="offset points",
            color=PEAK_COLOUR,
            va="center",
        )
        force.set(ylabel="force in\njoint 1 [N]", ylim=(0, None))
        impulse.plot(time, columns["joint[1].impulse.x"], color=VIOLET)
        impulse.set(xlabel="time [s]", xlim=(0, time[-1]), ylabel="impulse on\nthe arm, x [N·s]")
        for axes in panels:
            axes.tick_params(labelbottom=True)
        figure.align_ylabels()
        figure.savefig(path, dpi=DPI)


if __name__ == "__main__":
    main()

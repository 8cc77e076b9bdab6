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
    """Draw the position of the carriage, and its impulse on the arm."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4.5), layout="constrained")
    place, impulse = figure.subplots(2, 1, sharex=True)
    place.plot(time, columns["base.x"])
    place.set_ylabel("place of the carriage [m]")
    impulse.plot(time, columns["joint[1].impulse.x"])
    impulse.set(xlabel="time [s]", ylabel="impulse on the arm [N·s]")
    figure.savefig(path, dpi=160)


if __name__ == "__main__":
    main()

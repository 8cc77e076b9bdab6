"""Co-simulate the arm and its controller, two FMUs, by a master of fixed steps.

``python models/controlled_arm/co_simulation.py`` builds both FMUs and writes a table and a picture. The
masters libcosim and Ecos need the packages of the extra ``masters``.
"""

from __future__ import annotations

import csv
from pathlib import Path

import fmpy
import numpy as np
from masters import run

HERE = Path(__file__).parent
STOP_TIME, STEP = 2.0, 1e-3  # s
SHOWN = 4.0  # the time that the picture shows, relative to the time of the first impact


def save_csv(path, columns):
    """Write a table, numbers in full precision."""
    with Path(path).open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))


def start_values(fmus):
    """Return the parameters of FMUs: name → value."""
    variables = [v for path in fmus for v in fmpy.read_model_description(str(path)).modelVariables]
    return {v.name: float(v.start) for v in variables if v.causality == "parameter"}


def draw(path, columns, parameters):
    """Draw the motion, the joints' angles and torques, and the force of the wall."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from chain_impact import Recording
    from chain_impact.pictures import draw_chain, draw_walls
    from chain_impact.pictures.drawing.colours import BLUE, GREEN, INK, PEAK_COLOUR, TIME_COLOURS
    from chain_impact.pictures.drawing.head_and_foot import write_headline
    from chain_impact.pictures.drawing.style import DPI, STYLE
    from chain_impact.scene.half_planes import half_planes

    time, force = columns["time"], columns["contact[2].x_max.force"]
    # the largest force may lie between two communication points
    peak = max(column.max() for name, column in columns.items() if name.endswith(".peak_force"))
    hit, impact = time[force.argmax()], time[np.flatnonzero(force)[0]]
    recording = Recording(
        "ControlledArm", time, columns, [], half_planes({"x_max": parameters["box.x_max"]}, {})
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10, 6), dpi=DPI, layout="constrained")
        write_headline(
            figure,
            f"ControlledArm: peak force of the wall {peak:.0f} N, then {force[-1]:.0f} N",
            "two FMUs, arm and controller  ·  targets of the joints lie behind the wall  ·  restitution e = "
            f"{parameters['contact.restitution']:g}  ·  communication step {time[1]:g} s",
        )
        grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.2))
        motion = figure.add_subplot(grid[:, 0])
        angles, torques, forces = panels = [figure.add_subplot(grid[row, 1]) for row in range(3)]

        draw_walls(motion, recording)
        motion.plot(*recording.points[:, -1].T, color=INK, linewidth=1, label="path of the tip")
        for at, more in ((0.0, ""), (0.5 * impact, ""), (impact, ", hits the wall")):
            pose = recording.points[np.searchsorted(time, at - 1e-9)]
            shade = TIME_COLOURS(at / impact)
            draw_chain(motion, pose, color=shade, linewidth=2.4, label=f"{at:.2g} s{more}")
        motion.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")

        shoulder = columns["link[1].angle"]
        joints = (("shoulder", BLUE, shoulder), ("elbow", GREEN, columns["link[2].angle"] - shoulder))
        for i, (name, colour, angle) in enumerate(joints, 1):
            target = parameters[f"joint[{i}].target"]
            angles.plot(time, angle, color=colour, label=name)
            angles.axhline(target, color=colour, linestyle=":", linewidth=1)
            place = {"xycoords": angles.get_yaxis_transform(), "textcoords": "offset points"}
            angles.annotate(
                "target", (1, target), (0, 2), **place, color=colour, ha="right", fontsize="small"
            )
            torques.step(time, columns[f"joint[{i}].torque"], color=colour, where="post")
        angles.set(ylabel="joint angle [rad]", ylim=(-2.1, 1.1))
        torques.set(ylabel="torque [N·m]")
        forces.plot(time, force, color=INK, linewidth=1)
        forces.plot(hit, peak, "o", color=PEAK_COLOUR)
        forces.annotate(
            f"{peak:.0f} N", (hit, peak), (8, 0), textcoords="offset points", color=PEAK_COLOUR, va="center"
        )
        forces.set(ylabel="force of the wall [N]", ylim=(0, None))
        for axes in panels:
            axes.set(xlim=(0, SHOWN * impact))
        forces.set_xlabel(f"time [s]; at rest until {time[-1]:g} s")
        for axes in (motion, angles):
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)
        figure.savefig(path, dpi="figure")


def main():
    """Build, co-simulate, write the table and the picture."""
    arguments, fmus, columns = run(
        __doc__,
        HERE,
        plant="arm",
        slave=(HERE / "controller.py", "JointController"),
        stop_time=STOP_TIME,
        step=STEP,
        plot="the picture; ControlledArm.png in the folder by default",
    )
    folder = arguments.output
    save_csv(folder / "ControlledArm.csv", columns)
    draw(arguments.plot or folder / "ControlledArm.png", columns, start_values(fmus))
    for name in ("joint[1].torque", "joint[2].torque", "contact[2].x_max.force", "point[2].y"):
        print(f"{name:<24}{columns[name][-1]:.6f}")


if __name__ == "__main__":
    main()

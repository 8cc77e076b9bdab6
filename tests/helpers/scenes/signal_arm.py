"""An arm that signals drive, and the arm with a table."""

import numpy as np

from chain_impact.scene.scene import load_scene

ARM = """
name = "Arm"
gravity = [0.0, -9.81]
[chain]
base = "pinned"
[[chain.links]]
length = 0.4
mass = 0.5
joint_stiffness = 3.0
joint_damping = 0.2
[[chain.links]]
length = 0.3
mass = 0.4
joint_stiffness = 2.0
joint_damping = 0.1
[[walls]]
name = "table"
point = [0.0, -0.75]
angle = 0.0
[contact]
stiffness = 1e5
restitution = 0.6
points = [2]
[inputs]
joint_torques = true
joint_targets = true
tip_force = true
base_motion = true
wall_motion = ["table"]
[initial]
angles = [-1.2, -0.9]
[simulation]
stop_time = 0.6
step_size = 0.01
"""
TORQUE, TARGET, HEIGHT = "joint[2].torque", "joint[1].target_angle", "base.y"
TABLE, PUSH = "wall.table.displacement", "tip.force.x"
TIMES = np.array([0.0, 0.05, 0.12, 0.2, 0.31, 0.4])


def with_table(folder, driven, columns, numbers, scene=ARM):
    """Return the arm with a signal of the form "table" for the inputs ``driven``; its files go to ``folder``.

    ``columns`` are those of the table's file, ``numbers`` further lines of the signal in the scene's file.
    """
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(map(repr, map(float, row))) for row in rows)]
    (folder / "drive.csv").write_text("\n".join(lines))
    inputs = ", ".join(f'"{name}"' for name in driven)
    text = f'{scene}\n[signals.drive]\ninput = [{inputs}]\nform = "table"\nfile = "drive.csv"\n{numbers}\n'
    (folder / "arm.toml").write_text(text)
    return load_scene(folder / "arm.toml")

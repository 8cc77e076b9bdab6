"""MuJoCo: the chain of a scene as its bodies and joints, planar, with its own contact.

Slides and hinges in the x–z plane, hinge angles relative; points that may touch are small frictionless
spheres, the walls planes set back by their radius.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene

RADIUS = 1e-3  # m
# balls touch walls and nothing else
BALL, WALL = (f'contype="{a}" conaffinity="{1 - a}"' for a in (1, 0))
INTEGRATORS = ("Euler", "implicitfast", "RK4")
WALLS = {  # the normal of a plane is its z axis
    "x_min": "0 1 0 90", "x_max": "0 1 0 -90", "y_min": "0 1 0 0", "y_max": "0 1 0 180",
}  # fmt: skip


def damping_ratio(restitution: float) -> float:
    """ζ of a linear contact that would rebound with e, if it were allowed to pull."""
    return -math.log(restitution) / math.hypot(math.pi, math.log(restitution))


def model_text(scene: Scene, integrator: str, dt: float, time_constant: float | None) -> str:
    """MJCF. The time constant of a contact [s] goes with the damping ratio that the restitution asks for."""
    links, pairs = scene.chain.links, candidates(scene)
    points = {point for point, _ in pairs}
    contact = ""
    if time_constant is not None:
        ratio = damping_ratio(scene.contact.restitution)
        contact = f'solref="{time_constant} {ratio}" solimp="0.99 0.99 0.001"'

    def ball(point: int, along: float) -> str:
        if point not in points:
            return ""
        return f'<geom type="sphere" size="{RADIUS}" pos="{along} 0 0" {BALL} mass="0"/>'

    inner = ball(len(links), links[-1].length)
    for i in range(len(links) - 1, -1, -1):
        link = links[i]
        joints = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>' if i == 0 else ""
        place = f"{links[i - 1].length} 0 0" if i else "0 0 0"
        inertia = " ".join([str(link.inertia)] * 3)
        inner = (
            f'<body pos="{place}">{joints}<joint type="hinge" axis="0 -1 0"/>'
            f'<inertial pos="{link.center_of_mass} 0 0" mass="{link.mass}" diaginertia="{inertia}"/>'
            f"{ball(i, 0.0)}{inner}</body>"
        )
    planes = ""
    for name, turn in WALLS.items():
        at = getattr(scene.box, name)
        if at is not None and pairs:
            back = at - RADIUS if name.endswith("min") else at + RADIUS
            place = f"{back} 0 0" if name[0] == "x" else f"0 0 {back}"
            planes += f'<geom type="plane" size="9 9 1" pos="{place}" axisangle="{turn}" {WALL}/>'
    gx, gy = scene.gravity
    return f"""<mujoco><compiler angle="degree" inertiafromgeom="false" boundmass="0"/>
<option timestep="{dt}" integrator="{integrator}" gravity="{gx} 0 {gy}" cone="elliptic" iterations="50"
 tolerance="1e-12"><flag energy="enable" refsafe="disable"/></option>
<default><geom condim="1" {contact}/></default><worldbody>{planes}{inner}</worldbody></mujoco>"""


class Engine:
    """One model; set back to the start for each run."""

    def __init__(self, scene: Scene, integrator: str, dt: float, time_constant: float | None = None) -> None:
        self.scene, self.dt = scene, dt
        self.model = mujoco.MjModel.from_xml_string(model_text(scene, integrator, dt, time_constant))
        self.data = mujoco.MjData(self.model)

    def run(self, stop: float) -> None:
        """From the start to ``stop`` [s]."""
        first = self.scene.initial
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = [*first.position, *np.diff([0.0, *first.angles])]
        self.data.qvel[:] = [*first.velocity, *np.diff([0.0, *first.angular_velocities])]
        mujoco.mj_step(self.model, self.data, nstep=round(stop / self.dt))

    def state(self) -> np.ndarray:
        """As that of the kernel: x₀, y₀, angles, and their rates."""
        q, v = self.data.qpos, self.data.qvel
        return np.concatenate([q[:2], np.cumsum(q[2:]), v[:2], np.cumsum(v[2:])])

    def energy(self) -> float:
        """Kinetic and potential energy [J]."""
        mujoco.mj_forward(self.model, self.data)
        mujoco.mj_energyPos(self.model, self.data)
        mujoco.mj_energyVel(self.model, self.data)
        return float(self.data.energy.sum())

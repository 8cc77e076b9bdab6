"""MuJoCo: the chain of a scene as its bodies and joints, planar, with its own contact.

Slides and hinges in the x–z plane, hinge angles relative; points that may touch are small spheres, the walls
planes set back by their radius. In a scene with friction the chain can also slide along y, though nothing
moves it there: MuJoCo's friction at a point has two directions, and ``noslip_iterations`` have no effect on a
contact that cannot move along one of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import mujoco
import numpy as np
from common import rounded

from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene

RADIUS = 1e-3  # m
RUBBING_RADIUS = 1e-6  # m, as friction acts at the surface of a sphere and not at its centre
# balls touch walls and nothing else
BALL, WALL = (f'contype="{a}" conaffinity="{1 - a}"' for a in (1, 0))
CONVERGED = 1e-6  # s, the step of runs that count as exact
INTEGRATORS = ("Euler", "implicitfast", "RK4")
OUT_OF_PLANE = '<joint type="slide" axis="0 1 0"/>'


@dataclass(frozen=True)
class Contact:
    """How MuJoCo models contacts and friction; the defaults are MuJoCo's own, but for the elliptic cones.

    Attributes:
        solref: time constant [s] and damping ratio; or −stiffness [1/s²] and −damping [1/s].
        solimp: least and largest impedance, and the penetration [m] at which the largest is reached.
        cone: of friction, elliptic or pyramidal.
        impratio: how many times as hard friction is as the contact along its normal.
        noslip: iterations of the solver that takes slip away afterwards.
        refsafe: whether time constants below two steps are raised to two steps.
        sideways: whether a chain with friction at walls can also slide out of the plane.
    """

    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, float, float] = (0.9, 0.95, 0.001)
    cone: str = "elliptic"
    impratio: float = 1.0
    noslip: int = 0
    refsafe: bool = True
    sideways: bool = True


DEFAULTS = Contact()


def damping_ratio(restitution: float) -> float:
    """ζ of a linear contact that would rebound with e, if it were allowed to pull."""
    return -math.log(restitution) / math.hypot(math.pi, math.log(restitution))


def bouncing(time_constant: float, restitution: float) -> Contact:
    """A contact with a time constant [s] and the damping ratio that the restitution asks for."""
    return Contact((time_constant, damping_ratio(restitution)), (0.99, 0.99, 0.001), refsafe=False)


def _planes(scene: Scene) -> str:
    """The walls; the normal of a plane is its z axis."""
    planes, rubs = "", scene.has_contact_friction
    radius = RUBBING_RADIUS if rubs else RADIUS
    for name, wall in scene.half_planes.items():
        (nx, nz), back = wall.normal, wall.offset - radius
        turn = math.degrees(math.atan2(nx, nz))
        own = scene.contact.wall[name].friction if rubs else None
        friction = f'friction="{scene.contact.friction if own is None else own} 0 0"' if rubs else ""
        place = f'pos="{nx * back} 0 {nz * back}" axisangle="0 1 0 {turn}"'
        planes += f'<geom type="plane" size="9 9 1" {place} {friction} {WALL}/>'
    return planes


def _bodies(scene: Scene, sideways: bool) -> str:
    """The links, each in the one before."""
    links, rubs = scene.chain.links, scene.has_contact_friction
    points = {point for point, _ in candidates(scene)}
    radius = RUBBING_RADIUS if rubs else RADIUS

    def ball(point: int, along: float) -> str:
        if point not in points:
            return ""
        return f'<geom type="sphere" size="{radius}" pos="{along} 0 0" friction="0 0 0" {BALL} mass="0"/>'

    inner = ball(len(links), links[-1].length)
    for i in range(len(links) - 1, -1, -1):
        link = links[i]
        joints = "" if i else '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
        joints += OUT_OF_PLANE if sideways and rubs and not i else ""
        dry = f'frictionloss="{link.joint_friction}"' if i and link.joint_friction else ""
        place = f"{links[i - 1].length} 0 0" if i else "0 0 0"
        inertia = " ".join([str(link.inertia)] * 3)
        inner = (
            f'<body pos="{place}">{joints}<joint type="hinge" axis="0 -1 0" {dry}/>'
            f'<inertial pos="{link.center_of_mass} 0 0" mass="{link.mass}" diaginertia="{inertia}"/>'
            f"{ball(i, 0.0)}{inner}</body>"
        )
    return inner


def model_text(scene: Scene, integrator: str, dt: float, contact: Contact) -> str:
    """MJCF."""
    ref, imp = (" ".join(map(str, values)) for values in (contact.solref, contact.solimp))
    gx, gy = scene.gravity
    condim = 3 if scene.has_contact_friction else 1
    return f"""<mujoco><compiler angle="degree" inertiafromgeom="false" boundmass="0"/>
<option timestep="{dt}" integrator="{integrator}" gravity="{gx} 0 {gy}" iterations="50" tolerance="1e-12"
 cone="{contact.cone}" impratio="{contact.impratio}" noslip_iterations="{contact.noslip}">
<flag energy="enable" refsafe="{"enable" if contact.refsafe else "disable"}"/></option>
<default><geom condim="{condim}" solref="{ref}" solimp="{imp}"/>
<joint solreffriction="{ref}" solimpfriction="{imp}"/></default>
<worldbody>{_planes(scene)}{_bodies(scene, contact.sideways)}</worldbody></mujoco>"""


class Engine:
    """One model; set back to the start for each run."""

    def __init__(self, scene: Scene, integrator: str, dt: float, contact: Contact = DEFAULTS) -> None:
        self.scene, self.dt = scene, dt
        self.model = mujoco.MjModel.from_xml_string(model_text(scene, integrator, dt, contact))
        self.data = mujoco.MjData(self.model)
        out = self.model.nq - 2 - len(scene.chain.links)
        self.plane = np.delete(np.arange(self.model.nq), np.arange(2, 2 + out))

    def run(self, stop: float) -> None:
        """From the start to ``stop`` [s]."""
        first = self.scene.initial
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self.plane] = [*first.position, *np.diff([0.0, *first.angles])]
        self.data.qvel[self.plane] = [*first.velocity, *np.diff([0.0, *first.angular_velocities])]
        mujoco.mj_step(self.model, self.data, nstep=round(stop / self.dt))

    def state(self) -> np.ndarray:
        """As that of the kernel: x₀, y₀, angles, and their rates."""
        q, v = self.data.qpos[self.plane], self.data.qvel[self.plane]
        return np.concatenate([q[:2], np.cumsum(q[2:]), v[:2], np.cumsum(v[2:])])

    def energy(self) -> float:
        """Kinetic and potential energy [J]."""
        mujoco.mj_forward(self.model, self.data)
        mujoco.mj_energyPos(self.model, self.data)
        mujoco.mj_energyVel(self.model, self.data)
        return float(self.data.energy.sum())

    @property
    def unstable(self) -> bool:
        """Whether the run has left what numbers can hold, so that MuJoCo began anew."""
        return any(warning.number for warning in self.data.warning)

    def energies_in_flight(self, stop: float) -> np.ndarray:
        """Kinetic and potential energy [J] at the start and after each step; NaN while a point touches."""
        self.run(0.0)
        shown, energies = mujoco.MjData(self.model), []
        for step in range(round(stop / self.dt) + 1):
            if step:
                mujoco.mj_step(self.model, self.data)
            # in other data, as what the next step starts from must not change
            shown.qpos[:], shown.qvel[:] = self.data.qpos, self.data.qvel
            mujoco.mj_forward(self.model, shown)
            energies.append(np.nan if shown.ncon else float(shown.energy.sum()))
        return np.array(energies)


def runs_at(
    name: str, case: tuple[Scene, str, Contact], steps: Iterable[float], stop: float, truth: Any = None
) -> tuple[dict, np.ndarray]:
    """Runs with some steps [s] that stay stable, and the errors of their states at the end.

    Args:
        name: of the contender.
        case: the scene, the integrator and the contact.
        steps: [s].
        stop: [s].
        truth: the state at the end; by default that of a run with the finest steps.

    Returns:
        Entries of race.py, and the state that counts as true.
    """
    scene, integrator, contact = case
    found = {}
    for dt in (CONVERGED, *steps) if truth is None else steps:
        engine = Engine(scene, integrator, dt, contact)
        engine.run(stop)
        if truth is None:
            truth = engine.state()
        elif not engine.unstable:
            error = rounded(np.abs(engine.state() - truth).max())
            found[name, dt] = (partial(engine.run, stop), {"error": error})
    return found, truth

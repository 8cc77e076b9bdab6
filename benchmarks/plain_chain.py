"""The model once more, compiled, over plain arrays: the yardstick for rhs.py and what the peers integrate.

The same recursion as in kernel/chain/recursion.py, and the same law of force, on ``float64[:]`` arrays of a
length known at run time only, as numba is mostly used. State y = (x₀, θ, ẋ₀, ω), without the energies.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from chain_impact.scene.candidates import candidates
from chain_impact.scene.scene import Scene
from chain_impact.variables.model import Model

jit = njit(error_model="numpy")
# inlined before compilation: a call would count references to every array, at more cost than the recursion
inlined = njit(error_model="numpy", inline="always")


class Chain(NamedTuple):
    """What stays constant; units as in chain_impact/kernel/record/given.py."""

    gravity: np.ndarray
    length: np.ndarray
    mass: np.ndarray
    ratio: np.ndarray  # centre of mass / length
    joint_inertia: np.ndarray
    wall: np.ndarray
    candidate_point: np.ndarray
    candidate_wall: np.ndarray
    stiffness: float
    exponent: float
    damping_factor: float  # λ


class Work(NamedTuple):
    """Work space; one number for each point 0…N or link."""

    link_x: np.ndarray
    link_y: np.ndarray
    load_x: np.ndarray
    load_y: np.ndarray
    moment: np.ndarray
    gain_x: np.ndarray
    gain_y: np.ndarray
    bias: np.ndarray
    px: np.ndarray
    py: np.ndarray
    vx: np.ndarray
    vy: np.ndarray


def plain_chain(scene: Scene) -> Chain:
    """The arrays of a scene with a free base, no joint damping and no inputs."""
    from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS

    assert scene.chain.base == "free"
    assert scene.contact.radius == 0.0
    model = Model(scene).new_instance()[0]["model"]
    pairs = np.array(candidates(scene), dtype=np.int64).reshape(-1, 2)
    length, mass, centre = (np.array(model[name]) for name in ("length", "mass", "center_of_mass"))
    return Chain(
        gravity=np.array(model["gravity"]),
        length=length,
        mass=mass,
        ratio=centre / length,
        joint_inertia=model["inertia"] + mass * centre**2,
        wall=np.array(model["wall"]),
        candidate_point=pairs[:, 0].copy(),
        candidate_wall=pairs[:, 1].copy(),
        stiffness=scene.contact.stiffness,
        exponent=scene.contact.exponent,
        damping_factor=CONTACT_LAWS[scene.contact.model].damping_factor(scene.contact.restitution),
    )


@jit
def new_work(points):
    """Work space for N+1 points."""
    w = np.zeros((12, points))
    return Work(w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], w[8], w[9], w[10], w[11])


def start(scene: Scene) -> np.ndarray:
    """The state at t = 0."""
    first = scene.initial
    return np.array([*first.position, *first.angles, *first.velocity, *first.angular_velocities])


@inlined
def link_vectors(chain, work, y):
    """Vectors along the links [m]."""
    for i in range(len(chain.length)):
        work.link_x[i] = chain.length[i] * math.cos(y[2 + i])
        work.link_y[i] = chain.length[i] * math.sin(y[2 + i])


# fmt: off
@inlined
def accelerations(  # noqa: PLR0917
    gravity, length, mass, ratio, joint_inertia, link_x, link_y,
    load_x, load_y, moment, gain_x, gain_y, bias, y, out
):
    """The recursion: accelerations of the base and of the angles into the second half of ``out``."""
    n = len(length)
    gx, gy = gravity[0], gravity[1]
    axx, axy, ayy = 0.0, 0.0, 0.0
    bx, by = -load_x[n], -load_y[n]
    for i in range(n - 1, -1, -1):
        m = mass[i]
        lx, ly = link_x[i], link_y[i]
        sx, sy = m * ratio[i] * lx, m * ratio[i] * ly
        w2 = y[n + 4 + i] * y[n + 4 + i]
        px, py = axy * lx - axx * ly, ayy * lx - axy * ly
        dx = bx - w2 * (axx * lx + axy * ly)
        dy = by - w2 * (axy * lx + ayy * ly)
        hx, hy = px - sy, py + sx
        inverse = 1.0 / (joint_inertia[i] + lx * py - ly * px)
        h0 = lx * dy - ly * dx + sy * gx - sx * gy - moment[i]
        kx, ky = hx * inverse, hy * inverse
        axx += m - hx * kx
        axy -= hx * ky
        ayy += m - hy * ky
        bx = dx - w2 * sx - m * gx - kx * h0 - load_x[i]
        by = dy - w2 * sy - m * gy - ky * h0 - load_y[i]
        gain_x[i], gain_y[i], bias[i] = kx, ky, h0 * inverse
    determinant = axx * ayy - axy * axy
    ax = (axy * by - ayy * bx) / determinant
    ay = (axy * bx - axx * by) / determinant
    out[n + 2], out[n + 3] = ax, ay
    for i in range(n):
        a = -(gain_x[i] * ax + gain_y[i] * ay + bias[i])
        out[n + 4 + i] = a
        w2 = y[n + 4 + i] * y[n + 4 + i]
        ax -= a * link_y[i] + w2 * link_x[i]
        ay += a * link_x[i] - w2 * link_y[i]


# fmt: on
@jit
def locate(chain, work, y):
    """Positions and velocities of the points."""
    n = len(chain.length)
    link_vectors(chain, work, y)
    x, y_, vx, vy = y[0], y[1], y[n + 2], y[n + 3]
    for i in range(n):
        work.px[i], work.py[i], work.vx[i], work.vy[i] = x, y_, vx, vy
        x += work.link_x[i]
        y_ += work.link_y[i]
        vx -= y[n + 4 + i] * work.link_y[i]
        vy += y[n + 4 + i] * work.link_x[i]
    work.px[n], work.py[n], work.vx[n], work.vy[n] = x, y_, vx, vy


@jit
def clearance(chain, work, c):
    """Clearance [m] and its rate [m/s] of candidate c, for the located points."""
    point, wall = chain.candidate_point[c], chain.candidate_wall[c]
    side = 1.0 - 2.0 * (wall % 2)
    if wall < 2:
        return side * (work.px[point] - chain.wall[wall]), side * work.vx[point]
    return side * (work.py[point] - chain.wall[wall]), side * work.vy[point]


@jit
def elastic_force(chain, depth):
    """K δⁿ [N]."""
    if chain.exponent == 1.5:
        return chain.stiffness * depth * math.sqrt(depth)
    return chain.stiffness * depth**chain.exponent


@jit
def rate(chain, work, y, active, v0, out):  # noqa: PLR0917, compiled
    """Set out = f(y) with the forces of the active candidates; returns the elastic energy [J]."""
    n = len(chain.length)
    touching = False
    for c in range(len(active)):
        touching = touching or active[c]
    stored = 0.0
    for k in range(n + 1):
        work.load_x[k], work.load_y[k] = 0.0, 0.0
    if touching:
        locate(chain, work, y)
        for c in range(len(active)):
            if active[c]:
                gap, gap_rate = clearance(chain, work, c)
                if gap < 0.0:
                    elastic = elastic_force(chain, -gap)
                    force = max(0.0, elastic * (1.0 - chain.damping_factor * gap_rate / v0[c]))
                    stored -= elastic * gap / (chain.exponent + 1.0)
                    point, wall = chain.candidate_point[c], chain.candidate_wall[c]
                    side = 1.0 - 2.0 * (wall % 2)
                    if wall < 2:
                        work.load_x[point] += side * force
                    else:
                        work.load_y[point] += side * force
    else:
        link_vectors(chain, work, y)
    for j in range(n + 2):
        out[j] = y[n + 2 + j]
    accelerations(
        chain.gravity, chain.length, chain.mass, chain.ratio, chain.joint_inertia, work.link_x, work.link_y,
        work.load_x, work.load_y, work.moment, work.gain_x, work.gain_y, work.bias, y, out
    )  # fmt: skip
    return stored


# fmt: off
@inlined
def flight_rate(  # noqa: PLR0917
    gravity, length, mass, ratio, joint_inertia, link_x, link_y,
    load_x, load_y, moment, gain_x, gain_y, bias, y, out
):
    """Set out = f(y) in flight, from plain arrays and nothing else."""
    n = len(length)
    for i in range(n):
        link_x[i] = length[i] * math.cos(y[2 + i])
        link_y[i] = length[i] * math.sin(y[2 + i])
    for j in range(n + 2):
        out[j] = y[n + 2 + j]
    accelerations(
        gravity, length, mass, ratio, joint_inertia, link_x, link_y,
        load_x, load_y, moment, gain_x, gain_y, bias, y, out
    )  # fmt: skip


# fmt: on
@jit
def mechanical_energy(chain, work, y):
    """Kinetic and potential energy [J], for the located points."""
    n, energy = len(chain.length), 0.0
    for i in range(n):
        m, r, omega = chain.mass[i], chain.ratio[i], y[n + 4 + i]
        vx, vy = work.vx[i] - omega * r * work.link_y[i], work.vy[i] + omega * r * work.link_x[i]
        own = chain.joint_inertia[i] - m * (r * chain.length[i]) ** 2
        energy += 0.5 * m * (vx * vx + vy * vy) + 0.5 * own * omega * omega
        x, y_ = work.px[i] + r * work.link_x[i], work.py[i] + r * work.link_y[i]
        energy -= m * (chain.gravity[0] * x + chain.gravity[1] * y_)
    return energy

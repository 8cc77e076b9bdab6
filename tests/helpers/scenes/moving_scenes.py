"""Scenes whose base or walls move, and chains that are moved step by step."""

import math

import numpy as np

from chain_impact import Chain
from chain_impact.scene.scene import scene_from_dict

G = 9.81
LINKS = ({"length": 0.5, "mass": 1.0}, {"length": 0.4, "mass": 0.7})
LAWS = ("zhang_sharf", "jankowski", "newton_impact")


def scene_of(links=LINKS, *, base="free", box=None, contact=None, inputs=None, **others):
    """Return a scene whose base may move, or with the given ``inputs``; ``others`` are more of its tables."""
    tables = {"solver": {"tolerance": 1e-12}, "simulation": {"stop_time": 1.0, "step_size": 0.01}}
    for name, table in others.items():
        tables[name] = tables.get(name, {}) | table if isinstance(table, dict) else table
    chain = {"base": base, "links": [dict(link) for link in links]}
    inputs = {"base_motion": True} if inputs is None else inputs
    data = {"name": "Moves", "chain": chain, "box": box or {}, "contact": contact or {}, "inputs": inputs}
    return scene_from_dict(data | tables, "moves")


def pendulum(**others):
    """Return two links that hang from a base that moves."""
    others.setdefault("initial", {"position": [0.1, 0.2], "angles": [-1.0, -0.4]})
    return scene_of(base="pinned", **others)


def room(model="zhang_sharf", velocity=(0.5, 0.0), walls=("y_min", "x_max"), **contact):
    """Return a free chain that falls to a floor, and against a wall if ``walls`` names it.

    The walls of ``walls`` may move.
    """
    return scene_of(
        box={"y_min": 0.0, "x_max": 2.0} if "x_max" in walls else {"y_min": 0.0},
        contact={"model": model, "stiffness": 1e6, "restitution": 0.6} | contact,
        inputs={"wall_motion": list(walls)},
        initial={
            "position": [0.6, 1.0],
            "angles": [0.4, -0.6],
            "velocity": list(velocity),
            "angular_velocities": [1.0, -2.0],
        },
    )


def resting(model, *, friction=0.0, stop=3600.0, **others):
    """Return a rod that lies on a floor that inputs may move."""
    return scene_of(
        LINKS[:1],
        box={"y_min": 0.0},
        contact={"model": model, "stiffness": 1e6, "restitution": 0.3, "friction": friction},
        inputs={"wall_motion": True},
        solver={"tolerance": 1e-8},
        simulation={"stop_time": stop, "step_size": stop / 600.0},
        initial={"angles": [0.0]},
        **others,
    )


def unbalanced(result):
    """Return the range of the energy balance [J]: its largest less its least value."""
    return np.ptp(result["energy.total"] + result["energy.dissipated"] - result["energy.supplied"])


def shaken(time, amplitude=0.05, rate=5.0):
    """Return position, velocity and acceleration of a base that oscillates about 0.1 m, at a time."""
    angle = rate * time
    return (
        0.1 + amplitude * math.sin(angle),
        amplitude * rate * math.cos(angle),
        -amplitude * rate**2 * math.sin(angle),
    )


def stepped(scene, step, count, given, names=("base.x", "base.vx", "base.ax")):
    """Return time, point[0].x, point[0].vx and link[1].angle after each step, (4, count).

    As a master does, the steps set the inputs ``names`` to ``given(time)`` at communication points.
    """
    chain, rows = Chain(scene), []
    for k in range(count):
        chain.set(dict(zip(names, given(k * step), strict=False)))
        chain.step_to((k + 1) * step)
        rows.append((chain.time, *chain.get(["point[0].x", "point[0].vx", "link[1].angle"])))
    return np.array(rows).T

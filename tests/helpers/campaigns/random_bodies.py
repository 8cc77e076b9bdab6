"""Random chains of bodies (offsets of centres of mass, points, boxes, sliders), and checks that hold for all.

``python -m tests.helpers.campaigns.random_bodies FIRST COUNT`` runs so many scenes and prints faults: a run
that ends early, accelerations that differ from Lagrange's equations with the contact forces in the outputs,
an energy balance that is not constant, dissipation that falls, a penetration that does not belong to the
position of its point, or results whose bits depend on the output step.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from chain_impact import simulate
from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.kernel.status import BASE_BEYOND_WALL, EVENT_STORM, NO_ROOM, STEP_TOO_SMALL, TOO_MUCH_WORK
from chain_impact.results.result import Result
from chain_impact.scene.asked_inputs import inputs_of
from chain_impact.scene.scene import Scene, scene_from_dict
from chain_impact.simulation.errors import SimulationError
from tests.helpers.campaigns.random_parts import Draw
from tests.helpers.models.body_model import BodyModel

ROWS = 40  # number of rows at which a run is checked
BALANCE = 1000.0  # largest change of the energy balance, over the tolerance times all energy
FALL = 10.0  # largest decrease of the dissipated energy between rows, over the tolerance times all energy
RESIDUAL = 1e-9  # largest error of the equations of motion, over the largest generalized force
DEEP = 1e-9  # [m or rad] largest difference between a penetration and the position of its point
CLOSED = (BASE_BEYOND_WALL, NO_ROOM, EVENT_STORM, STEP_TOO_SMALL, TOO_MUCH_WORK)
"""The statuses that are no fault of a run with moving walls or base: these may leave the chain no room."""
DRIVEN = 10000  # the first seed of scenes with drives, and with moving bases and walls
WORK = 5e6  # [1/s] evaluations per second at which a run ends early


def bodies(seed: int) -> Scene:
    """Return the scene of a seed: one to four links, most of them bodies, on any base, close to walls.

    Some joints have stops. From the seed DRIVEN on, scenes also have drives, and walls or a base that may
    move.
    """
    draw = Draw(seed, 66)
    base = draw.one(("free", "pinned", "slider"))
    chain: dict[str, Any] = {"base": base}
    links = [link(draw, grounded=i > 0 or base != "free") for i in range(draw.whole(1, 4))]
    slider = slider_of(draw) if base == "slider" else {}
    if slider:
        chain["slider"] = slider
    if not {"min", "max"} & slider.keys() and draw.chance(0.25):
        links[-1] |= {"joint_min": 0.0, "joint_max": 0.0} if len(links) > 1 or base != "free" else {}
    chain["links"] = links
    angles = [draw.real(-math.pi, math.pi) for _ in links]
    if "joint_min" in links[-1]:
        bend = angles[-1] - (angles[-2] if len(links) > 1 else 0.0)
        links[-1] |= {"joint_min": bend - draw.real(0.0, 1.0), "joint_max": bend + draw.real(1e-3, 1.0)}
    initial: dict[str, Any] = {
        "position": [0.0, 0.0],
        "angles": angles,
        "angular_velocities": [draw.real(-8.0, 8.0) for _ in links],
    }
    if base == "free":
        initial["velocity"] = [draw.real(-2.0, 2.0), draw.real(-3.0, 1.0)]
    elif base == "slider":
        initial["slider_velocity"] = draw.real(-2.0, 2.0)
    data = {
        "name": "Bodies",
        "gravity": draw.one(([0.0, -9.81], [0.0, 0.0], draw.direction(9.81)), (0.7, 0.1, 0.2)),
        "chain": chain,
        "contact": contact(draw, len(links), base),
        "initial": initial,
        "solver": {
            "method": draw.one(("auto", "explicit", "implicit"), (0.7, 0.15, 0.15)),
            "tolerance": draw.one((1e-6, 1e-8, 1e-10)),
            "work_limit": WORK,
        },
        "simulation": {"stop_time": draw.real(0.2, 1.0)},
    }
    moves = seed >= DRIVEN
    data["walls"] = walls(draw, scene_from_dict(data, "bodies"), moves)
    return scene_from_dict(with_drives(data, draw) if moves else data, "bodies")


def link(draw: Draw, grounded: bool) -> dict[str, Any]:
    """Return the table of a link; ``grounded``: whether the link has a joint."""
    length = draw.real(0.1, 0.6)
    table: dict[str, Any] = {"length": length, "mass": draw.power(0.1, 3.0)}
    if draw.chance(0.7):
        table["center_of_mass_offset"] = length * draw.real(-0.6, 0.6)
    if draw.chance(0.5):
        table["center_of_mass"] = length * draw.real(-0.5, 1.5)
    if draw.chance(0.25):
        table |= {"shape": "box", "height": length * draw.power(0.1, 2.0)}
    points = [
        {"x": length * draw.real(-0.5, 1.5), "y": length * draw.real(-0.8, 0.8)}
        for _ in range(draw.whole(0, 3))
    ]
    for point in points:
        if draw.chance(0.5):
            point["radius"] = draw.power(1e-3, 0.05)
    table["points"] = points
    if grounded:
        table["joint_damping"] = draw.power(1e-3, 0.3) * draw.chance(0.4)
        table["joint_stiffness"] = draw.power(0.1, 30.0) * draw.chance(0.4)
        table["joint_friction"] = draw.power(1e-2, 1.0) * draw.chance(0.15)
        table["joint_armature"] = draw.power(1e-4, 1e-2) * draw.chance(0.0)
    return table


def slider_of(draw: Draw) -> dict[str, Any]:
    """Return the table of a slider with some of its possible features."""
    table = {
        "angle": draw.one((0.0, math.pi / 2, draw.real(-math.pi, math.pi))),
        "mass": draw.one((0.0, draw.power(0.1, 5.0)), (0.2, 0.8)),
        "damping": draw.power(0.01, 3.0) * draw.chance(0.4),
        "stiffness": draw.power(1.0, 200.0) * draw.chance(0.4),
        "rest_position": draw.real(-0.2, 0.2),
        "friction": draw.power(0.1, 5.0) * draw.chance(0.3),
    }
    for key, sign, none in (("min", -1.0, 0.1), ("max", 1.0, 0.0)):
        if draw.chance(0.5):
            table[key] = sign * draw.one((0.0, draw.real(0.02, 0.5)), (none, 1.0 - none))
    return table


def with_drives(data: dict[str, Any], draw: Draw) -> dict[str, Any]:
    """Return the table with drives that have targets, forces or limits; a pinned base and walls may move."""
    chain, count = data["chain"], len(data["chain"]["links"])
    joints, slides = range(1 + (chain["base"] == "free"), count + 1), chain["base"] == "slider"
    follow, pushed, stop = draw.chance(0.5), draw.chance(0.5), data["simulation"]["stop_time"]
    for n in joints:
        link = chain["links"][n - 1]
        link["joint_armature"] = draw.power(1e-4, 1e-2) * draw.chance(0.4)
        if draw.chance(0.4):
            link["joint_torque_limit"] = draw.power(0.03, 10.0)
        if draw.chance(0.3) and "joint_min" not in link:
            angles = data["initial"]["angles"]
            bend = angles[n - 1] - (angles[n - 2] if n > 1 else 0.0)
            link |= {"joint_min": bend - draw.real(0.0, 1.0), "joint_max": bend + draw.real(1e-3, 1.0)}
    if slides and draw.chance(0.4):
        chain["slider"]["force_limit"] = draw.power(0.1, 30.0)
    still = chain["base"] == "pinned" and draw.chance(0.4)
    # ``wall_names`` leaves out walls that no point may touch; these do not move
    there = scene_from_dict(data, "bodies").wall_names
    moving = [wall["name"] for wall in data["walls"] if draw.chance(0.5) and wall["name"] in there]
    data["inputs"] = {
        "joint_targets": follow,
        "joint_torques": pushed,
        "slider_force": slides and pushed,
        "base_motion": still,
        "wall_motion": moving,
    }
    names = [f"joint[{n}].{'torque' if pushed else 'target_angle'}" for n in joints if pushed or follow]
    names += [f"slider.{'force' if pushed else 'target_position'}"] * (slides and (pushed or follow))
    names += [f"wall.{name}.belt_speed" for name in moving if draw.chance(0.5)]
    swings = [f"wall.{name}.displacement" for name in moving if draw.chance(0.7)]
    swings += [f"base.{axis}" for axis in "xy"] * still
    data["signals"] = {f"drive_{k}": {"input": name, **signal(draw, stop)} for k, name in enumerate(names)}
    for k, name in enumerate(swings):
        size = draw.power(1e-3, 0.1)
        # 1 − cos: the motion begins at rest, at the present position
        swing = {"mean": size, "amplitude": size, "phase": -math.pi / 2}
        data["signals"][f"swing_{k}"] = {
            "input": name,
            "form": "sine",
            "frequency": draw.power(0.3, 10.0) / stop,
            **swing,
        }
    return data


def signal(draw: Draw, stop: float) -> dict[str, Any]:
    """Return a constant, a sine, a ramp or steps for a drive or a belt, over a time of ``stop`` [s]."""
    size, start = draw.power(0.05, 5.0) * draw.one((-1.0, 1.0)), stop * draw.real(0.0, 0.6)
    return draw.one(
        (
            {"form": "constant", "value": size},
            {"form": "sine", "amplitude": size, "frequency": draw.power(0.5, 20.0) / stop, "start": start},
            {"form": "ramp", "final": size, "start": start, "duration": stop * draw.power(0.01, 0.5)},
            {"form": "steps", "times": [0.0, start + 1e-3 * stop], "values": [0.0, size]},
        )
    )


def contact(draw: Draw, count: int, base: str) -> dict[str, Any]:
    """Return the table of any contact law.

    Joints are points only sometimes, because bodies have other points.
    """
    law = CONTACT_LAWS[draw.one([*CONTACT_LAWS])]
    movable = range(base == "pinned", count + 1)
    table: dict[str, Any] = {
        "model": law.id,
        "exponent": law.exponent or draw.one((1.5, 1.0, draw.real(1.0, 2.5))),
        "stiffness": draw.power(1e4, 1e8),
        "restitution": draw.one((0.0 if law.allows_zero else 0.05, draw.real(0.05, 1.0))),
        "radius": draw.power(1e-3, 0.03) * draw.chance(0.3),
        "points": [k for k in movable if draw.chance(0.3)],
    }
    if draw.chance(0.5) and not law.rigid:
        table["friction"] = draw.real(0.05, 1.2)
        table["static_friction"] = table["friction"] * draw.one((0.0, draw.real(1.0, 1.4)))
    return table


def walls(draw: Draw, scene: Scene, driven: bool) -> list[dict[str, Any]]:
    """Return one to three walls near the points that may touch; ``driven``: also near a pinned base."""
    links, tables = len(scene.chain.links), []
    may = {point for point in scene.start if point > links} | {*scene.contact.points}
    if driven and scene.chain.base == "pinned":
        may.add(0)  # base and walls must not move through each other
    places = [(x, y, radius) for point, (x, y, radius) in scene.start.items() if point in may]
    for number in range(draw.whole(1, 3)):
        angle = draw.one((0.0, draw.real(-math.pi, math.pi)))
        if scene.chain.slider and scene.chain.slider.angle == angle:
            angle += 0.1  # a wall that is parallel to the motion of all points is refused
        nx, ny = -math.sin(angle), math.cos(angle)
        least = min((nx * x + ny * y - radius for x, y, radius in places), default=0.0)
        at = least - draw.one((0.0, draw.power(1e-6, 1e-2), draw.real(0.01, 0.5)), (0.1, 0.1, 0.8))
        tables.append({"name": f"w{number}", "point": [nx * at, ny * at], "angle": angle})
    return tables


def faults(seed: int) -> list[str]:
    """Return the faults in the scene of a seed, each in words that begin with the kind."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = bodies(seed)
        stop = scene.simulation.stop_time
        try:
            run = simulate(scene, output_step=stop / ROWS)
        except SimulationError as error:
            moves = scene.inputs.base_motion or scene.inputs.wall_motion
            return [] if moves and error.status in CLOSED else [f"stopped: {error}"]
        except Exception as error:
            return [f"raised: {error!r}"]
        other = simulate(scene, output_step=stop / 3)
    return [
        *wrong_energy(run),
        *wrong_motion(run),
        *(["observed: the output step changes impacts"] * (not same(run, other))),
    ]


def same(run: Result, other: Result) -> bool:
    """Return whether two runs have the same impacts and the same end, bit by bit."""
    names = ("point[0].x", "point[0].vy", *(f"link[{i + 1}].angle" for i in range(run.link_count)))
    return run.impacts.tobytes() == other.impacts.tobytes() and all(run[n][-1] == other[n][-1] for n in names)


def wrong_energy(run: Result) -> list[str]:
    energy = run.energy
    balance = energy["total"] + energy["dissipated"] - energy["supplied"]
    size = max(np.abs(energy[name]).max() for name in ("kinetic", "potential", "elastic", "dissipated"))
    off = np.abs(balance - balance[0]).max() / (size or 1.0)
    messages = (
        [f"energy: off by {off:.1e} of {size:.3g} J"] if off > BALANCE * run.scene.solver.tolerance else []
    )
    fall = -np.diff(energy["dissipated"]).min(initial=0.0) / (size or 1.0)
    if fall > FALL * run.scene.solver.tolerance:
        messages.append(f"energy: dissipation falls by {fall:.1e} of {size:.3g} J")
    return messages


def wrong_motion(run: Result) -> list[str]:
    """Return faults of accelerations and penetrations, compared with the independent model."""
    scene, messages, model = run.scene, [], BodyModel(of_rows(run.scene))
    inputs = {*inputs_of(scene)} & {*run.names}
    for row in range(len(run.time)):
        model.base |= {name: run[name][row] for name in inputs}
        model.set_inputs(run.time[row])
        y = state_of(run, model, row)
        place, look = model.locate(y), model.look(y, ())
        # first all forces except those of contacts, stops and friction, which the loops below add; with all
        # of them Pᵀ (M q̈ − f) = 0 must hold
        q = accelerations_of(run, row)
        force = (place.mass @ look.acceleration[..., None])[0, :, 0]
        sizes = [np.abs(force).max(), np.abs(place.mass[0] @ q).max(), 1e-3]
        for c, (point, wall) in enumerate(zip(model.points, model.walls, strict=True)):
            name = scene.wall_names[wall]
            of = f"contact[{point}].{name}."
            push, depth = run[f"{of}force"][row], run[f"{of}penetration"][row]
            gap = place.gap[0, c].real - model.value(f"wall.{name}.displacement")[0].real
            rigid = CONTACT_LAWS[scene.contact.model].rigid
            if gap < -max(DEEP, 30.0 * scene.solver.tolerance) and not (rigid or depth > 0.0):
                messages.append(f"behind: {of} is {-gap:.1e} beyond, without contact, at {run.time[row]:g} s")
            if depth > 0.0 and abs(depth + gap) > DEEP:
                messages.append(
                    f"depth: {of} is {depth:.9g}, by its place {-gap:.9g}, at {run.time[row]:g} s"
                )
            force = force + model.gradient(place, c)[0] * push
            sizes.append(abs(push))
        for joint in {joint for joint, _ in scene.chain.stops}:
            push = run[f"joint[{joint}].stop_moment"][row]
            force = force + model.joint_row(joint - 1)[0] * push
            sizes.append(abs(push))
        for e in model.friction.sliding:
            rub = run[friction_name(model, e)][row]
            force = force + model.friction.row(place, e)[0] * rub
            sizes.append(abs(rub))
        left = model.ways[0].T @ (place.mass[0] @ q - force)
        if np.abs(left).max() > RESIDUAL * max(sizes):
            messages.append(
                f"newton: {np.abs(left).max():.1e} N of {max(sizes):.2e} N at {run.time[row]:g} s"
            )
    return messages


def of_rows(scene: Scene) -> Scene:
    """Return the scene without stops in joints, and without signals, whose values the rows of a run give."""
    links = tuple(replace(link, joint_min=None, joint_max=None) for link in scene.chain.links)
    return replace(scene, chain=replace(scene.chain, links=links), signals={})


def state_of(run: Result, model: BodyModel, row: int) -> np.ndarray:
    """Return the state of the model for a row of a run."""
    y, n = np.zeros((1, model.size), complex), model.links
    for j, axis in enumerate("xy"):
        y[:, j], y[:, model.v.start + j] = run[f"point[0].{axis}"][row], run[f"point[0].v{axis}"][row]
    for i in range(n):
        y[:, 2 + i] = run[f"link[{i + 1}].angle"][row]
        y[:, model.v.start + 2 + i] = run[f"link[{i + 1}].angular_velocity"][row]
    return y


def accelerations_of(run: Result, row: int) -> np.ndarray:
    """Return the accelerations of the coordinates in a row of a run."""
    links = (f"link[{i + 1}].angular_acceleration" for i in range(run.link_count))
    return np.array([run[name][row] for name in ("point[0].ax", "point[0].ay", *links)])


def friction_name(model: BodyModel, e: int) -> str:
    """Return the name of the output with the force of an element of dry friction."""
    if e < model.friction.first_joint:
        return f"contact[{model.points[e]}].{model.scene.wall_names[model.walls[e]]}.friction_force"
    joint = e - model.friction.first_joint
    return "slider.friction_force" if joint == model.links else f"joint[{joint + 1}].friction_moment"


if __name__ == "__main__":
    first, count = int(sys.argv[1]), int(sys.argv[2])
    kinds: Counter[str] = Counter()
    for number in range(first, first + count):
        messages = faults(number)
        kinds.update({text.partition(":")[0] for text in messages} or {"right"})
        for text in messages[:3]:
            print(number, text, flush=True)
    print(dict(kinds))

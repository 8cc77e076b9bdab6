"""Checks of the loads in joints at each row of a run, for the random search (oracle.py)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from chain_impact.scene.candidates import candidates_of

NEWTON, MOMENTUM = 1e-9, 1e-8  # allowed errors of Newton's law and of momentum, over the largest term
# The allowed error of a peak is (SAMPLED + ROUGH × tolerance) × the largest force, as a peak is a sample.
SAMPLED, ROUGH = 1e-6, 1000.0
SMALL = 1e-12  # over the weight, or over a momentum of one link length per second


def load_checks(run: Any) -> Iterator[tuple[str, float, float, str]]:
    """Return kind, value, bound and words of each check; none for a run without loads.

    The expected load of a joint follows from the motion, by Newton's law for all links from this joint on.
    """
    outputs, scene = run.outputs, run.scene
    if not scene.outputs.loads:
        return
    chain, gravity, time = run.chain, np.array(scene.gravity), run.time
    count = len(scene.chain.links)
    force, impulse = (vectors(outputs["transmitted"], count, kind) for kind in ("", "impulse_"))
    mass, all_mass = chain.mass[:, None], chain.mass.sum()
    small = SMALL * all_mass * (chain.size + np.linalg.norm(gravity))

    parts = mass * (run.centres("point_acceleration") - gravity), -outside(run, "force", run.tip)
    momentum_rate, scale = summed(parts)
    off = np.abs(force - momentum_rate).max(axis=(1, 2)) - NEWTON * scale
    yield "newton", float(off.max()), small, "a force in a joint off Newton's law, beyond 1e-9 [N]"

    momentum = mass * run.centres("point_velocity")
    weight = -mass * gravity * time[:, None, None]
    given = -outside(run, "impulse", np.outer(time, run.tip))
    momentum_rate, _ = summed((momentum - momentum[0], weight, given))
    _, scale = summed((momentum, weight, given))
    off = np.abs(impulse - momentum_rate).max(axis=(1, 2)) - MOMENTUM * np.maximum.accumulate(scale)
    yield "momentum", float(off.max()), small, "an impulse in a joint off the momentum, beyond 1e-8 [N·s]"

    joints = slice(0 if scene.chain.base == "pinned" else 1, None)
    sizes, peaks = (
        np.linalg.norm(force, axis=2)[:, joints],
        outputs["transmitted"]["peak"][:, :count][:, joints],
    )
    if not sizes.shape[1]:
        return
    near = small + (SAMPLED + ROUGH * scene.solver.tolerance) * float(peaks.max())
    above = np.maximum.accumulate(sizes) - peaks
    yield "peak", float(above.max()), near, "a force in a joint above its peak so far [N]"
    fall = np.maximum.accumulate(peaks) - peaks
    yield "peak falls", float(fall.max()), near, "a peak in a joint that falls [N]"
    for impact in run.impacts:
        # False if the end of a contact is NaN because it lasts
        within = (time > impact["onset"]) & ~(time >= impact["end"])
        above = float(sizes[within].max(initial=0.0)) - float(impact["joint_force"])
        yield "peak of impact", above, near, "a force in a joint above that of the impact that lasts [N]"


def vectors(loads: Any, count: int, kind: str) -> np.ndarray:
    """Return forces or impulses in the joints, shape (T, N, 2)."""
    return np.stack([loads[f"{kind}{axis}"][:, :count] for axis in "xy"], axis=-1)


def summed(parts: tuple[np.ndarray, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return for each link the sum of parts over it and all later links, (T, N, 2), and the scale, (T,).

    The scale is the largest sum of magnitudes of one part over all links, along x or y.
    """
    whole = sum(parts)[:, ::-1].cumsum(axis=1)[:, ::-1]
    sizes = [np.abs(part).sum(axis=1).max(axis=1) for part in parts]
    return whole, np.max(sizes, axis=0)


def outside(run: Any, kind: str, at_tip: np.ndarray) -> np.ndarray:
    """Return the forces, or impulses, of walls and of the input on the links, shape (T, N, 2)."""
    outputs, scene = run.outputs, run.scene
    loads = np.zeros((len(outputs), len(scene.chain.links), 2))
    for c, (point, number) in enumerate(candidates_of(scene)):
        if wall := scene.half_planes.get(scene.wall_names[number]):
            normal = np.array(wall.normal)
            on = np.outer(outputs[kind][:, c], normal)
            if scene.has_friction:
                on += np.outer(outputs["friction"][kind][:, c], [normal[1], -normal[0]])
            loads[:, max(point, 1) - 1] += on
    loads[:, -1] += at_tip
    return loads

"""The limits of Newton's law for a fold of equal links that is dropped on two nearly coinciding points.

W = J M⁻¹ Jᵀ of the two points is nearly singular: impulses of any sign that stop both points could lose any
energy and have any size. ``faults(scene)`` follows the fold of a seed (random_scenes.py) from onset to onset,
and compares every impact with the limits of Newton's law.

Moreau's form of the law, 0 ≤ p ⟂ u⁺ + e u⁻ ≥ 0 with u⁺ = u⁻ + W p, has p = (1 + e) p̂ with p̂ the impulses
for e = 0. So an impact dissipates −½ p·(u⁻ + u⁺) = (1 − e²) T̂ with T̂ = ½ p̂·W p̂ = −½ p̂·u⁻, the loss of an
inelastic impact: the least energy whose removal lets no point arrive. T̂ is ½ u⁻·W⁻¹ u⁻ over the points that
have an impulse.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from chain_impact.kernel.events.rigid_impacts import LEAST_REBOUND_SPEED
from chain_impact.kernel.status import ONSET_DUE
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.random_scenes import FOLD_TOLERANCE as TOLERANCE, LENGTH
from tests.helpers.kernel.kernel_calls import advance_to_onset, event_update
from tests.helpers.models.reference import clearance_gradient, mass_matrix
from tests.helpers.scenes.problems import GRAVITY

TOUCHING = 1e-12  # m
ROUND_OFF = 1e-9  # largest error by round-off, over the energy of the chain
# The largest pull, over the largest possible momentum: a point that rises with less speed than round-off is
# stopped, which takes back this part of an impulse that the wall gives just before or after.
STOP = 1e-7
ERRORS = 100.0  # allowed sum of the errors of steps, in tolerances of the energy of the chain
EPSILON = 2.0**-52
MOST_IMPACTS = 200


def faults(scene: Scene) -> dict[str, float]:
    """Return the violations of the law in a run of the scene: kind → size, over the allowed size.

    ``pull``: an impulse below 0; ``pulling contact``: a negative sum of the impulses of a contact.
    ``impulse``: a sum of impulses larger than the energy explains. ``loss``: an impact loses more than
    (1 − e²) T̂.
    ``held``: walls that hold points lose more than errors of steps explain. ``gain``: an increase of energy.
    ``status``: the run ends early; its size is the number of the status. Only the first MOST_IMPACTS impacts
    are looked at.
    """
    instance = Instance(scene)
    stop, sizes = scene.simulation.stop_time, {}

    def note(kind: str, value: float, allowed: float) -> None:
        if not value <= allowed:
            sizes[kind] = max(sizes.get(kind, 0.0), value / allowed)

    first = after = row(instance)
    mass = sum(link.mass for link in scene.chain.links)
    # relative to the lowest position that the chain can reach
    there = float(first["total"]) + mass * GRAVITY * LENGTH * len(scene.chain.links)
    momentum = math.sqrt(2.0 * mass * there)
    errors = ERRORS * TOLERANCE * there
    for _ in range(MOST_IMPACTS):
        status = advance_to_onset(instance, stop)
        before = row(instance)
        note("pull", (after["impulse"] - before["impulse"]).max(), STOP * momentum)
        note("held", before["dissipated"] - after["dissipated"], errors)
        note("gain", before["total"] + before["dissipated"] - first["total"], errors)
        if status != ONSET_DUE:
            break
        bound = loss_bound(scene, instance, before)
        status = event_update(instance)
        after = row(instance)
        lost = after["dissipated"] - before["dissipated"]
        note("loss", lost - bound, ROUND_OFF * there)
        note("gain", after["total"] - before["total"], ROUND_OFF * there)
        note("pull", (before["impulse"] - after["impulse"]).max(), STOP * momentum)
        if status:
            break
    contacts = np.concatenate([instance.collect(), instance.open_contacts()])
    note("pulling contact", -contacts["impulse"].min(initial=0.0), EPSILON * momentum)
    given = after["impulse"].sum()
    note("impulse", given, 2.0 * momentum + mass * GRAVITY * instance.time)
    if instance.status:
        sizes["status"] = float(instance.status)
    return sizes


def row(instance: Instance) -> np.void:
    """Return the present outputs."""
    instance.observe()
    return instance.record["output"].copy()


def loss_bound(scene: Scene, instance: Instance, before: np.void) -> float:
    """Return (1 − e²) T̂ [J] of the points that touch in a row of outputs.

    T̂ if some points are slow enough to rest.
    """
    held = instance.record["contacts"]["active"] == 1
    gaps, u = before["point_position"][:, 1], before["point_velocity"][:, 1].copy()
    points = np.array(scene.contact.points)
    # points that are held are at rest except for errors
    u[points[held]] = 0.0
    touching = points[held | (gaps[points] < TOUCHING)]
    gradient = np.array([clearance_gradient(scene, before["angle"], k, "y_min") for k in touching])
    u = u[touching]
    response = np.linalg.solve(mass_matrix(scene, before["angle"]), gradient.T)
    e, least = scene.contact.restitution, scene.contact.minimum_impact_speed
    rests = (u < 0.0) & ((-u < least) | (-e * u < LEAST_REBOUND_SPEED * least))
    if rests.any():
        e = 0.0
    return (1.0 - e * e) * inelastic_loss(gradient @ response, u)


def inelastic_loss(w: np.ndarray, u: np.ndarray) -> float:
    """Return T̂ [J] as the maximum of −p·u − ½ p·W p over p ≥ 0, also for a nearly singular W."""
    most = 0.0
    for count in range(1, len(u) + 1):
        for chosen in combinations(range(len(u)), count):
            part = list(chosen)
            p = np.linalg.lstsq(w[np.ix_(part, part)], -u[part], rcond=None)[0]
            if (p >= 0.0).all():
                most = max(most, float(-0.5 * p @ u[part]))
    return most

"""What Newton's law allows to a fold of equal links, two points of which all but coincide, dropped on both.

There W = J M⁻¹ Jᵀ of the two is near-singular: what stops both, whatever the sign of the impulses, can take
any energy and make any impulse. ``faults(scene)`` follows the fold of a seed (tests/helpers/random_scenes.py)
from onset to onset and holds every impact against what Newton's law allows.

Moreau's form of the law, 0 ≤ p ⟂ u⁺ + e u⁻ ≥ 0 with u⁺ = u⁻ + W p, has p = (1 + e) p̂ with p̂ those of e = 0.
So an impact takes −½ p·(u⁻ + u⁺) = (1 − e²) T̂ with T̂ = ½ p̂·W p̂ = −½ p̂·u⁻, what the inelastic impact takes:
the least energy whose removal lets no point arrive. It is ½ u⁻·W⁻¹ u⁻ over the points that have an impulse.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from chain_impact.kernel.events.impacts import STICK
from chain_impact.kernel.status import ONSET_DUE
from chain_impact.scene.scene import Scene
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel_calls import advance_to_onset, event_update
from tests.helpers.problems import GRAVITY
from tests.helpers.random_scenes import FOLD_TOLERANCE as TOLERANCE, LENGTH
from tests.helpers.reference import clearance_gradient, mass_matrix

TOUCHING = 1e-12  # m
ROUND_OFF = 1e-9  # of the energy that there is
# Of the momentum that it can be in: a point that rises by less than round-off is stopped, which takes this
# much of an impulse that the wall has given before or gives soon.
STOP = 1e-7
ERRORS = 100.0  # tolerances of the energy that there is, for what errors of steps add up to
EPSILON = 2.0**-52
MOST_IMPACTS = 200


def faults(scene: Scene) -> dict[str, float]:
    """What breaks the law in a run of the scene: kind → by how much, in parts of what is allowed.

    ``pull``: an impulse below 0; ``pulling contact``: the sum of those of a contact. ``impulse``: more of it
    than the energy that there was can ask for. ``loss``: an impact takes more than (1 − e²) T̂. ``held``:
    walls that hold take more than errors of steps may. ``gain``: energy from nothing. ``status``: the run
    ends early.
    """
    instance = Instance(scene)
    stop, found = scene.simulation.stop_time, {}

    def note(kind: str, value: float, allowed: float) -> None:
        if not value <= allowed:
            found[kind] = max(found.get(kind, 0.0), value / allowed)

    first = after = row(instance)
    mass = sum(link.mass for link in scene.chain.links)
    # over the lowest that the chain can come to
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
        found["status"] = float(instance.status)
    return found


def row(instance: Instance) -> np.void:
    """The outputs as they are now."""
    instance.observe()
    return instance.record["output"].copy()


def loss_bound(scene: Scene, instance: Instance, before: np.void) -> float:
    """(1 − e²) T̂ [J] of the points that touch in a row of outputs; T̂ if some are so slow that they rest."""
    held = instance.record["touch"]["active"] == 1
    gaps, u = before["point_position"][:, 1], before["point_velocity"][:, 1].copy()
    points = np.array(scene.contact.points)
    # those that are held stand still but for errors
    u[points[held]] = 0.0
    touching = points[held | (gaps[points] < TOUCHING)]
    gradient = np.array([clearance_gradient(scene, before["angle"], k, "y_min") for k in touching])
    u = u[touching]
    response = np.linalg.solve(mass_matrix(scene, before["angle"]), gradient.T)
    e, least = scene.contact.restitution, scene.contact.minimum_impact_speed
    rests = (u < 0.0) & ((-u < least) | (-e * u < STICK * least))
    if rests.any():
        e = 0.0
    return (1.0 - e * e) * inelastic_loss(gradient @ response, u)


def inelastic_loss(w: np.ndarray, u: np.ndarray) -> float:
    """T̂ [J] as the most of −p·u − ½ p·W p over p ≥ 0, which no near-singular W can spoil."""
    most = 0.0
    for count in range(1, len(u) + 1):
        for chosen in combinations(range(len(u)), count):
            part = list(chosen)
            p = np.linalg.lstsq(w[np.ix_(part, part)], -u[part], rcond=None)[0]
            if (p >= 0.0).all():
                most = max(most, float(-0.5 * p @ u[part]))
    return most

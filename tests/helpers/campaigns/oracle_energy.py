"""Bounds on the energies of a run, for the checks of the random search (oracle.py)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from tests.helpers.campaigns.oracle import Account

SAFETY = 3.0  # factor on the tolerance, because the error control uses estimates, and scales are sampled
INTERPOLATED = 10.0  # error of an output between steps, over the error of a step
EPSILON = 2.0**-52


def energy_bound(run: Account) -> float:
    """Return the largest allowed drift of the energy balance [J].

    The exact motion conserves the energy balance, from any state. So the drift is the sum of the changes by
    errors of the steps, and nothing amplifies these changes. The error of one step may be the tolerance times
    a scale for each component of the state (docs/computation.md, error norm); ``energy_scale`` is the
    resulting change of the balance, to first order. The errors of n steps add up like √n, because they have
    no common sign. An output between steps is interpolated, with an error up to ten times as large. SAFETY
    covers two facts: the solver uses an estimate of a step's error, and the scale is sampled only at some
    points. The largest drift in the scenes of 2000 seeds was √n/2 times tolerance and scale.

    Round-off is added: a few units in the last place of the energies and, at stiff walls, of the positions,
    because a force F turns an error of a position into an error of energy.
    """
    return per_step(run, energy_scale(run))


def per_step(run: Account, scale: float) -> float:
    """Return the energy change [J] that round-off and allowed errors cause in all steps of a run.

    An allowed error is the tolerance times a scale [J].
    """
    steps = max(1.0, float(run.statistics["steps"]))
    errors = SAFETY * max(INTERPOLATED, steps**0.5) * run.scene.solver.tolerance * scale
    return float(errors + steps * round_off(run))


def energy_scale(run: Account) -> float:
    """Return a bound [J] on the change of the energy balance by an error of one, in units of the error norm.

    Kinetic: with |δv₀| ≤ s/1s + |v₀| and |δω| ≤ 1 rad/s + |ω|, Σ m |v_C| |δv_C| + I |ω| |δω|. Potential: with
    |δx₀| ≤ s and |δθ| ≤ 1 rad, Σ m |g| |δx_C|. Dissipated: its scale in the norm. Elastic: F |δg| with the
    scale of the penetration, and k |φ| |δφ| with |δφ| ≤ 1 rad. The supplied energy is not controlled: its
    absolute value counts.

    A motion with more energy than is available counts with the available energy, so that an explosion does
    not increase its own bound.
    """
    chain, outputs, there = run.chain, run.outputs, available(run)
    share = np.sqrt(np.minimum(1.0, there / np.maximum(outputs["kinetic"], 1e-300)))[:, None]
    base = chain.size + share * np.linalg.norm(outputs["point_velocity"][:, :1], axis=2)
    omega = share * np.abs(outputs["angular_velocity"])
    error = base + np.cumsum(chain.length * (1.0 + omega), axis=1)
    speed = share * np.linalg.norm(run.centres("point_velocity"), axis=2)
    kinetic = (chain.mass * speed * error + chain.inertia * omega * (1.0 + omega)).sum(axis=1).max()
    gravity = np.linalg.norm(run.scene.gravity)
    potential = gravity * (chain.mass * (chain.size + np.cumsum(chain.length))).sum()
    supplied = np.abs(outputs["supplied"]).max()
    walls_and_springs = elastic_scale(run) + float(spring_moments(run).sum())
    return float(kinetic + potential + supplied + dissipated_scale(run) + walls_and_springs)


def spring_moments(run: Account) -> np.ndarray:
    """Return the largest moment of each joint's spring [N·m], which is the energy for an error of 1 rad."""
    links = run.scene.chain.links
    stiffness = np.array([link.joint_stiffness for link in links])
    if run.scene.chain.base == "free":
        stiffness[0] = 0.0
    rest = np.array([link.joint_rest_angle for link in links])
    angles = np.diff(run.outputs["angle"], axis=1, prepend=0.0) - rest
    return stiffness * np.abs(angles).max(axis=0)


def dissipated_scale(run: Account) -> float:
    """Return the scale of the dissipated energy [J]: the energy of the error norm plus energies of the run.

    These are the dissipated energy and the largest kinetic energy of an onset, together at most twice the
    available energy.
    """
    sizes = np.abs(run.outputs["dissipated"]).max() + brought(run)
    return run.chain.energy + min(float(sizes), 2.0 * float(available(run).max()))


def available(run: Account) -> np.ndarray:
    """Return the energy [J] that motion, walls and heat can have in each row, at least 0.

    It is the total energy at the start plus the supplied energy, minus the potential energy.
    """
    outputs = run.outputs
    return np.maximum(0.0, outputs["total"][0] + outputs["supplied"] - outputs["potential"])


def elastic_scale(run: Account) -> float:
    """Return the largest product of a contact's K δⁿ and the scale of its penetration [J]; 0 without any."""
    impacts, law = run.impacts, run.laws_of_impacts
    if not len(impacts):
        return 0.0
    depth, (v0, foreseen) = impacts["max_penetration"], expected(run)
    chain = run.chain
    leeway = np.maximum(1.0, np.minimum(chain.size / law.unit / v0, 0.01 / run.scene.solver.tolerance))
    # the error of a clearance is at most the error of the coordinates
    error = np.minimum(np.maximum(depth, foreseen) * leeway, (chain.size + chain.length.sum()) / law.unit)
    return float((law.stiffness * np.maximum(depth, 0.0) ** law.exponent * error).max())


def expected(run: Account) -> tuple[np.ndarray, np.ndarray]:
    """Return v₀ [m/s] of each contact, and the depth δ* [m] with K δ*ⁿ⁺¹/(n+1) = ½ m v₀²; at stops in rad.

    δ* is 0 for a rigid contact.
    """
    law = run.laws_of_impacts
    v0, n = np.maximum(run.impacts["impact_speed"], law.slowest), law.exponent
    with np.errstate(divide="ignore"):
        depth = (0.5 * run.impacts["effective_mass"] * v0**2 * (n + 1) / law.stiffness) ** (1 / (n + 1))
    return v0, np.where(law.stiffness > 0.0, depth, 0.0)


def brought(run: Account) -> float:
    """Return the largest kinetic energy with which a contact began, ½ m v₀² [J]."""
    v0 = np.maximum(run.impacts["impact_speed"], run.laws_of_impacts.slowest)
    return float((0.5 * run.impacts["effective_mass"] * v0**2).max(initial=0.0))


def round_off(run: Account) -> float:
    """Return the change of the energy balance by round-off in a step [J]."""
    outputs = run.outputs
    terms = sum(
        np.abs(outputs[name]).max() for name in ("kinetic", "potential", "elastic", "dissipated", "supplied")
    )
    # sums of terms that may cancel
    far = np.abs(outputs["point_position"]).max()
    terms += run.chain.mass.sum() * np.linalg.norm(run.scene.gravity) * far
    if len(run.impacts):
        law = run.laws_of_impacts
        force = law.stiffness * np.maximum(0.0, run.impacts["max_penetration"]) ** law.exponent
        terms += (force * np.where(law.stop, 2.0 * np.abs(outputs["angle"]).max(), far)).max()
    terms += (spring_moments(run) * np.abs(outputs["angle"]).max(axis=0)).sum()
    return float(4.0 * EPSILON * terms)


def dissipation_bound(run: Account) -> float:
    """Return the largest allowed decrease of the dissipated energy [J]: the true rate is ≥ 0."""
    return per_step(run, dissipated_scale(run))

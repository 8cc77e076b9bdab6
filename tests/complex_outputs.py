"""The outputs of the FMU from a state of the chain in complex numbers."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np

from tests.complex_chain import ComplexChain, Place, Touch


def outputs_of(chain: ComplexChain, y: np.ndarray, touches: Sequence[Touch]) -> dict[str, np.ndarray]:
    """All outputs of a state, by their names in the FMU, each of shape (lanes,)."""
    look = chain.look(y, touches)
    values = {"time": y[:, chain.time]}
    acceleration = chain.point_accelerations(look)
    for k in range(chain.links + 1):
        for j, axis in enumerate("xy"):
            values[f"point[{k}].{axis}"] = look.place.position[:, k, j]
            values[f"point[{k}].v{axis}"] = look.place.velocity[:, k, j]
            values[f"point[{k}].a{axis}"] = acceleration[:, k, j]
    for i in range(chain.links):
        values[f"link[{i + 1}].angle"] = look.place.angle[:, i]
        values[f"link[{i + 1}].angular_velocity"] = look.place.omega[:, i]
        values[f"link[{i + 1}].angular_acceleration"] = look.acceleration[:, 2 + i]
    elastic = look.spring_energy
    for touch, (_, spring) in zip(touches, look.pairs, strict=True):
        # K δⁿ⁺¹/(n+1)
        elastic = elastic - spring * look.place.gap[:, touch.candidate] / (touch.law.exponent + 1.0)
    values |= _at_walls(chain, y, touches, look) | _at_stops(chain, y, touches, look)
    values |= _energies(chain, y, look.place, elastic) | _of_friction(chain, y, look)
    return {name: value.copy() for name, value in values.items()}


def _at_walls(
    chain: ComplexChain, y: np.ndarray, touches: Sequence[Touch], look: SimpleNamespace
) -> dict[str, np.ndarray]:
    names, values = chain.scene.wall_names, {}
    zero = np.zeros(chain.lanes, complex)
    active = {touch.candidate: i for i, touch in enumerate(touches)}
    for c in range(chain.at_walls):
        name, i = f"contact[{chain.points[c]}].{names[chain.walls[c]]}", active.get(c)
        values[f"{name}.force"] = zero if i is None else look.pairs[i][0]
        values[f"{name}.penetration"] = zero if i is None else -look.place.gap[:, c]
        values[f"{name}.penetration_rate"] = zero if i is None else -look.place.gap_rate[:, c]
        values[f"{name}.impulse"] = y[:, chain.impulse + c]
    return values


def _at_stops(
    chain: ComplexChain, y: np.ndarray, touches: Sequence[Touch], look: SimpleNamespace
) -> dict[str, np.ndarray]:
    """Moment and impulse of both stops of a joint together, and how far it is beyond one of them."""
    values = {}
    zero = np.zeros(chain.lanes, complex)
    for joint in set(chain.joints):
        for output in ("moment", "impulse", "penetration"):
            values[f"joint[{joint + 1}].stop_{output}"] = zero
    for i, (joint, side) in enumerate(zip(chain.joints, chain.side, strict=True), chain.at_walls):
        impulse = f"joint[{joint + 1}].stop_impulse"
        values[impulse] = values[impulse] + side * y[:, chain.impulse + i]
    for touch, (force, _) in zip(touches, look.pairs, strict=True):
        if (stop := touch.candidate - chain.at_walls) >= 0:
            name = f"joint[{chain.joints[stop] + 1}].stop_"
            values[f"{name}moment"] = chain.side[stop] * force
            values[f"{name}penetration"] = -look.place.gap[:, touch.candidate]
    return values


def _of_friction(chain: ComplexChain, y: np.ndarray, look: SimpleNamespace) -> dict[str, np.ndarray]:
    """Forces, moments and impulses of dry friction, and what it has dissipated."""
    dry, values = chain.friction, {}
    zero = np.zeros(chain.lanes, complex)
    for e in dry.sliding:
        force = look.friction.get(e, zero)
        if e >= dry.first_joint:
            values[f"joint[{e - dry.first_joint + 1}].friction_moment"] = force
        else:
            name = f"contact[{chain.points[e]}].{chain.scene.wall_names[chain.walls[e]]}.friction_"
            values[f"{name}force"], values[f"{name}impulse"] = force, y[:, chain.tangential + e]
    return values | ({"energy.friction": y[:, chain.rubbed]} if dry.sliding else {})


def _energies(chain: ComplexChain, y: np.ndarray, place: Place, elastic: np.ndarray) -> dict[str, np.ndarray]:
    v = y[:, chain.v]
    momentum = (chain.mass_matrix(place) @ v[..., None])[..., 0]
    kinetic = 0.5 * (v * momentum).sum(1)
    # Σ m x_C: of the base, and b_i e_i
    moment = chain.total[:, None] * place.position[:, 0] + (chain.b[..., None] * place.along).sum(1)
    potential = -(chain.gravity * moment).sum(1)
    return {
        "energy.kinetic": kinetic,
        "energy.potential": potential,
        "energy.elastic": elastic,
        "energy.dissipated": y[:, chain.dissipated],
        "energy.supplied": y[:, chain.supplied],
        "energy.total": kinetic + potential + elastic,
        "momentum.x": momentum[:, 0],
        "momentum.y": momentum[:, 1],
    }

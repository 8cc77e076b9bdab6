"""Dry friction beside MuJoCo: ``python benchmarks/friction.py [--quick]``.

A rod that rests on a slope by friction: how fast does it creep, and what does that cost? Two links that are
thrown onto a floor with friction: the error of the state in motion and at rest against the cost, and how much
energy errors add. MuJoCo's contact is another one than ours, so each is judged by its own converged run.
Without damping, MuJoCo's integrators Euler, implicit and implicitfast are the same; so it is Euler and RK4.
"""

from __future__ import annotations

import common  # isort: skip

import math
from dataclasses import replace
from typing import Any

import numpy as np
import peers
from equal_error import seconds_at
from friction_chart import SIZE, draw
from peers.ours import Kernel
from race import ROUNDS, Entries, ours_at, race_settings

from chain_impact.scene.scene import Scene
from chain_impact.simulation.simulate import simulate
from tests.friction import SLOPE, sled, thrown

TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
FINE = 1e-12  # tolerance of our own converged run
SETTLED, STOP, HOUR = 10.0, 60.0, 3600.0  # s, on the slope
SLOPE_STEPS = (1e-2, 1e-3, 1e-4)  # s
SLOPE_RK4_STEPS = (1e-2, 1e-3)  # s
AT_REST = {"contact.friction": 0.6, "initial.vx": 0.0, "initial.vy": 0.0}
IMPEDANCE = (0.95, 0.95, 0.001)  # of the contact that is as stiff at rest as ours
NOSLIP = 10  # iterations
MOVING, RESTING = 0.3, 1.5  # s, of the thrown chain
THROWN_STEPS = (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5)  # s
FINEST_ENERGY = 1e-4  # s, the least step of runs whose energy is watched
PATIENCE = 60.0  # s


# --- a rod at rest on a slope -----------------------------------------------------------------------------


def depth(state: np.ndarray) -> float:
    """How deep the first point of the rod is in the slope [m]."""
    return float(-state[0] * math.sin(SLOPE) - state[1] * math.cos(SLOPE))


def drift(early: np.ndarray, late: np.ndarray, stop: float) -> dict[str, float]:
    """The mean speed along the slope [µm/s] since the rod has settled, and the depth of penetration [m]."""
    moved = (late - early)[:2] @ (math.cos(SLOPE), -math.sin(SLOPE))
    return {
        "drift": common.rounded(1e6 * abs(moved) / (stop - SETTLED)),
        "penetration": common.rounded(depth(late)),
    }


def contacts_at_rest(deep: float) -> dict[str, Any]:
    """Names of MuJoCo's settings → the contact at a step [s].

    Args:
        deep: the penetration of ours [m], which one of them shall have.
    """
    from peers.mujoco import DEFAULTS, Contact, Engine

    def stiff(stiffness: float) -> Contact:  # 1/s², with critical damping
        return Contact((-stiffness, -2.0 * math.sqrt(stiffness)), IMPEDANCE)

    trial = Engine(sled(**AT_REST), "Euler", 1e-3, stiff(1e4))
    trial.run(SETTLED)
    # with an impedance that is constant, penetration goes with the inverse of the stiffness
    like_ours = stiff(1e4 * depth(trial.state()) / deep)

    def stiffest(dt: float) -> Contact:  # the least time constant and the largest impedance that it accepts
        return Contact((2.0 * dt, 1.0), (0.9999, 0.9999, 0.001))

    return {
        "defaults": lambda _: DEFAULTS,
        "defaults, pyramidal cones": lambda _: replace(DEFAULTS, cone="pyramidal"),
        "defaults, impratio 10": lambda _: replace(DEFAULTS, impratio=10.0),
        "defaults, impratio 100": lambda _: replace(DEFAULTS, impratio=100.0),
        "defaults, noslip": lambda _: replace(DEFAULTS, noslip=NOSLIP),
        "defaults, in the plane only": lambda _: replace(DEFAULTS, sideways=False),
        "defaults, in the plane only, noslip": lambda _: replace(DEFAULTS, sideways=False, noslip=NOSLIP),
        "stiffness of ours": lambda _: like_ours,
        "stiffness of ours, impratio 100": lambda _: replace(like_ours, impratio=100.0),
        "stiffness of ours, noslip": lambda _: replace(like_ours, noslip=NOSLIP),
        "stiffest": stiffest,
        "stiffest, impratio 100": lambda dt: replace(stiffest(dt), impratio=100.0),
    }


def ours_at_rest() -> dict:
    """Our kernel for as long as MuJoCo at some tolerances, and for an hour."""
    found = {}
    for name, stop in (("ours", STOP), ("ours, an hour", HOUR)):
        for tolerance in TOLERANCES:
            scene = sled(**AT_REST | {"solver.tolerance": tolerance})
            early, kernel = Kernel(scene, SETTLED).outcome(), Kernel(scene, stop)
            late = kernel.outcome()
            found[name, tolerance] = (
                kernel.run,
                drift(early.state, late.state, stop) | {"steps": late.steps},
            )
    return found


def mujoco_at_rest(deep: float) -> dict:
    """MuJoCo with each setting and step."""
    from peers.mujoco import Engine

    found, contacts = {}, contacts_at_rest(deep)
    cases = [("Euler", name, dt) for name in contacts for dt in SLOPE_STEPS]
    cases += [("RK4", name, dt) for name in ("defaults", "defaults, noslip") for dt in SLOPE_RK4_STEPS]
    for integrator, name, dt in cases:
        engine = Engine(sled(**AT_REST), integrator, dt, contacts[name](dt))
        engine.run(SETTLED)
        early = engine.state()
        engine.run(STOP)
        figures = drift(early, engine.state(), STOP) | {"steps": round(STOP / dt)}
        found[f"MuJoCo {integrator}, {name}", dt] = (lambda e=engine: e.run(STOP), figures)
    return found


# --- a thrown chain ---------------------------------------------------------------------------------------


def contacts_when_thrown() -> dict[str, Any]:
    """Names of MuJoCo's settings → integrator and contact: defaults, and the first impact as long as ours."""
    from peers.mujoco import DEFAULTS, bouncing, damping_ratio

    scene = thrown(**{"solver.tolerance": 1e-10})
    first, restitution = simulate(scene).impacts[0], scene.contact.restitution
    ratio = damping_ratio(restitution)
    duration = float(first["end"] - first["onset"])
    like_ours = bouncing(duration * math.sqrt(1.0 - ratio**2) / (math.pi * ratio), restitution)
    return {
        "MuJoCo Euler, defaults": ("Euler", DEFAULTS),
        "MuJoCo Euler, defaults, noslip": ("Euler", replace(DEFAULTS, noslip=NOSLIP)),
        "MuJoCo RK4, defaults": ("RK4", DEFAULTS),
        "MuJoCo Euler, duration of ours": ("Euler", like_ours),
        "MuJoCo RK4, duration of ours": ("RK4", like_ours),
    }


def ours_when_thrown(stop: float) -> tuple[Entries, np.ndarray]:
    """Our kernel at each tolerance: run and error; and the state of the converged run."""

    def scene(tolerance: float) -> Scene:
        return thrown(**{"solver.tolerance": tolerance})

    truth = Kernel(scene(FINE), stop).outcome().state
    return ours_at(TOLERANCES, scene, stop, truth), truth


def mujoco_when_thrown(stop: float, contacts: dict) -> tuple[Entries, dict[str, list[float]]]:
    """MuJoCo at each step: run and error; and the states of the converged runs."""
    from peers.mujoco import runs_at

    found, truths = {}, {}
    for name, case in contacts.items():
        runs, truth = runs_at(name, (thrown(), *case), THROWN_STEPS, stop)
        found |= runs
        truths[name] = truth.tolist()
    return found, truths


def throw(stop: float, contacts: dict, rounds: int) -> dict:
    """Errors and cost at a time [s]."""
    mine, truth = ours_when_thrown(stop)
    theirs, truths = mujoco_when_thrown(stop, contacts)
    rows = race_settings(mine | theirs, rounds, PATIENCE)
    own = [row for row in rows if row["name"] == "ours"]
    for row in rows:
        if row["name"] != "ours":
            equal = seconds_at(row["error"], own)
            row["times ours at equal error"] = equal and common.rounded(row["seconds"] / equal)
    return {"rows": rows, "converged": {"ours": truth.tolist(), **truths}}


def own_changes(tolerance: float) -> dict[str, float]:
    """Changes of the energy of our run by errors; and its balance, which has what walls and friction take."""
    result = simulate(thrown(**{"solver.tolerance": tolerance}), output_step=1e-4)
    energy = result["energy.kinetic"] + result["energy.potential"]
    total = result["energy.total"] + result["energy.dissipated"]
    flights = np.where(result["energy.elastic"] == 0.0, energy, np.nan)
    return changes(flights) | {"balance": common.rounded(np.abs(total - total[0]).max())}


def changes(energies: np.ndarray) -> dict[str, float]:
    """Of energies in flight: what is lost before the first impact, and by how much they rise later [J].

    Nothing but impacts and friction can change the energy, and these can only take some.
    """
    first = energies[: np.isnan(energies).argmax()]
    known = energies[~np.isnan(energies)]
    lost, risen = first[0] - first[-1], (known - np.minimum.accumulate(known)).max()
    return {"lost before the first impact": common.rounded(lost), "rise": common.rounded(risen)}


def balance(contacts: dict) -> list[dict]:
    """Changes of the energy by errors."""
    from peers.mujoco import Engine

    rows = [{"name": "ours", "setting": tolerance, **own_changes(tolerance)} for tolerance in TOLERANCES]
    for name, (integrator, contact) in contacts.items():
        for dt in THROWN_STEPS:
            if dt < FINEST_ENERGY:
                continue
            engine = Engine(thrown(), integrator, dt, contact)
            energies = engine.energies_in_flight(RESTING)
            if not engine.unstable:
                rows.append({"name": name, "setting": dt, **changes(energies)})
    for row in rows:
        print(row, flush=True)
    return rows


def main() -> None:
    """Measure and draw."""
    rounds = common.rounds(__doc__, ROUNDS)
    common.needed("mujoco")
    from peers.mujoco import CONVERGED

    started = common.environment(peers.PACKAGES)
    mine, contacts = ours_at_rest(), contacts_when_thrown()
    deep = mine["ours", min(TOLERANCES)][1]["penetration"]
    results = {
        "slope": race_settings(mine | mujoco_at_rest(deep), rounds, PATIENCE),
        "moving": throw(MOVING, contacts, rounds),
        "resting": throw(RESTING, contacts, rounds),
        "energy": balance(contacts),
    }
    settings = {
        "rounds": rounds, "slope [rad]": SLOPE, "friction at the slope": AT_REST["contact.friction"],
        "drift from [s]": SETTLED, "to [s]": STOP, "thrown, until [s]": [MOVING, RESTING],
        "converged step [s]": CONVERGED, "converged tolerance": FINE,
        "duration of ours": str(contacts["MuJoCo Euler, duration of ours"][1]),
        "defaults": str(contacts["MuJoCo Euler, defaults"][1]),
        "stiffness of ours": str(contacts_at_rest(deep)["stiffness of ours"](0.0)),
    }  # fmt: skip
    common.save("friction", started, settings, results)
    common.picture("friction", draw, SIZE)


if __name__ == "__main__":
    main()

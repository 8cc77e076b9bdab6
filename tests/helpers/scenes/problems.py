"""Scenes with exact answers, for tests, benchmarks and docs.

Builders return the scene; most of them also return, or say, the exact result, from closed forms or from
tests/helpers/models/reference.py, which share no code with the kernel. Units are SI throughout.

Most scenes have one link or four, because each number of links needs a compilation.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from chain_impact.kernel.forces.laws import CONTACT_LAWS
from chain_impact.scene.scene import Scene, load_scene, scene_from_dict, with_values
from tests.helpers.models.reference import PointImpact, point_impact

GRAVITY = 9.81  # m/s²
FAR = 1e3  # [m] position of a wall that is never reached
# a floor with as many walls as the default scene
FLOOR = {"x_min": -FAR, "x_max": FAR, "y_min": 0.0, "y_max": FAR}
RIGID = "newton_impact"
GHOST = 1e-12  # [N/m^(3/2)] stiffness of a wall without any effect on the motion


def scene_table(
    name: str,
    links: Sequence[Mapping[str, float]],
    initial: Mapping[str, Any],
    box: Mapping[str, float],
    contact: Mapping[str, Any],
    *,
    gravity: float = 0.0,
    stop_time: float = 1.0,
    base: str = "free",
    tolerance: float = 1e-10,
    **more: Any,
) -> dict[str, Any]:
    """Return the table of a scene, in the form of its file.

    ``contact`` and ``initial`` contain keys of these tables, ``more`` other tables.
    """
    return {
        "name": name,
        "gravity": [0.0, -gravity],
        "chain": {"base": base, "links": [dict(link) for link in links]},
        "box": dict(box),
        "contact": dict(contact),
        "initial": dict(initial),
        "solver": {"tolerance": tolerance},
        "simulation": {"stop_time": stop_time, "step_size": stop_time / 100},
    } | more


def build(
    name: str,
    links: Sequence[Mapping[str, float]],
    initial: Mapping[str, Any],
    box: Mapping[str, float],
    contact: Mapping[str, Any],
    **more: Any,
) -> Scene:
    """Return a validated scene, from the arguments of ``scene_table``."""
    return scene_from_dict(scene_table(name, links, initial, box, contact, **more), name)


def contact_table(**changes: Any) -> dict[str, Any]:
    """Return the [contact] table of these scenes: Zhang–Sharf with e = 0.7 and K = 1e8, with changes."""
    return {"model": "zhang_sharf", "stiffness": 1e8, "restitution": 0.7} | changes


def of_law(law: str, otherwise: float = 1.5) -> dict[str, Any]:
    """Return the keys of the [contact] table that choose a law, with its only exponent, or ``otherwise``."""
    return {"model": law, "exponent": CONTACT_LAWS[law].exponent or otherwise}


def ball(
    height: float = 0.0,
    speed: float = 1.0,
    *,
    mass: float = 1.0,
    gravity: float = 0.0,
    stop_time: float = 0.1,
    tolerance: float = 1e-10,
    **contact: Any,
) -> Scene:
    """Return a point mass above the floor: a link with its centre of mass at the base, which may touch."""
    link = {"length": 1.0, "mass": mass, "center_of_mass": 0.0, "inertia": 1.0}
    initial = {"position": [0.0, height], "angles": [0.0], "velocity": [0.0, -speed]}
    table = contact_table(points=[0], **contact)
    return build(
        "Ball",
        [link],
        initial,
        {"y_min": 0.0},
        table,
        gravity=gravity,
        stop_time=stop_time,
        tolerance=tolerance,
    )


def struck_ball(
    mass: float = 1.0, speed: float = 1.0, damping_factor: float = 0.0, **contact: Any
) -> tuple[Scene, PointImpact]:
    """Return a ball that flies 1 mm to the floor without gravity, and its exact impact for the law's λ."""
    scene = ball(height=1e-3, speed=speed, mass=mass, **contact)
    k, n = scene.contact.stiffness, scene.contact.exponent
    exact = point_impact(mass, speed, k, n, damping_factor)
    # enough time to arrive, to touch and to leave
    return with_values(scene, {("simulation", "stop_time"): 2e-3 / speed + 2 * exact.duration}), exact


@dataclass(frozen=True)
class Drop:
    """The arrival of a body that is dropped: onset [s], speed [m/s]."""

    onset: float
    speed: float


def dropped_ball(height: float = 1.0, stop_time: float = 0.5, **contact: Any) -> tuple[Scene, Drop]:
    """Return a ball that is dropped from rest, and its arrival: t = √(2h/g), v = √(2gh)."""
    scene = ball(height, 0.0, gravity=GRAVITY, stop_time=stop_time, **contact)
    return scene, Drop(math.sqrt(2 * height / GRAVITY), math.sqrt(2 * GRAVITY * height))


def rest_depth(scene: Scene, points: int = 1) -> float:
    """Return the penetration (m g/(k K))^(1/n) [m] of a chain that rests on k equally loaded points."""
    weight = -scene.gravity[1] * sum(link.mass for link in scene.chain.links)
    return (weight / (points * scene.contact.stiffness)) ** (1 / scene.contact.exponent)


def rod(
    tilt: float,
    lowest: float,
    speed: float = 1.0,
    spin: float = 0.0,
    *,
    gravity: float = 0.0,
    stop_time: float = 0.1,
    box: Mapping[str, float] | None = None,
    length: float = 1.0,
    **contact: Any,
) -> Scene:
    """Return a uniform rod of 1 kg above the floor, whose lower end starts at the height ``lowest`` [m].

    Args:
        tilt: angle from the floor [rad]; the base is the lower end for a tilt > 0.
        lowest: height of the lower end [m].
        speed: speed of the centre towards the floor [m/s].
        spin: angular velocity [rad/s].
        gravity: [m/s²].
        stop_time: [s].
        box: the walls, by default the floor at 0 and a wall far away on the left.
        length: [m].
        contact: keys of the [contact] table.
    """
    rise = length * math.sin(tilt)
    # v_base = v_centre − ω c⊥
    initial = {
        "position": [0.0, lowest - min(rise, 0.0)],
        "angles": [tilt],
        "velocity": [spin * rise / 2, -speed - spin * length * math.cos(tilt) / 2],
        "angular_velocities": [spin],
    }
    walls = {"x_min": -FAR, "y_min": 0.0} if box is None else box
    link = {"length": length, "mass": 1.0}
    return build(
        "Rod", [link], initial, walls, contact_table(**contact), gravity=gravity, stop_time=stop_time
    )


@dataclass(frozen=True)
class RodImpact:
    """The rigid impact of a rod's end: effective mass [kg], spin after it [rad/s], speed of the centre.

    The speed of the centre [m/s] is positive upwards, away from the floor.
    """

    effective_mass: float
    spin: float
    speed: float


def struck_rod(tilt: float, restitution: float, stiffness: float) -> tuple[Scene, RodImpact]:
    """Return a rod at an angle whose end hits the floor at 1 m/s with m_eff = m/(1 + 3cos²θ).

    The impulse p = m_eff (1+e) v at the distance (L/2)cosθ from the centre, with I = mL²/12 and m = L = 1.
    """
    scene = rod(tilt, 1e-3, restitution=restitution, stiffness=stiffness, stop_time=0.02)
    effective = 1.0 / (1.0 + 3.0 * math.cos(tilt) ** 2)
    impulse = effective * (1.0 + restitution)
    # the impulse acts on the base, to the left of the centre for cos θ > 0: it turns the rod clockwise
    return scene, RodImpact(effective, -6.0 * impulse * math.cos(tilt), impulse - 1.0)


def flat_rod(tilt: float = 0.0, **contact: Any) -> Scene:
    """Return a rod that hits the floor at 1 m/s; for ``tilt`` = 0 with both ends at once: e′ = e, no spin."""
    return rod(tilt, 1e-3, **contact)


def clattering_rod(restitution: float, stiffness: float = 1e10) -> tuple[Scene, float]:
    """Return a nearly flat rod: one end hits first, and the other end arrives at v(3+e)/2 [m/s].

    The speed follows from Newton's impact of one end, in the limit of a short contact and a small angle. The
    second end arrives so late (1 mm behind) that the first contact has ended then.
    """
    return rod(1e-3, 1e-3, restitution=restitution, stiffness=stiffness), (3.0 + restitution) / 2.0


def cornered_rod(restitution: float, stiffness: float = 1e8) -> Scene:
    """Return a rod at 45° that flies at 1 m/s along itself into a corner: it returns at e m/s without spin.

    The same point hits both walls at once; by symmetry each wall reverses its own component of the velocity,
    as for a point mass m.
    """
    s = math.sqrt(0.5)
    initial = {"position": [1e-3, 1e-3], "angles": [math.pi / 4], "velocity": [-s, -s]}
    table = contact_table(restitution=restitution, stiffness=stiffness)
    link, box = {"length": 1.0, "mass": 1.0}, {"x_min": 0.0, "y_min": 0.0}
    return build("Corner", [link], initial, box, table, stop_time=0.1)


@dataclass(frozen=True)
class Crossings:
    """Contacts with walls without effect, in order of onset: point, onset [s], end [s]."""

    point: np.ndarray
    onset: np.ndarray
    end: np.ndarray


def ghost_spinner(
    clearance: float, spin: float = 10.0, turns: int = 6, tolerance: float = 1e-10
) -> tuple[Scene, Crossings]:
    """Return a rod of 1 m that spins about its centre above a floor without effect.

    The centre stays at the height ½ + ``clearance`` [m]: the ends dip through the floor once a turn if that
    is < ½, where sin φ = −2h for the angle φ of the centre → end vector, and only there.
    """
    height = 0.5 + clearance
    scene = rod(0.0, height, 0.0, spin, stop_time=2 * math.pi * turns / spin, stiffness=GHOST)
    scene = with_values(scene, {("solver", "tolerance"): tolerance})
    if height >= 0.5:
        return scene, Crossings(np.array([], int), np.array([]), np.array([]))
    # the tip (1) starts at φ = 0 and the base (0) at φ = π; below the floor for φ in (π + a, 2π − a)
    a = math.asin(2 * height)
    first = {1: math.pi + a, 0: a}
    rows = sorted(
        ((first[point] + 2 * math.pi * turn) / spin, point) for turn in range(turns) for point in (0, 1)
    )
    onset = np.array([time for time, _ in rows])
    return scene, Crossings(np.array([point for _, point in rows]), onset, onset + (math.pi - 2 * a) / spin)


@dataclass(frozen=True)
class Swing:
    """The motion of a rod between two walls: first onset, period and duration of contacts [s]."""

    first: float
    period: float
    duration: float


def swinging_rod(
    half_width: float = 0.4, spin: float = 10.0, stiffness: float = 1e8, tolerance: float = 1e-10
) -> tuple[Scene, Swing]:
    """Return a rod of 1 m that turns about its centre in a corridor too narrow for a whole turn, elastic.

    Both ends hit at once, one the floor and one the ceiling, so the centre stays and the one coordinate φ
    obeys I φ̈ = −L cosφ K δ^{3/2} with δ = ½ sin φ − w; the rod swings between ±a, sin a = 2w, at the same
    rate in both directions. A contact lasts 2∫dφ/√(ω² − 4E(φ)/I), with E = (2/5)Kδ^{5/2} in each of the two.
    """
    box = {"y_min": -half_width, "y_max": half_width}
    scene = rod(0.0, 0.0, 0.0, spin, stop_time=1.0, box=box, model="hertz", stiffness=stiffness)
    scene = with_values(scene, {("solver", "tolerance"): tolerance})
    inertia = 1.0 / 12.0
    with mpmath.workdps(30):
        w, k = mpmath.mpf(half_width), mpmath.mpf(stiffness)

        def square(phi: Any) -> Any:  # returns φ̇²
            depth = max(mpmath.sin(phi) / 2 - w, mpmath.mpf(0))
            return spin**2 - 4 * (mpmath.mpf(2) / 5) * k * depth**2.5 / inertia

        a = mpmath.asin(2 * w)
        guess = (5 * inertia * spin**2 / (8 * k)) ** 0.4 / (mpmath.cos(a) / 2)
        turn = mpmath.findroot(square, (a + guess / 2, a + 2 * guess), solver="anderson", tol=1e-25)
        duration = 2 * mpmath.quad(lambda phi: 1 / mpmath.sqrt(abs(square(phi))), [a, (a + turn) / 2, turn])
        first = a / spin
        return scene, Swing(float(first), float(2 * first + duration), float(duration))


def tumbling_chain(stop_time: float = 10.0, tolerance: float = 1e-10) -> Scene:
    """Return four unequal links that spin fast and fall freely, with nothing to hit."""
    links = [
        {"length": 0.5, "mass": 1.0},
        {"length": 0.4, "mass": 1.5, "center_of_mass": 0.1},
        {"length": 0.3, "mass": 0.7, "inertia": 0.01},
        {"length": 0.6, "mass": 0.9, "center_of_mass": 0.4},
    ]
    initial = {
        "position": [0.3, -0.2],
        "angles": [0.3, 1.4, -2.0, 0.1],
        "velocity": [0.7, 2.0],
        "angular_velocities": [12.0, -9.0, 15.0, 8.0],
    }
    contact = contact_table(points=[])
    return build(
        "Tumbler", links, initial, {}, contact, gravity=GRAVITY, stop_time=stop_time, tolerance=tolerance
    )


def flat_chain(
    height: float, tilts: Sequence[float] = (0.0,) * 4, stop_time: float = 0.1, **contact: Any
) -> Scene:
    """Return four equal rods in a row above the floor, with five points to touch it.

    Without ``tilts`` it is symmetric about x = 1.
    """
    initial = {"position": [0.0, height], "angles": tilts}
    rods = [{"length": 0.5, "mass": 1.0}] * 4
    return build(
        "FlatChain", rods, initial, FLOOR, contact_table(**contact), gravity=GRAVITY, stop_time=stop_time
    )


def stiff_joint(
    damping: float, count: int = 2, stop_time: float = 1.0, base: str = "free", **contact: Any
) -> Scene:
    """Return links of 50 g and 0.5 m whose joints have so much damping [N·m·s/rad] that they turn as one."""
    rods = [{"length": 0.5, "mass": 0.05, "joint_damping": damping} for _ in range(count)]
    if base == "free":
        rods[0]["joint_damping"] = 0.0
    initial = {
        "position": [0.0, 0.6],
        "angles": [0.3, -0.5, 1.0][:count],
        "angular_velocities": [1.0, -3.0, 2.0][:count],
    }
    walls = {"y_min": 0.0} if base == "free" else {}
    table = contact_table(**contact) if base == "free" else {"points": []}
    return build(
        "StiffJoint",
        rods,
        initial,
        walls,
        table,
        gravity=GRAVITY,
        stop_time=stop_time,
        base=base,
        tolerance=1e-8,
    )


def heap(stop_time: float, **contact: Any) -> Scene:
    """Return a hundred short links above a floor, on which they form a heap."""
    links = [{"length": 0.1, "mass": 0.1}] * 100
    initial = {"position": [0.0, 0.5], "angles": [0.8 * math.sin(i) for i in range(100)]}
    box, table = {"x_min": -1.0, "x_max": 12.0, "y_min": 0.0}, contact_table(**contact)
    return build("Heap", links, initial, box, table, gravity=GRAVITY, stop_time=stop_time, tolerance=1e-6)


def default_scene(**changes: Any) -> Scene:
    """Return the scene of models/four_link_box with some keys of its [contact] table changed."""
    return with_values(
        load_scene("four_link_box"), {("contact", key): value for key, value in changes.items()}
    )


def driven(stop_time: float = 0.076) -> Scene:
    """Return an arm whose servos swing its tip into a wall, at 0.072 s for 2.7 ms."""
    servos = [(0.4, 2.0, 300.0, 12.0), (0.35, 1.5, 200.0, 8.0), (0.25, 0.8, 80.0, 3.0)]
    keys = ("length", "mass", "joint_stiffness", "joint_damping")
    table = {
        "name": "Driven",
        "chain": {"base": "pinned", "links": [dict(zip(keys, one, strict=True)) for one in servos]},
        "box": {"x_max": 0.5},
        "contact": {"stiffness": 1e7, "restitution": 0.5},
        "inputs": {"joint_targets": True},
        "initial": {"angles": [-0.5 * math.pi] * len(servos)},
        "outputs": {"loads": True},
        "simulation": {"stop_time": stop_time},
    }
    return scene_from_dict(table, "driven")


def rigid(scene: Scene, **contact: Any) -> Scene:
    """Return the scene with rigid walls, and with some keys of its [contact] table changed."""
    changes = {("contact", key): value for key, value in contact.items()}
    return with_values(scene, {("contact", "model"): RIGID} | changes)


def own_law() -> Callable[..., float]:
    """Return a user's law, as a function that is defined inside another function."""

    def mine(
        penetration: float, rate: float, impact_speed: float, stiffness: float, exponent: float
    ) -> float:
        """Return the force of Hunt and Crossley with λ = 0.2."""
        return stiffness * math.pow(penetration, exponent) * (1.0 + 0.2 * rate / impact_speed)

    return mine

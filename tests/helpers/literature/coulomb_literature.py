"""Problems from the literature with Coulomb friction, as scenes, with the figures of their sources.

Each builder returns the table of a scene, a second solution that shares no code with the kernel, and the
published figures, if the source has numbers. Units are SI. The books and papers were not read: their numbers
come from the sources that each docstring names, or are chosen so that a published figure follows from them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from tests.helpers.models.coulomb_impact import Departure, Strike, algebraic, stiff_limit
from tests.helpers.models.reference import exact_damping_factor
from tests.helpers.scenes.coulomb_problems import Table
from tests.helpers.scenes.problems import GRAVITY, contact_table, scene_table

FIRM = 1e9  # [N/m^(3/2)] a stiffness near the limit K → ∞


# --- Kane and Levinson's double pendulum -----------------------------------------------------------------


@dataclass(frozen=True)
class KaneLevinson:
    """The arriving point, and the energy [J] that Kane's rule adds: as published, and computed."""

    strike: Strike
    published_gain: str
    rule: Departure
    limit: Departure  # the result of force laws, which lose energy


def kane_pendulum(stiffness: float = FIRM) -> tuple[Table, KaneLevinson]:
    """Return two rods of 1 kg and 1 m, 20° and 30° from the vertical, that turn at −0.1 and −0.2 rad/s.

    Kane & Levinson 1985, *Dynamics: Theory and Applications*, after an example of Kane's of 1984. Their rule,
    Newton's hypothesis with Coulomb's law on the impulses (``algebraic``), increases the energy of .0232 J
    by .0407 J. The parameters are chosen so that these figures follow.
    """
    e, friction = 0.7, 0.5
    first, second, slow, fast = math.radians(20.0), math.radians(30.0), -0.1, -0.2
    reach = math.cos(first) + math.cos(second)
    rods = [{"length": 1.0, "mass": 1.0}] * 2
    initial = {
        "position": [0.0, reach],
        "angles": [first - math.pi / 2, second - math.pi / 2],
        "angular_velocities": [slow, fast],
    }
    contact = contact_table(stiffness=stiffness, restitution=e, points=[2], friction=friction)
    table = scene_table("KanePendulum", rods, initial, {"y_min": 0.0}, contact, base="pinned", stop_time=0.05)
    cosine = 0.5 * math.cos(first - second)
    mass = np.array([[4 / 3, cosine], [cosine, 1 / 3]])
    rows = np.array([[math.sin(first), math.sin(second)], [math.cos(first), math.cos(second)]])
    w = rows @ np.linalg.solve(mass, rows.T)
    normal, tangential = rows @ [slow, fast]
    strike = Strike(w[0, 0], w[0, 1], w[1, 1], -normal, tangential, friction)
    exact = KaneLevinson(strike, "0.0407", algebraic(strike, e), stiff_limit(strike, exact_damping_factor(e)))
    return table, exact


# --- a stick of Siconos ----------------------------------------------------------------------------------

# stored values from the first impact to the second: horizontal velocity of the centre [m/s], angular velocity
# [rad/s], and the increase of energy
SICONOS = ("-0.50373883", "1.6800228", "0.00070713554")
# the same values by Frémond's law, ImpactingStick-FremondNSL
FREMOND = ("-0.49631334", "1.6890682", "-0.00066901813")


@dataclass(frozen=True)
class SiconosStick:
    """The first impact of the stick.

    Attributes:
        onset: [s].
        strike: the arriving point.
        published: stored velocity of the centre along x [m/s], angular velocity [rad/s], and increase of
            energy [J].
        rule: the same values by the rule that the time stepping of Siconos uses, at the exact time.
        limit: the same values with force laws as K → ∞.
    """

    onset: float
    strike: Strike
    published: tuple[str, str, str]
    rule: tuple[float, float, float]
    limit: tuple[float, float, float]


def siconos_stick(stiffness: float = FIRM) -> tuple[Table, SiconosStick]:
    """Return a stick of 1 m and 1 kg that falls on one end at 45°; e = 1, µ = .01, g = 10 m/s².

    The example ImpactingStick of Siconos (Acary & Brogliato 2008, *Numerical Methods for Nonsmooth Dynamical
    Systems*), siconos-tutorials, with the values of its reference file: Moreau's time stepping of 0.1 ms. The
    slip of the end reverses in the impact, where this scheme increases the energy.
    """
    friction, weight, spin = 0.01, 10.0, 0.1
    velocity, angle = np.array([-0.5, 0.1]), math.pi / 4  # velocity of the centre; angle from the vertical
    centre = np.array([0.5 * math.sin(angle), 0.5 * math.cos(angle) + 0.01])

    def arm(time: float) -> np.ndarray:
        """Return the vector from the centre to the end."""
        return 0.5 * np.array([math.sin(angle + spin * time), -math.cos(angle + spin * time)])

    def height(time: float) -> float:
        return float(centre[1] + velocity[1] * time - 0.5 * weight * time**2 + arm(time)[1])

    onset = brentq(height, 0.0, 0.2, xtol=1e-16)
    across = arm(onset)
    before = np.array([velocity[0], velocity[1] - weight * onset, spin])
    rows = np.array([[0.0, 1.0, across[0]], [1.0, 0.0, -across[1]]])
    w = rows @ np.diag([1.0, 1.0, 12.0]) @ rows.T
    normal, tangential = rows @ before
    strike = Strike(w[0, 0], w[0, 1], w[1, 1], -normal, tangential, friction)

    def after(departure: Departure) -> tuple[float, float, float]:
        impulse = np.array([departure.normal, departure.tangential])
        moved = before + np.array([1.0, 1.0, 12.0]) * (impulse @ rows)
        return float(moved[0]), float(moved[2]), -departure.dissipated

    start = arm(0.0)
    initial = {
        "position": (centre + start).tolist(),
        "angles": [angle + math.pi / 2],
        "velocity": [velocity[0] - spin * start[1], velocity[1] + spin * start[0]],
        "angular_velocities": [spin],
    }
    contact = contact_table(
        model="hertz", stiffness=stiffness, restitution=1.0, points=[0], friction=friction
    )
    table = scene_table(
        "SiconosStick",
        [{"length": 1.0, "mass": 1.0}],
        initial,
        {"y_min": 0.0},
        contact,
        gravity=weight,
        stop_time=0.2,
    )
    rule, limit = algebraic(strike, 1.0), stiff_limit(strike, 0.0)
    return table, SiconosStick(onset, strike, SICONOS, after(rule), after(limit))


# --- Painlevé's rod, after Glocker -----------------------------------------------------------------------


@dataclass(frozen=True)
class GlockerRod:
    """The time [s] at which the sliding rod jams, published and for the rigid rod, and the rod's motion then.

    Attributes:
        published: [s].
        time: [s].
        angle: [rad], 45°.
        spin: [rad/s].
        speed: of the centre [m/s].
    """

    published: str
    time: float
    angle: float
    spin: float
    speed: float


def glocker_rod(stiffness: float = 1e7, restitution: float = 0.3) -> tuple[Table, GlockerRod]:
    """Return a rod of 2 m and 1 kg that slides on its leading end at 30 m/s, 31° from the floor; µ = 5/3.

    Glocker 1995, *Dynamik von Starrkörpersystemen mit Reibung und Stößen*, after an example of the library
    cardillo, which marks the "impact without collision" at .83 s. With rigid contact the normal force is F_n
    = m (g − s φ̇² sin φ) J/A, A = J + m s² cos φ (cos φ − µ sin φ), which no longer exists where A = 0: at
    tan φ = 1. All motions near this angle end at the point where the numerator is zero, too (Génot &
    Brogliato 1999, Eur J Mech A 18:653). g = 10 m/s².
    """
    half, friction, weight, angle = 1.0, 5 / 3, 10.0, math.radians(31.0)
    initial = {
        "position": [-half * math.cos(angle), 2 * half * math.sin(angle)],
        "angles": [-angle],
        "velocity": [30.0, 0.0],
    }
    contact = contact_table(stiffness=stiffness, restitution=restitution, friction=friction)
    table = scene_table(
        "GlockerRod",
        [{"length": 2 * half, "mass": 1.0}],
        initial,
        {"y_min": 0.0},
        contact,
        gravity=weight,
        stop_time=1.0,
    )
    return table, _rigid_slide(half, friction, weight, angle)


@cache
def _rigid_slide(half: float, friction: float, weight: float, angle: float) -> GlockerRod:
    """Return the motion of the rigid rod of 1 kg until A = 0: y = (φ, φ̇, v_x)."""
    inertia = half**2 / 3

    def lever(phi: float) -> float:
        return half * (math.cos(phi) - friction * math.sin(phi))

    def left(phi: float) -> float:
        return inertia + half * math.cos(phi) * lever(phi)

    def rate(_: float, y: np.ndarray) -> list[float]:
        normal = (weight - half * math.sin(y[0]) * y[1] ** 2) * inertia / left(y[0])
        return [y[1], -normal * lever(y[0]) / inertia, -friction * normal]

    def singular(_: float, y: np.ndarray) -> float:
        return left(y[0]) - 1e-9

    singular.terminal = True  # type: ignore[attr-defined]
    solution = solve_ivp(
        rate, (0.0, 2.0), [angle, 0.0, 30.0], method="DOP853", rtol=1e-12, atol=1e-13, events=singular
    )
    phi, spin, speed = solution.y[:, -1]
    return GlockerRod("0.83", float(solution.t[-1]), float(phi), float(spin), float(speed))


# --- Painlevé's rod, after Stewart and Trinkle -----------------------------------------------------------


@dataclass(frozen=True)
class StewartRod:
    """The time [s] at which the lower end of the falling rod hits the floor, and the arriving point."""

    onset: float
    strike: Strike


def stewart_rod(stiffness: float = 1e7, restitution: float = 0.05) -> tuple[Table, StewartRod]:
    """Return a rod of 1 kg with round ends, .5 m apart, of .002 kg·m², that falls spinning at 4 rad/s.

    The coefficient of friction is .6.

    Stewart & Trinkle 1996, Int J Numer Methods Eng 39:2673, after recreations of the example by others: the
    centre at 1 m, 30° from the horizontal, inelastic. The radius of the ends is 5 cm. With so little inertia
    Painlevé's problem occurs at an ordinary µ. The source has only curves, so there is no published figure.
    """
    length, radius, inertia, friction, spin = 0.5, 0.05, 0.002, 0.6, 4.0
    centre, start = np.array([0.0, 1.0]), math.radians(30.0)

    def lowest(time: float) -> float:
        drop = abs(math.sin(start + spin * time)) * length / 2
        return float(centre[1] - 0.5 * GRAVITY * time**2 - drop - radius)

    onset = brentq(lowest, 0.0, 0.45, xtol=1e-16)
    angle = start + spin * onset
    arm = -0.5 * length * np.array([math.cos(angle), math.sin(angle)]) * math.copysign(1.0, math.sin(angle))
    rows = np.array([[0.0, 1.0, arm[0]], [1.0, 0.0, -arm[1]]])
    w = rows @ np.diag([1.0, 1.0, 1.0 / inertia]) @ rows.T
    normal, tangential = rows @ [0.0, -GRAVITY * onset, spin]
    along = 0.5 * length * np.array([math.cos(start), math.sin(start)])
    initial = {
        "position": (centre - along).tolist(),
        "angles": [start],
        "velocity": [spin * along[1], -spin * along[0]],
        "angular_velocities": [spin],
    }
    contact = contact_table(stiffness=stiffness, restitution=restitution, radius=radius, friction=friction)
    links = [{"length": length, "mass": 1.0, "inertia": inertia}]
    table = scene_table("StewartRod", links, initial, {"y_min": 0.0}, contact, gravity=GRAVITY, stop_time=1.0)
    return table, StewartRod(onset, Strike(w[0, 0], w[0, 1], w[1, 1], -normal, tangential, friction))


# --- the rocking block -----------------------------------------------------------------------------------

RIGID = 1e6  # [N·m] dry friction that holds two links of a block together


@dataclass(frozen=True)
class RockingBlock:
    """A block that turns about one lower corner until the other corner hits the floor.

    Attributes:
        published: ω⁺/ω⁻ of Housner, e = 0.
        onset: time at which the second corner hits the floor [s].
        before: angular velocity before this impact [rad/s].
        strike: the arriving corner.
        after: angular velocity after the impact, with force laws as K → ∞ [rad/s].
    """

    published: float
    onset: float
    before: float
    strike: Strike
    after: float


def rocking_block(
    tilt: float, spin: float = 0.0, stiffness: float = FIRM, restitution: float = 0.1
) -> tuple[Table, RockingBlock]:
    """Return a block of 1 m by 1.5 m and 1 kg, as in Siconos' example RockingBlock, tilted by an angle [rad].

    Housner 1963, Bull Seismol Soc Am 53:403: the block sticks to the floor (µ = 1), and the corner on which
    it stood leaves the floor without an impulse. The angular momentum about the other corner stays constant,
    so ω⁺/ω⁻ = 1 − (3/2) sin²α, with tan α = width/height, without a rebound (e = 0). The corners are the ends
    of a chain of two links whose joint, the centre, is held by dry friction. ``spin``: at the start [rad/s],
    negative towards the floor.
    """
    half_width, half_height, friction = 0.5, 0.75, 1.0
    reach, rise = math.hypot(half_width, half_height), math.atan2(half_height, half_width)
    inertia = reach**2 / 3  # about the centre of the block
    half = {"length": reach, "mass": 0.5, "inertia": inertia / 2}
    links = [half | {"center_of_mass": reach}, half | {"center_of_mass": 0.0, "joint_friction": RIGID}]

    def speed(angle: float) -> float:
        drop = math.sin(rise + tilt) - math.sin(rise + angle)
        return math.sqrt(spin**2 + 2.0 * GRAVITY * reach * drop / (inertia + reach**2))

    # with θ = tilt (1 − u²) the integrand is regular in u, also from rest
    onset = quad(lambda u: 2.0 * tilt * u / speed(tilt * (1.0 - u * u)), 0.0, 1.0, epsabs=1e-13)[0]
    before = -speed(0.0)
    w = np.array([[0.0, 1.0, half_width], [1.0, 0.0, half_height]])
    w = w @ np.diag([1.0, 1.0, 1.0 / inertia]) @ w.T
    strike = Strike(w[0, 0], w[0, 1], w[1, 1], -2.0 * half_width * before, 0.0, friction)
    limit = stiff_limit(strike, exact_damping_factor(restitution))
    after = before + (half_width * limit.normal + half_height * limit.tangential) / inertia
    initial = {"angles": [rise + tilt, tilt - rise], "angular_velocities": [spin, spin]}
    contact = contact_table(stiffness=stiffness, restitution=restitution, points=[0, 2], friction=friction)
    table = scene_table(
        "RockingBlock", links, initial, {"y_min": 0.0}, contact, gravity=GRAVITY, stop_time=2.0 * onset
    )
    published = 1.0 - 1.5 * half_width**2 / reach**2
    return table, RockingBlock(published, onset, before, strike, after)


# --- a chain that lands ahead of free fall ---------------------------------------------------------------


@dataclass(frozen=True)
class ZigzagChain:
    """The published observation, and the first impact of a chain that is nearly level.

    Attributes:
        ahead: least and largest distance ahead of free fall in the experiment [m].
        speeds: speeds of the points 0…N after the impact of the tip, point N, over the speed of the fall.
    """

    ahead: tuple[str, str]
    speeds: np.ndarray


def zigzag_chain(count: int = 20, length: float = 0.25, tilt: float = 0.12) -> tuple[Table, ZigzagChain]:
    """Return a chain of equal rods, nearly level and tilted alternately, dropped on a rigid floor; e = µ = 0.

    Grewal, Johnson & Ruina 2011, *A chain that speeds up, rather than slows, due to collisions: How
    compression can cause tension*, Am J Phys 79:723. Where a rod lands on its lower end, its upper end is
    thrown down and pulls what is above: for a free rod with 3/2 of its speed. In their experiment, according
    to its web page, a chain of .218 kg whose lower end was .75 m above a table was 6 to 7 cm ahead of a chain
    in free fall. The number, the length and the tilt of the rods are our choice, because the page does not
    give these values.

    Their rods hang in strings, which a tension does not unfold. Those of this chain are hinged end to end:
    pulled down at one end, a rod turns and lifts its other end. With the heights y of the points the kinetic
    energy is Σ m (ẏ² + ẏ ẏ' + ẏ'²)/6 over the rods, so an impulse at the tip changes the speeds by factors of
    −(2 − √3) from point to point: the effect decays, and such a distance is not to be expected.
    """
    mass, drop = 0.218, 0.75
    rods = [{"length": length, "mass": mass / count}] * count
    # the base is the upper end; successive rods go down to opposite sides
    angles = [-tilt if k % 2 == 0 else math.pi + tilt for k in range(count)]
    top = drop + count * length * math.sin(tilt)
    initial = {"position": [0.0, top], "angles": angles}
    contact = contact_table(model="newton_impact", restitution=0.0)
    table = scene_table(
        "ZigzagChain",
        rods,
        initial,
        {"y_min": 0.0},
        contact,
        gravity=GRAVITY,
        stop_time=math.sqrt(2.0 * (top - 0.02) / GRAVITY),
    )
    matrix = np.zeros((count + 1, count + 1))
    for k in range(count):
        matrix[k : k + 2, k : k + 2] += np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    response = np.linalg.solve(matrix, np.eye(count + 1)[-1])
    return table, ZigzagChain(("0.06", "0.07"), 1.0 - response / response[-1])

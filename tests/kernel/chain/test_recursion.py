"""The recursion against two derivations that share nothing with it.

Lagrange's equations by SymPy for up to three links, and the textbook form M(q)q̈ = h assembled with
NumPy for up to a thousand.
"""

import functools

import numpy as np
import pytest
import sympy

from chain_impact.kernel.chain.kinematics import link_vectors, locate_points
from chain_impact.kernel.chain.recursion import accelerations
from chain_impact.kernel.initialize import derive_chain
from chain_impact.kernel.model.contact_force import set_damping
from chain_impact.kernel.model.contact_law import start_laws
from chain_impact.kernel.model.energy import mechanical_energy
from chain_impact.kernel.model.equations import state_rate
from chain_impact.kernel.model.geometry import place_walls
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import WALLS, scene_from_dict
from chain_impact.variables.model import Model
from tests.kernel.chains import random_links
from tests.plain import Plain
from tests.reference import exact_damping_factor, generalized_force, mass_matrix, point_jacobian, set_vectors

RESTITUTION, STIFFNESS, DEPTH = 0.5, 2e4, 1e-3
IMPACT_SPEED = 60.0  # m/s, so high that the wall pushes at any speed of the point


def random_scene(rng, size, place, has):
    (count, base), (wall, point) = size, place
    links, springs = random_links(rng, count), np.random.default_rng(count)
    for link in links:
        link["joint_damping"] *= has["joint damping"]
        if has["joint springs"]:
            stiffness, rest = springs.uniform(0.1, 20.0), springs.uniform(-3.0, 3.0)
            link |= {"joint_stiffness": stiffness, "joint_rest_angle": rest}
    box = {"box": {wall: 1e6 if wall.endswith("max") else -1e6}}
    slope = {"walls": [{"name": wall, "point": [0.0, -1e6], "angle": 0.6}]}
    table = {
        "name": "Random",
        "gravity": [2.3, -9.81] if has["gravity"] else [0.0, 0.0],
        "chain": {"base": base, "links": links},
        "contact": {"points": [point], "restitution": RESTITUTION, "stiffness": STIFFNESS},
        "inputs": {"joint_torques": True, "tip_force": True},
        "initial": {"angles": [0.0] * count},
    }
    return scene_from_dict(table | (slope if wall == "slope" else box), "random")


def instance(scene):
    d = Plain(Model(scene).new_instance()[0])
    derive_chain(d)
    assert start_laws(d) == OK
    return d


@functools.cache
def lagrange(count):
    """Functions M(q…) and h(q…) of Lagrange's equations M q̈ = h, from T, V, Rayleigh's D and virtual work."""
    n = count
    q = sympy.symbols(f"x y theta0:{n}")
    qd = sympy.symbols(f"vx vy omega0:{n}")
    m, length, centre, inertia, damping, stiffness, rest, torque = (
        sympy.symbols(f"{name}0:{n}") for name in ("m", "l", "c", "I", "d", "k", "phi", "u")
    )
    gx, gy, pinned = sympy.symbols("gx gy pinned")
    load = sympy.symbols(f"f0:{2 * (n + 1)}")
    time_derivative = lambda e: sum(e.diff(a) * b for a, b in zip(q, qd, strict=True))  # noqa: E731

    joint = sympy.Matrix(q[:2])
    kinetic = potential = rayleigh = work = 0
    for i in range(n):
        work += load[2 * i] * joint[0] + load[2 * i + 1] * joint[1]
        along = sympy.Matrix([sympy.cos(q[2 + i]), sympy.sin(q[2 + i])])
        mass_centre = joint + centre[i] * along
        velocity = mass_centre.applyfunc(time_derivative)
        kinetic += m[i] * velocity.dot(velocity) / 2 + inertia[i] * qd[2 + i] ** 2 / 2
        potential -= m[i] * (gx * mass_centre[0] + gy * mass_centre[1])
        # joint i turns link i against link i − 1, the first one against the ground, if there is a joint
        held = pinned if i == 0 else 1
        before = (0, 0) if i == 0 else (q[1 + i], qd[1 + i])
        potential += held * stiffness[i] * (q[2 + i] - before[0] - rest[i]) ** 2 / 2
        rayleigh += held * damping[i] * (qd[2 + i] - before[1]) ** 2 / 2
        work += held * torque[i] * (q[2 + i] - before[0])
        joint = joint + length[i] * along
    work += load[2 * n] * joint[0] + load[2 * n + 1] * joint[1]

    lagrangian = kinetic - potential
    momenta = [lagrangian.diff(rate) for rate in qd]
    matrix = sympy.Matrix([[momentum.diff(rate) for rate in qd] for momentum in momenta])
    right = sympy.Matrix(
        [
            lagrangian.diff(a) + work.diff(a) - rayleigh.diff(b) - time_derivative(momentum)
            for a, b, momentum in zip(q, qd, momenta, strict=True)
        ]
    )
    arguments = [q, qd, m, length, centre, inertia, damping, stiffness, rest, torque, (gx, gy), pinned, load]
    return sympy.lambdify(arguments, matrix, cse=True), sympy.lambdify(arguments, right, cse=True)


def lagrange_accelerations(scene, angles, velocities, torques, loads):
    """q̈ = M⁻¹h, with ẍ₀ = ÿ₀ = 0 for a pinned base."""
    links = scene.chain.links
    pinned = scene.chain.base == "pinned"
    names = ("mass", "length", "center_of_mass", "inertia")
    names += ("joint_damping", "joint_stiffness", "joint_rest_angle")
    columns = [[getattr(link, name) for link in links] for name in names]
    arguments = [(0.0, 0.0, *angles), velocities, *columns, torques, scene.gravity, pinned, loads.ravel()]
    matrix, right = (np.array(f(*arguments), float) for f in lagrange(len(links)))
    free = slice(2, None) if pinned else slice(None)
    result = np.zeros(len(links) + 2)
    result[free] = np.linalg.solve(matrix[free, free], right[free, 0])
    return result


JOINTS = "joint torques", "joint damping", "joint springs"
EFFECTS = "inertia", "gravity", *JOINTS, "tip force", "contact", "all"


@pytest.mark.full("more cases", but=45)
@pytest.mark.parametrize("effect", EFFECTS)
@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_accelerations_are_lagranges(count, base, effect):
    rng = np.random.default_rng(17 * count + len(base) + EFFECTS.index(effect))
    has = {one: effect in (one, "all") for one in EFFECTS}
    check_against_lagrange(rng, (count, base), ("y_min", int(rng.integers(1, count + 1))), has)


@pytest.mark.parametrize("wall", [*WALLS, "slope"])
def test_every_wall_pushes_inwards(wall):
    check_against_lagrange(np.random.default_rng(5), (2, "free"), (wall, 1), dict.fromkeys(EFFECTS, True))


def check_against_lagrange(rng, size, place, has):
    """Compare ẏ with Lagrange's accelerations, and the powers with force times speed."""
    (n, base), (wall, point), scene = size, place, random_scene(rng, size, place, has)
    d = instance(scene)
    y = np.zeros_like(d["work"]["y"])
    rate = np.full_like(y, np.nan)
    pinned = base == "pinned"
    angles = y[2 : n + 2] = rng.uniform(-np.pi, np.pi, n)
    omega = y[n + 4 : 2 * n + 4] = rng.uniform(-5.0, 5.0, n)
    if not pinned:
        y[:2], y[n + 2 : n + 4] = rng.uniform(-1.0, 1.0, 2), rng.uniform(-1.0, 1.0, 2)
    velocities = y[n + 2 : 2 * n + 4]

    torques, loads = np.zeros(n), np.zeros((n + 1, 2))
    if has["joint torques"]:
        torques = d["inputs"]["joint_torque"][:] = rng.uniform(-5.0, 5.0, n)
    if has["tip force"]:
        loads[n] = d["inputs"]["tip_force"][:] = rng.uniform(-5.0, 5.0, 2)
    supplied = loads[n] @ point_jacobian(scene, angles, n) @ velocities
    joints = np.diff(omega, prepend=0.0)
    if not pinned:
        joints[0] = 0.0  # there is no joint
    supplied += torques @ joints
    dissipated = sum(link.joint_damping * w**2 for link, w in zip(scene.chain.links, joints, strict=True))

    if has["contact"]:
        # put the wall where the point is 1 mm deep
        reached = zip(scene.chain.links[:point], angles[:point], strict=True)
        place = y[:2] + sum(link.length * np.array([np.cos(a), np.sin(a)]) for link, a in reached)
        inward = np.array(scene.half_planes[wall].normal)
        on_wall = place + DEPTH * inward
        if wall in WALLS:
            d["model"]["wall"][WALLS.index(wall)] = on_wall[WALLS.index(wall) // 2]
        else:
            d["walls"]["x"][0], d["walls"]["y"][0] = on_wall
        d["touch"]["active"][0] = 1
        d["touch"]["active_count"] = d["touch"]["compliant_count"] = 1
        d["touch"]["impact_speed"][0] = IMPACT_SPEED
        place_walls(d)
        set_damping(d, 0)
        speed = -inward @ point_jacobian(scene, angles, point) @ velocities
        elastic = STIFFNESS * DEPTH**1.5
        ratio = max(0.0, 1 + exact_damping_factor(RESTITUTION) * speed / max(IMPACT_SPEED, speed))
        loads[point] += inward * elastic * ratio
        dissipated += elastic * (ratio - 1) * speed

    state_rate(d, y, rate)

    expected = lagrange_accelerations(scene, angles, velocities, torques, loads)
    np.testing.assert_array_equal(rate[: n + 2], velocities)
    np.testing.assert_allclose(
        rate[n + 2 : 2 * n + 4], expected, rtol=0.0, atol=1e-11 * np.abs(expected).max()
    )
    assert rate[2 * n + 4] == pytest.approx(dissipated, rel=1e-11, abs=1e-12)
    assert rate[2 * n + 5] == pytest.approx(supplied, rel=1e-11, abs=1e-12)


def long_chain(count):
    """A random chain without contacts in a random state, with loads on all points and links."""
    rng = np.random.default_rng(2)
    chain = {"base": "free", "links": random_links(rng, count)}
    table = {"name": "Long", "gravity": [2.3, -9.81], "chain": chain, "contact": {"points": []}}
    scene = scene_from_dict(table | {"initial": {"angles": [0.0] * count}}, "long")
    angles, omega = rng.uniform(-np.pi, np.pi, count), rng.uniform(-5.0, 5.0, count)
    loads, moments = rng.uniform(-20.0, 20.0, (count + 1, 2)), rng.uniform(-5.0, 5.0, count)
    return scene, angles, omega, loads, moments


def recursive_accelerations(scene, angles, omega, loads, moments):
    d = instance(scene)
    work = d["work"]
    set_vectors(work["load"], loads)
    work["moment"] = moments
    y = np.array([0.0, 0.0, *angles, 0.0, 0.0, *omega])
    link_vectors(d, y)
    rate = np.full(len(y), np.nan)
    accelerations(d, y, rate)
    return rate[len(angles) + 2 :]


def test_a_thousand_links_solve_the_assembled_equations():
    """The residual must be round-off: of the size of ε |M| |q̈|, whatever the conditioning of M.

    The solution itself can only agree to ε cond(M), for either method.
    """
    problem = long_chain(1000)
    matrix, right = mass_matrix(problem[0], problem[1]), generalized_force(*problem)
    found = recursive_accelerations(*problem)
    epsilon = np.finfo(float).eps
    scale = np.abs(matrix) @ np.abs(found) + np.abs(right)
    assert np.abs((matrix @ found - right) / scale).max() < 100.0 * epsilon
    expected = np.linalg.solve(matrix, right)
    least, *_, largest = np.linalg.eigvalsh(matrix)
    allowed = 10.0 * epsilon * largest / least
    assert 0.0 < allowed < 1e-6  # else the comparison says nothing
    assert np.abs(found - expected).max() < allowed * np.abs(expected).max()


def test_energy_is_that_of_the_assembled_mass_matrix():
    """T = ½ q̇ᵀ M q̇, and V changes by −M g·Δ when the base moves by Δ."""
    scene, angles, omega, *_ = long_chain(5)
    d = instance(scene)
    y = np.concatenate([[0.3, -0.4], angles, [1.1, 0.7], omega, [0.0, 0.0]])
    locate_points(d, y)
    kinetic, potential = mechanical_energy(d, y)
    velocities = y[7:14]
    assert kinetic == pytest.approx(velocities @ mass_matrix(scene, angles) @ velocities / 2, rel=1e-13)
    y[:2] += (2.0, 5.0)
    locate_points(d, y)
    rise = mechanical_energy(d, y)[1] - potential
    weight = sum(link.mass for link in scene.chain.links) * np.array(scene.gravity)
    assert rise == pytest.approx(-weight @ (2.0, 5.0), rel=1e-12)

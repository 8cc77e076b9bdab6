"""Centres of mass off a link's line, points on links, and a base on a slider, against Lagrange's equations.

The reference builds M(q) and the forces from the Jacobians of single points, and solves with a dense matrix.
It shares no code with the recursion.
"""

# Tests: kernel/chain/sites.py, kernel/chain/slider.py, kernel/chain/mass_matrix_solver.py

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.chain.mass_matrix_solver import HELD, clear_impedance, factorize_matrix
from chain_impact.kernel.constraints.constraint_response import solve_in_space
from chain_impact.kernel.constraints.geometry import add_joint_impedances, clear_used_forces
from chain_impact.kernel.equations import mechanical_energy, rate_from_state
from chain_impact.kernel.forces.active_contacts import begin_force_law_contact, list_active_contacts
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.kernel.plain import initialized

GRAVITY = np.array([1.0, -9.81])
ORIGIN = np.array([0.1, 0.2])
BASES = ("free", "pinned", "slider")


class Reference:
    """The chain at a state (q, v) with q = (x, y, θ₁ …), as dense matrices.

    Attributes:
        mass: M, shape (N+2, N+2).
        motions: T, whose columns are the motions that the base allows.
    """

    def __init__(self, chain, q, v):
        self.links, self.chain, self.q, self.v = chain["links"], chain, q, v
        count = len(q)
        self.mass, self.force = np.zeros((count, count)), np.zeros(count)
        for i, link in enumerate(self.links):
            _, jacobian, bias = self.point(i, link["center_of_mass"], link["center_of_mass_offset"])
            self.mass += link["mass"] * jacobian.T @ jacobian
            self.mass[2 + i, 2 + i] += link["inertia"]
            self.force += jacobian.T @ (link["mass"] * (GRAVITY - bias))
            if i > 0 or chain["base"] != "free":
                relative = np.zeros(count)
                relative[2 + i] = 1.0
                relative[1 + i] -= i > 0
                self.mass += link["joint_armature"] * np.outer(relative, relative)
        first = {"free": np.eye(2), "pinned": np.zeros((2, 0))}.get(chain["base"])
        if first is None:
            slider = chain["slider"]
            along = np.array([math.cos(slider["angle"]), math.sin(slider["angle"])])
            first = along[:, None]
            self.mass[:2, :2] += slider["mass"] * np.eye(2)
            stretch = along @ (q[:2] - ORIGIN) - slider["rest_position"]
            push = -slider["damping"] * (along @ v[:2]) - slider["stiffness"] * stretch
            self.force[:2] += slider["mass"] * GRAVITY + push * along
        self.motions = np.zeros((count, first.shape[1] + len(self.links)))
        self.motions[:2, : first.shape[1]] = first
        self.motions[2:, first.shape[1] :] = np.eye(len(self.links))

    def point(self, i, x, y):
        """Return position, Jacobian and velocity-dependent acceleration of a point of link i."""
        jacobian, bias, position = np.zeros((2, len(self.q))), np.zeros(2), self.q[:2].copy()
        jacobian[0, 0] = jacobian[1, 1] = 1.0
        for j in range(i + 1):
            along, beside = (self.links[j]["length"], 0.0) if j < i else (x, y)
            c, s = math.cos(self.q[2 + j]), math.sin(self.q[2 + j])
            arm = np.array([along * c - beside * s, along * s + beside * c])
            position += arm
            jacobian[:, 2 + j] += [-arm[1], arm[0]]
            bias -= self.v[2 + j] ** 2 * arm
        return position, jacobian, bias

    def solved(self, mass, force):
        """Return the motion that the base allows, for a mass matrix and a force."""
        t = self.motions
        return t @ np.linalg.solve(t.T @ mass @ t, t.T @ force)


def random_chain(rng, base, geared):
    links = [
        {
            "length": (length := rng.uniform(0.2, 1.0)),
            "mass": rng.uniform(0.2, 2.0),
            "center_of_mass": rng.uniform(0.0, length),
            "center_of_mass_offset": 0.1 * rng.normal(),
            "inertia": rng.uniform(0.01, 0.1),
            "joint_armature": rng.uniform(0.0, 0.2) if geared else 0.0,
            "points": [
                {"x": 0.3 * rng.normal(), "y": 0.2 * rng.normal(), "radius": 0.01}
                for _ in range(rng.integers(0, 4))
            ],
        }
        for _ in range(rng.integers(1, 6))
    ]
    slider = {
        "angle": rng.normal(),
        "mass": rng.uniform(0.1, 2.0),
        "damping": rng.uniform(0.0, 2.0),
        "stiffness": rng.uniform(0.0, 20.0),
        "rest_position": rng.normal(),
    }
    return {"base": base, "links": links, **({"slider": slider} if base == "slider" else {})}


@pytest.fixture(
    params=[(base, geared, seed) for base in BASES for geared in (0, 1) for seed in range(4)], ids=str
)
def moving(request):
    """Return a random chain in a random state: the instance, its state, and the reference."""
    base, geared, seed = request.param
    rng = np.random.default_rng([seed, geared, BASES.index(base)])
    chain = random_chain(rng, base, geared)
    n = len(chain["links"])
    data = {
        "name": "Random",
        "gravity": [*GRAVITY],
        "chain": chain,
        "box": {"y_min": -50.0},
        "contact": {"points": [], "model": "hertz", "exponent": 1.0, "stiffness": 1e5},
        "initial": {
            "position": [*ORIGIN],
            "angles": [*rng.normal(size=n)],
            "angular_velocities": [*3.0 * rng.normal(size=n)],
        },
    }
    d = initialized(scene_from_dict(data, "random"))
    y = d.step.state_end.copy()
    if base == "free":
        y[n + 2 : n + 4] = rng.normal(size=2)
    if base == "slider":
        along = np.array([d.slider.ux, d.slider.uy])
        y[:2] += rng.normal() * along
        y[n + 2 : n + 4] = rng.normal() * along
    return d, y, Reference(chain, y[: n + 2], y[n + 2 : 2 * n + 4]), rng


def sites_of(reference):
    return [(i, site["x"], site["y"]) for i, link in enumerate(reference.links) for site in link["points"]]


def test_accelerations_by_forces_at_sites_agree_with_lagrange(moving):
    d, y, reference, _ = moving
    n, force = d.link_count, reference.force.copy()
    d.candidate.offset[:] = 0.3  # the floor is above some points
    locate_points(d, y)
    for c in range(d.candidate_count):
        begin_force_law_contact(d, c)
    list_active_contacts(d)
    rate = np.zeros_like(y)
    rate_from_state(d, y, rate)
    sites = sites_of(reference)
    for c in range(d.candidate_count):
        _, jacobian, _ = reference.point(*sites[d.candidate.point[c] - n - 1])
        force += jacobian.T @ [0.0, d.contacts.force[c]]
    solution = reference.solved(reference.mass, force)
    np.testing.assert_allclose(
        rate[n + 2 : 2 * n + 4], solution, rtol=1e-10, atol=1e-10 * np.abs(solution).max()
    )
    accelerate_points(d, y, rate)
    for s, site in enumerate(sites):
        position, jacobian, bias = reference.point(*site)
        for vectors, value in (
            (d.scratch.position, position),
            (d.scratch.velocity, jacobian @ reference.v),
            (d.scratch.acceleration, jacobian @ solution + bias),
        ):
            result = vectors.x[2 * n + 1 + s], vectors.y[2 * n + 1 + s]
            np.testing.assert_allclose(result, value, rtol=0.0, atol=1e-10 * max(1.0, np.abs(solution).max()))


def test_the_kinetic_energy_is_that_of_the_mass_matrix(moving):
    d, y, reference, _ = moving
    locate_points(d, y)
    kinetic, _ = mechanical_energy(d, y)
    assert kinetic == pytest.approx(0.5 * reference.v @ reference.mass @ reference.v, rel=1e-12)


def test_impedances_at_points_of_links_act_as_springs_there(moving):
    d, y, reference, rng = moving
    n, mass, force = d.link_count, reference.mass.copy(), np.zeros(d.link_count + 2)
    locate_points(d, y)
    clear_impedance(d, d.scratch.impedance)
    clear_used_forces(d, d.scratch.applied_force)
    for s, site in enumerate(sites_of(reference)):
        place, (_, jacobian, _) = 2 * n + 1 + s, reference.point(*site)
        amount, angle, load = rng.uniform(0.0, 10.0), rng.uniform(0.0, math.pi), rng.normal(size=2)
        normal = np.array([math.cos(angle), math.sin(angle)])
        d.scratch.impedance.xx[place] = amount * normal[0] ** 2
        d.scratch.impedance.xy[place] = amount * normal[0] * normal[1]
        d.scratch.impedance.yy[place] = amount * normal[1] ** 2
        d.scratch.applied_force.x[place], d.scratch.applied_force.y[place] = load
        mass += amount * np.outer(normal @ jacobian, normal @ jacobian)
        force += jacobian.T @ load
    add_joint_impedances(d, d.scratch.impedance)
    factorize_matrix(d, d.scratch.link_vector, d.scratch, HELD, True)
    d.scratch.applied_force.joint[:] = 0.0
    change = np.zeros(n + 2)
    solve_in_space(d, d.scratch.link_vector, d.scratch, HELD, change)
    solution = reference.solved(mass, force)
    np.testing.assert_allclose(change, solution, rtol=1e-9, atol=1e-10 * max(1e-3, np.abs(solution).max()))

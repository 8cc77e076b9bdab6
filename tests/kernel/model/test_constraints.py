"""Impulses at rigid walls, against dense matrices and every possible set of contacts."""

import math

import numpy as np
import pytest

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.model.constraints import factorize_free, solve_equality, solve_lcp
from chain_impact.kernel.model.geometry import clearance
from chain_impact.kernel.model.holding import project_state
from chain_impact.scene.scene import WALLS, with_values
from chain_impact.variables.model import Model
from tests.plain import Plain
from tests.problems import default_scene
from tests.reference import clearance_gradient, complementary_impulses, mass_matrix
from tests.turned import turned

POINTS, FAR = 5, 10.0


def located(angles, touching, turn=0.0):
    """The default chain at some angles, located, as if it touched there: the walls are far.

    It is turned as a whole by an angle ``turn`` [rad].

    Returns:
        Its record, W = J M⁻¹ Jᵀ and M⁻¹ Jᵀ.
    """
    far = {("box", name): -FAR if name.endswith("min") else FAR for name in WALLS}
    start = {("initial", "angles"): angles, ("initial", "position"): (0.0, 0.0)}
    scene = turned(with_values(default_scene(model="newton_impact"), start | far), turn)
    d, angles, names = (
        Plain(Model(scene).new_instance()[0]),
        scene.initial.angles,
        dict(zip(WALLS, scene.half_planes, strict=True)),
    )
    start_touching(d, touching)
    gradient = np.array([clearance_gradient(scene, angles, point, names[wall]) for point, wall in touching])
    response = np.linalg.solve(mass_matrix(scene, angles), gradient.T)
    return d, gradient @ response, response


def start_touching(d, touching):
    """Initialize, and let these (points, walls) touch."""
    assert initialize(d, 0.0) == 0
    for k, (point, wall) in enumerate(touching):
        d["touch"]["active_index"][k] = 4 * point + WALLS.index(wall)
        d["touch"]["active"][4 * point + WALLS.index(wall)] = 1
    d["touch"]["active_count"] = len(touching)


def set_problem(d, start, aim, pressed):
    own = d["rigid"]
    for name, values in (("start", start), ("target", aim), ("in_active_set", pressed)):
        own[name][: len(start)] = values
    return own


ON_FLOOR = [(point, "y_min") for point in range(POINTS)]


@pytest.mark.parametrize("base", ["free", "pinned"])
@pytest.mark.parametrize("pressed", [[1, 1, 1, 1], [0, 1, 0, 1]])
def test_pressed_points_reach_their_aims(base, pressed):
    touching = ON_FLOOR[1:]
    # a point of a pinned chain does not need the base's two coordinates
    d, w, response = located([0.3, -0.4, 0.9, -0.1], touching)
    if base == "pinned":
        d["model"]["pinned"] = 1
        start_touching(d, touching)
    start, aim = np.array([-1.0, 0.3, 0.1, -2.0]), np.array([0.5, 0.0, 0.0, 0.7])
    own = set_problem(d, start, aim, pressed)
    factorize_free(d)
    solve_equality(d, 1.0)
    rows = np.flatnonzero(pressed)
    np.testing.assert_allclose(own["reached"][rows], aim[rows], atol=1e-14)
    assert (own["impulse"][:4][np.array(pressed) == 0] == 0.0).all()
    if base == "free":
        p = np.zeros(4)
        p[rows] = np.linalg.solve(w[np.ix_(rows, rows)], (aim - start)[rows])
        np.testing.assert_allclose(own["impulse"][:4], p, rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(own["change"], response @ p, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize("ratio", [1e-6, 1.0, 1e6])
def test_masses_that_differ_by_a_million_are_no_hindrance(ratio):
    d, _, _ = located([0.1, -0.2, 0.1, 0.2], ON_FLOOR)
    masses = np.array([1.0, ratio, 1.0, 1.0])
    d["model"]["mass"], d["model"]["inertia"] = masses, masses * 0.25 / 12
    start_touching(d, ON_FLOOR)
    own = set_problem(d, -np.ones(5), np.full(5, 0.5), np.ones(5))
    factorize_free(d)
    solve_equality(d, 1.0)
    np.testing.assert_allclose(own["reached"][:5], 0.5, atol=1e-10)


@pytest.mark.full("more cases", but=28)
@pytest.mark.parametrize("seed", range(40))
def test_impulses_are_complementary(seed):
    """Against all 2^k sets of contacts; the points are anywhere, as if the walls passed through them.

    For every other seed all is turned.
    """
    random = np.random.default_rng(seed)
    angles = random.uniform(-math.pi, math.pi, 4)
    places = [(point, wall) for point in range(POINTS) for wall in ("y_min", "x_max")]
    touching = [places[i] for i in sorted(random.choice(len(places), random.integers(1, 6), replace=False))]
    d, w, response = located(angles.tolist(), touching, turn=0.4 * (seed % 2))
    start = random.normal(size=len(touching))
    aim = random.choice([0.0, 0.5], len(touching)) * np.abs(start)
    expected = complementary_impulses(w, start, aim)
    own = set_problem(d, start, aim, random.integers(0, 2, len(touching)))
    factorize_free(d)
    solve_lcp(d, np.abs(start).max())
    scale = np.linalg.cond(w) * max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(own["impulse"][: len(touching)], expected, atol=1e-14 * scale)
    np.testing.assert_allclose(own["change"], response @ expected, atol=1e-13 * scale)


def test_a_link_jammed_between_two_walls_has_a_solution_of_many():
    """Both ends of a level link at vertical walls: W is singular, the motion unique, the squeeze is not."""
    d, w, _ = located([0.0] * 4, [(0, "x_min"), (4, "x_max")])
    assert np.linalg.matrix_rank(w) == 1
    own = set_problem(d, np.array([-1.0, 1.0]), np.zeros(2), np.ones(2))
    factorize_free(d)
    solve_lcp(d, 1.0)
    np.testing.assert_allclose(own["reached"][:2], 0.0, atol=1e-14)
    assert (own["impulse"][:2] >= 0.0).all()


def test_a_state_is_moved_onto_the_walls():
    d, _, _ = located([0.0, 1e-6, -2e-6, 1e-6], ON_FLOOR[:3])
    y = d["step"]["state_end"].copy()
    y[1] = 1e-6 - FAR
    y[6:12] *= 1e-9  # errors, not a motion
    locate_points(d, y)
    project_state(d, y)
    for c in d["touch"]["active_index"][:3]:
        gap, gap_rate = clearance(d, c)
        assert abs(gap) < 1e-15
        assert abs(gap_rate) < 1e-14

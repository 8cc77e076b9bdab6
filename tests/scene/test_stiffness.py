"""Stiffness from material and shape."""

import math

import pytest

from chain_impact import SceneWarning, simulate, sphere_plane_stiffness
from tests.helpers.scenes.problems import struck_ball

STEEL = 207e9, 0.3
RADIUS = 0.02


@pytest.mark.parametrize(
    ("young", "poisson", "expected"),
    [
        (207e9, 0.3, 2.145e10),  # steel
        (70e9, 0.33, 7.4e9),  # aluminium
        (3.0e9, 0.38, 3.3e8),  # PMMA
        (5e6, 0.49, 6.2e5),  # rubber
    ],
)
def test_a_sphere_on_a_plane_of_its_own_material(young, poisson, expected):
    result = sphere_plane_stiffness(RADIUS, young, poisson, young, poisson)
    assert result == pytest.approx(expected, rel=0.01)


def test_a_rigid_plane_doubles_the_stiffness_and_the_order_does_not_matter():
    of_equal_materials = sphere_plane_stiffness(RADIUS, *STEEL, *STEEL)
    assert sphere_plane_stiffness(RADIUS, *STEEL, 1e30, 0.3) == pytest.approx(
        2 * of_equal_materials, rel=1e-12
    )
    pair = sphere_plane_stiffness(RADIUS, *STEEL, 3e9, 0.4)
    assert sphere_plane_stiffness(RADIUS, 3e9, 0.4, *STEEL) == pytest.approx(pair, rel=1e-14)
    assert sphere_plane_stiffness(4 * RADIUS, 3e9, 0.4, *STEEL) == pytest.approx(2 * pair, rel=1e-14)


def test_a_steel_ball_touches_as_long_as_in_the_textbook():
    """20 mm at 1 m/s on steel: T = 2.87 [m²/(R E*² v)]^(1/5), after Johnson 1985, Contact mechanics."""
    stiffness = sphere_plane_stiffness(RADIUS, *STEEL, *STEEL)
    mass = 7850 * 4 / 3 * math.pi * RADIUS**3
    scene, _ = struck_ball(mass, 1.0, model="hertz", stiffness=stiffness)
    (impact,) = simulate(scene).impacts
    combined = STEEL[0] / (2 * (1 - STEEL[1] ** 2))
    duration = 2.87 * (mass**2 / (RADIUS * combined**2)) ** 0.2
    assert impact["end"] - impact["onset"] == pytest.approx(duration, rel=2e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": 0.0}, r"radius = 0\.0 must be a finite number > 0"),
        ({"radius": math.inf}, "radius = inf"),
        ({"young_1": -1.0}, r"young_1 = -1\.0"),
        ({"young_2": math.nan}, "young_2 = nan"),
        ({"poisson_1": 0.6}, r"poisson_1 = 0\.6 must be > -1 and <= 0\.5"),
        ({"poisson_2": -1.0}, r"poisson_2 = -1\.0"),
    ],
)
def test_values_that_are_no_material_are_refused(changes, message):
    values = {"radius": RADIUS, "young_1": 1e9, "poisson_1": 0.3, "young_2": 1e9, "poisson_2": 0.3}
    with pytest.raises(ValueError, match=message):
        sphere_plane_stiffness(**values | changes)


def test_a_modulus_in_gigapascals_is_asked_about():
    with pytest.warns(
        SceneWarning, match=r"^young_1 = 207 Pa is softer than a gel: is it in GPa\?$"
    ) as caught:
        sphere_plane_stiffness(RADIUS, 207, 0.3, 207e9, 0.3)
    assert caught[0].filename == __file__
    with pytest.warns(SceneWarning, match=r"^radius = 20 m: is it in mm\?$"):
        sphere_plane_stiffness(20, 207e9, 0.3, 207e9, 0.3)

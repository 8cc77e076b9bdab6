"""Armatures of drives: their inertia in motions, impacts, loads and derivatives."""

import math

import numpy as np
import pytest

from chain_impact import Chain, SceneError, simulate
from chain_impact.scene.scene import with_values
from tests.helpers.models.driven_chain import DrivenChain
from tests.helpers.models.reference import balance
from tests.helpers.scenes.joint_drives import INERTIA, ROD, TOLERANCE, chain_with_drives, random_chain
from tests.helpers.scenes.problems import build
from tests.helpers.tools.differences import slope


@pytest.mark.parametrize("armature", [1e-3, 0.7, 50.0])
def test_an_armature_adds_to_the_inertia_about_the_pin(armature):
    link = ROD | {"joint_stiffness": 12.0, "joint_armature": armature}
    result = simulate(chain_with_drives([link], {"angles": [0.7], "angular_velocities": [1.5]}))
    pace = math.sqrt(12.0 / (INERTIA + armature))
    exact = 0.7 * np.cos(pace * result.time) + 1.5 / pace * np.sin(pace * result.time)
    np.testing.assert_allclose(result.angles[:, 0], exact, rtol=0, atol=1e-10)
    assert balance(result) < 1e-10
    kinetic = 0.5 * (INERTIA + armature) * result.angular_velocities[:, 0] ** 2
    np.testing.assert_allclose(result.energy["kinetic"], kinetic, rtol=1e-13)


@pytest.mark.full("more cases", but=2)
@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_a_chain_with_armatures_moves_as_the_textbook_says(count, base):
    scene = random_chain(count, base)
    book, chain = DrivenChain(scene), Chain(scene)
    alpha = [chain.get(f"link[{i}].angular_acceleration") for i in range(1, count + 1)]
    np.testing.assert_allclose(alpha, book.rate(book.start)[count + 4 :], rtol=1e-12, atol=1e-12)
    result, exact = simulate(scene), book.reached(1.0)
    end = result.outputs[-1]
    state = [*end["point_position"][0], *end["angle"], *end["point_velocity"][0], *end["angular_velocity"]]
    np.testing.assert_allclose(state, exact[:-1], rtol=0, atol=1e-10)
    assert balance(result) < 1e-10


@pytest.mark.parametrize("base", ["free", "pinned"])
def test_the_implicit_method_has_the_armatures_in_its_mass_matrix(base):
    """Without the armatures its iteration would converge slowly: they exceed the inertias of the links."""
    scene = with_values(random_chain(3, base), {f"link[{i}].joint_armature": 5.0 for i in (1, 2, 3)})
    scene = with_values(scene, {f"link[{i}].joint_stiffness": 1e7 for i in (1, 2, 3)})
    scene = with_values(scene, {f"link[{i}].joint_damping": 1e4 for i in (1, 2, 3)})
    implicit, explicit = (
        simulate(scene, method=method, tolerance=1e-8, stop_time=0.02) for method in ("implicit", "explicit")
    )
    assert np.abs(implicit.angles - explicit.angles).max() < 1e-7
    assert implicit.statistics["rhs_evaluations"] < 20 * implicit.statistics["implicit_steps"]


def test_a_rigid_wall_meets_the_mass_of_links_and_armatures():
    """M Δ = Jᵀ p with p = (1 + e) u/(J M⁻¹ Jᵀ), Newton's impact of the tip with the textbook's matrices."""
    links = [ROD | {"joint_armature": 0.4}, ROD | {"joint_armature": 2.0}]
    initial = {"angles": [0.3, -1.0], "angular_velocities": [-1.0, -2.0]}
    contact = {"model": "newton_impact", "restitution": 0.6, "points": [2]}
    height = 0.8 * (math.sin(0.3) + math.sin(-1.0)) - 1e-3
    scene = build("Rigid", links, initial, {"y_min": height}, contact, base="pinned", tolerance=TOLERANCE)
    impact = simulate(scene, stop_time=0.1).impacts[0]
    run = simulate(scene, stop_time=impact["onset"], output_step=impact["onset"])
    book, angle = DrivenChain(scene), run.angles[-1]
    matrix, _ = book.assemble(angle, np.zeros(2))
    row = book.jacobian(angle, 2)[1]
    mass = 1.0 / (row @ book.answer(matrix, row))
    assert impact["effective_mass"] == pytest.approx(mass, rel=1e-9)
    after = simulate(scene, stop_time=2.0 * impact["onset"])
    assert balance(after) < 1e-9


@pytest.mark.parametrize("law", ["hertz", "newton_impact"])
def test_a_stop_meets_the_inertia_of_link_and_armature(law):
    link = ROD | {"joint_armature": 0.7, "joint_max": 0.5}
    stops = {"model": law, "stiffness": 1e5, "exponent": 1.5, "restitution": 1.0}
    result = simulate(chain_with_drives([link], {"angles": [0.0], "angular_velocities": [2.0]}, stops=stops))
    (impact,), inertia = result.impacts, INERTIA + 0.7
    assert impact["effective_mass"] == pytest.approx(inertia, rel=1e-14)
    assert impact["impulse"] == pytest.approx(2.0 * 2.0 * inertia, rel=1e-11)
    depth = 0.0 if law == "newton_impact" else (2.5 * 0.5 * inertia * 2.0**2 / 1e5) ** 0.4
    assert impact["max_penetration"] == pytest.approx(depth, rel=1e-11)
    assert balance(result) < 1e-10


def test_a_held_chain_has_the_moments_of_its_armatures():
    """A tip slides along a rigid floor: forces of constraint hold the tip there; the energies balance."""
    links = [ROD | {"joint_armature": 0.4}, ROD | {"joint_armature": 2.0, "joint_friction": 0.1}]
    initial = {"angles": [0.6, -0.6], "angular_velocities": [0.0, 0.0]}
    contact = {"model": "newton_impact", "points": [2], "restitution": 0.0}
    scene = build(
        "Held", links, initial, {"y_min": 0.0}, contact, base="pinned", tolerance=1e-10, gravity=9.81
    )
    result = simulate(scene, stop_time=0.3)
    assert np.abs(result.points[:, 2, 1]).max() < 1e-10
    assert result["contact[2].y_min.force"][1:].min() > 0.0
    assert np.ptp(result.angles[:, 0]) > 0.04
    assert balance(result) < 1e-8


def differences(scene, parameter, output, step=1e-3, **more):
    """Return the derivative of an output over time by central differences of order 6."""

    def run(value):
        return simulate(with_values(scene, {parameter: value}), **more)[output]

    return slope(run, scene.values[parameter], step, 6)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_derivatives_with_respect_to_an_armature_are_those_of_differences(method):
    scene = random_chain(3, "free")
    name = "link[2].joint_armature"
    result = simulate(scene, sensitivities=[name], method=method, tolerance=1e-10, stop_time=0.5)
    exact = differences(scene, name, "point[3].x", tolerance=1e-12, stop_time=0.5)
    derivative = result.sensitivity("point[3].x", name)
    assert np.abs(derivative - exact).max() < 1e-8 * np.abs(exact).max() * (
        1 if method == "explicit" else 100
    )


@pytest.mark.parametrize(("value", "part"), [(-1e-9, ">= 0"), (math.nan, "finite"), ("1", "number")])
def test_an_armature_is_a_number_that_is_not_negative(value, part):
    with pytest.raises(SceneError, match=rf"chain.links\[1\].joint_armature.*{part}"):
        chain_with_drives([ROD | {"joint_armature": value}], {})

"""Stops in joints, against one impact of each law, assembled chains, and the statics of rest."""

import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.scene.scene import scene_from_dict
from tests import coulomb
from tests.reference import point_impact, rebound
from tests.stops import LENGTH, MASS, SPEED, STIFFNESS, arm, knee, struck_rod, together
from tests.textbook import Textbook

INERTIA = MASS * LENGTH**2 / 3
FORCES = [law for law in CONTACT_LAWS.values() if not law.impulsive]


def exact_impact(law, e):
    """Separation speed [rad/s], depth [rad] and moment [N·m] of I φ̈ = −K φⁿ − d φᵖ φ̇, without the kernel."""
    n, s = law.exponent or 1.5, law.mass_power
    factor = law.damping_factor(e)
    if law.rate_exponent is None:  # the Hunt–Crossley family
        impact = point_impact(INERTIA, SPEED, STIFFNESS, n, factor)
        return impact.separation_speed, impact.max_penetration, impact.peak_force
    # in the units (I ω²/K)^{1/(n+1)} of the angle, and that over ω of time
    unit = (INERTIA * SPEED**2 / STIFFNESS) ** (1 / (n + 1))
    scaled = factor * STIFFNESS ** (1 - s) * INERTIA**s * unit ** (law.rate_exponent + 1) / (INERTIA * SPEED)
    found = rebound(n, law.rate_exponent, scaled, law.approach_only)
    return found.restitution * SPEED, found.depth * unit, found.force * INERTIA * SPEED**2 / unit


@pytest.mark.full("more cases", but=6)
@pytest.mark.parametrize("law", FORCES, ids=lambda law: law.id)
def test_a_rod_rebounds_from_its_stop_as_the_law_says_of_an_angle(law):
    e = 0.6
    result = simulate(struck_rod(law.id, e, exponent=law.exponent or 1.5), tolerance=1e-12)
    impact, (speed, depth, moment) = result.impacts[0], exact_impact(law, e)
    assert impact["onset"] == pytest.approx(0.45, abs=1e-13)
    assert impact["impact_speed"] == pytest.approx(SPEED, rel=1e-12)
    assert impact["effective_mass"] == pytest.approx(INERTIA, rel=1e-13)
    assert impact["separation_speed"] == pytest.approx(speed, rel=1e-8)
    assert impact["max_penetration"] == pytest.approx(depth, rel=1e-6)
    assert impact["peak_force"] == pytest.approx(moment, rel=1e-6)
    moved = INERTIA * (impact["impact_speed"] + impact["separation_speed"])
    assert impact["impulse"] == pytest.approx(moved, rel=1e-9)


def test_the_prescribed_restitution_is_exact():
    for model, e in (("zhang_sharf", 0.35), ("newton_impact", 0.35), ("newton_impact", 0.0)):
        result = simulate(struck_rod(model, e), tolerance=1e-12)
        (impact,) = result.impacts[:1]
        if e > 0.0:
            assert impact["separation_speed"] == pytest.approx(e * SPEED, rel=1e-10)
        lost = 0.5 * INERTIA * SPEED**2 * (1.0 - e * e)
        assert result.energy["dissipated"][-1] == pytest.approx(lost, rel=1e-9)


# --- chains ------------------------------------------------------------------------------------------------

KNEE = arm(
    [
        {"length": 0.4, "mass": 1.3, "joint_min": -2.5, "joint_max": -0.6},
        {"length": 0.35, "mass": 0.8, "joint_min": -1.2, "joint_max": 0.1},
    ],
    [-1.2, -1.6],
    2.0,
    initial={"angles": [-1.2, -1.6], "angular_velocities": [3.0, -4.0]},
    stops={"stiffness": 3e3, "restitution": 0.4},
)
SIX = scene_from_dict(
    {
        "name": "Six",
        "chain": {
            "base": "free",
            "links": [
                {"length": 0.3, "mass": 1.0}
                | ({"joint_min": -0.8 - 0.05 * i, "joint_max": 0.7 + 0.1 * i} if i else {})
                for i in range(6)
            ],
        },
        "stops": {"stiffness": 2e3, "restitution": 0.5},
        "initial": {
            "position": [0.0, 0.0],
            "angles": [0.1, 0.3, 0.2, -0.1, 0.2, 0.0],
            "velocity": [0.0, 3.0],
            "angular_velocities": [1.0, -2.0, 3.0, -1.5, 2.5, -3.0],
        },
        "simulation": {"stop_time": 2.0, "step_size": 0.01},
    },
    "six",
)


@pytest.mark.full("takes long")
@pytest.mark.parametrize("scene", [KNEE, SIX], ids=lambda scene: scene.name)
def test_an_assembled_chain_moves_alike(scene):
    """States to 1e-9 and onsets to 1e-11 s, over all impacts of 2 s."""
    exact = coulomb.simulate(scene, times=[scene.simulation.stop_time])
    state, onsets = exact.states[-1], [change for change in exact.changes if change.kind == "onset"]
    assert len(onsets) >= 3
    result = simulate(scene, tolerance=1e-12)
    found = sorted((row["onset"], int(row["point"]), scene.wall_names[row["wall"]]) for row in result.impacts)
    assert [tuple(place) for _, *place in found] == [onset.place for onset in onsets]
    times = [onset.time for onset in onsets]
    np.testing.assert_allclose([time for time, *_ in found], times, rtol=0, atol=1e-11)
    n = len(scene.chain.links)
    moved = np.concatenate([result.points[-1, 0], result.angles[-1]])
    np.testing.assert_allclose(moved, state[: n + 2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(result.angular_velocities[-1], state[n + 4 :], rtol=0, atol=1e-9)
    ledger = result.energy["total"] + result.energy["dissipated"]
    assert np.ptp(ledger) < 1e-9


def test_a_contact_that_lasts_at_the_end_is_told_by_moment_and_angle():
    """As one that has ended: the same onset, speed and inertia, and what was reached so far."""
    whole, scene = simulate(knee()).impacts[0], knee()
    result = simulate(scene, stop_time=0.5 * (whole["onset"] + whole["end"]))
    (lasting,) = result.impacts
    assert scene.wall_names[lasting["wall"]] == "joint_min"
    for name in ("point", "wall", "onset", "impact_speed", "effective_mass"):
        assert lasting[name] == whole[name], name
    assert np.isnan([lasting["end"], lasting["separation_speed"]]).all()
    assert lasting["max_penetration"] >= result.angles[-1, 0] - result.angles[-1, 1] > 0.0
    assert lasting["peak_force"] >= result["joint[2].stop_moment"][-1] > 0.0
    for name in ("peak_force", "max_penetration", "impulse"):
        assert 0.5 * whole[name] < lasting[name] <= whole[name], name


# --- rest --------------------------------------------------------------------------------------------------

RESTING = [
    {"length": 0.4, "mass": 1.3, "joint_min": -0.4},
    {"length": 0.3, "mass": 0.5, "joint_min": -0.5, "joint_max": 0.6},
]


@pytest.mark.parametrize("model", ["zhang_sharf", "newton_impact"])
def test_an_arm_comes_to_rest_on_its_stops(model):
    """The stops bear the moments of the weight: K φⁿ, or the constraint of a rigid one."""
    scene = arm(RESTING, [0.3, 0.4], 6.0, stops={"model": model, "stiffness": 1e6, "restitution": 0.3})
    result = simulate(scene)
    first, second = result.angles[-1]
    np.testing.assert_allclose(result.angular_velocities[-1], 0.0, atol=1e-9)
    distal = 0.5 * 9.81 * 0.15 * math.cos(second)
    proximal = 1.3 * 9.81 * 0.2 * math.cos(first) + 0.5 * 9.81 * 0.4 * math.cos(first) + distal
    moments = result["joint[1].stop_moment"][-1], result["joint[2].stop_moment"][-1]
    assert moments == pytest.approx((proximal, distal), rel=1e-8)
    depths = (0.0, 0.0) if model == "newton_impact" else [(moment / 1e6) ** (2 / 3) for moment in moments]
    assert (-0.4 - first, -0.5 - (second - first)) == pytest.approx(depths, abs=1e-9)


@pytest.mark.parametrize(("walls", "stops"), [("zhang_sharf", "newton_impact"), ("newton_impact", "flores")])
def test_rigid_stops_and_walls_with_a_force_hold_an_arm_together_and_the_other_way_round(walls, stops):
    """An arm on its stop and on a floor: the moments about the base, and about the knee, are in balance."""
    scene = arm(
        RESTING,
        [0.3, 0.4],
        6.0,
        box={"y_min": -0.3},
        contact={"model": walls, "stiffness": 1e7, "restitution": 0.3},
        stops={"model": stops, "stiffness": 1e6, "restitution": 0.3},
    )
    for method in ("auto", "explicit", "implicit"):
        result = simulate(scene, method=method)
        np.testing.assert_allclose(result.angular_velocities[-1], 0.0, atol=1e-7)
        first, second = result.angles[-1]
        knee, hip = result["joint[2].stop_moment"][-1], result["joint[1].stop_moment"][-1]
        push = result["contact[2].y_min.force"][-1]
        reach = 0.3 * math.cos(second)
        assert knee + push * reach == pytest.approx(0.5 * 9.81 * 0.15 * math.cos(second), rel=1e-6)
        total = 1.3 * 9.81 * 0.2 * math.cos(first) + 0.5 * 9.81 * (
            0.4 * math.cos(first) + 0.15 * math.cos(second)
        )
        assert hip + push * (0.4 * math.cos(first) + reach) == pytest.approx(total, rel=1e-6)
        assert (result.impacts["wall"] == scene.wall_names.index("joint_min")).any()
        drop = np.diff(result.energy["dissipated"]).min()
        assert drop > -1e-9


@pytest.mark.full("more cases", but=3)
@pytest.mark.parametrize("law", ["zhang_sharf", "lankarani_nikravesh", "kelvin_voigt"])
@pytest.mark.parametrize(("walls", "stops"), [(None, "newton_impact"), ("newton_impact", None)])
def test_the_peak_of_a_force_is_the_largest_one_also_where_rigid_contacts_strike_or_hold(law, walls, stops):
    """A rigid impact makes the force of the other contacts jump; and a held one takes part in their rates."""
    exponent = 1.0 if law == "kelvin_voigt" else 1.5
    scene = arm(
        [{"length": 0.5, "mass": 1.0}, {"length": 0.4, "mass": 0.5, "joint_max": 0.3}],
        [0.4, 0.2],
        1.5,
        box={"y_min": -0.55},
        contact={"model": walls or law, "stiffness": 3e3, "restitution": 0.3, "exponent": exponent},
        stops={"model": stops or law, "stiffness": 500.0, "restitution": 0.3, "exponent": exponent},
    )
    result = simulate(scene, output_step=1e-5, tolerance=1e-9)
    forces = {
        "y_min": np.max([result[f"contact[{k}].y_min.force"] for k in (1, 2)], axis=0),
        "joint_max": -result["joint[2].stop_moment"],
    }
    for name, force in forces.items():
        own = result.impacts[result.impacts["wall"] == scene.wall_names.index(name)]
        if (own["peak_force"] > 0.0).all():
            assert force.max() <= own["peak_force"].max() * (1.0 + 1e-9)


# --- impacts at one moment ---------------------------------------------------------------------------------


def after_impact(scene, rigid):
    """The rates of the knee and of the tip after the rigid impact, at the floor or at the stop."""
    angle, omega = np.array(scene.initial.angles), np.array(scene.initial.angular_velocities)
    matrix, _ = Textbook(scene).assemble(angle, omega)
    knee, tip = np.array([-1.0, 1.0]), np.array([0.4, 0.3]) * np.cos(angle)
    struck = tip if rigid == "floor" else knee
    response = np.linalg.solve(matrix[2:, 2:], struck)
    omega = omega - response * (1.5 * (struck @ omega) / (struck @ response))
    return knee @ omega, tip @ omega


@pytest.mark.parametrize(
    ("rigid", "omegas"),
    [("floor", [-2.0, -2.5]), ("floor", [2.5, -4.0]), ("stop", [2.0, -4.0]), ("stop", [-2.0, -2.5])],
)
@pytest.mark.parametrize("law", ["zhang_sharf", "kelvin_voigt"])
def test_a_contact_begins_after_a_rigid_impact_at_the_same_moment_if_it_still_approaches(rigid, omegas, law):
    """Else there is none: no impact is listed that has no force."""
    laws = ("newton_impact", law) if rigid == "floor" else (law, "newton_impact")
    scene = together(*laws, omegas)
    knee, tip = after_impact(scene, rigid)
    left = knee if rigid == "floor" else tip
    first, second = ("y_min", "joint_min") if rigid == "floor" else ("joint_min", "y_min")
    hits = simulate(scene, tolerance=1e-10).impacts
    at_once = {scene.wall_names[hit["wall"]]: hit for hit in hits if hit["onset"] < 1e-10}
    assert at_once[first]["peak_force"] == 0.0
    assert (second in at_once) == (left < 0.0)
    if left < 0.0:
        assert at_once[second]["impact_speed"] == pytest.approx(-left, rel=1e-12)
        assert at_once[second]["peak_force"] > 1.0


def test_steps_after_an_impact_are_as_long_as_before_it_while_a_rigid_stop_holds_another_joint():
    """An arm rests on its rigid stop, and its tip bounces on a floor that has a force."""
    links = [{"length": 0.5, "mass": 5.0, "joint_min": -0.1}, {"length": 0.3, "mass": 0.2}]
    scene = arm(
        links,
        [-0.1, 0.6],
        5.0,
        box={"y_min": -0.2},
        contact={"model": "zhang_sharf", "stiffness": 1e6, "restitution": 0.95},
        stops={"model": "newton_impact", "restitution": 0.0},
        initial={"angles": [-0.1, 0.6], "angular_velocities": [0.0, -2.0]},
    )
    result = simulate(scene)
    bounces = (result.impacts["peak_force"] > 0.0) & (result.impacts["wall"] == 2)
    assert bounces.sum() > 10
    # if steps had to grow from the size of those of an impact, there would be 28 for each
    assert result.statistics["steps"] < 26 * bounces.sum()

"""Joints with springs, dampers and stops: closed forms, beams, statics, and the cost of stiff joints."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from chain_impact import simulate
from chain_impact.kernel.ode.step_control import ERROR_ORDER
from chain_impact.kernel.record.constants import IMPLICIT, SOLVER_METHODS
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.models.reference import balance, momenta
from tests.helpers.models.textbook import Textbook
from tests.helpers.scenes.joint_drives import INERTIA, ROD
from tests.helpers.scenes.problems import build, stiff_joint
from tests.helpers.scenes.stops import arm, knee_scene, simultaneous_impacts

FLIGHT = 0.25  # s, in the scene of stiff joints, before its first impact
RTOL = {"DOP853": 1e-12, "Radau": 1e-10}
RIGID = {("contact", "model"): "newton_impact"}


def sprung(links, initial, *, base="pinned", tolerance=1e-10, **more):
    """Return a chain with springs in free space."""
    return build("Sprung", links, initial, {}, {"points": []}, base=base, tolerance=tolerance, **more)


def integrated(scene, time, method="DOP853"):
    """Return base, angles, rates and dissipated energy, by SciPy on the assembled equations."""
    book = Textbook(scene)

    def rate(_, y):
        return np.append(book.rate(y[:-1]), book.loss(y[:-1]))

    y = np.append(book.start, 0.0)
    return solve_ivp(rate, (0.0, time), y, method, rtol=RTOL[method], atol=1e-12).y[:, -1]


def reached(result):
    """Return base, angles, rates and dissipated energy at the end of a result."""
    end = result.outputs[-1]
    motion = end["point_position"][0], end["angle"], end["point_velocity"][0], end["angular_velocity"]
    return np.concatenate([*motion, [end["dissipated"]]])


# --- springs -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("rest", [0.0, -0.7, 8.0])
def test_a_rod_on_a_spring_swings_harmonically_however_far(rest, method):
    """I φ̈ = −k φ at any amplitude: φ = A cos ωt + (ω₀/ω) sin ωt about the rest angle."""
    stiffness, amplitude, spin = 12.0, 4.0, 1.5
    link = ROD | {"joint_stiffness": stiffness, "joint_rest_angle": rest}
    scene = sprung([link], {"angles": [rest + amplitude], "angular_velocities": [spin]})
    tolerance = 1e-6 if method == "implicit" else 1e-11
    result = simulate(scene, method=method, tolerance=tolerance)
    pace = np.sqrt(stiffness / INERTIA)
    exact = rest + amplitude * np.cos(pace * result.time) + spin / pace * np.sin(pace * result.time)
    assert np.abs(result.angles[:, 0] - exact).max() < 100.0 * tolerance
    stored = 0.5 * stiffness * (result.angles[:, 0] - rest) ** 2
    np.testing.assert_allclose(result.energy["elastic"], stored, rtol=1e-12)
    assert np.ptp(result.energy["total"]) < 1e3 * tolerance


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize(("count", "base"), [(2, "free"), (4, "pinned")])
def test_a_chain_moves_as_the_textbook_says(count, base):
    rng = np.random.default_rng([count, len(base)])
    links = [
        {
            "length": rng.uniform(0.2, 1.0),
            "mass": rng.uniform(0.5, 2.0),
            "joint_stiffness": rng.uniform(1.0, 100.0),
            "joint_rest_angle": rng.uniform(-1.0, 1.0),
            "joint_damping": rng.uniform(0.0, 0.05),
        }
        for _ in range(count)
    ]
    angles, spins = rng.uniform(-1.0, 1.0, count), rng.uniform(-3.0, 3.0, count)
    initial = {"angles": list(angles), "angular_velocities": list(spins)}
    scene = sprung(links, initial, base=base, gravity=9.81, tolerance=1e-11)
    result = simulate(scene)
    np.testing.assert_allclose(reached(result), integrated(scene, 1.0), rtol=0, atol=1e-8)
    assert balance(result) < 1e-8


def test_a_free_base_has_no_spring():
    links = [ROD | {"joint_stiffness": 10.0}, ROD | {"joint_stiffness": 3.0}]
    initial = {"angles": [0.4, 1.0], "angular_velocities": [1.0, -1.0]}
    scene = sprung(links, initial, base="free")
    without = with_values(scene, {"link[1].joint_stiffness": 0.0, "link[1].joint_rest_angle": 2.0})
    results = [simulate(each) for each in (scene, without)]
    np.testing.assert_array_equal(results[0].outputs, results[1].outputs)
    momentum, spin = momenta(results[0])
    assert np.ptp(momentum, axis=0).max() < 1e-8
    assert np.ptp(spin) < 1e-9


def test_the_implicit_method_keeps_its_order_on_springs():
    """The number of steps grows as the seventh root of 1/tolerance, and the error falls as the tolerance."""
    links = [ROD | {"joint_stiffness": 50.0, "joint_rest_angle": 0.2}] * 3
    scene = sprung(links, {"angles": [0.3, -0.5, 1.0], "angular_velocities": [1.0, -3.0, 2.0]}, gravity=9.81)
    exact = integrated(scene, 1.0)
    runs = [simulate(scene, tolerance=tolerance, method="implicit") for tolerance in (1e-5, 1e-8)]
    assert runs[1].statistics["steps"] / runs[0].statistics["steps"] == pytest.approx(
        1000.0 ** (1 / ERROR_ORDER[IMPLICIT]), rel=0.15
    )
    errors = [np.abs(reached(run) - exact).max() for run in runs]
    assert errors[0] < 1e-3
    assert errors[1] < 1e-6


# --- stiff joints ------------------------------------------------------------------------------------------


def stiffened(damping, stiffness, count=2, base="free", stop_time=0.25):
    """Return the links of ``stiff_joint`` with springs that are slack as they start."""
    scene = stiff_joint(damping, count, stop_time, base)
    angles = np.array(scene.initial.angles)
    rest = np.diff(angles, prepend=0.0)
    changes = {("chain", "links", i, "joint_rest_angle"): float(rest[i]) for i in range(count)}
    changes |= {("chain", "links", i, "joint_stiffness"): stiffness for i in range(count)}
    return with_values(scene, changes)


@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
def test_stiff_damped_springs_become_implicit_after_their_swing(stiffness):
    """The number of evaluations is bounded: explicit steps alone need 85,000 for 1e7 N·m/rad."""
    result = simulate(stiffened(0.01 * np.sqrt(stiffness), stiffness))
    assert result.statistics["implicit_steps"] > 0
    assert result.statistics["rhs_evaluations"] < 12_000
    assert balance(result) < 1e-7


def test_a_swing_that_the_tolerance_sees_has_explicit_steps():
    """Links start with a relative rate of 4 rad/s, on springs without damping: nothing decays."""
    result = simulate(stiffened(0.0, 1e5))
    assert result.statistics["implicit_steps"] == 0
    assert balance(result) < 1e-6


def test_stiff_springs_at_rest_have_implicit_steps():
    """A free chain that rotates as one body strains its springs by less than the tolerance."""
    still = {("initial", "angular_velocities"): [1.0, 1.0]}
    result = simulate(with_values(stiffened(0.0, 1e12), still))
    assert result.statistics["implicit_steps"] > 0.5 * result.statistics["steps"]
    assert result.statistics["rhs_evaluations"] < 2_000
    rod = with_values(stiff_joint(1e6), {**still, ("simulation", "stop_time"): 0.25})
    np.testing.assert_allclose(result.points[-1], simulate(rod).points[-1], rtol=0, atol=1e-6)


def test_springs_that_are_taken_away_leave_nothing_behind():
    """An instance restarted without its springs moves like an instance without springs."""
    with_springs = stiffened(0.0, 1e3)
    without = with_values(with_springs, {("chain", "links", i, "joint_stiffness"): 0.0 for i in range(2)})
    used, new_instance = Instance(with_springs), Instance(without)
    used.advance(0.1)
    used.record["given"]["drive_stiffness"] = 0.0
    used.initialize()
    for chain in (used, new_instance):
        chain.advance(0.2)
    np.testing.assert_array_equal(used.record["step"]["state_end"], new_instance.record["step"]["state_end"])


@pytest.mark.full("takes long")
@pytest.mark.parametrize("method", ["auto", "implicit"])
@pytest.mark.parametrize("damping", [100.0, 1e4])
@pytest.mark.parametrize(("count", "base"), [(2, "free"), (3, "pinned")])
def test_the_error_in_flight_follows_the_tolerance(count, base, damping, method):
    scene = stiff_joint(damping, count, FLIGHT, base)
    exact = integrated(scene, FLIGHT, "Radau")
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-9):
        result = simulate(scene, tolerance=tolerance, method=method)
        assert np.abs(reached(result) - exact).max() < 0.2 * tolerance


@pytest.mark.parametrize(
    ("damping", "most"), [(1.0, 7_000), (10.0, 12_000), (100.0, 7_000), (1e4, 4_000), (1e6, 4_000)]
)
def test_a_fall_with_impacts_costs_a_bounded_number_of_evaluations(damping, most):
    """Explicit steps alone need 34,000 for 10 N·m·s/rad, 253,000 for 100, and 25 million for 1e4."""
    result = simulate(stiff_joint(damping))
    assert len(result.impacts) >= 5
    assert result.statistics["rhs_evaluations"] < most


@pytest.mark.parametrize(
    ("scene", "stop_time", "impacts", "method"),
    [
        (with_values(stiffened(0.1, 1e3), RIGID | {("contact", "restitution"): 0.8}), 0.8, 3, "auto"),
        (with_values(stiff_joint(100.0), RIGID | {("contact", "restitution"): 1.0}), 0.45, 2, "auto"),
        (stiffened(0.1, 1e3), 0.8, 3, "auto"),
        (stiffened(0.1, 1e3), 0.8, 3, "implicit"),
    ],
    ids=["rigid, springs", "rigid, dampers", "auto", "implicit"],
)
def test_the_energy_balance_closes_through_impacts(scene, stop_time, impacts, method):
    result = simulate(scene, stop_time=stop_time, method=method)
    assert len(result.impacts) >= impacts
    assert balance(result) < 1e-6
    assert method == "implicit" or result.statistics["rhs_evaluations"] < 20_000


# --- stiff springs at loose tolerances: no gain of energy, and losses in proportion to the tolerance --------

FIFTH, SECONDS = 0.2, 4


def strained(count, stiffness, tolerance, base="free", bend=2.0):
    """Return links of 0.5 m and 1 kg at random angles [rad], with springs slack in a straight line."""
    draw = np.random.default_rng(count)
    initial = {
        "position": [0.0, 0.0],
        "velocity": [0.0, 0.0],
        "angles": (bend * draw.normal(size=count)).tolist(),
        "angular_velocities": draw.uniform(-2.0, 2.0, count).tolist(),
    }
    links = [{"length": 0.5, "mass": 1.0, "joint_stiffness": stiffness}] * count
    return build(
        "Springs", links, initial, {}, {"points": []}, stop_time=SECONDS, base=base, tolerance=tolerance
    )


def changes(scene, method="auto"):
    """Return the largest rise and fall of the energy balance, over its start, and the status of the run."""
    instance = Instance(scene)
    instance.record["solver"]["method"] = 1 + SOLVER_METHODS.index(method)
    instance.initialize()
    instance.observe()
    output, balances = instance.record["output"], [0.0]
    start = float(output["total"])
    for second in range(1, SECONDS + 1):
        status = instance.advance(float(second))
        instance.observe()
        balances.append(float(output["total"] + output["dissipated"]) - start)
        if status != OK:
            break
    return max(balances) / start, -min(balances) / start, status


@pytest.mark.full("more cases", but=7)
@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-2, 5e-3, 1e-3])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_no_tolerance_makes_energy_from_nothing(base, tolerance, method):
    share, _, status = changes(strained(5, 1e5, tolerance, base), method)
    assert status == OK
    assert share < FIFTH


@pytest.mark.full("more cases", but=10)
@pytest.mark.parametrize("method", SOLVER_METHODS)
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-6])
@pytest.mark.parametrize(("bend", "most"), [(0.01, 17.0), (0.1, 10.0)])
def test_losses_follow_the_tolerance(bend, most, tolerance, method):
    """The springs oscillate fast with a small amplitude; without a bound the loss is up to 143 tolerances."""
    _, share, status = changes(strained(5, 1e5, tolerance, bend=bend), method)
    assert status == OK
    assert share < most * tolerance


# --- stops -------------------------------------------------------------------------------------------------


def test_a_contact_that_lasts_at_the_end_is_told_by_moment_and_angle():
    """The row has the onset, speed, inertia and present peaks, like the row of a finished contact."""
    whole, scene = simulate(knee_scene()).impacts[0], knee_scene()
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


@pytest.mark.parametrize(("walls", "stops"), [("zhang_sharf", "newton_impact"), ("newton_impact", "flores")])
def test_rigid_stops_and_force_walls_hold_an_arm_together(walls, stops):
    """An arm rests on its stop and on a floor: the moments about the base, and about the knee, balance."""
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
def test_the_peak_force_is_the_largest_beside_rigid_contacts(law, walls, stops):
    """A rigid impact makes the force of other contacts jump; a held contact influences their rates."""
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
    """Return the rates of the knee and of the tip after the rigid impact, at the floor or at the stop."""
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
def test_a_contact_begins_with_a_simultaneous_rigid_impact(rigid, omegas, law):
    """The rigid impact is listed; the other contact only if the rigid impact leaves an approach there."""
    laws = ("newton_impact", law) if rigid == "floor" else (law, "newton_impact")
    scene = simultaneous_impacts(*laws, omegas)
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


def test_a_held_joint_does_not_shorten_steps_after_an_impact():
    """An arm rests on its rigid stop, while its tip bounces on a floor with a force law."""
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
    # steps that had to grow from an impact's step size would give 28 steps for each bounce
    assert result.statistics["steps"] < 26 * bounces.sum()

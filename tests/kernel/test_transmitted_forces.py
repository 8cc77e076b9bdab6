"""Loads in joints and on walls, against Newton's and Euler's laws for the simulated motion of each link."""

import numpy as np
import pytest
from scipy.integrate import simpson

from chain_impact import load_scene, simulate, sweep
from chain_impact.scene.scene import Scene, with_values
from chain_impact.simulation.errors import SimulationError
from tests.helpers.campaigns.random_scenes import DRIVEN, RUBBED, SLANTED, STOPPED, scene as random_scene
from tests.helpers.tools.differences import slope

GEAR = {"link[2].joint_stiffness": 3.0, "link[3].joint_damping": 0.2, "inputs.tip_force": True}
GEAR |= {"link[3].joint_min": 1.2, "link[3].joint_max": 1.4, "inputs.joint_torques": True}
ROUGH = {"contact.friction": 0.3, "wall.y_min.static_friction": 0.5, "link[2].joint_friction": 0.5}
SLOPE = {("walls",): [{"name": "slope", "point": [0.3, -0.2], "angle": -0.5}]}
CASES = {
    "box": ("four_link_box", {}),
    "rigid walls": ("four_link_box", {"contact.model": "newton_impact"}),
    "cut off": ("four_link_box", {"contact.model": "kelvin_voigt", "contact.exponent": 1.0}),
    "pinned": ("pinned_arm", {}),
    "driven, stops": ("four_link_box", GEAR),
    "friction": ("four_link_box", ROUGH | GEAR),
    "armatures": ("four_link_box", GEAR | {"link[2].joint_armature": 0.1, "link[4].joint_armature": 0.02}),
    "slope": ("four_link_box", SLOPE),
    "held": ("ramp", {}),
}
PUSHED = {"joint[2].torque": 0.4, "tip.force.x": 3.0, "tip.force.y": -1.0}


def loaded(name: str, **changes) -> Scene:
    model, values = CASES[name]
    return with_values(load_scene(model), values | {"outputs.loads": True} | changes)


def run(name: str, step: float = 1e-3, **changes):
    scene = loaded(name, **changes)
    inputs = PUSHED if scene.inputs.tip_force else {}
    return simulate(scene, output_step=step, stop_time=min(1.0, scene.simulation.stop_time), inputs=inputs)


def cross(first, other):
    return first[..., 0] * other[..., 1] - first[..., 1] * other[..., 0]


class Links:
    """The public outputs of a run: motion of the links and forces at their points, each of shape (T, 2).

    ``push`` is the force on the tip [N].
    """

    def __init__(self, result, push=(0.0, 0.0)) -> None:
        self.result, self.scene, self.push = result, result.scene, np.array(push)
        self.links = self.scene.chain.links
        self.count = len(self.links)
        self.first = 1 if self.scene.chain.base == "pinned" else 2  # number of the first joint

    def vector(self, name):
        return np.stack([self.result[f"{name}{axis}"] for axis in "xy"], 1)

    def at_center(self, i, kind=""):
        """Return position, velocity or acceleration of the centre of mass of link i, from 1."""
        inner, outer = (self.vector(f"point[{k}].{kind}") for k in (i - 1, i))
        link = self.links[i - 1]
        return inner + link.center_of_mass / link.length * (outer - inner)

    def forces_on(self, wall, kind="force"):
        """Return point → force, or impulse, of a wall on the point."""
        forces, normal = {}, np.array(self.scene.half_planes[wall].normal)
        for name in self.result.columns:
            owner, _, quantity = name.rpartition(".")
            point = int(owner[8 : owner.index("]")]) if owner.startswith("contact[") else -1
            if point >= 0 and owner.endswith(f"].{wall}") and quantity in (kind, f"friction_{kind}"):
                along = normal if quantity == kind else np.array([normal[1], -normal[0]])
                forces[point] = forces.get(point, 0.0) + np.outer(self.result[name], along)
        return forces

    def force_at(self, k, kind="force"):
        """Return the force of walls, and of an input at the tip, on point k."""
        total = np.zeros((len(self.result.time), 2))
        for wall in self.scene.half_planes:
            total += self.forces_on(wall, kind).get(k, 0.0)
        if k == self.count:
            total += self.push if kind == "force" else np.outer(self.result.time, self.push)
        return total

    def cut_at_stops(self):
        """Return the rows inside a step in which the force of a stop is cut to zero.

        The accelerations have no cut.
        """
        beyond, names = np.zeros(len(self.result.time), bool), self.result.columns
        for name in names:
            if name.endswith("stop_penetration"):
                force = names[name.replace("penetration", "moment")]
                beyond |= (names[name] > 0.0) & (force == 0.0)
        return beyond

    def of_joint(self, i, name="force."):
        return self.vector(f"joint[{i}].{name}") if self.first <= i <= self.count else 0.0


def links_of(name: str, step: float = 1e-3) -> Links:
    result = run(name, step)
    push = [PUSHED[f"tip.force.{axis}"] for axis in "xy"] if result.scene.inputs.tip_force else (0.0, 0.0)
    return Links(result, push)


def off(result, expected):
    return np.abs(result - expected).max() / max(np.abs(expected).max(), 1e-6)


@pytest.mark.parametrize("name", CASES)
def test_forces_and_moments_are_those_of_the_laws_of_newton_and_euler(name):
    assert_laws_hold(links_of(name))


def test_loads_balance_in_random_scenes():
    """The scenes have walls at any angle, stops, springs, dry friction and rigid walls."""
    complete = 0
    for seed in (*range(4), *(first + k for first in (SLANTED, STOPPED, RUBBED, DRIVEN) for k in range(8))):
        try:
            result = simulate(with_values(random_scene(seed), {"outputs.loads": True}))
        except SimulationError as error:  # the error contains the rows before the failure
            result = error.result
        else:
            complete += 1
        if result is not None and len(result.time):
            assert_laws_hold(Links(result))
    assert complete > 20


def assert_laws_hold(chain):
    result, gravity = chain.result, np.array(chain.scene.gravity)
    for i in range(chain.first, chain.count + 1):
        link, center = chain.links[i - 1], chain.at_center(i)
        inner, outer = chain.vector(f"point[{i - 1}]."), chain.vector(f"point[{i}].")
        beyond = chain.force_at(i) - chain.of_joint(i + 1)
        # m (a − g) = f_i − f_{i+1} + F_i
        expected = link.mass * (chain.at_center(i, "a") - gravity) - beyond
        assert off(chain.of_joint(i), expected) < 1e-12
        # I α = τ_i − τ_{i+1} + (p_{i−1} − C) × f_i + (p_i − C) × (F_i − f_{i+1})
        turned = link.inertia * result[f"link[{i}].angular_acceleration"]
        turned -= cross(inner - center, chain.of_joint(i)) + cross(outer - center, beyond)
        after = result[f"joint[{i + 1}].moment"] if i < chain.count else 0.0
        size = np.abs(chain.of_joint(i)).max() * link.length
        rest = np.abs(result[f"joint[{i}].moment"] - after - turned)
        assert rest[~chain.cut_at_stops()].max(initial=0.0) < 1e-9 * max(size, 1.0)


@pytest.mark.parametrize("name", CASES)
def test_impulses_are_the_change_of_momentum(name):
    assert_momentum_holds(links_of(name, 0.01))


def test_the_laws_hold_with_a_base_and_a_wall_that_move():
    moved = {"outputs.loads": True, "inputs.base_motion": True, "inputs.wall_motion": ["x_max"]}
    scene = load_scene("pinned_arm").with_values(moved)
    ways = {
        "base.y": lambda time: 0.05 * np.sin(20.0 * time),
        "wall.x_max.displacement": lambda time: 0.02 * np.sin(10.0 * time),
    }
    chain = Links(simulate(scene, inputs=ways))
    assert len(chain.result.impacts) == 2
    assert_laws_hold(chain)
    assert_momentum_holds(chain)


def assert_momentum_holds(chain):
    gravity, time = np.array(chain.scene.gravity), chain.result.time
    for i in range(chain.first, chain.count + 1):
        momentum = chain.links[i - 1].mass * chain.at_center(i, "v")
        given = (
            chain.of_joint(i, "impulse.") - chain.of_joint(i + 1, "impulse.") + chain.force_at(i, "impulse")
        )
        given += chain.links[i - 1].mass * np.outer(time, gravity)
        assert np.abs(given - (momentum - momentum[0])).max() < 1e-11 * max(np.abs(momentum).max(), 1.0)


def test_an_impulse_is_the_integral_of_the_force():
    """The reference is Simpson's rule where no force has a kink."""
    sharp = {"solver.tolerance": 1e-10, "link[3].joint_min": -9.0, "link[3].joint_max": 9.0}
    result = run("driven, stops", 1e-4, **sharp)
    flight = result.time <= result.impacts["onset"][0]
    for joint in (2, 3, 4):
        for axis in "xy":
            force = result[f"joint[{joint}].force.{axis}"][flight]
            expected = simpson(force, dx=1e-4)
            last_impulse = result[f"joint[{joint}].impulse.{axis}"][len(force) - 1]
            assert last_impulse == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", ["box", "rigid walls", "driven, stops", "friction", "pinned"])
def test_a_peak_is_that_of_a_thousand_times_finer_rows(name):
    coarse, fine = run(name, 0.05), run(name, 5e-5)
    chain = Links(fine)
    for i in range(chain.first, chain.count + 1):
        sizes = np.hypot(*chain.of_joint(i).T)
        peaks, result = fine[f"joint[{i}].peak_force"], coarse[f"joint[{i}].peak_force"]
        assert (peaks >= np.maximum.accumulate(sizes) * (1.0 - 1e-6)).all()
        assert (np.diff(peaks) >= -1e-7 * peaks[-1]).all()
        assert result == pytest.approx(peaks[::1000], rel=1e-7)
        assert sizes.max() <= result[-1] * (1.0 + 1e-9)
        assert_time_of_peak(coarse, i, fine, sizes)


def assert_time_of_peak(result, joint, fine, sizes):
    """Assert that each row's peak is nearly the largest force of the fine rows around the peak's time."""
    peaks, times = (result[f"joint[{joint}].peak_{quantity}"] for quantity in ("force", "time"))
    for row, peak, time in zip(result.time, peaks, times, strict=True):
        beside = (np.abs(fine.time - time) <= 1.01 * fine.time[1]) & (fine.time <= row + 1e-12)
        assert sizes[beside].max() == pytest.approx(peak, rel=0.02)
        assert time <= row


@pytest.mark.full("more cases", but="box")
@pytest.mark.parametrize("name", ["box", "driven, stops", "friction", "pinned", "rigid walls", "held"])
def test_an_impact_has_the_largest_force_in_a_joint_while_it_lasts(name):
    coarse, fine = run(name, 0.1), run(name, 1e-5)
    chain = Links(fine)
    assert coarse.impacts.tobytes() == fine.impacts.tobytes()
    joints = range(chain.first, chain.count + 1)
    sizes = np.array([np.hypot(*chain.of_joint(i).T) for i in joints])
    lasting = 0
    for impact in coarse.impacts:
        onset, end = impact["onset"], np.nan_to_num(impact["end"], nan=fine.time[-1])
        if end == onset or not joints:
            assert (impact["joint_force"], impact["joint"]) == (0.0, 0)
            continue
        # without the rows at the ends of the impact, where the force of a rigid wall jumps
        rows = sizes[:, (fine.time > onset) & (fine.time < end)]
        assert rows.max(initial=0.0) <= impact["joint_force"] * (1.0 + 1e-7)
        if rows.shape[1] > 60:  # enough rows for one near the peak
            # a force that jumps at an onset or at a mode change may be smaller in the next row
            near = 1e-3 if name in ("box", "pinned") else 0.03
            assert impact["joint_force"] == pytest.approx(rows.max(), rel=near)
            assert impact["joint"] == joints[rows.max(axis=1).argmax()]
            lasting += 1
    assert lasting or name == "rigid walls" or not joints
    most = max(fine[f"joint[{i}].peak_force"][-1] for i in joints) if joints else 0.0
    assert coarse.impacts["joint_force"].max() <= most
    if name in ("box", "pinned"):
        assert coarse.impacts["joint_force"].max() == most


@pytest.mark.parametrize("name", ["friction", "slope", "held"])
def test_a_wall_bears_what_its_points_press_on_it(name):
    chain = links_of(name)
    bearing = 0
    for wall in chain.scene.half_planes:
        place = next((each.point for each in chain.scene.walls if each.name == wall), (0.0, 0.0))
        force, moment = np.zeros((len(chain.result.time), 2)), np.zeros(len(chain.result.time))
        for point, given in chain.forces_on(wall).items():
            force -= given
            moment -= cross(chain.vector(f"point[{point}].") - place, given)
        bearing += force.any()
        assert off(chain.vector(f"wall.{wall}.load."), force) < 1e-12
        assert off(chain.result[f"wall.{wall}.load_moment"], moment) < 1e-12
    assert bearing


def test_a_sweep_has_those_of_the_end():
    names = ["joint[3].impulse.y", "joint[3].peak_force", "wall.y_min.load.y"]
    scene = loaded("driven, stops", **{"simulation.stop_time": 0.6})
    masses = [scene.values["link[4].mass"], 1.5]
    result = sweep(scene, {"link[4].mass": masses, "contact.stiffness": [1e6, 1e8]}, outputs=names)
    for row in result.table:
        varied = {name: row[name] for name in ("link[4].mass", "contact.stiffness")}
        expected = simulate(scene.with_values(varied), output_step=0.6)
        assert [row[name] for name in names] == [expected[name][-1] for name in names]
    assert len(set(result["joint[3].peak_force"])) == 4


@pytest.mark.parametrize("name", CASES)
def test_the_motion_is_the_same_without_them(name):
    with_loads, without = run(name), run(name, **{"outputs.loads": False})
    assert all(
        "load" in column_name or column_name.startswith("joint")
        for column_name in set(with_loads.columns) - set(without.columns)
    )
    for column, values in without.columns.items():
        assert np.array_equal(with_loads[column], values), column
    for field in set(without.impacts.dtype.names) - {"joint_force", "joint"}:
        expected = without.impacts[field]
        assert np.array_equal(with_loads.impacts[field], expected, equal_nan=expected.dtype.kind == "f")
    assert np.isnan(without.impacts["joint_force"]).all()
    assert not without.impacts["joint"].any()
    assert ("loads    at most" in str(with_loads)) == any(
        output.endswith("peak_force") for output in with_loads.continuous_columns
    )


@pytest.mark.parametrize(
    ("name", "output"),
    [
        ("box", "joint[3].force.x"),
        ("box", "joint[3].peak_force"),
        ("box", "joint[4].impulse.y"),
        ("driven, stops", "joint[3].moment"),
        ("driven, stops", "joint[4].impulse.y"),
    ],
)
def test_derivatives_are_those_of_differences(name, output):
    parameter, change = "link[4].mass", 1e-5
    scene = loaded(name, **{"solver.tolerance": 1e-11})
    value, inputs = scene.values[parameter], PUSHED if scene.inputs.tip_force else {}
    result = simulate(scene, stop_time=0.6, output_step=0.02, sensitivities=[parameter], inputs=inputs)

    def changed(number):
        varied = scene.with_values({parameter: number})
        return simulate(varied, stop_time=0.6, output_step=0.02, inputs=inputs)[output]

    expected = slope(changed, value, change)
    derivative = result.sensitivity(output, parameter)
    # the difference is not valid in a row just at an impact
    quiet = np.abs(expected) < 50.0 * np.median(np.abs(expected))
    assert quiet.sum() > 20
    assert np.abs(derivative - expected)[quiet].max() < 1e-5 * np.abs(expected[quiet]).max()


def test_the_time_of_a_peak_has_the_derivative_of_differences_or_none():
    scene = loaded("driven, stops", **{"solver.tolerance": 1e-11})
    options = {"stop_time": 0.6, "output_step": 0.02, "inputs": PUSHED}
    result = simulate(scene, sensitivities=["link[4].mass"], **options)

    def changed(number):
        return simulate(scene.with_values({"link[4].mass": number}), **options)["joint[4].peak_time"]

    derivatives, expected = (
        result.sensitivity("joint[4].peak_time", "link[4].mass"),
        slope(changed, 1.0, 1e-5),
    )
    is_trusted = ~np.isnan(derivatives)
    assert is_trusted.sum() > 20
    assert is_trusted[-1]
    assert derivatives[is_trusted] == pytest.approx(expected[is_trusted], abs=1e-5 * np.abs(expected).max())
    # where two steps meet, only the sample is known, and its time is that of the step
    swing = {
        "outputs.loads": True,
        "box.x_max": 10.0,
        "initial.angles": [-1.3035486237248173, -0.18771234638737821],
        "initial.angular_velocities": [-3.849870379940408, 2.925307694961165],
        "solver.tolerance": 1e-6,
    }
    result = simulate(load_scene("pinned_arm").with_values(swing), 0.8, sensitivities=["link[1].mass"])
    assert np.isnan(result.sensitivity("joint[1].peak_time", "link[1].mass")[-1])


@pytest.mark.parametrize(
    ("name", "wall", "parameter", "stop"),
    [
        ("box", "y_min", "link[4].mass", 0.505),
        ("friction", "y_min", "link[4].mass", 0.505),
        ("held", "ramp", "link[1].mass", 0.36),
    ],
)
def test_derivatives_of_a_walls_load_equal_differences(name, wall, parameter, stop):
    scene, change = loaded(name, **{"solver.tolerance": 1e-11}), 1e-5
    value, inputs = scene.values[parameter], PUSHED if scene.inputs.tip_force else {}
    options = {"stop_time": stop, "output_step": 1e-4, "inputs": inputs}
    result = simulate(scene, sensitivities=[parameter], **options)
    names = [f"wall.{wall}.load.x", f"wall.{wall}.load.y", f"wall.{wall}.load_moment"]

    def changed(number):
        varied = simulate(scene.with_values({parameter: number}), **options)
        return np.array([varied[name] for name in names])

    assert sum(result[output].any() for output in names) == (2 if name == "box" else 3)
    for output, expected in zip(names, slope(changed, value, change), strict=True):
        derivative = result.sensitivity(output, parameter)
        assert np.abs(derivative - expected).max() <= 2e-6 * np.abs(expected).max()

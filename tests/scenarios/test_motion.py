"""A moving base and moving walls, against other frames, exact maps, integrations and differences."""

import math
import pickle

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import Chain, SceneError, SceneWarning, SimulationError, simulate
from chain_impact.fmu.references import reference_results
from chain_impact.pages.recorded import data_of_page
from chain_impact.pictures.film.film import Film
from chain_impact.scene.scene import scene_from_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.models import driven
from tests.helpers.scenes.moving_scenes import LAWS, LINKS, G, pendulum, resting, room, scene_of, unbalanced


@pytest.mark.parametrize("armature", [0.0, 0.05])
def test_a_base_with_constant_acceleration_is_another_gravity(armature):
    links = [link | {"joint_armature": armature} for link in LINKS]
    scene = scene_of(links, base="pinned", initial={"position": [0.1, 0.2], "angles": [-1.0, -0.4]})
    moved = simulate(
        scene, inputs={"base.x": lambda t: 0.1 + 0.65 * t * t, "base.y": lambda t: 0.2 + 0.35 * t * t}
    )
    still = simulate(scene.with_values({"gravity.x": -1.3, "gravity.y": -G - 0.7}))
    for output in ("link[1].angle", "link[2].angle", "link[2].angular_velocity"):
        assert np.abs(moved[output] - still[output]).max() < 1e-10
    assert np.abs(moved["point[0].x"] - 0.1 - 0.65 * moved.time**2).max() < 1e-14
    assert unbalanced(moved) < 1e-10


def test_a_shaken_pendulum_is_that_of_an_independent_integration():
    amplitude, rate, length = 0.05, 40.0, 0.5
    scene = scene_of(LINKS[:1], base="pinned", initial={"angles": [1.4]})
    result = simulate(scene, inputs={"base.y": lambda t: amplitude * math.sin(rate * t)})
    exact, _ = driven.pendulum(result.time, [1.4, 0.0], amplitude, rate, length)
    assert np.abs(result["link[1].angle"] - exact).max() < 1e-9
    assert unbalanced(result) < 1e-8
    assert np.ptp(result["energy.total"]) > 1.0


@pytest.mark.parametrize("model", LAWS)
def test_walls_at_constant_velocity_are_walls_at_rest_in_another_frame(model):
    up, inward = 0.3, 0.2
    moved = simulate(
        room(model),
        inputs={"wall.y_min.displacement": lambda t: up * t, "wall.x_max.velocity": inward},
    )
    still = simulate(room(model, velocity=(0.5 + inward, -up)))
    assert len(moved.impacts) == len(still.impacts) > 4
    assert np.abs(moved.impacts["onset"] - still.impacts["onset"]).max() < 1e-11
    for name in ("impact_speed", "peak_force", "impulse"):
        assert moved.impacts[name] == pytest.approx(still.impacts[name], rel=1e-8)
    assert np.abs(moved["link[2].angle"] - still["link[2].angle"]).max() < 1e-10
    assert np.abs(moved["point[0].y"] - still["point[0].y"] - up * moved.time).max() < 1e-11
    assert unbalanced(moved) < 1e-9
    assert moved["energy.supplied"][-1] > 1.0


def on_a_ramp(velocity, method, model, friction):
    """Return a free chain that falls on a wall at an angle, which may move."""
    return scene_of(
        walls=[{"name": "ramp", "point": [0.3, 0.1], "angle": 0.3}],
        contact={"model": model, "stiffness": 1e6, "restitution": 0.5, "friction": friction},
        inputs={"wall_motion": ["ramp"]},
        initial={
            "position": [0.6, 1.0],
            "angles": [0.4, -0.6],
            "velocity": velocity,
            "angular_velocities": [1.0, -2.0],
        },
        solver={"method": method, "tolerance": 1e-11},
    )


@pytest.mark.parametrize(
    ("method", "model", "friction"),
    [
        ("auto", "zhang_sharf", 0.4),
        ("explicit", "newton_impact", 0.0),
        ("implicit", "zhang_sharf", 0.0),
        ("implicit", "zhang_sharf", 0.4),
        ("implicit", "newton_impact", 0.0),
    ],
)
def test_a_wall_at_an_angle_moves_along_its_normal_and_its_belt_along_it(method, model, friction):
    speed, belt = 0.3, 0.5 if friction else 0.0
    normal = np.array([-math.sin(0.3), math.cos(0.3)])
    frame = speed * normal + belt * np.array([normal[1], -normal[0]])
    inputs = {"wall.ramp.velocity": speed, "wall.ramp.belt_speed": belt}
    moved = simulate(on_a_ramp([0.0, 0.0], method, model, friction), inputs=inputs)
    still = simulate(on_a_ramp((-frame).tolist(), method, model, friction))
    assert len(moved.impacts) == len(still.impacts) > 4
    assert np.abs(moved.impacts["onset"] - still.impacts["onset"]).max() < 1e-11
    assert np.abs(moved["link[2].angle"] - still["link[2].angle"]).max() < 1e-9
    assert unbalanced(moved) < 1e-8


def test_a_belt_at_constant_speed_is_a_floor_at_rest_in_another_frame():
    speed = 0.7
    moved = simulate(room(walls=("y_min",), friction=0.4), 1.5, inputs={"wall.y_min.belt_speed": speed})
    still = simulate(room(walls=("y_min",), friction=0.4, velocity=(0.5 - speed, 0.0)), 1.5)
    assert np.abs(moved.impacts["onset"] - still.impacts["onset"]).max() < 1e-11
    assert np.abs(moved["link[1].angle"] - still["link[1].angle"]).max() < 1e-10
    assert np.abs(moved["point[0].x"] - still["point[0].x"] - speed * moved.time).max() < 1e-11
    assert unbalanced(moved) < 1e-9
    assert len(moved.stick_slip) == len(still.stick_slip)


def test_a_ball_on_a_vibrating_table_bounces_as_the_map_has_it():
    amplitude, rate, restitution = 0.01, 30.0, 0.8
    scene = scene_of(
        [{"length": 0.1, "mass": 1.0, "center_of_mass": 0.0, "inertia": 1e-3}],
        box={"y_min": 0.0},
        contact={"model": "newton_impact", "restitution": restitution, "points": [0]},
        inputs={"wall_motion": ["y_min"]},
        initial={"position": [0.0, 0.1], "angles": [math.pi / 2]},
    )
    result = simulate(scene, inputs={"wall.y_min.displacement": lambda t: amplitude * math.sin(rate * t)})
    onsets = driven.table_impacts((0.1, 0.0), amplitude, rate, restitution, 10)
    assert np.abs(result.impacts["onset"][:10] - onsets).max() < 1e-11
    assert unbalanced(result) < 1e-10


@pytest.mark.parametrize("model", ["newton_impact", "flores"])
def test_a_chain_at_rest_on_an_accelerating_floor_does_not_creep(model):
    def height(t):
        return 0.5 * (1.0 - np.cos(0.01 * t))

    result = simulate(resting(model), inputs={"wall.y_min.displacement": height})
    gap = (result["point[0].y"] - height(result.time))[100:]
    # a wall with a force law deforms where it accelerates: δ = (m (g + a)/2K)^(2/3)
    acceleration = 0.5 * 1e-4 * np.cos(0.01 * result.time[100:])
    depth = 0.0 if model == "newton_impact" else (0.5 * (G + acceleration) / 1e6) ** (2 / 3)
    assert np.abs(gap + depth).max() < (1e-12 if model == "newton_impact" else 1e-11)
    assert unbalanced(result) < 1e-8


@pytest.mark.parametrize("rate", [0.01, 1.0])
def test_a_point_that_sticks_to_an_accelerating_belt_does_not_creep(rate):
    scene = resting("flores", friction=0.5, stop=36.0 / rate)
    result = simulate(scene, inputs={"wall.y_min.belt_speed": lambda t: 0.5 * rate * np.sin(rate * t)})
    apart = (result["point[1].x"] - 0.5 * (1.0 - np.cos(rate * result.time)))[100:]
    assert np.ptp(apart) < 1e-12
    assert result["contact[0].y_min.sticking"][100:].all()


def test_the_speed_of_a_belt_may_jump():
    scene = resting("flores", friction=0.5, stop=2.0)
    result = simulate(scene, inputs={"wall.y_min.belt_speed": ([0.0, 1.0], [0.0, 0.4])})
    # the body slides with µ g until it has the speed of the belt
    lasted = 0.4 / (0.5 * G)
    assert np.interp(1.0 + 0.5 * lasted, result.time, result["point[0].vx"]) == pytest.approx(0.2, rel=0.02)
    assert result["point[0].vx"][-1] == pytest.approx(0.4, abs=1e-9)
    assert result["point[0].x"][-1] == pytest.approx(0.4 - 0.2 * lasted, abs=1e-6)
    assert unbalanced(result) < 1e-6


REFUSED = {
    "jump of the position": (lambda t: 0.1 * (t > 0.5), "the position jumps at t = 0.5 s.*give a velocity"),
    "kink": (lambda t: abs(t - 0.5), "the velocity jumps at t = 0.5 s.*give a velocity"),
    "no number": (lambda _: math.nan, "returned nan"),
}


@pytest.mark.parametrize("why", REFUSED)
def test_a_motion_that_jumps_is_refused(why):
    function, sentence = REFUSED[why]
    with pytest.raises(SceneError, match=sentence):
        simulate(room(), inputs={"wall.y_min.displacement": function})


def test_a_wall_that_is_given_a_jump_between_steps_is_refused():
    chain = Chain(room())
    chain.step(0.01)
    chain.set("wall.y_min.displacement", 0.1)
    with pytest.raises(SimulationError, match=r"give its velocity, too: point 0 at the wall y_min") as caught:
        chain.step(0.01)
    assert caught.value.part == pickle.loads(pickle.dumps(caught.value)).part == "point 0 at the wall y_min"


def test_a_velocity_that_contradicts_its_position_is_warned_of():
    with pytest.warns(SceneWarning, match=r"wall.y_min.velocity = 0.5 contradicts .* gives 0.01"):
        simulate(room(), inputs={"wall.y_min.displacement": lambda t: 0.01 * t, "wall.y_min.velocity": 0.5})


@pytest.mark.parametrize("inputs", [{"base.y": lambda t: 0.2 - t}, {"wall.y_min.velocity": 1.0}])
def test_a_wall_does_not_move_through_a_pinned_base(inputs):
    scene = pendulum(box={"y_min": -1.0}, inputs={"base_motion": True, "wall_motion": ["y_min"]})
    with pytest.raises(SimulationError, match=r"the base is beyond a wall.*: the base at the wall "):
        simulate(scene, 2.0, inputs=inputs)


def test_motions_that_are_not_asked_for_are_refused():
    scene = pendulum(inputs={})
    with pytest.raises(
        SceneError, match=r"'base.x' is not an input of this scene; set inputs.base_motion = true"
    ):
        simulate(scene, inputs={"base.x": 1.0})
    with pytest.raises(SceneError, match="there is no wall floor"):
        simulate(scene, inputs={"wall.floor.velocity": 1.0})
    with pytest.raises(SceneError, match=r"base\.x is not a variable"):
        Chain(scene).set("base.x", 1.0)


BAD_SCENES = {
    "a free base": (
        {"base": "free", "inputs": {"base_motion": True}},
        "must be false: inputs can move a base only",
    ),
    "no such wall": (
        {"inputs": {"wall_motion": ["y_max"]}},
        "'y_max' is not a wall of the scene; must be one of y_min",
    ),
    "no list": ({"inputs": {"wall_motion": "yes"}}, "must be a list of names, or true for all"),
}


@pytest.mark.parametrize("case", BAD_SCENES)
def test_scenes_that_cannot_move_so_are_refused(case):
    options, sentence = BAD_SCENES[case]
    with pytest.raises(SceneError, match=sentence):
        scene_of(box={"y_min": -1.0}, initial={"angles": [0.0, 0.0]}, **options)


def test_walls_are_drawn_where_they_are(tmp_path):
    def height(t):
        return 0.2 * math.sin(4.0 * t)

    inputs = {"wall.y_min.displacement": height, "wall.y_min.belt_speed": 0.7, "wall.x_max.velocity": 0.3}
    result = simulate(room("flores", friction=0.3), inputs=inputs)
    assert result["wall.y_min.position"] == pytest.approx([height(t) for t in result.time], abs=1e-13)
    assert result["wall.y_min.belt_position"] == pytest.approx(0.7 * result.time)
    walls = result.walls_at(0.5)
    assert walls["y_min"].offset == pytest.approx(height(0.5))
    assert walls["x_max"].offset == pytest.approx(-2.0 + 0.15)
    moved_walls = data_of_page(result)["moved"]
    assert (moved_walls["y_min"]["low"], moved_walls["y_min"]["high"]) == pytest.approx(
        (0.2 * math.sin(4.0), 0.2), abs=1e-3
    )
    result.plot(tmp_path / "motion.png")
    film = Film(Figure(figsize=(9.6, 5.4)), result, np.array([0.0, 0.4]))
    floors = []
    for frame in (0, 1):
        list(film.show(frame, 1.0))
        floors.append(min(line.get_ydata()[0] for line in film.room if hasattr(line, "get_ydata")))
    assert floors == pytest.approx([0.0, height(0.4)])


def test_reference_results_have_velocities_of_their_motions(recwarn):
    scene = pendulum(box={"y_min": -1.0}, inputs={"base_motion": True, "wall_motion": True})
    result = reference_results(PreparedScene(scene))
    assert not [warning for warning in recwarn if warning.category is SceneWarning]
    assert len(result.times) > 50
    step, inputs = result.times[1], result.inputs
    for position, velocity in (("base.y", "base.vy"), ("wall.y_min.displacement", "wall.y_min.velocity")):
        slope = np.gradient(inputs[position], step, edge_order=2)
        assert slope == pytest.approx(inputs[velocity], abs=0.02 * np.abs(slope).max())


@pytest.mark.parametrize("speed", [0.5, 0.05])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_rigid_walls_that_leave_no_room_end_the_run(speed, restitution):
    """A rod lies along x between two walls, and one wall moves in until the rod has no room."""
    tables = {
        "name": "Press",
        "gravity": [0.0, 0.0],
        "chain": {"links": [{"length": 1.0, "mass": 1.0}]},
        "box": {"x_min": 0.0, "x_max": 1.2},
        "contact": {"model": "newton_impact", "restitution": restitution},
        "inputs": {"wall_motion": ["x_max"]},
        "initial": {"position": [0.1, 0.0], "angles": [0.0]},
    }
    scene, shut = scene_from_dict(tables, "press"), 0.2 / speed
    with pytest.raises(SimulationError, match="squeezed") as caught:
        simulate(scene, 2.0 * shut, inputs={"wall.x_max.velocity": speed})
    assert caught.value.result.time[-1] == pytest.approx(shut, abs=2e-3)

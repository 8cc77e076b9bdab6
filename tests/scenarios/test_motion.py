"""A moving base and moving walls, against other frames, exact maps, integrations and differences."""

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import Chain, SceneError, SceneWarning, SimulationError, load_scene, simulate
from chain_impact.fmu.references import reference
from chain_impact.pages.recorded import data
from chain_impact.pictures.film_figure import Film
from chain_impact.scene.scene import scene_from_dict
from chain_impact.variables.prepared import PreparedScene
from tests.helpers import driven

G = 9.81
LINKS = ({"length": 0.5, "mass": 1.0}, {"length": 0.4, "mass": 0.7})
LAWS = ("zhang_sharf", "jankowski", "newton_impact")


def scene_of(links=LINKS, *, base="free", box=None, contact=None, inputs=None, **others):
    """Return a scene; ``others`` are more of its tables, by their keys."""
    tables = {"solver": {"tolerance": 1e-12}, "simulation": {"stop_time": 1.0, "step_size": 0.01}}
    for name, table in others.items():
        tables[name] = tables.get(name, {}) | table if isinstance(table, dict) else table
    chain = {"base": base, "links": [dict(link) for link in links]}
    inputs = {"base_motion": True} if inputs is None else inputs
    data = {"name": "Moves", "chain": chain, "box": box or {}, "contact": contact or {}, "inputs": inputs}
    return scene_from_dict(data | tables, "moves")


def pendulum(**others):
    """Return two links that hang from a base that moves."""
    others.setdefault("initial", {"position": [0.1, 0.2], "angles": [-1.0, -0.4]})
    return scene_of(base="pinned", **others)


def room(model="zhang_sharf", velocity=(0.5, 0.0), walls=("y_min", "x_max"), **contact):
    """Return a free chain that falls to a floor and against a wall, both of which may move."""
    return scene_of(
        box={"y_min": 0.0, "x_max": 2.0} if "x_max" in walls else {"y_min": 0.0},
        contact={"model": model, "stiffness": 1e6, "restitution": 0.6} | contact,
        inputs={"wall_motion": list(walls)},
        initial={
            "position": [0.6, 1.0],
            "angles": [0.4, -0.6],
            "velocity": list(velocity),
            "angular_velocities": [1.0, -2.0],
        },
    )


def resting(model, *, friction=0.0, stop=3600.0, **others):
    """Return a rod that lies on a floor that moves."""
    return scene_of(
        LINKS[:1],
        box={"y_min": 0.0},
        contact={"model": model, "stiffness": 1e6, "restitution": 0.3, "friction": friction},
        inputs={"wall_motion": True},
        solver={"tolerance": 1e-8},
        simulation={"stop_time": stop, "step_size": stop / 600.0},
        initial={"angles": [0.0]},
        **others,
    )


def unbalanced(result):
    """Return the largest change of the energy balance [J]."""
    return np.ptp(result["energy.total"] + result["energy.dissipated"] - result["energy.supplied"])


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
def test_what_rests_on_a_floor_that_accelerates_does_not_creep(model):
    def height(t):
        return 0.5 * (1.0 - np.cos(0.01 * t))

    result = simulate(resting(model), inputs={"wall.y_min.displacement": height})
    gap = (result["point[0].y"] - height(result.time))[100:]
    # a compliant wall deforms where it accelerates: δ = (m (g + a)/2K)^(2/3)
    acceleration = 0.5 * 1e-4 * np.cos(0.01 * result.time[100:])
    depth = 0.0 if model == "newton_impact" else (0.5 * (G + acceleration) / 1e6) ** (2 / 3)
    assert np.abs(gap + depth).max() < (1e-12 if model == "newton_impact" else 1e-11)
    assert unbalanced(result) < 1e-8


@pytest.mark.parametrize("rate", [0.01, 1.0])
def test_what_sticks_to_a_belt_that_accelerates_does_not_creep(rate):
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


def shaken(time, amplitude=0.05, rate=5.0):
    """Return position, velocity and acceleration of a base."""
    angle = rate * time
    return (
        0.1 + amplitude * math.sin(angle),
        amplitude * rate * math.cos(angle),
        -amplitude * rate**2 * math.sin(angle),
    )


def stepped(scene, step, count, given, names=("base.x", "base.vx", "base.ax")):
    """Return the chain after each step, as a master steps it that gives a motion at communication points."""
    chain, rows = Chain(scene), []
    for k in range(count):
        chain.set(dict(zip(names, given(k * step), strict=False)))
        chain.step_to((k + 1) * step)
        rows.append((chain.time, *chain.get(["point[0].x", "point[0].vx", "link[1].angle"])))
    return np.array(rows).T


def test_a_constant_acceleration_is_followed_exactly_from_communication_points():
    time, x, _, angle = stepped(pendulum(), 0.01, 100, lambda t: (0.1 + 0.65 * t * t, 1.3 * t, 1.3))
    still = simulate(pendulum().with_values({"gravity.x": -1.3}))
    assert np.abs(x - 0.1 - 0.65 * time**2).max() < 1e-14
    assert np.abs(angle - still["link[1].angle"][1:]).max() < 1e-11


@pytest.mark.parametrize(("names", "order"), [(3, 3), (2, 2)])
def test_a_smooth_motion_is_followed_with_an_error_that_falls_with_the_step(names, order):
    errors = []
    for step in (0.02, 0.01):
        given = ("base.x", "base.vx", "base.ax")[:names]
        time, x, _, _ = stepped(pendulum(), step, round(1 / step), lambda t: shaken(t)[:names], given)
        errors.append(np.abs(x - 0.1 - 0.05 * np.sin(5.0 * time)).max())
    assert errors[0] / errors[1] == pytest.approx(2**order, rel=0.1)


def test_a_position_alone_is_followed_with_a_warning():
    chain = Chain(pendulum())
    chain.set("base.x", shaken(0.0)[0])
    chain.step_to(0.01)
    chain.set("base.x", shaken(0.01)[0])
    with pytest.warns(
        SceneWarning, match=r"base\.x has been moved by 0.0024.* in 0.01 s, .* velocity of 0 m/s"
    ):
        chain.step_to(0.02)
    for k in range(2, 100):
        chain.set("base.x", shaken(0.01 * k)[0])
        chain.step_to(0.01 * (k + 1))
    assert chain.get("point[0].x") == pytest.approx(shaken(1.0)[0], abs=2e-4)
    assert chain.get("point[0].vx") == pytest.approx(shaken(1.0)[1], abs=2e-2)


def test_a_motion_does_not_drift_in_an_hour():
    slow = [0.05, 0.05]
    time, x, _, _ = stepped(pendulum(), 1.0, 3600, lambda t: shaken(t, *slow))
    assert np.abs(x - 0.1 - 0.05 * np.sin(0.05 * time))[-100:].max() < 2e-6


def test_held_inputs_are_followed_as_by_a_chain_that_is_stepped():
    inputs = {name: (lambda t, k=k: shaken(t)[k]) for k, name in enumerate(("base.x", "base.vx"))}
    result = simulate(pendulum(), inputs=inputs, interpolation="hold")
    _, _, _, angle = stepped(pendulum(), 0.01, 100, lambda t: shaken(t)[:2], ("base.x", "base.vx"))
    assert (result["link[1].angle"][1:] == angle).all()


def test_a_saved_state_goes_on_bit_by_bit():
    chain = Chain(pendulum())
    chain.set({"base.vx": 0.3, "base.ax": -0.4})
    chain.step(0.05)
    state = chain.save()
    chain.step(0.05)
    before = chain.get("*")
    chain.restore(state)
    chain.step(0.05)
    assert (chain.get("*") == before).all()


def test_samples_of_a_position_are_joined_smoothly():
    times = np.linspace(0.0, 1.0, 201)
    sampled = simulate(pendulum(), inputs={"base.x": (times, 0.1 + 0.05 * np.sin(5.0 * times))})
    exact = simulate(pendulum(), inputs={"base.x": lambda t: shaken(t)[0]})
    assert np.abs(sampled["link[1].angle"] - exact["link[1].angle"]).max() < 1e-7


def test_a_velocity_alone_is_integrated():
    exact = simulate(pendulum(), inputs={"base.x": lambda t: shaken(t)[0]})
    inputs = {"base.vx": lambda t: shaken(t)[1]}
    assert np.abs(simulate(pendulum(), inputs=inputs)["link[1].angle"] - exact["link[1].angle"]).max() < 1e-10


VARIED = ("link[1].mass", "contact.stiffness", "wall.y_min.displacement", "wall.y_min.velocity")


@pytest.mark.parametrize("model", ["zhang_sharf", "newton_impact"])
def test_derivatives_of_a_bounce_on_a_moving_floor_are_those_of_differences(model):
    names = [name for name in VARIED if model != "newton_impact" or name != "contact.stiffness"]
    scene = room(model, walls=("y_min",))

    def height(t):
        return 0.02 * math.sin(7.0 * t)

    def run(changed=None, by=0.0, **options):
        inputs = {
            "wall.y_min.displacement": lambda t: (
                height(t) + by * {"wall.y_min.displacement": 1.0, "wall.y_min.velocity": t}.get(changed, 0.0)
            )
        }
        value = {changed: scene.values[changed] + by} if changed in scene.values else {}
        return simulate(scene.with_values(value), 0.5, inputs=inputs, **options)

    result = run(sensitivities=names)
    assert len(result.impacts) >= 1
    for name in names:
        step = 3e-3 * max(abs(scene.values.get(name) or 0.0), 0.01)
        slope = sum(
            factor * (run(name, k * step)["link[2].angle"] - run(name, -k * step)["link[2].angle"])
            for k, factor in ((1, 45.0), (2, -9.0), (3, 1.0))
        ) / (60.0 * step)
        found = result.sensitivity("link[2].angle", name)
        assert np.abs(found - slope)[-1] < 1e-8 * max(1.0, np.abs(slope).max()), name


def test_the_derivative_by_the_position_of_a_base_moves_all_points():
    result = simulate(
        pendulum(), inputs={"base.x": lambda t: shaken(t)[0]}, sensitivities=["base.*", "initial.x"]
    )
    assert result.sensitivity("point[2].x", "base.x") == pytest.approx(1.0)
    assert result.sensitivity("link[1].angle", "base.x") == pytest.approx(0.0)
    assert result.sensitivity("point[0].x", "base.vx") == pytest.approx(result.time)
    gravity = simulate(pendulum(), inputs={"base.x": lambda t: shaken(t)[0]}, sensitivities=["gravity.x"])
    assert result.sensitivity("link[2].angle", "base.ax") == pytest.approx(
        -gravity.sensitivity("link[2].angle", "gravity.x"), abs=1e-9
    )


def test_an_initial_position_is_that_of_a_base_that_moves():
    chain = Chain(pendulum())
    chain.set("initial.x", 0.7)
    assert chain.get(["base.x", "point[0].x"]) == pytest.approx([0.7, 0.7])
    chain.set("base.x", 0.4)
    assert chain.get("point[0].x") == pytest.approx(0.4)


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
    with pytest.raises(SimulationError, match=r"give its velocity, too: point 0 at the wall y_min"):
        chain.step(0.01)


def test_a_velocity_that_contradicts_its_position_is_warned_of():
    with pytest.warns(SceneWarning, match=r"wall.y_min.velocity = 0.5 contradicts .* derivative is 0.01"):
        simulate(room(), inputs={"wall.y_min.displacement": lambda t: 0.01 * t, "wall.y_min.velocity": 0.5})


@pytest.mark.parametrize("inputs", [{"base.y": lambda t: 0.2 - t}, {"wall.y_min.velocity": 1.0}])
def test_a_wall_does_not_move_through_a_pinned_base(inputs):
    scene = pendulum(box={"y_min": -1.0}, inputs={"base_motion": True, "wall_motion": ["y_min"]})
    with pytest.raises(SimulationError, match=r"the pinned base is beyond a wall.*: the base at the wall "):
        simulate(scene, 2.0, inputs=inputs)


def test_motions_that_are_not_asked_for_are_refused():
    scene = pendulum(inputs={})
    with pytest.raises(
        SceneError, match=r"'base.x' is no input of this scene; inputs.base_motion = true makes"
    ):
        simulate(scene, inputs={"base.x": 1.0})
    with pytest.raises(SceneError, match=r'inputs.wall_motion = \["floor"\] makes it'):
        simulate(scene, inputs={"wall.floor.velocity": 1.0})
    with pytest.raises(SceneError, match=r"base\.x is no variable"):
        Chain(scene).set("base.x", 1.0)


BAD_SCENES = {
    "a free base": ({"base": "free", "inputs": {"base_motion": True}}, "must be false for a free base"),
    "no such wall": (
        {"inputs": {"wall_motion": ["y_max"]}},
        "'y_max' is no wall of the scene; must be one of y_min",
    ),
    "no list": ({"inputs": {"wall_motion": "yes"}}, "must be a list of names, or true for all"),
}


@pytest.mark.parametrize("what", BAD_SCENES)
def test_scenes_that_cannot_move_so_are_refused(what):
    options, sentence = BAD_SCENES[what]
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
    seen = data(result)["moved"]
    assert (seen["y_min"]["low"], seen["y_min"]["high"]) == pytest.approx(
        (0.2 * math.sin(4.0), 0.2), abs=1e-3
    )
    result.plot(tmp_path / "motion.png")
    film = Film(Figure(figsize=(9.6, 5.4)), result, np.array([0.0, 0.4]))
    floors = []
    for frame in (0, 1):
        list(film.show(frame, 1.0))
        floors.append(min(line.get_ydata()[0] for line in film.room if hasattr(line, "get_ydata")))
    assert floors == pytest.approx([0.0, height(0.4)])


def test_velocities_that_are_given_without_positions_are_integrated():
    chain, step = Chain(room(walls=("y_min",))), 1.0 / 128
    found = []
    for speed in (0.1, 0.3, 0.0):
        chain.set("wall.y_min.velocity", speed)
        for _ in range(8):
            chain.step(step)
        found.append(chain.get("wall.y_min.position"))
    # the first velocity acts at once, and each other velocity after one step
    assert np.diff(found) == pytest.approx([0.3 * 8 * step - 0.2 * step / 2, 0.3 * step / 2], abs=1e-15)
    assert found[0] == pytest.approx(0.1 * 8 * step, abs=1e-15)
    chain.set({"wall.y_min.displacement": found[-1] + 0.001, "wall.y_min.velocity": 0.1})
    for _ in range(8):
        chain.step(step)
    assert chain.get("wall.y_min.position") == pytest.approx(found[-1] + 0.001 + 0.1 * 8 * step, abs=1e-15)


def test_an_acceleration_that_is_given_alone_changes_the_velocity():
    chain = Chain(pendulum())
    for acceleration, count in ((2.0, 8), (-1.0, 16), (0.0, 8)):
        chain.set("base.ax", acceleration)
        for _ in range(count):
            chain.step(1.0 / 64)
    # v = 0.25 after 1/8 s, and 0 after another 1/4 s
    assert chain.get("point[0].vx") == pytest.approx(0.0, abs=1e-14)
    assert chain.get("point[0].x") == pytest.approx(0.1 + 0.5 * 0.25 / 8 + 0.5 * 0.25 / 4, abs=1e-14)


def test_the_reference_results_of_an_fmu_have_motions_that_agree_with_their_velocities(recwarn):
    scene = pendulum(box={"y_min": -1.0}, inputs={"base_motion": True, "wall_motion": True})
    found = reference(PreparedScene(scene))
    assert not [one for one in recwarn if one.category is SceneWarning]
    assert len(found.times) > 50
    step, inputs = found.times[1], found.inputs
    for position, velocity in (("base.y", "base.vy"), ("wall.y_min.displacement", "wall.y_min.velocity")):
        slope = np.gradient(inputs[position], step, edge_order=2)
        assert slope == pytest.approx(inputs[velocity], abs=0.02 * np.abs(slope).max())


PROFILES = {
    "smoothstep": ("base.x", lambda s: 0.1 * (3.0 * s**2 - 2.0 * s**3)),
    "quintic": ("base.x", lambda s: 0.1 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)),
    "versine": ("base.x", lambda s: 0.05 * (1.0 - math.cos(math.pi * s))),
    "trapezoid": ("base.vx", lambda s: 0.1 * min(1.0, 4.0 * s, 4.0 * (1.0 - s))),
    "step of acceleration": ("base.ax", lambda s: 1.0 if s < 1.0 else 0.0),
}


@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize("until", [0.1, 0.37, 0.5])
def test_profiles_of_machines_whose_acceleration_jumps_are_followed(name, until):
    """A continuous velocity does not jump at its kinks."""
    signal, course = PROFILES[name]
    scene = load_scene("pinned_arm").with_values({"inputs.base_motion": True})
    inputs = {signal: lambda time: course(min(time / until, 1.0))}
    result = simulate(scene, 0.6, inputs=inputs, output_step=0.1)
    if signal == "base.x":
        assert result["point[0].x"][-1] == pytest.approx(course(1.0), abs=1e-9)
    else:
        assert result["point[0].vx"][-1] == pytest.approx(0.0 if signal == "base.vx" else until, abs=1e-6)


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

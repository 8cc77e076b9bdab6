"""Signals of a scene: motions against the same functions in Python, derivatives against differences."""

# Tests: kernel/chain/signals.py, kernel/events/segments.py
# Tests: scene/signal_polynomials.py, variables/signal_filling.py

import math

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline, PPoly

from chain_impact import Chain, SceneError, simulate
from chain_impact.kernel.chain.prescribed_motion import travel_of_sines
from chain_impact.kernel.chain.signals import rate_in_limited_drives, rate_of_signals
from chain_impact.scene.scene import parse_scene
from chain_impact.scene.signal_polynomials import spline_of_position, start_value_of_signal
from chain_impact.simulation.derivatives import DifferentiatedRun
from tests.helpers.kernel.plain import initialized
from tests.helpers.scenes.signal_arm import ARM, HEIGHT, PUSH, TABLE, TARGET, TIMES, TORQUE, with_table
from tests.helpers.tools.differences import slope


def smooth(x):
    x = min(max(x, 0.0), 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x)


def chirp(time, start=0.1, rise=0.2):
    s = max(0.0, time - start)
    return 0.2 + 0.5 * smooth(s / rise) * math.sin(0.3 + 2.0 * math.pi * (5.0 * s + 0.5 * 20.0 * s * s))


def trapezoid(time):
    x = min(max((time - 0.1037) / 0.2913, 0.0), 1.0)
    if x < 1.0 / 3.0:
        part = 2.25 * x * x
    elif x < 2.0 / 3.0:
        part = 0.25 + 1.5 * (x - 1.0 / 3.0)
    else:
        part = 1.0 - 2.25 * (1.0 - x) ** 2
    return 0.05 * part


FORMS = {
    "constant": (TORQUE, 'form = "constant"\nvalue = 0.4', lambda _: 0.4),
    "chirp": (
        PUSH,
        'form = "sine"\nmean = 0.2\namplitude = 0.5\nfrequency = 5.0\nfrequency_rate = 20.0\nphase = 0.3\n'
        "start = 0.1\nrise = 0.2",
        chirp,
    ),
    "smooth": (
        TARGET,
        'form = "ramp"\ninitial = -1.2\nfinal = -0.3\nstart = 0.1\nduration = 0.3',
        lambda t: -1.2 + 0.9 * smooth((t - 0.1) / 0.3),
    ),
    "linear": (
        TORQUE,
        'form = "ramp"\nfinal = 0.7\nstart = 0.15\nduration = 0.2\nshape = "linear"',
        lambda t: 0.7 * min(max((t - 0.15) / 0.2, 0.0), 1.0),
    ),
    "trapezoid": (
        HEIGHT,
        'form = "ramp"\nfinal = 0.05\nstart = 0.1037\nduration = 0.2913\nshape = "trapezoid"',
        trapezoid,
    ),
    "steps": (
        TORQUE,
        'form = "steps"\ntimes = [0.1, 0.2537, 0.4043]\nvalues = [0.0, 0.8, -0.5]',
        lambda t: 0.0 if t < 0.2537 else 0.8 if t < 0.4043 else -0.5,
    ),
    "shaken": (
        HEIGHT,
        'form = "sine"\namplitude = 0.01\nfrequency = 20.0',
        lambda t: 0.01 * math.sin(40.0 * math.pi * t),
    ),
    "belt": (
        "wall.table.belt_speed",
        'form = "sine"\nmean = 0.1\namplitude = 0.5\nfrequency = 6.0\nphase = 0.3\nstart = 0.05\nrise = 0.25',
        lambda t: 0.1 + 0.5 * smooth((t - 0.05) / 0.25) * math.sin(0.3 + 12.0 * math.pi * max(0.0, t - 0.05)),
    ),
    "speed": (
        "base.vy",
        'form = "sine"\namplitude = 0.4\nfrequency = 8.0\nrise = 0.0999',
        lambda t: 0.4 * smooth(t / 0.0999) * math.sin(16.0 * math.pi * t),
    ),
    "sweep": (
        "base.ay",
        'form = "sine"\namplitude = 5.0\nfrequency = 4.0\nfrequency_rate = 25.0\nphase = 1.2\nrise = 0.3',
        lambda t: 5.0 * smooth(t / 0.3) * math.sin(1.2 + 2.0 * math.pi * (4.0 * t + 12.5 * t * t)),
    ),
    "slowing belt": (
        "wall.table.belt_speed",
        'form = "sine"\namplitude = 0.5\nfrequency = 6.0\nfrequency_rate = -20.0\nstart = 0.05',
        lambda t: 0.5 * math.sin(2.0 * math.pi * (6.0 * max(0.0, t - 0.05) - 10.0 * max(0.0, t - 0.05) ** 2)),
    ),
    "table": (
        TABLE,
        'form = "sine"\namplitude = 0.01\nfrequency = 8.0\nphase = 1.5707963267948966\nstart = 0.05',
        lambda t: 0.01 * math.cos(16.0 * math.pi * max(0.0, t - 0.05)),
    ),
}


def signal_scene(name):
    input_name, numbers, _ = FORMS[name]
    return parse_scene(f'{ARM}\n[signals.drive]\ninput = "{input_name}"\n{numbers}\n', "arm.toml")


def rate_of(function):
    """Return a function for the derivative, where the function is smooth."""
    return lambda t: (function(t + 1e-7) - function(t - 1e-7)) / 2e-7


def by_python(name, **settings):
    """Return the run of the arm with a Python function in the place of the signal."""
    input_name, _, function = FORMS[name]
    inputs = {input_name: function}
    if input_name == TARGET:
        # the derivative of 10 x³ − 15 x⁴ + 6 x⁵, times 0.9 rad
        x = lambda t: min(max((t - 0.1) / 0.3, 0.0), 1.0)  # noqa: E731
        inputs["joint[1].target_velocity"] = lambda t: 90.0 * (x(t) * (1.0 - x(t))) ** 2
    return simulate(parse_scene(ARM, "arm.toml"), inputs=inputs, **settings)


@pytest.mark.parametrize("name", FORMS)
def test_a_signal_moves_the_chain_as_the_same_function_in_python_does(name):
    settings = {"tolerance": 1e-12}
    run, run_of_function = simulate(signal_scene(name), **settings), by_python(name, **settings)
    for output in ("link[1].angle", "link[2].angle", "link[2].angular_velocity", "energy.supplied"):
        np.testing.assert_allclose(run[output], run_of_function[output], rtol=0.0, atol=1e-10, err_msg=output)
    np.testing.assert_allclose(run.impacts["onset"], run_of_function.impacts["onset"], rtol=0.0, atol=1e-10)
    input_name, _, function = FORMS[name]
    times = [t - 1e-13 for t in run.time]  # a row at a jump has the value before it
    np.testing.assert_allclose(run[input_name], [function(t) for t in times], rtol=0.0, atol=1e-10)


def at_start(scene, input_name):
    """Return the value of an input at the start, as the checks of a scene compute it."""
    return start_value_of_signal(scene.signals["drive"], input_name, scene.simulation.stop_time)


@pytest.mark.parametrize("name", FORMS)
def test_the_checks_of_a_start_know_what_signals_make_of_it(name):
    input_name = FORMS[name][0]
    scene = signal_scene(name)
    assert at_start(scene, input_name) == simulate(scene, 1e-3)[input_name][0]
    if name in ("smooth", "trapezoid", "chirp"):
        for start in (-0.02, -0.17, -1.0):  # the signal began before the run
            started_scene = scene.with_values({"signal.drive.start": start})
            assert at_start(started_scene, input_name) == simulate(started_scene, 1e-3)[input_name][0]


def test_a_base_and_a_wall_start_where_signals_have_them():
    arm = parse_scene(ARM, "arm.toml")
    base, wall = (
        {("signals", "up"): {"input": input_name, "form": "constant", "value": 0.3}}
        for input_name in (HEIGHT, TABLE)
    )
    # the initial position is inside the wall
    lifted = arm.with_values({("walls", 0, "point"): [0.0, -0.4]} | base)
    assert lifted.start[0][:2] == (0.0, 0.3)
    assert simulate(lifted, 1e-3)["point[2].y"][0] == pytest.approx(lifted.start[2][1], abs=1e-15)
    with pytest.raises(SceneError, match=r"point 2 at \(.*\) m is .* m deep in the wall table"):
        arm.with_values(wall)


NUMBERS = [
    ("constant", "value"),
    *(
        ("chirp", key)
        for key in ("mean", "amplitude", "frequency", "frequency_rate", "phase", "start", "rise")
    ),
    *(("smooth", key) for key in ("initial", "final", "start", "duration")),
    *(("linear", key) for key in ("final", "start", "duration")),
    *(("trapezoid", key) for key in ("final", "start", "duration")),
    *(("steps", key) for key in ("time[2]", "time[3]", "value[1]", "value[2]")),
    *(("shaken", key) for key in ("mean", "amplitude", "frequency", "phase")),
    *(("table", key) for key in ("amplitude", "frequency", "mean")),
    *(("speed", key) for key in ("amplitude", "frequency", "phase", "rise")),
    *(("sweep", key) for key in ("amplitude", "frequency", "frequency_rate", "phase", "rise")),
]


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize(("name", "key"), NUMBERS)
def test_derivatives_by_each_number_are_those_of_differences(name, key):
    scene, parameter, output = signal_scene(name), f"signal.drive.{key}", "link[2].angle"
    run = simulate(scene, tolerance=1e-12, sensitivities=[parameter])
    value = scene.values[parameter]
    step = 1e-5 * max(1.0, abs(value))

    def changed(number):
        return simulate(scene.with_values({parameter: number}), tolerance=1e-13)[output]

    expected = slope(changed, value, step, 4)
    result = run.sensitivity(output, parameter)
    np.testing.assert_allclose(result, expected, rtol=0.0, atol=1e-6 * (np.abs(expected).max() + 1e-2))


@pytest.mark.parametrize("name", ["steps", "trapezoid", "chirp"])
def test_the_communication_step_changes_nothing(name):
    scene = signal_scene(name)
    fine, rough = Chain(scene), Chain(scene)
    for k in range(1, 400):
        fine.step_to(min(0.6, k * 0.0017))
    rough.step_to(0.6)
    names = ["link[1].angle", "link[2].angular_velocity", "energy.supplied", FORMS[name][0]]
    assert fine.get(names).tobytes() == rough.get(names).tobytes()


# ---- tables -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("interpolation", ["hold", "linear"])
@pytest.mark.parametrize("period", [None, 0.3, 0.7])
def test_the_checks_of_a_start_know_what_tables_make_of_it(tmp_path, interpolation, period):
    for begin in (-0.25, 0.0, 0.1, -5.0):
        columns = {"time": begin + np.array([0.0, 0.1, 0.2]), TORQUE: [1.0, 3.0, -2.0]}
        numbers = f'interpolation = "{interpolation}"\n' + (f"period = {period}" if period else "")
        scene = with_table(tmp_path, [TORQUE], columns, numbers)
        assert at_start(scene, TORQUE) == simulate(scene, 1e-3)[TORQUE][0]


def test_a_wall_that_a_spline_moves_starts_where_the_spline_has_it(tmp_path):
    # linear interpolation between the rows would put the table 2 cm above point 2
    columns = {"time": [-0.3, -0.1, 0.1, 0.7], TABLE: [0.5, 0.16, 0.16, 0.5]}
    scene = with_table(tmp_path, [TABLE], columns, "")
    assert at_start(scene, TABLE) == simulate(scene, 0.01)[TABLE][0]


@pytest.mark.parametrize("interpolation", ["hold", "linear"])
def test_a_table_drives_as_samples_do(tmp_path, interpolation):
    values = {TORQUE: np.sin(20.0 * TIMES), PUSH: np.cos(9.0 * TIMES)}
    scene = with_table(tmp_path, values, {"time": TIMES, **values}, f'interpolation = "{interpolation}"')
    run = simulate(scene, tolerance=1e-12)
    kind = "follow" if interpolation == "hold" else "linear"
    inputs = {name: (TIMES, column) for name, column in values.items()}
    run_of_samples = simulate(parse_scene(ARM, "x"), tolerance=1e-12, inputs=inputs, interpolation=kind)
    np.testing.assert_allclose(run["link[2].angle"], run_of_samples["link[2].angle"], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize(("input_name", "order"), [("base.y", 0), ("base.vy", 1), ("base.ay", 2)])
def test_a_base_follows_a_spline_of_its_position_or_integrals(tmp_path, input_name, order):
    times = np.linspace(0.0, 0.6, 25)
    wave = [0.01 * np.sin(12.0 * times), 0.12 * np.cos(12.0 * times), -1.44 * np.sin(12.0 * times)][order]
    scene = with_table(tmp_path, [input_name], {"time": times, input_name: wave}, 'interpolation = "spline"')
    run = simulate(scene, tolerance=1e-12)
    spline = CubicSpline(times, wave)
    for _ in range(order):
        spline = spline.antiderivative()
    for name, k in (("base.y", 0), ("base.vy", 1), ("base.ay", 2)):
        expected = spline(run.time) if k == 0 else spline.derivative(k)(run.time)
        np.testing.assert_allclose(run[name], expected, rtol=0.0, atol=1e-12 * 10.0**k)
    np.testing.assert_allclose(run["point[0].y"], run["base.y"], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("input_name", "numbers", "function"),
    [
        (
            "base.ay",
            'form = "steps"\ntimes = [0.0, 0.3]\nvalues = [1.0, -2.0]',
            lambda t: 1.0 if t < 0.3 else -2.0,
        ),
        (
            "base.vy",
            'form = "ramp"\nfinal = -0.3\nstart = 0.05\nduration = 0.1\nshape = "linear"',
            lambda t: -3.0 * min(0.1, max(0.0, t - 0.05)),
        ),
    ],
)
def test_a_function_with_jumps_and_bends_moves_the_base_as_a_signal_does(input_name, numbers, function):
    signal = f'{ARM}\n[signals.drive]\ninput = "{input_name}"\n{numbers}\n'
    run = simulate(parse_scene(signal, "arm.toml"), tolerance=1e-12)
    run_of_function = simulate(parse_scene(ARM, "arm.toml"), tolerance=1e-12, inputs={input_name: function})
    np.testing.assert_allclose(run_of_function["point[0].y"], run["point[0].y"], rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(run_of_function["link[2].angle"], run["link[2].angle"], rtol=0.0, atol=1e-10)


def test_a_table_moves_the_base_alike_whenever_the_run_ends(tmp_path):
    columns = {"time": [0.1, 0.25, 0.4, 0.55, 0.7], "base.y": [0.0, -0.05, 0.02, 0.0, 0.03]}
    scene = with_table(tmp_path, ["base.y"], columns, "")
    spline = CubicSpline(*columns.values(), bc_type=("clamped", "not-a-knot"))
    for stop, last in ((0.5, 0.5), (0.7, 0.7), (0.9, 0.55)):
        run = simulate(scene, stop_time=stop)
        in_table = run.time <= last
        expected = spline(np.maximum(run.time, 0.1))
        np.testing.assert_allclose(run["base.y"][in_table], expected[in_table], rtol=0.0, atol=1e-14)
    assert run["base.y"][run.time >= 0.7] == pytest.approx(0.03, abs=1e-15)
    assert run["base.vy"][run.time >= 0.7] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("begin", [0.0, 0.1])
def test_the_acceleration_of_a_spline_jumps_only_at_the_ends_of_its_table(begin):
    times = begin + np.array([0.0, 0.13, 0.2, 0.35, 0.4])
    heights = np.array([0.01, -0.05, 0.02, 0.0, 0.03])
    at, powers = spline_of_position(times, heights, 0.9)
    spline = PPoly(powers.T[::-1], at)
    np.testing.assert_allclose(spline(times), heights, rtol=0.0, atol=1e-15)
    for order, size in ((0, 0.05), (1, 1.0), (2, 50.0)):
        left_values, right_values = (spline.derivative(order)(at[1:-1] + side) for side in (-1e-9, 1e-9))
        np.testing.assert_allclose(left_values, right_values, rtol=0.0, atol=1e-6 * size)
    speed = spline.derivative()
    assert speed(at[-1]) == pytest.approx(0.0, abs=1e-13)
    if begin > 0.0:  # otherwise the run begins with the table, and its rows give the velocity
        assert speed(at[0]) == pytest.approx(0.0, abs=1e-15)
    else:
        spline_of_rows = CubicSpline(times, heights)
        assert speed(0.0) == pytest.approx(float(spline_of_rows(0.0, 1)), rel=1e-12)


@pytest.mark.parametrize(
    ("input_name", "size"), [(HEIGHT, 0.02), (TABLE, 0.02), ("base.vy", 0.2), (TORQUE, 1.0)]
)
@pytest.mark.parametrize("times", [TIMES, 0.1 + TIMES, 3.0 * TIMES])
def test_a_spline_of_a_table_is_that_of_samples_in_python(tmp_path, input_name, size, times):
    """Some tables end before the run, with a speed."""
    columns = {"time": times, input_name: size * np.sin(1.0 + 9.0 * times)}
    run = simulate(with_table(tmp_path, [input_name], columns, 'interpolation = "spline"'), tolerance=1e-12)
    arm = parse_scene(ARM, "arm.toml")
    for inputs in (tmp_path / "drive.csv", {input_name: (times, columns[input_name])}):
        run_of_samples = simulate(arm, tolerance=1e-12, inputs=inputs, interpolation="spline")
        for name in ("link[2].angle", "energy.supplied", "point[2].y"):
            np.testing.assert_allclose(run[name], run_of_samples[name], rtol=0.0, atol=1e-10, err_msg=name)
    course = DifferentiatedRun(arm, ["link[1].mass"], ["link[2].angle"], tmp_path / "drive.csv", "spline")
    result = course.run(np.array([0.5]), run.time).values[:, 0]
    np.testing.assert_allclose(result, run["link[2].angle"], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("begin", [-0.35, 0.0, 0.1, 0.45])
@pytest.mark.parametrize("interpolation", ["linear", "spline"])
def test_a_periodic_velocity_begins_with_a_position_of_zero(tmp_path, begin, interpolation):
    times, speeds = begin + np.array([0.0, 0.1, 0.3]), [0.2, -0.1, 0.2]
    numbers = f'period = 0.3\ninterpolation = "{interpolation}"'
    scene = with_table(tmp_path, ["base.vy"], {"time": times, "base.vy": speeds}, numbers)
    run = simulate(scene, output_step=1e-3)
    assert run["base.y"][0] == pytest.approx(0.0, abs=1e-16)
    integral = cumulative_trapezoid(run["base.vy"], x=run.time)
    np.testing.assert_allclose(run["base.y"][1:], integral, rtol=0.0, atol=2e-6)


def test_a_table_repeats_after_its_period(tmp_path):
    times = np.linspace(0.0, 0.2, 21)[:-1]
    wave = 0.01 * np.sin(10.0 * math.pi * times)
    scene = with_table(tmp_path, ["base.y"], {"time": times, "base.y": wave}, "period = 0.2")
    run = simulate(scene, tolerance=1e-10)
    spline = CubicSpline([*times, 0.2], [*wave, wave[0]], bc_type="periodic")
    np.testing.assert_allclose(run["base.y"], spline(run.time % 0.2), rtol=0.0, atol=1e-15)
    belt = with_table(
        tmp_path,
        ["wall.table.belt_speed"],
        {"time": [0.0, 0.1], "wall.table.belt_speed": [0.0, 1.0]},
        'period = 0.2\ninterpolation = "hold"',
    )
    run = simulate(belt)
    # the belt moves 0.1 m in each period
    np.testing.assert_allclose(
        run["wall.table.belt_position"][[10, 20, 40, 55]], [0.0, 0.1, 0.2, 0.25], atol=1e-14
    )


@pytest.mark.parametrize(
    ("input_name", "counts"), [(TORQUE, True), (PUSH, False), ("joint[1].torque", False)]
)
def test_only_sines_that_act_in_a_drive_with_a_limit_make_it_sampled(input_name, counts):
    limited = ARM.replace("joint_damping = 0.1", "joint_damping = 0.1\njoint_torque_limit = 1.0")
    scene = parse_scene(
        f'{limited}\n[signals.drive]\ninput = "{input_name}"\n{FORMS["shaken"][1]}', "arm.toml"
    )
    d = initialized(scene)
    assert rate_of_signals(d) == pytest.approx(40.0 * math.pi)
    assert rate_in_limited_drives(d) == (rate_of_signals(d) if counts else 0.0)


def test_a_smooth_ramp_changes_like_half_a_period_of_a_cosine():
    ramp = 'input = "joint[2].torque"\nform = "ramp"\nfinal = 1.0\nduration = 0.5\nshape = '
    d = initialized(parse_scene(f'{ARM}\n[signals.drive]\n{ramp}"smooth"', "arm.toml"))
    assert rate_of_signals(d) == pytest.approx(math.pi / 0.5)
    d = initialized(parse_scene(f'{ARM}\n[signals.drive]\n{ramp}"trapezoid"', "arm.toml"))
    assert rate_of_signals(d) == 0.0


@pytest.mark.parametrize("input_name", [TORQUE, PUSH, TARGET])
def test_only_sines_that_move_the_base_or_a_wall_have_a_travel(input_name):
    """A torque, a force or an angle is not a length; where a speed is a sine, its integral is the travel."""
    motions = "".join(
        f'[signals.s{k}]\ninput = "{name}"\nform = "sine"\namplitude = {size}\nfrequency = 5.0\n'
        for k, (name, size) in enumerate({input_name: 700.0, TABLE: 0.05, "base.vy": 0.3}.items())
    )
    d = initialized(parse_scene(f"{ARM}\n{motions}", "arm.toml"))
    assert travel_of_sines(d) == pytest.approx(0.05 + 0.3 / (10.0 * math.pi), rel=1e-12)

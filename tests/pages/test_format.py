"""Texts and ticks of numbers on the pages."""

# Tests: pages/browser/base/format.js, pages/browser/base/ticks.js, pages/browser/scene/words.js

import numpy as np
import pytest

from tests.pages.javascript import function_of

ROUND_OFF = function_of("format", "roundOff")
ANGLES = function_of("format", "angles")
TICKS = "([first, step]) => ticksOf([0, 1, 2, 3].map((k) => first + k * step))"
TICKS_BETWEEN = "(ranges) => ranges.map(([low, high]) => ticksBetween(low, high, 3))"


@pytest.mark.parametrize(
    ("first", "step", "expected"),
    [
        (-2e-5, 1e-5, ["-0.00002", "-0.00001", "0", "0.00001"]),
        (0.0, 0.25, ["0", "0.25", "0.50", "0.75"]),
        (-100.0, 50.0, ["-100", "-50", "0", "50"]),
        (1.0, 2e-9, ["1.000000000e+0", "1.000000002e+0", "1.000000004e+0", "1.000000006e+0"]),
        (2e6, 1e6, ["2e+6", "3e+6", "4e+6", "5e+6"]),
    ],
)
def test_ticks_have_the_digits_that_their_distance_needs(script, first, step, expected):
    assert script.evaluate(TICKS, [first, step]) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0,5", "0.5"),
        (" -12,25 deg", " -12.25 deg"),
        ("1,5e6", "1.5e6"),
        (",5", ".5"),
        ("0,125", "0.125"),
        ("1,5", "1.5"),
        ("1,500", "1,500"),
        ("1,500 mm", "1,500 mm"),
        ("2*0,6", "2*0.6"),
        ("1,2,3", "1,2,3"),
        ("0.5", "0.5"),
        ("hertz", "hertz"),
    ],
)
def test_a_decimal_comma_is_a_point_unless_it_may_be_one_of_thousands(script, text, expected):
    assert script.evaluate("withPoint", text) == expected


def test_an_axis_has_three_to_ten_ticks(script):
    ranges = [
        (low * size, high * size)
        for low in (-1, -0.3, 0)
        for high in np.linspace(0.1, 9.9, 50)
        for size in (1e-6, 1, 3e3)
    ]
    ticks_of_ranges = script.evaluate(TICKS_BETWEEN, [[float(end) for end in limits] for limits in ranges])
    for (low, high), ticks in zip(ranges, ticks_of_ranges, strict=True):
        assert 3 <= len(ticks) <= 10
        assert np.ptp(np.diff(ticks)) == pytest.approx(0.0, abs=1e-6 * (high - low))
        assert low - 1e-6 * abs(low) <= ticks[0] < ticks[-1] <= high * (1 + 1e-6)


def test_ticks_of_counts_are_whole_numbers_at_equal_distances(script):
    function = "(ranges) => ranges.map((ends) => ticksBetween(...ends, 3, true))"
    ticks = script.evaluate(function, [[1, 8], [0, 6], [3, 4], [0, 1.1], [0, 250]])
    assert ticks == [[2, 4, 6, 8], [0, 2, 4, 6], [3, 4], [0, 1], [0, 100, 200]]


def test_round_off_of_the_largest_value_is_shown_as_zero(script):
    texts = script.evaluate(ROUND_OFF)
    assert texts == [[[0.5, 0], [1e-11]], [[0]]]


def test_an_angle_is_shown_in_degrees(script):
    pairs, quarter_text, half_text, length_text = script.evaluate(ANGLES)
    values, values_from_texts = zip(*pairs, strict=True)
    assert values_from_texts == pytest.approx(values, rel=1e-4)
    assert (quarter_text, half_text, length_text) == ("-25", "28.648", "3.141592653589793")


def test_a_typed_quantity_may_have_units_and_arithmetic(script):
    cases = [
        ("-90", "rad", -np.pi / 2), ("90\u00b0", "rad", np.pi / 2), ("90 deg/s", "rad/s", np.pi / 2),
        ("1.5 rad", "rad", 1.5), ("120 cm", "m", 1.2), ("35 mm/s", "m/s", 0.035), ("200 g", "kg", 0.2),
        ("2*0.6", "m", 1.2), ("-1/2*-3+1", "1", 2.5), ("1e-3", "s", 1e-3), ("0,5", "1", 0.5),
        ("pi/2", "rad", np.pi / 2), ("-2*pi", "rad/s", -2 * np.pi), ("pi", "m", np.pi),
        ("5 MN/m^1.5", "N/m¹·⁵", 5e6), ("2 kN/mm^1.5", "N/m¹·⁵", 2e3 / 1e-3**1.5), ("5 cm2", "m2", 5e-4),
        ("-1 g", "m/s2", -9.80665), ("2 Nm", "N.m", 2.0), ("2 kNm", "N.m", 2e3), ("3 N m", "N.m", 3.0),
        ("4 Nm/rad", "N.m/rad", 4.0), ("5 kgm²", "kg.m2", 5.0), ("5 g.m2", "kg.m2", 5e-3),
    ]  # fmt: skip
    wrong_cases = [("45 grad", "rad"), ("2 kg", "m"), ("5 N", "N/m¹·⁵"), ("2 3", "m"), ("", "m")]
    values = script.evaluate(
        "(cases) => cases.map(([text, unit]) => typed(text, unit))", [*cases, *wrong_cases]
    )
    assert values[:-5] == pytest.approx([value for *_, value in cases], rel=1e-15)
    assert values[-5:] == [text for text, _ in wrong_cases]


@pytest.mark.parametrize(
    ("speed", "text"),
    [
        (4.972, "4.97 m/s"),
        (0.1, "0.10 m/s"),
        (0.0479, "47.9 mm/s"),
        (0.00263, "2.63 mm/s"),
        (7.35e-4, "735 µm/s"),
        (1.13e-6, "1.13 µm/s"),
        (4e-10, "0.400 nm/s"),
        (1e-13, "0 m/s"),
        (0.0, "0 m/s"),
    ],
)
def test_a_small_speed_or_impulse_has_a_prefix(script, speed, text):
    speed_text = script.evaluate("speed => speedWithUnit(speed, 'm/s')", speed)
    assert speed_text.replace("\u202f", " ") == text
    impulse = script.evaluate("impulse => impulseText({ impulse, atStop: false })", speed)
    assert impulse.split("\u202f")[1] == text.split()[1].replace("m/s", "N·s")


def test_an_axis_by_decades_has_two_ticks_or_more_however_narrow_it_is(script):
    narrow = [[2.2e6, 4.4e6], [6.1e6, 6.4e6]]
    function = "ranges => ranges.map(([low, high]) => decadesBetween(low, high))"
    ticks_of_ranges = script.evaluate(function, [[1e5, 1e11], [2e6, 6e7], *narrow])
    assert ticks_of_ranges[:2] == [[10.0**power for power in range(5, 12)], [2e6, 5e6, 1e7, 2e7, 5e7]]
    for (low, high), ticks in zip(narrow, ticks_of_ranges[2:], strict=True):
        assert len(ticks) > 1
        assert low <= min(ticks) < max(ticks) <= high


@pytest.mark.parametrize(
    ("wall", "text"),
    [("joint_min", "min"), ("slider_max", "max"), ("joint_plate", "joint_plate"), ("y_min", "y_min")],
)
def test_the_list_of_impacts_shortens_the_names_of_stops_only(script, wall, text):
    assert script.evaluate("wall => wallText({ wall })", wall) == text


@pytest.mark.parametrize(
    ("wall", "gravity", "text"),
    [
        ("y_min", [0.0, -9.81], "floor"),
        ("x_max", [0.0, -1.0], "right wall"),
        ("ramp", [0.0, -9.81], None),
        ("y_min", [0.0, 0.0], "lower wall"),
        ("y_max", [0.0, 9.81], "upper wall"),
        ("x_min", [1.0, -9.81], "left wall"),
        ("y_min", [None, None], "lower wall"),
    ],
)
def test_a_wall_of_the_box_is_a_floor_only_where_gravity_points_down(script, wall, gravity, text):
    arguments = [wall, {"gravity.x": gravity[0], "gravity.y": gravity[1]}]
    function = "([wall, values]) => boxWallText(wall, (name) => values[name]) ?? null"
    assert script.evaluate(function, arguments) == text


@pytest.mark.parametrize(
    ("part", "text"),
    [("point 2", "2"), ("point 4 (toe)", "toe"), ("point 12 (a (b))", "a (b)"), ("joint 3", "joint 3")],
)
def test_a_list_has_short_words_for_what_touches(script, part, text):
    assert script.evaluate("what => touchingPartText({ what })", part) == text


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("joint[12].torque", "Torque of joint 12"),
        ("joint[2].target_velocity", "Target velocity of joint 2"),
        ("slider.force", "Force on the slider"),
        ("slider.target_position", "Target position of the slider"),
        ("tip.force.x", "Force on the tip, x"),
        ("base.y", "Position of the base, y"),
        ("base.vx", "Velocity of the base, x"),
        ("base.ay", "Acceleration of the base, y"),
        ("wall.y_min.belt_speed", "Belt speed of the lower wall"),
        ("wall.ramp.displacement", "Displacement of ramp"),
    ],
)
def test_an_input_has_words(script, name, text):
    assert script.evaluate("name => inputText(name, () => undefined)", name) == text


def test_a_wall_of_the_box_has_the_words_that_gravity_gives_it(script):
    function = "(down) => inputText('wall.y_min.displacement', (name) => (name === 'gravity.y' ? down : 0))"
    assert script.evaluate(function, -9.81) == "Displacement of the floor"
    assert script.evaluate(function, 9.81) == "Displacement of the lower wall"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("link[3].joint_damping", "Joint damping of link 3"),
        ("link[2].point[1].x", "X of point 1 of link 2"),
        ("initial.angular_velocity[2]", "Initial angular velocity of link 2"),
        ("initial.vx", "Initial vx"),
        ("gravity.x", "Gravity, x"),
        ("box.y_min", "Box, y_min"),
        ("wall.side_wall.angle", "Angle of wall side_wall"),
        ("slider.force_limit", "Force limit of slider"),
    ],
)
def test_a_parameter_has_words(script, name, text):
    assert script.evaluate("name => parameterText(name)", name) == text

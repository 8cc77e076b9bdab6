"""The computations that exist in Python and in JavaScript: the same inputs give the same values.

The comparisons allow for a few last digits: a compiler may join a product and a sum, and mathematical
libraries round sines differently.
"""

# Tests: pages/drawn_outputs.py, pages/shared.py, pictures/film/arrow_scale.py, pictures/film/film.py
# Tests: scene/display/outlines.py
# Tests: pages/browser/base/map_values.js, pages/browser/base/similar_names.js
# Tests: pages/browser/drawing/arrow_scale.js, pages/browser/explore/map/map_colours.js
# Tests: pages/browser/recording/pacing.js, pages/browser/recording/view.js
# Tests: pages/browser/recording/free_region.js, pages/browser/recording/frames.js
# Tests: pages/browser/charts/energy_zero.js
# Tests: pages/browser/scene/bodies.js, pages/browser/scene/angles.js

import re
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import quickjs

import chain_impact
from chain_impact import load_scene, model_names, simulate
from chain_impact.map_colours import WIDE_COLOURS, colour_ends, count_bins, value_ratio
from chain_impact.pages.assembly import browser_text
from chain_impact.pages.drawn_outputs import GROUPS, drawn_entries
from chain_impact.pages.recorded import data_of_page, free_sides, impacts_of_page
from chain_impact.pictures.drawing.colours import LOAD
from chain_impact.pictures.film.arrow_scale import ArrowScale
from chain_impact.pictures.film.film import FORCE, MUTED
from chain_impact.pictures.over_time.energies import ENERGIES, without_gap
from chain_impact.recording.joint_stops import ranges_of
from chain_impact.recording.pacing import frame_rate, frame_times, rate_text, slow_spans
from chain_impact.recording.view import film_view, free_region_within, pin_lines, positions_of, radius_of
from chain_impact.scene.display.outlines import outlines_from, rail_from
from chain_impact.scene.half_planes import half_planes
from chain_impact.scene.texts.angles import radians_of
from chain_impact.scene.texts.similar_names import proposed_name
from chain_impact.scene.texts.unit_text import stiffness_unit, unit_text
from tests.helpers.campaigns import random_scenes
from tests.helpers.scenes.friction import sled
from tests.helpers.scenes.stops import knee_scene
from tests.pages.in_pages import page_contents
from tests.pages.javascript import function_of

FRAMES = function_of("twins", "framesInPage")
SPANS = "([impacts, stop]) => slowSpans(impactsUntil(impacts, stop))"
VIEW = function_of("twins", "viewInPage")
ROOM = "([walls, around]) => freeRegionWithin(walls, around).corners"
SHAPES = function_of("twins", "shapes")
FRAMES_SHOWN = function_of("twins", "shownInPage")
DRAWN_GROUPS = """(contents) => Object.entries(sceneOf(contents).drawn.groups).map(([group, entries]) =>
  [group, entries.map(({ n, name, words }) => [n, name, Object.keys(words)])])"""
ARROWS = "([peak, forces]) => forces.map((force) => new ArrowScale(peak, 1, 1).lengthOf(force))"
COLOURS = """(values) => {
  const { ends, isLogarithmic } = colourScale(values, false);
  return [ends, isLogarithmic];
}"""
STEPS = """([most, least]) => {
  const { bins, shareOf } = colourScale([most, least], true);
  return [bins, [least, most].map(shareOf)];
}"""


PACKAGE = Path(chain_impact.__file__).parent
ROOT = Path(__file__).parents[2]


def named_twins(pattern, comment, language):
    """Yield (file, twin) for each twin that the first text of a file names; both are paths in the package."""
    sentence = re.compile(rf"The twins? in {language} (?:is|are) (.+)\.$", re.MULTILINE)
    for file in PACKAGE.rglob(pattern):
        if first := re.match(comment, file.read_text("utf-8"), re.DOTALL):
            names = ", ".join(sentence.findall(first[0]))
            yield from (
                (file.relative_to(PACKAGE).as_posix(), name) for name in re.findall(r"[\w/.]+", names)
            )


def test_twins_name_each_other():
    own_pairs = {*named_twins("*.py", r'""".*?"""', "JavaScript")}
    pairs_of_pages = {(twin, file) for file, twin in named_twins("*.js", r"(?://[^\n]*\n)+", "Python")}
    assert len(own_pairs) > 20
    assert own_pairs == pairs_of_pages
    assert {name for pair in own_pairs for name in pair if not (PACKAGE / name).is_file()} == set()


def test_the_list_of_twins_names_the_tests_that_compare_them():
    """A line has a module, its twin, and a test file that names the twin in a line ``# Tests:``."""
    lines = (ROOT / "docs" / "development" / "twins.txt").read_text("utf-8").splitlines()[1:]
    pairs = {
        (module, twin.removeprefix("pages/browser/"))
        for module, twin in named_twins("*.py", r'""".*?"""', "JavaScript")
    }
    assert [tuple(line.split()[:2]) for line in lines] == sorted(pairs)
    for _, twin, test in map(str.split, lines):
        tested_files = re.findall(
            r"^# Tests: (.*)", (Path(__file__).parent / test).read_text("utf-8"), re.MULTILINE
        )
        assert f"pages/browser/{twin}" in ", ".join(tested_files).split(", "), test


def random(seed):
    return np.random.default_rng(seed)


def close(result, expected, rel=1e-12, size=1.0):
    np.testing.assert_allclose(result, expected, rtol=rel, atol=rel * size)


@pytest.mark.parametrize("seed", range(20))
def test_the_times_of_the_frames(script, seed):
    chance = random(seed)
    start, stop = chance.uniform(-1.0, 1.0), chance.uniform(1.1, 9.0)
    onsets = np.sort(chance.uniform(start, stop, chance.integers(0, 12)))
    spans = [(onset, onset + 10.0 ** chance.uniform(-6.0, 0.5)) for onset in onsets.tolist()]
    spans[::3] = [(onset, onset) for onset, _ in spans[::3]]
    impact_time, rate = chance.choice([0.0, 0.2, 0.6]), chance.choice([60.0, 640.0])
    max_frames = int(chance.choice([300, 20_000]))
    times, per_second = frame_times(start, stop, spans, impact_time, max_frames, usual_rate=rate)
    times_in_page, rate_in_page = script.evaluate(FRAMES, [start, stop, spans, impact_time, max_frames, rate])
    close(times_in_page, times)
    close(rate_in_page, per_second)


def test_a_very_long_motion_has_no_more_times_than_frames_need(script):
    times, per_second = frame_times(0.0, 1e9, [(5.0, 5.1)])
    times_in_page, rate_in_page = script.evaluate(FRAMES, [0.0, 1e9, [(5.0, 5.1)], 0.6, 20_000, 60.0])
    assert len(times) == len(times_in_page) == 20_000
    close(times_in_page, times)
    close(rate_in_page, per_second)


@cache
def recorded(model):
    return simulate(load_scene(model))


@pytest.mark.parametrize("model", ["four_link_box", "kneed_leg", "rod_drop", "rocking_block", "pinned_arm"])
def test_the_impacts_that_are_shown_slowly(script, model):
    result = recorded(model)
    spans = script.evaluate(SPANS, [impacts_of_page(result), float(result.time[-1])])
    assert len(spans) == len(slow_spans(result))
    if spans:
        close(spans, slow_spans(result))


def some_walls(chance):
    """Return walls of a box and at any angle around a motion of about 2 m."""
    box = {
        name: end * chance.uniform(0.5, 4.0)
        for name, end in (("x_min", -1.0), ("x_max", 1.0), ("y_min", -1.0), ("y_max", 1.0))
        if chance.random() < 0.6
    }
    slopes = {
        f"slope{k}": (*(chance.uniform(-1.0, 4.0) * np.array([np.sin(a), -np.cos(a)])).tolist(), a)
        for k, a in enumerate(chance.uniform(-np.pi, np.pi, chance.integers(0, 4)).tolist())
    }
    return half_planes(box, slopes)


@pytest.mark.parametrize("seed", range(40))
def test_the_view_of_a_motion(script, seed):
    chance = random(seed)
    points = np.cumsum(chance.normal(0.0, 0.1, (30, 4, 2)), axis=0) + chance.normal(0.0, 0.5, (4, 2))
    walls, pinned, radius = some_walls(chance), bool(chance.random() < 0.5), float(chance.choice([0.0, 0.1]))
    corners = chance.normal(0.0, 0.2, (4, 2)) if chance.random() < 0.3 and not pinned else np.zeros((0, 2))
    places = np.concatenate([points, points[:, :1] + corners], axis=1)
    result = script.evaluate(VIEW, [points.tolist(), free_sides(walls), radius, pinned, corners.tolist()])
    view, anchor = film_view(places, walls, radius, is_pinned=pinned)
    close(result["view"], view, size=10.0)
    assert result["anchor"] == anchor.tolist()
    lines = pin_lines(points) if pinned else []
    assert len(result["pin"]) == len(lines)
    for line, expected_line in zip(result["pin"], lines, strict=True):
        close(line, expected_line, size=10.0)


@pytest.mark.parametrize("seed", range(20))
def test_the_free_region_between_walls(script, seed):
    walls = some_walls(random(seed))
    corners_of_area = [[-5.0, -4.0], [6.0, 5.0]]
    corners = script.evaluate(ROOM, [free_sides(walls), corners_of_area])
    expected = free_region_within(walls.values(), np.array(corners_of_area))
    assert len(corners) == len(expected)
    if corners:
        close(corners, expected, size=10.0)


RANDOM = [*range(20), *(random_scenes.SIGNALLED + seed for seed in range(10))]


@pytest.mark.full("more cases", but=12)
@pytest.mark.parametrize("source", [*model_names(), *RANDOM])
def test_the_shapes_of_a_scene_and_the_rate_of_its_frames(script, source):
    """Walls, outlines of bodies, the line of a slider, and ranges of joints."""
    scene = load_scene(source) if isinstance(source, str) else random_scenes.scene(source)
    bases = np.array(scene.initial.position) + np.zeros((3, 1)) * [1.0, 1.0]
    rail = rail_from(bases[None, :1], None, scene.values)
    if rail is not None:
        rail = replace(rail, size=2.0)
        bases = rail.origin + np.array([[0.0], [0.3], [-0.2]]) * rail.direction
    result = script.evaluate(SHAPES, [page_contents(scene), bases.tolist(), 2.0])
    walls = free_sides(scene.half_planes)
    assert result["walls"].keys() == walls.keys()
    for name, wall in walls.items():
        close(result["walls"][name]["normal"], wall["normal"])
        close(result["walls"][name]["offset"], wall["offset"], size=10.0)
    bodies = outlines_from(scene.values, scene.contact.points)
    assert [link for link, _ in result["bodies"]] == list(bodies)
    for link, corners in result["bodies"]:
        close(corners, bodies[link])
    assert (result["rail"] is None) == (rail is None)
    if rail is not None:
        for line, expected_line in zip(result["rail"]["lines"], rail.lines(bases), strict=True):
            close(line, expected_line, size=10.0)
        close(result["rail"]["carriage"], rail.carriage(np.zeros(2)))
        ends = {"slider_min": rail.low, "slider_max": rail.high}
        assert result["rail"]["limits"] == {name: end for name, end in ends.items() if np.isfinite(end)}
        stops = free_sides(rail.stops)
        assert result["rail"]["stops"].keys() == stops.keys()
        for name, stop in stops.items():
            close(result["rail"]["stops"][name]["offset"], stop["offset"], size=10.0)
    ranges = ranges_of(scene.values)
    assert [limits["joint"] for limits in result["ranges"]] == list(ranges)
    for limits in result["ranges"]:
        close(limits["arc"], ranges[limits["joint"]].arc)
    parameters = {name: value for name, value in scene.values.items() if value is not None}
    run = SimpleNamespace(parameters=parameters, time=np.array([0.0, scene.simulation.stop_time]))
    close(result["rate"], frame_rate(run))


@pytest.mark.parametrize("model", ["four_link_box", "cart_pole", "pinned_arm", "thrown_brick"])
def test_the_page_of_a_recording_shows_the_frames_and_the_view_of_a_film(script, model):
    result = recorded(model)
    shown_frames = script.evaluate(FRAMES_SHOWN, [data_of_page(result), 0.6])
    start, stop = float(result.time[0]), float(result.time[-1])
    times, _ = frame_times(start, stop, slow_spans(result), 0.6, usual_rate=frame_rate(result))
    close(shown_frames["time"], times)
    points = np.stack([shown_frames["x"], shown_frames["y"]], axis=-1).reshape(len(times), -1, 2)
    expected = [[np.interp(times, result.time, column) for column in rows] for rows in result.all_points.T]
    np.testing.assert_allclose(points, np.array(expected).transpose(2, 1, 0), atol=1e-3)
    view, anchor = film_view(positions_of(result), result.walls, radius_of(result), is_pinned=result.pinned)
    np.testing.assert_allclose(shown_frames["view"], view, atol=1e-3 * np.ptp(view))
    assert shown_frames["anchor"] == anchor.tolist()


@pytest.mark.parametrize("model", ["ramp", "sphere_on_wall", "bouncing_ball", "rod_drop", "thrown_brick"])
def test_the_centre_of_a_ball(script, model):
    shape, values = data_of_page(recorded(model)), load_scene(model).values
    link = [values["link[1].center_of_mass"], values["link[1].length"]]
    assert script.evaluate("([shape, link]) => ballOf(shape, ...link)", [shape, link]) == shape["ball"]


@pytest.mark.full("more cases", but=8)
@pytest.mark.parametrize("source", ["knee", "sled", *model_names()])
def test_the_quantities_that_are_drawn(script, source):
    scene = {"knee": knee_scene, "sled": sled}.get(source, partial(load_scene, source))()
    scene = scene.with_values({"outputs.loads": True, "simulation.stop_time": 1e-3})
    expected = drawn_entries(simulate(scene).columns)
    assert expected.keys() == set(GROUPS)
    for group, entries in script.evaluate(DRAWN_GROUPS, page_contents(scene)):
        names_of_entries = {(n, name): set(names) for n, name, names in entries}
        assert names_of_entries == {
            (owner["n"], owner["name"]): owner["columns"].keys() for owner in expected[group]
        }


def test_a_group_that_is_not_drawn_is_an_error(script):
    with pytest.raises(quickjs.JSException):
        script.evaluate("() => Recording.prototype.drawnAt.call({ drawn: { loads: [] } }, 'load', 0)")


def test_the_lengths_of_arrows(script):
    forces = [3e3, 2e3, 500.0, 17.0]
    lengths = script.evaluate(ARROWS, [3e3, forces])
    scale = ArrowScale(3e3, 1.0)
    expected = [scale.length(force) for force in forces]
    shortest = 9.0  # pixels: all arrows of a scene of one pixel are shorter
    assert lengths == [shortest] * 4
    large = script.evaluate(ARROWS.replace("1, 1", "1000, 2000"), [3e3, forces])
    close(large, 1000.0 * np.array(expected))


@pytest.mark.parametrize("height", [-1e5, -20.0, -4.661, -0.03, 0.0, 0.7, 60.0])
def test_the_zero_of_the_potential_energy(script, height):
    wave = np.linspace(0.0, 1.0, 20)
    energies = {"kinetic": wave, "potential": height - wave, "total": height + 0.0 * wave}
    shifted, offset = without_gap(energies)
    arguments = {name: values.tolist() for name, values in energies.items()}
    assert script.evaluate("energyOffset", arguments) == pytest.approx(offset, rel=1e-12)
    shifted_in_page = script.evaluate("(energies) => movedBy(energies, energyOffset(energies))", arguments)
    for name, values in shifted.items():
        assert shifted_in_page[name] == pytest.approx(values.tolist(), abs=1e-9 * (1.0 + abs(height)))


def test_words_of_rates_units_and_angles(script):
    rates = [*np.geomspace(1e-4, 30.0, 200).tolist(), 0.985, 1.0, 1.015, 0.1, 0.5]
    results = script.evaluate("(rates) => rates.map(rateText)", rates)
    assert results == [rate_text(rate) for rate in rates]
    units = ["1", "m", "m/s2", "N.m", "kg.m2", "N.m.s", "rad/s2", "N/m^exponent", "N.s/m"]
    assert script.evaluate("(units) => units.map(unitText)", units) == list(map(unit_text, units))
    for exponent in (1.0, 1.5, 2.25):
        text = script.evaluate('(exponent) => unitOfPower("N/m^exponent", exponent)', exponent)
        assert text == stiffness_unit("N/m", exponent)
    texts = ["90 deg", "-12.5deg/s", " +.5e1 deg ", "1 deg/s2", "deg", "90", "1 rad", "90 degs"]
    for unit in ("rad", "rad/s", "rad/s2", "m"):
        results = script.evaluate(
            "([texts, unit]) => texts.map((text) => inRadians(text, unit))", [texts, unit]
        )
        assert results == [radians_of(text, unit) for text in texts]


def test_colours_of_films_are_those_of_pages():
    light = dict(
        re.findall(r"--([\w-]+): (#\w{6});", browser_text("player/style.css").partition("@media")[0])
    )
    colours = {"muted": MUTED, "force": FORCE, "load": LOAD, **ENERGIES}
    del colours["total"]  # black in a film
    assert {name: light[name] for name in colours} == colours


PROPOSED = "([wrong, names]) => wrong.map((name) => proposed(name, names) ?? null)"


def misspelt(chance, name):
    """Return a name with up to three letters removed, doubled or exchanged, or a part of it."""
    for _ in range(chance.integers(1, 4)):
        at = int(chance.integers(0, len(name)))
        letters = [name[:at] + name[at + 1 :], name[:at] + name[at : at + 1] + name[at:]]
        letters += [name[:at] + name[at : at + 2][::-1] + name[at + 2 :], name[: at + 2]]
        name = str(chance.choice(letters)) or name
    return name


@pytest.mark.full("more cases", but=1)
@pytest.mark.parametrize("seed", range(4))
def test_a_misspelt_name_gets_the_same_proposal(script, seed):
    chance, names = random(seed), [*recorded("four_link_box").columns, "contact.stiffness", "link[1].length"]
    names += ["contact.restitution", "box"]
    misspelt_names = [misspelt(chance, str(chance.choice(names))) for _ in range(30)]
    misspelt_names += ["lenght", "stifness", "force", "joint[9].angle", "link.mass", "x", "4].x", "[", ""]
    misspelt_names += ["contact.bounce", "floor", "a.law"]
    assert script.evaluate(PROPOSED, [misspelt_names, names]) == [
        proposed_name(name, names) for name in misspelt_names
    ]


@pytest.mark.parametrize("seed", range(20))
def test_the_colours_of_a_map(script, seed):
    """Values of a narrow and a wide range, some with extremes, or with values that are not positive."""
    chance = random(seed)
    values = 10.0 ** chance.uniform(0.0, chance.choice([0.3, 4.0]), 200) - chance.choice([0.0, 1.5])
    values[:3] *= chance.choice([1.0, 1e3], 3)
    ends, is_logarithmic = script.evaluate(COLOURS, [*values, None])
    assert is_logarithmic == (value_ratio(values) >= WIDE_COLOURS)
    close(ends, colour_ends(values, logarithmic=is_logarithmic))


@pytest.mark.parametrize(("least_count", "largest_count"), [(3, 4), (0, 11), (7, 95), (100, 12_345)])
def test_the_colours_of_counts(script, least_count, largest_count):
    bins, shares = script.evaluate(STEPS, [largest_count, least_count])
    assert bins == count_bins(least_count, largest_count)
    assert shares == [0.0, 1.0]


def test_a_wall_may_have_the_name_of_a_property_of_every_object(script):
    assert script.evaluate("(angle) => normalOf('constructor', angle)", 0.0) == [0, 1]

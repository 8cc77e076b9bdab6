"""Links with points and a base on a slider in recordings, pictures and films."""

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.pages.recorded import data_of_page
from chain_impact.pictures.over_time.impacts import marks_of, point_groups
from chain_impact.recording.csv_file import read_csv
from chain_impact.recording.recording import Recording
from chain_impact.recording.stick_slip import element_label
from chain_impact.scene.display.outlines import outline_of_discs, outlines_from, placed_corners
from chain_impact.scene.scene import scene_from_dict
from tests.helpers.scenes import bodies
from tests.tiers import needs_interop

BRICK = {
    "name": "Brick",
    "chain": {"links": [{"length": 0.5, "mass": 1.0, "shape": "box", "height": 0.2}]},
    "box": {"y_min": 0.0},
    "contact": {"points": [], "stiffness": 1e6, "friction": 0.8, "radius": 0.02},
    "initial": {"position": [0.0, 0.4], "angles": [0.5]},
}
CART = {
    "name": "Cart",
    "gravity": [0.0, 0.0],
    "chain": {
        "base": "slider",
        "slider": {"angle": 0.3, "mass": 2.0, "friction": 2.0, "min": -0.2, "max": 0.4},
        "links": [{"length": 0.5, "mass": 0.5}],
    },
    "box": {},
    "contact": {"points": []},
    "initial": {"position": [1.0, 2.0], "angles": [1.0], "slider_velocity": 2.5},
}


@pytest.fixture(scope="module", params=[BRICK, CART], ids=["brick", "cart"])
def run(request):
    return simulate(scene_from_dict(request.param, request.param["name"]), stop_time=0.8, output_step=0.01)


@pytest.fixture(scope="module")
def cart():
    return simulate(scene_from_dict(CART, "Cart"), stop_time=2.0, output_step=0.01)


def area(corners):
    x, y = corners.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_an_outline_is_the_convex_hull_of_discs():
    square = outline_of_discs([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.3, 0.6, 0), (0.5, 0, 0)])
    assert area(square) == pytest.approx(1.0)
    assert len(square) == 4
    capsule = outline_of_discs([(0.0, 0.0, 0.1), (1.0, 0.0, 0.1)])
    assert area(capsule) == pytest.approx(0.2 + np.pi * 0.1**2, rel=0.01)


def test_an_outline_goes_with_its_link():
    scene = scene_from_dict(BRICK, "Brick")
    (corners,) = outlines_from(scene.values, scene.contact.points).values()
    there = placed_corners(corners, np.array([1.0, 2.0]), np.array([1.0, 2.5]))
    assert there.min(axis=0) == pytest.approx([1.0 - 0.12, 2.0 - 0.02])
    assert there.max(axis=0) == pytest.approx([1.0 + 0.12, 2.5 + 0.02])
    run = simulate(scene, stop_time=0.1)
    np.testing.assert_allclose(run.outlines[1], corners, rtol=0.0, atol=1e-15)


def test_points_of_links_touch_with_their_own_radii():
    run = simulate(scene_from_dict(BRICK, "Brick"), stop_time=0.1)
    assert run.touching_radii == dict.fromkeys((2, 3, 4, 5), 0.02)


def test_an_impact_at_a_sliders_stop_is_where_its_carriage_ends(cart):
    first, second = (cart.impact_position(impact) for impact in cart.impacts[:2])
    along, half = np.array([np.cos(0.3), np.sin(0.3)]), cart.rail.half
    assert first == pytest.approx([1.0, 2.0] + (0.4 + half) * along, abs=1e-6)
    assert second == pytest.approx([1.0, 2.0] - (0.2 + half) * along, abs=1e-6)


def test_a_table_of_a_cart_shows_its_line_with_and_without_the_scene(cart, tmp_path):
    cart.save_csv(tmp_path / "cart.csv")
    for scene in (None, cart.scene):
        recording = read_csv(tmp_path / "cart.csv", scene)
        assert not recording.pinned
        assert recording.rail.angle == pytest.approx(0.3)
        assert recording.rail.origin == pytest.approx([1.0, 2.0])
        assert bool(recording.rail.stops) == bool(scene)


def test_a_recording_without_a_slider_has_no_line():
    recording = Recording("R", np.arange(2.0), {"point[0].x": np.zeros(2), "point[0].y": np.zeros(2)})
    assert recording.rail is None


@pytest.mark.full("takes long")
@pytest.mark.parametrize("name", ["run.png", "run.gif"])
def test_pictures_and_films_show_bodies(run, tmp_path, name):
    draw = run.plot if name.endswith("png") else run.animate
    draw(tmp_path / name)
    assert (tmp_path / name).stat().st_size > 1000


def test_points_are_told_by_their_names_and_sliders_as_such(cart):
    run = simulate(bodies.body(), 0.6, output_step=0.01)
    names = [run.touching_part(impact) for impact in run.impacts]
    assert names[:3] == ["point 3 (heel)", "point 4 (toe)", "point 6"]
    assert {cart.touching_part(impact) for impact in cart.impacts} == {"slider"}
    unnamed = Recording("R", run.time, run.columns, run.impacts, wall_names=run.wall_names)
    assert unnamed.touching_part(run.impacts[0]) == "point 3"
    places = {element_label(phase, run.wall_names, run.point_names) for phase in run.stick_slip}
    assert {"point 3 (heel) at y_min", "point 4 (toe) at y_min"} <= places
    groups = point_groups(run, marks_of(run)[1])
    assert [name for name, *_ in groups] == ["point 3 (heel)", "point 4 (toe)", "point 6"]
    assert "  3 (heel)  " in str(run)
    assert [impact["what"] for impact in data_of_page(run)["impacts"]] == names
    assert data_of_page(run)["pointNames"] == [(3, "heel"), (4, "toe")]
    assert "slider  slider_max" in str(cart)
    few = simulate(cart.scene, 0.5, output=["slider.position"])
    assert few.touching_part(few.impacts[0]) == "slider"


@needs_interop
def test_a_dataset_has_all_points_and_the_stops_of_a_slider():
    dataset = simulate(bodies.body(), 0.3, output_step=0.01).to_xarray()
    assert dataset["point_name"].values.tolist() == ["", "", "", "heel", "toe", "", "", "", ""]
    run = simulate(bodies.cart().with_values({"link[1].joint_min": -9.0}), 0.4, output_step=0.01)
    force = run.to_xarray()["force"].sel(contact="contact[0].slider_max")
    np.testing.assert_array_equal(force, run["contact[0].slider_max.force"])
    assert force.max() > 1.0


def test_sticking_elements_are_marked_where_they_are():
    chain = {**CART["chain"], "slider": {"friction": 50.0}}
    cart = simulate(scene_from_dict({**CART, "chain": chain}, "Cart"), stop_time=1.0, output_step=0.01)
    axes = cart.plot(kind="motion").axes[0]
    mark = next(line for line in axes.lines if line.get_label() == "sticks at the end")
    np.testing.assert_allclose(mark.get_xydata(), cart.points[-1:, 0])


def test_numbers_at_a_sliders_stops_are_beyond_their_marks():
    """A short pendulum on the cart leaves room for the numbers."""
    cart = simulate(bodies.cart().with_values({"link[1].length": 0.1}), stop_time=2.0, output_step=0.01)
    axes = cart.plot(panels=["motion"]).axes[0]
    marks = [line[1:] for line in cart.rail.lines(cart.points[:, 0])[1:]]
    numbers = [text for text in axes.texts if text.get_text().startswith("#")]
    assert len(numbers) == 2
    for text in numbers:
        away = min(np.hypot(*(np.array(text.xy) - mark[0])) for mark in marks)
        assert away < 1e-6


def test_a_page_has_bodies_and_the_line_of_a_slider(run):
    contents = data_of_page(run)
    assert contents["links"] == 1
    assert contents["pointCount"] == run.all_points.shape[1]
    assert [link for link, _ in contents["bodies"]] == [*run.outlines]
    assert dict(contents["touching"]) == run.touching_radii
    assert bool(contents["rail"]) == (run.name == "Cart")
    if contents["rail"]:
        assert [*contents["rail"]["stops"]] == [*contents["rail"]["limits"]] == ["slider_min", "slider_max"]
        assert not contents["pinned"]

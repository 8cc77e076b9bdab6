"""The pairs of a point and a wall between which contact is possible, and the stops of joints."""

from chain_impact import load_scene
from chain_impact.kernel.record.constants import WALLS
from chain_impact.scene.candidates import candidates_of, point_wall_pairs, stop_pairs
from chain_impact.scene.facts import SceneFacts
from chain_impact.scene.scene import with_values
from chain_impact.variables.prepared import PreparedScene


def test_candidates_are_the_listed_points_at_the_walls_that_are_there():
    box = load_scene("four_link_box")
    assert candidates_of(box) == [(point, wall) for point in range(5) for wall in range(4)]
    some_points = with_values(
        box, {("contact", "points"): [4, 1], ("box", "x_min"): None, ("box", "y_max"): None}
    )
    x_max, y_min = WALLS.index("x_max"), WALLS.index("y_min")
    assert candidates_of(some_points) == [(1, x_max), (1, y_min), (4, x_max), (4, y_min)]
    walls = [{"name": name, "point": [0.0, 0.0], "angle": angle} for name, angle in (("a", 0.0), ("b", -1.0))]
    slanted = with_values(some_points, {("walls",): walls})
    assert candidates_of(slanted)[:4] == [(1, x_max), (1, y_min), (1, 4), (1, 5)]
    walls_of_record = PreparedScene(slanted).new_instance()[0]["walls"]
    assert walls_of_record["angle"].tolist() == [0.0, -1.0] + [0.0] * 6
    assert candidates_of(with_values(box, {("contact", "points"): []})) == []
    for scene in (box, some_points, slanted, with_values(box, {("contact", "points"): []})):
        assert len(candidates_of(scene)) == len(scene.contact.points) * len(scene.half_planes)
    assert candidates_of(with_values(box, {("box", wall): None for wall in WALLS})) == []


def test_stops_come_last_joint_after_joint():
    box = with_values(load_scene("four_link_box"), {("contact", "points"): [4], ("box", "x_min"): None})
    walls = [{"name": "ramp", "point": [0.0, -9.0], "angle": 0.0}]
    limits = {"link[4].joint_max": 1.5, "link[2].joint_min": -2.0, "link[2].joint_max": 2.0}
    stopped = with_values(with_values(box, {("walls",): walls}), limits)
    assert stopped.wall_names == ("x_min", "x_max", "y_min", "y_max", "ramp", "joint_min", "joint_max")
    assert candidates_of(stopped) == [(4, 1), (4, 2), (4, 3), (4, 4), (2, 5), (2, 6), (4, 6)]
    assert point_wall_pairs(stopped) + stop_pairs(stopped) == candidates_of(stopped)


def test_a_wall_with_the_name_of_a_stop_is_a_wall():
    walls = [{"name": name, "point": [0.0, -9.0], "angle": 0.1} for name in ("joint_min", "slider_max")]
    named_scene = with_values(load_scene("four_link_box"), {("walls",): walls})
    assert {candidate["stop"] for candidate in SceneFacts(named_scene)["candidates"]} == {0}

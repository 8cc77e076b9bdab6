"""A changed law for a scene with stops and several wall materials, and comparisons of laws there."""

# Tests: study_data/compared_impact.py, study_data/law_runs.py

import functools

import pytest

from chain_impact import compare, simulate
from chain_impact.pictures.compare.headline import comparison_headline
from chain_impact.pictures.compare.looks import looks_of_laws
from chain_impact.pictures.compare.plot import comparison_conditions
from chain_impact.scene.errors import SceneError
from chain_impact.studies.changed_law import contact_with_law, keeps_exponents, law_values
from chain_impact.studies.compare.compare import OVERLAPS
from chain_impact.studies.compare.text import advice, comparison_heading, law_table, legend
from chain_impact.study_data.compared_impact import contact_at
from tests.helpers.scenes.stops import UP, knee_scene

K = "stiffness"


@functools.cache
def impacts(is_up=False):
    return simulate(knee_scene(**UP) if is_up else knee_scene()).impacts


def depth(stiffness, n, energy):
    return ((n + 1.0) * energy / stiffness) ** (1.0 / (n + 1.0))


def test_a_law_with_another_exponent_is_as_deep_at_walls_and_stops():
    scene = knee_scene(**{"wall.x_max.stiffness": 1e6, "stop.exponent": 2.0})
    first = impacts()[0]
    energy = 0.5 * first["effective_mass"] * first["impact_speed"] ** 2
    changes = law_values(scene, "kelvin_voigt", first)
    changed_scene = scene.with_values(changes)
    assert (changed_scene.contact.exponent, changed_scene.stops.exponent) == (1.0, 1.0)
    given_values = [(1e8, 1.5), (1e6, 1.5), (1e4, 2.0)]
    new_stiffnesses = (
        changed_scene.contact.stiffness,
        changed_scene.contact.wall["x_max"].stiffness,
        changed_scene.stops.stiffness,
    )
    for (stiffness, n), new_stiffness in zip(given_values, new_stiffnesses, strict=True):
        assert depth(new_stiffness, 1.0, energy) == pytest.approx(depth(stiffness, n, energy), rel=1e-12)


def test_stops_with_a_law_of_their_own_keep_it():
    scene = knee_scene(**{"stops.model": "flores"})
    changes = law_values(scene, "kelvin_voigt", impacts()[0])
    assert scene.with_values(changes).stops == scene.stops
    assert keeps_exponents("kelvin_voigt", knee_scene(**{"contact.exponent": 1.0, "stop.exponent": 1.0}))
    assert not keeps_exponents("kelvin_voigt", knee_scene(**{"contact.exponent": 1.0, "stop.exponent": 1.5}))


def test_the_contact_of_an_impact_is_that_of_its_wall_or_of_the_stops():
    scene = knee_scene()
    at_stop, at_wall = impacts()[0], next(hit for hit in impacts() if hit["wall"] == 1)
    stop = contact_at(scene, at_stop)
    assert (stop.stiffness, stop.exponent, stop.restitution) == (1e4, 1.5, 0.5)
    wall = contact_at(scene, at_wall)
    assert (wall.stiffness, wall.restitution) == (1e8, 0.25)
    assert contact_with_law(stop, "flores", at_stop).stiffness == 1e4
    assert contact_with_law(stop, "kelvin_voigt", at_stop).exponent == 1.0


@pytest.mark.parametrize("is_up", [False, True])
def test_laws_are_compared_at_a_stop(is_up):
    scene = knee_scene(**UP) if is_up else knee_scene()
    comparison = compare(scene, laws=["flores", "zhang_sharf", "newton_impact"])
    assert comparison.is_at_stop
    assert comparison.contact.restitution == 0.5
    assert " kg·m² at " in comparison_heading(comparison)
    assert comparison_heading(comparison).endswith("rad/s")
    assert law_table(comparison).head[2:4] == ("peak, N·m", "depth, mrad")
    run, first = comparison["zhang_sharf"], impacts(is_up)[0]
    assert run.stiffness == 1e4
    # the loop consists of samples in time: the largest sample is near the peak
    assert run.loop.max(axis=1) == pytest.approx([first["max_penetration"], first["peak_force"]], rel=1e-4)
    assert comparison["newton_impact"].peak_force == 0.0


@pytest.mark.parametrize("kept_law", ["flores", "newton_impact"])
def test_laws_are_compared_at_a_wall_where_stops_keep_their_law(kept_law):
    """The first impact is at a stop and equal under all laws, so it does not distinguish them."""
    comparison = compare(
        knee_scene(**{"stops.model": kept_law}), laws=["flores", "zhang_sharf", "kelvin_voigt"]
    )
    result = comparison["zhang_sharf"].result
    assert result.scene.wall_names[result.impacts["wall"][0]] == "joint_min"
    at_wall = result.impacts[result.impacts["wall"] == 1][0]
    assert comparison.first_impact.tobytes() == at_wall.tobytes()
    assert not comparison.is_at_stop
    assert comparison.contact.restitution == 0.25
    assert f"first impact at a wall at {at_wall['onset']:.6g} s" in comparison_heading(comparison)
    assert law_table(comparison).head[2] == "peak, kN"
    assert legend(comparison).endswith(f"The stops keep {kept_law} under every law.")
    assert advice(comparison) == "within 5 % of e = 0.25 in this impact: zhang_sharf"
    for law in ("flores", "zhang_sharf"):
        run, row = (
            comparison[law],
            comparison[law].result.impacts[comparison[law].result.impacts["wall"] == 1][0],
        )
        assert run.restitution == row["separation_speed"] / row["impact_speed"]
        assert run.loop.max(axis=1) == pytest.approx([row["max_penetration"], row["peak_force"]], rel=1e-3)
    viscous_run = comparison["kelvin_voigt"]
    energy = 0.5 * at_wall["effective_mass"] * at_wall["impact_speed"] ** 2
    assert depth(viscous_run.stiffness, 1.0, energy) == pytest.approx(depth(1e8, 1.5, energy), rel=1e-12)
    assert "in the first impact, for e = 0.25" in comparison_headline(comparison)
    assert comparison_conditions(comparison, looks_of_laws(comparison)).startswith(
        "first impact at a wall of "
    )


def test_a_contact_that_holds_while_the_compared_impact_begins_is_told():
    """A spring presses the knee onto a rigid stop when the tip arrives at the wall."""
    pressed = {"link[2].joint_stiffness": 50.0, "link[2].joint_rest_angle": -1.0}
    straight = {"initial.angle[1]": -1.0, "initial.angle[2]": -1.0}
    turning = {"initial.angular_velocity[1]": 4.0, "initial.angular_velocity[2]": 4.0}
    scene = knee_scene(
        **{"stops.model": "newton_impact", "stop.restitution": 0.0}, **pressed, **straight, **turning
    )
    comparison = compare(scene, laws=["zhang_sharf"])
    stop, wall = comparison["zhang_sharf"].result.impacts[[0, 1]]
    assert (stop["wall"], wall["wall"]) == (4, 1)
    assert not stop["end"] < wall["onset"]
    assert comparison["zhang_sharf"].note == OVERLAPS


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"simulation.stop_time": 1.0}, "there is none at a wall before 1 s"),
        ({"contact.points": []}, "no point can touch a wall"),
    ],
)
def test_impacts_at_stops_that_keep_their_law_are_not_compared(changes, reason):
    scene = knee_scene(**{"stops.model": "flores"}, **changes)
    with pytest.raises(SceneError, match=f"the stops keep stops.model = flores, and {reason}"):
        compare(scene, laws=["zhang_sharf"])

"""A hint, in Python and on the command line, if a point goes deep into a wall."""

# Tests: scene/warning.py

import warnings

import pytest

from chain_impact import SceneWarning, SimulationError, cli, load_scene, simulate
from chain_impact.recording.summary import DEEP_PENETRATION

SOFT = {"contact.stiffness": 100.0}
MESSAGE = (
    "m beyond y_min, and the length of the shortest link is 0.5 m: "
    "contact.stiffness = 100 [N/m^1.5] is small for this motion"
)


def warnings_and_result(scene, **settings):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = simulate(scene, **settings)
    return [str(warning.message) for warning in caught], result


def test_a_wall_that_is_too_soft_is_told_at_the_line_that_simulates():
    with pytest.warns(SceneWarning) as caught:
        result = simulate(load_scene("four_link_box").with_values(SOFT))
    (message,) = (str(warning.message) for warning in caught)
    assert message == f"FourLinkBox: a point goes {result.impacts['max_penetration'].max():.3g} {MESSAGE}"
    assert caught[0].filename == __file__
    assert result.impacts["max_penetration"].max() > 0.5
    assert f"note     {message.partition(': ')[2]}" in str(result).splitlines()
    assert MESSAGE.replace(">", "&gt;") in result._repr_html_()


def test_the_stiffness_of_the_wall_itself_is_named():
    soft = {"contact.wall": {"y_min": {"stiffness": 100.0}}}
    messages, _ = warnings_and_result(load_scene("four_link_box").with_values(soft))
    assert len(messages) == 1
    assert messages[0].endswith(MESSAGE.replace("contact.", "wall.y_min."))


@pytest.mark.parametrize("values", [{}, {"contact.stiffness": 1e5}, {"contact.model": "newton_impact"}])
def test_shallow_contacts_are_not_told(values):
    messages, result = warnings_and_result(load_scene("four_link_box").with_values(values))
    assert messages == []
    assert result.impacts["max_penetration"].max() < DEEP_PENETRATION * 0.5
    assert "note" not in str(result)


@pytest.mark.parametrize("model", ["elastic_floor", "kneed_leg", "simple_pendulum"])
def test_balls_stops_and_chains_without_walls_have_nothing_to_tell(model):
    messages, _ = warnings_and_result(model)
    assert messages == []


def test_a_rod_that_touches_with_one_point_is_no_ball():
    soft = {"contact.points": [0], "contact.stiffness": 10.0}
    messages, _ = warnings_and_result(load_scene("rod_drop").with_values(soft))
    assert len(messages) == 1
    assert "m beyond y_min, and the length of the shortest link is 0.6 m" in messages[0]


def test_a_ball_goes_deeper_than_its_radius():
    messages, _ = warnings_and_result(
        load_scene("elastic_ball").with_values({"contact.model": "hertz", "contact.stiffness": 1e3})
    )
    assert len(messages) == 1
    assert "m beyond y_min, and the radius of the ball is 0.1 m" in messages[0]


def test_a_run_that_stops_tells_it_too():
    with pytest.raises(SimulationError), pytest.warns(SceneWarning, match="m beyond y_min"):
        simulate(load_scene("four_link_box").with_values({**SOFT, "solver.work_limit": 1000}))


def test_the_command_line_tells_it_once(capsys, tmp_path):
    picture = ["--set", "simulation.step_size=0.01", "--plot", str(tmp_path / "soft.png")]
    assert cli.main(["simulate", "four_link_box", "--set", "contact.stiffness=100", *picture]) == 0
    assert capsys.readouterr().err.count(MESSAGE) == 1

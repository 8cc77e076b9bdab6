"""The printed report of a comparison. (test_commands.py tests the reports of simulations.)"""

# Tests: studies/compare/text.py

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, compare, load_scene
from chain_impact.cli.screen import borderless_table, law_table_parts, plain_lines, summary, variable_lines
from chain_impact.recording.summary import NO_NUMBER
from chain_impact.scene.settings import with_settings
from chain_impact.simulation.simulate import simulate
from chain_impact.variables.prepared import PreparedScene
from tests.helpers.scenes.problems import default_scene, driven


def test_an_impulse_and_a_law_without_a_result_have_a_row():
    comparison = compare(default_scene())
    hertz, *other_runs = comparison.runs
    impulse = replace(hertz, duration=0.0, max_penetration=0.0, peak_force=0.0)
    no_numbers = dict.fromkeys(("restitution", "peak_force"), math.nan)
    failed = replace(other_runs[0], result=None, note="cannot start", **no_numbers)
    _, table, *_ = law_table_parts(replace(comparison, runs=(impulse, failed, *other_runs[1:])))
    lines = [line.strip() for line in plain_lines(table)]
    first, second = (next(line for line in lines if line.startswith(run.law)) for run in (impulse, failed))
    assert first.split()[2:5] == ["–", "0.000", "0.000"]
    assert second.split()[1:3] == ["–", "–"]
    assert second.endswith("  –  cannot start")


def test_the_list_of_impacts_has_their_peak_forces_and_impulses():
    recording = simulate(load_scene("kneed_leg"))
    _, table, *_ = summary(recording)
    head, *rows = plain_lines(table)
    assert head.endswith("peak force, N·m  impulse, N·m·s")  # all are at stops
    for row, impact in zip(rows, recording.impacts, strict=True):
        force, impulse = (f"{impact[name]:.4g}" for name in ("peak_force", "impulse"))
        assert re.search(rf"  {force} +{impulse}$", row)
    box_run = simulate(default_scene())
    head, first, *_ = plain_lines(list(summary(box_run))[1])
    assert head.endswith("peak force, N  impulse, N·s")
    for cell, name in zip(first.split()[-2:], ("peak_force", "impulse"), strict=True):
        assert float(cell) == pytest.approx(box_run.impacts[0][name], rel=1e-3)


def test_the_walls_that_were_hit_are_explained():
    lines = [part for part in summary(simulate(default_scene())) if isinstance(part, str)]
    (walls,) = (line for line in lines if line.startswith("wall "))
    assert "x_max is the right wall" in walls
    assert "y_min is the floor" in walls
    assert "x_min" not in walls
    (points,) = (line for line in lines if line.startswith("point "))
    assert points.endswith("and so on")
    sliding = [part for part in summary(simulate(load_scene("sliding_rod"))) if isinstance(part, str)]
    (walls,) = (line for line in sliding if line.startswith("wall "))
    degrees = math.degrees(load_scene("sliding_rod").walls[0].angle)
    assert f"ramp has the angle {degrees:.4g} deg" in walls
    (points,) = (line for line in sliding if line.startswith("point "))
    assert points.endswith("0 is the first end of the link, 1 its other end")
    joint = summary(simulate(load_scene("kneed_leg")))  # hits a stop only
    assert not [part for part in joint if isinstance(part, str) and part.startswith(("point", "wall"))]


def test_without_impacts_there_is_no_table_of_them():
    head, *lines = summary(simulate(with_settings(default_scene(), {"simulation.stop_time": 0.1})))
    assert head.plain.endswith("0 impacts")
    assert [line.split()[0] for line in lines] == ["energy", "balance"]


def test_the_columns_are_aligned():
    _, table, *_ = law_table_parts(compare(default_scene()))
    head, *rows = plain_lines(table)
    end = head.index("steps") + len("steps")
    assert [row.split()[0] for row in rows] == list(CONTACT_LAWS)
    assert all(len(row) == end or row[end] == " " for row in rows)


@pytest.mark.parametrize("width", [80, 200])
def test_the_list_of_variables_is_as_wide_as_the_terminal(width):
    variables = PreparedScene(default_scene()).variables
    lines = list(variable_lines(variables, width))
    assert max(map(len, lines)) <= width
    assert len(lines) > len(variables) + 20  # long descriptions continue in the next line
    assert all(any(line.split()[:1] == [v.name] for line in lines) for v in variables)


def test_the_list_of_impacts_tells_which_link_has_a_point():
    recording = simulate(with_settings(load_scene("thrown_brick"), {"simulation.stop_time": 0.8}))
    point_lines = [part for part in summary(recording) if isinstance(part, str) and part.startswith("point ")]
    assert len(point_lines) == 1
    assert point_lines[0].endswith("2–5 on link 1")


def test_elsewhere_lines_are_whole_and_have_no_spaces_at_their_end():
    table = borderless_table(("name", "number"), numbers=("number",))
    table.add_row("[a]" * 2, "1")
    table.add_row("b" * 200, "23")
    assert [len(line) for line in plain_lines(table)] == [209] * 3
    assert not any(line.endswith(" ") for line in plain_lines(borderless_table(("name", "text"))))


def test_the_list_of_impacts_has_their_durations_and_tells_which_last():
    recording = simulate(driven(stop_time=0.2))
    lines = list(plain_lines(list(summary(recording))[1]))
    cells = [line.split()[5] for line in lines if line[:3].strip().isdecimal()]
    assert max(map(len, lines)) <= 80
    assert "lasts" in cells
    for cell, impact in zip(cells, recording.impacts, strict=True):
        if np.isnan(impact["end"]):
            assert cell == "lasts"
        else:
            assert float(cell) == pytest.approx(1e3 * (impact["end"] - impact["onset"]), rel=1e-3)


def test_a_rigid_impact_has_no_duration():
    _, first, *_ = plain_lines(list(summary(simulate(default_scene(model="newton_impact"))))[1])
    assert first.split()[5:7] == [NO_NUMBER, NO_NUMBER]

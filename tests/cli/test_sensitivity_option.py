"""`chain-impact simulate --sensitivity`: a table of the impacts, a picture and columns."""

# Tests: cli/simulate.py, recording/sensitivity.py

import csv
import re

import numpy as np
import pytest

from chain_impact import simulate


def tables(output):
    """Return parameter → rows of numbers of its table, as text."""
    rows_of_parameters, rows = {}, None
    for line in output.splitlines():
        if head := re.fullmatch(r"Change of the impacts for (.*) \+ .*", line):
            rows = rows_of_parameters.setdefault(head[1], [])
        elif rows is not None and re.match(r" *\d+ ", line):
            rows.append(line.split()[1:])
    return rows_of_parameters


def test_the_table_of_impacts(run):
    names = ["contact.restitution", "link[1].mass", "link[2].mass"]
    options = ("--sensitivity", f"{names[0]}, link[1].mass", "--sensitivity", "link[2].m*")
    code, output, errors = run("simulate", "--stop-time", "0.6", *options)
    assert (code, errors) == (0, "")
    rows_of_parameters = tables(output)
    assert list(rows_of_parameters) == names
    result = simulate("four_link_box", stop_time=0.6, sensitivities=names)
    impacts, size = result.impacts, {name: 0.01 * result.scene.values[name] for name in names}
    for name, rows in rows_of_parameters.items():
        assert len(rows) == len(impacts) == 2
        for k, row in enumerate(rows):

            def change(quantity, name=name, k=k):
                return size[name] * result.impact_sensitivity(quantity, name)[k]

            duration = (change("end") - change("onset")) / (impacts["end"][k] - impacts["onset"][k])
            quantities = ("impact_speed", "separation_speed", "peak_force", "max_penetration")
            shares = [change(quantity) / impacts[quantity][k] for quantity in quantities]
            expected = [1e3 * change("onset"), *(100.0 * share for share in (*shares, duration))]
            expected.append(100.0 * change("impulse") / impacts["impulse"][k])
            assert [float(cell) for cell in row] == pytest.approx(expected, rel=6e-3)
    head = r"^ # +onset, ms +speed, % +rebound, % +peak, % +depth, % +duration, % +impulse, %$"
    assert re.search(head, output, re.M)
    assert "Change of the impacts" not in run("simulate", "--stop-time", "0.6")[1]


def test_a_derivative_that_is_not_finite_is_a_dash(run):
    _, output, _ = run(
        "simulate", "bouncing_ball", "--stop-time", "1", "--sensitivity", "contact.restitution"
    )
    first, *_ = tables(output)["contact.restitution"]
    assert first[2] == "+1"  # percent: the rebound speed is e v
    assert first[3] == first[5] == "–"  # peak force and duration


def test_a_limit_is_said_in_words(run, work_folder):
    (work_folder / "rod.toml").write_text(
        'name = "Rod"\n[chain]\nlinks = [{ length = 1.0, mass = 1.0 }]\n[box]\ny_min = 0.0\n'
        '[contact]\nmodel = "newton_impact"\n[initial]\nangles = [0.0]\nposition = [0.0, 0.1]\n'
    )
    options = ("--stop-time", "0.3", "--sensitivity", "contact.restitution")
    code, output, errors = run("simulate", "rod.toml", *options)
    assert (code, errors) == (0, "")
    (limit,) = re.findall(r"^limit +(there are no derivatives from t = \S+ s on, .*)$", output, re.M)
    assert "at y_min: several points arrive at one moment" in limit


@pytest.mark.full("takes long")
def test_picture_and_table(run, work_folder):
    options = ("--stop-time", "0.5", "--sensitivity", "gravity.y", "--plot", "rod.svg", "--csv", "rod.csv")
    code, output, _ = run("simulate", "rod_drop", *options)
    assert (code, output.splitlines()[:2]) == (0, ["results  rod.csv", "picture  rod.svg"])
    picture = (work_folder / "rod.svg").read_text(encoding="utf-8")
    assert "change of peak force [%]" in re.sub(r"<!-- | -->", "", picture)
    with (work_folder / "rod.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    derivative = np.array([float(row[head.index("sensitivity.gravity.y.point[1].y")]) for row in rows])
    time = np.array([float(row[0]) for row in rows])
    # the derivative is ½ t² until the first impact
    falling = time < 0.3
    np.testing.assert_allclose(derivative[falling], 0.5 * time[falling] ** 2, atol=1e-12)


def test_the_window_shows_them(run, monkeypatch):
    from matplotlib import pyplot
    from matplotlib.figure import Figure

    titles = []
    window = Figure(layout="constrained")
    monkeypatch.setattr("chain_impact.cli.simulate.open_window", lambda: window)
    monkeypatch.setattr(pyplot, "show", lambda: titles.append(window.get_suptitle()))
    run("simulate", "rod_drop", "--stop-time", "0.5", "--sensitivity", "gravity.y", "--show")
    assert titles == [window.get_suptitle()]
    assert "gravity y + 1 %" in titles[0]


def test_rank_orders_all_parameters_and_draws_bars(run, work_folder):
    code, output, errors = run("simulate", "pinned_arm", "--rank", "peak_force", "--plot", "bars.png")
    assert (code, errors) == (0, "")
    _, _, ranking = output.partition("PinnedArm  peak_force = 1015.53 N")
    rows = ranking.splitlines()
    assert [row.split()[0] for row in rows[4:6]] == ["initial.angle[1]", "gravity.y"]
    assert (
        ranking.index(" link[2].joint_damping")
        < ranking.index("added to a parameter that is 0")
        < ranking.index("joint[1].torque")
    )
    assert "contact.exponent is left out" in ranking
    assert "without effect: link[1].joint_rest_angle" in ranking
    assert (work_folder / "bars.png").stat().st_size > 10_000
    output_of_contacts = run(
        "simulate", "pinned_arm", "--rank", "energy.total", "--sensitivity", "contact.*"
    )[1]
    assert "contact.restitution" in output_of_contacts
    assert "gravity" not in output_of_contacts
    assert "impulse" not in output_of_contacts  # a column of the list of impacts
    assert run("simulate", "a.fmu", "--rank", "peak_force")[0] == 2


def test_a_ranking_by_the_force_in_joints_needs_no_key_of_the_scene(run):
    command = ("simulate", "pinned_arm", "--stop-time", "0.55", "--rank", "joint_force", "--sensitivity")
    code, output, errors = run(*command, "link[*].mass")
    assert (code, errors) == (0, "")
    assert output == run(*command, "link[*].mass", "--set", "outputs.loads=true")[1]
    assert "link[2].mass" in output


def test_rank_tells_which_effects_a_run_with_the_new_value_refutes(run):
    output = run("simulate", "four_link_box", "--stop-time", "0.52", "--rank", "peak_force")[1]
    assert "for 16 of 37 effects: all agree within 25 %" in output
    late = run("simulate", "four_link_box", "--rank", "point[4].x", "--sensitivity", "initial.*")[1]
    head, *rows = late.partition("to first order")[2].splitlines()[1:]
    assert head.endswith("in a run")
    assert (
        "differ by more than" in late.partition("effect   of 1 %")[0]
    )  # this sentence stands above the table
    name, *_, simulated = rows[0].split()
    assert name.startswith("initial.")
    assert abs(float(simulated)) < 3.0  # m, the width of the box

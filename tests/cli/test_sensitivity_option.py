"""`chain-impact simulate --sensitivity`: a table of the impacts, a picture and columns."""

# Tests: cli/simulate.py, recording/sensitivity.py

import csv
import re

import numpy as np
import pytest

from chain_impact import simulate


def tables(said):
    """Return parameter → rows of numbers of its table, as text."""
    found, rows = {}, None
    for line in said.splitlines():
        if head := re.fullmatch(r"Change of the impacts for (.*) \+ .*", line):
            rows = found.setdefault(head[1], [])
        elif rows is not None and re.match(r" *\d+ ", line):
            rows.append(line.split()[1:])
    return found


def test_the_table_of_impacts(run):
    names = ["contact.restitution", "link[1].mass", "link[2].mass"]
    asked = ("--sensitivity", f"{names[0]}, link[1].mass", "--sensitivity", "link[2].m*")
    code, said, errors = run("simulate", "--stop-time", "0.6", *asked)
    assert (code, errors) == (0, "")
    found = tables(said)
    assert list(found) == names
    result = simulate("four_link_box", stop_time=0.6, sensitivities=names)
    impacts, size = result.impacts, {name: 0.01 * result.scene.values[name] for name in names}
    for name, rows in found.items():
        assert len(rows) == len(impacts) == 2
        for k, row in enumerate(rows):

            def change(quantity, name=name, k=k):
                return size[name] * result.impact_sensitivity(quantity, name)[k]

            duration = (change("end") - change("onset")) / (impacts["end"][k] - impacts["onset"][k])
            quantities = ("impact_speed", "separation_speed", "peak_force", "max_penetration")
            shares = [change(quantity) / impacts[quantity][k] for quantity in quantities]
            right = [1e3 * change("onset"), *(100.0 * one for one in (*shares, duration))]
            right.append(100.0 * change("impulse") / impacts["impulse"][k])
            assert [float(cell) for cell in row] == pytest.approx(right, rel=6e-3)
    head = r"^ # +onset, ms +speed, % +rebound, % +peak, % +depth, % +duration, % +impulse, %$"
    assert re.search(head, said, re.M)
    assert "Change of the impacts" not in run("simulate", "--stop-time", "0.6")[1]


def test_a_derivative_that_is_not_finite_is_a_dash(run):
    _, said, _ = run("simulate", "bouncing_ball", "--stop-time", "1", "--sensitivity", "contact.restitution")
    first, *_ = tables(said)["contact.restitution"]
    assert first[2] == "+1"  # e v, for e + 1 %
    assert first[3] == first[5] == "–"  # peak, duration


def test_a_limit_is_said_in_words(run, here):
    (here / "rod.toml").write_text(
        'name = "Rod"\n[chain]\nlinks = [{ length = 1.0, mass = 1.0 }]\n[box]\ny_min = 0.0\n'
        '[contact]\nmodel = "newton_impact"\n[initial]\nangles = [0.0]\nposition = [0.0, 0.1]\n'
    )
    asked = ("--stop-time", "0.3", "--sensitivity", "contact.restitution")
    code, said, errors = run("simulate", "rod.toml", *asked)
    assert (code, errors) == (0, "")
    (limit,) = re.findall(r"^limit +(there are no derivatives from t = \S+ s on, .*)$", said, re.M)
    assert "at y_min: several points arrive at one moment" in limit


@pytest.mark.full("takes long")
def test_picture_and_table(run, here):
    asked = ("--stop-time", "0.5", "--sensitivity", "gravity.y", "--plot", "rod.svg", "--csv", "rod.csv")
    code, said, _ = run("simulate", "rod_drop", *asked)
    assert (code, said.splitlines()[:2]) == (0, ["results  rod.csv", "picture  rod.svg"])
    picture = (here / "rod.svg").read_text(encoding="utf-8")
    assert "change of peak force [%]" in re.sub(r"<!-- | -->", "", picture)
    with (here / "rod.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    found = np.array([float(row[head.index("sensitivity.gravity.y.point[1].y")]) for row in rows])
    time = np.array([float(row[0]) for row in rows])
    # the derivative is ½ t² until the first impact
    falling = time < 0.3
    np.testing.assert_allclose(found[falling], 0.5 * time[falling] ** 2, atol=1e-12)


def test_the_window_shows_them(run, monkeypatch):
    from matplotlib import pyplot
    from matplotlib.figure import Figure

    shown = []
    window = Figure(layout="constrained")
    monkeypatch.setattr("chain_impact.cli.simulate.open_window", lambda: window)
    monkeypatch.setattr(pyplot, "show", lambda: shown.append(window.get_suptitle()))
    run("simulate", "rod_drop", "--stop-time", "0.5", "--sensitivity", "gravity.y", "--show")
    assert shown == [window.get_suptitle()]
    assert "gravity y + 1 %" in shown[0]


def test_rank_orders_all_parameters_and_draws_bars(run, here):
    code, said, errors = run("simulate", "pinned_arm", "--rank", "peak_force", "--plot", "bars.png")
    assert (code, errors) == (0, "")
    _, _, told = said.partition("PinnedArm  peak_force = 1015.53 N")
    rows = told.splitlines()
    assert [row.split()[0] for row in rows[4:6]] == ["initial.angle[1]", "gravity.y"]
    assert (
        told.index(" link[2].joint_damping")
        < told.index("added to a parameter that is 0")
        < told.index("joint[1].torque")
    )
    assert "contact.exponent is left out" in told
    assert "without effect: link[1].joint_rest_angle" in told
    assert (here / "bars.png").stat().st_size > 10_000
    few = run("simulate", "pinned_arm", "--rank", "energy.total", "--sensitivity", "contact.*")[1]
    assert "contact.restitution" in few
    assert "gravity" not in few
    assert "impulse" not in few  # the list of impacts
    assert run("simulate", "a.fmu", "--rank", "peak_force")[0] == 2


def test_a_ranking_by_the_force_in_joints_needs_no_key_of_the_scene(run):
    command = ("simulate", "pinned_arm", "--stop-time", "0.55", "--rank", "joint_force", "--sensitivity")
    code, said, errors = run(*command, "link[*].mass")
    assert (code, errors) == (0, "")
    assert said == run(*command, "link[*].mass", "--set", "outputs.loads=true")[1]
    assert "link[2].mass" in said


def test_rank_tells_which_effects_a_run_with_the_new_value_refutes(run):
    said = run("simulate", "four_link_box", "--stop-time", "0.52", "--rank", "peak_force")[1]
    assert "for 16 of 37 effects: all agree within 25 %" in said
    late = run("simulate", "four_link_box", "--rank", "point[4].x", "--sensitivity", "initial.*")[1]
    head, *rows = late.partition("to first order")[2].splitlines()[1:]
    assert head.endswith("in a run")
    assert "differ by more than" in late.partition("effect   of 1 %")[0]  # the news stands at the top
    name, *_, simulated = rows[0].split()
    assert name.startswith("initial.")
    assert abs(float(simulated)) < 3.0  # m, the width of the box

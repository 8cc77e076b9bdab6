"""The printed report of a fit."""

from dataclasses import replace

import pytest

from chain_impact import fit, simulate
from chain_impact.studies.fit.report import rounded_text
from chain_impact.text import aligned_lines
from tests.helpers.scenes.stops import struck_rod
from tests.helpers.tools.measurements import FREE, NOISE, TIP, impacts, motion, scene


@pytest.fixture(scope="module")
def lines():
    columns, result = motion(0.7)
    fit_result = fit(
        scene(K=5e7, e=0.6),
        [[columns, impacts(result, ["peak_force"], noise=0.02)]],
        FREE,
        sigma={TIP[0]: NOISE, "peak_force": "2%"},
    )
    return repr(fit_result).splitlines()


def test_a_fit_is_printed_whole(lines):
    assert lines[0] == "FourLinkBox  zhang_sharf, 402 values, 3 free parameters"
    assert lines[2].split("  ")[0] == "parameter"
    assert [line.split()[:2] for line in lines[3:6]] == [[FREE[0], "5e7"], [FREE[1], "0.6"], [FREE[2], "1.5"]]
    assert " … " in lines[3]
    assert "N/m^1.5" in lines[3]
    assert "rad/s" in lines[5]
    by_name = {line.split()[0]: line for line in lines if line}
    assert "1 mm given" in by_name[TIP[0]]
    assert "estimated" in by_name[TIP[1]]
    assert by_name["peak_force"].count("…") == 1
    assert "χ² per degree of freedom" in by_name["converged;"]


def test_impacts_at_stops_of_joints_have_units_of_rotation():
    scene = struck_rod("flores", 0.5)
    onset, impulse = (float(simulate(scene).impacts[0][name]) for name in ("onset", "impulse"))
    table = {"point": [1], "wall": ["joint_max"], "onset": [onset], "impulse": [1.02 * impulse]}
    fit_result = fit(scene, table, ["stops.restitution"], sigma={"onset": 1e-4, "impulse": "1%"})
    (line,) = [line for line in repr(fit_result).splitlines() if line.startswith("impulse ")]
    assert "N·m·s" in line


def test_many_horizons_are_not_listed():
    fit_result = fit(scene(), motion(0.5)[0], FREE[2:])
    text = repr(replace(fit_result, horizons=tuple(range(1, 13))))
    assert "first with data until 1 s, then until 2, …, 11, 12 s" in text


def test_high_correlations_are_told():
    fit_result = fit(scene(), motion(1.2)[0], FREE)
    assert fit_result.correlation[0, 2] < -0.99
    note = (
        f"The estimates of {FREE[0]} and {FREE[2]} have a correlation of {fit_result.correlation[0, 2]:.3f}."
    )
    assert note in repr(fit_result).splitlines()


@pytest.mark.full("takes long")
def test_a_ranking_is_printed():
    columns, _ = motion(0.6, count=30)
    fit_result = fit(scene(), columns, ["contact.restitution"], laws=True)
    text = repr(fit_result)
    assert "\nlaw " in text
    assert "ΔAIC" in text
    *rows, _, last = text[text.index("\nlaw ") :].splitlines()[2:]
    assert last.endswith("laws fit equally well, with ΔAIC < 2: these data cannot tell them apart.")
    assert len(rows) == len(fit_result.ranking)
    assert rows[0].split()[:2] == [fit_result.ranking[0].law, "0.0"]


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.70012345, 0.0013, "0.7001"),
        (1.0123e8, 2e6, "1.012e8"),
        (3.21e7, 4e7, "3.2e7"),
        (-9.8123, 0.02, "-9.812"),
        (0.5, float("inf"), "0.5"),
        (0.0, 0.1, "0"),
    ],
)
def test_digits_follow_the_standard_error(value, error, text):
    assert rounded_text(value, error) == text


def test_columns_are_aligned():
    assert list(aligned_lines(("a", "bb"), [("ccc", "d")])) == ["a    bb", "ccc  d"]
    assert list(aligned_lines(("a", "b\nN"), [("ccc", "d")])) == ["     b", "a    N", "ccc  d"]

"""The picture of a comparison."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact import CONTACT_LAWS, compare
from chain_impact.scene import with_values
from chain_impact.studies.compare import realised_restitution
from chain_impact.studies.compare_plot import PRESCRIBED, fill, looks_of, plot_comparison
from tests.problems import default_scene


@pytest.fixture(scope="module")
def comparison():
    return compare(default_scene())


@pytest.fixture(scope="module")
def curves(comparison):
    return realised_restitution(comparison, PRESCRIBED)


def drawn(comparison, curves):
    page = Figure(figsize=(15.0, 5.6), layout="constrained")
    fill(page, comparison, curves)
    page.draw_without_rendering()
    return page


def test_every_law_is_in_the_legend_and_twins_share_a_look(comparison, curves):
    looks = looks_of(comparison, curves)
    names = [name for look in looks.values() for name in look["label"].split(", ")]
    assert sorted(names) == sorted(CONTACT_LAWS)
    assert looks["ye"]["label"] == "ye, flores"
    styles = [(str(look["color"]), str(look.get("linestyle"))) for look in looks.values()]
    assert len(set(styles)) == len(styles)


def test_the_panels_show_restitution_loops_and_energy(comparison, curves):
    page = drawn(comparison, curves)
    restitution, loops, energy = page.axes
    count = len(looks_of(comparison, curves))
    assert len(restitution.lines) == count + 1  # and the scene's e
    assert len(loops.lines) == len(energy.lines) == count
    line = next(line for line in loops.lines if line.get_label() == "zhang_sharf")
    np.testing.assert_allclose(line.get_xydata().T, comparison["zhang_sharf"].loop * [[1e3], [1e-3]])
    names = [axes.get_xlabel() for axes in page.axes] + [axes.get_ylabel() for axes in page.axes]
    assert sum("[" in name for name in names) == 4


def test_the_legend_covers_no_panel(comparison, curves):
    page = drawn(comparison, curves)
    (legend,) = page.legends
    box = legend.get_window_extent()
    assert not any(axes.get_window_extent().overlaps(box) for axes in page.axes)
    assert page.bbox.x1 >= box.x1


def test_laws_that_did_not_run_leave_the_others_in_the_picture(tmp_path):
    comparison = compare(
        with_values(default_scene(model="hertz", restitution=0.0), {("simulation", "stop_time"): 0.6})
    )
    told = []
    plot_comparison(comparison, tmp_path / "laws.svg", progress=told.append)
    assert told[-1] == 1.0
    assert "<svg" in (tmp_path / "laws.svg").read_text(encoding="utf-8")

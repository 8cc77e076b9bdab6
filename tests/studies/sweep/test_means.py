"""A picture of very many runs shows means of cells, which are those of the rows."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from chain_impact.kernel.status import OK
from chain_impact.scene.scene import load_scene
from chain_impact.studies.sweep import means as module, plot
from chain_impact.studies.sweep.job import STATUS
from chain_impact.studies.sweep.means import means
from chain_impact.studies.sweep.sweep import sweep
from chain_impact.studies.sweep.variation import Variation

SCENE = load_scene("four_link_box").with_values({"simulation.stop_time": 0.6, "solver.tolerance": 1e-6})


@pytest.fixture
def few_cells(monkeypatch):
    monkeypatch.setattr(module, "MOST_CELLS", 3)
    monkeypatch.setattr(module, "FULL", 1)
    monkeypatch.setattr(plot, "MOST_DRAWN", 10)


def drawn(found):
    page = Figure(layout="constrained")
    plot.fill(page, found)
    return page


def test_cells_of_a_grid(few_cells):
    """Restitution 0 is allowed for none of these laws: its runs fail, and count for no mean."""
    vary = {
        "contact.model": "hertz,flores",
        "contact.restitution": "0,0.8,0.3,0.5,0.1",
        "initial.x": "0.5,0.6",
    }
    found = sweep(SCENE, vary)
    table = found.to_dataframe()
    e, x, law = found.design.variations[1], found.design.variations[2], found.design.variations[0]
    small = means(found, (e, law), ("peak_force",))
    assert small.varied == ("contact.restitution", "contact.model")
    assert small["contact.restitution"] == pytest.approx(np.repeat([0.05, 0.4, 0.8], 2))
    assert small["contact.model"].tolist() == ["hertz", "flores"] * 3
    for row in small.table:
        low, high = {0.05: (0.0, 0.1), 0.4: (0.3, 0.5), 0.8: (0.8, 0.8)}[round(row["contact.restitution"], 9)]
        own = table[table["contact.restitution"].between(low, high)]
        own = own[(own["contact.model"] == row["contact.model"]) & (own["status"] == "ok")]
        assert row["peak_force"] == pytest.approx(own["peak_force"].mean(), rel=1e-13)
    assert not small.failed.any()
    assert means(found, (x,), ("peak_force",)).design.shape == (2,)


def test_cells_whose_runs_all_failed_are_grey(few_cells):
    found = sweep(SCENE, {"contact.restitution": "0,0.3,0.6", "initial.x": "0.5:0.6:4"})
    page = drawn(found)
    shown = page.axes[0].collections[0].get_array()
    assert shown.mask.tolist() == [[True, False, False]] * 3
    force = 1e-3 * found["peak_force"].reshape(3, 4)[1:]
    assert shown[0, 1:].tolist() == pytest.approx(force[:, :2].mean(axis=1).tolist(), rel=1e-13)
    assert shown[1:, 1:].data == pytest.approx(force[:, 2:].T, rel=1e-13)
    assert "12 runs" in page.get_suptitle()
    assert "4 failed" in page.get_suptitle()
    texts = [text.get_text() for text in page.texts] + [axes.get_title() for axes in page.axes]
    assert any("means of neighbouring runs" in text for text in texts)


@pytest.mark.parametrize("ends", ["1e6:1e9:log", "1e9:1e6:log"])
def test_cells_of_samples(few_cells, ends):
    vary = {"contact.restitution": "0.3:0.6", "contact.stiffness": ends, "initial.x": "0.5:0.6"}
    found = sweep(SCENE, vary, samples=40)
    small = means(found, found.design.variations[:2], ("peak_force", "impact.count"))
    assert small.design.shape == (3, 3)
    e, k = small["contact.restitution"].reshape(3, 3), small["contact.stiffness"].reshape(3, 3)
    assert e[:, 0] == pytest.approx([0.35, 0.45, 0.55])
    assert k[0] == pytest.approx(10.0 ** np.array([6.5, 7.5, 8.5]))
    first = (found["contact.restitution"] - 0.3) * 10
    second = np.log10(found["contact.stiffness"]) - 6.0
    for i, j in np.ndindex(3, 3):
        own = (first.astype(int) == i) & (second.astype(int) == j)
        assert own.any()
        for name in ("peak_force", "impact.count"):
            assert small[name].reshape(3, 3)[i, j] == pytest.approx(found[name][own].mean(), rel=1e-13)
    assert (small[STATUS] == OK).all()
    assert drawn(found).axes[0].collections


def test_one_number_and_a_choice_are_curves(few_cells):
    found = sweep(SCENE, {"contact.restitution": "0.3:0.8:6", "contact.model": "flores,hertz"})
    axes = drawn(found).axes[0]
    forces = 1e-3 * found["peak_force"].reshape(3, 2, 2).mean(axis=1)
    for line, law in zip(axes.lines, (1, 0), strict=True):  # in the order of their numbers
        assert line.get_xdata() == pytest.approx([0.35, 0.55, 0.75])
        assert line.get_ydata() == pytest.approx(forces[:, law], rel=1e-13)


def test_few_runs_are_drawn_as_they_are():
    found = sweep(SCENE, {"contact.restitution": "0.3:0.8:300"})
    assert len(drawn(found).axes[0].lines[0].get_xdata()) == 300


def test_an_axis_has_no_more_cells_than_its_values():
    one = Variation(
        sweep(SCENE, {"initial.x": [0.5]}).design.variations[0].variable, np.array([3.0, 1.0, 2.0])
    )
    middles, bounds = module._cells(one, 10)
    assert middles.values.tolist() == [1.0, 2.0, 3.0]
    assert bounds.tolist() == [2.0, 3.0]

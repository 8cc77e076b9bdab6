"""The co-simulation of an arm on a carriage: impulses to the carriage, motion to the arm."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.helpers.models import driven
from tests.helpers.scenes.model_files import co_simulated
from tests.tiers import needs_interop

START = [-2.4, -2.1]  # rad
IMPACT = 0.49  # s, before the impact of the tip
SCRIPT = Path(__file__).parents[2] / "models" / "carried_arm" / "co_simulation.py"


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """Return the columns and the picture of the co-simulation with the script's defaults."""
    folder = tmp_path_factory.mktemp("usual")
    picture = folder / "carriage.png"
    return co_simulated("carried_arm", folder, "--plot", picture), picture


@pytest.mark.full("builds two FMUs")
@pytest.mark.parametrize("target", ["native", "pythonfmu"])
def test_the_error_before_the_impact_is_proportional_to_the_step(target, usual, tmp_path):
    """The reference is a single simulation of carriage and arm."""
    errors = []
    for step in ("1e-3", "5e-4"):
        if (target, step) == ("native", "1e-3"):
            columns, _ = usual
        else:
            columns = co_simulated("carried_arm", tmp_path, "--target", target, "--step", step)
        rows = columns["time"] < IMPACT
        exact = driven.carried(columns["time"][rows], START)
        errors.append(np.abs(columns["base.x"][rows] - exact[:, 0]).max())
    assert errors[0] < 1.5e-4
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.1)


def test_the_curve_of_the_force_reaches_its_largest_value(monkeypatch):
    """The largest force may lie between two communication points."""
    figures, draw = [], runpy.run_path(SCRIPT)["draw"]
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: figures.append(figure))
    names = ("base.x", "joint[1].force.x", "joint[1].force.y", "joint[1].impulse.x")
    columns = dict.fromkeys(names, np.zeros(4)) | {"joint[1].force.x": np.array([1.0, 1.0, 7.0, 2.0])}
    draw("", np.arange(4.0), columns | {"joint[1].peak_force": np.array([1.0, 1.0, 7.0, 8.0])})
    curve, dot = figures[0].axes[1].lines
    assert curve.get_ydata().tolist() == [1.0, 1.0, 7.0, 8.0]
    assert dot.get_xydata().tolist() == [[3.0, 8.0]]


@pytest.mark.full("builds two FMUs")
def test_no_impulse_is_lost_between_communication_points(usual):
    """The impulses of joint and wall equal the change of the arm's momentum, impacts included."""
    columns, picture = usual
    assert picture.stat().st_size > 10_000
    momentum = sum(
        0.5 * mass * (columns[f"point[{k}].vx"] + columns[f"point[{k + 1}].vx"])
        for k, (_, mass, _) in enumerate(driven.ARM)
    )
    given = columns["joint[1].impulse.x"] + columns["contact[2].x_max.impulse"] * -1.0
    assert columns["impact.count"][-1] >= 1
    np.testing.assert_allclose(momentum - momentum[0], given, rtol=0, atol=1e-8)
    # the carriage has received the same impulse, without the impulse of its last step
    mass, spring, damper = driven.CARRIAGE
    step = columns["time"][1]
    resisted = np.cumsum(spring * columns["base.x"] + damper * columns["base.vx"]) * step
    lost = mass * columns["base.vx"] + resisted + columns["joint[1].impulse.x"]
    assert np.abs(lost[-200:]).max() < 0.02 * np.abs(columns["joint[1].impulse.x"]).max()


@needs_interop
def test_another_master_has_the_same_results(usual, tmp_path):
    own_columns, _ = usual
    for master in ("libcosim", "ecos"):
        theirs = co_simulated("carried_arm", tmp_path, "--master", master)
        for name in ("base.x", "link[2].angle", "joint[1].impulse.x"):
            message = f"{name} with {master}"
            np.testing.assert_allclose(theirs[name], own_columns[name], rtol=0, atol=1e-6, err_msg=message)

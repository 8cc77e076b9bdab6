"""The content of a fit, and its file."""

# Tests: studies/fit/estimates.py, studies/fit/result.py

import math

import numpy as np
import pytest

from chain_impact import Fit, fit, load_scene
from chain_impact.scene.scene import scene_file_path
from tests.helpers.tools.measurements import NOISE, TIP, motion, scene


@pytest.fixture(scope="module")
def fit_result():
    return fit(
        scene(e=0.6), motion(0.6, count=50)[0], ["contact.restitution"], sigma=dict.fromkeys(TIP, NOISE)
    )


def test_numbers_that_follow(fit_result):
    assert isinstance(fit_result, Fit)
    assert fit_result.freedom == 99
    assert fit_result.chi_squared == pytest.approx(float(np.sum((fit_result.residuals / NOISE) ** 2)))
    assert fit_result.reduced_chi_squared == pytest.approx(fit_result.chi_squared / 99)
    assert {
        name: int(is_of_column.sum()) for name, is_of_column in fit_result.columns.items()
    } == dict.fromkeys(TIP, 50)


def test_without_freedom_there_is_no_reduced_chi_squared():
    exact_fit = fit(scene(), {"time": [0.2], "point[4].x": [2.4]}, ["initial.x"], sigma={"point[4].x": NOISE})
    assert exact_fit.freedom == 0
    assert math.isnan(exact_fit.reduced_chi_squared)


def test_the_fitted_scene_as_a_file(fit_result, tmp_path):
    fit_result.save(tmp_path / "like.toml", scene_file_path("four_link_box"))
    fit_result.save(tmp_path / "plain.toml")
    assert load_scene(tmp_path / "like.toml") == load_scene(tmp_path / "plain.toml") == fit_result.scene
    assert "# Four equal rods" in (tmp_path / "like.toml").read_text(encoding="utf-8")

"""The contact laws ranked by their fit."""

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, fit, load_scene, simulate
from tests.helpers.tools.measurements import FREE, NOISE, TIP, impacts, motion, scene

NAMES = ("peak_force", "duration", "separation_speed")


@pytest.fixture(scope="module")
def fit_result():
    columns, result = motion(0.7)
    table = impacts(result, NAMES, noise=0.005)
    sigma = dict.fromkeys(TIP, NOISE) | dict.fromkeys(NAMES, "0.5%")
    return fit(scene(K=5e7, e=0.6), [[columns, table]], FREE, sigma=sigma, laws=True)


def test_every_law_is_ranked_the_best_first(fit_result):
    assert {entry.law for entry in fit_result.ranking} == set(CONTACT_LAWS)
    laws = [entry.law for entry in fit_result.ranking]
    assert laws[0] == fit_result.scene.contact.model == fit_result.ranking[0].fit.scene.contact.model
    full = [
        round(entry.fit.aic, 1)
        for entry in fit_result.ranking
        if entry.fit and not entry.note.endswith("not comparable")
    ]
    assert full == sorted(full)


def test_the_law_of_the_data_is_among_the_best_and_others_are_not(fit_result):
    ranked = {entry.law: entry.fit.aic - fit_result.aic for entry in fit_result.ranking if entry.fit}
    assert ranked["zhang_sharf"] < 5.0
    for law in ("kelvin_voigt", "hertz", "kuwabara_kono", "gharib_hurmuzlu"):
        assert ranked[law] > 50.0


def test_starts_are_those_of_the_user(fit_result):
    assert [parameter.start for parameter in fit_result.parameters] == [5e7, 0.6, 1.5]


def test_a_law_that_cannot_tell_what_was_measured_is_noted(fit_result):
    """An impulse has no peak force."""
    newton = next(entry for entry in fit_result.ranking if entry.law == "newton_impact")
    assert newton.fit is None
    assert "newton_impact, has no peak_force" in newton.note
    assert fit_result.ranking[-1] == newton


def test_a_law_that_does_not_allow_the_restitution_is_noted():
    ball = load_scene("bouncing_ball").with_values(
        {"contact.restitution": 0.0, "contact.model": "hunt_crossley"}
    )
    result = simulate(ball, stop_time=1.0, output_step=0.02)
    columns = {"time": result.time, "point[0].y": result["point[0].y"]}
    fit_result = fit(ball, columns, ["initial.vy"], sigma={"point[0].y": 1e-3}, laws=True)
    noted = {entry.law: entry.note for entry in fit_result.ranking if entry.fit is None}
    assert "zhang_sharf" in noted
    assert "contact.restitution" in noted["zhang_sharf"]
    assert np.isfinite(fit_result.aic)

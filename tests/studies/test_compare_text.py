"""A comparison as text: a small table, and advice that is true."""

import math
from dataclasses import replace

import pytest

from chain_impact import CONTACT_LAWS, compare
from chain_impact.scene.scene import with_values
from chain_impact.studies.compare import OVERLAP
from chain_impact.studies.compare_text import advice
from tests.problems import default_scene, flat_rod


@pytest.fixture(scope="module")
def box():
    return compare(default_scene())


def test_advice_is_the_exact_law_with_the_registrys_reason(box):
    first, near, unfit = advice(box)
    assert first.endswith(
        f"here, e′ = {box['zhang_sharf'].restitution:.4g}, because other forces act during the contact."
    )
    assert first.startswith(f"for e = 0.7: zhang_sharf. {CONTACT_LAWS['zhang_sharf'].limits}")
    assert "hu_guo" in near
    assert {"hertz", "gharib_hurmuzlu"} <= set(unfit.partition(": ")[2].split(", "))
    told = {*near.partition(": ")[2].split(", "), *unfit.partition(": ")[2].split(", "), "zhang_sharf"}
    assert told == set(CONTACT_LAWS)


def test_advice_from_contacts_together_is_by_the_ranges_of_the_laws():
    """A rod that falls flat: its ends touch together, so its first impact tells nothing of the laws."""
    together = compare(flat_rod(), laws=["zhang_sharf", "hu_guo", "hertz"])
    run = replace(together["zhang_sharf"], restitution=0.1239, note=OVERLAP)
    e = together.scene.contact.restitution
    told = advice(replace(together, runs=(replace(together["hertz"], restitution=e), run)))
    assert told[0] == (
        f"for e = {e:g}: zhang_sharf. {CONTACT_LAWS['zhang_sharf'].limits} In the first impact here, "
        "e′ = 0.1239 instead, because another contact began before the first ended: e is the restitution of "
        "one contact on its own."
    )
    assert told[1:] == [f"not for e = {e:g}: hertz"]


def test_printed_it_is_a_small_table():
    found = compare(default_scene(), laws=["flores", "zhang_sharf"])
    lines = repr(found).splitlines()
    assert lines[0].startswith("FourLinkBox  e = 0.7")
    assert [line.split()[0] for line in lines[1:4]] == ["law", "zhang_sharf", "flores"]
    assert lines[-2].startswith("for e = 0.7: zhang_sharf")
    assert len(repr(found["flores"])) < 500


def test_advice_where_the_exact_law_is_not_allowed_is_the_nearest():
    comparison = compare(default_scene(model="hertz", restitution=0.0))
    law = min(
        (run for run in comparison.runs if math.isfinite(run.restitution)), key=lambda run: run.restitution
    )
    assert advice(comparison)[0].startswith(f"for e = 0: {law.law}. Of the laws that ran, ")


def test_there_is_no_advice_from_contacts_that_do_not_end():
    scene = with_values(default_scene(), {("simulation", "stop_time"): 0.4995})
    comparison = compare(scene)
    (told,) = advice(comparison)  # an impulse is over
    assert told.startswith("for e = 0.7: newton_impact. ")
    assert "zhang_sharf" not in told
    forces = tuple(run for run in comparison.runs if not CONTACT_LAWS[run.law].impulsive)
    assert advice(replace(comparison, runs=forces)) == [
        "for e = 0.7: none, as no law finished its first impact"
    ]


def test_without_rebound_rigid_walls_are_what_is_left():
    """At e = 0 the wall holds the point that it stopped, which is no part of the impact."""
    comparison = compare(with_values(default_scene(model="hertz"), {("contact", "restitution"): 0.0}))
    rigid = comparison["newton_impact"]
    assert (rigid.restitution, rigid.duration, rigid.peak_force) == (0.0, 0.0, 0.0)
    impact = rigid.result.impacts[0]
    lost = 0.5 * impact["effective_mass"] * impact["impact_speed"] ** 2
    assert rigid.energy_lost == pytest.approx(lost, rel=1e-9)
    assert advice(comparison)[0].startswith("for e = 0: newton_impact")

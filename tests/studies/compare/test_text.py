"""A comparison as text: a small table, and correct advice."""

from dataclasses import replace

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, compare, simulate
from chain_impact.scene.scene import with_values
from chain_impact.studies.compare.text import advice, law_table
from tests.helpers.scenes.problems import default_scene, driven


@pytest.fixture(scope="module")
def box():
    return compare(default_scene())


def test_advice_is_the_laws_that_realise_the_restitution_in_the_impact(box):
    laws = [run.law for run in box.runs if 0.665 <= run.restitution <= 0.735]
    assert {"zhang_sharf", "hu_guo", "newton_impact"} <= set(laws)
    # at 5 m/s this law dissipates more than at its design speed of 1 m/s
    assert "kuwabara_kono" not in laws
    text = advice(box)
    assert text.startswith(f"within 5 % of e = 0.7 in this impact: {len(laws)} laws")
    assert [law for law in CONTACT_LAWS if law in text] == ["zhang_sharf"]
    other_runs = [run for run in box.runs if run.law != "zhang_sharf"]
    comparison = replace(box, runs=(replace(box["zhang_sharf"], restitution=0.1), *other_runs))
    nearest_law = min(other_runs, key=lambda run: abs(run.restitution - 0.7)).law
    assert [law for law in CONTACT_LAWS if law in advice(comparison)] == [nearest_law]


def test_the_advice_names_all_of_a_few_laws(box):
    far_run = replace(box["zhang_sharf"], restitution=0.1)
    assert (
        advice(replace(box, runs=(far_run, box["flores"]))) == "within 5 % of e = 0.7 in this impact: flores"
    )


def test_no_law_is_named_whose_contact_does_not_end():
    scene = with_values(default_scene(), {("simulation", "stop_time"): 0.4995})
    comparison = compare(scene)
    assert advice(comparison).endswith(": newton_impact")  # an impulse ends at its onset
    forces = tuple(run for run in comparison.runs if not CONTACT_LAWS[run.law].rigid)
    assert advice(replace(comparison, runs=forces)).endswith(": none of these laws")


def test_the_restitutions_of_an_impact_under_other_forces_are_listed():
    """Servos press the tip onto the wall: without losses the restitution is 0.70 at K = 1e7."""
    comparison = compare(driven(), laws=["zhang_sharf", "lee_wang", "newton_impact"])
    assert not comparison.is_free
    assert [row.stiffness for row in comparison.reached] == [1e7, 1e8, 1e9]
    for row in comparison.reached:
        for law, value in (("hertz", row.lossless), ("zhang_sharf", row.exact)):
            values = {"contact.model": law, "contact.stiffness": row.stiffness}
            first = simulate(driven().with_values(values)).impacts[0]
            assert value == pytest.approx(first["separation_speed"] / first["impact_speed"], rel=1e-12)
    deviations = [abs(row.lossless - 1.0) for row in comparison.reached]
    assert deviations == sorted(deviations, reverse=True)
    laws_line, reach_line = advice(comparison).splitlines()
    assert laws_line.endswith(": newton_impact, as in any scene; lee_wang, in this scene, not in any")
    assert "0.15 at K = 1e+07 (0.70 lossless)" in reach_line


def test_a_free_impact_needs_no_other_stiffness(box):
    assert box.is_free
    assert len(box.reached) == 1
    assert box.reached[0].lossless == pytest.approx(1.0, abs=1e-3)


def test_printed_it_is_a_small_table():
    comparison = compare(default_scene(), laws=["flores", "zhang_sharf"])
    lines = repr(comparison).splitlines()
    assert lines[0].startswith("FourLinkBox  e = 0.7")
    assert [line.split()[0] for line in lines[1:4]] == ["law", "zhang_sharf", "flores"]
    assert lines[-1].startswith("within 5 % of e = 0.7 in this impact: zhang_sharf, flores; take zhang_sharf")
    assert len(repr(comparison["flores"])) < 500


def test_the_unit_of_each_column_suits_its_largest_value():
    soft = default_scene().with_values({"contact.stiffness": 1e2})
    head, rows = law_table(compare(soft, laws=["flores"]))
    assert head[2:4] == ("peak, N", "depth, mm")
    assert all(1.0 <= float(row[2]) < 1000.0 for row in rows)


def test_without_rebound_rigid_walls_are_what_is_left():
    """At e = 0 the wall holds the stopped point after the impact; the impact itself has no rebound."""
    comparison = compare(with_values(default_scene(model="hertz"), {("contact", "restitution"): 0.0}))
    rigid = comparison["newton_impact"]
    assert (rigid.restitution, rigid.duration, rigid.peak_force) == (0.0, 0.0, 0.0)
    impact = rigid.result.impacts[0]
    energy_lost = 0.5 * impact["effective_mass"] * impact["impact_speed"] ** 2
    assert rigid.energy_lost == pytest.approx(energy_lost, rel=1e-9)
    assert advice(comparison).startswith("within 5 % of e = 0 in this impact: newton_impact")


def test_advice_on_a_contact_that_is_pressed_does_not_deny_its_e():
    """The table has e′, so the sentence says why e′ does not lead to a law."""
    comparison = compare(driven(), laws=["zhang_sharf", "newton_impact"])
    run = comparison["zhang_sharf"]
    pressed = replace(run, loop=np.array([[0.0, 2.0, 1.0, 2.0, 0.0], np.zeros(5)]))
    text = advice(replace(comparison, runs=(pressed, comparison["newton_impact"])))
    assert text.startswith(
        "other forces push on during this contact, so e′ describes them, too, and does not "
    )
    assert " tell which laws realise e = 0.5\n" in text
    assert "no restitution" not in text

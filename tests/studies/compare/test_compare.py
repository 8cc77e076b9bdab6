"""Every law on the same scene, for comparison."""

# Tests: studies/compare/runs.py

import csv
import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, SceneError, compare, load_scene, simulate, with_law
from chain_impact.scene.files.models import models_folder
from chain_impact.scene.scene import with_values
from tests.helpers.models.reference import exact_damping_factor, realised_restitution as exact_restitution
from tests.helpers.scenes.problems import ball, default_scene, flat_rod, of_law, own_law, struck_ball
from tests.tiers import needs_compilers

OTHER_EXPONENT = [law for law in CONTACT_LAWS.values() if not law.allows_exponent(1.5)]


@pytest.fixture(scope="module")
def box():
    return compare(default_scene())


def test_every_law_has_a_row_in_the_order_of_the_registry(box):
    assert [run.law for run in box.runs] == list(CONTACT_LAWS)
    assert box.reference == "zhang_sharf"
    assert all(run.result is not None and run.impacts > 0 for run in box.runs)


@pytest.mark.parametrize("law", [law.id for law in CONTACT_LAWS.values() if law.allows_exponent(1.5)])
def test_a_row_tells_what_simulate_gives(box, law):
    result, run = simulate(default_scene(model=law)), box[law]
    first = result.impacts[0]
    assert run.peak_force == first["peak_force"]
    assert run.max_penetration == first["max_penetration"]
    assert run.duration == first["end"] - first["onset"]
    assert run.restitution == first["separation_speed"] / first["impact_speed"]
    counts = result.statistics
    assert (run.impacts, run.steps, run.evaluations) == (
        len(result.impacts),
        counts["steps"],
        counts["rhs_evaluations"],
    )


def test_the_energy_lost_is_that_of_the_effective_mass():
    scene, expected = struck_ball(damping_factor=exact_damping_factor(0.7))
    comparison = compare(scene)
    assert comparison["zhang_sharf"].energy_lost == pytest.approx(expected.dissipated, rel=1e-6)
    assert comparison["hertz"].energy_lost == pytest.approx(0.0, abs=1e-9)


def test_a_loop_is_the_first_impact_and_encloses_the_energy_lost(box):
    for run in box.runs:
        if run.duration == 0.0:  # a law of impulses
            assert run.loop.size == 0
            continue
        depth, force = run.loop
        assert depth.max() == pytest.approx(run.max_penetration, rel=1e-3)
        assert force.max() <= run.peak_force * (1 + 1e-6)
        # equal up to the mesh of the loop and, for a cut force, the energy left in the spring
        enclosed = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(depth))
        assert enclosed == pytest.approx(run.energy_lost, rel=0.02, abs=0.02)


def test_a_law_of_another_exponent_is_as_deep_as_an_elastic_one(box):
    assert OTHER_EXPONENT
    first, scene = box.first_impact, box.scene.contact
    energy = 0.5 * first["effective_mass"] * first["impact_speed"] ** 2
    depth = (2.5 * energy / scene.stiffness) ** 0.4
    for law in OTHER_EXPONENT:
        run = box[law.id]
        assert run.exponent == law.exponent
        assert run.stiffness * depth ** (run.exponent + 1) / (run.exponent + 1) == pytest.approx(energy)
        assert f"n = {run.exponent:g}, K = {run.stiffness:.4g} for the same elastic depth" in run.note
    assert {run.stiffness for run in box.runs if not run.note} == {scene.stiffness}


def test_a_scene_of_a_law_with_another_exponent():
    comparison = compare(default_scene(**of_law("kelvin_voigt"), stiffness=1e7))
    assert comparison["kelvin_voigt"].stiffness == 1e7
    assert comparison["tsuji"].exponent == 1.5
    assert comparison["zhang_sharf"].exponent == 1.0


def test_the_divergence_is_the_first_impact_elsewhere(box):
    def places(law):
        return [(row["point"], row["wall"]) for row in box[law].result.impacts]

    assert box["zhang_sharf"].divergence is None
    divergences = {run.law: run.divergence for run in box.runs if run.divergence}
    assert len(divergences) > 5
    for law, number in divergences.items():
        assert places(law)[: number - 1] == places("zhang_sharf")[: number - 1]
        assert places(law)[number - 1 : number] != places("zhang_sharf")[number - 1 : number]
        assert 0.0 < box[law].divergence_time < 2.0


def test_laws_that_do_not_allow_the_restitution_say_so():
    comparison = compare(default_scene(model="hertz", restitution=0.0))
    assert comparison.reference == "hertz"
    for law in CONTACT_LAWS.values():
        run = comparison[law.id]
        assert (run.result is not None) == law.allows_zero
        refusal = (
            f"contact.restitution = 0.0 must be > 0 for the contact model {law.id}; newton_impact allows 0"
        )
        assert run.note.endswith("" if law.allows_zero else refusal)
        assert not run.note.startswith(comparison.scene.name)


def test_a_law_that_fails_keeps_its_row_with_what_it_gave():
    scene = with_values(default_scene(), {("solver", "work_limit"): 3000.0})
    stopped = [run for run in compare(scene).runs if "the simulation stopped at t = " in run.note]
    assert stopped
    assert all(math.isfinite(run.restitution) for run in stopped)


def test_overlapping_contacts_are_told():
    runs = compare(flat_rod()).runs
    assert sum(run.duration > 0 for run in runs) == len(runs) - 1
    assert all("another contact began before the first ended" in run.note for run in runs if run.duration > 0)


def test_a_contact_that_does_not_end_has_no_restitution():
    scene = with_values(default_scene(), {("simulation", "stop_time"): 0.4995})
    run = compare(scene)["zhang_sharf"]
    assert run.peak_force > 0.0
    assert all(math.isnan(value) for value in (run.restitution, run.duration, run.energy_lost))


def test_why_laws_of_stops_are_not_compared_is_told():
    with pytest.raises(SceneError, match=r"the stops keep stops\.model = flores, and no point can touch"):
        compare("arm_at_stop")


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({("simulation", "stop_time"): 0.1}, "there is none before 0.1 s"),
        ({("solver", "work_limit"): 1.0}, "the simulation stopped at t = "),
    ],
)
def test_without_an_impact_there_is_nothing_to_compare(changes, reason):
    with pytest.raises(SceneError, match=f"^FourLinkBox: no impact to compare the laws by: {reason}"):
        compare(with_values(default_scene(), changes))


@needs_compilers
def test_a_users_law_is_compared_too():
    comparison = compare(with_law(ball(height=0.01), own_law()))
    assert [run.law for run in comparison.runs] == [*CONTACT_LAWS, "mine"]
    assert comparison["mine"].restitution == pytest.approx(exact_restitution(0.2), rel=1e-6)


def test_progress_goes_from_nothing_to_all():
    fractions = []
    compare(ball(height=0.01), progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)


def test_the_csv_has_a_row_for_each_law(box, tmp_path):
    box.save_csv(tmp_path / "laws.csv")
    with (tmp_path / "laws.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["law"] for row in rows] == list(CONTACT_LAWS)
    for row, run in zip(rows, box.runs, strict=True):
        assert float(row["restitution"]) == run.restitution
        assert float(row["peak force [N]"]) == run.peak_force
        assert row["first other impact"] == ("" if run.divergence is None else str(run.divergence))


def test_some_laws_only():
    scene = default_scene()
    comparison = compare(scene, laws=["flores", "hertz"])
    assert [run.law for run in comparison.runs] == ["hertz", "flores"]
    single_law = compare(scene, laws=["kelvin_voigt"])
    assert [run.law for run in single_law.runs] == ["kelvin_voigt", scene.contact.model]
    unfit = str(compare(scene, laws=["hertz"]))
    assert unfit.endswith(f"of e = {scene.contact.restitution:g} in this impact: none of these laws")
    with pytest.raises(SceneError, match="flore is not a contact law; the nearest is flores"):
        compare(scene, laws=["flore"])
    with pytest.raises(SceneError, match=r"rubber is not a contact law; .*--list laws"):
        compare(scene, laws=["rubber"])
    with pytest.raises(SceneError, match="3 is not a contact law; "):
        compare(scene, laws=[3])


def test_a_scene_can_be_named(tmp_path):
    file = tmp_path / "drop.toml"
    text = (models_folder() / "rod_drop" / "scene.toml").read_text(encoding="utf-8")
    file.write_text(text.replace("stop_time = 2.0", "stop_time = 0.35"), encoding="utf-8")
    comparison = compare(file)
    assert comparison.scene == load_scene(file)
    assert comparison.first_impact["onset"] == compare(str(file)).first_impact["onset"]

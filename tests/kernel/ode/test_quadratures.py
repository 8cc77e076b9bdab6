"""Quadratures of a step, from its stages to the integrals; and impulses of walls in runs.

Gravity and the walls together change the momentum of the chain.
"""

from dataclasses import replace

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS, load_scene, simulate
from chain_impact.kernel.ode import quadratures
from chain_impact.kernel.ode.dense_output import interpolate_component
from chain_impact.kernel.record.constants import DENSE_COEFFICIENTS
from chain_impact.kernel.record.state import time_at
from chain_impact.scene.candidates import candidates_of
from chain_impact.scene.scene import scene_from_dict
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.models.reference import momenta
from tests.helpers.scenes.problems import default_scene, of_law
from tests.kernel.chains import chain, mark_touching
from tests.kernel.rubbing import rubbing_chain


def unbalanced(result):
    """Return the largest part of the momentum [N·s] that neither gravity nor the walls have given."""
    scene = result.scene
    momentum, _ = momenta(result)
    mass = sum(link.mass for link in scene.chain.links)
    walls = [scene.half_planes[scene.wall_names[wall]].normal for _, wall in candidates_of(scene)]
    given = result.outputs["impulse"] @ np.array(walls) + mass * np.outer(result.time, scene.gravity)
    return abs(momentum - momentum[0] - given).max()


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_momentum_balances_at_every_communication_point_under_every_law(law):
    result = simulate(default_scene(**of_law(law)), tolerance=1e-10)
    assert len(result.impacts) >= 5
    assert unbalanced(result) < 1e-8


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_points_released_by_a_rigid_wall_have_the_integral_of_their_force(tolerance):
    """A chain on the floor is lifted at its tip: one point after the other leaves the floor."""
    lying = {
        "name": "Drawn",
        "chain": {"links": [{"length": 0.5, "mass": 1.0}] * 3},
        "box": {"y_min": 0.0},
        "contact": {"model": "newton_impact", "restitution": 0.0},
        "inputs": {"tip_force": True},
        "initial": {"angles": [0.0] * 3},
    }
    result = simulate(
        scene_from_dict(lying, "lying"),
        0.5,
        1e-4,
        tolerance=tolerance,
        inputs={"tip.force.y": lambda t: 60.0 * t, "tip.force.x": lambda t: 3.0 * t},
    )
    force, impulse = result.outputs["force"], result.outputs["impulse"]
    floor = force.max(axis=0) > 0.0
    assert floor.sum() == 4
    assert (force[-1, floor] == 0.0).sum() >= 2, "released"
    # by Simpson's rule, where no row lies between a force and its end
    released = (force[2::2] == 0.0) != (force[:-2:2] == 0.0)
    steps = (force[:-2:2] + 4.0 * force[1:-1:2] + force[2::2]) / 6.0 * 2e-4
    errors = np.where(released, 0.0, np.abs(np.diff(impulse[::2], axis=0) - steps)).sum(axis=0)
    assert errors.max() < 300.0 * tolerance * impulse.max()


def test_without_them_the_motion_is_the_same_bit_by_bit():
    scene = load_scene("four_link_box")
    without = replace(scene, outputs=replace(scene.outputs, contacts=False, impacts=0))
    assert Instance(without).record["quadrature"]["computed"] == 0
    result, other = simulate(scene), simulate(without)
    for name in ("point_position", "point_velocity", "force", "dissipated"):
        np.testing.assert_array_equal(result.outputs[name], other.outputs[name])
    assert not other.outputs["impulse"].any()
    assert result.statistics == other.statistics


# --- single functions ---------------------------------------------------------------------------------------

TOUCHED = [1, 3]
FIELDS = ("state", "state_end", "tried_state", "integral", "rate", "rate_end", "impulse_at_onset")


@pytest.fixture
def d():
    """Return two contacts whose impulses, forces and stages are all different."""
    rng = np.random.default_rng(13)
    _, d = chain(rng, 2)
    d.quadrature.computed = 1
    mark_touching(d, TOUCHED)
    for name in FIELDS:
        d.quadrature[name][:] = rng.uniform(1.0, 9.0, len(d.quadrature[name]))
    d.quadrature.dense[:], d.quadrature.stage[:] = (
        rng.uniform(1.0, 9.0, part.shape) for part in (d.quadrature.dense, d.quadrature.stage)
    )
    d.contacts.force[:] = rng.uniform(1.0, 9.0, d.candidate_count)
    d.scratch.stage[:] = rng.uniform(0.1, 0.9, d.scratch.stage.shape)
    return d


def values(d, *names):
    return [d.quadrature[name][:2].tolist() for name in names]


def test_impulses_of_active_contacts_are_integrated_if_they_are_wanted(d):
    quadratures.reset_quadratures(d)
    assert d.quadrature.index[: d.quadrature.count].tolist() == TOUCHED
    mark_touching(d, [2])
    quadratures.reset_quadratures(d)
    assert d.quadrature.index[: d.quadrature.count].tolist() == [2]
    d.quadrature.computed = 0
    quadratures.reset_quadratures(d)
    assert d.quadrature.count == 0


@pytest.mark.parametrize(("contacts", "joints"), [(2, False), (1, True), (0, True)])
def test_integrals_of_dry_friction_follow_those_of_contacts(contacts, joints):
    """They are an impulse of friction for each contact, and the energy of all friction."""
    _, d, _ = rubbing_chain(np.random.default_rng(1), "free", contacts, joints)
    d.quadrature.computed = 1
    quadratures.reset_quadratures(d)
    own, touched = d.quadrature, d.contacts.active_index[:contacts]
    last = d.candidate_count + d.friction_element_count
    assert own.index[: own.count].tolist() == [*touched, *(d.candidate_count + touched), last]
    rng = np.random.default_rng(2)
    d.contacts.force[:], d.friction_element.force[:] = (
        rng.normal(size=d.candidate_count),
        rng.normal(size=d.friction_element_count),
    )
    d.friction.power = 3.5
    own.rate[:] = 99.0
    quadratures.store_end_rates(d)
    quadratures.commit_quadratures(d)
    expected = np.zeros(len(own.integral))
    expected[touched], expected[d.candidate_count + touched] = (
        d.contacts.force[touched],
        d.friction_element.force[touched],
    )
    expected[last] = 3.5
    assert own.rate.tolist() == expected.tolist()


@pytest.mark.parametrize("at_end", [False, True])
def test_a_stage_is_the_force_in_the_variable_of_the_step(d, at_end):
    """dp/ds = F dt/ds."""
    before = d.quadrature.stage.copy()
    (quadratures.set_quadrature_stage_at_end if at_end else quadratures.set_quadrature_stage)(d, 4)
    forces = d.quadrature.rate_end[:2] if at_end else d.contacts.force[TOUCHED]
    expected = forces * d.scratch.stage[4, time_at(2)]
    assert d.quadrature.stage[4, :2].tolist() == expected.tolist()
    before[4, :2] = expected
    assert d.quadrature.stage.tolist() == before.tolist()


def test_a_step_goes_on_from_the_last_one_and_may_be_cut_or_dropped(d):
    """The totals belong to the end of the step."""
    end, trial_state, total = *values(d, "state_end", "tried_state"), d.quadrature.integral.copy()
    quadratures.accept_quadratures(d)
    assert values(d, "state", "state_end") == [end, trial_state]
    expected = [interpolate_component(d.quadrature, 0.3, k) for k in range(2)]
    quadratures.truncate_quadratures(d, 0.3)
    assert values(d, "state", "state_end") == [end, expected]
    quadratures.commit_quadratures(d)
    total[TOUCHED] = expected
    assert d.quadrature.integral.tolist() == total.tolist()
    quadratures.roll_back_quadratures(d)
    assert values(d, "state", "state_end") == [end, end]


@pytest.mark.parametrize(
    ("rigid", "wall", "course", "expected"),
    [
        (0, (2, 0), [(5.0, 5.0), (4.9, 5.5)], [5.0, 5.5]),
        (1, (2, 0), [(5.0, 1.0), (4.0, 3.0)], [5.0, 2.0]),
        (1, (2, 0), [(5.0, 1.0), (4.0, 1.5)], [5.0, 1.0]),  # the correction never exceeds the other impulse
        (1, (2, 1), [(5.0, 1.0), (4.0, 3.0)], [5.0, 3.0]),  # stops of other joints do not take part
        (1, ((2, 3), 0), [(5.0, 1.0), (4.0, 3.0)], [5.0, 3.0]),  # other walls do not take part
    ],
)
def test_an_integral_that_falls_is_kept_or_its_sum_at_a_rigid_wall(d, rigid, wall, course, expected):
    make_rigid(d, rigid)
    d.candidate.wall[TOUCHED], d.candidate.stop[TOUCHED] = wall
    d.quadrature.state[:2], d.quadrature.state_end[:2] = course
    quadratures.correct_falling_quadratures(d)
    assert values(d, "state_end") == [expected]


def test_the_energy_of_dry_friction_does_not_fall(d):
    d.quadrature.index[1] = d.candidate_count + d.friction_element_count
    d.quadrature.state[:2], d.quadrature.state_end[:2] = (5.0, 1.0), (6.0, 0.5)
    quadratures.correct_falling_quadratures(d)
    assert values(d, "state_end") == [[6.0, 1.0]]


@pytest.mark.parametrize("kept", [1.0, 0.7])
def test_a_course_that_falls_is_below_all_that_follows(d, kept):
    thetas = np.linspace(0.0, kept, 71)
    d.quadrature.dense[:, 0], d.step.end_fraction = 0.0, kept
    d.quadrature.dense[:3, 0], d.quadrature.state[0] = (1.0, -1.9, 2.0), 3.0
    d.quadrature.state_end[0] = interpolate_component(d.quadrature, kept, 0)
    at = np.array([interpolate_component(d.quadrature, theta, 0) for theta in thetas])
    course = np.array([quadratures.quadrature_within(d, theta, 0) for theta in thetas])
    assert np.diff(at).min() < -1e-3
    assert np.diff(course).min() >= 0.0
    assert (course[0], course[-1]) == (3.0, d.quadrature.state_end[0])
    assert np.abs(course - np.maximum(3.0, at)).max() <= np.abs(at - at.clip(3.0)).max()


def test_a_new_phase_starts_from_the_totals(d):
    total, rate = d.quadrature.integral[TOUCHED].tolist(), d.quadrature.rate[TOUCHED].tolist()
    quadratures.reset_quadratures(d)
    assert values(d, "rate_end") == [rate]
    assert values(d, "state", "state_end") == [total, total]
    assert d.quadrature.dense.shape[0] == DENSE_COEFFICIENTS
    assert not d.quadrature.dense[:, :2].any()
    assert d.quadrature.dense[:, 2:].all()


@pytest.mark.parametrize("name", ["accept", "roll_back", "commit", "reset"])
def test_without_them_nothing_is_done(d, name):
    d.quadrature.computed, d.quadrature.count, d.quadrature.rate[:] = 0, 0, 0.0
    before = d.numpy_record.tobytes()
    getattr(quadratures, f"{name}_quadratures")(d)
    assert d.numpy_record.tobytes() == before


@pytest.mark.parametrize(
    ("rigid", "impulses", "given"), [([1, 3], (2.5, -1e-17), (2.5, 0.0)), ([3], (7.0, 2.0), (0.0, 2.0))]
)
def test_rigid_walls_give_their_impulses_at_once_and_none_that_pulls(d, rigid, impulses, given):
    """Compliant contacts get no immediate impulse."""
    make_rigid(d, np.isin(np.arange(d.candidate_count), rigid))
    d.constraints.impulse[:2] = impulses
    expected = d.quadrature.integral.copy()
    expected[TOUCHED] += given
    quadratures.add_impulses_of_impact(d)
    assert d.quadrature.integral.tolist() == expected.tolist()

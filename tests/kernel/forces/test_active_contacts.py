"""Contacts of a chain: the loads of their forces, their dissipation, and the beginning of a contact."""

import math
from functools import partial

import numpy as np
import pytest

from chain_impact.kernel import equations
from chain_impact.kernel.constraints import geometry, impulses
from chain_impact.kernel.forces import active_contacts
from chain_impact.kernel.forces.force_formula import elastic_energy, law_force, law_slopes
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.models.reference import mass_matrix, point_jacobian
from tests.helpers.scenes.problems import of_law
from tests.helpers.tools.differences import slope
from tests.kernel.chains import (
    chain,
    gradients,
    locate_touching_state,
    mark_touching,
    move_wall_to_depth,
    stopped_chain,
    stops_of,
    vectors,
)

DEPTH = 1e-3
LAWS = pytest.mark.parametrize("law", ["zhang_sharf", "kelvin_voigt", "jankowski", "hertz"])


def in_contact(law="zhang_sharf", touching=3):
    """Return a chain with contacts that have begun, at the depths DEPTH, 2 DEPTH …; its state and ∇g."""
    rng = np.random.default_rng(7)
    scene, d = chain(rng, 3, inputs=True, **of_law(law), restitution=0.6, minimum_impact_speed=9.0)
    d.inputs.tip_force[:] = 0.3, -0.8
    # candidates of other points, at other walls
    candidates = [1, 6, 15][:touching]
    y = locate_touching_state(rng, d, candidates)
    for c in candidates:
        active_contacts.latch_onset(d, c)
    for k, c in enumerate(candidates):
        move_wall_to_depth(d, c, DEPTH * (k + 1))
    active_contacts.set_kink_sides(d)
    return scene, d, y, candidates, gradients(scene, d, y[2:5], candidates)


@LAWS
@pytest.mark.parametrize("touching", [0, 1, 3])
def test_loads_do_the_work_of_the_contacts_and_of_the_input(law, touching):
    """Q = Σ F ∇g + f_tip·∇p_tip; the dissipated power is the walls' power minus the stored power."""
    scene, d, y, candidates, jacobian = in_contact(law, touching)
    d.scratch.applied_force.x[:] = d.scratch.applied_force.y[:] = 9.0  # loads of another state
    rates = jacobian @ y[5:10]
    forces = np.array(
        [active_contacts.contact_force(d, c, *geometry.clearance_and_rate(d, c)) for c in candidates]
    )
    lost = active_contacts.set_forces_of_step(d)
    result = sum(
        point_jacobian(scene, y[2:5], k).T @ load for k, load in enumerate(vectors(d.scratch.applied_force))
    )
    expected = point_jacobian(scene, y[2:5], 3).T @ [0.3, -0.8]
    if touching:
        expected = expected + jacobian.T @ forces
        assert (forces > 0.0).all()
        assert (d.contacts.force[candidates] == forces).all()
    np.testing.assert_allclose(result, expected, rtol=1e-11, atol=1e-11)
    # the power of the walls = power stored in springs + power of the dampers
    stored = sum(
        -rate * slope(partial(elastic_energy, d, candidates[k]), DEPTH * (k + 1), 1e-7 * abs(rate))
        for k, rate in enumerate(rates)
    )
    assert lost == pytest.approx(-forces @ rates - stored, abs=1e-6 * np.abs(forces * rates).sum())
    assert lost >= 0.0
    active_contacts.clear_applied_forces(d)
    assert vectors(d.scratch.applied_force).tolist() == [[0.0, 0.0]] * 3 + [[0.3, -0.8]]


@LAWS
def test_slopes_at_the_points_are_those_of_the_law(law):
    """At a distance of round-off from the wall the spring stiffness is zero."""
    _, d, _, candidates, _ = in_contact(law)
    for k, c in enumerate(candidates):
        gap, rate = geometry.clearance_and_rate(d, c)
        assert -gap == pytest.approx(DEPTH * (k + 1), rel=1e-9)
        assert active_contacts.contact_slopes(d, c) == law_slopes(d, c, -gap, -rate)
    assert active_contacts.apply_contact(d, c, 1e-16, 0.0) == 0.0
    assert active_contacts.contact_force(d, c, 1e-16, -0.7) == law_force(d, c, 0.0, 0.7)[0]


@pytest.mark.parametrize("law", ["zhang_sharf", "jankowski", "newton_impact"])
@pytest.mark.parametrize("speed", [2.0, 1e-4, 0.0, -0.5])
def test_a_contact_begins_with_what_the_impact_is(law, speed):
    """v₀ has a lower bound. Of a force law the depth is that of an elastic impact.

    K δⁿ⁺¹/(n+1) = ½ m v₀². Of the rigid law it is the length of the longest link.
    """
    rng = np.random.default_rng(3)
    scene, d = chain(rng, 3, **of_law(law), restitution=0.6, minimum_impact_speed=1e-2)
    c = d.candidate_count - 2
    y = locate_touching_state(rng, d, [c], depth=0.0)
    (gradient,) = gradients(scene, d, y[2:5], [c])
    shift = -speed - gradient @ y[5:10]
    normal = d.candidate.normal_x[c], d.candidate.normal_y[c]
    for part, n in zip((d.scratch.velocity.x, d.scratch.velocity.y), normal, strict=True):
        part[:] = part + shift * n
    for field in ("peak_force", "max_penetration", "force_rate"):
        d.contacts[field][c] = 7.0
    d.step.end, d.quadrature.integral[c], d.impact.count = 1.25, 3.5, 4
    active_contacts.latch_onset(d, c)
    touched = d.contacts
    first = max(speed, 1e-2)
    mass = 1.0 / (gradient @ np.linalg.solve(mass_matrix(scene, y[2:5]), gradient))
    assert touched.onset[c] == d.impact.last_time == 1.25
    assert touched.latched_speed[c] == pytest.approx(first, rel=1e-9)
    assert touched.impact_speed[c] == pytest.approx(max(0.0, speed), abs=1e-12)
    assert math.copysign(1.0, touched.impact_speed[c]) == 1.0
    assert d.impact.last_speed == touched.impact_speed[c]
    assert touched.penetration_rate[c] == pytest.approx(speed, abs=1e-12)
    assert touched.effective_mass[c] == pytest.approx(mass, rel=1e-10)
    assert [touched[name][c] for name in ("peak_force", "max_penetration")] == [0.0] * 2
    assert touched.force_rate[c] > 0.0
    assert (d.impact.count, d.impact.last_point) == (5, d.candidate.point[c])
    assert d.impact.last_wall == d.candidate.wall[c] + 1
    assert d.quadrature.impulse_at_onset[c] == 3.5
    assert touched.impact_number[c] == 5
    if law == "newton_impact":
        assert touched.expected_penetration[c] == d.chain.longest_link
    else:
        energy = 0.5 * mass * first**2
        assert elastic_energy(d, c, touched.expected_penetration[c]) == pytest.approx(energy, rel=1e-9)
        lost = active_contacts.contact_force(d, c, -1e-3, -first) - active_contacts.contact_force(
            d, c, -1e-3, 0.0
        )
        assert lost > 0.0


@pytest.mark.parametrize("law", ["zhang_sharf", "jankowski", "newton_impact"])
def test_the_side_of_its_kink_is_that_on_which_a_contact_is(law):
    """The kink is where the force is cut to zero, or the start of separation for approach damping."""
    _, d, _, candidates, _ = in_contact("zhang_sharf" if law == "newton_impact" else law)
    point, n = d.candidate.point, (d.candidate.normal_x, d.candidate.normal_y)
    sides = []
    for c, rate in zip(candidates, (-3.0, 0.0, 1e3), strict=True):
        d.scratch.velocity.x[point[c]], d.scratch.velocity.y[point[c]] = rate * n[0][c], rate * n[1][c]
        sides.append(int(rate > 0.0))
        assert (active_contacts.kink_height(d, c) < 0.0) == (rate > 0.0)
    assert len({int(point[c]) for c in candidates}) == 3
    d.contacts.beyond_kink[:] = [*[5] * d.candidate_count]
    make_rigid(d, law == "newton_impact")
    active_contacts.set_kink_sides(d)
    if d.contact_settings.any_rigid:  # a rigid wall has no contact force law
        assert (d.contacts.beyond_kink == 5).all()
        return
    assert d.contacts.beyond_kink[candidates].tolist() == sides
    assert (np.delete(d.contacts.beyond_kink, candidates) == 5).all()
    active_contacts.set_kink_side(d, candidates[2])
    assert d.contacts.beyond_kink[candidates[2]] == 1


def test_only_what_the_contacts_have_noted_is_forgotten():
    _, d = chain(np.random.default_rng(0), 3)
    mark_touching(d, [1, 4, 7])
    make_rigid(d, np.isin(np.arange(d.candidate_count), [4, 7]))
    d.contacts.kink_crossed[:], d.constraints.least_force[:] = 1, -2.0
    equations.clear_stage_notes(d)
    others = [c for c in range(d.candidate_count) if c not in (1, 4, 7)]
    assert not d.contacts.kink_crossed[[1, 4, 7]].any()
    assert not d.constraints.least_force[[4, 7]].any()
    assert d.contacts.kink_crossed[others].all()
    assert (d.constraints.least_force[others] == -2.0).all()


@pytest.mark.parametrize("touching", [[], [0], [3, 5], [2, 3, 7, 9, 14], range(16)])
@pytest.mark.parametrize("rigid", [[], [3], [0, 3, 8, 9], range(16)])
def test_contacts_with_a_force_are_listed_first_and_no_impulse_holds_them(touching, rigid):
    _, d = chain(np.random.default_rng(0), 3)
    mark_touching(d, touching)
    make_rigid(d, np.isin(np.arange(d.candidate_count), list(rigid)))
    d.contacts.active_count = d.contacts.force_law_count = 5
    d.contacts.active_index[:], listings = 11, int(d.contacts.contact_set)
    active_contacts.list_active_contacts(d)
    forces = [c for c in touching if c not in rigid]
    held = [c for c in touching if c in rigid]
    assert d.contacts.force_law_count == len(forces)
    assert d.contacts.active_index[: d.contacts.active_count].tolist() == forces + held
    impulses.activate_all(d)
    assert not d.constraints.in_active_set[: len(forces)].any()
    assert d.constraints.in_active_set[len(forces) : d.contacts.active_count].all()
    assert d.contacts.contact_set == listings + 1


@pytest.mark.parametrize("rigid", [1, 6, 15])
def test_beside_a_rigid_contact_only_the_others_have_a_force(rigid):
    """Loads and dissipation contain the other contacts alone."""
    _, d, _, candidates, _ = in_contact()
    others = [c for c in candidates if c != rigid]
    mark_touching(d, others)
    lost, loads = active_contacts.set_forces_of_step(d), vectors(d.scratch.applied_force)
    mark_touching(d, candidates)
    d.contacts.force[rigid] = -5.0
    make_rigid(d, np.arange(d.candidate_count) == rigid)
    assert active_contacts.set_forces_of_step(d) == lost
    np.testing.assert_array_equal(vectors(d.scratch.applied_force), loads)
    assert d.contacts.force[rigid] == -5.0


def test_the_stops_among_the_contacts_are_counted():
    _, d = stopped_chain(3)
    stops = stops_of(d)
    for touching in ([], [0, 1], stops[:1], [0, *stops[:3]], [*stops, 0]):
        d.contacts.active[:] = np.isin(np.arange(d.candidate_count), touching)
        d.contacts.joint_stop_count = 9
        active_contacts.list_active_contacts(d)
        assert d.contacts.active_count == len(touching)
        assert d.contacts.joint_stop_count == len(set(touching) & set(stops))

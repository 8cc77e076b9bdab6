"""The equations of motion: the terms of each kind of load, and the loads that are valid for a state."""

import numpy as np
import pytest

from chain_impact.kernel import equations
from chain_impact.kernel.chain import kinematics
from chain_impact.kernel.chain.drives import spring_energy
from chain_impact.kernel.forces import active_contacts, holding
from chain_impact.kernel.record import state
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.models.reference import generalized_force, mass_matrix, point_jacobian, set_vectors
from tests.kernel.chains import (
    chain,
    free_coordinates,
    locate_touching_state,
    mark_touching,
    move_wall_to_depth,
    random_state,
    relative_motion,
    vectors,
)

CASES = [("free", 1), ("free", 3), ("pinned", 1), ("pinned", 4)]
BASES = pytest.mark.parametrize(("base", "count"), CASES)


def prepared(base, count, touching=(), **more):
    """Return a chain with inputs in a state with some contacts, and the relative motions."""
    rng = np.random.default_rng([count, len(base)])
    options = {"springs": True, "dampers": True, "inputs": True} | more
    scene, d = chain(rng, count, base, **options)
    y = locate_touching_state(rng, d, touching)
    d.inputs.motor[:-1], d.inputs.tip_force[:] = rng.normal(size=count), rng.normal(size=2)
    d.scratch.moment[:] = 9.0  # moments of another state
    joints = relative_motion(count)[:, 2:]
    if base == "free":
        joints[0] = 0.0  # a free base has no joint
    return scene, d, y, joints


def omega_of(d, y):
    return y[state.omega_at(d.link_count) : state.omega_at(d.link_count) + d.link_count]


def rates(d, rate):
    return rate[state.velocity_at(d.link_count) : state.velocity_at(d.link_count) + d.link_count + 2]


@BASES
def test_moments_of_the_springs_are_the_slopes_of_their_energy(base, count):
    _, d, y, _ = prepared(base, count)
    d.scratch.moment[:] = 0.5
    equations.add_spring_moments(d, y)
    h = 1e-6
    for i in range(count):
        ahead, behind = y.copy(), y.copy()
        ahead[2 + i] += h
        behind[2 + i] -= h
        slope = (spring_energy(d, ahead) - spring_energy(d, behind)) / (2 * h)
        assert d.scratch.moment[i] - 0.5 == pytest.approx(-slope, rel=1e-7, abs=1e-7)


@BASES
@pytest.mark.parametrize("sprung", [0, 1])
def test_joint_moments_act_on_both_links_with_their_power(base, count, sprung):
    """Gᵀ (u − c G ω) with the rates G ω of the joints; dissipated Σ c (G ω)², supplied u·G ω + f·v."""
    scene, d, y, joints = prepared(base, count)
    d.chain.has_springs = sprung
    dissipated, supplied = equations.set_joint_moments(d, y)
    moments = d.scratch.moment.copy()
    if sprung:
        d.scratch.moment[:] = 0.0
        equations.add_spring_moments(d, y)
        moments -= d.scratch.moment
    damping = np.array([link.joint_damping for link in scene.chain.links])
    relative = joints @ omega_of(d, y)
    expected = joints.T @ (d.inputs.motor[:-1] - damping * relative)
    np.testing.assert_allclose(moments, expected, rtol=1e-11, atol=1e-12)
    assert dissipated == pytest.approx(damping @ relative**2, rel=1e-12, abs=1e-300)
    tip = point_jacobian(scene, y[2 : count + 2], count) @ y[count + 2 : 2 * count + 4]
    power = d.inputs.motor[:-1] @ relative + d.inputs.tip_force @ tip
    assert supplied == pytest.approx(power, rel=1e-11)


@BASES
@pytest.mark.parametrize("resisting", [False, True])
@pytest.mark.parametrize("inputs", [False, True])
def test_the_rate_solves_the_assembled_equations_under_the_present_loads(base, count, resisting, inputs):
    scene, d, y, _ = prepared(base, count, springs=resisting, dampers=resisting, inputs=inputs)
    rng, rate = np.random.default_rng(5), np.full(len(y), np.nan)
    loads = rng.normal(size=(count + 1, 2))
    set_vectors(d.scratch.applied_force, loads)
    moments, powers = np.zeros(count), (0.0, 0.0)
    if inputs or d.chain.has_springs_or_dampers:
        powers = equations.set_joint_moments(d, y)
        moments = d.scratch.moment.copy()
        d.scratch.moment[:] = 9.0
    else:
        d.scratch.moment[:] = 0.0
    equations.free_rate_from_forces(d, y, 1.5, rate)
    angles, free = y[2 : count + 2], free_coordinates(d)
    force = generalized_force(scene, angles, omega_of(d, y), loads, moments)
    expected = np.zeros(count + 2)
    expected[free] = np.linalg.solve(mass_matrix(scene, angles)[free, free], force[free])
    np.testing.assert_array_equal(rate[: count + 2], y[count + 2 : 2 * count + 4])
    np.testing.assert_allclose(rates(d, rate), expected, rtol=0, atol=1e-10 * np.abs(expected).max())
    assert rate[state.dissipated_at(count)] == pytest.approx(1.5 + powers[0], rel=1e-13)
    assert rate[state.supplied_at(count)] == powers[1]
    # in a step in time u has no rate, and the rate of time is one
    assert (rate[state.sundman_u_at(count)], rate[state.time_at(count)]) == (0.0, 1.0)


@BASES
def test_the_loads_of_a_located_state_are_those_of_its_contacts_and_inputs(base, count):
    _, d, y, _ = prepared(base, count, touching=[0, 3])
    for k, c in enumerate((0, 3)):
        active_contacts.latch_onset(d, c)
        move_wall_to_depth(d, c, 1e-3 * (k + 1))
    rate, expected, whole = (np.full(len(y), np.nan) for _ in range(3))
    equations.rate_from_points(d, y, rate)
    loads = vectors(d.scratch.applied_force)
    equations.free_rate_from_forces(d, y, active_contacts.set_forces_of_step(d), expected)
    np.testing.assert_array_equal(rate[:-2], expected[:-2])
    assert (vectors(d.scratch.applied_force) == loads).all()
    equations.rate_from_state(d, y, whole)
    np.testing.assert_array_equal(whole[:-2], rate[:-2])
    # without the walls: rigid walls have no forces here
    make_rigid(d)
    active_contacts.clear_applied_forces(d)
    only_inputs = vectors(d.scratch.applied_force)
    equations.free_rate_from_forces(d, y, 0.0, expected)
    d.scratch.applied_force.x[:] = d.scratch.applied_force.y[:] = 9.0
    equations.free_rate_from_inputs(d, y, rate)
    np.testing.assert_array_equal(rate[:-2], expected[:-2])
    assert (vectors(d.scratch.applied_force) == only_inputs).all()
    assert np.abs(rate[:-2] - whole[:-2]).max() > 1.0


@pytest.mark.parametrize("touching", [0, 1, 2])
@pytest.mark.parametrize("base", ["free", "pinned"])
def test_rigid_walls_hold_what_touches_them_by_forces_that_do_no_work(base, touching):
    """Their forces are the constraint forces, tested in test_holding.py."""
    rng = np.random.default_rng(touching)
    _, d = chain(rng, 4, base, model="newton_impact")
    candidates = [5, 14][:touching]
    y = locate_touching_state(rng, d, candidates, 0.0)
    rate, expected = np.full((2, len(y)), np.nan)
    equations.rate_from_points(d, y, rate)
    forces = d.contacts.force[candidates].tolist()
    equations.free_rate_from_inputs(d, y, expected)
    if touching:
        assert np.abs(rate[:-2] - expected[:-2]).max() > 0.1
        d.contacts.force[:] = np.nan
        holding.add_constraint_forces(d, y, expected)
    np.testing.assert_array_equal(rate[:-2], expected[:-2])
    np.testing.assert_array_equal(d.contacts.force[candidates], forces)
    assert rate[state.dissipated_at(4)] == 0.0


def test_in_free_flight_no_point_is_located():
    rng = np.random.default_rng(2)
    _, d = chain(rng, 3)
    y = random_state(rng, d)
    rate, other = np.full(len(y), np.nan), np.full(len(y), np.nan)
    d.scratch.position.x[:] = 77.0
    equations.rate_from_state(d, y, rate)
    assert (d.scratch.position.x == 77.0).all()
    kinematics.locate_points(d, y)
    equations.rate_from_points(d, y, other)
    np.testing.assert_array_equal(rate[:-2], other[:-2])
    # an input acts on the tip, whose speed gives the input's power
    d.chain.has_inputs, d.inputs.tip_force[0] = 1, 2.0
    d.scratch.velocity.x[:] = 77.0
    equations.rate_from_state(d, y, rate)
    assert rate[state.supplied_at(3)] == pytest.approx(2.0 * d.scratch.velocity.x[3])
    assert d.scratch.velocity.x[3] != 77.0
    # a contact also needs located points, without any input
    d.chain.has_inputs = 0
    mark_touching(d, [2])
    d.scratch.velocity.x[:] = 77.0
    equations.rate_from_state(d, y, rate)
    assert d.scratch.velocity.x[3] != 77.0


def test_the_inputs_are_those_at_the_time_of_the_state():
    _, d, y, _ = prepared("pinned", 1)
    d.inputs.piece.degree, d.inputs.piece.scale, d.step.time_origin = 1, 1.0, 0.5
    d.inputs.piece.motor[:2, 0] = 1.0, 2.0
    y[state.time_at(1)] = 0.25
    equations.rate_from_points(d, y, np.zeros(len(y)))
    assert d.inputs.motor[0] == 1.0 + 2.0 * 0.75

"""The start and the restart of a replay."""

# Tests: kernel/tangent/entry.py

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS
from chain_impact.kernel.chain.inputs import apply_inputs
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.events import handlers
from chain_impact.kernel.forces import active_contacts, candidate_laws, force_formula
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.record.fields import AT_START
from chain_impact.kernel.status import OK
from chain_impact.kernel.tangent import duals, replay, trust
from tests.helpers.kernel.kernel_calls import tangents_of
from tests.helpers.kernel.plain import Plain, make_rigid, record_of
from tests.helpers.models.complex_laws import TINY
from tests.helpers.scenes.derivative_scenes import Case
from tests.helpers.scenes.problems import ball, of_law
from tests.helpers.tools.differences import slope
from tests.kernel.chains import chain, mark_touching, move_wall_to_depth, random_state, vectors
from tests.kernel.forces.factors import FACTORS
from tests.kernel.tangent.dual import random_duals, started


@pytest.mark.full("more cases", but=40)
@pytest.mark.parametrize("e", [0.1, 0.5, 0.95])
@pytest.mark.parametrize("law", FACTORS)
def test_the_factor_of_a_law_varies_with_the_restitution(law, e):
    assert {*CONTACT_LAWS} - {*FACTORS} == {"newton_impact"}
    factor_of_law = complex(FACTORS[law](complex(e, TINY)))
    case = Case(ball(1e-3, 1.0, restitution=e, **of_law(law)), ("contact.restitution",), ())
    factor = tangents_of(started(case))["law"]["damping_factor"][0, 0]
    # the polynomial of Kuwabara and Kono has 10 digits
    bound = 1e-10 if law == "kuwabara_kono" else 1e-11
    assert factor["value"] == pytest.approx(factor_of_law.real, rel=bound, abs=1e-14)
    assert factor["slope"][0] == pytest.approx(factor_of_law.imag / TINY, rel=bound, abs=1e-14)


PARAMETERS = {
    "chain": (
        *("gravity", "length", "mass", "given_center_of_mass", "given_inertia", "box_wall"),
        "joint_armature",
    ),
    "drive": ("friction", "limit"),
    "walls": ("x", "y", "angle"),
    "initial": ("position", "velocity", "angle", "angular_velocity"),
    "contact_settings": ("exponent", "radius"),
}
GIVEN = ("stiffness", "restitution", "friction", "static_friction", "motor", "tip_force")
GIVEN += ("drive_damping", "drive_stiffness", "target", "target_velocity")


@pytest.fixture
def both():
    """Return a chain with inputs and random parameters, and an instance of dual numbers of its layout."""
    rng = np.random.default_rng(8)
    _, d = chain(rng, 2, springs=True, inputs=True)
    for record, names in PARAMETERS.items():
        for name in names:
            d[record].numpy_record[name] = rng.uniform(0.5, 2.0, np.shape(d[record][name]))
    for name in GIVEN[6:]:
        d["given"].numpy_record[name] = rng.uniform(0.5, 2.0, np.shape(d["given"][name]))
    t = random_duals(rng, d.numpy_record.dtype)
    t.link_count, t.candidate_count = d.link_count, d.candidate_count
    return d, t


def values(numbers):
    return np.vectorize(lambda number: number.value, otypes=[float])(numbers)


def slopes(numbers):
    return np.array([number.slope for number in np.ravel(numbers)])


def test_parameters_are_taken_with_the_derivatives_that_it_has_of_them(both):
    d, t = both
    before = {
        (record, name): slopes(getattr(getattr(t, record), name))
        for record in PARAMETERS
        for name in PARAMETERS[record]
    }
    d.given.law = CONTACT_LAWS["hunt_crossley"].number
    assert candidate_laws.update_laws(d) == OK
    duals.copy_given(d, t, AT_START)
    replay.copy_given_and_modes(d, t)  # reads the walls, whose material may change during a run
    for (record, name), own in before.items():
        field = getattr(getattr(t, record), name)
        np.testing.assert_array_equal(values(field), d[record][name], err_msg=name)
        np.testing.assert_array_equal(slopes(field), own, err_msg=name)
    assert t.contact_settings.minimum_impact_speed == d.contact_settings.minimum_impact_speed
    assert t.solver.tolerance == d.solver.tolerance


def test_given_values_hold_with_their_derivatives(both):
    d, t = both
    number = CONTACT_LAWS["ye"].number
    d.given.law, d.given.stiffness, d.given.restitution = number, 5e5, 0.25
    d.given.friction, d.given.static_friction = 0.25, 0.5
    d.given.motor[:], d.given.tip_force[:] = 1.5, (2.0, 3.0)
    d.given.piece.degree, d.given.piece.end = 1, 6.5
    before = {name: slopes(getattr(t.given, name)) for name in GIVEN}
    assert candidate_laws.update_laws(d) == OK
    replay.copy_given_and_modes(d, t)
    apply_inputs(t)
    assert candidate_laws.update_laws(t) == OK
    assert (t.law.number == number).all()
    assert t.given.law == number
    assert t.contact_settings.any_friction == 1
    assert (t.inputs.piece.degree, t.inputs.piece.end) == (1, 6.5)
    for name in GIVEN[:4]:
        for number in getattr(t.law, name):
            assert number.value == d.given[name]
            np.testing.assert_array_equal([number.slope], before[name])
    for name in GIVEN[4:]:
        np.testing.assert_array_equal(values(getattr(t.inputs, name)), d.given[name])
        np.testing.assert_array_equal(slopes(getattr(t.inputs, name)), before[name])


@pytest.mark.parametrize("law", ["hunt_crossley", "lankarani_nikravesh", "ye", "jankowski", "newton_impact"])
def test_the_factor_of_a_law_has_its_own_derivatives(both, law):
    """The reference is d f/d e by a difference, times the derivatives of the restitution."""
    d, t = both
    entry, e = CONTACT_LAWS[law], 0.6
    d.given.law, d.given.restitution = entry.number, e
    d.contact_settings.exponent = 1.5
    assert candidate_laws.start_laws(d) == OK
    duals.copy_given(d, t, AT_START)
    replay.copy_given_and_modes(d, t)
    assert candidate_laws.start_laws(t) == OK
    expected = slope(entry.damping_factor, e, 1e-6)
    own = t.law
    factor = own.damping_factor[0]
    assert factor.value == d.law.damping_factor[0]
    np.testing.assert_allclose(factor.slope, expected * own.restitution[0].slope, rtol=1e-7, atol=1e-9)
    assert (own.rigid[0], own.approach_only[0]) == (entry.rigid, entry.approach_only)
    if entry.rate_exponent is None:
        assert own.rate_exponent[0] is own.exponent[0]
    else:
        assert own.rate_exponent[0] == entry.rate_exponent


@pytest.fixture
def twins(monkeypatch):
    """Return a chain and a second record of its layout in place of a record of dual numbers."""
    monkeypatch.setattr(replay, "dual_with_slope", lambda number, _slope, _argument: number)
    monkeypatch.setattr(replay, "value", float)
    rng = np.random.default_rng(9)
    scene, d = chain(rng, 2, springs=True, dampers=True, inputs=True)
    dtype = d.numpy_record.dtype
    fields = [*((name, dtype[name]) for name in dtype.names), ("trust", duals.TRUST)]
    t = Plain(np.zeros(1, np.dtype(fields))[0])
    blank = record_of(scene)
    for name in ("link_count", "candidate_count", "candidate"):
        t.numpy_record[name] = blank.numpy_record[name]
    t.chain.has_base_joint, t.chain.has_inputs = d.chain.has_base_joint, d.chain.has_inputs
    return d, t


def test_a_replay_starts_as_the_instance_does(twins):
    """It derives the laws again, because derivatives may have changed since an earlier start."""
    d, t = twins
    d.initial.angular_velocity[:], d.inputs.tip_force[:] = (0.3, -0.4), (1.0, 2.0)
    d.given.tip_force[:] = 1.0, 2.0
    assert initialize(d, 1.5) == OK
    replay.start_tangent(d, t)
    t.law.damping_factor[:] = 77.0
    t.scratch.applied_force.x[:], t.contacts.active_count, t.step.method, t.trust.reason = 9.0, 3, 1, 7
    replay.start_tangent(d, t)
    records = [
        "chain",
        "contact_settings",
        "law",
        "initial",
        "candidate",
        "walls",
        "inputs",
        "impact",
        "contacts",
    ]
    records += ["given", "stops", "solver"]
    for record in records:
        dtype = d.numpy_record.dtype[record].base  # the type of a table's rows
        for name in dtype.names:
            if not dtype[name].names:
                np.testing.assert_array_equal(t[record][name], d[record][name], err_msg=f"{record}.{name}")
    for name in (
        "communication_point",
        "start",
        "end",
        "time_origin",
        "size",
        "regularized_candidate",
        "method",
        "switch_after",
    ):
        assert t.step[name] == d.step[name], name
    np.testing.assert_array_equal(t.step.state_end, d.step.state_end)
    np.testing.assert_array_equal(vectors(t.scratch.applied_force), vectors(d.scratch.applied_force))
    assert t.trust.reason == trust.TRUSTED
    assert t.impact.last_time == 1.5


@pytest.mark.parametrize("law", ["hunt_crossley", "newton_impact"])
def test_a_replay_restarts_from_the_end_of_its_step_with_given_values(twins, law, monkeypatch):
    """Lasting contacts with a force law use the new law; contacts at rigid walls stay as they are."""
    d, t = twins
    assert initialize(d, 0.0) == OK
    replay.start_tangent(d, t)
    rng = np.random.default_rng(1)
    y = random_state(rng, t)
    t.step.state_end[:], t.step.end = y, 2.5
    locate_points(t, y)
    mark_touching(t, [4])
    move_wall_to_depth(t, 4, 1e-3)
    active_contacts.latch_onset(t, 4)
    make_rigid(t, law == "newton_impact")
    damping, number = t.contacts.damping[4], CONTACT_LAWS[law].number
    d.given.law, d.given.stiffness, d.given.restitution, d.given.tip_force[:] = number, 3e5, 0.8, (5.0, 6.0)
    assert candidate_laws.update_laws(d) == OK
    t.scratch.applied_force.x[:] = 9.0
    t.contacts.beyond_kink[4] = 5
    t.step.communication_point = 1.0
    t.step.start_delay = 7.0
    calls = []
    monkeypatch.setattr(handlers, "recompute_active_set", lambda *arguments: calls.append(arguments))
    replay.restart_tangent(d, t)
    assert calls == [(t,)]
    assert t.step.communication_point == t.step.start == t.step.end == 2.5
    assert t.step.start_delay == 0.0
    np.testing.assert_array_equal(t.step.state[:-2], y[:-2])
    assert vectors(t.scratch.applied_force).tolist() == [[0.0, 0.0], [0.0, 0.0], [5.0, 6.0]]
    assert (t.law.number[4], t.law.stiffness[4]) == (number, 3e5)
    assert t.contacts.active_count == 1
    if law == "newton_impact":
        assert t.contacts.damping[4] == damping
        assert t.contacts.beyond_kink[4] == 5
    else:
        mass, speed = t.contacts.effective_mass[4], t.contacts.latched_speed[4]
        expected = CONTACT_LAWS[law].damping_factor(0.8) * 3e5 / speed
        assert t.contacts.damping[4] == pytest.approx(expected, rel=1e-12)
        energy = force_formula.elastic_energy(t, 4, t.contacts.expected_penetration[4])
        assert energy == pytest.approx(0.5 * mass * speed**2, rel=1e-9)
        assert t.contacts.beyond_kink[4] in {0, 1}


@pytest.mark.parametrize(("ended", "expected"), [(2.0, 3), (2.5, 3), (2.6, trust.TRUSTED)])
def test_derivatives_that_ended_in_what_is_dropped_go_on(twins, ended, expected):
    d, t = twins
    assert initialize(d, 0.0) == OK
    replay.start_tangent(d, t)
    t.step.end, t.trust.reason, t.trust.time = 2.5, 3, ended
    replay.restart_tangent(d, t)
    assert t.trust.reason == expected

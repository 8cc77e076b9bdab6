"""The contact law of each candidate, from the values of the candidate, its wall, the scene, or stops."""

import math

import numpy as np
import pytest

from chain_impact import CONTACT_LAWS
from chain_impact.kernel import status
from chain_impact.kernel.advance import latch_active_contacts
from chain_impact.kernel.forces import candidate_laws, laws, user_law
from chain_impact.kernel.forces.candidate_laws import USER_LAW, start_laws, update_laws
from chain_impact.kernel.forces.force_formula import elastic_energy, law_force, set_damping
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.status import OK
from tests.helpers.kernel.plain import make_rigid
from tests.kernel.chains import chain, mark_touching, stopped_chain, stops_of

LAWS = pytest.mark.parametrize("law", CONTACT_LAWS.values(), ids=lambda law: law.id)
NUMBER = {name: law.number for name, law in CONTACT_LAWS.items()}
SIZE = 1.6  # m, the longest link
RANGE = status.PARAMETER_OUT_OF_RANGE
FRICTION = pytest.mark.parametrize("name", ["friction", "static_friction"])


def restitution_for(law, e=0.7):
    """Return a restitution; near 1 the factor of Kuwabara and Kono takes no integration."""
    return 1.0 - 1e-7 if law.id == "kuwabara_kono" else e


def laws_of(d):
    """Return the bytes of the table of laws, and whether any law has a force, or is rigid."""
    return d.law.tobytes(), d.contact_settings.any_force_law, d.contact_settings.any_rigid


@pytest.fixture
def record_and_candidates():
    """Return a record with two walls of their own material, and stops, and a candidate of each kind."""
    _, d = stopped_chain(2)
    d.chain.longest_link = SIZE
    d.given.law, d.given.stiffness, d.given.restitution = NUMBER["flores"], 1e6, 0.4
    d.given.stop_stiffness, d.given.stop_restitution = 1e3, 0.2
    d.contact_settings.exponent, d.stops.exponent, d.stops.law = 1.5, 1.0, 0
    d.contact_settings.minimum_impact_speed, d.stops.minimum_impact_speed = 1e-3, 2e-3
    of_walls = d.candidate.wall[d.candidate.stop == 0].tolist()
    walls = sorted(set(of_walls))
    d.walls.stiffness[:], d.walls.restitution[:] = 0.0, -1.0
    d.walls.stiffness[walls[1]], d.walls.restitution[walls[2]] = 5e7, 0.0
    return d, (*map(of_walls.index, walls[:3]), stops_of(d)[0])


def chain_with(law):
    """Return the record of a chain whose walls have a law."""
    _, d = chain(np.random.default_rng(4), 3)
    d.given.law = law.number
    d.given.restitution = restitution_for(law)
    d.contact_settings.exponent = law.exponent or 2.0
    return d


@LAWS
def test_a_law_gets_the_numbers_of_the_registry(law):
    d = chain_with(law)
    own = d.law
    own.approach_only[:] = own.rate_exponent[:] = 9
    assert start_laws(d) == OK
    p = d.contact_settings.exponent if law.rate_exponent is None else law.rate_exponent
    assert (own.rate_exponent == p).all()
    assert (own.approach_only == law.approach_only).all()
    assert (own.damping_factor == law.damping_factor(restitution_for(law))).all()
    assert (own.rigid == law.rigid).all()
    assert (d.contact_settings.any_rigid, d.contact_settings.any_force_law) == (law.rigid, not law.rigid)


@pytest.mark.parametrize(
    "law", [law for law in CONTACT_LAWS.values() if law.exponent], ids=lambda law: law.id
)
def test_a_law_with_an_exponent_of_its_own_refuses_others(law):
    d = chain_with(law)
    d.contact_settings.exponent = 1.1
    assert start_laws(d) == status.EXPONENT_NOT_ALLOWED


# two laws take the logarithm of 0, an error in Python
@pytest.mark.parametrize(
    "law",
    [law for law in CONTACT_LAWS.values() if law.id not in {"kelvin_voigt", "tsuji"}],
    ids=lambda law: law.id,
)
def test_a_law_with_infinite_damping_at_restitution_0_refuses_it(law):
    d = chain_with(law)
    d.given.restitution = 0.0
    assert start_laws(d) == (OK if law.allows_zero else status.RESTITUTION_NOT_ALLOWED)


def test_a_users_law_has_no_factor(record_and_candidates, monkeypatch):
    monkeypatch.setattr(user_law, "has_user_law", lambda: 1)
    d, (c, *_) = record_and_candidates
    d.given.law, d.law.damping_factor[:] = USER_LAW, 5.0
    d.law.approach_only[:] = d.law.rigid[:] = 1
    assert start_laws(d) == OK
    for name, value in (
        ("damping_factor", 0.0),
        ("rate_exponent", 1.5),
        ("approach_only", 0),
        ("rigid", 0),
    ):
        assert d.law[name][c] == value
    d.given.law = USER_LAW + 1
    assert update_laws(d) == status.UNKNOWN_LAW


@pytest.mark.parametrize(
    ("changes", "refused"),
    [
        ({}, OK),
        *(({"law": number}, status.UNKNOWN_LAW) for number in (0, USER_LAW)),
        *(({"law": number}, OK) for number in (1, laws.LAW_COUNT)),
        *(({"restitution": e}, RANGE) for e in (-1e-9, 1.0 + 1e-9, math.nan)),
        *(({"stiffness": stiffness}, RANGE) for stiffness in (0.0, math.nan)),
        *(({"restitution": 1.0}, OK), ({"stiffness": 1e-3}, OK)),
        ({"law": NUMBER["kelvin_voigt"]}, status.EXPONENT_NOT_ALLOWED),  # this law is linear
        ({"restitution": 0.0}, status.RESTITUTION_NOT_ALLOWED),  # the damping of this law would be infinite
        ({"restitution": 0.0, "law": NUMBER["newton_impact"]}, OK),
    ],
)
def test_given_values_are_checked_and_those_refused_change_no_law(record_and_candidates, changes, refused):
    d, (c, *_) = record_and_candidates
    d.walls.restitution[:] = -1.0
    assert start_laws(d) == OK
    before = laws_of(d)
    for name, value in changes.items():
        d.given[name] = value
    assert candidate_laws.check_law(d, c) == candidate_laws.check_laws(d) == update_laws(d) == refused
    assert laws_of(d) == before or refused == OK
    # the same check at the start, where given values become effective
    assert initialize(d, 0.0) == d.statistics.status == refused


@pytest.mark.parametrize(
    ("sliding", "static", "refused"),
    [
        *((0.3, 0.0, OK), (0.0, 0.3, OK), (1e3, 1e4, OK), (-0.1, 0.0, RANGE), (-0.1, 0.5, RANGE)),
        *((math.nan, 0.0, RANGE), (math.inf, 0.0, RANGE), (0.3, math.inf, RANGE)),
    ],
)
def test_coefficients_of_friction_are_checked(record_and_candidates, sliding, static, refused):
    d, (c, *_) = record_and_candidates
    d.given.friction, d.given.static_friction = sliding, static
    assert candidate_laws.check_law(d, c) == candidate_laws.check_laws(d) == refused


SPEED, MASS = 1.5, 2.0  # m/s and kg, of the contacts that last
LASTING = [2, 5]


@pytest.fixture
def touching_record():
    """Return a record of a chain with two contacts that last, whose damping is not derived yet."""
    _, d = chain(np.random.default_rng(4), 3)
    mark_touching(d, LASTING)
    d.contacts.latched_speed[:], d.contacts.effective_mass[:] = SPEED, MASS
    d.contacts.damping[:] = d.contacts.expected_penetration[:] = 0.0
    change_law(d, "ye", 0.5)
    return d


def change_law(d, law, restitution):
    """Give the walls a law between two steps, and let the contacts that last take it."""
    d.given.law, d.given.restitution = NUMBER[law], restitution
    assert update_laws(d) == OK
    latch_active_contacts(d)


@pytest.mark.parametrize("restitution", [0.5, 0.25])
@pytest.mark.parametrize("law", ["ye", "flores"])
def test_contacts_that_last_take_a_changed_law_and_restitution(touching_record, law, restitution):
    change_law(touching_record, law, restitution)
    assert (touching_record.law.damping_factor == CONTACT_LAWS[law].damping_factor(restitution)).all()
    damping = touching_record.law.damping_factor[2] * touching_record.law.stiffness[2] / SPEED
    assert touching_record.contacts.damping[LASTING] == pytest.approx([damping] * 2, rel=1e-12)
    assert np.count_nonzero(touching_record.contacts.damping) == len(LASTING)


def test_the_expected_penetration_of_a_contact_that_lasts_holds_its_energy(touching_record):
    change_law(touching_record, "flores", 0.25)
    energy = elastic_energy(touching_record, 5, touching_record.contacts.expected_penetration[5])
    assert energy == pytest.approx(0.5 * MASS * SPEED**2, rel=1e-12)
    assert np.count_nonzero(touching_record.contacts.expected_penetration) == len(LASTING)


def test_a_factor_is_kept_for_the_same_law_restitution_and_exponent(touching_record):
    """The next run keeps the factor, too; the damping follows the stiffness."""
    touching_record.law.damping_factor[0] = 77.0
    touching_record.given.stiffness *= 2.0
    change_law(touching_record, "ye", 0.5)
    assert (touching_record.law.damping_factor == 77.0).all()
    assert touching_record.contacts.damping[2] == pytest.approx(
        77.0 * touching_record.given.stiffness / SPEED, rel=1e-12
    )
    assert start_laws(touching_record) == OK
    assert (touching_record.law.damping_factor == 77.0).all()
    touching_record.contact_settings.exponent = 2.0
    assert start_laws(touching_record) == OK
    assert (touching_record.law.damping_factor == CONTACT_LAWS["ye"].damping_factor(0.5)).all()
    assert (touching_record.law.rate_exponent == 2.0).all()


def test_a_wall_that_becomes_rigid_derives_no_expected_penetration(touching_record):
    touching_record.contacts.expected_penetration[:] = 5.0
    make_rigid(touching_record)
    change_law(touching_record, "newton_impact", 0.5)
    assert touching_record.law.rigid.all()
    assert (touching_record.contacts.expected_penetration == 5.0).all()


# --- walls and stops of their own --------------------------------------------------------------------------


def test_walls_and_stops_may_have_their_own_stiffness(record_and_candidates):
    """A depth of round-off is harmless at walls with a force law; rigid walls have no harmless depth."""
    d, (first, *_) = record_and_candidates
    kinds, harmless = list(record_and_candidates[1]), candidate_laws.HARMLESS_DEPTH * SIZE
    d.given.law = NUMBER["hertz"]
    for of_stops in (0, NUMBER["lee_wang"]):
        d.stops.law = of_stops
        assert start_laws(d) == OK
        assert d.law.number[kinds].tolist() == [NUMBER["hertz"]] * 3 + [of_stops or NUMBER["hertz"]]
    assert d.law.stiffness[kinds] == pytest.approx([1e6, 5e7, 1e6, 1e3 / SIZE**2], rel=1e-13)
    assert d.law.restitution[kinds].tolist() == [0.4, 0.4, 0.0, 0.2]
    assert d.law.exponent[kinds].tolist() == [1.5, 1.5, 1.5, 1.0]
    assert d.law.minimum_impact_speed[kinds] == pytest.approx([1e-3, 1e-3, 1e-3, 2e-3 * SIZE], rel=1e-13)
    assert d.law.harmless_depth[kinds] == pytest.approx([harmless] * 4, rel=1e-13)
    d.law.rigid[first] = 1
    candidate_laws.set_law_parameters(d, first)
    assert d.law.harmless_depth[first] == 0.0


def test_candidates_of_one_origin_have_one_law():
    """``same_as`` is the first candidate of an origin; the material of a wall may change during a run."""
    d = stopped_chain(2)[1]
    wall = d.candidate.wall[1]
    d.walls.restitution[wall] = 0.2
    assert start_laws(d) == OK
    origins = [-2 if d.candidate.stop[c] else wall == d.candidate.wall[c] for c in range(d.candidate_count)]
    assert len(set(origins)) == 3
    assert d.law.same_as.tolist() == [origins.index(origin) for origin in origins]
    d.walls.restitution[wall], d.given.stop_restitution = 0.9, 0.1
    assert update_laws(d) == OK
    factor, e = CONTACT_LAWS["zhang_sharf"].damping_factor, d.given.restitution
    of_origin = {-2: 0.1, True: 0.9, False: e}
    assert d.law.restitution.tolist() == [of_origin[origin] for origin in origins]
    assert d.law.damping_factor.tolist() == [factor(of_origin[origin]) for origin in origins]


@pytest.mark.parametrize(
    "name",
    ["law", "stiffness", "restitution", "friction", "static_friction", "stop_stiffness", "stop_restitution"],
)
def test_laws_are_in_use_as_long_as_what_is_given_is_the_same(record_and_candidates, name):
    d, _ = record_and_candidates
    d.walls.restitution[:], d.given.friction, d.given.static_friction = -1.0, 0.1, 0.3
    assert start_laws(d) == OK
    assert candidate_laws.are_laws_in_use(d)
    d.given[name] += 1 if name == "law" else 0.25
    assert not candidate_laws.are_laws_in_use(d)


@pytest.mark.parametrize("number", [law.number for law in CONTACT_LAWS.values() if law.allows_exponent(1.5)])
def test_candidates_of_one_origin_have_the_same_law_in_all_parts(number):
    d = stopped_chain(2)[1]
    d.given.law = d.stops.law = number
    assert start_laws(d) == OK
    for name in d.numpy_record["law"].dtype.names:
        assert d.law[name].tolist() == d.law[name][d.law.same_as].tolist(), name


@pytest.mark.parametrize("law", CONTACT_LAWS.values(), ids=lambda law: law.id)
def test_the_table_of_laws_says_which_walls_are_rigid(law):
    assert laws.is_rigid(law.number) == law.rigid
    assert not laws.is_rigid(laws.LAW_COUNT + 1)  # a user's law


@pytest.mark.parametrize("value", [math.nan, 0.0, -1.0])
def test_stops_that_are_out_of_range_are_refused_and_change_nothing(value):
    d = stopped_chain(2)[1]
    before = laws_of(d)
    d.given.stop_stiffness, d.given.law = value, 3
    assert update_laws(d) == RANGE
    assert laws_of(d) == before
    d.given.stop_stiffness, d.stops.law = 1e4, laws.LAW_COUNT + 1
    assert update_laws(d) == status.UNKNOWN_LAW
    assert laws_of(d) == before


INERTIA, RATE = 0.37, 2.5  # kg·m² and rad/s, of the impact at a stop
STOP_STIFFNESS = 4e4  # N·m/radⁿ


def stop_with(law):
    """Return a record with a law of its stops, and a stop."""
    _, d = stopped_chain(3)
    d.stops.law, d.stops.exponent, d.given.stop_stiffness = law.number, law.exponent or 2.0, STOP_STIFFNESS
    d.stops.minimum_impact_speed, d.given.stop_restitution = 0.02, restitution_for(law)
    assert start_laws(d) == OK
    return d, stops_of(d)[0]


@LAWS
def test_stops_have_a_law_of_their_own(law):
    d, c = stop_with(law)
    assert d.law.number[c] == law.number
    assert d.law.number[0] == d.given.law != law.number or law.id == "zhang_sharf"
    assert d.law.minimum_impact_speed[c] == pytest.approx(0.02 * d.chain.longest_link, rel=1e-14)
    assert d.law.rigid[c] == law.rigid
    assert d.law.restitution[c] == restitution_for(law)


@pytest.mark.parametrize("angle", [1e-3, 0.2])
@pytest.mark.parametrize("rate", [1.3, -0.4])
@pytest.mark.parametrize(
    "law", [law for law in CONTACT_LAWS.values() if not law.rigid], ids=lambda law: law.id
)
def test_the_law_of_a_stop_is_that_of_an_angle(law, rate, angle):
    """M = K φⁿ + d φᵖ φ̇, with d from K, v₀ in rad/s and the inertia; here F = M/s at δ = s φ."""
    d, c = stop_with(law)
    size, n, m = d.chain.longest_link, d.stops.exponent, law.mass_power
    d.contacts.effective_mass[c], d.contacts.latched_speed[c] = INERTIA / size**2, RATE * size
    set_damping(d, c)
    p = n if law.rate_exponent is None else law.rate_exponent
    factor = law.damping_factor(restitution_for(law))
    damping = factor * STOP_STIFFNESS ** (1.0 - m) * INERTIA**m / (RATE if m == 0.0 else 1.0)
    spring = STOP_STIFFNESS * angle**n
    damper = 0.0 if law.approach_only and rate < 0.0 else damping * angle**p * rate
    force, elastic = law_force(d, c, angle * size, rate * size)
    assert elastic * size == pytest.approx(spring, rel=1e-12)
    assert force * size == pytest.approx(max(0.0, spring + damper), rel=1e-11)
    assert elastic_energy(d, c, angle * size) == pytest.approx(spring * angle / (n + 1.0), rel=1e-12)


def test_a_users_law_of_a_stop_takes_and_returns_what_belongs_to_angles(monkeypatch):
    calls = []
    monkeypatch.setattr(user_law, "has_user_law", lambda: 1)
    monkeypatch.setattr(user_law, "force", lambda *arguments: calls.append(arguments) or 12.0)
    _, d = stopped_chain(2)
    size, d.stops.law = d.chain.longest_link, USER_LAW
    d.stops.exponent, d.given.stop_stiffness, d.given.stop_restitution = 1.3, 5e3, 0.4
    assert start_laws(d) == OK
    c = d.candidate_count - 1
    d.contacts.effective_mass[c], d.contacts.latched_speed[c] = 0.3 / size**2, 2.0 * size
    force, elastic = law_force(d, c, 0.1 * size, 0.7 * size)
    assert calls[0] == pytest.approx((0.1, 0.7, 2.0, 0.3, 5e3, 1.3, 0.4), rel=1e-12)
    assert force * size == pytest.approx(12.0, rel=1e-13)
    assert elastic * size == pytest.approx(5e3 * 0.1**1.3, rel=1e-12)


def test_a_contact_with_a_force_cannot_become_rigid():
    """A held contact at a rigid wall may become rigid again, and contact-free candidates may become rigid."""
    d = stopped_chain(2)[1]
    mark_touching(d, [stops_of(d)[0]])
    before, kept = laws_of(d), d.given.law
    d.given.law = d.stops.law = NUMBER["newton_impact"]
    assert update_laws(d) == status.RIGID_WHILE_TOUCHING
    assert laws_of(d) == before
    d.stops.law = kept
    assert update_laws(d) == OK
    assert (d.law.rigid == (d.candidate.stop == 0)).all()
    assert (d.contact_settings.any_rigid, d.contact_settings.any_force_law) == (1, 1)
    mark_touching(d, [0])
    assert update_laws(d) == OK


# --- dry friction ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("of_all", "of_wall", "refused"),
    [
        *(((0.3, 0.3), (-1.0, -1.0), None), ((0.3, 0.2), (-1.0, -1.0), 0), ((0.3, 0.2), (0.1, 0.2), 0)),
        *(((0.3, 0.4), (0.3, 0.2), 1), ((0.3, 0.4), (-1.0, 0.2), 1)),
        ((0.0, 0.2), (0.3, -1.0), None),  # a wall's own friction does not inherit the scene's static friction
    ],
)
def test_a_static_friction_below_that_of_sliding_is_refused_with_its_wall(
    record_and_candidates, of_all, of_wall, refused
):
    d, kinds = record_and_candidates
    d.given.friction, d.given.static_friction = of_all
    d.walls.restitution[:] = -1.0
    wall = d.candidate.wall[kinds[1]]
    d.walls.friction[wall], d.walls.static_friction[wall] = of_wall
    assert start_laws(d) == (OK if refused is None else status.STATIC_BELOW_SLIDING)
    assert d.fault.part == (0 if refused is None else 1 + kinds[refused])


@pytest.mark.parametrize(
    ("of_all", "of_wall", "expected"),
    [
        ((0.3, 0.5), (-1.0, -1.0), (0.3, 0.5)),
        ((0.3, 0.0), (-1.0, -1.0), (0.3, 0.3)),  # static friction defaults to kinetic friction
        # a wall's own friction does not inherit the scene's static friction
        ((0.3, 0.5), (0.1, -1.0), (0.1, 0.1)),
        ((0.3, 0.5), (0.1, 0.4), (0.1, 0.4)),
        ((0.3, 0.5), (-1.0, 0.4), (0.3, 0.4)),
        ((0.3, 0.5), (0.0, -1.0), (0.0, 0.0)),
        ((0.0, 0.0), (0.7, -1.0), (0.7, 0.7)),
    ],
)
def test_a_wall_may_give_its_own_friction_and_a_stop_has_none(
    record_and_candidates, of_all, of_wall, expected
):
    d, kinds = record_and_candidates
    d.given.friction, d.given.static_friction = of_all
    wall = d.candidate.wall[kinds[1]]
    d.walls.friction[wall], d.walls.static_friction[wall] = of_wall
    for c, pair in ((kinds[0], (of_all[0], max(of_all))), (kinds[1], expected), (kinds[3], (0.0, 0.0))):
        candidate_laws.derive_damping(d, c)
        candidate_laws.set_law_parameters(d, c)
        assert (d.law.friction[c], d.law.static_friction[c]) == pair
        d.contact_settings.any_friction = 0
        candidate_laws.set_law_flags(d, c)
        assert d.contact_settings.any_friction == (pair[1] > 0.0)


@FRICTION
def test_a_wall_with_friction_of_its_own_has_a_law_of_its_own(record_and_candidates, name):
    d, (c, *_) = record_and_candidates
    assert candidate_laws.law_origin(d, c) == candidate_laws.COMMON_LAW
    d.walls[name][d.candidate.wall[c]] = 0.0
    assert candidate_laws.law_origin(d, c) == d.candidate.wall[c]


@FRICTION
def test_rigid_walls_have_no_friction_but_stops_beside_them_may_be_rigid(record_and_candidates, name):
    d, (c, *_, stop) = record_and_candidates
    rigid = NUMBER["newton_impact"]
    d.given[name], d.given.law, d.stops.law = 0.3, rigid, NUMBER["flores"]
    assert candidate_laws.check_law(d, c) == candidate_laws.check_laws(d) == status.FRICTION_WITH_RIGID_WALLS
    d.given.law, d.stops.law = NUMBER["flores"], rigid
    assert candidate_laws.check_law(d, stop) == candidate_laws.check_laws(d) == OK
    d.given[name], d.given.law = 0.0, rigid
    assert candidate_laws.check_laws(d) == OK

"""Records from outside: refuse values that would cause invalid memory accesses or endless runs."""

# Tests: kernel/initialize.py, kernel/status.py

import numpy as np
import pytest

from chain_impact.kernel import entry, hooks
from chain_impact.kernel.entry import is_record_sound, is_sound
from chain_impact.kernel.forces.friction import list_sticking
from chain_impact.kernel.forces.laws import LAW_COUNT
from chain_impact.kernel.record.constants import (
    DISTANCE_KNOWN,
    EXPLICIT,
    IMPLICIT,
    INPUT_DEGREE,
    NEIGHBOUR,
    NO_CONTACT,
    NO_FRICTION,
    SOLVER_METHODS,
    SOLVER_READER,
    STICKS,
)
from chain_impact.kernel.record.contacts import LATEST_COUNT
from chain_impact.kernel.status import LAST_STATUS, OK, STATUS_TEXT, UNKNOWN_LAW
from chain_impact.scene.scene import load_scene
from chain_impact.simulation.derivatives import DifferentiatedInstance
from chain_impact.simulation.instance import Instance
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.selection import differentiable_named
from tests.helpers.kernel.kernel_calls import tangents_of
from tests.helpers.kernel.plain import Plain, record_of
from tests.helpers.scenes.derivative_scenes import table
from tests.kernel.chains import chain, mark_touching, stopped_chain, stops_of
from tests.kernel.rubbing import rubbing_chain


@pytest.fixture
def d():
    """Return the default chain in its first impact."""
    instance = Instance(load_scene("four_link_box"))
    instance.advance(0.4995)
    return Plain(instance.record)


def test_a_record_of_a_run_is_sound(d):
    assert is_sound(d) == 1


def test_the_last_status_is_the_last():
    assert max(STATUS_TEXT) == LAST_STATUS


def test_without_candidates_no_contact_is_regularized():
    still = {"position": [0.0, 0.0], "angles": [0.0] * 3}
    d = record_of(table([{"length": 0.3, "mass": 1.0}] * 3, initial=still))
    assert is_sound(d) == 1
    d.step.regularized_candidate = 0
    assert is_sound(d) == 0


def test_each_candidate_has_a_law_once_a_run_has_started(d):
    d.contacts.active_count = d.contacts.force_law_count = 0
    d.law.number[3] = 0
    assert is_sound(d) == 0
    d.statistics.status = UNKNOWN_LAW  # a start that failed
    assert is_sound(d) == 1


# lower and upper bound of each index of a chain of 3 links with 16 candidates and 7 impacts
BOUNDS = {
    ("chain", "meeting_joint"): (0, 3),
    ("step", "regularized_candidate"): (NO_CONTACT, 15),
    ("step", "method"): (EXPLICIT, IMPLICIT),
    ("step", "last_method"): (EXPLICIT, IMPLICIT),
    ("step", "dense_for"): (0, SOLVER_READER),
    ("search", "known_extent"): (0, DISTANCE_KNOWN),
    ("law", "number"): (1, LAW_COUNT),
    ("candidate", "stop"): (-2, 2),
    ("solver", "method"): (1, len(SOLVER_METHODS)),
    ("statistics", "status"): (OK, LAST_STATUS),
    ("latest", "requested_count"): (0, LATEST_COUNT),
    ("contact_log", "count"): (0, None),
    ("contacts", "active_count"): (0, 16),
    ("contacts", "force_law_count"): (0, 0),
    ("contacts", "active_index"): (0, 15),
    ("contacts", "active"): (0, 1),
    ("contacts", "event"): (0, NEIGHBOUR),
    ("contacts", "impact_number"): (0, 7),
    ("candidate", "point"): (0, 3),
    ("candidate", "wall"): (0, 4 + 15),
    ("candidate", "place"): (0, 6),
}


# lower and upper bounds for a chain of 4 links with 20 candidates and 24 elements: 2 contacts and 3 joints
# have friction, and 2 of them stick
OF_FRICTION = {
    ("friction", "may_act"): (0, 1),
    ("friction", "active_count"): (2, 24),
    ("friction", "contact_count"): (2, 5),
    ("friction", "stuck_count"): (1, 5),
    ("friction", "stuck_joints"): (0, 2),
    ("friction_changes", "count"): (0, None),
    ("friction_element", "index"): (0, 23),
    ("friction_element", "stuck_index"): (0, 23),
    ("friction_element", "mode"): (-1, NO_FRICTION),
}


def put(record, field, i, value):
    if i is None:
        record[field] = value
    else:
        record[field][i] = value


def assert_fits(d, record, field, i, cases):
    """Assert which values of a number pass the check of soundness, and restore the original value."""
    before = d[record][field] if i is None else d[record][field][i]
    for value, fits in cases:
        put(d[record], field, i, value)
        assert bool(is_record_sound(d)) == fits, (field, i, value)
    put(d[record], field, i, before)


@pytest.mark.full("more cases", but=17)
@pytest.mark.parametrize(("record", "field"), [*BOUNDS, *OF_FRICTION])
def test_each_index_has_its_least_and_its_most(record, field):
    if (record, field) in OF_FRICTION:
        least, most = OF_FRICTION[record, field]
        _, d, _ = rubbing_chain(np.random.default_rng(0), "free", 2, True)
        d.friction_element.mode[d.friction_element.index[[0, 3]]] = STICKS
        list_sticking(d)
    else:
        least, most = BOUNDS[record, field]
        _, d = chain(np.random.default_rng(0), 3)
        d.impact.count = 7
        if field == "stop":
            d.candidate.point[:] = 1  # stops belong to joints, and joints are counted from 1
    assert is_record_sound(d)
    shape = np.shape(d[record][field])
    for i in range(shape[0]) if shape else [None]:
        too_small = least - 1 if (record, field) in BOUNDS else min(least, 0) - 1
        assert_fits(d, record, field, i, ((least, True), (too_small, False)))
        if most is not None:
            assert_fits(d, record, field, i, ((most, True), (most + 1, False), (1 << 40, False)))
    assert is_record_sound(d)


def test_no_more_contacts_have_a_force_than_there_are():
    _, d = chain(np.random.default_rng(0), 3)
    mark_touching(d, [1, 4, 7])
    assert_fits(d, "contacts", "force_law_count", None, ((0, True), (3, True), (4, False), (-1, False)))


def test_a_law_may_be_missing_only_before_a_start_without_contacts():
    _, d = chain(np.random.default_rng(0), 3)
    d.law.number[5] = 0
    assert not is_record_sound(d)
    d.chain.longest_link = 0.0  # the start derives the size
    assert is_record_sound(d)
    mark_touching(d, [1])
    assert not is_record_sound(d)
    d.law.number[5] = 1
    assert is_record_sound(d)


def test_a_law_is_copied_from_a_candidate_that_is_not_later():
    _, d = chain(np.random.default_rng(0), 3)
    for c in range(d.candidate_count):
        assert_fits(d, "law", "same_as", c, ((0, True), (c, True), (c + 1, False), (-1, False)))


def test_only_stops_have_the_numbers_after_those_of_walls():
    """Joints begin at 1, because the base, point 0, has no preceding link."""
    d = stopped_chain(3)[1]
    last, stop = 4 + d.candidate_count - 1, stops_of(d)[0]
    assert is_record_sound(d)
    assert_fits(d, "candidate", "wall", 0, ((last, True), (last + 1, False)))
    assert_fits(d, "candidate", "wall", stop, ((last + 2, True),))
    assert_fits(d, "candidate", "point", stop, ((1, True), (3, True), (0, False), (4, False)))


def test_a_stop_belongs_to_a_joint_and_not_to_a_point_on_a_link():
    rod = {"length": 0.3, "mass": 1.0, "joint_max": 1.0}
    links = [rod | {"points": [{"x": 0.1, "y": 0.05}, {"x": 0.2, "y": 0.05}]}, rod]
    still = {"position": [0.0, 1.0], "angles": [0.0, 0.0]}
    d = record_of(table(links, initial=still, base="pinned", box={"y_min": -1.0}))
    stops = stops_of(d)
    assert (d.site_count, len(stops)) == (2, 2)
    assert is_record_sound(d)
    for c in range(d.candidate_count):
        last = 2 if c in stops else 2 + 2
        assert_fits(d, "candidate", "point", c, ((last, True), (last + 1, False)))


@pytest.mark.parametrize("part", ["given", "inputs"])
def test_the_degree_of_a_piece_has_its_bounds(part):
    _, d = chain(np.random.default_rng(0), 1)
    for degree, fits in ((0, True), (INPUT_DEGREE, True), (-1, False), (INPUT_DEGREE + 1, False)):
        d[part].piece.degree = degree
        assert bool(is_record_sound(d)) == fits
        d[part].piece.degree = 0


@pytest.mark.parametrize("field", ["order", "integrals"])
def test_the_loops_over_a_signal_have_their_bounds(field):
    d = Plain(Instance(load_scene("bouncing_table")).record)
    assert_fits(d, "signal", field, 0, ((0, True), (2, True), (-1, False), (3, False), (1 << 50, False)))


def test_a_record_without_room_for_friction_has_none():
    _, d = chain(np.random.default_rng(0), 3)
    assert d.friction_element_count == 0
    for field in ("may_act", "active_count", "contact_count", "stuck_count", "stuck_joints"):
        assert_fits(d, "friction", field, None, ((1, False), (0, True)))


def test_a_users_law_is_one_more(monkeypatch):
    _, d = chain(np.random.default_rng(0), 1)
    d.law.number[0] = LAW_COUNT + 1
    assert not is_record_sound(d)
    monkeypatch.setattr(entry, "has_user_law", lambda: 1)
    assert is_record_sound(d)


def test_a_record_is_sound_with_what_is_beside_it(monkeypatch):
    _, d = chain(np.random.default_rng(0), 1)
    assert is_sound(d) == 1
    monkeypatch.setattr(hooks, "are_tangents_sound", lambda d: 0)
    assert is_sound(d) == 0


@pytest.mark.parametrize(
    ("links", "path", "value"),
    [
        (2, ("candidate_count",), 1 << 20),
        (12, ("candidate_count",), 1 << 20),
        (12, ("link_count",), 1 << 20),  # in the kernel for any number of links
        (2, ("contacts", "active_count"), -2),
        (12, ("step", "method"), 7),
    ],
)
def test_an_unsound_record_of_dual_numbers_is_refused(links, path, value):
    """The compiled kernel would read memory beyond the record."""
    scene = table(
        [{"length": 0.1, "mass": 1.0}] * links, box={"y_min": 0.0}, initial={"angles": [1.0] * links}
    )
    prepared = PreparedScene(scene)
    instance = DifferentiatedInstance(prepared, differentiable_named(prepared, ["contact.stiffness"]))
    assert instance.is_sound(instance.words)
    record = tangents_of(instance)[0]
    for step in path[:-1]:
        record = record[step]
    record[path[-1]] = value
    assert not instance.is_sound(instance.words)

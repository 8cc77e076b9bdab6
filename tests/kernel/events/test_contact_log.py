"""The peaks of a contact, and its row in the log at its end: also at loose tolerances."""

import math

import numpy as np
import pytest

from chain_impact import load_scene, simulate
from chain_impact.kernel import hooks
from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.events import contact_log
from chain_impact.kernel.forces.active_contacts import contact_force
from chain_impact.kernel.forces.force_formula import set_damping
from chain_impact.kernel.ode.quadratures import reset_quadratures
from chain_impact.kernel.record.constants import (
    CONTACT_ENDS,
    KINK,
    NO_EVENT,
    ONSET,
    OUTPUT_READER,
    SOLVER_READER,
)
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.scenes.problems import GRAVITY, build
from tests.helpers.tools.differences import slope
from tests.kernel.chains import located, stopped_chain, stops_of
from tests.kernel.events.motions import DEEP, falling
from tests.kernel.steps import held_tip, let_push, points_of

STIFFNESS = 1e8


@pytest.mark.parametrize("tolerance", [3e-3, 1e-3])
@pytest.mark.parametrize("seed", range(15))
def test_an_elastic_contact_has_its_peak_force_at_its_largest_depth(seed, tolerance):
    """F = K δ^(3/2). At loose tolerances a step may begin before a peak and end with the contact."""
    random = np.random.default_rng(seed)
    initial = {
        "position": [0.0, 0.01],
        "velocity": [0.0, -(10 ** random.uniform(-1, 1))],
        "angles": [random.choice([0.0, 1e-3, 0.3])],
        "angular_velocities": [random.uniform(-3, 3)],
    }
    link, contact = {"length": 0.5, "mass": 1.0}, {"model": "hertz", "stiffness": STIFFNESS}
    scene = build("Rod", [link], initial, {"y_min": 0.0}, contact, gravity=GRAVITY, tolerance=tolerance)
    instance = Instance(scene)
    instance.advance(0.3)
    result = instance.collect()
    assert len(result) > 1
    expected = STIFFNESS * result["max_penetration"] ** 1.5
    np.testing.assert_allclose(result["peak_force"], expected, rtol=5e-3)


K, N = 4.0, 1.5
FINE = np.linspace(0.0, 1.0, 20001)


def depth(t, height):
    return DEEP - np.polynomial.polynomial.polyval(t, height)


def forces(d, t, height):
    """Return F = K δⁿ (1 + λ δ̇/v₀) of the law family, with the latched damping."""
    rate = -np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyder(height))
    return depth(t, height) ** N * (K + d.contacts.damping[1] * rate)


def pressed(height, law="zhang_sharf", size=1.0):
    """Return a step of a contact that has been followed to the step's start, and its motion."""
    d, motion = falling(height, law=law, size=size)
    d.contacts.latched_speed[1] = 3.0
    set_damping(d, 1)
    rate = -height[1]
    d.contacts.peak_force[1] = d.contacts.max_penetration[1] = 0.0
    d.contacts.penetration_rate[1], d.contacts.force_rate[1] = rate, 1.0
    return d, motion


TURNING = [0.0, -0.5, 0.6, 0.1]  # turns within the step


def there(d, points):
    """Assert that the points are located at these positions."""
    np.testing.assert_allclose(located(d), points, rtol=0, atol=1e-13)


@pytest.mark.parametrize("size", [1.0, 0.2])
def test_peaks_are_the_largest_values_on_the_way(size):
    """The largest value lies inside the step, or at its end during compression."""
    d, motion = pressed(TURNING, size=size)
    d.step.dense_for = OUTPUT_READER
    contact_log.update_extremes(d)
    assert d.step.dense_for == (SOLVER_READER if size == 1.0 else OUTPUT_READER)
    t = FINE * size
    assert d.contacts.peak_force[1] == pytest.approx(forces(d, t, TURNING).max(), rel=1e-6)
    assert d.contacts.max_penetration[1] == pytest.approx(depth(t, TURNING).max(), rel=1e-6)
    expected = slope(lambda t: forces(d, t, TURNING), size, 1e-6)
    assert d.contacts.force_rate[1] == pytest.approx(expected, rel=1e-6)
    rate = -np.polynomial.polynomial.polyval(size, np.polynomial.polynomial.polyder(TURNING))
    assert d.contacts.penetration_rate[1] == pytest.approx(rate, rel=1e-12)
    there(d, points_of(d, motion.at(size)))
    # larger earlier peaks stay
    d.contacts.peak_force[1], d.contacts.max_penetration[1] = 1e3, 2e3
    contact_log.update_extremes(d)
    assert (d.contacts.peak_force[1], d.contacts.max_penetration[1]) == (1e3, 2e3)


def test_a_force_that_only_falls_has_no_peak_in_the_step():
    d, _ = pressed([0.0, 0.1, 0.1])
    d.contacts.penetration_rate[1], d.contacts.force_rate[1] = -0.1, -0.5
    locate_points(d, d.step.state_end)
    *_, elsewhere = contact_log.find_peaks(d, 1, -1.0, d.step.end, SOLVER_READER)
    assert not elsewhere


def test_peaks_until_a_time_within_the_step():
    """The peaks count up to the observer's time; an observation changes no contact and counts no cost."""
    for until in (0.1, 0.25, 0.9):
        d, motion = pressed(TURNING)
        y = motion.at(until)
        locate_points(d, y)
        accelerate_points(d, y, motion.at(until, 1))
        rate = contact_log.rate_of_force(d, 1)
        t = FINE * until
        d.step.dense_for = OUTPUT_READER
        evaluations = d.statistics.rhs_evaluations
        force, deepest, elsewhere = contact_log.find_peaks(d, 1, rate, d.step.start + until, OUTPUT_READER)
        assert force == pytest.approx(forces(d, t, TURNING).max(), rel=1e-6)
        assert deepest == pytest.approx(depth(t, TURNING).max(), rel=1e-6)
        assert elsewhere == (rate <= 0.0 or y[d.link_count + 3] >= 0.0)
        assert d.contacts.peak_force[1] == d.contacts.max_penetration[1] == 0.0
        assert d.statistics.rhs_evaluations == evaluations


@pytest.mark.parametrize(
    ("approach_only", "event", "lands"), [(1, KINK, 1), (1, CONTACT_ENDS, 0), (0, KINK, 0)]
)
def test_a_step_that_lands_on_the_turn_is_deepest_there(approach_only, event, lands):
    d, _ = pressed(TURNING, law="jankowski")
    d.law.approach_only[1], d.contacts.event[1] = approach_only, event
    assert contact_log.penetration_turns_at_end(d, 1) == bool(lands)
    d, _ = pressed([0.0, -1.0, 0.5], law="jankowski")  # turns at its end
    d.contacts.event[1] = KINK
    contact_log.update_extremes(d)
    assert d.contacts.max_penetration[1] == pytest.approx(DEEP + 0.5, rel=1e-14)


@pytest.mark.parametrize(
    "height",
    [
        [0.0, -0.5, 0.5],  # a parabola
        TURNING,
        [0.0, -0.5, 1.0, 1.0, 1.0],
        [0.0, -0.05, 0.4],  # at its start
        [0.0, -0.9, 0.5],  # near its end
        [0.0, -0.5, -0.2],  # samples without a maximum
        [0.0, -0.7, 0.1],
        [0.0, 0.2, -0.1],
    ],
)
@pytest.mark.parametrize("until", [1.0, 0.5])
def test_a_maximum_is_found_by_parabolas_wherever_it_is(height, until):
    d, _ = pressed(height)
    result = contact_log.find_largest_penetration(d, 1, 0.5 * until, 0.5 * until, until)
    tops = np.polynomial.polynomial.polyroots(np.polynomial.polynomial.polyder(height))
    places = [0.0, until, *(t.real for t in tops if abs(t.imag) < 1e-12 and 0.0 < t.real < until)]
    most, place = max((depth(t, height), t) for t in places)
    # near an end of the step the last parabola does not reach the maximum
    inside = 0.2 < place / until < 0.9
    assert result == pytest.approx(most, rel=2e-8 if inside else 1e-3)


@pytest.mark.parametrize("due", [False, True])
def test_a_cut_step_forgets_events_after_the_communication_point(due, monkeypatch):
    """An onset and mode changes stay marked if they are exactly at the communication point."""
    d, motion = pressed(TURNING)
    d.contacts.event[:4] = ONSET, CONTACT_ENDS, KINK, NO_EVENT
    dropped = []
    monkeypatch.setattr(contact_log, "drop_mode_marks", dropped.append)
    d.step.communication_point = d.step.end if due else d.step.start + 0.4
    breaks, clock = d.step.break_count, d.step.communication_point
    contact_log.end_at_communication_point(d)
    assert d.step.end == clock
    assert d.contacts.event[:4].tolist() == [ONSET if due else NO_EVENT, NO_EVENT, NO_EVENT, NO_EVENT]
    assert dropped == ([] if due else [d])
    expected = motion.at(1.0 if due else 0.4)
    np.testing.assert_allclose(d.step.state_end[:-2], expected[:-2], rtol=0, atol=1e-13)
    assert d.step.break_count > breaks


def test_contacts_are_followed_to_the_communication_point_at_no_cost(monkeypatch):
    d, motion = pressed(TURNING)
    d.step.communication_point = d.step.start + 0.25
    d.quadrature.computed = 1
    reset_quadratures(d)
    d.quadrature.state_end[0], d.quadrature.integral[1] = 5.0, 1.0
    d.quadrature.state[0], d.quadrature.dense[:, 0] = 2.0, 0.0
    d.quadrature.dense[0, 0] = 4.0  # 2 + 4 θ
    before = d.statistics.rhs_evaluations, d.budget.other_cost
    contact_log.update_instance_to_communication_point(d)
    t = 0.25 * FINE
    assert d.contacts.peak_force[1] == pytest.approx(forces(d, t, TURNING).max(), rel=1e-6)
    assert d.contacts.max_penetration[1] == pytest.approx(depth(t, TURNING).max(), rel=1e-6)
    assert d.quadrature.integral[1] == pytest.approx(3.0, rel=1e-12)
    assert (d.statistics.rhs_evaluations, d.budget.other_cost) == before
    there(d, points_of(d, motion.at(0.25)))
    calls = []
    monkeypatch.setattr(hooks, "on_truncate", calls.append)
    d, _ = pressed(TURNING)
    d.step.communication_point, d.scratch.rate_end[:] = d.step.start + 0.25, math.nan
    contact_log.update_to_communication_point(d)
    assert calls == [d]
    assert d.step.end == d.step.communication_point
    assert d.contacts.max_penetration[1] == pytest.approx(depth(t, TURNING).max(), rel=1e-6)
    # the accelerations belong to the communication point
    assert math.isfinite(d.contacts.force_rate[1])
    there(d, points_of(d, d.step.state_end))


@pytest.mark.parametrize("kept", [0, 4])
@pytest.mark.parametrize("rigid", [0, 1])
def test_the_state_of_contacts_is_noted_at_the_communication_point(rigid, kept):
    for until in (0.1, 0.6):
        d, motion = pressed(TURNING)
        d.latest.requested_count = kept
        make_rigid(d, rigid)
        d.latest.end[0] = -1.0
        d.contacts.impact_number[1] = d.impact.count = 5
        d.step.communication_point = d.step.start + until
        y = motion.at(until)
        locate_points(d, y)
        accelerate_points(d, y, motion.at(until, 1))
        d.output.force[1] = contact_force(d, 1, *clearance_and_rate(d, 1))
        d.output.impulse[1], d.quadrature.impulse_at_onset[1] = 7.5, 3.0
        d.contacts.peak_force[1] = 0.1 * (1 - rigid) + 50.0 * rigid
        contact_log.list_latest(d)
        latest = d.latest
        if kept == 0:
            assert latest.end[0] == -1.0
            continue
        t = until * FINE
        assert latest.end[0] == d.step.communication_point
        assert latest.impulse[0] == 4.5
        assert latest.separation_speed[0] == pytest.approx(y[d.link_count + 3], rel=1e-12)
        force = 50.0 if rigid else forces(d, t, TURNING).max()
        assert latest.peak_force[0] == pytest.approx(force, rel=1e-6)
        deepest = 0.0 if rigid else depth(t, TURNING).max()
        assert latest.max_penetration[0] == pytest.approx(deepest, rel=1e-6)
        there(d, points_of(d, y))


@pytest.mark.parametrize("size", [1e-3, 0.2])
def test_the_peak_of_a_holding_force_is_found_by_parabolas_through_samples(size):
    """The maximum of 3 − (x − 0.6)² is 3 inside; a monotonic force is largest at an end."""
    d, c, motion = held_tip(size, [3.0 - 0.6**2, 1.2, -1.0])
    d.constraints.sampled_force[:] = 0.0
    evaluations = d.statistics.rhs_evaluations
    contact_log.update_held_extremes(d)
    assert d.contacts.peak_force[c] == pytest.approx(3.0, rel=1e-9)
    assert d.statistics.rhs_evaluations - evaluations == contact_log.HELD_SAMPLES
    there(d, points_of(d, motion.at(size)))
    # at the end of a step with a growing force, and through the function for all contacts
    let_push(d, c, [1.0, 2.0])
    d.contacts.peak_force[c], d.contacts.force_rate[c] = 0.5, 77.0
    contact_log.update_extremes(d)
    assert d.contacts.force_rate[c] == 77.0
    assert d.contacts.peak_force[c] == pytest.approx(3.0, rel=1e-9)
    let_push(d, c, [1.0, -0.5])
    d.contacts.peak_force[c] = 0.5
    contact_log.update_held_extremes(d)
    assert d.contacts.peak_force[c] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("rate", [0.4, -0.4])
@pytest.mark.parametrize("rigid", [0, 1])
def test_a_contact_that_ends_is_a_row_of_the_log(rigid, rate):
    d, _ = pressed([0.0, rate, 0.0])
    make_rigid(d, rigid)
    size = len(d.contact_log.point)
    for count in (0, 5, size + 2):  # the oldest are lost
        d.contact_log.count = count
        values = {"onset": 1.5, "impact_speed": 0.7, "peak_force": 9.0, "max_penetration": 0.3}
        for name, value in (values | {"effective_mass": 2.5}).items():
            d.contacts[name][1] = value + count
        d.quadrature.integral[1], d.quadrature.impulse_at_onset[1] = 8.0, 6.5
        d.contacts.active[1] = 1
        contact_log.end_contact(d, 1, rigid)
        assert not d.contacts.active[1]
        log, row = d.contact_log, count % size
        assert log.impact_number[row] == d.contacts.impact_number[1]
        assert log.count == count + 1
        assert (log.point[row], log.wall[row]) == (d.candidate.point[1], d.candidate.wall[1])
        assert log.onset[row] == 1.5 + count
        assert log.end[row] == d.step.end
        assert log.impact_speed[row] == 0.7 + count
        leaves = max(0.0, rate) if rigid else rate
        assert log.separation_speed[row] == pytest.approx(leaves, rel=1e-12)
        assert log.peak_force[row] == 9.0 + count
        assert log.max_penetration[row] == 0.3 + count
        assert log.effective_mass[row] == 2.5 + count
        assert log.impulse[row] == 1.5


def test_a_contact_of_a_stop_is_logged_as_an_angle_and_a_moment():
    """With the lever arm s: φ = δ/s, M = F s, inertia m s². Stops and walls have separate largest peaks."""
    _, d = stopped_chain(2)
    stop, arm, log = stops_of(d)[0], 1.4, d.contact_log
    d.chain.longest_link = arm
    for c, force, depth in ((0, 2.0, 1e-3), (1, 1.0, 5e-3), (2, 3.0, 2e-3), (stop, 9.0, 0.3)):
        d.contacts.impact_speed[c], d.contacts.effective_mass[c] = 0.7, 2.5
        d.contacts.peak_force[c], d.contacts.max_penetration[c] = force, depth
        d.quadrature.integral[c], d.quadrature.impulse_at_onset[c] = 8.0, 6.5
        rate = clearance_and_rate(d, c)[1]
        contact_log.end_contact(d, c, 0)
    logged = [log[name][3] for name in ("impact_speed", "separation_speed", "peak_force", "max_penetration")]
    assert logged == pytest.approx([0.7 / arm, rate / arm, 9.0 * arm, 0.3 / arm])
    assert (log.effective_mass[3], log.impulse[3]) == pytest.approx((2.5 * arm**2, 1.5 * arm))
    assert (d.peaks.moment, d.peaks.rotation) == (log.peak_force[3], log.max_penetration[3])
    assert (d.peaks.force, d.peaks.penetration) == (3.0, 5e-3)


@pytest.mark.parametrize("method", ["auto", "implicit"])
@pytest.mark.parametrize("parts", [(0.46,), (0.3, 0.5, 0.7), (0.48, 0.49, 0.5, 0.51, 0.52)])
def test_a_restart_inside_of_an_impact_loses_no_peak(method, parts):
    """Values that are given again, although unchanged, cause the restart."""
    scene = with_values(load_scene("four_link_box"), {"solver.method": method, "solver.tolerance": 1e-8})
    first = simulate(scene).impacts[0]
    instance = Instance(scene)
    for part in parts:
        instance.advance(first["onset"] + part * (first["end"] - first["onset"]))
        instance.record["given"]["pending"] = 1
    instance.advance(first["end"] + 1e-3)
    result = instance.collect()[0]
    assert result["peak_force"] == pytest.approx(first["peak_force"], rel=1e-6)
    assert result["max_penetration"] == pytest.approx(first["max_penetration"], rel=1e-6)
    assert result["impulse"] == pytest.approx(first["impulse"], rel=1e-7)

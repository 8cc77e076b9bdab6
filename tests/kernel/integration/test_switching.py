"""When implicit steps are taken for joints' damping, and that what is not stiff does without."""

from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.integration.method import IMPLICIT
from chain_impact.kernel.integration.switching import LONGER, MIN_SWITCH_STEPS, suggests_switch
from chain_impact.scene.scene import with_values
from chain_impact.simulation.instance import Instance
from tests.problems import GRAVITY, build, contact_table, stiff_joint


def test_light_damping_stays_explicit():
    result = simulate(with_values(stiff_joint(1e-3), {("simulation", "stop_time"): 0.25}))
    assert len(result.impacts) == 0
    assert result.statistics["implicit_steps"] == 0


@pytest.mark.parametrize("damping", [1e2, 1e4, 1e6])
def test_stiff_damping_is_implicit_in_flight_after_its_own_motion_has_decayed(damping):
    result = simulate(with_values(stiff_joint(damping), {("simulation", "stop_time"): 0.25}))
    steps, implicit = result.statistics["steps"], result.statistics["implicit_steps"]
    assert len(result.impacts) == 0
    assert MIN_SWITCH_STEPS <= steps - implicit <= 30
    assert implicit <= 60


@pytest.mark.parametrize("last", [0.1, 10.0])
@pytest.mark.parametrize("longer", [0.9, 1.1])
def test_the_size_of_the_next_implicit_step_decides(longer, last):
    """The last one may be a first step after an event, or cut short by an input."""
    step = SimpleNamespace(method=IMPLICIT, explicit_size=2.0, start=1.0, end=1.0 + last)
    step.next_size = longer * LONGER * step.explicit_size
    assert suggests_switch(SimpleNamespace(step=step)) == (longer < 1.0)


def test_impacts_between_stiff_joints_take_explicit_steps_from_their_onset():
    """Three implicit steps at each onset first would take 370 right-hand sides more."""
    result = simulate(stiff_joint(100.0), tolerance=1e-7)
    assert len(result.impacts) == 8
    assert result.statistics["rhs_evaluations"] < 4_300
    assert result.statistics["rejected_steps"] < 50


def test_a_forced_method_is_kept():
    scene = with_values(stiff_joint(1.0), {("simulation", "stop_time"): 0.25})
    explicit, implicit = (simulate(scene, method=method).statistics for method in ("explicit", "implicit"))
    assert explicit["implicit_steps"] == 0
    assert implicit["implicit_steps"] == implicit["steps"]


def test_an_onset_leaves_very_stiff_damping_implicit():
    instance = Instance(stiff_joint(1e6))
    while instance.record["impact"]["count"] == 0:
        instance.advance(float(instance.record["step"]["end"]) + 1e-9)
    before = instance.statistics
    instance.advance(float(instance.record["impact"]["last_time"]) + 1e-4)
    after = instance.statistics
    steps = after["steps"] - before["steps"]
    assert steps >= 8
    assert after["implicit_steps"] - before["implicit_steps"] == steps


@pytest.mark.parametrize("damping", [100.0, 1e4])
def test_rigid_walls_have_implicit_steps_in_flight_and_at_rest(damping):
    """Explicit steps take 13,000 for 100 N·m·s/rad, and for 1e4 more work than the limit allows."""
    changes = {("contact", "model"): "newton_impact", ("contact", "restitution"): 0.3}
    instance = Instance(with_values(stiff_joint(damping), changes))
    assert instance.advance(2.0) == 0
    assert instance.record["touch"]["active_count"] > 0
    assert instance.record["step"]["method"] == IMPLICIT
    counts = instance.statistics
    assert counts["implicit_steps"] > 30
    assert counts["steps"] < 400
    assert counts["rhs_evaluations"] < 6_000


@pytest.mark.parametrize(("damping", "most"), [(1e4, 200), (1e6, 600)])
def test_the_projection_onto_rigid_walls_makes_no_steps_short(damping, most):
    """It leaves a fast motion of the joints, for which 2,000 to 5,000 steps were tried."""
    changes = {("contact", "model"): "newton_impact", ("contact", "restitution"): 0.0}
    instance = Instance(with_values(stiff_joint(damping), changes | {("solver", "tolerance"): 1e-6}))
    assert instance.advance(1.0) == 0
    instance.observe()
    counts, weight = instance.statistics, 0.1 * GRAVITY
    assert counts["steps"] + counts["rejected_steps"] < most
    assert instance.record["output"]["force"].sum() == pytest.approx(weight, rel=1e-5)


def test_rigid_walls_alone_make_nothing_stiff():
    changes = {("contact", "model"): "newton_impact", ("solver", "method"): "implicit"}
    result = simulate(with_values(stiff_joint(0.0), changes))
    assert len(result.impacts) > 3
    assert result.statistics["implicit_steps"] == 0


@pytest.mark.parametrize("stiffness", [1e6, 1e8, 1e10])
def test_a_contact_that_rings_for_long_has_implicit_steps(stiffness):
    """A tip settles on a wall and swings there, hardly damped: 4,900 explicit steps at 1e10."""
    links = [{"length": length, "mass": 1.0, "joint_damping": 0.5} for length in (0.5, 0.4)]
    start = {"position": [0.0, 0.0], "angles": [-0.6, -0.9]}
    contact = contact_table(model="flores", stiffness=stiffness, restitution=0.1, points=[2])
    scene = build(
        "Tip",
        links,
        start,
        {"y_min": -0.6},
        contact,
        gravity=9.81,
        stop_time=0.5,
        base="pinned",
        tolerance=1e-8,
    )
    result = simulate(scene)
    assert len(result.impacts) > 0
    assert result.statistics["implicit_steps"] > 5
    assert result.statistics["steps"] < 200
    exact = simulate(scene, tolerance=1e-12, method="explicit")
    assert np.abs(result.angles[-1] - exact.angles[-1]).max() < 1e-7


def test_the_count_does_not_depend_on_the_communication_step():
    counts = set()
    for step in (1.0, 0.01, 0.0007):
        result = simulate(stiff_joint(100.0), output_step=step)
        counts.add(tuple(sorted(result.statistics.items())))
    assert len(counts) == 1

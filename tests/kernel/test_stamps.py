"""No function of the kernel reads a value that belongs to another state."""

# Tests: kernel/advance.py, kernel/entry.py

import numpy as np
import pytest

from chain_impact import SimulationError, load_scene, simulate
from chain_impact.kernel.advance import advance, set_communication_point
from chain_impact.kernel.chain import kinematics
from chain_impact.kernel.constraints.geometry import clearance_acceleration, clearance_and_rate
from chain_impact.kernel.cost import UNLIMITED, cost_so_far
from chain_impact.kernel.entry import advance_to
from chain_impact.kernel.events import contact_log
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.observe import observe
from chain_impact.kernel.status import OK
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns import random_scenes
from tests.helpers.kernel.plain import Plain, record_of
from tests.helpers.kernel.stamps import StaleError, stamp, watched

KINDS = ("SLANTED", "SPRUNG", "STOPPED", "RUBBED", "DRIVEN", "SIGNALLED")


def run(scene, stop, rows=6):
    """Run a scene as plain Python with stamps, and return the instance."""
    d = record_of(scene)
    stamp(d)
    with watched(), np.errstate(all="ignore"):
        status = initialize(d, 0.0)
        for time in np.linspace(0.0, stop, rows):
            status = status or advance_to(d, time)
            observe(d)
    return d


@pytest.mark.parametrize(
    ("model", "stop"),
    [
        ("double_pendulum_wall", 0.7),
        ("bouncing_table", 0.5),
        pytest.param("sliding_rod", 0.3, marks=pytest.mark.full("another contact: it sticks and slides")),
        pytest.param("stick_slip_belt", 0.7, marks=pytest.mark.full("another kind of motion: a belt")),
        pytest.param("thrown_brick", 0.6, marks=pytest.mark.full("other places: points of links")),
        pytest.param("arm_at_stop", 0.5, marks=pytest.mark.full("another method: implicit")),
        pytest.param("cart_pole", 0.5, marks=pytest.mark.full("another base: a slider")),
    ],
)
def test_a_run_reads_only_what_belongs_to_its_state(model, stop):
    d = run(load_scene(model), stop)
    assert d.statistics.status == OK
    assert d.step.communication_point == stop


def near_first_onset(scene):
    """Return an instance that the compiled kernel has brought to a time just before the first onset."""
    try:
        impacts = simulate(scene, output=[]).impacts
    except SimulationError as error:
        impacts = error.result.impacts
    instance, d = Instance(scene), record_of(scene)
    instance.advance(0.999999 * impacts["onset"][0] if len(impacts) else 0.0)
    d.copy_values(Plain(instance.record))
    d.step.rate_known = d.scratch.located_at_end = 0  # the stamps begin without a state
    stamp(d)
    return d


@pytest.mark.full("random scenes, with all that a scene can have")
@pytest.mark.parametrize("kind", KINDS)
def test_random_scenes_read_only_what_belongs_to_their_states(kind):
    for seed in range(3):
        scene = random_scenes.scene(getattr(random_scenes, kind) + seed)
        d = near_first_onset(scene.with_values({"solver.work_limit": 1e4}))
        with watched(), np.errstate(all="ignore"):
            advance(d, scene.simulation.stop_time, UNLIMITED, cost_so_far(d) + 150)
            set_communication_point(d, d.step.end)
            observe(d)


def test_components_as_long_as_a_state_are_no_state():
    """This scene has as many loads as its state has entries."""
    d = run(random_scenes.scene(random_scenes.SLANTED + 662), 1e-9, rows=2)
    assert d.statistics.status == OK
    assert d.transmitted_row_count == len(d.step.state)


def test_a_read_of_another_state_is_found():
    d = run(load_scene("double_pendulum_wall"), 0.01)
    y = d.step.state_end.copy()
    other = y + 1e-9
    with watched():
        kinematics.locate_points(d, y)
        kinematics.accelerate_points(d, y, d.scratch.rate_end)
        clearance_acceleration(d, 0)
        kinematics.locate_points(d, other)
        clearance_and_rate(d, 0)
        with pytest.raises(StaleError, match="acceleration of another state"):
            clearance_acceleration(d, 0)
        kinematics.set_link_vectors(d, y)
        with pytest.raises(StaleError, match="position of another state"):
            clearance_and_rate(d, 0)


def test_a_step_whose_points_are_elsewhere_is_found(monkeypatch):
    monkeypatch.setattr(contact_log, "ensure_points", lambda _: None)
    with pytest.raises(StaleError, match="position of another state"):
        run(load_scene("rod_drop"), 0.7)

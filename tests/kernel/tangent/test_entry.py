"""What a caller asks of an instance with derivatives: any times, any number of parameters, any pieces."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact import SimulationError, load_scene
from chain_impact.kernel.status import NOT_FINITE, OK
from chain_impact.kernel.tangent import directions, entry
from chain_impact.simulation.instance import Instance
from chain_impact.simulation.simulate import simulate
from tests.derivative_scenes import Case, struck_twice
from tests.kernel.tangent.dual import followed, started

CASE = struck_twice("flores")
NAMES = CASE.parameters[: 2 * directions.DIRECTIONS + 1]
TIMES = np.linspace(0.0, 0.3, 31)


def of(*names):
    return Case(CASE.scene, names, CASE.times)


@pytest.fixture(scope="module")
def together():
    return followed(started(of(*NAMES)), TIMES)


def test_the_number_of_parameters_beside_one_does_not_matter(together):
    """They are carried in several instances of dual numbers, one after the other."""
    values, slopes = together
    for k in (0, directions.DIRECTIONS - 1, directions.DIRECTIONS, 2 * directions.DIRECTIONS):
        alone, slope = followed(started(of(NAMES[k])), TIMES)
        np.testing.assert_array_equal(alone, values)
        np.testing.assert_array_equal(slope[..., 0], slopes[..., k])


def test_the_pieces_in_which_a_run_is_made_do_not_matter(together):
    instance = started(of(*NAMES))
    pieces = [followed(instance, part) for part in np.array_split(TIMES, 5)]
    np.testing.assert_array_equal(np.concatenate([values for values, _ in pieces]), together[0])
    np.testing.assert_array_equal(np.concatenate([slopes for _, slopes in pieces]), together[1])


def test_impacts_are_followed_to_the_communication_point():
    """Within a contact: its largest force until then, and how that varies, as the run itself has it."""
    names = ("contact.stiffness", "contact.restitution")
    onset = simulate(CASE.scene).impacts["onset"][0]
    at = onset + 4e-4
    scene = CASE.scene.with_values({"simulation.stop_time": at, "simulation.step_size": at})
    result = simulate(scene, tolerance=1e-12, sensitivities=names)
    assert np.isnan(result.impacts["end"]).tolist() == [True]
    found = {name: result.impact_sensitivity("peak_force", name)[0] for name in names}
    for name in names:
        by = 1e-4 * scene.values[name]
        above, below = (
            simulate(scene.with_values({name: scene.values[name] + sign * by}), tolerance=1e-12)
            for sign in (1, -1)
        )
        right = (above.impacts["peak_force"][0] - below.impacts["peak_force"][0]) / (2.0 * by)
        assert found[name] == pytest.approx(right, rel=1e-6)
        assert np.isnan(result.impact_sensitivity("end", name)).all()
        assert np.isfinite(result.impact_sensitivity("impact_speed", name)).all()


def test_a_log_that_is_full_is_emptied_on_the_way():
    """A ball bounces more often between two rows than the log has room for: t_n − t_1 = 2 v Σ eᵏ/g."""
    name = "contact.restitution"
    scene = load_scene("bouncing_ball")
    result = simulate(scene, output_step=math.inf, sensitivities=name)
    impacts, e = result.impacts, scene.contact.restitution
    assert len(impacts) > len(Instance(scene).record["finished"]["point"])
    powers = np.arange(1, len(impacts))
    terms = 2.0 * impacts["impact_speed"][0] / -scene.gravity[1] * powers * e ** (powers - 1.0)
    bounces = 40  # before it comes to rest
    found = result.impact_sensitivity("onset", name)
    np.testing.assert_allclose(found[1:bounces], np.cumsum(terms)[: bounces - 1], rtol=1e-6)
    often = simulate(scene, sensitivities=name)
    np.testing.assert_allclose(found, often.impact_sensitivity("onset", name), rtol=1e-9)


def test_a_fault_ends_both():
    scene = CASE.scene.with_values({"solver.work_limit": 300})
    with pytest.raises(SimulationError) as plain:
        simulate(scene)
    with pytest.raises(SimulationError) as caught:
        simulate(scene, sensitivities="contact.stiffness")
    assert caught.value.status == plain.value.status
    result, right = caught.value.result, plain.value.result
    assert 0 < len(result.time) == len(right.time)
    assert result.outputs.tobytes() == right.outputs.tobytes()
    assert result.sensitivity("point[0].x", "contact.stiffness").shape == result.time.shape


SIZES = {"links": 2, "candidates": 6, "elements": 8}
WIDE, LOOKS, BLOCKS = 1 + directions.DIRECTIONS, 4, 2


def output(words):
    return SimpleNamespace(words=words)


@pytest.fixture
def d():
    """An instance with four outputs, and two of dual numbers behind it: each number is told by its place."""
    one = SimpleNamespace(tangents=BLOCKS, **SIZES, output=output(np.arange(4.0)))
    one.statistics = SimpleNamespace(status=OK)
    one.tangent_instances = [
        SimpleNamespace(**SIZES, output=output(1000.0 * (b + 1) + np.arange(LOOKS * WIDE)))
        for b in range(BLOCKS)
    ]
    return one


def test_slopes_are_forgotten_and_values_are_not():
    numbers = np.arange(2.0 * WIDE)
    entry.forget_slopes(numbers)
    assert numbers[[0, WIDE]].tolist() == [0.0, WIDE]
    assert np.isnan(np.delete(numbers, [0, WIDE])).all()


@pytest.mark.parametrize("status", [OK, NOT_FINITE])
def test_after_a_fault_no_derivative_is_told_nor_one_that_is_not_trusted(d, status, monkeypatch):
    filled = []
    monkeypatch.setattr(entry, "fill_outputs", filled.append)
    monkeypatch.setattr(entry, "trusted", lambda t: t is d.tangent_instances[1])
    d.statistics.status = status
    entry.observe_all(d)
    assert filled == d.tangent_instances
    for t, kept in zip(d.tangent_instances, (False, status == OK), strict=True):
        assert math.isnan(t.output.words[1]) != kept


def test_the_earliest_end_of_all_is_shared_by_all(d, monkeypatch):
    d.tangents = 3
    d.tangent_instances.append(SimpleNamespace())
    d.tangent_instances = [SimpleNamespace(end=end) for end in (5.0, 3.0, 4.0)]
    replayed = []
    monkeypatch.setattr(entry, "replay", lambda _, t: replayed.append(t))

    def share_reason(t, other):
        t.end = min(t.end, other.end)

    monkeypatch.setattr(entry, "share_reason", share_reason)
    entry.replay_all(d)
    assert replayed == d.tangent_instances
    assert [t.end for t in d.tangent_instances] == [3.0, 3.0, 3.0]


def test_each_follows_its_contacts_and_then_its_end(d, monkeypatch):
    done = []
    monkeypatch.setattr(entry, "update_own_to_output_time", lambda t: done.append(("contacts", t)))
    monkeypatch.setattr(entry, "move_end", lambda t: done.append(("end", t)))
    monkeypatch.setattr(entry, "share_reasons", lambda d: done.append(("shared", d)))
    entry.truncate_all(d)
    assert done[:-1] == [(what, t) for t in d.tangent_instances for what in ("contacts", "end")]
    assert done[-1] == ("shared", d)


@pytest.mark.parametrize("wrong", [0, 1])
@pytest.mark.parametrize("what", [*SIZES, "bounds"])
def test_one_that_is_not_valid_is_enough(d, wrong, what, monkeypatch):
    valid = [True, True]
    monkeypatch.setattr(entry, "within_bounds", lambda t: valid[t is d.tangent_instances[1]])
    assert entry.all_valid(d)
    if what == "bounds":
        valid[wrong] = False
    else:
        setattr(d.tangent_instances[wrong], what, 7)
    assert not entry.all_valid(d)

"""Random scenes at rest: the run reaches its end, and the state stays constant."""

import math

import numpy as np
import pytest

from chain_impact import simulate
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import scene_from_dict
from chain_impact.simulation.instance import Instance
from tests.helpers.campaigns.resting import KINDS, LONG, SHORT, run, scene as random_scene
from tests.helpers.scenes.problems import of_law

RESTS = 1e-12  # allowed change of the energy balance over the energies in the last quarter of a run at rest


def check_rest(rests):
    """Check that no run ends early, and that the energy of a chain at rest stays the same."""
    assert [rest for rest in rests if rest.status != OK] == []
    for rest in rests:
        assert not rest.rests or rest.drift < RESTS


@pytest.mark.parametrize("kind", KINDS)
def test_chains_that_rest_go_on_to_rest(kind):
    check_rest([run(kind, seed, SHORT) for seed in range(8)])


CHATTERED = {
    "rigid_drop": (2, 113, 584, 905, 2251, 2400, 2612),
    "rigid_pendulum": (1611,),
    "rod_on_slope": (1407,),
    "sprung_stops": (22, 77, 934, 1717),
}


@pytest.mark.parametrize(("kind", "seed"), [(kind, seed) for kind in CHATTERED for seed in CHATTERED[kind]])
def test_chains_that_chattered_come_to_rest(kind, seed):
    assert run(kind, seed, SHORT).status == OK


# The energy changed by corrections of the last iteration and of the dense output, by motions of sticking
# elements in the stages of implicit steps, and, in explicit steps, by the way back to the anchors.
CREPT = {
    "rod_on_floor": (877, 1576, 2373, 2473),
    "rod_on_slope": (218, 974, 1660, 1753),
    "double_pendulum": (766, 1473),
}


@pytest.mark.parametrize("kind", CREPT)
def test_friction_at_rest_does_no_work(kind):
    check_rest([run(kind, seed, SHORT) for seed in CREPT[kind]])


@pytest.mark.parametrize(("kind", "seeds"), [("pendulum", (70, 207, 243, 295)), ("rigid_pendulum", (125,))])
def test_friction_in_a_joint_does_no_work_in_an_hour(kind, seeds):
    """Without a correction, the equal round-off of each step of a second adds up to more than is allowed."""
    check_rest([run(kind, seed, LONG) for seed in seeds])


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("rod_on_floor", seed) for seed in (5, 11, 14, 36, 54)]
    + [("rod_on_slope", seed) for seed in (4, 7, 10, 24, 33)],
)
def test_friction_forces_at_rest_do_not_depend_on_the_tolerance(kind, seed):
    """An end that still slides when the other one sticks slows down without a stop: it keeps its limit."""
    scene, friction_forces = random_scene(kind, seed), []
    for tolerance in (1e-8, 1e-9, 1e-10):
        result = simulate(scene.with_values({"solver.tolerance": tolerance, "solver.method": "auto"}))
        normal, friction, sticking = (
            np.array([result[name][-1] for name in result.names if name.endswith(f"wall.{output}")])
            for output in ("force", "friction_force", "sticking")
        )
        (end,) = np.flatnonzero((normal > 0.0) & (sticking == 0))
        assert abs(friction[end]) == pytest.approx(scene.contact.friction * normal[end], rel=1e-9)
        friction_forces.append(friction)
    assert np.ptp(friction_forces, axis=0).max() < 1e-3 * normal.max()


@pytest.mark.parametrize("tilt", [1e-4, 3e-4])
def test_a_chain_that_lies_almost_flat_rests_in_long_steps(tilt):
    link = {"length": 0.3, "mass": 0.5}
    table = {
        "name": "Flat",
        "chain": {"base": "free", "links": [link, link]},
        "box": {"y_min": 0.0},
        "contact": of_law("tsuji") | {"stiffness": 1e6, "restitution": 0.3, "friction": 0.5},
        "initial": {"position": [0.0, 1e-4], "angles": [tilt, -2.0 * tilt]},
        "solver": {"tolerance": 1e-9, "method": "implicit"},
    }
    counts = counts_between(scene_from_dict(table, "flat"), 1.0, 5.0)
    assert counts["steps"] < 80
    assert counts["rejected_steps"] < 10


@pytest.mark.parametrize(
    ("kind", "seed", "share"),
    [("rod_on_floor", 261, share) for share in (1.0, 1.02, 1.04, 1.06)]
    + [("rod_on_floor", 63, 1.0), ("rod_on_slope", 112, 1.0)],
)
def test_round_off_does_not_shorten_the_steps_at_rest(kind, seed, share):
    """The round-off of positions exceeds the tolerance of a penetration; without bounds, steps are 0.2 ms."""
    scene = random_scene(kind, seed)
    tolerance = share * scene.solver.tolerance
    assert counts_between(scene.with_values({"solver.tolerance": tolerance}), 5.0, 15.0)["steps"] < 200


def counts_between(scene, start, end):
    """Return the numbers of steps from a start to an end time [s]."""
    instance, counts = Instance(scene), []
    for until in (start, end):
        row = np.zeros(1, instance.record.dtype["output"])
        while not instance.trajectory(np.array([until]), row):
            instance.collect()
        counts.append(instance.statistics)
    return {name: counts[1][name] - counts[0][name] for name in ("steps", "rejected_steps")}


@pytest.mark.parametrize("count", [2, 3])
def test_a_straight_chain_slides_down_a_slope_for_half_an_hour(count):
    """All points touch and the joints stick: more constraints than coordinates, 3000 km from the origin."""
    angle, last = -0.19, 1800.0
    links = [{"length": 0.3 + 0.1 * i, "mass": 1.0, "joint_friction": 1.0} for i in range(count)]
    table = {
        "name": "Slides",
        "chain": {"base": "free", "links": links},
        "walls": [{"name": "slope", "point": [0.0, 0.0], "angle": angle}],
        "contact": {"model": "newton_impact"},
        "initial": {"angles": [angle] * count},
        "simulation": {"stop_time": last, "step_size": last},
    }
    result = simulate(scene_from_dict(table, "slides"))
    for i in range(count):
        # the round-off of positions, 5e-10 m, over the length
        assert result[f"link[{i + 1}].angle"][-1] == pytest.approx(angle, abs=1e-8)
    speed = math.hypot(result["point[0].vx"][-1], result["point[0].vy"][-1])
    assert speed == pytest.approx(9.81 * math.sin(-angle) * last, rel=1e-12)


@pytest.mark.full("more cases", but="pendulum")
@pytest.mark.parametrize("kind", ["pendulum", "double_pendulum", "rigid_pendulum"])
def test_an_hour_of_rest_is_held(kind):
    rests = [run(kind, seed, LONG) for seed in range(20)]
    assert sum(rest.rests for rest in rests) > 8
    check_rest(rests)

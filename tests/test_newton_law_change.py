"""Changing the contact law to and from rigid walls, in flight and while points are held."""

import numpy as np
import pytest

from chain_impact import SimulationError
from chain_impact.kernel.laws.contact_laws import CONTACT_LAWS
from chain_impact.kernel.status import RIGID_WHILE_TOUCHING
from chain_impact.simulation.instance import Instance
from tests.newton import LAW, WEIGHT, floor_forces, rigid
from tests.problems import ball, default_scene


def change_law(instance, law):
    instance.record["given"]["law"] = CONTACT_LAWS[law].number
    instance.record["given"]["changed"] = 1


def test_in_flight_the_law_may_change_to_it():
    instance = Instance(default_scene())
    assert instance.advance(0.4) == 0
    change_law(instance, LAW)
    assert instance.advance(2.0) == 0
    impacts = instance.collect()
    assert (impacts["end"] == impacts["onset"])[:5].all()


def test_while_a_point_is_in_a_wall_it_may_not():
    instance = Instance(default_scene(restitution=0.05))
    assert instance.advance(9.0) == 0
    change_law(instance, LAW)
    assert instance.advance(9.1) == RIGID_WHILE_TOUCHING
    assert instance.time == 9.0
    text = str(SimulationError(RIGID_WHILE_TOUCHING, 9.0, None))
    assert LAW in text


def test_held_contacts_pass_to_another_law():
    instance = Instance(default_scene(model=LAW, restitution=0.3))
    assert instance.advance(8.0) == 0
    assert instance.record["touch"]["active_count"] == 5
    change_law(instance, "zhang_sharf")
    out = np.zeros(1, instance.record.dtype["output"])
    instance.record["finished"]["count"] = 0
    assert instance.trajectory(np.array([12.0]), out) == 1
    assert floor_forces(out[0]).sum() == pytest.approx(WEIGHT, rel=1e-5)
    assert (out["penetration"][0].reshape(5, 4)[:, 2] > 0.0).all()


@pytest.mark.parametrize("look", [False, True])
def test_a_change_that_is_refused_leaves_the_contacts_rigid(look):
    """An output asked for in between, when the parameters do not yet go together, changes nothing."""

    def after(settings):
        instance = Instance(rigid(ball(height=0.01), restitution=0.0))
        assert instance.advance(1.0) == 0
        for law, restitution in settings:
            instance.record["given"]["restitution"] = restitution
            change_law(instance, law)
            if look:
                instance.observe()
        return instance, instance.advance(1.5)

    instance, status = after([("zhang_sharf", 0.0), ("zhang_sharf", 0.7)])
    assert status == 0
    assert instance.record["finished"]["count"] == 1
    _, status = after([("kelvin_voigt", 0.7), (LAW, 0.7)])
    assert status == 0

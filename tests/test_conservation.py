"""Conservation: what flight, impacts and any scene at all keep of energy and momenta."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from chain_impact import CONTACT_LAWS, simulate
from chain_impact.scene.scene import SOLVER_METHODS
from tests.problems import GRAVITY, build, contact_table, default_scene, of_law, rod, tumbling_chain
from tests.reference import momenta


def ledger(result):
    """What must stay constant: the energy that is there, was lost and was not put in."""
    energy = result.energy
    return energy["total"] + energy["dissipated"] - energy["supplied"]


# --- flight ------------------------------------------------------------------------------------------------


def test_a_tumbling_chain_keeps_energy_and_momenta_for_ten_seconds():
    result = simulate(tumbling_chain(stop_time=10.0, tolerance=1e-10))
    momentum, spin = momenta(result)
    mass = sum(link.mass for link in result.scene.chain.links)
    momentum[:, 1] += mass * GRAVITY * result.time
    for quantity in (result.energy["total"], momentum[:, 0], momentum[:, 1], spin):
        assert np.ptp(quantity) < 1e-9 * max(abs(quantity[0]), 1.0)


def test_energy_drift_falls_with_the_tolerance():
    drifts = [np.ptp(simulate(tumbling_chain(2.0, tol)).energy["total"]) for tol in (1e-4, 1e-6, 1e-8, 1e-10)]
    assert drifts == sorted(drifts, reverse=True)
    assert drifts[-1] < 1e-4 * drifts[0]


# --- energy ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", CONTACT_LAWS)
def test_energy_never_rises_and_the_ledger_closes(law):
    result = simulate(default_scene(**of_law(law)), stop_time=2.0, tolerance=1e-10)
    energy, start = result.energy, result.energy["total"][0]
    assert start == pytest.approx(61.6630096858, abs=1e-9)
    assert len(result.impacts) >= 5
    assert (np.diff(energy["total"]) < 1e-8 * start).all()
    assert (np.diff(energy["dissipated"]) >= -1e-11 * start).all()  # but for round-off
    assert (result.outputs["force"] >= 0.0).all()
    assert np.ptp(ledger(result)) < 1e-6 * start


@pytest.mark.parametrize("method", SOLVER_METHODS)
def test_ledger_closes_to_the_tolerance_when_the_force_ends_before_the_contact(method):
    """A rod's end leaves a soft, damped wall faster than its surface returns: no force, but depth to lose."""
    scene = rod(1.0, 1.0, 0.0, gravity=GRAVITY, stop_time=0.55, restitution=0.25, stiffness=1e4)
    result = simulate(scene, tolerance=1e-10, output_step=1e-4, method=method)
    outputs = result.outputs
    assert ((outputs["penetration"] > 1e-3) & (outputs["force"] == 0.0)).any()
    assert np.ptp(ledger(result)) < 1e-7 * ledger(result)[0]


# --- any scene ---------------------------------------------------------------------------------------------


LENGTHS = st.floats(0.1, 0.5)
ANGLES = st.floats(-math.pi, math.pi)


@st.composite
def boxed_chains(draw):
    """Four links of any kind and motion, in a box that they may outgrow when stretched."""
    links = [
        {
            "length": draw(LENGTHS),
            "mass": draw(st.floats(0.1, 5.0)),
            "center_of_mass": draw(st.floats(0.0, 0.5)),
            "inertia": draw(st.floats(1e-3, 0.2)),
            "joint_damping": draw(st.sampled_from([0.0, 0.05])),
        }
        for _ in range(4)
    ]
    law = draw(st.sampled_from([law for law in CONTACT_LAWS if law != "hertz"]))
    contact = contact_table(
        **of_law(law, draw(st.sampled_from([1.0, 1.5, 2.0]))),
        stiffness=10 ** draw(st.floats(4.0, 10.0)),
        restitution=draw(st.floats(0.05, 1.0)),
        radius=draw(st.sampled_from([0.0, 0.02])),
    )
    angles = draw(st.lists(ANGLES, min_size=4, max_size=4))
    lengths = [link["length"] for link in links]
    reach = np.cumsum([np.array(lengths) * f(angles) for f in (np.cos, np.sin)], axis=1)
    low, high = np.minimum(reach.min(axis=1), 0.0), np.maximum(reach.max(axis=1), 0.0)
    margin = draw(st.floats(0.05, 0.5)) + contact["radius"]
    box = {
        "x_min": low[0] - margin,
        "x_max": high[0] + margin,
        "y_min": low[1] - margin,
        "y_max": high[1] + margin,
    }
    initial = {
        "angles": angles,
        "velocity": draw(st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=2)),
        "angular_velocities": draw(st.lists(st.floats(-6.0, 6.0), min_size=4, max_size=4)),
    }
    return build("Any", links, initial, box, contact, gravity=GRAVITY, stop_time=0.3, tolerance=1e-9)


@given(boxed_chains())
@settings(max_examples=300, deadline=None, derandomize=True)
def test_any_scene_keeps_the_laws_of_physics(scene):
    result = simulate(scene)
    outputs, balance = result.outputs, ledger(result)
    assert np.isfinite(np.frombuffer(outputs.tobytes())).all()
    assert (outputs["force"] >= 0.0).all()
    scale = result.energy["kinetic"].max() + np.ptp(result.energy["potential"])
    assert np.ptp(balance) < 1e-5 * scale
    assert np.diff(result.energy["total"]).max() < 1e-6 * scale
    # nothing tunnels: who is beyond a wall is in contact, and no deeper than the energy there is can push it
    box, contact = scene.box, scene.contact
    sides = [(0, box.x_min), (0, -box.x_max), (1, box.y_min), (1, -box.y_max)]
    gaps = []
    for point in range(5):
        for wall, (axis, place) in enumerate(sides):
            sign = 1.0 - 2.0 * (wall % 2)
            gaps.append(sign * result.points[:, point, axis] - place - contact.radius)
    depths = np.maximum(0.0, -np.transpose(gaps))
    np.testing.assert_allclose(outputs["penetration"], depths, rtol=0, atol=1e-10)
    energy = contact.stiffness * depths ** (contact.exponent + 1) / (contact.exponent + 1)
    assert energy.max() <= scale * (1 + 1e-6)

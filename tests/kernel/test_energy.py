"""The energies of a chain with springs and contacts, and their balance, which no motion changes."""

# Tests: kernel/equations.py

import numpy as np
import pytest

from chain_impact.kernel import equations
from chain_impact.kernel.chain import drives, kinematics
from chain_impact.kernel.equations import energy_balance, mechanical_energy, stored_energy
from chain_impact.kernel.forces import active_contacts, force_formula
from tests.helpers.kernel.plain import make_rigid
from tests.helpers.models.reference import centre_jacobian
from tests.kernel.chains import chain, locate_touching_state, mark_touching, move_wall_to_depth

CASES = [("free", 1), ("free", 4), ("pinned", 1), ("pinned", 3)]
BASES = pytest.mark.parametrize(("base", "count"), CASES)


def prepared(base, count, **more):
    """Return a chain with all that resists and drives, in contact with two walls by some depth; its state."""
    rng = np.random.default_rng([count, len(base)])
    scene, d = chain(rng, count, base, springs=True, dampers=True, inputs=True, **more)
    candidates = [1, d.candidate_count - 1]
    y = locate_touching_state(rng, d, candidates)
    for k, c in enumerate(candidates):
        if not d.contact_settings.any_rigid:
            active_contacts.latch_onset(d, c)
        move_wall_to_depth(d, c, 1e-3 * (k + 1))
    active_contacts.set_kink_sides(d)
    d.inputs.motor[:-1], d.inputs.tip_force[:] = rng.normal(size=count), rng.normal(size=2)
    return scene, d, y, candidates


@BASES
def test_kinetic_and_potential_energy_are_those_of_the_centres_of_mass(base, count):
    """½ Σ (m v_C² + I ω²), and −Σ m g·p_C."""
    scene, d, y, _ = prepared(base, count)
    angles, rates = y[2 : count + 2], y[count + 2 : 2 * count + 4]
    kinetic, potential = mechanical_energy(d, y)
    speeds = [centre_jacobian(scene, angles, i) @ rates for i in range(count)]
    twice = [
        link.mass * v @ v + link.inertia * omega**2
        for link, v, omega in zip(scene.chain.links, speeds, rates[2:], strict=True)
    ]
    assert kinetic == pytest.approx(0.5 * sum(twice), rel=1e-12)
    place, expected = y[0] + 1j * y[1], 0.0
    for link, angle in zip(scene.chain.links, angles, strict=True):
        centre = place + link.center_of_mass * np.exp(1j * angle)
        expected -= link.mass * (scene.gravity[0] * centre.real + scene.gravity[1] * centre.imag)
        place += link.length * np.exp(1j * angle)
    assert potential == pytest.approx(expected, rel=1e-12)


@BASES
def test_stored_energy_is_that_of_springs_and_pressed_contacts(base, count):
    _, d, y, (first, _second) = prepared(base, count)
    assert d.chain.has_springs == (count > 1 or base == "pinned")
    springs = drives.spring_energy(d, y)
    contacts = [force_formula.elastic_energy(d, 0, depth) for depth in (1e-3, 2e-3)]
    assert stored_energy(d, y) == pytest.approx(springs + sum(contacts), rel=1e-9)
    move_wall_to_depth(
        d, first, -1e-3
    )  # the point has left its wall, and the end of its contact is not located yet
    assert stored_energy(d, y) == pytest.approx(springs + contacts[1], rel=1e-9)
    d.chain.has_springs = 0
    assert stored_energy(d, y) == pytest.approx(contacts[1], rel=1e-9)
    make_rigid(d)
    assert stored_energy(d, y) == 0.0
    d.chain.has_springs = 1
    make_rigid(d, 0)
    mark_touching(d, [])
    assert stored_energy(d, y) == springs


@BASES
@pytest.mark.parametrize("law", ["zhang_sharf", "jankowski", "newton_impact"])
def test_no_motion_changes_the_energy_balance(base, count, law):
    """The reference is a central difference along ẏ, under gravity, springs, dampers, inputs and contacts."""
    _, d, y, _ = prepared(base, count, model=law, stiffness=1e5)
    if d.contact_settings.any_rigid:
        mark_touching(d, [])
    rate, h, ends, scale = np.zeros(len(y)), 1e-6, [], []
    equations.rate_from_state(d, y, rate)
    for side in (h, -h):
        moved = y + side * rate
        kinematics.locate_points(d, moved)
        ends.append(energy_balance(d, moved))
        scale.append(sum(mechanical_energy(d, moved)))
    assert (ends[0] - ends[1]) / (2 * h) == pytest.approx(0.0, abs=2e-5 * max(1.0, abs(ends[0])))
    # the motion changes each energy by itself
    assert abs(scale[0] - scale[1]) / (2 * h) > 1e-2
    y[2 * count + 4] += 3.0
    y[2 * count + 5] += 10.0
    before = energy_balance(d, y - 0.0)
    y[2 * count + 4] += 3.0
    y[2 * count + 5] += 10.0
    assert energy_balance(d, y) - before == pytest.approx(3.0 - 10.0, abs=1e-8 * max(1.0, abs(before)))

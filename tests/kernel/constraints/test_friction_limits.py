"""Forces within the limits of friction, against a dense solver for bounded least squares."""

import numpy as np
import pytest
from scipy.linalg import cholesky
from scipy.optimize import lsq_linear

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.constraints.friction_limits import find_limited_forces
from chain_impact.kernel.constraints.geometry import constraint_count
from chain_impact.kernel.constraints.impulses import LEAST_STICKING_IMPEDANCE
from chain_impact.kernel.equations import rate_from_points
from chain_impact.kernel.forces.friction import list_sticking
from chain_impact.kernel.record.constants import STICKS
from tests.kernel.rubbing import AtRest, Doubled

CASES = [("free", 3, True), ("free", 2, False), ("pinned", 1, True), ("pinned", 0, True)]


def stuck(seed, case, part):
    """Return a chain whose elements all stick, with limits of 0.2 to 1.5 times ``part`` of their forces."""
    chain = AtRest(seed, *case)
    d = chain.d
    d.friction_element.mode[chain.elements] = STICKS
    list_sticking(d)
    limits = part * np.random.default_rng(seed).uniform(0.2, 1.5, len(chain.elements))
    solve(d)
    set_limits(chain, limits * np.abs(d.friction_element.force[chain.elements]))
    return chain


def set_limits(chain, limits):
    """Set the friction limits of the elements [N]."""
    d = chain.d
    for e, limit in zip(chain.elements, limits, strict=True):
        if e < d.candidate_count:
            d.law.static_friction[e] = d.law.friction[e] = limit / d.contacts.force[e]
        else:
            d.drive.friction[e - d.candidate_count] = limit * d.chain.longest_link
            d.friction_element.friction_limit[e] = limit


def solve(d):
    """Let the kernel find the holding forces of all sticking elements at the end of the last step."""
    rate = np.zeros(len(d.step.state_end))
    locate_points(d, d.step.state_end)
    rate_from_points(d, d.step.state_end, rate)


def forces(d):
    """Return the forces of all sticking elements [N]."""
    return d.limited_forces.force[d.contacts.active_count : constraint_count(d)]


def bounded(chain):
    """Return the forces within the limits [N] by a dense solver, and the signs of those at their limits."""
    limits, root = chain.limits()[0], cholesky(chain.mobility)
    force = lsq_linear(root, -np.linalg.solve(root.T, chain.bias), (-limits, limits), method="bvls").x
    return force, np.where(np.abs(force) >= limits * (1.0 - 1e-9), np.sign(force), 0.0)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("part", [0.3, 1.0])
def test_forces_hold_as_much_as_they_can(part, seed, case):
    """Within the limits, the forces p minimize ½ pᵀ W p + pᵀ a₀, where a₀ is t·a without forces."""
    chain = stuck(seed, case, part)
    d = chain.d
    solve(d)
    find_limited_forces(d)
    expected, at_limit = bounded(chain)
    np.testing.assert_allclose(forces(d), expected, atol=1e-8 * np.abs(expected).max())
    assert d.limited_forces.at_limit[: len(expected)].tolist() == at_limit.tolist()
    assert at_limit.any()


@pytest.mark.parametrize("total", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("seed", range(4))
def test_two_elements_at_one_place_share_a_load(seed, total):
    """Equal forces would exceed the small limit; both elements together hold up to the sum of the limits."""
    chain = Doubled(seed)
    d = chain.d
    d.friction_element.mode[chain.elements] = STICKS
    list_sticking(d)
    solve(d)
    first, second = (chain.elements.index(e) for e in chain.twins)
    needed = abs(sum(d.friction_element.force[list(chain.twins)]))
    limits = np.full(len(chain.elements), 1e9)
    limits[second], limits[first] = LEAST_STICKING_IMPEDANCE / 10.0 * needed, needed / total
    set_limits(chain, limits)
    solve(d)
    find_limited_forces(d)
    computed_forces, left = forces(d), chain.bias + chain.mobility @ forces(d)
    assert (np.abs(computed_forces) <= limits * (1.0 + 1e-12)).all()
    assert computed_forces[first] * computed_forces[second] > 0.0
    if total < 1.0:
        np.testing.assert_allclose(left, 0.0, atol=1e-9 * np.abs(chain.bias).max())
        assert (d.limited_forces.at_limit[: len(limits)] != 0).sum() <= 1
    elif total > 1.0:
        assert np.abs(computed_forces[[first, second]]) == pytest.approx(limits[[first, second]], rel=1e-12)
        assert (left[[first, second]] * computed_forces[first] < 0.0).all()


@pytest.mark.parametrize("seed", range(4))
def test_forces_are_found_where_constraints_nearly_depend_on_each_other(seed):
    """Only many iterations tell which of two elements with nearly the same tangent reaches its limit."""
    chain = Doubled(seed, apart=1e-5)
    d = chain.d
    d.friction_element.mode[chain.elements] = STICKS
    list_sticking(d)
    solve(d)
    limits = np.random.default_rng(seed).uniform(0.2, 1.5, len(chain.elements))
    limits[chain.elements.index(chain.twins[1])] *= 3.0
    set_limits(chain, limits * np.abs(d.friction_element.force[chain.elements]))
    solve(d)
    find_limited_forces(d)
    expected, at_limit = bounded(chain)
    np.testing.assert_allclose(forces(d), expected, atol=1e-8 * np.abs(expected).max())
    assert d.limited_forces.at_limit[: len(expected)].tolist() == at_limit.tolist()

"""Derivatives through implicit steps that are long beside a disturbance: of a chain that stays at rest."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.integration.radau import STAGES, Q
from chain_impact.kernel.tangent import implicit_step
from chain_impact.kernel.tangent.trust import GRAZING, NOT_SOLVED, TRUSTED
from tests.derivative_scenes import Case, table
from tests.kernel.tangent.dual import followed, started

H = 1.0  # s, of a step at rest
GRAVITY = 9.81
PARAMETERS = ("initial.angle[1]", "initial.angular_velocity[1]")
IDLE = ("contact.stiffness", "contact.restitution", "contact.exponent", "contact.radius")
STATE = ("link[1].angle", "link[1].angular_velocity")


def hanging(length, tolerance, damping=0.0):
    """A link that hangs still far above a floor, and what it is differentiated by."""
    scene = table(
        [{"length": length, "mass": 1.0, "joint_damping": damping}],
        base="pinned",
        box={"y_min": -100.0},
        initial={"angles": [-0.5 * math.pi]},
        simulation={"stop_time": 3.0 * H, "step_size": H},
        solver={"method": "implicit", "tolerance": tolerance},
    )
    return Case(scene, PARAMETERS, (H, 2.0 * H, 3.0 * H))


def slopes_of(case):
    """Those of the state at the case's times, shape (T, 2, P), and the instance at the last of them."""
    instance = started(case)
    columns = [list(instance.model.columns).index(name) for name in STATE]
    _, slopes = followed(instance, case.times)
    return slopes[:, columns], instance


def collocated(length, damping):
    """What a step of length H makes of a small disturbance: its linear equations, solved for all stages.

    U = 1 ⊗ y + h (Q ⊗ A) U with φ̈ = −(m g l/2 φ + d φ̇)/(m l²/3).
    """
    inertia = length * length / 3.0
    rate = np.array([[0.0, 1.0], [-0.5 * GRAVITY * length / inertia, -damping / inertia]])
    system = np.eye(2 * STAGES) - H * np.kron(np.array(Q), rate)
    return np.linalg.solve(system, np.kron(np.ones((STAGES, 1)), np.eye(2)))[-2:]


@pytest.mark.parametrize("damping", [0.0, 1e4])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("length", [50.0, 2.0, 0.8])
def test_derivatives_solve_the_equations_of_a_step_whatever_the_values_need(length, tolerance, damping):
    """The values are solved by the first guess, and the derivatives only by a slow iteration."""
    slopes, instance = slopes_of(hanging(length, tolerance, damping))
    assert instance.statistics["steps"] == instance.statistics["implicit_steps"] == len(slopes)
    step = collocated(length, damping)
    for k, found in enumerate(slopes):
        right = np.linalg.matrix_power(step, k + 1)
        assert np.abs(found - right).max() <= (k + 1) * (tolerance + 1e-12) * np.abs(right).max()
    assert instance.limits == ()


@pytest.mark.parametrize("more", [(), IDLE])
def test_derivatives_that_an_iteration_does_not_reach_are_not_there(more):
    """0.05 m swings three times a second: beyond the start there are none, and a sentence says why.

    Nor are there any of what has no influence, in whichever instance of dual numbers.
    """
    slopes, instance = slopes_of(replace(hanging(0.05, 1e-8), parameters=(*more, *PARAMETERS)))
    assert instance.record["tangents"] == 1 + (len(more) > 0)
    assert np.isnan(slopes).all()
    (limit,) = instance.limits
    assert limit.startswith("there are no derivatives from t = 0 s on: ")
    assert "iteration" in limit


@pytest.mark.parametrize("reason", [TRUSTED, GRAZING, NOT_SOLVED])
def test_derivatives_that_have_ended_are_not_iterated(reason, monkeypatch):
    """The step is made for its values all the same."""
    called = []
    before = ["extend_start", "extrapolate_stages", "take_stages", "take_slopes", "factorize_real"]
    for name in (*before, "set_result"):
        monkeypatch.setattr(implicit_step, name, lambda *_, name=name: called.append(name))
    monkeypatch.setattr(implicit_step, "extended_size", lambda _t: 1)
    monkeypatch.setattr(implicit_step, "compliant", lambda _t: 0)
    monkeypatch.setattr(implicit_step, "iterate_slopes", lambda *_: called.append("iterate_slopes"))
    monkeypatch.setattr(implicit_step, "mark_untrusted", lambda *_: called.append("mark_untrusted"))
    d = SimpleNamespace(step=SimpleNamespace(start=0.0))
    implicit_step.make_implicit(d, SimpleNamespace(trust=SimpleNamespace(reason=reason)), H)
    iterated = ["iterate_slopes", "mark_untrusted"] if reason == TRUSTED else []
    assert called == [*before, *iterated, "set_result"]

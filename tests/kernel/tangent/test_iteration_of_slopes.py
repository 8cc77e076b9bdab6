"""The iteration of an implicit step's derivatives: when it has converged, and when it is given up."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from chain_impact.kernel.integration.radau import STAGES
from chain_impact.kernel.tangent import implicit_step
from chain_impact.kernel.tangent.directions import DIRECTIONS
from chain_impact.kernel.tangent.implicit_step import (
    ENOUGH,
    FALLS,
    FAR_OFF,
    MOST,
    ROUND_OFF,
    STALLED,
    iterate_slopes,
    last_correction,
    make_implicit,
    take_slopes,
    take_stages,
)
from chain_impact.kernel.tangent.trust import GRAZING, NO_IMPACT, NOT_SOLVED, TRUSTED
from tests.kernel.tangent.dual import Dual

TOLERANCE = 1e-4


def iterated(monkeypatch, corrections):
    """Whether an iteration with these corrections converges, and after how many of them."""
    left, done = list(corrections), []
    for name in ("find_residuals", "solve_slopes"):
        monkeypatch.setattr(implicit_step, name, lambda *_: None)
    monkeypatch.setattr(implicit_step, "correct_stages", lambda *_: done.append("iterate"))
    monkeypatch.setattr(implicit_step, "take_stages", lambda *_: done.append("values"))
    monkeypatch.setattr(implicit_step, "last_correction", lambda *_: left.pop(0))
    d = SimpleNamespace(solver=SimpleNamespace(tolerance=TOLERANCE))
    converged = iterate_slopes(d, None, 0.1, 3)
    assert done == ["iterate", "values"] * (len(done) // 2)
    return converged, len(done) // 2


def test_it_has_converged_when_a_correction_is_a_small_part_of_the_tolerance(monkeypatch):
    enough = ENOUGH * TOLERANCE
    assert iterated(monkeypatch, [1.0, 1e-2, 1.01 * enough, 0.99 * enough, 0.0]) == (True, 4)


def test_it_is_given_up_when_the_corrections_fall_no_more(monkeypatch):
    above = 1.1 * max(ROUND_OFF, ENOUGH * TOLERANCE)
    assert iterated(monkeypatch, [above] * MOST) == (False, 1 + STALLED)
    # a fall that is not enough counts from the least before it
    slow = [1.0, *[1.01 * FALLS] * STALLED, *[0.0] * MOST]
    assert iterated(monkeypatch, slow) == (False, 1 + STALLED)
    assert iterated(monkeypatch, [1.0, *[1.01 * FALLS] * (STALLED - 1), 0.0]) == (True, 1 + STALLED)


def test_one_that_falls_within_some_iterations_goes_on(monkeypatch):
    waves = [0.9 * FALLS] + [1.0] * (STALLED - 1) + [0.8 * FALLS**2] + [1.0] * (STALLED - 1) + [0.0]
    assert iterated(monkeypatch, waves) == (True, len(waves))


def test_round_off_is_no_failure(monkeypatch):
    monkeypatch.setattr(implicit_step, "ENOUGH", 0.0)
    assert iterated(monkeypatch, [0.9 * ROUND_OFF] * MOST) == (True, 1 + STALLED)
    assert iterated(monkeypatch, [1.1 * ROUND_OFF] * MOST) == (False, 1 + STALLED)


def test_it_ends_after_many_iterations(monkeypatch):
    assert (
        iterated(monkeypatch, [1e9 * 0.69**k + 1e-3 for k in range(40)] + [0.5**k for k in range(MOST)])[1]
        <= MOST
    )
    assert iterated(monkeypatch, [1e300 * 0.5**k for k in range(MOST)]) == (False, MOST)


def dual(*slopes):
    return Dual(7.0, (*slopes, *[0.0] * (DIRECTIONS - len(slopes))))


def slopes(start, end, parts):
    """A step with two components, with these slopes of its start, its last stage and its corrections."""
    none = np.array([[dual(), dual()] for _ in range(STAGES)], object)
    own = SimpleNamespace(start=[dual(*one) for one in start], stages=none.copy(), parts=none)
    own.stages[STAGES - 1] = [dual(*one) for one in end]
    for (i, j), one in parts.items():
        own.parts[i, j] = dual(*one)
    d = SimpleNamespace(friction=SimpleNamespace(stuck_count=0), step=SimpleNamespace(size=0.1))
    d.implicit, d.model = SimpleNamespace(weight=[2.0, 10.0]), None
    return d, SimpleNamespace(implicit=own)


def test_a_correction_is_relative_to_the_derivatives_at_the_end_in_its_worst_direction():
    """Weighted: 2·(3 + 1) and 10·(1 − 0.5) in one direction, 2 and 20 in another."""
    d, t = slopes(
        [(3.0, 1.0), (1.0, 2.0)], [(1.0, 0.0), (-0.5, 0.0)], {(0, 0): (-0.04,), (2, 1): (0.004, 0.06)}
    )
    assert last_correction(d, t, 2) == pytest.approx(max(0.08 / 8.0, 0.6 / 20.0))
    t.implicit.parts[4, 0] = dual(1.0)
    assert last_correction(d, t, 2) == pytest.approx(2.0 / 8.0)
    assert last_correction(d, t, 0) == 0.0


def test_zero_derivatives_need_no_correction_and_allow_none():
    d, t = slopes([(0.0,)] * 2, [(0.0,)] * 2, {})
    assert last_correction(d, t, 2) == 0.0
    t.implicit.parts[1, 1] = dual(1e-9)
    assert last_correction(d, t, 2) == FAR_OFF


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_far_off(bad):
    d, t = slopes([(1.0,)] * 2, [(0.0,)] * 2, {(3, 0): (0.0, bad)})
    assert last_correction(d, t, 2) == FAR_OFF


def test_nor_is_there_a_correction_beside_derivatives_without_bound():
    d, t = slopes([(1.0,), (math.inf,)], [(0.0,)] * 2, {})
    assert last_correction(d, t, 2) == FAR_OFF


def test_stages_have_the_values_of_the_run_and_their_own_slopes():
    d, t = slopes([(0.0,)] * 2, [(1.0, 2.0), (3.0, 4.0)], {})
    d.implicit.last = np.arange(2.0 * STAGES).reshape(STAGES, 2)
    take_stages(d, t, 2)
    assert [[one.value for one in row] for row in t.implicit.stages] == d.implicit.last.tolist()
    assert [one.slope[:2].tolist() for one in t.implicit.stages[-1]] == [[1.0, 2.0], [3.0, 4.0]]


def test_the_linear_system_is_that_of_the_run():
    def data(scale):
        link = SimpleNamespace(x=[scale, 2 * scale], y=[3 * scale, 4 * scale])
        own = SimpleNamespace(link=link, stiffness=[5 * scale, 6 * scale], damping=[7 * scale, 8 * scale])
        return SimpleNamespace(links=2, touch=SimpleNamespace(active_count=1), implicit=own)

    d, t = data(1), data(100)
    take_slopes(d, t)
    assert (t.implicit.link.x, t.implicit.link.y) == ([1, 2], [3, 4])
    assert (t.implicit.stiffness, t.implicit.damping) == ([5, 600], [7, 800])


@pytest.mark.parametrize("reason", [TRUSTED, GRAZING])
@pytest.mark.parametrize("converges", [True, False])
@pytest.mark.parametrize("contacts", [0, 1, 2])
def test_a_step_is_made_of_the_stages_of_the_run(monkeypatch, reason, converges, contacts):
    d, called = SimpleNamespace(step=SimpleNamespace(start=1.5)), []
    t = SimpleNamespace(
        trust=SimpleNamespace(reason=reason),
        trial=SimpleNamespace(state="y"),
        implicit=SimpleNamespace(z="z"),
    )
    for name in [
        "extend_start",
        "extrapolate_stages",
        "take_stages",
        "take_slopes",
        "factorize_real",
        "set_result",
        "project_clearances",
    ]:
        monkeypatch.setattr(implicit_step, name, lambda *_, name=name: called.append(name))
    monkeypatch.setattr(implicit_step, "extended_size", lambda _: 12)
    monkeypatch.setattr(implicit_step, "compliant", lambda _: contacts)
    monkeypatch.setattr(implicit_step, "iterate_slopes", lambda *_: called.append("iterate") or converges)
    monkeypatch.setattr(implicit_step, "mark_untrusted", lambda _t, *what: called.append(what))
    make_implicit(d, t, 0.1)
    right = ["extend_start", "extrapolate_stages", "take_stages", "take_slopes", "factorize_real"]
    if reason == TRUSTED:
        right += ["iterate"] if converges else ["iterate", (NOT_SOLVED, NO_IMPACT, 1.5)]
    right += ["set_result", "project_clearances"] if contacts else ["set_result"]
    assert called == right

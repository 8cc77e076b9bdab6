"""A tried step: what accepts it, cuts it at its event, repeats it or refuses it."""

import math

import numpy as np
import pytest

from chain_impact.kernel import advance as loop
from chain_impact.kernel.integration.control import FAR_OFF, conclude, refuse
from chain_impact.kernel.integration.method import EXPLICIT, IMPLICIT
from chain_impact.kernel.model import constraints
from chain_impact.kernel.model.constraints import MOVING, SOLVED
from tests.kernel.chains import chain

SIZE = 0.01  # s
KEPT = 2.5, 3.5  # J: the energies at the end of a tried step


class Landing:
    """A step whose event, repeats and energies are told in advance; its own error is the first one."""

    def __init__(
        self, monkeypatch, *, bends, method=EXPLICIT, errors=(0.2, 0.5), onset=-1.0, keeps=True, loss=0.0
    ):
        _, self.d = chain(np.random.default_rng(1), 2)
        self.d.step.size, self.d.step.method, self.d.step.last_method = SIZE, method, method
        self.patch, self.noted, errors, costs = monkeypatch, [], list(errors), [1.0, 0.7]
        monkeypatch.setattr(loop, "bends_force", lambda _: bends)
        monkeypatch.setattr(loop, "roll_back", lambda _: self.noted.append("roll back"))
        monkeypatch.setattr(loop, "drop_events", lambda _: self.noted.append("drop events"))
        monkeypatch.setattr(loop, "truncate_step", lambda _, theta: self.noted.append(("cut", theta)))
        monkeypatch.setattr(loop, "onset_fraction", lambda d: self.located(d, onset))

        def attempt(d, h):
            self.noted.append(("try", h / SIZE))
            conclude(d, errors.pop(0), costs.pop(0))

        def check_energy(d, theta):
            self.noted.append(("energy", theta))
            refuse(d, loss)
            if not keeps:
                refuse(d, FAR_OFF)
            return KEPT

        monkeypatch.setattr(loop, "attempt", attempt)
        monkeypatch.setattr(loop, "accept", lambda _: self.noted.append("accept"))
        monkeypatch.setattr(loop, "check_energy", check_energy)

    def located(self, d, theta):
        if theta is None:
            refuse(d, FAR_OFF)
            return -1.0
        return theta

    def run(self, theta):
        """The outcome, and what was done after the whole step was accepted."""
        self.patch.setattr(loop, "find_event", lambda d: self.located(d, theta))
        loop.try_step(self.d, SIZE)
        assert self.noted[:2] == [("try", 1.0), "accept"]
        return self.d.trial.error, self.noted[2:]


BACK = ["roll back", "drop events"]


def test_a_step_without_an_event_is_only_checked(monkeypatch):
    assert Landing(monkeypatch, bends=True, loss=0.3).run(-1.0) == (0.3, [("energy", -1.0)])
    assert Landing(monkeypatch, bends=True, loss=0.1).run(-1.0) == (0.2, [("energy", -1.0)])


def test_a_step_is_cut_at_an_event_at_which_the_force_does_not_bend(monkeypatch):
    cut = [("energy", 0.4), ("cut", 0.4)]
    assert Landing(monkeypatch, bends=False).run(0.4) == (0.2, cut)
    cut = [("energy", 0.0), ("cut", 0.0)]
    assert Landing(monkeypatch, bends=True).run(0.0) == (0.2, cut)


@pytest.mark.parametrize(("bends", "method"), [(True, EXPLICIT), (False, IMPLICIT)])
def test_it_is_repeated_up_to_one_at_which_the_force_bends_or_if_it_is_implicit(monkeypatch, bends, method):
    """The next size follows from the error of the whole step, and from the cost of the repeated one."""
    landing = Landing(monkeypatch, bends=bends, method=method)
    repeated = ["roll back", ("try", 0.4), "accept", ("energy", -1.0)]
    assert landing.run(0.4) == (0.2, repeated)
    assert landing.d.trial.cost_factor == 0.7


@pytest.mark.parametrize("theta", [1e-3, 1.0])
def test_at_its_ends_the_interpolant_of_an_implicit_step_is_right(monkeypatch, theta):
    landing = Landing(monkeypatch, bends=False, method=IMPLICIT)
    assert landing.run(theta) == (0.2, [("energy", theta), ("cut", theta)])


def test_a_repeated_step_may_have_an_onset_before_its_end(monkeypatch):
    landing = Landing(monkeypatch, bends=True, onset=0.9)
    repeated = ["roll back", ("try", 0.4), "accept", ("energy", 0.9), ("cut", 0.9)]
    assert landing.run(0.4) == (0.2, repeated)


def test_a_step_that_is_not_accurate_is_not_searched(monkeypatch):
    landing = Landing(monkeypatch, bends=True, errors=[1.5])
    loop.try_step(landing.d, SIZE)
    assert landing.d.trial.error == 1.5
    assert landing.noted == [("try", 1.0)]


def test_what_cannot_be_located_or_repeated_is_refused(monkeypatch):
    """A refused step is rolled back, also if its repeat has been."""
    assert Landing(monkeypatch, bends=True).run(None) == (FAR_OFF, BACK)
    for error in (1.5, math.nan):
        done = ["roll back", ("try", 0.4), *BACK]
        assert Landing(monkeypatch, bends=True, errors=[0.2, error]).run(0.4) == (FAR_OFF, done)
    landing = Landing(monkeypatch, bends=True, onset=None)
    assert landing.run(0.4) == (FAR_OFF, ["roll back", ("try", 0.4), "accept", *BACK])


UNFOUND = [(SOLVED, False), (MOVING, True), (constraints.UNSOLVED, True)]


@pytest.mark.parametrize(("unsolved", "refused"), UNFOUND)
def test_a_step_without_the_forces_of_constraints_is_refused(monkeypatch, unsolved, refused):
    landing = Landing(monkeypatch, bends=False)
    check_energy = loop.check_energy

    def fails(d, theta):
        energies = check_energy(d, theta)
        d.rigid.unsolved = unsolved
        return energies

    monkeypatch.setattr(loop, "check_energy", fails)
    before = landing.d.balance.at_end, landing.d.balance.available
    error, noted = landing.run(-1.0)
    assert error == (FAR_OFF if refused else 0.2)
    assert ("roll back" in noted) == refused
    assert (landing.d.balance.at_end, landing.d.balance.available) == (before if refused else KEPT)


def test_a_refused_step_is_not_repeated_for_an_event_that_was_found_before(monkeypatch):
    landing = Landing(monkeypatch, bends=True)
    landing.located = lambda d, theta: (refuse(d, FAR_OFF), theta)[1]
    assert landing.run(0.4) == (FAR_OFF, BACK)


@pytest.mark.parametrize(
    ("keeps", "loss", "error"), [(False, 0.0, FAR_OFF), (False, 1.0, FAR_OFF), (True, 1.05, 1.05)]
)
def test_a_step_that_does_not_keep_the_energy_is_refused(monkeypatch, keeps, loss, error):
    landing = Landing(monkeypatch, bends=False, keeps=keeps, loss=loss)
    assert landing.run(0.4) == (error, [("energy", 0.4), *BACK])

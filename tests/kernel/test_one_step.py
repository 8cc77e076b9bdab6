"""One step of the solver: its size, and where it ends."""

# Tests: kernel/advance.py

import math

import numpy as np
import pytest

from chain_impact.kernel import advance as loop
from chain_impact.kernel.constraints import impulses
from chain_impact.kernel.constraints.impulses import MOVING, SOLVED
from chain_impact.kernel.ode.step_control import SAFETY_FACTOR, is_accepted, reject_step, set_outcome
from chain_impact.kernel.record.constants import CHECK_FAILED, EXPLICIT, IMPLICIT, INACCURATE
from chain_impact.kernel.status import NOT_FINITE, OK, STEP_TOO_SMALL, TOO_MUCH_WORK
from tests.kernel.chains import chain

SIZE = 0.01  # s, proposed for the next step
ORDER = 8


class Trials:
    """A solver with prescribed errors, whose steps lose no energy."""

    def __init__(self, monkeypatch, errors, limit=math.inf):
        _, self.d = chain(np.random.default_rng(1), 2)
        self.d.step.next_size, self.d.step.method = SIZE, EXPLICIT
        self.d.step.end = 1.0
        self.sizes, self.errors, self.noted = [], list(errors), []
        monkeypatch.setattr(loop, "integrate_trial", self.attempt)
        monkeypatch.setattr(loop, "prepare_step", lambda _, h: h)
        monkeypatch.setattr(loop, "limit_to_input_piece", lambda _, h: min(h, limit))
        monkeypatch.setattr(loop, "make_last_step", self.note("accept"))
        monkeypatch.setattr(loop, "roll_back", self.note("roll back"))
        monkeypatch.setattr(loop, "drop_events", self.note("drop events"))
        monkeypatch.setattr(loop, "find_event", lambda _: -1.0)
        monkeypatch.setattr(loop, "check_energy", lambda *_: (0.0, 0.0))

    def note(self, call):
        return lambda *_: self.noted.append(call)

    def attempt(self, d, h):
        self.sizes.append(h)
        set_outcome(d, self.errors.pop(0), 1.0)

    def run(self):
        status = loop.shrink_until_accepted(self.d)
        return status, self.d.step.next_size / SIZE


def suggested(error):
    return SAFETY_FACTOR[EXPLICIT] * error ** (-1.0 / ORDER)


INF, NAN = math.inf, math.nan


@pytest.mark.parametrize(
    ("errors", "longest", "sizes", "next_size"),  # sizes over the proposed size
    [
        *(([error], INF, [1.0], suggested(error)) for error in (1e-4, 0.1, 1.0)),
        *(([error], INF, [1.0], 6.0) for error in (0.0, 1e-16)),
        # after a refused step the next step does not grow
        ([20.0, 1e-9], INF, [1.0, suggested(20.0)], suggested(20.0)),
        ([1.05, 0.5], INF, [1.0, suggested(1.05)], suggested(1.05) * suggested(0.5)),
        # without a finite error the step is reduced to a tenth
        *(([bad, bad, 0.5], INF, [1.0, 0.1, 0.01], 0.01 * suggested(0.5)) for bad in (NAN, INF)),
        # a step cut by the end of an input keeps the size for the next step
        ([0.5], 0.1, [0.1], 1.0),
        # unless the step was still too long, or could have been longer than proposed
        ([20.0, 0.5], 0.1, [0.1, 0.1 * suggested(20.0)], 0.1 * suggested(20.0) * suggested(0.5)),
        ([1e-9], 0.5, [0.5], 3.0),
    ],
)
def test_a_size_follows_from_the_error_of_the_one_before(monkeypatch, errors, longest, sizes, next_size):
    trials = Trials(monkeypatch, errors, limit=longest * SIZE)
    assert trials.run() == (OK, pytest.approx(next_size, rel=1e-13))
    assert trials.sizes == pytest.approx([SIZE * size for size in sizes], rel=1e-13)
    assert trials.d.statistics.rejected_steps == len(sizes) - 1
    assert trials.noted == ["accept"]


def test_a_lengthened_step_ends_with_the_piece_of_the_inputs(monkeypatch):
    for limit, size in ((math.inf, 1.2 * SIZE), (0.6 * SIZE, 0.6 * SIZE)):
        trials = Trials(monkeypatch, [0.5], limit=limit)
        monkeypatch.setattr(loop, "prepare_step", lambda _, h: 1.2 * h)
        trials.run()
        assert trials.sizes == [size]


@pytest.mark.parametrize(("bad", "status"), [(math.nan, NOT_FINITE), (2e6, STEP_TOO_SMALL)])
def test_the_last_try_says_why_no_size_will_do(monkeypatch, bad, status):
    assert Trials(monkeypatch, [2.0, math.inf, *[bad] * 40]).run()[0] == status


def test_no_step_is_longer_than_a_second(monkeypatch):
    trials = Trials(monkeypatch, [0.5])
    trials.d.step.next_size = 7.0
    trials.run()
    assert trials.sizes == [1.0]


def test_a_step_ends_where_its_size_is_lost_in_the_time(monkeypatch):
    trials = Trials(monkeypatch, [2e6] * 40)
    trials.d.step.end = 1.0
    assert trials.run()[0] == STEP_TOO_SMALL
    assert trials.sizes[-1] > 1e-16
    trials = Trials(monkeypatch, [2e6] * 40)
    trials.d.step.end = 0.0
    assert trials.run()[0] == STEP_TOO_SMALL
    assert 1e-18 <= trials.sizes[-1] < 1e-17


def test_a_refused_step_may_be_the_last_that_the_cost_allows(monkeypatch):
    trials = Trials(monkeypatch, [20.0, 0.5])
    monkeypatch.setattr(loop, "is_cost_exceeded", lambda _: True)
    assert trials.run()[0] == TOO_MUCH_WORK
    assert len(trials.sizes) == 1


KEPT = 2.5, 3.5  # J: the energies at the end of a trial step


class Landing:
    """A step with prescribed event, repeats and energies; the step's own error is the first of the errors."""

    def __init__(
        self, monkeypatch, *, bends, method=EXPLICIT, errors=(0.2, 0.5), onset=-1.0, keeps=True, loss=0.0
    ):
        _, self.d = chain(np.random.default_rng(1), 2)
        self.d.step.size, self.d.step.method, self.d.step.last_method = SIZE, method, method
        self.patch, self.noted, errors, costs = monkeypatch, [], list(errors), [1.0, 0.7]
        monkeypatch.setattr(loop, "force_has_kink", lambda _: bends)
        monkeypatch.setattr(loop, "roll_back", lambda _: self.noted.append("roll back"))
        monkeypatch.setattr(loop, "drop_events", lambda _: self.noted.append("drop events"))
        monkeypatch.setattr(loop, "truncate_step", lambda _, theta: self.noted.append(("cut", theta)))
        monkeypatch.setattr(loop, "onset_fraction", lambda d: self.located(d, onset))

        def attempt(d, h):
            self.noted.append(("try", h / SIZE))
            set_outcome(d, errors.pop(0), costs.pop(0))

        def check_energy(d, theta):
            self.noted.append(("energy", theta))
            set_outcome(d, max(d.trial.error, loss), d.trial.cost_factor)
            if not keeps:
                reject_step(d, CHECK_FAILED)
            return KEPT

        monkeypatch.setattr(loop, "integrate_trial", attempt)
        monkeypatch.setattr(loop, "make_last_step", lambda _: self.noted.append("accept"))
        monkeypatch.setattr(loop, "check_energy", check_energy)

    def located(self, d, theta):
        if theta is None:
            reject_step(d, CHECK_FAILED)
            return -1.0
        return theta

    def run(self, theta):
        """Return the error or the reason of the refusal, and the calls after the first acceptance."""
        self.patch.setattr(loop, "find_event", lambda d: self.located(d, theta))
        loop.try_to_event(self.d, SIZE)
        assert self.noted[:2] == [("try", 1.0), "accept"]
        trial = self.d.trial
        return trial.error if is_accepted(self.d) else trial.outcome, self.noted[2:]


BACK = ["roll back", "drop events"]
REPEATED = ["roll back", ("try", 0.4), "accept"]


def check_of_cut(theta):
    """Return the check of a step that ends at a fraction, at which it is cut."""
    return [("energy", theta), ("cut", theta)]


@pytest.mark.parametrize(
    ("course", "theta", "error", "calls"),
    [
        # a step without an event is only checked
        ({"bends": True, "loss": 0.3}, -1.0, 0.3, [("energy", -1.0)]),
        ({"bends": True, "loss": 0.1}, -1.0, 0.2, [("energy", -1.0)]),
        # the step is cut at a smooth force
        ({"bends": False}, 0.4, 0.2, check_of_cut(0.4)),
        ({"bends": True}, 0.0, 0.2, check_of_cut(0.0)),
        # the step is repeated up to a kink, and an implicit step up to an onset before its end
        ({"bends": True}, 0.4, 0.2, [*REPEATED, ("energy", -1.0)]),
        ({"bends": False, "method": IMPLICIT}, 0.4, 0.2, [*REPEATED, ("energy", -1.0)]),
        ({"bends": True, "onset": 0.9}, 0.4, 0.2, [*REPEATED, *check_of_cut(0.9)]),
        # the interpolant of an implicit step is accurate at the ends
        *(({"bends": False, "method": IMPLICIT}, theta, 0.2, check_of_cut(theta)) for theta in (0.0, 1.0)),
        # a step whose event cannot be located or repeated is refused and undone, also after a repeat
        ({"bends": True}, None, CHECK_FAILED, BACK),
        ({"bends": True, "onset": None}, 0.4, CHECK_FAILED, [*REPEATED, *BACK]),
        *(
            ({"bends": True, "errors": [0.2, bad]}, 0.4, CHECK_FAILED, [*REPEATED[:2], *BACK])
            for bad in (1.5, NAN)
        ),
        # a step that changes the total energy is refused and undone
        *(
            ({"bends": False, "keeps": False, "loss": loss}, 0.4, CHECK_FAILED, [check_of_cut(0.4)[0], *BACK])
            for loss in (0.0, 1.0)
        ),
        ({"bends": False, "loss": 1.05}, 0.4, INACCURATE, [check_of_cut(0.4)[0], *BACK]),
    ],
)
def test_a_step_ends_at_its_event(monkeypatch, course, theta, error, calls):
    """The next size follows from the error of the whole step, and from the cost of the repeated step."""
    landing = Landing(monkeypatch, **course)
    assert landing.run(theta) == (error, calls)
    assert error > 1.0 or landing.d.trial.cost_factor == (0.7 if REPEATED[1] in calls else 1.0)


def test_a_step_that_is_not_accurate_is_not_searched(monkeypatch):
    landing = Landing(monkeypatch, bends=True, errors=[1.5])
    loop.try_to_event(landing.d, SIZE)
    assert landing.d.trial.error == 1.5
    assert landing.noted == [("try", 1.0)]


UNFOUND = [(SOLVED, False), (MOVING, True), (impulses.OUTCOME_FORCES_NOT_FOUND, True)]


@pytest.mark.parametrize(("unsolved", "refused"), UNFOUND)
def test_a_step_without_the_forces_of_constraints_is_refused(monkeypatch, unsolved, refused):
    landing = Landing(monkeypatch, bends=False)
    check_energy = loop.check_energy

    def fails(d, theta):
        energies = check_energy(d, theta)
        d.constraints.outcome = unsolved
        return energies

    monkeypatch.setattr(loop, "check_energy", fails)
    before = landing.d.balance.value_end, landing.d.balance.available_energy
    error, noted = landing.run(-1.0)
    assert error == (CHECK_FAILED if refused else 0.2)
    assert ("roll back" in noted) == refused
    assert (landing.d.balance.value_end, landing.d.balance.available_energy) == (before if refused else KEPT)


def test_a_refused_step_is_not_repeated_for_an_event_that_was_found_before(monkeypatch):
    landing = Landing(monkeypatch, bends=True)
    landing.located = lambda d, theta: (reject_step(d, CHECK_FAILED), theta)[1]
    assert landing.run(0.4) == (CHECK_FAILED, BACK)

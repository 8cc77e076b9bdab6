"""Bounds on work and events for simulated time, so that no scene can keep the solver busy for ever.

All work is counted in one currency: an evaluation of the right-hand side. A look at the points in the search
for events costs about as much, and so does a response of the chain to impulses.
"""

from chain_impact.kernel.status import EVENT_STORM, OK, STEP_TOO_LONG, TOO_MUCH_WORK

UNLIMITED = 1 << 62  # evaluations
WORK_WINDOW = 1.0  # s of simulated time, which `solver.work_limit` speaks of
# s. What a second may take at the most, so often may a communication step, however long it is.
LONGEST_CALL = 20.0
# Evaluations times links, after which a long call returns to ask whether to go on: 20 to 30 ns each, so that
# Ctrl-C is obeyed within a second.
CALL_WORK = 20_000_000
# A candidate that begins and ends a contact MOST_EVENTS times in EVENT_WINDOW [s] does so for ever: a bounce
# of a microsecond rises by 1e-12 m.
EVENT_WINDOW, MOST_EVENTS = 1e-3, 1000


def work_done(d):
    """All work since the start, in evaluations."""
    return d.statistics.rhs_evaluations + d.limits.other_work


def work_exceeded(d):
    """Whether the work in a second of simulated time exceeds the limit; every long loop asks."""
    return work_done(d) - d.limits.work_count > d.solver.work_limit * WORK_WINDOW


def work_of_a_call(d):
    """How much work a caller waits for that wants to be asked in between whether to go on: below a second."""
    return CALL_WORK // (d.links + 1)


def allow_any_length(d):
    """Let the time to the next communication point take any work: who asks in between may stop it."""
    d.limits.call_count = UNLIMITED


def check_work(d):
    """TOO_MUCH_WORK or STEP_TOO_LONG when a second or a communication step takes too much work, or OK."""
    limits = d.limits
    if work_exceeded(d):
        return TOO_MUCH_WORK
    if work_done(d) - limits.call_count > d.solver.work_limit * LONGEST_CALL:
        return STEP_TOO_LONG
    if d.step.end >= limits.work_start + WORK_WINDOW:
        limits.work_start = d.step.end
        limits.work_count = work_done(d)
    return OK


def check_events(d, events):
    """EVENT_STORM when ``events`` more are too many for a short window of time, or OK."""
    limits = d.limits
    if d.step.end >= limits.event_start + EVENT_WINDOW:
        limits.event_start = d.step.end
        limits.event_count = 0
    limits.event_count += events
    return OK if limits.event_count <= MOST_EVENTS * d.candidates else EVENT_STORM

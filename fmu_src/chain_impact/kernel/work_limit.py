"""Bounds on work and on events per simulated time, so that every run ends.

The unit of work is an evaluation of the right-hand side. To locate the points in the search for events costs
about as much, and so does to solve for the response of the chain to impulses.
"""

from chain_impact.kernel.status import EVENT_STORM, OK, STEP_TOO_LONG, TOO_MUCH_WORK

UNLIMITED = 1 << 62  # evaluations
WORK_WINDOW = 1.0  # s of simulated time, for which `solver.work_limit` bounds the work
# s. A communication step of any length may take at most the work allowed for this simulated time.
LONGEST_CALL = 20.0
# Evaluations times links, after which a long call returns so that its caller can stop it: 20 to 30 ns each,
# so that Ctrl-C takes effect within a second.
CALL_WORK = 20_000_000
# A candidate that begins and ends a contact MOST_EVENTS times in EVENT_WINDOW [s] is taken for a chattering
# that never ends: in a bounce of a microsecond the point rises by only 1e-12 m.
EVENT_WINDOW, MOST_EVENTS = 1e-3, 1000


def clear_counts(d, time):
    """Start all counts at ``time`` [s], at which a run starts."""
    statistics, limits = d.statistics, d.limits
    statistics.steps, statistics.rejected_steps = 0, 0
    statistics.rhs_evaluations, statistics.implicit_steps = 0, 0
    limits.event_count, limits.work_count, limits.call_count, limits.other_work = 0, 0, 0, 0
    limits.event_start, limits.work_start = time, time


def count_step(d, implicit):
    """Count an accepted step, and whether it is ``implicit``: 0 or 1."""
    d.statistics.steps += 1
    d.statistics.implicit_steps += implicit


def count_rejected_step(d):
    """Count a rejected try of a step."""
    d.statistics.rejected_steps += 1


def work_done(d):
    """All work since the start, in evaluations of the right-hand side."""
    return d.statistics.rhs_evaluations + d.limits.other_work


def count_evaluations(d, number):
    """Count evaluations of the right-hand side."""
    d.statistics.rhs_evaluations += number


def count_other_work(d, number):
    """Count work that costs about as much as so many evaluations."""
    d.limits.other_work += number


def counted_work(d):
    """The evaluations and the other work so far, for ``uncount_work``."""
    return d.statistics.rhs_evaluations, d.limits.other_work


def uncount_work(d, counted):
    """Return to the counts of ``counted_work``: what was done since then serves outputs only."""
    d.statistics.rhs_evaluations, d.limits.other_work = counted


def work_exceeded(d):
    """Whether the work in a second of simulated time exceeds the limit; every long loop checks it."""
    return work_done(d) - d.limits.work_count > d.solver.work_limit * WORK_WINDOW


def work_of_a_call(d):
    """The work, in evaluations, after which a call returns so that its caller can stop: under a second."""
    return CALL_WORK // (d.links + 1)


def begin_call(d):
    """Begin to count the work of a communication step."""
    d.limits.call_count = work_done(d)


def allow_any_length(d):
    """Lift the bound on a communication step, for callers that can stop the run between calls."""
    d.limits.call_count = UNLIMITED


def check_work(d):
    """TOO_MUCH_WORK or STEP_TOO_LONG if a second or a communication step takes too much work, else OK."""
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
    """EVENT_STORM if ``events`` more exceed the limit of the present EVENT_WINDOW, else OK."""
    limits = d.limits
    if d.step.end >= limits.event_start + EVENT_WINDOW:
        limits.event_start = d.step.end
        limits.event_count = 0
    limits.event_count += events
    elements = d.candidates + (d.links if d.friction.used else 0)
    return OK if limits.event_count <= MOST_EVENTS * elements else EVENT_STORM

"""The counts of work and of events, and their bounds, which end every run.

The unit of work is an evaluation of the right-hand side. One location of the points in the search for events
costs about as much, and so does one solution for the response of the chain to impulses.
"""

from chain_impact.kernel.status import EVENT_STORM, OK, STEP_TOO_LONG, TOO_MUCH_WORK

UNLIMITED = 1 << 62  # a number of evaluations that means: no limit
WORK_WINDOW = 1.0  # [s] the simulated time in which `solver.work_limit` limits the work
# [s] A communication step, even a short one, may take the work that is allowed for this simulated time.
LONGEST_CALL = 20.0
# The number of evaluations times links after which a long call returns, so that its caller can stop the run.
# An evaluation takes 20 to 30 ns per link, so Ctrl-C takes effect within a second.
CALL_WORK = 20_000_000
# The number of events in EVENT_WINDOW [s], on average for each candidate, and for each drive if there is
# friction or a drive with a limit. More events count as chattering without end: in a bounce of a microsecond
# the point rises only 1e-12 m.
EVENT_WINDOW, MOST_EVENTS = 1e-3, 1000


def begin_windows(d, time):
    """Begin the first time windows for the limits on events and work at ``time`` [s], the start of a run."""
    d.limits.event_start, d.limits.work_start = time, time


def count_step(d, implicit):
    """Count an accepted step; ``implicit``: 1 if the step is implicit, else 0."""
    d.statistics.steps += 1
    d.statistics.implicit_steps += implicit


def count_rejected_step(d):
    """Count a rejected try of a step."""
    d.statistics.rejected_steps += 1


def work_done(d):
    """Return all work since the start, in evaluations of the right-hand side."""
    return d.statistics.rhs_evaluations + d.limits.other_work


def count_evaluations(d, number):
    """Count evaluations of the right-hand side."""
    d.statistics.rhs_evaluations += number


def count_other_work(d, number):
    """Count other work that costs about as much as ``number`` evaluations."""
    d.limits.other_work += number


def counted_work(d):
    """Return the counts of evaluations and of other work, for a later ``uncount_work``."""
    return d.statistics.rhs_evaluations, d.limits.other_work


def uncount_work(d, counted):
    """Reset the counts to ``counted``, from ``counted_work``: the work since then serves outputs only."""
    d.statistics.rhs_evaluations, d.limits.other_work = counted


def work_exceeded(d):
    """Return whether the work exceeds the limit for a second of simulated time.

    Every long loop calls this.
    """
    return work_done(d) - d.limits.work_count > d.solver.work_limit * WORK_WINDOW


def work_of_a_call(d):
    """Return the work, in evaluations, after which a call returns so that its caller can stop the run."""
    return CALL_WORK // (d.links + 1)


def begin_call(d):
    """Begin to count the work of a communication step."""
    d.limits.call_count = work_done(d)


def allow_any_length(d):
    """Remove the limit on the work of a communication step; the caller can stop the run between calls."""
    d.limits.call_count = UNLIMITED


def check_work(d):
    """Return TOO_MUCH_WORK or STEP_TOO_LONG if the work in a second or a call is too large, else OK."""
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
    """Count ``events``; return EVENT_STORM if their sum in EVENT_WINDOW exceeds the limit, else OK."""
    limits = d.limits
    if d.step.end >= limits.event_start + EVENT_WINDOW:
        limits.event_start = d.step.end
        limits.event_count = 0
    limits.event_count += events
    elements = d.candidates + (d.links + d.slides if d.friction.used or d.model.has_drive_limits else 0)
    return OK if limits.event_count <= MOST_EVENTS * elements else EVENT_STORM

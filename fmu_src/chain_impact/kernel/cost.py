"""The cost of a run, the count of its events, and the limits on both that end a run with a fault.

The unit of cost is an evaluation of the right-hand side f(y). To locate the points in the search for events,
or to solve for the response of the chain to impulses, costs about one unit, too.
"""

from chain_impact.kernel.status import EVENT_STORM, OK, STEP_TOO_LONG, TOO_MUCH_WORK

UNLIMITED = 1 << 62  # value of a limit, of the cost or of the log, that means: no limit
COST_WINDOW = 1.0  # [s] the simulated time in which `solver.work_limit` limits the cost
# A communication step of any length may cost at most as much as `solver.work_limit` allows for
# LONGEST_COMMUNICATION_STEP [s] of simulated time, unless ``allow_any_length`` removes this limit. The limit
# in each COST_WINDOW of simulated time holds in any case.
LONGEST_COMMUNICATION_STEP = 20.0
# The cost, in evaluations times N + 1 for N links, after which a long call returns, so that its caller can
# stop the run. An evaluation takes 20 to 30 ns per link, so Ctrl-C takes effect within a second.
PAUSE_COST = 20_000_000
# A run ends with a fault after more than MOST_EVENTS × n events in EVENT_WINDOW [s] of simulated time. n is
# the number of candidates. If there is dry friction or a drive with a limit, n also counts the links and the
# slider. So many events are endless chattering: a bounce that lasts a microsecond is only 1e-12 m high.
EVENT_WINDOW, MOST_EVENTS = 1e-3, 1000


def begin_windows(d, time):
    """Begin the first windows of time that limit events and cost, at ``time`` [s], the start of a run."""
    d.budget.event_start, d.budget.cost_start = time, time


def count_step(d, implicit):
    """Count an accepted step; ``implicit``: 1 if the step is implicit, else 0."""
    d.statistics.steps += 1
    d.statistics.implicit_steps += implicit


def count_rejected_step(d):
    """Count a tried step that has been rejected."""
    d.statistics.rejected_steps += 1


def cost_so_far(d):
    """Return the cost since the start of the run, in evaluations of the right-hand side."""
    return d.statistics.rhs_evaluations + d.budget.other_cost


def count_evaluations(d, number):
    """Add ``number`` to the count of evaluations of the right-hand side."""
    d.statistics.rhs_evaluations += number


def count_other_cost(d, number):
    """Count calculations other than evaluations that cost about as much as ``number`` evaluations."""
    d.budget.other_cost += number


def read_cost_counts(d):
    """Return two counts: the evaluations of the right-hand side, and the cost of other calculations.

    ``restore_cost_counts`` can later reset both counts to these values.
    """
    return d.statistics.rhs_evaluations, d.budget.other_cost


def restore_cost_counts(d, counts):
    """Reset the counts of evaluations and of other cost to ``counts``, a result of ``read_cost_counts``.

    The cost since the call of ``read_cost_counts`` is the cost of outputs, which does not count.
    """
    d.statistics.rhs_evaluations, d.budget.other_cost = counts


def is_cost_exceeded(d):
    """Return whether the present window (COST_WINDOW) costs more than `solver.work_limit` allows.

    Searches and iterations that may take long call this function, to end early.
    """
    return cost_so_far(d) - d.budget.cost_at_window > d.solver.work_limit * COST_WINDOW


def cost_before_pause(d):
    """Return the cost [evaluations] after which calls such as ``advance_awhile`` return before their end.

    The caller of the kernel can then stop the run, or call the kernel again.
    """
    return PAUSE_COST // (d.link_count + 1)


def begin_communication_step(d):
    """Begin to count the cost of the next communication step."""
    d.budget.cost_at_communication_step = cost_so_far(d)


def allow_any_length(d):
    """Remove the limit on the cost of a communication step, for a caller that can stop the run."""
    d.budget.cost_at_communication_step = UNLIMITED


def check_and_renew_cost_window(d):
    """Return TOO_MUCH_WORK, STEP_TOO_LONG or OK, and begin a new window of cost when one has passed.

    TOO_MUCH_WORK: the present window costs more than `solver.work_limit` allows. STEP_TOO_LONG: the present
    communication step costs more than `solver.work_limit` allows for LONGEST_COMMUNICATION_STEP.
    """
    budget = d.budget
    if is_cost_exceeded(d):
        return TOO_MUCH_WORK
    if cost_so_far(d) - budget.cost_at_communication_step > d.solver.work_limit * LONGEST_COMMUNICATION_STEP:
        return STEP_TOO_LONG
    if d.step.end >= budget.cost_start + COST_WINDOW:
        budget.cost_start = d.step.end
        budget.cost_at_window = cost_so_far(d)
    return OK


def count_events(d, events):
    """Add the number ``events`` to the count of events in the present EVENT_WINDOW; return a status.

    The status is EVENT_STORM if the count exceeds MOST_EVENTS × n, else OK. The comment on MOST_EVENTS
    defines n.
    """
    budget = d.budget
    if d.step.end >= budget.event_start + EVENT_WINDOW:
        budget.event_start = d.step.end
        budget.event_count = 0
    budget.event_count += events
    elements = d.candidate_count + (
        d.link_count + d.slides if d.friction.may_act or d.chain.has_drive_limits else 0
    )
    return OK if budget.event_count <= MOST_EVENTS * elements else EVENT_STORM

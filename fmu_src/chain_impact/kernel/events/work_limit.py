"""Bounds on work and events for simulated time, so that no scene can keep the solver busy for ever."""

from chain_impact.kernel.status import EVENT_STORM, OK, TOO_MUCH_WORK

WORK_WINDOW = 1.0  # s
EVENT_WINDOW = 1e-3  # s, in which a candidate can have …
MOST_EVENTS = 1000  # … this many onsets and ends before it is called a storm


def watch_work(d):
    """TOO_MUCH_WORK when the evaluations in a second of simulated time exceed the limit, or OK."""
    watch = d.watch
    if d.step.end >= watch.work_start + WORK_WINDOW:
        watch.work_start = d.step.end
        watch.work_count = d.statistics.rhs_evaluations
    done = d.statistics.rhs_evaluations - watch.work_count
    return OK if done <= d.solver.work_limit * WORK_WINDOW else TOO_MUCH_WORK


def watch_events(d, events):
    """EVENT_STORM when ``events`` more are too many for a short window of time, or OK."""
    watch = d.watch
    if d.step.end >= watch.event_start + EVENT_WINDOW:
        watch.event_start = d.step.end
        watch.event_count = 0
    watch.event_count += events
    return OK if watch.event_count <= MOST_EVENTS * d.candidates else EVENT_STORM

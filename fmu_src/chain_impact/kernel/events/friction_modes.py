"""The modes of dry friction after an event: which elements stick, and which slide in which direction.

An element that moves along t slides in the direction of its motion. The modes of those at rest follow from
the forces: they stick if the forces of their constraints are within the limits of static friction, and else
slide so that friction acts against the motion that begins,

    sticks    |F_t| ≤ µ_s F_n        slides with s    s t·a ≥ 0.

The modes are found by pivoting, as in ``solve_lcp``: all that violate their condition change at once as long
as fewer and fewer do. An element keeps its mode if that is consistent. If this comes to no end, the modes are
those of forces within the limits of friction (rows/limits.py), which always exist.
"""

from chain_impact.kernel.chain.kinematics import accelerate_points, largest, locate_points
from chain_impact.kernel.equations import located_rate
from chain_impact.kernel.events.marks import SLIDING_ENDS, STICKING_ENDS, drop_changes
from chain_impact.kernel.events.onset_modes import begins, decide_onsets
from chain_impact.kernel.events.sampled import excess, rest_speed
from chain_impact.kernel.forces.friction import (
    NO_FRICTION,
    STICKS,
    against,
    joint_of,
    list_friction,
    list_sticking,
    set_anchor,
    set_friction_used,
    set_mode,
)
from chain_impact.kernel.forces.holding import project_state
from chain_impact.kernel.ode.last_step import reset_step
from chain_impact.kernel.rows.constraints import MAX_STALLED_PIVOTS, count_stalls
from chain_impact.kernel.rows.geometry import any_sticking, tangential_acceleration, tangential_rate
from chain_impact.kernel.rows.limits import share_within_limits
from chain_impact.kernel.status import count_evaluations

# The largest acceleration against its direction with which a sliding element at rest keeps sliding, over the
# largest acceleration, gravity and a link length per second squared; or twice what sticks accelerates. If
# others hold the element, it is an error.
AGAINST = 1e-9
# The largest speed of what sticks or has just stopped, over a link length per second: an error at a loose
# tolerance. With a larger speed it slides.
MISLOCATED = 1e-3


def update_modes(d, jumped):
    """Set the modes for the state at the end of the last step, and project it onto what sticks.

    Args:
        d: the instance, with the points located at the end of the last step.
        jumped: whether speeds may have jumped. Otherwise what stuck has no speed but for errors.
    """
    own = d.friction
    list_friction(d)
    for e in range(d.elements):
        d.element.before[e] = NO_FRICTION if begins(d, e) else d.element.mode[e]
        set_mode(d, e, NO_FRICTION)
    for i in range(own.count):
        set_mode(d, d.element.index[i], first_guess(d, d.element.index[i], jumped))
    drop_changes(d)
    decide_onsets(d)
    choose_modes(d)
    for i in range(own.stuck_count):
        e = d.element.stuck[i]
        if jumped or d.element.before[e] != STICKS:
            set_anchor(d, e)
    log_changes(d)
    if any_sticking(d):
        project_state(d, d.step.state_end)
        locate_points(d, d.step.state_end)
    for i in range(own.count):
        set_slack(d, d.element.index[i])


def reinit_modes(d, jumped):
    """Choose the modes at the end of the last step, where parameters, inputs or the state have been set.

    Args:
        d: the instance.
        jumped: as for ``update_modes``.
    """
    set_friction_used(d)
    if d.friction.used or d.friction.count > 0:
        locate_points(d, d.step.state_end)
        update_modes(d, jumped)
        reset_step(d, d.step.end, d.step.state_end)


def set_slack(d, e):
    """Set how far element e may move against its direction of sliding: as it does now, because of errors.

    Sliding that begins at rest does so with the error of a speed that has been located to be 0. If others
    hold what has a force at its limit, it moves with them, by as much as the tolerance allows for a speed: it
    accelerates backward, or has ended to slide and slides on.
    """
    backward = -d.element.mode[e] * tangential_rate(d, e)
    held = is_inconsistent(d, e) or d.element.mode[e] == d.element.before[e]
    least = d.solver.tolerance * d.model.size if held else 0.0
    d.element.slack[e] = max(least, 2.0 * backward) if d.element.undecided[e] else 0.0


def first_guess(d, e, jumped):
    """The mode of element e by its motion; if it is at rest, the one it had, and it is undecided."""
    speed = tangential_rate(d, e)
    before, event = d.element.before[e], d.element.event[e]
    d.element.undecided[e] = 1
    if event == STICKING_ENDS:
        return against(d.element.force[e])
    resting = event == SLIDING_ENDS or (before == STICKS and not jumped)
    if resting and abs(speed) <= MISLOCATED * d.model.size:
        return STICKS
    # a speed that sliding may have backward is an error
    slides = abs(before) == 1 and not jumped
    if abs(speed) > rest_speed(d) + (d.element.slack[e] if slides else 0.0):
        d.element.undecided[e] = 0
        return against(-speed)
    return STICKS if before == NO_FRICTION else before


def choose_modes(d):
    """Change the modes of undecided elements until all are consistent, or take those by the limits."""
    fewest, stalls_left = d.friction.count + 1, MAX_STALLED_PIVOTS
    while stalls_left >= 0:
        wrong = count_inconsistent_now(d)
        if wrong == 0:
            return
        fewest, stalls_left = count_stalls(wrong, fewest, stalls_left)
        for i in range(d.friction.count):
            e = d.element.index[i]
            if is_inconsistent(d, e):
                set_mode(d, e, against(d.element.force[e]) if d.element.mode[e] == STICKS else STICKS)
    choose_by_limits(d)


def count_inconsistent_now(d):
    """Find the forces and accelerations with the present modes; return how many of these are inconsistent."""
    rate = d.work.rate
    list_sticking(d)
    located_rate(d, d.step.state_end, rate)
    count_evaluations(d, 1)
    accelerate_points(d, d.step.state_end, rate)
    return count_inconsistent(d)


def choose_by_limits(d):
    """Let all undecided elements stick but those whose forces are at their limits (rows/limits.py).

    An element at its limit slides, or others hold it: then it moves by errors only, in either direction.
    """
    for i in range(d.friction.count):
        if d.element.undecided[d.element.index[i]]:
            set_mode(d, d.element.index[i], STICKS)
    while count_inconsistent_now(d) > 0 and any_over(d):
        share_within_limits(d)
        let_go(d)


def any_over(d):
    """Whether the force of any element that sticks exceeds its limit."""
    for i in range(d.friction.stuck_count):
        if is_inconsistent(d, d.element.stuck[i]):
            return True
    return False


def let_go(d):
    """Let the elements slide whose forces are at their limits, or if there are none, those over them."""
    held = True
    for i in range(d.friction.stuck_count):
        if d.share.at_limit[i] != 0:
            set_mode(d, d.element.stuck[i], against(float(d.share.at_limit[i])))
            held = False
    for i in range(d.friction.stuck_count if held else 0):
        e = d.element.stuck[i]
        if is_inconsistent(d, e):
            set_mode(d, e, against(d.element.force[e]))


def count_inconsistent(d):
    """The number of undecided elements whose mode is not consistent with the forces."""
    wrong = 0
    for i in range(d.friction.count):
        wrong += is_inconsistent(d, d.element.index[i])
    return wrong


def is_inconsistent(d, e):
    """Whether element e is undecided and its mode is not consistent with the forces and accelerations."""
    if not d.element.undecided[e]:
        return False
    if d.element.mode[e] == STICKS:
        return abs(d.element.force[e]) > d.element.limit[e] + 0.5 * excess(d, e)
    acceleration = d.element.mode[e] * tangential_acceleration(d, e)
    return acceleration < -unsure_acceleration(d)


def unsure_acceleration(d):
    """An acceleration [m/s²] of an element that may be an error: round-off, or as of what sticks."""
    left = 0.0
    for i in range(d.friction.stuck_count):
        left = max(left, abs(tangential_acceleration(d, d.element.stuck[i])))
    return AGAINST * (largest(d, d.work.acceleration) + d.model.gravity_size + d.model.size) + 2.0 * left


def clear_changes(d):
    """Clear the log of changes, as they have been collected or a run starts."""
    d.changes.count = 0


def log_changes(d):
    """Log the elements whose mode has changed. In a full log they overwrite the oldest entries."""
    log = d.changes
    for e in range(d.elements):
        if d.element.mode[e] != d.element.before[e]:
            row = log.count % len(log.time)
            joint = e >= d.candidates
            log.time[row], log.mode[row] = d.step.end, d.element.mode[e]
            # a slider is point 0
            log.point[row] = (joint_of(d, e) + 1) % (d.links + 1) if joint else d.candidate.point[e]
            log.wall[row] = -1 if joint else d.candidate.wall[e]
            log.count += 1

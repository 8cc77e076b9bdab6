"""The search of a step for changes of the modes of dry friction, by samples (force_events.py).

An element that slides stops where its speed in the direction of sliding falls below zero. An element that
sticks begins to slide where the friction force exceeds its limit.
"""

from chain_impact.kernel.constraints.constraint_response import mean_mass
from chain_impact.kernel.constraints.geometry import tangential_rate
from chain_impact.kernel.cost import count_evaluations
from chain_impact.kernel.equations import rate_from_state
from chain_impact.kernel.events.crossing import locate_at_fraction
from chain_impact.kernel.events.force_events import inputs_turn_fast, make_search
from chain_impact.kernel.events.marks import mark_mode_change
from chain_impact.kernel.forces.holding import project_state
from chain_impact.kernel.record.constants import SLIDING_ENDS, STICKING_ENDS, STICKS

# the largest tangential speed that counts as rest, relative to one longest link per second
REST_SPEED = 1e-12
# A friction force that exceeds its limit by up to FRICTION_EXCESS is round-off, relative to a sum: the limit,
# plus the mean mass of a link times the sum of gravity and the longest link per s².
FRICTION_EXCESS = 1e-10
# A sliding speed that is positive at all stages may be negative between two of them if its least value at a
# stage is below DIP_PART times that at one of the ends. With a smaller number, falls of a speed that is about
# a parabola in time would be missed; with a larger number, steps would be searched in vain.
DIP_PART = 0.5

FRICTION_ELEMENT_MEMBERS = (lambda d: d.friction.active_count, lambda d, k: d.friction_element.index[k])


def mode_may_end(d, e, end):
    """Return whether e's mode may have ended in the last step up to its fraction ``end``.

    This is so in three cases:

    - The margin of the mode was below −``element_error`` at a stage.
    - e slides, and its least speed at a stage is so small that the speed may have been negative between two
      stages (DIP_PART).
    - Inputs turn so fast that the margin may have been negative between the stages.

    The points must be located at ``end``, and are located there afterwards.
    """
    least = d.friction_element.margin[e]
    if inputs_turn_fast(d) or least < -element_error(d, e):
        return True
    if d.friction_element.mode[e] == STICKS:
        return False
    speed = sliding_speed(d, e)
    locate_at_fraction(d, 0.0)
    speed = max(speed, sliding_speed(d, e))
    locate_at_fraction(d, end)
    return least < DIP_PART * speed


def sliding_speed(d, e):
    """Return the speed [m/s] of element e in the direction in which e slides, at the located points."""
    return d.friction_element.mode[e] * tangential_rate(d, e)


def mark_changes(d, element, theta):
    """Mark ``element``, whose mode ends at θ of the step, and every other element whose mode ends at θ.

    The sliding of an element that comes to rest at θ ends as well, even if its speed would not change its
    sign: another element, which sticks from θ on, may hold the body at rest. Otherwise round-off would decide
    which elements of a body that stops slide on at zero speed, with forces at their limits. Afterwards the
    points are located at θ.
    """
    for i in range(d.friction.active_count):
        e = d.friction_element.index[i]
        if e == element or element_margin(d, e, theta) < 0.0 or has_come_to_rest(d, e):
            mark_mode_change(d, e, STICKING_ENDS if d.friction_element.mode[e] == STICKS else SLIDING_ENDS)
    locate_at_fraction(d, theta)


def has_come_to_rest(d, e):
    """Return whether e slides, is at rest at the located points, and was not at rest when the step began.

    Afterwards the points may be located at the start of the last step.
    """
    if d.friction_element.mode[e] == STICKS or not is_at_rest(d, e):
        return False
    locate_at_fraction(d, 0.0)
    return not is_at_rest(d, e)


def is_at_rest(d, e):
    """Return whether the tangential speed of element e is at most ``rest_speed`` at the located points."""
    return abs(tangential_rate(d, e)) <= rest_speed(d)


def element_error(d, e):
    """Return the tolerated error of element e: of friction force [N] if e sticks, else of speed [m/s]."""
    return (
        friction_round_off(d, e)
        if d.friction_element.mode[e] == STICKS
        else rest_speed(d) + d.friction_element.slack[e]
    )


def rest_speed(d):
    """Return the tangential speed [m/s] up to which an element with ``slack`` 0 counts as at rest."""
    return REST_SPEED * d.chain.longest_link


def friction_round_off(d, e):
    """Return the excess [N] of the friction force of element e over its limit that counts as round-off."""
    return FRICTION_EXCESS * (
        d.friction_element.friction_limit[e]
        + mean_mass(d) * (d.chain.gravity_magnitude + d.chain.longest_link)
    )


def element_margin(d, e, theta):
    """Return the margin of element e to the end of its mode at θ, plus the tolerated error ``element_error``.

    The margin is the speed in the direction of sliding [m/s]; if e sticks, the limit minus |friction| [N].
    """
    locate_at_fraction(d, theta)
    if d.friction_element.mode[e] != STICKS:
        return sliding_speed(d, e) + element_error(d, e)
    project_state(d, d.scratch.state)
    rate_from_state(d, d.scratch.state, d.scratch.rate)
    count_evaluations(d, 1)
    return d.friction_element.friction_limit[e] - abs(d.friction_element.force[e]) + element_error(d, e)


def margin_is_halved(d):
    """Return whether the repeated step at least halves the margin of any mode that is marked to end.

    The margin (``element_margin``) at the end of the step is compared with that at its start. The dense
    output of a long implicit step has errors: it may show an end of a mode that a shorter step does not have.
    Without this check, steps with such false ends could follow each other without end.
    """
    is_halved = False
    for i in range(d.friction.active_count):
        e = d.friction_element.index[i]
        if d.friction_element.event[e]:
            is_halved = is_halved or element_margin(d, e, 1.0) <= 0.5 * element_margin(d, e, 0.0)
    locate_at_fraction(d, 1.0)
    return is_halved


find_mode_change = make_search(
    element_margin, mode_may_end, mark_changes, FRICTION_ELEMENT_MEMBERS, finds_dips=True
)

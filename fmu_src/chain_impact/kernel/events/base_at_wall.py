"""The end of a run in which a wall reaches the base, which is pinned or slides parallel to the wall.

The distance g of the base from the wall follows from prescribed motions alone (chain/prescribed_motion.py).
The search is like that of crossing.py. With a bound |g̈| ≤ A over an interval of width w, g lies below its
chord by at most A w²/8. An interval in which g may therefore fall to −ALLOWED_OVERLAP is halved. So the
search also finds a wall that passes the base within a step and comes back.
"""

from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.prescribed_motion import move_channels
from chain_impact.kernel.chain.slider import slider_component
from chain_impact.kernel.constraints.geometry import ALLOWED_OVERLAP, is_at_wall
from chain_impact.kernel.cost import count_other_cost, is_cost_exceeded
from chain_impact.kernel.events.crossing import prescribed_bounds
from chain_impact.kernel.events.marks import drop_events
from chain_impact.kernel.mathematics.root_search import MOST_GUESSES
from chain_impact.kernel.ode.dense_output import fraction_at_time
from chain_impact.kernel.ode.falls import correct_falls
from chain_impact.kernel.ode.last_step import ensure_dense, truncate_step
from chain_impact.kernel.record.constants import PARALLEL_COSINE, SOLVER_READER
from chain_impact.kernel.status import BASE_BEYOND_WALL, BASE_PART, OK, refuse_part


def end_where_wall_meets_base(d):
    """End the last step where a wall reaches the base, if any wall does.

    ``check_base_at_walls`` then ends the run. Afterwards the points are located at the end of the step.
    """
    reached = d.step.end
    for c in range(d.candidate_count if d.chain.has_base_joint else 0):
        if faces_base(d, c):
            reached = time_of_meeting(d, c, reached)
    if reached < d.step.end:
        drop_events(d)
        ensure_dense(d, SOLVER_READER)
        truncate_step(d, fraction_at_time(d, reached))
        correct_falls(d)
    locate_points(d, d.step.state_end)


def check_base_at_walls(d):
    """Return BASE_BEYOND_WALL if the base is beyond a wall at the end of the last step, else OK.

    The base is beyond the wall if ``base_clearance`` is below −ALLOWED_OVERLAP/2.
    """
    move_channels(d, d.step.end)
    for c in range(d.candidate_count if d.chain.has_base_joint else 0):
        # if ``end_where_wall_meets_base`` has cut the step, the clearance is −ALLOWED_OVERLAP up to
        # round-off; the limit −ALLOWED_OVERLAP/2 leaves a margin for this round-off
        if faces_base(d, c) and base_clearance(d, c) < -0.5 * ALLOWED_OVERLAP:
            return refuse_part(d, BASE_PART, c, BASE_BEYOND_WALL)
    return OK


def overlap_margin(d, c, time):
    """Return ``base_clearance`` from the wall of candidate c at a ``time`` [s], plus ALLOWED_OVERLAP [m].

    The result is < 0 if the base is deeper in the wall than ALLOWED_OVERLAP. Base and walls move to this
    time.
    """
    move_channels(d, time)
    count_other_cost(d, 1)
    return base_clearance(d, c) + ALLOWED_OVERLAP


def time_of_meeting(d, c, end):
    """Return the first time [s] in the last step at which ``base_clearance`` falls to −ALLOWED_OVERLAP.

    The wall is that of candidate c. The result is ``end`` [s] if the clearance does not fall so far before
    ``end``, and a time without meaning if the cost exceeds the limit, which ends the run.
    """
    _, acceleration = prescribed_bounds(d, c)
    a, b = d.step.start, end
    margin_a, margin_b = overlap_margin(d, c, a), overlap_margin(d, c, b)
    while margin_a >= 0.0 and not is_cost_exceeded(d):
        width = b - a
        sag = acceleration * width * width / 8.0
        # with a sag below ALLOWED_OVERLAP the clearance g falls through −ALLOWED_OVERLAP at most once in the
        # interval, up to round-off
        is_short = sag < ALLOWED_OVERLAP
        if is_short and margin_b < 0.0:
            return time_of_passage(d, c, a, b)
        if is_short or min(margin_a, margin_b) >= sag:
            if b >= end:
                return end
            a, margin_a, b = b, margin_b, min(end, b + 2.0 * width)
        else:
            b = a + 0.5 * width
        margin_b = overlap_margin(d, c, b)
    return a


def time_of_passage(d, c, a, b):
    """Return the time [s] between a and b at which ``base_clearance`` falls to −ALLOWED_OVERLAP.

    The clearance is larger at a and smaller at b. The time is found by halving of the interval.
    """
    for _ in range(MOST_GUESSES):
        middle = 0.5 * (a + b)
        if not a < middle < b:
            break
        if overlap_margin(d, c, middle) < 0.0:
            b = middle
        else:
            a = middle
    return b


def faces_base(d, c):
    """Return whether c is the first candidate of a wall that can meet the base, which is pinned or slides.

    Wall and pinned base can meet if one of them moves. A wall can meet a base that slides if the wall moves
    and is parallel to the base's line; other walls can touch such a base as a point. Only the first candidate
    of each wall counts, so that each wall is checked once.
    """
    if not is_at_wall(d, c):
        return False
    channel = d.wall_motion.first_channel[c]
    if d.slides:
        # all walls but those parallel to the line have the same points as candidates
        cosine = slider_component(d, d.candidate.normal_x[c], d.candidate.normal_y[c])
        return channel >= 0 and abs(cosine) < PARALLEL_COSINE and not has_earlier_candidate(d, c)
    # all walls have the same points as candidates, in the same order
    return d.candidate.point[c] == d.candidate.point[0] and (d.chain.base_moves or channel >= 0)


def has_earlier_candidate(d, c):
    """Return whether a candidate before c is at the same moving wall as c."""
    for e in range(c):
        if d.wall_motion.first_channel[e] == d.wall_motion.first_channel[c]:
            return True
    return False


def base_clearance(d, c):
    """Return n·p − offset [m] of the base p at candidate c's wall, without radius; < 0 in the wall."""
    x, y = d.step.state_end[0], d.step.state_end[1]
    if d.chain.base_moves:
        x, y = d.channel.position[0], d.channel.position[1]
    return d.candidate.normal_x[c] * x + d.candidate.normal_y[c] * y - d.candidate.offset[c]

"""The events that are found by samples of a step. At each kind of event a function falls below zero.

mode_changes.py has the searches for the ends of sliding and sticking, this module those for all other kinds.

    KINK             δ̇ or the force without the cut at 0; times −1 if the step starts beyond the kink
    RELATCH          RELATCH_RATIO v₀ − δ̇ of a contact with a force
    RELEASE          least force with which a rigid wall holds a point
    SLIDING_ENDS     s t·v, the speed in the direction of sliding
    STICKING_ENDS    µ_s F_n − |F_t|, the limit of friction minus the friction force
    (drives)         least margin of a drive's torque or force to the end of the drive's mode

δ is the penetration, v₀ the latched speed in the law, s = ±1 the direction of sliding, t·v the tangential
speed relative to the belt, F_n the normal force, F_t the friction force, and µ_s the coefficient of static
friction. The stages and ends of a step show which events must be searched for; if inputs turn fast, changes
of friction modes, RELEASE and limits of drives are searched for in any case. An event that is found late
causes only a small error of energy.

KINK: the force of a contact has a kink where it is cut off at 0 or, for a law that damps on approach only, at
δ̇ = 0. A step across a kink would lose its order. So a step uses the force of one side of the kink, continued
smoothly beyond the kink. If a stage or the end of the step is beyond the kink, the step is repeated so that
it ends at the kink; the next step uses the force of the other side. Where the force is cut off, a point that
is still inside the wall moves as in flight until it leaves or the wall pushes again.

The torque or force of a drive has a kink where it reaches its limit or falls below the limit. The mode of the
drive stays the same until the end of the step.

RELATCH: v₀ is latched at the onset of the contact. v₀ is raised if δ̇ becomes much larger than v₀, in a
second impact or, after a very slow onset, by gravity. Otherwise the force, which contains λ δ̇/v₀ with the
damping factor λ, would grow without bound.
"""

from chain_impact.kernel.chain.drives import drive_component, mode_margin
from chain_impact.kernel.chain.inputs import ensure_inputs
from chain_impact.kernel.chain.kinematics import locate_points
from chain_impact.kernel.chain.signals import rate_in_limited_drives
from chain_impact.kernel.constraints.geometry import clearance_and_rate
from chain_impact.kernel.cost import count_evaluations
from chain_impact.kernel.equations import rate_from_state
from chain_impact.kernel.events.crossing import SIMULTANEOUS_TIME, locate_at_fraction
from chain_impact.kernel.events.event_exclusion import RELATCH_RATIO, may_relatch
from chain_impact.kernel.events.marks import drop_events, mark_contact_event, mark_saturation
from chain_impact.kernel.events.passage import make_passage_search
from chain_impact.kernel.forces.active_contacts import kink_height
from chain_impact.kernel.forces.force_formula import note_crossing
from chain_impact.kernel.forces.holding import least_impulse, project_state
from chain_impact.kernel.ode.dense_output import interpolate_state
from chain_impact.kernel.ode.step_control import is_accepted, reject_step
from chain_impact.kernel.record.constants import (
    CHECK_FAILED,
    KINK,
    RELATCH,
    RELEASE,
)
from chain_impact.kernel.record.state import omega_at, velocity_at

# SAMPLES: the least number of samples in the searched part of a step. The search for RELATCH takes
# FEW_SAMPLES: if it misses an event, the latched speed only stays too low.
SAMPLES, FEW_SAMPLES = 8, 4
# The turn [rad] of an input is its angular frequency times the duration of the step. With a turn above
# TURN_OF_STAGES, events that inputs cause may lie between the stages, which are up to 0.31 of the step apart.
TURN_OF_STAGES = 0.5
# number of samples per radian in a step with a turn above TURN_OF_STAGES
SAMPLES_PER_RADIAN = 8.0
# [rad] a larger turn gets as many samples as MOST_SAMPLED_TURN, to bound the cost of the samples
MOST_SAMPLED_TURN = 1e4
# A wall pulls if the force by which it holds a point is negative. A pull up to PULL_ROUND_OFF is round-off,
# relative to the mass of chain, carriage and armatures times the sum of gravity and the longest link per s².
PULL_ROUND_OFF = 1e-11
# [s] a shorter step is not rejected if a wall pulls by more than ``plausible_pull`` in a stage
LEAST_REJECTED_STEP = 1e-9


CONTACT_MEMBERS = (lambda d: d.contacts.force_law_count, lambda d, k: d.contacts.active_index[k])
ONE_MEMBER = (lambda _d: 1, lambda _d, _k: 0)


def turn_of_inputs(d):
    """Return the largest turn [rad] of an input in the last step: ``search.input_rate`` times duration."""
    return (d.step.end - d.step.start) * d.search.input_rate


def inputs_turn_fast(d):
    """Return whether an input turns so fast in the last step that events may lie between its stages."""
    return turn_of_inputs(d) > TURN_OF_STAGES


def sample_count(d):
    """Return the number of samples in the search of the last step: SAMPLES, or more if inputs turn fast."""
    return max(SAMPLES, 1 + int(SAMPLES_PER_RADIAN * min(MOST_SAMPLED_TURN, turn_of_inputs(d))))


def make_search(
    value,
    is_suspect,
    mark,
    members=ONE_MEMBER,
    *,
    samples=sample_count,
    resolution=SIMULTANEOUS_TIME,
    finds_dips=False,
):
    """Return a search of the last step for one kind of event.

    Args:
        value: function of (d, c, θ) that falls below zero at the event; c is a candidate or an element.
        is_suspect: function of (d, c, θ): whether stages, and the points, which are located at θ, show that c
            may have an event up to the fraction θ of the step.
        mark: function of (d, c, θ) that marks the event of c at θ, and other events at the same time.
        members: two functions: of d, the number of searched c; of (d, k), the k-th c. ONE_MEMBER: c = 0.
        samples: function of d that returns the number of samples of the step.
        resolution: accuracy of the location of the event, as in ``make_passage_search``.
        finds_dips: whether short falls between two samples are searched for, as in ``make_passage_search``.

    Returns:
        A function of (d, earliest). ``earliest`` is the θ of the earliest event found so far, −1 for none.
        The function searches the step up to ``earliest`` or, for −1, up to its end. If it finds an event of
        this kind, it drops all marks, marks this event and returns its θ, else it returns ``earliest``. The
        points must be located at the end of the searched part of the step; afterwards they are located at the
        result or, for −1, at the end of the step.
    """
    count, member = members
    passage = make_passage_search(value, samples, resolution, finds_dips)

    def find(d, earliest):
        first, event_member = earliest if earliest >= 0.0 else 1.0, -1
        for k in range(count(d)):
            c = member(d, k)
            if is_suspect(d, c, first):
                theta = passage(d, c, first)
                if theta >= 0.0:
                    first, event_member = theta, c
                locate_at_fraction(d, first)
        if event_member < 0:
            return earliest
        drop_events(d)
        mark(d, event_member, first)
        return first

    return find


# ---- contacts with a force --------------------------------------------------------------------------------


def mark_kinks(d, c, theta):
    """Mark contact c, and each contact that passes its kink up to SIMULTANEOUS_TIME after the fraction θ.

    θ is a fraction of the last step. Afterwards the points are located at θ.
    """
    mark_contact_event(d, c, KINK)
    # contacts of a symmetric chain reach their kinks at one time, up to round-off: all are marked
    locate_at_fraction(d, min(1.0, theta + SIMULTANEOUS_TIME / d.step.size))
    for k in range(d.contacts.force_law_count):
        if side_of_kink(d, d.contacts.active_index[k]) < 0.0:
            mark_contact_event(d, d.contacts.active_index[k], KINK)
    locate_at_fraction(d, theta)


def side_of_kink(d, c):
    """Return ±``kink_height`` [N or m/s] of contact c; the sign makes it positive on the step's side."""
    height = kink_height(d, c)
    return -height if d.contacts.beyond_kink[c] else height


def has_crossed(d, c, _end):
    """Return whether a stage of the last step, or the located points, show that c has crossed its kink."""
    note_crossing(d, c, kink_height(d, c))
    return d.contacts.kink_crossed[c] != 0


def side_of_kink_at(d, c, theta):
    """Return ``side_of_kink`` of contact c at the fraction θ of the last step."""
    locate_at_fraction(d, theta)
    return side_of_kink(d, c)


def relatch_margin(d, c, theta):
    """Return RELATCH_RATIO v₀ − δ̇ [m/s] of contact c at θ; if this is < 0, the speed v₀ is latched again."""
    locate_at_fraction(d, theta)
    _, clearance_rate = clearance_and_rate(d, c)
    return RELATCH_RATIO * d.contacts.latched_speed[c] + clearance_rate


find_relatch = make_search(
    relatch_margin,
    lambda d, c, _end: may_relatch(d, c),
    lambda d, c, _theta: mark_contact_event(d, c, RELATCH),
    CONTACT_MEMBERS,
    samples=lambda _d: FEW_SAMPLES,
)
find_kink = make_search(
    side_of_kink_at, has_crossed, mark_kinks, CONTACT_MEMBERS, samples=lambda _d: SAMPLES, resolution=0.0
)


# ---- release by rigid walls -------------------------------------------------------------------------------


def check_pull(d, _c):
    """Return whether to search the last step for a release, because a rigid wall has pulled in a stage.

    Round-off (``pull_limit``) does not count. If a wall has pulled by more than ``plausible_pull``, and the
    step is longer than LEAST_REJECTED_STEP, the function rejects the step and returns False.
    """
    least_force = 0.0
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        least_force = min(least_force, d.constraints.least_force[d.contacts.active_index[k]])
    if not least_force < -pull_limit(d):
        return False
    if least_force < -plausible_pull(d) and d.step.size > LEAST_REJECTED_STEP:
        reject_step(d, CHECK_FAILED)
        return False
    return True


def pull_limit(d):
    """Return the largest pull [N] of a rigid wall that round-off can cause."""
    return (
        PULL_ROUND_OFF
        * d.chain.energy_scale
        / (d.chain.longest_link * d.chain.longest_link)
        * (d.chain.gravity_magnitude + d.chain.longest_link)
    )


def plausible_pull(d):
    """Return the largest plausible pull [N], from gravity and the motion at the start of the last step.

    If a wall pulls more strongly in a stage, the stage has passed a toggle position, where forces go to
    infinity. The step and its time of release are then wrong.
    """
    first, turn_rate, carriage = omega_at(d.link_count), 1.0, 0.0
    if d.slides:
        carriage = abs(drive_component(d, d.scratch.rate_start, velocity_at(d.link_count), d.link_count))
    for i in range(d.link_count):
        omega, alpha = d.step.state[first + i], d.scratch.rate_start[first + i]
        turn_rate = max(turn_rate, omega * omega + abs(alpha))
    longest_link = d.chain.longest_link
    mass = d.chain.energy_scale / (longest_link * longest_link)
    return mass * (d.chain.gravity_magnitude + carriage + d.link_count * longest_link * turn_rate)


def least_force(d, _c, theta):
    """Return the least force [N] of held contacts at the fraction θ of the last step, plus ``pull_limit``.

    If all walls push, 0 stands for the least force. So the result is negative only if a wall pulls by more
    than round-off.
    """
    interpolate_state(d.step, theta, d.scratch.state)
    # the state is projected, because the error of the interpolant would cause large forces of stiff joints
    locate_points(d, d.scratch.state)
    project_state(d, d.scratch.state)
    rate_from_state(d, d.scratch.state, d.scratch.rate)
    count_evaluations(d, 1)
    return least_impulse(d) + pull_limit(d)


def mark_pulling(d, _c, theta):
    """Mark with RELEASE the held contacts that pull by ``pull_limit`` or more at θ of the last step."""
    least_force(d, 0, theta)
    for k in range(d.contacts.force_law_count, d.contacts.active_count):
        if d.constraints.impulse[k] + pull_limit(d) <= 0.0:
            mark_contact_event(d, d.contacts.active_index[k], RELEASE)


def may_release(d, c, _end):
    """Return whether to search the last step for the release of a point.

    This is so if a wall has pulled in a stage (``check_pull``), or if inputs turn fast, so that a wall may
    pull between the stages. A step that ``check_pull`` has just rejected is not searched.
    """
    return check_pull(d, c) or (inputs_turn_fast(d) and is_accepted(d))


find_release = make_search(least_force, may_release, mark_pulling)


# ---- limits of drives -------------------------------------------------------------------------------------


def may_pass_limit(d, _c, _end):
    """Return whether the mode of a drive may have ended in the last step.

    This is so if a stage or the end of the step shows an end, or if the margin of a drive with a limit may
    have been negative between the stages, because inputs turn fast. If these are the scene's signals, only a
    fast signal that acts in a drive with a limit counts.
    """
    if not d.chain.has_drive_limits:
        return False
    if inputs_turn_fast(d):
        if d.signal_count == 0 or d.inputs.piece.degree != 0:
            return True
        if (d.step.end - d.step.start) * rate_in_limited_drives(d) > TURN_OF_STAGES:
            return True
    ensure_inputs(d, d.step.state_end)
    return min(d.drive.mode_margin, mode_margin(d, d.step.state_end)) < 0.0


def drive_margin(d, _c, theta):
    """Return ``mode_margin`` [N·m] at θ: the least margin of any drive to the end of the drive's mode."""
    locate_at_fraction(d, theta)
    ensure_inputs(d, d.scratch.state)
    return mode_margin(d, d.scratch.state)


def mark_drive_limit(d, _c, _theta):
    """Mark that the mode of a drive ends."""
    mark_saturation(d, 1)


find_saturation = make_search(drive_margin, may_pass_limit, mark_drive_limit, finds_dips=True)

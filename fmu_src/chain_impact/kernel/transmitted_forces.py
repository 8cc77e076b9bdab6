"""The forces and moments that the joints transmit, and the forces and moments of the chain on walls.

Newton's law for the links i to N gives the force f_i of link i − 1 on link i. With F_k the force at point k,
m_j the mass of link j, a_Cj the acceleration of its centre of mass, and g gravity, this force is

    f_i = Σ_{j≥i} m_j (a_Cj − g) − Σ_{k≥i} F_k.

A contact at point k acts on link k, which ends there; a contact at the base acts on link 1, and a contact at
a site acts on the site's link. Integrated over time, with p the momentum of the links i to N, the law is

    ∫f_i dt = Δp − Σ m_j g Δt − Σ_{k≥i} ∫F_k dt.

This law includes the impulses of rigid walls. So the impulse in a joint follows from momenta and from the
impulses at the points, and f_i is not integrated.

The peak of |f_i| is searched for in the dense output of each step; impulses of rigid walls do not count in a
peak. A contact begins and ends at ends of steps. So the largest force during a contact is the largest one in
the steps in which the contact is active.

In the record, transmitted forces have a row for each joint, from row 0 for the joint at the base, and after
these a row for each wall. If a scene does not request the outputs of loads, its record has no such rows.
"""

import math

from chain_impact.kernel.chain.drives import first_joint, transmitted_moment
from chain_impact.kernel.chain.kinematics import accelerate_points, locate_points, vector_at_center_of_mass
from chain_impact.kernel.constraints.geometry import (
    is_at_joint_stop,
    is_at_wall,
    joint_stop_moment,
    link_of,
    normal_row,
    tangent_row,
)
from chain_impact.kernel.cost import read_cost_counts, restore_cost_counts
from chain_impact.kernel.equations import rate_from_points
from chain_impact.kernel.forces.active_contacts import set_joint_square
from chain_impact.kernel.function_marks import has_dual_rule
from chain_impact.kernel.ode.dense_output import event_fraction, fraction_at_time, interpolate_state
from chain_impact.kernel.ode.folds import correct_near_fold
from chain_impact.kernel.ode.last_step import ensure_dense, ensure_points
from chain_impact.kernel.ode.maximum import maximum_of
from chain_impact.kernel.record.constants import OUTPUT_READER, WALLS
from chain_impact.kernel.record.method import was_implicit
from chain_impact.kernel.record.state import time_at

# The number of intervals between the samples of joint forces in a step: PEAK_INTERVALS in an explicit step,
# IMPLICIT_PEAK_INTERVALS in an implicit step, where the forces may rise and fall often.
PEAK_INTERVALS, IMPLICIT_PEAK_INTERVALS = 8, 32
# A peak is searched for where the parabola through three samples of |f|² exceeds this part of the largest
# |f|² so far. The parabola may lie below the peak, so with a value nearer to 1 some peaks would be missed.
NEAR_PEAK = 0.95


def start_transmitted_forces(d, time):
    """Clear the peaks at the start of a run at ``time`` [s], and store the momenta of the links.

    The momenta are those at the end of the last step, which has the length 0.
    """
    transmitted = d.transmitted
    locate_points(d, d.step.state_end)
    transmitted.run_start, transmitted.searched_end = time, math.nan
    set_link_momenta(d, transmitted.start_x, transmitted.start_y)
    for i in range(d.link_count):
        set_joint_force_peak(d, i, 0.0, time)


def store_tip_impulse(d, j, impulse):
    """Store component j, x or y, of the impulse [N·s] of the input force at the tip since the run's start.

    The impulses in joints are computed from this impulse.
    """
    d.transmitted.tip_impulse[j] = impulse


def set_joint_force_peak(d, i, square, time):
    """Set the largest squared force |f|² [N²] so far of the joint in row i, and its time [s]."""
    d.transmitted.peak_square[i], d.transmitted.peak_time[i] = square, time


def set_link_momenta(d, x, y):
    """Set x and y to the momentum [N·s] of each link, for the located points."""
    for i in range(d.link_count):
        vx, vy = vector_at_center_of_mass(d, d.scratch.velocity, i)
        x[i], y[i] = d.chain.mass[i] * vx, d.chain.mass[i] * vy


def set_joint_forces(d, contact_force, friction_force, x, y):
    """Set x and y to the force f_i [N] in each joint, on its outer link, for the accelerated points.

    ``contact_force`` has the normal force [N] of each candidate, and ``friction_force`` the friction force
    [N] of each element.
    """
    for i in range(d.link_count):
        ax, ay = vector_at_center_of_mass(d, d.scratch.acceleration, i)
        x[i] = d.chain.mass[i] * (ax - d.chain.gravity[0])
        y[i] = d.chain.mass[i] * (ay - d.chain.gravity[1])
    for k in range(d.contacts.active_count):
        subtract_contact(d, d.contacts.active_index[k], contact_force, friction_force, x, y)
    sum_from_tip(d, d.inputs.tip_force, x, y)


def subtract_contact(d, c, along_normal, along_tangent, x, y):
    """Subtract the force or impulse of candidate c's wall from the entry in x and y of the link it acts on.

    ``along_normal`` and ``along_tangent`` have the two components for each candidate. Stops are ignored:
    those of a joint act between links, those of the slider on its carriage.
    """
    if is_at_wall(d, c):
        fx, fy = wall_force(d, c, along_normal, along_tangent)
        i = link_of(d, c)
        x[i] -= fx
        y[i] -= fy


def sum_from_tip(d, at_tip, x, y):
    """Set x and y to the force, or impulse, in the proximal joint of each link.

    Before the call, the entry of a link in x and y is the link's mass times (a_C − g), minus the forces of
    walls on the link; or the integral of this sum over time. The force, or impulse, in a joint is the sum of
    these entries from the joint's outer link to the tip, minus the force, or impulse, ``at_tip``.
    """
    x[d.link_count - 1] -= at_tip[0]
    y[d.link_count - 1] -= at_tip[1]
    for i in range(d.link_count - 2, -1, -1):
        x[i] += x[i + 1]
        y[i] += y[i + 1]


def wall_force(d, c, along_normal, along_tangent):
    """Return the force [N] or impulse [N·s] of a wall on candidate c's point, x and y.

    ``along_normal`` and ``along_tangent`` have the two components for each candidate.
    """
    _, nx, ny = normal_row(d, c)
    fx, fy = along_normal[c] * nx, along_normal[c] * ny
    if d.friction_element_count > 0:
        _, tx, ty = tangent_row(d, c)
        fx += along_tangent[c] * tx
        fy += along_tangent[c] * ty
    return fx, fy


def fill_transmitted_forces(d, y, rate):
    """Fill the outputs of forces and moments of joints and walls, for the accelerated points.

    The outputs of contact forces and of dry friction must have been filled. The moment of a joint is the
    whole moment on its outer link: of drive, dry friction and stops, minus the torque that accelerates the
    armature. With this definition each link obeys Euler's law.
    """
    out = d.output
    set_joint_forces(d, out.force, out.friction.force, out.transmitted.x, out.transmitted.y)
    for i in range(d.link_count):
        out.transmitted.moment[i] = transmitted_moment(d, y, rate, i)
        if d.friction_element_count > 0:
            out.transmitted.moment[i] += out.friction.drive_friction[i]
    if d.slides:
        fill_slider_reaction(d)
    for row in range(d.link_count, d.transmitted_row_count):
        out.transmitted.x[row], out.transmitted.y[row], out.transmitted.moment[row] = 0.0, 0.0, 0.0
    for k in range(d.contacts.active_count):
        c = d.contacts.active_index[k]
        if is_at_wall(d, c):
            add_force_on_wall(d, c)
        elif is_at_joint_stop(d, c):
            out.transmitted.moment[d.candidate.point[c] - 1] += joint_stop_moment(d, c, out.force[c])


def fill_slider_reaction(d):
    """Fill the outputs of the force and the moment of the slider's line on the carriage.

    The force follows from the force in joint 1 and the carriage's weight; the moment is that in joint 1.
    """
    out, slider, gravity = d.output, d.slider, d.chain.gravity
    # reaction of the line from the force f₁ in joint 1 and the weight m g: R = n·(f₁ − m g), n = (−u_y, u_x);
    # the carriage does not turn
    fx, fy = out.transmitted.x[0] - slider.mass * gravity[0], out.transmitted.y[0] - slider.mass * gravity[1]
    out.slider_reaction, out.slider_moment = slider.ux * fy - slider.uy * fx, out.transmitted.moment[0]


def add_force_on_wall(d, c):
    """Add the force of candidate c's point on its wall, and the moment of this force, to the outputs.

    The moment is about the given point of the wall (`walls.x`, `walls.y`), which does not move with the wall;
    for a wall of the box it is about the origin.
    """
    out, wall, place = d.output, d.candidate.wall[c], d.candidate.place[c]
    fx, fy = wall_force(d, c, out.force, out.friction.force)
    x, y = d.scratch.position.x[place], d.scratch.position.y[place]
    if wall >= len(WALLS):
        x -= d.walls.x[wall - len(WALLS)]
        y -= d.walls.y[wall - len(WALLS)]
    row = d.link_count + wall
    out.transmitted.x[row] -= fx
    out.transmitted.y[row] -= fy
    out.transmitted.moment[row] -= x * fy - y * fx


def fill_joint_impulses(d):
    """Fill the outputs of the joints' impulses from the run's start to the communication point.

    The points must be located at the communication point.
    """
    out, transmitted = d.output, d.transmitted
    x = out.transmitted.impulse_x
    y = out.transmitted.impulse_y
    duration = d.step.communication_point - transmitted.run_start
    set_link_momenta(d, x, y)
    for i in range(d.link_count):
        x[i] -= transmitted.start_x[i] + d.chain.mass[i] * d.chain.gravity[0] * duration
        y[i] -= transmitted.start_y[i] + d.chain.mass[i] * d.chain.gravity[1] * duration
    for c in range(d.candidate_count):
        subtract_contact(d, c, out.impulse, out.friction.impulse, x, y)
    sum_from_tip(d, transmitted.tip_impulse, x, y)


def fill_joint_force_peaks(d):
    """Fill the outputs of the largest joint forces since the start, up to the communication point.

    A whole step is searched only once. Only if the step raises a peak, an output at a time within the step
    needs a second search, up to this time. After a search, the points are not located at the output's time.
    """
    out, transmitted, rises = d.output.transmitted, d.transmitted, False
    if transmitted.searched_break_count != d.step.break_count or transmitted.searched_end != d.step.end:
        search_step_for_peaks(d)
        for i in range(d.link_count):
            transmitted.searched_square[i] = transmitted.largest_square[i]
        transmitted.searched_break_count, transmitted.searched_end = d.step.break_count, d.step.end
    for i in range(d.link_count):
        transmitted.largest_square[i] = transmitted.peak_square[i]
        transmitted.largest_time[i] = transmitted.peak_time[i]
        raise_largest(d, i, out.x[i] * out.x[i] + out.y[i] * out.y[i], d.step.communication_point)
        rises = rises or transmitted.searched_square[i] > transmitted.largest_square[i]
    if rises:
        search_peaks(d, d.step.communication_point, d.step.communication_point)
    for i in range(d.link_count):
        out.peak[i] = math.sqrt(transmitted.largest_square[i]) if transmitted.largest_square[i] > 0.0 else 0.0
        out.peak_time[i] = transmitted.largest_time[i]


def raise_joint_force_peaks(d):
    """Raise the stored largest joint forces to those in the last step, where these are larger.

    Two maxima of |f|² [N²] are stored: for each joint since the start of the run
    (``transmitted.peak_square``, with its time), and for each active contact since its onset, over all joints
    (``contacts.joint_square``, with the joint's number). The evaluations do not count as cost, because they
    serve outputs only. Afterwards points and forces are those at the end of the step.
    """
    transmitted, contacts, counts = d.transmitted, d.contacts, read_cost_counts(d)
    ensure_dense(d, OUTPUT_READER)
    search_step_for_peaks(d)
    for i in range(d.link_count):
        if transmitted.largest_square[i] > transmitted.peak_square[i]:
            set_joint_force_peak(d, i, transmitted.largest_square[i], transmitted.largest_time[i])
    for k in range(contacts.active_count):
        c = contacts.active_index[k]
        for i in range(first_joint(d), d.link_count):
            if transmitted.largest_square[i] > contacts.joint_square[c]:
                set_joint_square(d, c, transmitted.largest_square[i], i + 1)
    # the search has evaluated other times: set the forces, and what follows from them, to those at the end of
    # the step
    set_joint_forces_at(d, fraction_at_time(d, d.step.end))
    ensure_points(d)
    restore_cost_counts(d, counts)


def search_step_for_peaks(d):
    """Set ``transmitted.largest_square`` of each joint to its largest |f|² [N²] in the last step.

    The value raises two kinds of stored maxima: the joint's peak, and the largest |f|² of each active
    contact. If |f|² of the joint stays below all of these maxima in the step, the value is the least of the
    maxima instead, and raises none.
    """
    transmitted, least_square = d.transmitted, math.inf
    for k in range(d.contacts.active_count):
        least_square = min(least_square, d.contacts.joint_square[d.contacts.active_index[k]])
    for i in range(d.link_count):
        transmitted.largest_square[i] = min(transmitted.peak_square[i], least_square)
    search_peaks(d, d.step.end, time_of_peak(d, d.step.end, d.step.end))


def search_peaks(d, time, peak_at_end):
    """Raise ``transmitted.largest_square`` to the largest |f|² [N²] in the last step until ``time`` [s].

    Where ``largest_square`` rises, ``transmitted.largest_time`` becomes the time [s] of this |f|², or
    ``peak_at_end`` if this is the |f|² at ``time``. ``time`` and ``peak_at_end`` are equal, but may differ in
    their derivatives.
    """
    transmitted, first, end = d.transmitted, event_fraction(d), fraction_at_time(d, time)
    intervals = IMPLICIT_PEAK_INTERVALS if was_implicit(d) else PEAK_INTERVALS
    for m in range(intervals + 1):
        theta = first + (end - first) * m / intervals
        set_joint_forces_at(d, theta)
        sampled_at = peak_at_end if m == intervals else time_of_peak(d, time_of_joint_forces(d), theta)
        for i in range(d.link_count):
            transmitted.square_after[i] = square_of_force(d, i)
        for i in range(d.link_count):
            left = transmitted.square_before[i]
            top = transmitted.square_middle[i]
            right = transmitted.square_after[i]
            transmitted.square_before[i], transmitted.square_middle[i] = top, right
            raise_largest(d, i, right, sampled_at)
            if m >= 2 and rises_between(left, top, right, transmitted.largest_square[i]):
                middle, reach = first + (end - first) * (m - 1) / intervals, (end - first) / intervals
                # ``find_largest_square`` also stores the largest of its samples in ``largest_square``, with
                # its time. Its result, the summit of a parabola, exceeds this sample by about
                # round-off, so the time stays.
                largest = find_largest_square(d, i, middle, reach, end)
                transmitted.largest_square[i] = max(transmitted.largest_square[i], largest)


@has_dual_rule
def time_of_peak(_d, time, _fraction_or_time):
    """Return the ``time`` [s] of a peak; ``_fraction_or_time`` is where in the last step the peak lies.

    In a tangent instance, the time has derivatives if the fraction or time has any: at an event and at the
    maximum of a parabola. Otherwise the derivatives are NaN: the peak shifts, but a sample of it does not.
    """
    return time


def time_of_joint_forces(d):
    """Return the time [s] of the forces in ``transmitted.x`` and ``.y``, after ``set_joint_forces_at``."""
    return d.step.start + d.scratch.state[time_at(d.link_count)]


def raise_largest(d, i, square, time):
    """Raise ``transmitted.largest_square`` of the joint in row i to ``square`` [N²], if this is larger.

    ``time`` [s] then becomes ``transmitted.largest_time``, the time of this square.
    """
    if square > d.transmitted.largest_square[i]:
        d.transmitted.largest_square[i], d.transmitted.largest_time[i] = square, time


def rises_between(left, top, right, highest):
    """Return whether a quantity with three equidistant samples may exceed ``highest`` between them.

    The result is true if the parabola through the samples ``left``, ``top`` and ``right`` has a maximum
    between the outer samples that exceeds NEAR_PEAK times ``highest``.
    """
    slope_fall = 2.0 * top - left - right
    # the parabola through the samples has no maximum between the outer samples
    if slope_fall <= 0.0 or abs(right - left) > 2.0 * slope_fall:
        return False
    return top + (right - left) * (right - left) / (8.0 * slope_fall) > NEAR_PEAK * highest


def set_joint_forces_at(d, theta):
    """Set ``transmitted.x`` and ``.y`` to the forces in the joints at the fraction θ of the last step.

    Afterwards the points are located and accelerated there.
    """
    y, rate = d.scratch.state, d.scratch.rate
    interpolate_state(d.step, theta, y)
    locate_points(d, y)
    rate_from_points(d, y, rate)
    correct_near_fold(d, theta, y, rate)
    accelerate_points(d, y, rate)
    set_joint_forces(d, d.contacts.force, d.friction_element.force, d.transmitted.x, d.transmitted.y)


def square_of_force(d, i):
    """Return |f|² [N²] of the joint in row i, from the last computed forces in ``transmitted``."""
    return d.transmitted.x[i] * d.transmitted.x[i] + d.transmitted.y[i] * d.transmitted.y[i]


def square_at(d, i, theta):
    """Return |f|² [N²] of the joint in row i at the fraction θ of the last step.

    If ``transmitted.largest_square`` of the joint is smaller than the result, the result and its time are
    stored in ``largest_square`` and ``largest_time``.
    """
    set_joint_forces_at(d, theta)
    square = square_of_force(d, i)
    raise_largest(d, i, square, time_of_peak(d, time_of_joint_forces(d), theta))
    return square


find_largest_square = maximum_of(square_at)

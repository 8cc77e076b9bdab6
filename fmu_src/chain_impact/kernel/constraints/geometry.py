"""Geometry of contact: at which places and in which directions points touch walls, and joints stops.

A candidate is a pair of a point and a wall, a stop in a joint, or a stop of the slider. Every wall is a
half-plane, with a normal n of length 1 toward the free side, and n·p = offset for the points p on the edge.
The clearance g of a point at p is positive while point and wall are apart:

    g = n·p − offset − radius,   ġ = n·ṗ − w,   g̈ = n·p̈ − ẇ,

with the present offset, speed w and acceleration ẇ of a wall that moves along n (chain/prescribed_motion.py).
A wall at rest has w = ẇ = 0. The tangential motion is relative to the wall's belt.

The normals are computed once, at initialization, so that the code in loops has no branch on the kind of wall.

A row is a place (chain/kinematics.py) and a direction (n_x, n_y) at this place: the normal of a contact or
stop, the tangent along which dry friction acts, or a joint's own angle. J of a row maps the vectors of all
places to the component along this direction of the vector at this place. The functions of this module return
g, ġ, g̈ and the tangential motion relative to a moving wall and its belt.

A stop limits a joint's own angle ψ_i = θ_i − θ_{i−1}. The joint has its own place at x = s ψ_i, with the
longest link s as a lever arm (chain/kinematics.py), and the stop is a wall for this place. So lengths,
speeds, forces and masses of stops have the same units and scales as at walls, and a force F has the moment
±s F.
"""

from chain_impact.kernel.chain.drives import (
    armature_of_drive,
    coordinate_sum_of_drive,
    is_slider,
    joints_resist,
    length_per_coordinate,
)
from chain_impact.kernel.chain.kinematics import clear_joints, clear_vectors, largest_component, set_polar
from chain_impact.kernel.chain.prescribed_motion import fastest_wall
from chain_impact.kernel.chain.sites import joint_place, site_of_point, site_place
from chain_impact.kernel.chain.slider import slider_component
from chain_impact.kernel.record.constants import WALLS

# [m] the largest depth in a wall at which a point, or the base, may start a run: a point that touches
# the wall may have this depth by round-off of positions and sines
ALLOWED_OVERLAP = 1e-12
BOX_NORMALS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""The components x and y of the normals of the box's walls, to the inside, in the order of WALLS."""
STOP_CODES = {"joint_min": 1, "joint_max": -1, "slider_min": 2, "slider_max": -2}
"""Name of a stop → its value of candidate.stop, whose sign is that of the stop's normal (``stop_sign``)."""
JOINT_MIN, JOINT_MAX, SLIDER_MIN, SLIDER_MAX = STOP_CODES.values()
STOP_COUNT = len(STOP_CODES)
AT_WALL = 0  # value of candidate.stop for a candidate at a wall, not at a stop


def set_candidate_rows(d):
    """Set the place and radius of each candidate, and the normal and offset of its wall or stop."""
    for c in range(d.candidate_count):
        wall, point = d.candidate.wall[c], d.candidate.point[c]
        d.candidate.place[c], d.candidate.radius[c] = point, d.contact_settings.radius
        if point > d.link_count:
            s = site_of_point(d, point)
            d.candidate.place[c], d.candidate.radius[c] = site_place(d, s), d.site.radius[s]
        if is_at_stop(d, c):
            set_stop(d, c)
        elif wall < len(WALLS):
            set_box_wall(d, c, wall)
        else:
            set_sloped_wall(d, c, wall - len(WALLS))
        d.wall_motion.unmoved_offset[c] = d.candidate.offset[c]


def set_box_wall(d, c, wall):
    """Set the normal and the offset of candidate c at a ``wall`` of the box, an index in WALLS."""
    candidate = d.candidate
    nx, ny = BOX_NORMALS[wall]
    candidate.normal_x[c], candidate.normal_y[c] = nx, ny
    # the normal has a single component: either nx or ny is 0
    candidate.offset[c] = (nx + ny) * d.chain.box_wall[wall]


def set_sloped_wall(d, c, w):
    """Set the normal and the offset of candidate c, whose wall has the index w in `walls`."""
    candidate, walls = d.candidate, d.walls
    candidate.offset[c] = 1.0
    cosine, sine = candidate.normal_y[c : c + 1], candidate.normal_x[c : c + 1]
    set_polar(candidate.offset[c : c + 1], walls.angle, w, cosine, sine)
    # n = (−sin φ, cos φ) is to the left of the wall's direction (cos φ, sin φ)
    candidate.normal_x[c] = -candidate.normal_x[c]
    candidate.offset[c] = candidate.normal_x[c] * walls.x[w] + candidate.normal_y[c] * walls.y[w]


def set_stop(d, c):
    """Set the row, the offset and the radius of candidate c, a stop of a joint or of the slider.

    The base touches the slider's stops. A joint's stop is at the place of the joint. The radius is 0.
    """
    candidate = d.candidate
    sign = stop_sign(d, c)
    i = d.candidate.point[c] - 1 if is_at_joint_stop(d, c) else d.link_count
    candidate.place[c], x, y = row_of_drive(d, i)
    # a sum with 0.0 is never −0.0, which outputs would print
    candidate.normal_x[c], candidate.normal_y[c] = sign * x + 0.0, sign * y + 0.0
    limit = lever_of_candidate(d, c) * (d.drive.min[i] if sign > 0.0 else d.drive.max[i])
    if not is_at_joint_stop(d, c):
        limit += slider_component(d, d.initial.position[0], d.initial.position[1])
    candidate.offset[c], candidate.radius[c] = sign * limit, 0.0


def is_at_wall(d, c):
    """Return whether candidate c is at a wall, not at a stop of a joint or of the slider."""
    return d.candidate.stop[c] == AT_WALL


def is_at_stop(d, c):
    """Return whether candidate c is a stop of a joint or of the slider."""
    return d.candidate.stop[c] != AT_WALL


def is_at_joint_stop(d, c):
    """Return whether candidate c is a stop of a joint."""
    return d.candidate.stop[c] == JOINT_MIN or d.candidate.stop[c] == JOINT_MAX


def stop_sign(d, c):
    """Return the sign of the normal at a stop of a joint or slider: 1.0 at the lower, −1.0 at the upper."""
    return 1.0 if d.candidate.stop[c] > AT_WALL else -1.0


def joint_stop_moment(d, c, force):
    """Return the moment [N·m] on the link farther from the base by the ``force`` [N] of a joint's stop.

    For an impulse [N·s] the result is the angular impulse [N·m·s]. The result has the sign of ``force`` at
    the lower limit of the joint's angle, and the opposite sign at the upper limit.
    """
    return stop_sign(d, c) * lever_of_candidate(d, c) * force


def first_stop(d, c):
    """Return the index of the lower stop of the joint whose upper stop is candidate c.

    If the joint has no lower stop, or c is any other candidate, the result is c.
    """
    candidate = d.candidate
    is_upper = (
        c > 0
        and candidate.stop[c] == JOINT_MAX
        and candidate.stop[c - 1] == JOINT_MIN
        and candidate.point[c - 1] == candidate.point[c]
    )
    return c - 1 if is_upper else c


def is_candidate_sound(d, c):
    """Return whether the stop, point, place and wall of candidate c exist in this record.

    A record from outside may contain any numbers.
    """
    # the numbers of joints begin at 1; the numbers of stops follow the numbers of the walls
    first_point, last_point = (
        (1, d.link_count) if is_at_joint_stop(d, c) else (0, d.link_count + d.site_count)
    )
    last_wall = len(WALLS) + d.candidate_count - 1
    if is_at_stop(d, c):
        last_wall += STOP_COUNT
    return (
        SLIDER_MAX <= d.candidate.stop[c] <= SLIDER_MIN
        and first_point <= d.candidate.point[c] <= last_point
        and 0 <= d.candidate.place[c] < site_place(d, d.site_count)
        and 0 <= d.candidate.wall[c] <= last_wall
    )


def normal_row(d, c):
    """Return the row of candidate c along the normal n of its wall or stop: the place, n_x and n_y."""
    return d.candidate.place[c], d.candidate.normal_x[c], d.candidate.normal_y[c]


def tangent_row(d, e):
    """Return the row of element e in the direction t, along which dry friction acts.

    At a wall t = (n_y, −n_x), with the normal n. The elements after the candidates are the joints, then the
    slider; their rows are along their coordinates.
    """
    if e < d.candidate_count:
        return d.candidate.place[e], d.candidate.normal_y[e], -d.candidate.normal_x[e]
    return row_of_drive(d, e - d.candidate_count)


def row_of_drive(d, i):
    """Return the row along the coordinate of drive i: the base along the slider's line, or a joint's place.

    The coordinate x of a joint's place is the joint's angle times the longest link s; a force F at this place
    is the moment s F.
    """
    if is_slider(d, i):
        return 0, d.slider.ux, d.slider.uy
    return joint_place(d, i), 1.0, 0.0


def constraint_count(d):
    """Return the number of constraints: the active contacts plus the sticking elements."""
    return d.contacts.active_count + d.friction.stuck_count


def has_sticking(d):
    """Return whether any element sticks by dry friction."""
    return d.friction.stuck_count > 0


def constraint_row(d, k):
    """Return the row of constraint k: the normal of an active contact, or the tangent of a sticking element.

    The constraints are numbered: first the active contacts, then the sticking elements.
    """
    if k < d.contacts.active_count:
        return normal_row(d, d.contacts.active_index[k])
    return tangent_row(d, d.friction_element.stuck_index[k - d.contacts.active_count])


def dot(row, vectors):
    """Return J v of a row: the component, along the row, of the vectors v of all places."""
    place, nx, ny = row
    return nx * vectors.x[place] + ny * vectors.y[place]


def add_along_row(row, vectors, amount):
    """Add a force or impulse ``amount`` along a row to the vector of the row's place in ``vectors``."""
    place, nx, ny = row
    vectors.x[place] += nx * amount
    vectors.y[place] += ny * amount


def add_impedance(row, impedance, amount):
    """Add ``amount`` [kg], a mass that resists motion along a row, to the ``impedance`` of the row's place.

    The impedance of each place is a symmetric 2×2 matrix.
    """
    place, nx, ny = row
    impedance.xx[place] += nx * nx * amount
    impedance.xy[place] += nx * ny * amount
    impedance.yy[place] += ny * ny * amount


def clearance_and_rate(d, c):
    """Return clearance g [m] and ġ [m/s] of c at located points; at a joint's stop g is angle × lever arm."""
    row = normal_row(d, c)
    clearance = dot(row, d.scratch.position) - d.candidate.offset[c] - d.candidate.radius[c]
    clearance_rate = dot(row, d.scratch.velocity)
    if d.channel_count > 0:
        clearance_rate -= d.wall_motion.velocity[c]
    return clearance, clearance_rate


def clearance_acceleration(d, c):
    """Return g̈ [m/s²], the second derivative of candidate c's clearance, from the accelerated points."""
    acceleration = dot(normal_row(d, c), d.scratch.acceleration)
    if d.channel_count > 0:
        acceleration -= d.wall_motion.acceleration[c]
    return acceleration


def may_have_belt(d, e):
    """Return False if no belt can move at element e: no motion is prescribed, or e is at no wall."""
    return d.channel_count > 0 and e < d.candidate_count


def tangential_position(d, e):
    """Return the coordinate [m] of element e along t, at a wall relative to the belt, at located points."""
    coordinate = dot(tangent_row(d, e), d.scratch.position)
    return coordinate - d.wall_motion.travel[e] if may_have_belt(d, e) else coordinate


def tangential_rate(d, e):
    """Return the speed [m/s] of element e along t, at a wall relative to the belt, at located points."""
    speed = dot(tangent_row(d, e), d.scratch.velocity)
    return speed - d.wall_motion.belt_velocity[e] if may_have_belt(d, e) else speed


def tangential_acceleration(d, e):
    """Return the acceleration [m/s²] of e along t, at a wall relative to the belt, at accelerated points."""
    a = dot(tangent_row(d, e), d.scratch.acceleration)
    return a - d.wall_motion.belt_acceleration[e] if may_have_belt(d, e) else a


def constraint_acceleration(d, k):
    """Return the acceleration [m/s²] of constraint k, relative to wall or belt, at accelerated points."""
    if k < d.contacts.active_count:
        return clearance_acceleration(d, d.contacts.active_index[k])
    return tangential_acceleration(d, d.friction_element.stuck_index[k - d.contacts.active_count])


def add_forces_at_joint_places(d, applied_force):
    """Add the moment of the applied force at each joint's place to the moment in this joint.

    The place of a joint is no point of the chain: its coordinate x is the joint's angle times a lever arm,
    the longest link, so a force at the place is a moment at this lever arm.
    """
    if d.chain.has_joint_places:
        for i in range(d.link_count):
            applied_force.joint[i] += d.chain.longest_link * applied_force.x[joint_place(d, i)]


def add_joint_impedances(d, impedance):
    """Add to each joint's impedance its rotor's inertia, and the impedance at its place × lever arm²."""
    if d.chain.has_joint_places or d.chain.has_armatures:
        square = d.chain.longest_link * d.chain.longest_link
        for i in range(d.link_count):
            impedance.joint[i] += armature_of_drive(d, i)
            if d.chain.has_joint_places:
                impedance.joint[i] += square * impedance.xx[joint_place(d, i)]


def clear_used_forces(d, applied_force):
    """Set ``applied_force`` to zero at all places in use and, if ``joints_resist`` is true, in joints."""
    clear_vectors(d, applied_force)
    if joints_resist(d):
        clear_joints(applied_force)


def largest_velocity(d):
    """Return the largest |component| [m/s] of the velocities of all places, moving walls and belts."""
    largest = largest_component(d, d.scratch.velocity)
    if d.channel_count > 0:
        speed, _ = fastest_wall(d)
        largest = max(largest, speed)
    return largest


def largest_coordinate(d):
    """Return the largest |coordinate| [m] of any place, but at least the longest link.

    This is the scale of the round-off of positions.
    """
    return max(d.chain.longest_link, largest_component(d, d.scratch.position))


def largest_acceleration(d):
    """Return the largest |component| [m/s²] of the accelerations of all places, moving walls and belts."""
    largest = largest_component(d, d.scratch.acceleration)
    if d.channel_count > 0:
        _, acceleration = fastest_wall(d)
        largest = max(largest, acceleration)
    return largest


def length_bound(d, vectors):
    """Return an upper bound of the lengths of the velocities or accelerations at places with clearances.

    Points and sites have clearances; so do joints, if any joint has a stop. ``vectors`` belong to all places.
    """
    bound = 0.0
    for k in range(d.link_count + 1):
        bound = max(bound, abs(vectors.x[k]) + abs(vectors.y[k]))
    if d.chain.has_joint_stops:
        for k in range(joint_place(d, 0), joint_place(d, d.link_count)):
            bound = max(bound, abs(vectors.x[k]))
    for k in range(site_place(d, 0), site_place(d, d.site_count)):
        bound = max(bound, abs(vectors.x[k]) + abs(vectors.y[k]))
    return bound


def coordinate_sum(d, c, y):
    """Return the sum [m] of the absolute values of the coordinates that determine candidate c's clearance.

    At a joint's stop these are angles times the lever arm. The clearance's round-off is relative to the sum.
    """
    point = d.candidate.point[c]
    if is_at_joint_stop(d, c):
        return d.chain.longest_link * coordinate_sum_of_drive(d, y, point - 1)
    place = d.candidate.place[c]
    return abs(d.scratch.position.x[place]) + abs(d.scratch.position.y[place])


def link_of(d, c):
    """Return the index, from 0, of the link on which the wall of candidate c acts; c is not a joint's stop.

    This link ends at the candidate's point, or carries the candidate's site; for the base it is link 0.
    """
    point = d.candidate.point[c]
    return max(point, 1) - 1 if point <= d.link_count else d.site.link[site_of_point(d, point)]


def lever_of_candidate(d, c):
    """Return the clearance [m] per angle [rad] of a joint's stop, its lever arm; 1 for other candidates."""
    return length_per_coordinate(d, d.candidate.point[c] - 1) if is_at_joint_stop(d, c) else 1.0

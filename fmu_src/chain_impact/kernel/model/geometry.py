"""Geometry of contact: the only module that depends on what touches.

A candidate is a pair of a point and a wall, or a stop in a joint. Every wall is a half-plane, with an inward
normal n of length 1 and n·p = offset for the points p on it. The clearance of a point is positive when apart:

    g = n·p − offset − radius,   ġ = n·ṗ,   g̈ = n·p̈.

The normals are computed once, at initialization, so that the code in loops has no branch on the kind of wall.

A stop limits a joint's own angle ψ_i = θ_i − θ_{i−1}. For the kernel it is a contact at a lever arm, the
longest link s: its lengths, speeds, forces and masses have the units and the scales of those at walls.

    g = s (ψ − joint_min)  or  s (joint_max − ψ),   ġ = ±s ψ̇,   a force F has the moment ±s F in the joint.
"""

from chain_impact.kernel.chain.kinematics import move_points, turn_joints, zero
from chain_impact.kernel.chain.sincos import polar
from chain_impact.kernel.chain.state import ANGLES

# Of a link length: how deep a point may be in a wall without being in contact. Its force would be K δⁿ, 1e-10
# N for K = 1e8; and the round-off of positions is some 1e-15. Without it, every step of a point that slides
# along a wall at zero clearance would be searched for an onset.
HARMLESS = 1e-12

WALLS = ("x_min", "x_max", "y_min", "y_max")
"""The walls of the box in the order of their numbers, from 0. After them come those at any angle."""


NORMALS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Their inward normals."""


def place_walls(d):
    """Compute the normal and the offset of each candidate's wall, and the arm of each stop."""
    for c in range(d.candidates):
        wall = d.candidate.wall[c]
        if d.candidate.stop[c] != 0:
            place_stop(d, c)
        elif wall < len(WALLS):
            place_side(d, c, wall)
        else:
            place_slope(d, c, wall - len(WALLS))


def place_side(d, c, side):
    """Set the normal and the offset of candidate c at a side of the box."""
    own = d.candidate
    nx, ny = NORMALS[side]
    own.normal_x[c], own.normal_y[c] = nx, ny
    # nx or ny is 0
    own.offset[c] = (nx + ny) * d.model.wall[side]


def place_slope(d, c, w):
    """Set the normal and the offset of candidate c at the w-th of the walls at any angle."""
    own, walls = d.candidate, d.walls
    own.offset[c] = 1.0
    polar(own.offset[c : c + 1], walls.angle, w, own.normal_y[c : c + 1], own.normal_x[c : c + 1])
    # n = (−sin φ, cos φ) is to the left of the wall's direction (cos φ, sin φ)
    own.normal_x[c] = -own.normal_x[c]
    own.offset[c] = own.normal_x[c] * walls.x[w] + own.normal_y[c] * walls.y[w]


def place_stop(d, c):
    """Set the lever arm and the angle of candidate c, a stop."""
    own, link = d.candidate, d.candidate.point[c] - 1
    if own.stop[c] > 0:
        own.arm[c], own.offset[c] = d.model.size, d.model.joint_min[link]
    else:
        own.arm[c], own.offset[c] = -d.model.size, d.model.joint_max[link]


def clearance(d, c):
    """Clearance g [m] and its rate ġ [m/s] of candidate c, from the located points."""
    own, point = d.candidate, d.candidate.point[c]
    if own.stop[c] != 0:
        return own.arm[c] * (d.work.position.turn[point] - own.offset[c]), along_normal(d, c, d.work.velocity)
    gap = along_normal(d, c, d.work.position) - d.candidate.offset[c] - d.contact.radius
    return gap, along_normal(d, c, d.work.velocity)


def along_normal(d, c, vectors):
    """n·v of candidate c for the vectors v of all points: J v for motions v."""
    point = d.candidate.point[c]
    if d.candidate.stop[c] != 0:
        return d.candidate.arm[c] * vectors.turn[point]
    return d.candidate.normal_x[c] * vectors.x[point] + d.candidate.normal_y[c] * vectors.y[point]


def add_along_normal(d, c, vectors, amount):
    """Add ``amount`` times n to the vector of the point of candidate c: Jᵀ F for a force F."""
    point = d.candidate.point[c]
    if d.candidate.stop[c] != 0:
        vectors.turn[point] += d.candidate.arm[c] * amount
        return
    vectors.x[point] += d.candidate.normal_x[c] * amount
    vectors.y[point] += d.candidate.normal_y[c] * amount


def add_impedance(d, c, impedance, amount):
    """Add ``amount`` [kg] times n nᵀ to the impedance at the point of candidate c: Jᵀ D J."""
    point, nx, ny = d.candidate.point[c], d.candidate.normal_x[c], d.candidate.normal_y[c]
    if d.candidate.stop[c] != 0:
        impedance.turn[point] += d.candidate.arm[c] * d.candidate.arm[c] * amount
        return
    impedance.xx[point] += nx * nx * amount
    impedance.xy[point] += nx * ny * amount
    impedance.yy[point] += ny * ny * amount


def clear_loads_of(d, load):
    """Set the loads on all points, and the moments in all joints, to zero."""
    zero(load)
    if d.model.stopped or d.model.resisting:
        for i in range(len(load.turn)):
            load.turn[i] = 0.0


def move_contacts(d, links, change, motion):
    """Motion of points and joints that follows from a change of the coordinates, for the link vectors."""
    move_points(links, change, motion)
    if d.model.stopped:
        turn_joints(d.links, change, ANGLES, motion.turn)


def speed_bound(d, vectors):
    """A bound on |n·v| of all candidates for the vectors v of all points."""
    most = 0.0
    for k in range(len(vectors.x)):
        most = max(most, abs(vectors.x[k]) + abs(vectors.y[k]))
    if d.model.stopped:
        for i in range(1, len(vectors.turn)):
            most = max(most, d.model.size * abs(vectors.turn[i]))
    return most


def coordinates_size(d, c, y):
    """The sum of the sizes [m] of the coordinates whose round-off g of candidate c has, at located points."""
    point = d.candidate.point[c]
    if d.candidate.stop[c] != 0:
        before = abs(y[ANGLES + point - 2]) if point > 1 else 0.0
        return d.model.size * (abs(y[ANGLES + point - 1]) + before)
    return abs(d.work.position.x[point]) + abs(d.work.position.y[point])


def lever(d, c):
    """The length [m] by which speeds, forces and masses of candidate c are those of an angle; of a wall 1."""
    return d.model.size if d.candidate.stop[c] != 0 else 1.0


def harmless_depth(d, c):
    """How deep [m] a point may be in a wall without being in contact; 0 for a rigid wall."""
    return 0.0 if d.law.impulsive[c] else HARMLESS * d.model.size

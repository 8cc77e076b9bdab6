"""Geometry of contact: the only module that depends on the shape of a wall.

A candidate is a pair of a point and a wall. Every wall is a half-plane, with an inward normal n of length 1
and n·p = offset for the points p on it. The clearance of a point is positive when apart:

    g = n·p − offset − radius,   ġ = n·ṗ,   g̈ = n·p̈.

The normals are computed once, at initialization, so that the code in loops has no branch on the kind of wall.
"""

from chain_impact.kernel.chain.sincos import polar

# Of a link length: how deep a point may be in a wall without being in contact. Its force would be K δⁿ, 1e-10
# N for K = 1e8; and the round-off of positions is some 1e-15. Without it, every step of a point that slides
# along a wall at zero clearance would be searched for an onset.
HARMLESS = 1e-12

WALLS = ("x_min", "x_max", "y_min", "y_max")
"""The walls of the box in the order of their numbers, from 0. After them come those at any angle."""


NORMALS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Their inward normals."""


def place_walls(d):
    """Compute the normal and the offset [m] of each candidate's wall from the parameters."""
    for c in range(d.candidates):
        wall = d.candidate.wall[c]
        if wall < len(WALLS):
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


def clearance(d, c):
    """Clearance g [m] and its rate ġ [m/s] of candidate c, from the located points."""
    gap = along_normal(d, c, d.work.position) - d.candidate.offset[c] - d.contact.radius
    return gap, along_normal(d, c, d.work.velocity)


def normal(d, c):
    """The components of the normal n of candidate c."""
    return d.candidate.normal_x[c], d.candidate.normal_y[c]


def along_normal(d, c, vectors):
    """n·v of candidate c for the vectors v of all points."""
    point = d.candidate.point[c]
    return d.candidate.normal_x[c] * vectors.x[point] + d.candidate.normal_y[c] * vectors.y[point]


def add_along_normal(d, c, vectors, amount):
    """Add ``amount`` times n to the vector of the point of candidate c."""
    point = d.candidate.point[c]
    vectors.x[point] += d.candidate.normal_x[c] * amount
    vectors.y[point] += d.candidate.normal_y[c] * amount


def add_impedance(d, c, impedance, amount):
    """Add ``amount`` [kg] times n nᵀ to the impedance at the point of candidate c."""
    point, nx, ny = d.candidate.point[c], d.candidate.normal_x[c], d.candidate.normal_y[c]
    impedance.xx[point] += nx * nx * amount
    impedance.xy[point] += nx * ny * amount
    impedance.yy[point] += ny * ny * amount


def lever(d, c):
    """The length [m] by which speeds, forces and masses of candidate c are those of an angle; of a wall 1."""
    return d.model.size if d.candidate.stop[c] != 0 else 1.0


def harmless_depth(d, c):
    """How deep [m] a point may be in a wall without being in contact; 0 for a rigid wall."""
    return 0.0 if d.law.impulsive[c] else HARMLESS * d.model.size

"""Geometry of contact: the clearances of points to walls. Nothing else knows what a wall is.

A candidate is a pair of a point and a wall. Its clearance g is positive when apart.
"""

HARMLESS = 1e-12  # of a link length, how deep a point touches a wall without a force that counts

WALLS = ("x_min", "x_max", "y_min", "y_max")
"""The walls in the order of their numbers, from 0."""


def clearance(d, c):
    """Clearance g [m] and its rate ġ [m/s] of candidate c, from the located points."""
    wall = d.candidate.wall[c]
    position = across_wall(d, c, d.work.position)
    gap = inward(wall) * (position - d.model.wall[wall]) - d.contact.radius
    return gap, along_normal(d, c, d.work.velocity)


def inward(wall):
    """Sign of the inward normal of a wall along its axis: +1 for x_min and y_min, −1 for the others."""
    return 1.0 - 2.0 * (wall % 2)


def across_wall(d, c, vectors):
    """Of the vectors of all points, the component for candidate c along the axis that its wall stands on."""
    point = d.candidate.point[c]
    return vectors.x[point] if d.candidate.wall[c] < 2 else vectors.y[point]


def add_across_wall(d, c, vectors, amount):
    """Add to that component."""
    point = d.candidate.point[c]
    if d.candidate.wall[c] < 2:
        vectors.x[point] += amount
    else:
        vectors.y[point] += amount


def add_along_normal(d, c, vectors, amount):
    """Add to that component an amount along the inward normal."""
    add_across_wall(d, c, vectors, inward(d.candidate.wall[c]) * amount)


def along_normal(d, c, vectors):
    """The component along the inward normal of candidate c of the vectors of all points."""
    return inward(d.candidate.wall[c]) * across_wall(d, c, vectors)


def harmless_depth(d):
    """How deep [m] a point that is apart may be in a wall; 0 in a rigid one."""
    return 0.0 if d.contact.impulsive else HARMLESS * d.model.size


def bound_along_normal(d, c, bounds):
    """A bound on the component along the normal, from bounds on both components of all vectors."""
    return across_wall(d, c, bounds)

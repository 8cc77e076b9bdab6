"""A check that the mass matrix is regular in every position, so that the recursion never divides by zero.

It is singular where the chain can move without kinetic energy: no centre of mass moves, and no link turns
that has an inertia. A link without inertia can turn about its centre of mass. That moves its proximal joint,
unless the centre of mass lies there, and its distal one, unless it lies there. A joint that moves turns the
next link, which must be without inertia, too, and about its own centre of mass, which is possible while both
links are on one line. So the motion continues along a sequence of links without inertia. It begins at a link
whose proximal joint is the free base or its centre of mass, and it ends at a link whose distal joint is the
tip or its centre of mass. If no sequence has such a beginning and such an end, every pivot of the recursion
is positive: they are those of the elimination of a positive definite matrix.
"""

# Of a link's length: a centre of mass nearer to a joint than this counts as lying there. The inertia of the
# link about the joint, proportional to the square of this distance, is then no more than round-off.
NEAR = 1e-8


def loose_links(chain):
    """The first and the last link that can move without kinetic energy in some position; −1, −1 for none.

    Args:
        chain: record with ``length`` [m], ``center_of_mass`` [m] and ``inertia`` [kg·m²] of each link, and
            ``pinned``.
    """
    begin, count = -1, len(chain.length)
    for i in range(count):
        near = NEAR * chain.length[i]
        if chain.inertia[i] > 0.0:
            begin = -1
            continue
        if chain.center_of_mass[i] <= near or (i == 0 and not chain.pinned):
            begin = i
        if begin >= 0 and (i == count - 1 or abs(chain.length[i] - chain.center_of_mass[i]) <= near):
            return begin, i
    return -1, -1

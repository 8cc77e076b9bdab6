"""The inertia of a link where it is not given, and a check that the mass matrix is regular in every position.

A scene derives some values from others, such as the inertia, as it is read, and they stay derived: whoever
changes a length changes the centre of mass and the inertia with it. So the record has a place for what is
given, which holds DERIVED where nothing is, and a place for the value in use. The kernel fills the latter: at
initialization, or, of a value that can be set at any time, when such values are applied. ``Chain.set`` and
FMUs write a value that is set into both places, for example into ``given_inertia`` and ``inertia``: it is
given from then on, and can be read at once. Sweeps and the page write only the place for what is given, as
they read nothing before the run. So a changed parameter gives what the edited scene file gives, and a tangent
instance has the derivatives through what is derived.

The recursion never divides by zero if the mass matrix is regular. It is singular where the chain can move
without kinetic energy: no centre of mass moves, and no link turns that has an inertia. A link without inertia
can turn about its centre of mass. That moves its proximal joint, unless the centre of mass lies there, and
its distal one, unless it lies there. A joint that moves turns the next link, which must be without inertia,
too, and about its own centre of mass, which is possible while both links are on one line. So the motion
continues along a sequence of links without inertia. It begins at a link whose proximal joint is the free base
or its centre of mass, and it ends at a link whose distal joint is the tip or its centre of mass. If no
sequence has such a beginning and such an end, every pivot of the recursion is positive: they are those of the
elimination of a positive definite matrix.
"""

DERIVED = -1.7976931348623157e308
"""In the place of a given value: there is none. It is the lowest number, which no link can have."""


def in_use(given, derived):
    """The given value, or the derived one if none is given.

    The difference is 0 then. In a tangent instance it has the derivatives with respect to the value itself.
    """
    return derived + (given - DERIVED) if given == DERIVED else given


def middle(length):
    """The centre of mass of a uniform rod of some length [m], from its end [m]."""
    return length / 2


def inertia_of_box(mass, length, height):
    """The inertia [kg·m²] of a uniform rectangle about its centre of mass; with the height 0, of a thin rod.

    Args:
        mass: in kg.
        length: in m.
        height: in m.
    """
    # m (ℓ² + h²) / 12
    return mass * length * length / 12 + mass * height * height / 12


def corner_of_box(number, length, height):
    """Where a corner of a box is, along the link and to the left of it [m].

    Args:
        number: of the corner: 1 and 2 lie to the right, 3 and 4 to the left, 1 and 3 at the proximal joint.
        length: of the box, along the link [m].
        height: of the box, across the link [m].
    """
    return length if number % 2 == 0 else 0.0 * length, -0.5 * height if number <= 2 else 0.5 * height


# The distance from a joint up to which a centre of mass counts as lying there, over the link's length. The
# inertia about the joint, proportional to its square, is then no more than round-off.
NEAR = 1e-8


def loose_links(chain, free_base):
    """The first and the last link that can move without kinetic energy in some position; −1, −1 for none.

    Args:
        chain: record with ``length`` [m], ``center_of_mass`` [m], ``center_of_mass_offset`` [m] and
            ``inertia`` [kg·m²] of each link, and ``pinned``.
        free_base: whether the base has no mass of its own although link 1 hangs in a joint there.
    """
    begin, count = -1, len(chain.length)
    for i in range(count):
        near = NEAR * chain.length[i]
        if chain.inertia[i] > 0.0:
            begin = -1
            continue
        beside = abs(chain.center_of_mass_offset[i]) > near
        at_proximal = abs(chain.center_of_mass[i]) <= near and not beside
        at_distal = abs(chain.length[i] - chain.center_of_mass[i]) <= near and not beside
        if at_proximal or (i == 0 and (free_base or not chain.pinned)):
            begin = i
        if begin >= 0 and (i == count - 1 or at_distal):
            return begin, i
    return -1, -1

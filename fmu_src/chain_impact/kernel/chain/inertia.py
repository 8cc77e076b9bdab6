"""Values of links that are derived if they are not given, and a check that the mass matrix is always regular.

Values that a scene does not give, such as the inertia, are derived from others, and stay derived: a change of
a length also changes the centre of mass and the inertia. So the record has a field for the given value,
which is NOT_GIVEN if no value is given, and a field for the value in use. The kernel sets the field in use at
initialization. If the value can be set at any time, the kernel also sets the field in use when new values are
applied. ``Chain.set`` and FMUs write a value into both fields, for example into ``given_inertia`` and
``inertia``, so that the new value can be read at once. Sweeps and the page write only the field of the given
value, because they read nothing before the run. So a changed parameter gives the same results as an edited
scene file, and a tangent instance has the derivatives of derived values.

The recursion never divides by zero if the mass matrix is regular. The mass matrix without armatures is
singular if the chain can move without kinetic energy: no mass moves, and no link with an inertia turns.
Armatures are left out, so that a chain is valid with any armatures. A link without inertia can turn about its
centre of mass. This rotation moves each joint of the link that does not coincide with the centre of mass. A
moving joint turns the next link, which must also be without inertia and rotate about its own centre of mass.
Both rotations are possible while both links are on one line. So the motion continues along a sequence of
links without inertia. The sequence begins at a link whose proximal joint coincides with the link's centre of
mass, or is a free base or a base on a carriage without mass. The sequence ends at a link whose distal joint
is the tip or coincides with the link's centre of mass. If the chain has no such sequence, every pivot of the
recursion is positive, as in the elimination of a positive definite matrix.
"""

from chain_impact.kernel.record.constants import NOT_GIVEN


def given_or_derived(given, derived):
    """Return the value ``given``, or ``derived`` if ``given`` is NOT_GIVEN.

    In the second case the term ``given − NOT_GIVEN`` is 0. In a tangent instance this term has the
    derivatives with respect to the value, as if the derived value had been given.
    """
    return derived + (given - NOT_GIVEN) if given == NOT_GIVEN else given


def middle_of_rod(length):
    """Return the distance [m] of the centre of mass of a uniform rod from its end; ``length`` is in m."""
    return length / 2


def inertia_of_box(mass, length, height):
    """Return the inertia [kg·m²] of a uniform rectangle about its centre of mass; height 0 gives a thin rod.

    Args:
        mass: in kg.
        length: in m.
        height: in m.
    """
    # m (ℓ² + h²) / 12 for the mass m, the length ℓ and the height h
    return mass * length * length / 12 + mass * height * height / 12


def corner_of_box(number, length, height):
    """Return the coordinates [m] of a corner of a box: along the link, and to the left of the link's line.

    Both are measured from the link's proximal joint.

    Args:
        number: the number of the corner: 1 and 2 lie to the right, 3 and 4 to the left, 1 and 3 at the
            proximal joint.
        length: the length of the box, along the link [m].
        height: the height of the box, across the link [m].
    """
    return length if number % 2 == 0 else 0.0 * length, -0.5 * height if number <= 2 else 0.5 * height


# The largest distance between a joint and a centre of mass, relative to the link's length, at which both
# count as one point. The inertia about the joint of a link whose own inertia is 0, its mass times the squared
# distance, is then only round-off.
SAME_POINT = 1e-8


def find_loose_links(chain, free_base):
    """Return the first and last link of a sequence that can, in some positions, move without kinetic energy.

    The links of the sequence have no inertia; the module's docstring tells where a sequence begins and ends.
    Links are counted from 0. The result is −1, −1 if no such sequence exists.

    Args:
        chain: record with ``length`` [m], ``center_of_mass`` [m], ``center_of_mass_offset`` [m] and
            ``inertia`` [kg·m²] of each link, and ``has_base_joint``.
        free_base: whether the first link hangs in a joint at a base that can slide and has no mass.
    """
    begin, count = -1, len(chain.length)
    for i in range(count):
        near_distance = SAME_POINT * chain.length[i]
        if chain.inertia[i] > 0.0:
            begin = -1
            continue
        is_beside = abs(chain.center_of_mass_offset[i]) > near_distance
        is_at_proximal = abs(chain.center_of_mass[i]) <= near_distance and not is_beside
        is_at_distal = abs(chain.length[i] - chain.center_of_mass[i]) <= near_distance and not is_beside
        if is_at_proximal or (i == 0 and (free_base or not chain.has_base_joint)):
            begin = i
        if begin >= 0 and (i == count - 1 or is_at_distal):
            return begin, i
    return -1, -1

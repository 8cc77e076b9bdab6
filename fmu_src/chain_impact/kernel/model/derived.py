"""Values that follow from others unless they are given, such as the inertia of a link.

A scene derives them as it is read, and they stay derived: whoever changes a length changes the centre of mass
and the inertia with it. So the record has a place for what is given, which holds DERIVED where nothing is,
and a place for the value in use. The kernel fills the latter: at initialization, or, of a value that can be
set at any time, when such values are applied. ``Chain.set`` and FMUs write a value that is set into both
places, for example into ``given_inertia`` and ``inertia``: it is given from then on, and can be read at once.
Sweeps and the page write only the place for what is given, as they read nothing before the run. So a changed
parameter gives what the edited scene file gives, and a tangent instance has the derivatives through what is
derived.
"""

DERIVED = -1.0
"""In the place of a given value, which is not negative: there is none."""


def in_use(given, derived):
    """The given value, or the derived one if none is given.

    The difference is 0 then. In a tangent instance it has the derivatives with respect to the value itself.
    """
    return derived + (given - DERIVED) if given == DERIVED else given


def middle(length):
    """The centre of mass of a uniform rod of some length [m], from its end [m]."""
    return length / 2


def inertia_of_rod(mass, length):
    """The inertia [kg·m²] of a uniform thin rod of some mass [kg] and length [m] about its centre of mass."""
    return mass * length * length / 12

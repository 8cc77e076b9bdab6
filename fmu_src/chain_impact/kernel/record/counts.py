"""The counts at the start of a record; sizes and offsets of all its parts depend on them."""

from typing import NamedTuple


class Counts(NamedTuple):
    """The counts, in their order in the record; comments in the kernel use the letters N, C, F, ….

    The table variables/owners.py has the rules for the counts of a scene, in Python and in a browser.
    """

    links: int  # N, number of links
    candidates: int  # C, number of candidates: pairs of a point or site and a wall, and stops
    # F, number of parts that may have dry friction: all candidates, joints and a slider; 0 in a scene without
    # dry friction
    elements: int = 0
    loads: int = 0  # L, number of joints plus number of walls if the scene requests loads, else 0
    channels: int = 0  # K, number of given motions of the base and of walls (chain/motion.py)
    sites: int = 0  # P, number of sites: points of links beside the joints (chain/sites.py)
    signals: int = 0  # D, number of inputs that signals of the scene drive (chain/signals.py)
    knots: int = 0  # R, number of knots: starts of the polynomials of signals


COUNTS = Counts._fields
FEATURES = ("skewed", "slides")
"""The fields of an instance that follow the counts: two flags, each of which is 0 or 1."""

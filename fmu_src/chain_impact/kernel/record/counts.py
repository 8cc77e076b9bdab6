"""The counts, such as the number of links, at the start of a record; all sizes and offsets depend on them."""

from typing import NamedTuple


class Counts(NamedTuple):
    """The counts, in their order in the record; comments in the kernel use the letters N, C, F and so on.

    variables/owners.py has the rules that give the counts of a scene, in Python and in a browser.
    """

    links: int  # N, number of links
    candidates: int  # C, number of candidates: pairs of a point or site and a wall, and stops
    # F, number of parts that may have dry friction: all candidates, joints and a slider; 0 in a scene without
    # dry friction
    elements: int = 0
    # L, rows of the outputs of loads: number of joints plus number of walls; 0 if no loads are requested
    loads: int = 0
    # K, number of prescribed motions (chain/motion.py): two for a moving base, and two for each moving wall
    channels: int = 0
    sites: int = 0  # P, number of sites: points of links other than their ends (chain/sites.py)
    signals: int = 0  # D, number of inputs and prescribed motions that signals drive (chain/signals.py)
    knots: int = 0  # R, number of knots of all signals: times at which polynomials of the signals begin


COUNTS = Counts._fields
FEATURES = ("skewed", "slides")
"""The fields that follow the counts in an instance: two flags, 0 or 1 (record/instance.py explains them)."""

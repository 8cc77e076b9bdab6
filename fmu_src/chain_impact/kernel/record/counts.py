"""The counts, such as the number of links, at a record's start; they determine the sizes of its arrays."""

from typing import NamedTuple


class Counts(NamedTuple):
    """The counts, in their order in the record; comments in the kernel use the letters N, C, F and so on.

    variables/owners.py has the rules that give the counts of a scene, in Python and in a browser.
    """

    link_count: int  # N, number of links
    candidate_count: int  # C, number of candidates: pairs of a point or site and a wall, and stops
    # F, number of elements, parts that may have dry friction: C candidates, N joints and, if present, the
    # slider; 0 in a scene without dry friction
    friction_element_count: int = 0
    # L, rows of the transmitted forces: N joints, then all walls; 0 if their outputs are not requested
    transmitted_row_count: int = 0
    # K, number of prescribed motions (chain/prescribed_motion.py): two for a moving base, and two for each
    # moving wall
    channel_count: int = 0
    site_count: int = 0  # P, number of sites: points of links other than the links' ends (chain/sites.py)
    signal_count: int = 0  # D, number of inputs and prescribed motions that signals drive (chain/signals.py)
    knot_count: int = 0  # R, number of knots of all signals: times at which polynomials of the signals begin


COUNTS = Counts._fields
LARGEST_COUNT = 2**20 - 1
"""The largest value of a count that compiled kernels allow; no scene has a count near it."""
FEATURES = ("skewed", "slides")
"""The two flags, 0 or 1, that follow the counts in an instance; record/instance.py says what they mean."""

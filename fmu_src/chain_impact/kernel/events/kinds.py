"""The kinds of event, as stored for each candidate in ``touch.event``. table.py describes them."""

NONE, ONSET, END, RELATCH, RELEASE, KINK = 0, 1, 2, 3, 4, 5
NEIGHBOUR = 6  # not found by the search: a point near a wall that takes part in the impact of another point

SLIDING_ENDS, STICKING_ENDS = 1, 2
"""The kinds of change of a mode of dry friction, as stored for each element in ``element.event``."""

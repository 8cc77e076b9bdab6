"""The kinds of event, as ``touch.event`` has them for each candidate. What they are, table.py says."""

NONE, ONSET, END, RELATCH, RELEASE, KINK = 0, 1, 2, 3, 4, 5
NEIGHBOUR = 6  # not found in a step: a point that is near while the impact of another one is worked out
REFUSED = -2.0  # in place of the fraction θ of a step at which an event happens

"""The marks of events that the search has found in the last step, in ``event`` of touch, element and drive.

Only this module sets them. They stay until the next step applies them (handlers.py, friction_modes.py,
saturation.py).
handlers.py and sampled.py describe the kinds.
"""

NONE, ONSET, END, RELATCH, RELEASE, KINK = 0, 1, 2, 3, 4, 5
NEIGHBOUR = 6  # not found by the search: a point near a wall that takes part in the impact of another point
SLIDING_ENDS, STICKING_ENDS = 1, 2  # changes of modes


def mark(d, c, kind):
    """Mark candidate c with an event of this kind, or with NONE."""
    d.touch.event[c] = kind


def mark_change(d, e, kind):
    """Mark element e with a change of its mode of this kind."""
    d.element.event[e] = kind


def drop_events(d):
    """Drop the events found in the last step."""
    drop_contact_events(d)
    drop_changes(d)


def drop_contact_events(d):
    """Drop the events of candidates, but not the changes of modes of dry friction."""
    for c in range(d.candidates):
        d.touch.event[c] = NONE


def drop_changes(d):
    """Drop the changes of modes, of dry friction and drives, found in the last step."""
    for e in range(d.elements):
        d.element.event[e] = 0
    drop_saturations(d)


def mark_saturation(d, i):
    """Mark the drive of joint i, whose torque reaches its limit or falls below it."""
    d.drive.event[i] = 1


def drop_saturations(d):
    """Drop the marks of drives."""
    if d.model.limited:
        for i in range(d.links):
            d.drive.event[i] = 0


def copy_marks(d, t):
    """Give the tangent instance t the events of d."""
    for c in range(d.candidates):
        t.touch.event[c] = d.touch.event[c]
    for e in range(d.elements):
        t.element.event[e] = d.element.event[e]
    if d.model.limited:
        for i in range(d.links):
            t.drive.event[i] = d.drive.event[i]


def ends_in_onset(d):
    """Whether the last step ends where contacts begin."""
    for c in range(d.candidates):
        if d.touch.event[c] == ONSET:
            return True
    return False


def pending_changes(d):
    """The number of elements whose mode ends at the end of the last step."""
    changes = 0
    for i in range(d.friction.count):
        changes += d.element.event[d.element.index[i]] != 0
    return changes


def pending_saturations(d):
    """The number of drives whose mode ends at the end of the last step."""
    changes = 0
    if d.model.limited:
        for i in range(d.links):
            changes += d.drive.event[i]
    return changes

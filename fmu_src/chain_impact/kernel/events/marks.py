"""The marks of events found in the last step, in the parts ``contacts``, ``friction_element`` and ``drive``.

Only this module sets the marks. A mark stays until the next step applies the event (handlers.py,
friction_modes.py, saturation.py), or until the last step is rejected or cut before the event. handlers.py and
force_events.py describe the kinds of events.
"""

from chain_impact.kernel.record.constants import NO_EVENT, ONSET


def mark_contact_event(d, c, kind):
    """Mark candidate c with an event of a ``kind``; the kind NO_EVENT removes the mark of c."""
    d.contacts.event[c] = kind


def mark_mode_change(d, e, kind):
    """Mark element e with a ``kind`` of change of the friction mode: see record/constants.py."""
    d.friction_element.event[e] = kind


def drop_events(d):
    """Remove all marks of the last step: of contacts, friction modes and drives."""
    drop_contact_events(d)
    drop_mode_marks(d)


def drop_contact_events(d):
    """Remove the marks of candidates, but keep the marks of friction modes and drives."""
    for c in range(d.candidate_count):
        d.contacts.event[c] = NO_EVENT


def drop_mode_marks(d):
    """Remove the marks of mode changes, of dry friction and of drives, in the last step."""
    for e in range(d.friction_element_count):
        d.friction_element.event[e] = 0
    mark_saturation(d, 0)


def mark_saturation(d, event):
    """Set the one event of all drives: ``event`` is 1 if the mode of any drive ends, else 0.

    After the event, the modes of all drives are chosen again at the start of the next step.
    """
    d.drive.event = event


def copy_marks(d, t):
    """Copy the marks of the primal instance d to the tangent instance t."""
    for c in range(d.candidate_count):
        t.contacts.event[c] = d.contacts.event[c]
    for e in range(d.friction_element_count):
        t.friction_element.event[e] = d.friction_element.event[e]
    t.drive.event = d.drive.event


def ends_in_onset(d):
    """Return whether any candidate has the mark ONSET: a contact begins where the last step ends."""
    for c in range(d.candidate_count):
        if d.contacts.event[c] == ONSET:
            return True
    return False


def count_mode_changes(d):
    """Return the number of elements that are marked with an end of their friction mode."""
    changes = 0
    for i in range(d.friction.active_count):
        changes += d.friction_element.event[d.friction_element.index[i]] != 0
    return changes

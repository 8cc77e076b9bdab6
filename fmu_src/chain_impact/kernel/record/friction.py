"""The parts of the record with the data of dry friction, in contacts, in joints and of the slider."""

import numpy as np

from chain_impact.kernel.record.constants import NO_FRICTION
from chain_impact.kernel.record.fields import INTEGER, REAL, bounded_integer, layout, written_by

# number of changes of friction modes for which the log has room, divided by the number of elements
CHANGES_OF_EACH = 4


@written_by("forces/friction.py")
def friction_dtype(friction_element_count: int) -> np.dtype:
    """Return the layout of the data of all dry friction; `friction_element` has each element's data."""
    return layout(
        ("may_act", INTEGER),  # 1: some wall, joint or the slider has dry friction
        # number of elements with friction at present: active contacts, joints and the slider, in this order
        ("active_count", bounded_integer(0, friction_element_count)),
        ("contact_count", INTEGER),  # number of active contacts among these elements
        ("stuck_count", INTEGER),  # number of sticking elements: contacts, joints and the slider
        ("stuck_joints", INTEGER),  # number of sticking joints, plus 1 if the slider sticks
        ("power", REAL),  # W, power that all elements dissipate by dry friction, at the last evaluation of ẏ
    )


@written_by(
    "forces/friction.py",
    event="events/marks.py",
    **dict.fromkeys(("mode_before", "slack", "decided_by_forces"), "events/friction_modes.py"),
)
def friction_element_dtype(friction_element_count: int) -> np.dtype:
    """Return the layout of each element's data: the candidates, then the joints 1…N, then the slider."""
    elements = (friction_element_count,)
    return layout(
        # indices of the elements with friction; only the first `friction.active_count` entries are used
        ("index", bounded_integer(0, friction_element_count - 1), elements),
        # indices of the sticking elements; only the first `friction.stuck_count` entries are used
        ("stuck_index", bounded_integer(0, friction_element_count - 1), elements),
        # 0: sticks; ±1: slides along ±t; 2: no friction
        ("mode", bounded_integer(-1, NO_FRICTION), elements),
        # the event of an element at `step.end`, which the next step applies: the end of its mode, as in
        # ``mark_mode_change``; 0: none
        ("event", INTEGER, elements),
        ("mode_before", INTEGER, elements),  # mode before the last choice of modes; 2 for a new contact
        ("chosen_mode", INTEGER, elements),  # in a tangent instance: the mode of an element in the primal run
        # 1: the element is at rest, and the forces have determined the mode; 0: the element moves, and the
        # motion has determined the mode; in a tangent instance also STOPPED = 2 of tangent/friction.py
        ("decided_by_forces", INTEGER, elements),
        # m/s, a speed of an element against its direction of sliding counts as an error up to ``slack`` plus
        # ``rest_speed`` (events/mode_changes.py)
        ("slack", REAL, elements),
        ("anchor", REAL, elements),  # m, the coordinate along t at which a sticking element is held
        ("force", REAL, elements),  # N, friction force along t at the last evaluation of ẏ
        # N, largest force of static friction at the last evaluation of ẏ; constant for the slider and for a
        # joint, whose moment is divided by the lever arm
        ("friction_limit", REAL, elements),
        # least margin of an element to the end of its mode in the stages of the tried step, ∞ before the
        # first stage. If the element slides, the margin is its speed in the direction of sliding [m/s]; if it
        # sticks, its limit minus the size of the friction force [N]
        ("margin", REAL, elements),
    )


@written_by("events/friction_modes.py")
def friction_changes_dtype(friction_element_count: int) -> np.dtype:
    """Return the layout of the log of changes of friction modes.

    Friction that begins or ends is a change, too. A caller that has collected changes sets ``count`` to 0.
    """
    log = CHANGES_OF_EACH * friction_element_count
    return layout(
        ("count", INTEGER),  # number of changes since the caller has last collected them
        ("time", REAL, (log,)),  # s, time of each change
        ("point", INTEGER, (log,)),  # number of the point or joint of the element; 0 for the slider
        # index of the wall in the scene's wall_names; −1 for dry friction in a joint or of the slider
        ("wall", INTEGER, (log,)),
        ("mode", INTEGER, (log,)),  # mode of the element from this time on, as in `friction_element.mode`
    )

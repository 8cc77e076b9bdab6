"""The parts of the record with the data of contacts."""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count
from chain_impact.kernel.integration.dense import DENSE_COEFFICIENTS
from chain_impact.kernel.integration.explicit import STAGES
from chain_impact.kernel.model.latest import LATEST
from chain_impact.kernel.record.fields import INTEGER, REAL, record
from chain_impact.kernel.record.solver import factors_dtype

LOG_SIZE = 32  # finished contacts stored until they are collected, in addition to one for each candidate


def touch_dtype(candidates: int) -> np.dtype:
    """The data of each candidate; values fixed ("latched") at onset hold until the end or a new latch of v₀.

    Owner: model/contact.py; of events, the searches in events/; of peaks, events/contact_log.py.
    """
    return record(
        ("active_count", INTEGER),
        ("compliant_count", INTEGER),  # of them, with a force law: these come first
        ("stop_count", INTEGER),  # of them, stops
        ("active_index", INTEGER, (candidates,)),  # the candidates in contact, packed
        ("active", INTEGER, (candidates,)),  # 1: in contact
        ("event", INTEGER, (candidates,)),  # at `step.end` and not yet applied, see kernel/events/kinds.py
        ("onset", REAL, (candidates,)),  # s
        ("onset_speed", REAL, (candidates,)),  # m/s, normal approach speed at onset
        ("impact_speed", REAL, (candidates,)),  # m/s, v0 of the force law
        ("effective_mass", REAL, (candidates,)),  # kg, 1/(J M⁻¹ Jᵀ) at onset
        ("depth_scale", REAL, (candidates,)),  # m, expected penetration
        ("damping", REAL, (candidates,)),  # N·s/m^(p+1), d of the force law
        ("speed", REAL, (candidates,)),  # m/s, δ̇ and …
        ("force_rate", REAL, (candidates,)),  # N/s, dF/dt at the start of the step, to find the peaks
        ("force", REAL, (candidates,)),  # N, of active ones at the last evaluation of the rate …
        ("force_end", REAL, (candidates,)),  # N, … and at the end of the last step
        (
            "beyond_kink",
            INTEGER,
            (candidates,),
        ),  # 1: δ̇ is beyond the kink of its force
        ("kink_margin", REAL, (candidates,)),  # m/s, by which δ̇ may be on the wrong side; else 0
        ("kink_crossed", INTEGER, (candidates,)),  # 1: a stage of the tried step was on its other side
        ("number", INTEGER, (candidates,)),  # of its onset among all onsets, counted from 1
        ("peak_force", REAL, (candidates,)),  # N
        ("max_penetration", REAL, (candidates,)),  # m
        # m, of two error estimates of a tried step, in the clearances of the active contacts, packed
        ("gap_error", REAL, (2, candidates)),
    )


def impact_dtype() -> np.dtype:
    """The impacts so far. Owner: ``begin_contact`` in model/contact.py."""
    return record(
        ("count", INTEGER),  # onsets since the start
        ("last_time", REAL),  # s
        ("last_point", INTEGER),  # 0…N, −1 before the first impact
        ("last_wall", INTEGER),  # 1 + index into the scene's wall_names, 0 before the first impact
        ("last_speed", REAL),  # m/s
    )


def latest_dtype() -> np.dtype:
    """The latest impacts, the newest first. Owner: model/latest.py."""
    return record(
        ("kept", INTEGER),  # the number of them that is requested
        ("point", INTEGER, (LATEST,)),  # 0…N, −1 for none
        ("wall", INTEGER, (LATEST,)),  # 1 + index into the scene's wall_names, 0 for none
        ("time", REAL, (LATEST,)),  # s
        ("speed", REAL, (LATEST,)),  # m/s
        ("end", REAL, (LATEST,)),  # s, the present time while the contact lasts
        ("separation_speed", REAL, (LATEST,)),  # m/s
        ("peak_force", REAL, (LATEST,)),  # N
        ("max_penetration", REAL, (LATEST,)),  # m
        ("impulse", REAL, (LATEST,)),  # N·s
    )


def rigid_dtype(links: int, candidates: int) -> np.dtype:
    """The touching candidates, packed; those with a force law are not in the active set.

    Owner: model/constraints.py.
    """
    return record(
        ("factors", factors_dtype(links)),  # with an impedance at the points of the active set
        # m, m/s or m/s², rad …: the change of the coordinates by the impulses
        ("change", REAL, (coordinate_count(links),)),
        ("in_active_set", INTEGER, (candidates,)),  # 1: its impulse may differ from 0
        ("violated", INTEGER, (candidates,)),  # 1: its impulse or residual has the wrong sign
        ("start", REAL, (candidates,)),  # normal motion without impulses, m, m/s or m/s², …
        ("reached", REAL, (candidates,)),  # … with them, …
        ("target", REAL, (candidates,)),  # … its least required value, …
        ("residual", REAL, (candidates,)),  # … the missing part, later times the impedance
        ("impulse", REAL, (candidates,)),  # N·s, or N
        ("impedance", REAL, (candidates,)),  # kg, D
        ("sample", REAL, (2, candidates)),  # N, the last two sampled forces
        (
            "least_force",
            REAL,
            (candidates,),
        ),  # N, smallest force in the stages of the step; not packed
    )


def finished_dtype(candidates: int) -> np.dtype:
    """The log of finished contacts. Owner: events/contact_log.py; a caller that collects sets count to 0."""
    log = LOG_SIZE + candidates
    return record(
        ("count", INTEGER),  # contacts ended since last collected
        ("point", INTEGER, (log,)),
        ("wall", INTEGER, (log,)),
        ("onset", REAL, (log,)),  # s
        ("end", REAL, (log,)),  # s
        ("impact_speed", REAL, (log,)),  # m/s, approach speed at onset
        ("separation_speed", REAL, (log,)),  # m/s
        ("peak_force", REAL, (log,)),  # N
        ("max_penetration", REAL, (log,)),  # m
        ("effective_mass", REAL, (log,)),  # kg
        ("impulse", REAL, (log,)),  # N·s
    )


def impulse_dtype(candidates: int) -> np.dtype:
    """∫F dt of the walls on the points, packed unless noted. Owner: integration/impulse.py."""
    return record(
        ("wanted", INTEGER),  # 1: impulses are integrated
        ("total", REAL, (candidates,)),  # N·s since the start, not packed
        ("onset", REAL, (candidates,)),  # N·s, the total at the onset of the contact, not packed
        ("state", REAL, (candidates,)),  # N·s, at the start of the last step …
        ("state_end", REAL, (candidates,)),  # … and at its end
        ("tried", REAL, (candidates,)),  # N·s, at the end of the tried step
        ("dense", REAL, (DENSE_COEFFICIENTS, candidates)),  # the interpolant of the last step
        ("stage", REAL, (STAGES, candidates)),  # dp/ds at the stages
    )

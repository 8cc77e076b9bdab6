"""The layout of an instance: one flat record that holds all data of a running simulation.

Parameters, inputs, the integrator's memory, statistics, outputs and work space are the fields of one NumPy
record without pointers, so the state of an FMU is a copy of its bytes. Every scalar takes eight bytes (a
double or an integer), so each has an index counted in doubles from the start of the record: the FMU's code
needs no other knowledge of the layout.

N links, points 0…N (0 the base, N the tip), C candidates (pairs of a point and a wall), state vector y
(kernel/chain/state.py).

Every size and offset is a + bN + cC + dF + eL. The compiled kernel relies on it
(compilation/record_type.py). The parts that depend on C come after all others, then those that depend on F,
and last those that depend on L, so that the offsets of all others do not depend on them.
"""

import numpy as np

from chain_impact.kernel.record.contacts import (
    changes_dtype,
    element_dtype,
    finished_dtype,
    friction_dtype,
    impact_dtype,
    latest_dtype,
    peaks_dtype,
    quadrature_dtype,
    rigid_dtype,
    touch_dtype,
)
from chain_impact.kernel.record.fields import INTEGER, record
from chain_impact.kernel.record.given import (
    candidate_dtype,
    contact_dtype,
    given_dtype,
    initial_dtype,
    inputs_dtype,
    law_dtype,
    model_dtype,
    solver_dtype,
    stops_dtype,
    walls_dtype,
)
from chain_impact.kernel.record.implicit import implicit_dtype
from chain_impact.kernel.record.outputs import output_dtype, transmitted_dtype
from chain_impact.kernel.record.solver import (
    balance_dtype,
    fault_dtype,
    limits_dtype,
    search_dtype,
    statistics_dtype,
    step_dtype,
    trial_dtype,
    work_dtype,
)


def instance_dtype(links: int, candidates: int, elements: int = 0, loads: int = 0) -> np.dtype:
    """The record of an instance with N = ``links`` links, C = ``candidates`` candidates and F elements.

    The ``elements`` are what may have dry friction: candidates and joints, C + N, or none, F = 0, in a scene
    without dry friction, whose record has no room for it. Nor has it room for loads unless they are
    requested: then ``loads`` L is the number of joints N and walls together.
    """
    return record(
        ("links", INTEGER),  # N
        ("candidates", INTEGER),  # C
        ("elements", INTEGER),  # F
        ("loads", INTEGER),  # L
        ("tangents", INTEGER),  # number of tangent instances that follow this one in memory (kernel/tangent/)
        ("model", model_dtype(links)),
        ("contact", contact_dtype()),
        ("stops", stops_dtype()),
        ("initial", initial_dtype(links)),
        ("solver", solver_dtype()),
        ("given", given_dtype(links)),
        ("inputs", inputs_dtype(links)),
        ("step", step_dtype(links)),
        ("trial", trial_dtype(links)),
        ("impact", impact_dtype()),
        ("latest", latest_dtype()),
        ("peaks", peaks_dtype()),
        ("statistics", statistics_dtype()),
        ("fault", fault_dtype()),
        ("limits", limits_dtype()),
        ("balance", balance_dtype()),
        ("work", work_dtype(links)),
        ("friction", friction_dtype()),
        ("touch", touch_dtype(candidates)),
        ("candidate", candidate_dtype(candidates)),
        ("walls", walls_dtype(candidates)),
        ("law", law_dtype(candidates)),
        ("search", search_dtype(candidates)),
        ("finished", finished_dtype(candidates)),
        ("implicit", implicit_dtype(links, candidates, elements)),
        ("rigid", rigid_dtype(links, candidates, elements)),
        ("element", element_dtype(elements)),
        ("quadrature", quadrature_dtype(candidates, elements)),
        ("changes", changes_dtype(elements)),
        ("output", output_dtype(links, candidates, elements, loads)),
        ("transmitted", transmitted_dtype(loads)),
    )

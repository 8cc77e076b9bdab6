"""The part of the record with the data of implicit steps."""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count, state_size
from chain_impact.kernel.integration.radau import PAIRS, STAGES
from chain_impact.kernel.record.fields import (
    COMPLEX,
    INTEGER,
    REAL,
    impedance_dtype,
    loads_dtype,
    record,
    vectors_dtype,
    written_by,
)
from chain_impact.kernel.record.solver import factors_dtype


@written_by(
    **dict.fromkeys(("start", "start_rate", "link", "stiffness", "damping"), "integration/extended.py"),
    **dict.fromkeys(("shift", "pairs"), "integration/linear_system.py"),
    **dict.fromkeys(("iterations", "correction", "contraction"), "integration/newton.py"),
    **dict.fromkeys(("last", "began", "span", "listing", "thirds"), "integration/collocation.py"),
    **dict.fromkeys(
        ("z", "stages", "parts", "slowness"), ("integration/collocation.py", "integration/newton.py")
    ),
    normal=("integration/collocation.py", "integration/projection.py"),
    weight="integration/collocation.py",
)
def implicit_dtype(links: int, candidates: int, elements: int) -> np.dtype:
    """The work space of an implicit step, and the data that it uses of the last one.

    z = (y, then the clearances of active contacts, their rates, impulses): kernel/integration/extended.py.
    """
    state = state_size(links)
    extended = state + 3 * candidates + elements
    # for each pair of complex shifts, and what ``work`` holds for a real one
    pairs = record(
        ("factors", factors_dtype(links, COMPLEX, PAIRS)),
        ("impedance", impedance_dtype(links, COMPLEX)),
        ("load", loads_dtype(links, COMPLEX)),
        ("motion", vectors_dtype(2 * links + 1, COMPLEX)),
        ("change", COMPLEX, (coordinate_count(links),)),
        ("x", COMPLEX, (extended,)),  # a right-hand side, later the solution
    )
    return record(
        ("start", REAL, (extended,)),  # z at the start of a step …
        ("start_rate", REAL, (extended,)),  # … and ż
        ("z", REAL, (extended,)),
        ("weight", REAL, (extended,)),  # of errors, over the tolerance
        ("stages", REAL, (STAGES, extended)),  # increments of z to the nodes …
        ("rates", REAL, (STAGES, extended)),  # … and ż there
        ("parts", REAL, (STAGES, extended)),  # residuals in the eigenvectors of Q, then corrections
        ("last", REAL, (STAGES, extended)),  # the increments of the last step, …
        ("began", REAL),  # s, … its start, …
        ("span", REAL),  # s, … its size, …
        ("listing", INTEGER),  # … and the value of `touch.listings` for which they can be extrapolated
        ("iterations", INTEGER),  # in the tried step, …
        ("correction", REAL),  # … the largest component of the last correction, over the tolerance, …
        ("contraction", REAL),  # … and the last convergence rate θ
        ("slowness", REAL),  # θ/(1 − θ) of the last step
        ("thirds", REAL, (2, state)),  # corrections of the dense output at thirds of the step
        ("link", vectors_dtype(links + 1)),  # m, L_i where A was evaluated
        ("stiffness", REAL, (candidates,)),  # N/m, ∂F/∂δ of the active contacts, packed, …
        ("damping", REAL, (candidates,)),  # N·s/m, … and ∂F/∂δ̇, likewise
        ("normal", REAL, (candidates,)),  # m or m/s, clearances or rates to which coordinates are moved
        ("shift", REAL),  # s, the real shift of the factors in `work`
        ("pairs", pairs),
    )

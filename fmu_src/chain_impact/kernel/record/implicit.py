"""The part of the record with the data of implicit steps."""

import numpy as np

from chain_impact.kernel.chain.state import coordinate_count, state_size
from chain_impact.kernel.integration.radau import PAIRS, STAGES
from chain_impact.kernel.record.contacts import constraint_count
from chain_impact.kernel.record.fields import (
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
    **dict.fromkeys(("impedance", "factors"), "integration/linear_system.py"),
    **dict.fromkeys(("iterations", "correction", "contraction"), "integration/newton.py"),
    **dict.fromkeys(("last", "began", "span", "listing", "thirds"), "integration/collocation_dense.py"),
    **dict.fromkeys(
        ("z", "stages", "parts", "slowness"), ("integration/collocation.py", "integration/newton.py")
    ),
    normal=("integration/collocation_dense.py", "integration/projection.py"),
)
def implicit_dtype(links: int, candidates: int, elements: int) -> np.dtype:
    """The work space of an implicit step, and the data that it uses of the last one.

    z = (y, then the clearances of active contacts, their rates, impulses): kernel/integration/extended.py.
    """
    state = state_size(links)
    extended = state + 3 * candidates + elements
    # both parts of complex numbers, one below the other, for each pair of shifts
    shifted = record(
        *(
            (name, REAL, (2 * PAIRS, links))
            for name in ("gain_x", "gain_y", "inverse", "own", "damper")  # as in `real`
        ),
        ("base", REAL, (2 * PAIRS, 3)),
        ("impedance", REAL, (2 * PAIRS, candidates)),  # kg, D of the active contacts, packed
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
        # kg, … and their D, added to the inertia of their points; then that of what sticks
        ("impedance", REAL, (constraint_count(candidates, elements),)),
        ("normal", REAL, (candidates,)),  # m or m/s, clearances or rates to which coordinates are moved
        ("real", factors_dtype(links)),  # for the real shift
        ("factors", shifted),  # for the complex shifts
        ("reactance", impedance_dtype(links)),  # the imaginary part of `work.impedance`, …
        ("load", loads_dtype(links)),  # … of `work.load` …
        ("motion", vectors_dtype(2 * links + 1)),  # … and of `work.motion`
        ("answer", REAL, (2, coordinate_count(links))),  # Δ, likewise
    )

"""Points of a chain at rigid walls, with target motions."""

import numpy as np

from chain_impact.kernel.initialize import derive_chain
from chain_impact.kernel.record.constants import NOT_GIVEN
from tests.helpers.models.reference import mass_matrix
from tests.kernel.chains import chain, free_coordinates, gradients, locate_touching_state

CANDIDATES = [1, 6, 11, 16]  # points 0, 1, 2 and 4 of a free chain, each at another wall


def problem(base="free", pressed=(1, 0, 1, 1), seed=0, masses=None):
    """Return record, state, J, M⁻¹ Jᵀ and W of a chain whose touching candidates have target motions.

    ``pressed``: which of them are in the active set. With ``masses`` [kg] the links are rods with these
    masses, but M⁻¹ Jᵀ and W are those of the links before.
    """
    rng = np.random.default_rng([len(base), seed])
    scene, d = chain(rng, 4, base, model="newton_impact")
    if masses:
        d.chain.mass[:] = masses
        d.chain.given_center_of_mass[:] = d.chain.given_inertia[:] = NOT_GIVEN
        derive_chain(d)
    candidates = CANDIDATES[: len(pressed)]
    if base == "pinned":
        candidates = [c - 1 for c in candidates]
    y = locate_touching_state(rng, d, candidates, 0.0)
    free = free_coordinates(d)
    jacobian = gradients(scene, d, y[2:6], candidates)
    response = np.zeros((6, len(candidates)))
    response[free] = np.linalg.solve(mass_matrix(scene, y[2:6])[free, free], jacobian[:, free].T)
    own, count = d.constraints, len(candidates)
    own.in_active_set[:count] = pressed
    own.unforced_motion[:count], own.target_motion[:count] = rng.normal(size=count), rng.normal(size=count)
    return d, y, jacobian, response, jacobian @ response

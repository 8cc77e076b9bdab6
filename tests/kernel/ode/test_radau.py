"""The coefficients of Radau IIA with 5 stages."""

import numpy as np
import pytest

from chain_impact.kernel.ode import radau
from chain_impact.kernel.record.constants import RADAU_STAGES

ORDER = 9
C, MATRIX = np.array(radau.RADAU_NODES), np.array(radau.Q)


def test_stages_and_result_have_exactly_their_orders():
    """Σ_j Q_ij c_j^(k−1) = c_i^k/k. The method is stiffly accurate, and collocates at the end."""
    for k in range(1, RADAU_STAGES + 1):
        np.testing.assert_allclose(MATRIX @ C ** (k - 1), C**k / k, rtol=0, atol=2e-16)
    for k in range(1, ORDER + 2):
        assert (abs(MATRIX[-1] @ C ** (k - 1) - 1 / k) < 2e-16) == (k <= ORDER)
    assert radau.RADAU_NODES[-1] == 1.0
    assert np.linalg.matrix_rank(MATRIX) == RADAU_STAGES


def test_the_eigenvectors_are_those_of_its_eigenvalues():
    blocks = np.zeros((RADAU_STAGES, RADAU_STAGES))
    blocks[0, 0] = radau.REAL_EIGENVALUE
    for pair, (real, imaginary) in enumerate(radau.COMPLEX_EIGENVALUES):
        at = 1 + 2 * pair
        blocks[at : at + 2, at : at + 2] = [[real, -imaginary], [imaginary, real]]
    np.testing.assert_allclose(np.array(radau.RIGHT) @ radau.LEFT, np.eye(RADAU_STAGES), rtol=0, atol=3e-15)
    np.testing.assert_allclose(np.array(radau.LEFT) @ MATRIX @ radau.RIGHT, blocks, rtol=0, atol=1e-15)


def test_shifts_lie_in_a_sector_in_which_no_pivot_vanishes():
    """Sums of 1, s and s² with factors ≥ 0 do not vanish for |arg s| < 90°."""
    for real, imaginary in radau.COMPLEX_EIGENVALUES:
        assert 0.0 < np.degrees(np.arctan2(imaginary, real)) < 61.0


@pytest.mark.parametrize("k", range(RADAU_STAGES))
def test_the_polynomials_of_the_error_estimates(k):
    assert np.dot(radau.START_WEIGHTS, C**k) == pytest.approx(0.0**k, abs=3e-15)
    if k < RADAU_STAGES - 1:
        assert np.dot(radau.END_WEIGHTS, C[:-1] ** k) == pytest.approx(1.0, abs=3e-15)

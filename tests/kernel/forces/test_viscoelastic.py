"""f(e) of Kuwabara and Kono, against an integration without the fitted polynomial."""

import math

import numpy as np
import pytest

from chain_impact.kernel.forces.viscoelastic import (
    CHEBYSHEV_COEFFICIENTS,
    NEAREST_TO_ONE,
    evaluate_series,
    viscoelastic_factor,
)
from tests.helpers.models.reference import rebound


@pytest.mark.parametrize("e", [1e-4, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 0.9999])
def test_viscoelastic_spheres_realise_the_prescribed_restitution(e):
    assert rebound(1.5, 0.5, viscoelastic_factor(e)).restitution == pytest.approx(e, rel=2e-11)


@pytest.mark.parametrize("e", [1e-15, 1e-100, 1e-300])
def test_viscoelastic_spheres_of_hardly_any_restitution_have_the_limit(e):
    assert viscoelastic_factor(e) == pytest.approx(1.176079022502 * e**-0.6, rel=2e-11)


@pytest.mark.parametrize("e", [1e-6, 0.1, 0.5, 0.9, 1.0 - 1e-11])
def test_the_damping_of_viscoelastic_spheres_is_smooth(e):
    """Third differences of the logarithm are small everywhere, also at the end of the polynomial."""
    h = 0.1 * min(1e-2, 1.0 - e)
    values = [math.log(viscoelastic_factor(e * (1.0 - k * h))) for k in range(4)]
    assert abs(np.diff(values, 3)[0]) <= 0.02 * abs(np.diff(values)[0])


def test_viscoelastic_spheres_that_are_nearly_elastic_lose_in_proportion():
    assert viscoelastic_factor(1.0) == 0.0
    for loss in (1e-6, 1e-9, 1e-11, 1e-12, 1e-13):
        e = 1.0 - loss
        assert viscoelastic_factor(e) == pytest.approx((1.0 - e) / 1.15344885, rel=2e-6)


def test_the_series_is_that_of_chebyshev_polynomials():
    for x in (-1.0, -0.3, 0.0, 0.8, 1.0):
        assert evaluate_series(x) == pytest.approx(
            np.polynomial.chebyshev.chebval(x, CHEBYSHEV_COEFFICIENTS), rel=1e-14
        )


def test_next_to_no_loss_the_polynomial_is_that_of_none():
    inside, beyond = 1.0 - 2.0 * NEAREST_TO_ONE, 1.0 - 0.5 * NEAREST_TO_ONE
    for e in (inside, beyond):
        assert viscoelastic_factor(e) / (1.0 - e) == pytest.approx(evaluate_series(-1.0), rel=1e-9)

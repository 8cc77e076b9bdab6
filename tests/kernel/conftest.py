"""For kernel functions in plain Python: the floating-point behaviour of the compiled kernel."""

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def _quiet_arithmetic():
    """Silence divisions by zero: they give inf or NaN, which the step control rejects."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        yield

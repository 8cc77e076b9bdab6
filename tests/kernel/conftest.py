"""For kernel functions in plain Python: the floating-point behaviour of the compiled kernel."""

import numpy as np
import pytest

from tests.helpers.kernel.plain import begun


@pytest.fixture(autouse=True)
def _quiet_arithmetic():
    """Silence divisions by zero: they give inf or NaN, which the step control rejects."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        yield


@pytest.fixture(autouse=True)
def _own_records(request):
    """Let a test that replaces functions initialize its records itself."""
    begun.is_shared = "monkeypatch" not in request.fixturenames

"""For kernel functions in plain Python: the floating-point behaviour of the compiled kernel."""

import numpy as np
import pytest

from tests.helpers.kernel.plain import initialized


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """Silence divisions by zero, invalid operations and overflows: the step control rejects inf and NaN.

    A test that replaces functions initializes its records itself. A hook takes less time than fixtures.
    """
    initialized.is_shared = "monkeypatch" not in item.fixturenames
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return (yield)

"""For the functions of the kernel as plain Python: the arithmetic of the compiled kernel, and some speed."""

import functools

import numpy as np
import pytest

from chain_impact.kernel.laws import contact_laws


@pytest.fixture(autouse=True)
def _quiet_arithmetic():
    """A division by zero gives inf or NaN, which the step control rejects."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        yield


@pytest.fixture(autouse=True, scope="session")
def _solve_each_impact_once():
    """The impact after Kuwabara and Kono is solved step by step, which takes plain Python 7 ms."""
    solved = functools.cache(contact_laws.viscoelastic_rebound)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contact_laws, "viscoelastic_rebound", solved)
        yield

"""Fakes of the package's functions take what the functions take."""

import pytest

from chain_impact.kernel import advance
from chain_impact.simulation import kernels
from tests.helpers.tools import fakes


def older_kernel_for(scene, *, derivatives, sizes): ...


def test_a_fake_with_other_arguments_is_refused(monkeypatch):
    with pytest.raises(TypeError, match=r"The fake of .*log_is_full.* too many positional arguments"):
        monkeypatch.setattr(advance, "log_is_full", lambda d: False)
    for fake in (older_kernel_for, lambda: None):
        with pytest.raises(TypeError, match=r"The fake of .*kernel_for"):
            monkeypatch.setattr("chain_impact.simulation.kernels.kernel_for", fake)


@pytest.mark.parametrize("target", [(kernels, "kernel_for"), ("chain_impact.simulation.kernels.kernel_for",)])
def test_a_fake_refuses_a_call_that_the_function_refuses(monkeypatch, target):
    monkeypatch.setattr(*target, lambda scene, **options: (scene, options))
    assert kernels.kernel_for(1, derivatives=0, scope=None) == (1, {"derivatives": 0, "scope": None})
    for _ in range(2):
        with pytest.raises(TypeError, match=r"kernel_for.* got an unexpected keyword argument 'sizes'"):
            kernels.kernel_for(1, derivatives=0, sizes=None)
        monkeypatch.setattr(*target, lambda *_, **__: None)  # a fake of a fake is checked, too


def test_other_values_than_functions_are_put_in_place_as_they_are():
    class Fake: ...

    for fake, real in (("text", kernels.kernel_for), (len, "text"), (Fake, kernels.kernel_for), (len, len)):
        assert fakes.checked(fake, real) is fake

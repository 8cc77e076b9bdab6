"""Helpers for the tests of progress messages."""

from chain_impact.progress import log_once
from chain_impact.simulation import kernels


def compiling(monkeypatch):
    """Let the cached kernel look as if it had to be compiled."""
    cached = kernels.kernel_library

    def kernel_library(*arguments, **_):
        log_once("compiling the kernel", 17.0)
        return cached(*arguments)

    monkeypatch.setattr(kernels, "kernel_library", kernel_library)
    monkeypatch.setattr(kernels, "loaded_kernels", {})

"""The kernels that this process has loaded."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

import numpy as np

from chain_impact.compilation import signatures
from chain_impact.compilation.compilers import KernelScope
from chain_impact.compilation.library import kernel_library
from chain_impact.scene.scene import Scene
from chain_impact.variables.indices import HEAD_WORDS
from chain_impact.variables.prepared import kernel_scope

loaded_kernels: dict[tuple[KernelScope, bool, str | None], ctypes.CDLL] = {}
"""Loaded kernels without a user's law: (scope, with derivatives, ``CHAIN_IMPACT_CACHE`` or None) → kernel."""


def kernel_for(scene: Scene, *, derivatives: bool, scope: KernelScope | None = None) -> ctypes.CDLL:
    """Return the kernel for a scene, and keep it for later calls if the scene has no user's law.

    Args:
        scene: the scene.
        derivatives: whether the kernel carries derivatives.
        scope: which scenes the kernel can run: those of ``PreparedScene.kernel_scope``, the default, or only
            those with the counts of a tuple (``counts_and_flags``).

    Raises:
        BuildError: when the kernel cannot be compiled.
    """
    scope, law = kernel_scope(scene) if scope is None else scope, scene.contact.law_file
    # a change of the cache folder makes another key, so that the kernel is loaded from that folder
    key = (scope, derivatives, os.environ.get("CHAIN_IMPACT_CACHE"))
    if not law and key in loaded_kernels:
        return loaded_kernels[key]
    kernel = load_kernel(kernel_library(scope, law_file=law, derivatives=derivatives))
    if not law:
        loaded_kernels[key] = kernel
    return kernel


def counts_and_flags(memory: np.ndarray) -> tuple[int, ...]:
    """Return the counts and flags at the start of a record, for a kernel that runs only scenes with these.

    The number of tangent instances, the last word of this start, is left out.
    """
    return tuple(memory.view(np.int64)[: HEAD_WORDS - 1].tolist())


def load_kernel(library: Path) -> ctypes.CDLL:
    """Load a compiled kernel, and declare the types of its C functions (compilation/signatures.py)."""
    kernel = ctypes.CDLL(str(library))
    signatures.declare(kernel)
    return kernel

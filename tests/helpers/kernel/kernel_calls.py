"""Calls of a compiled kernel as FMUs make them, without the checks of ``Instance``, and its memory.

Of all tests and benchmarks, only this module uses private attributes of ``Instance`` and ``Chain``.
"""

from __future__ import annotations

from ctypes import CDLL
from typing import Any

import numpy as np

from chain_impact.simulation.chain import Chain
from chain_impact.simulation.instance import Instance


def instance_of(chain: Chain) -> Instance:
    """Return the instance that a chain steps."""
    return chain._instance


def kernel_of(instance: Instance) -> CDLL:
    """Return the compiled kernel of an instance."""
    return instance._kernel


def tangents_of(instance: Instance) -> np.ndarray:
    """Return the records of dual numbers behind the record of an instance with derivatives."""
    tangents: np.ndarray = instance._tangents  # type: ignore[attr-defined]
    return tangents


def initialize(instance: Instance, time: float = 0.0) -> int:
    """Set an instance to its start, at a time [s], and return the status."""
    return int(instance._kernel.initialize(instance._address, time))


def advance(instance: Instance, time: float) -> int:
    """Advance to a time [s] in one call, and return the status."""
    return int(instance._kernel.advance_to(instance._address, time))


def advance_awhile(instance: Instance, time: float) -> int:
    """Advance to a time [s], or a part of the way, and return the status."""
    return int(instance._kernel.advance_awhile(instance._address, time))


def advance_to_onset(instance: Instance, time: float) -> int:
    """Advance to a time [s], or to the first onset before it, which is then due; return the status."""
    return int(instance._kernel.advance_to_onset(instance._address, time))


def event_update(instance: Instance) -> int:
    """Apply the onset that is due, and return the status."""
    return int(instance._kernel.event_update(instance._address))


def move(instance: Instance, memory: Any) -> None:
    """Move the record of an instance into a buffer."""
    block = instance._memory
    place = np.frombuffer(memory, block.dtype, count=1)
    place[:] = block
    instance._use(place)

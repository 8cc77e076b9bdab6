"""The kernel as plain Python in the place of the compiled one, for runs of changed sources: mutants.py.

The entry points of compilation/entry_points.py, called with addresses as those of a library are. What has
derivatives needs dual numbers, which plain records have not.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from common import ROOT  # noqa: F401 - first: it makes the folder of the tests known

from chain_impact.kernel import entry
from chain_impact.kernel.advance import advance_to_onset, event_update
from chain_impact.kernel.events.contact_log import update_to_output_time
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.record.instance import instance_dtype
from chain_impact.kernel.soundness import sound
from tests.plain import Plain

SIZES = 4  # words at the start of a record: N, C, F, and the number of instances of dual numbers


class NoDerivativesError(RuntimeError):
    """A run with derivatives was asked for."""


def number(address: Any) -> int:
    """An address as a number."""
    return int(getattr(address, "value", address))


def array(address: Any, count: int, kind: Any = np.float64) -> np.ndarray:
    """The numbers at an address; a view."""
    if count == 0:
        return np.zeros(0, kind)
    size = count * np.dtype(kind).itemsize
    return np.frombuffer((ctypes.c_char * size).from_address(number(address)), kind)


def instance(address: Any) -> Plain:
    """The record at an address; a view."""
    *sizes, tangents = array(address, SIZES, np.int64).tolist()
    if tangents:
        raise NoDerivativesError
    return Plain(array(address, 1, instance_dtype(*sizes))[0])


def on(function: Callable[..., Any]) -> Callable[..., int]:
    """A function of an instance as one of its address."""

    def call(address: Any, *numbers: Any) -> int:
        return int(function(instance(address), *(getattr(one, "value", one) for one in numbers)) or 0)

    return call


def trajectory(  # noqa: PLR0917
    address: Any, times: Any, count: int, spans: Any, span_count: int, out: Any, columns: int
) -> int:
    """Fill rows with numbers of the record; return how many."""
    d = instance(address)
    rows = array(out, count * columns).reshape(count, columns)
    words = words_of(d._record)
    return int(
        entry.trajectory(
            d, words, array(times, count), array(spans, 2 * span_count, np.int64).reshape(-1, 2), rows
        )
    )


def run_each(  # noqa: PLR0917 - in C, arguments have no names
    address: Any,
    places: Any,
    parameters: int,
    values: Any,
    stops: Any,
    runs: int,
    looks: Any,
    columns: int,
    rows: Any,
    continuing: int,
) -> int:
    """Run again and again with other parameters; return how many runs are done."""
    d = instance(address)
    return int(
        entry.run_each(
            d,
            words_of(d._record),
            array(places, parameters, np.int64),
            array(values, runs * parameters).reshape(runs, parameters),
            array(stops, runs),
            array(looks, columns, np.int64),
            array(rows, runs * columns).reshape(runs, -1),
            continuing,
        )
    )


def words_of(record: Any) -> np.ndarray:
    """All numbers of a record; a view."""
    return array(record.__array_interface__["data"][0], record.dtype.itemsize // 8)


KERNEL = SimpleNamespace(
    initialize=on(initialize),
    advance=on(entry.advance_to),
    advance_awhile=on(entry.advance_awhile),
    advance_to_onset=on(advance_to_onset),
    event_update=on(event_update),
    observe=on(entry.observe_now),
    sound=on(sound),
    follow=on(update_to_output_time),
    trajectory=trajectory,
    run_each=run_each,
)
"""What a library has, see kernel/entry.py."""


def plain_kernel(scene: Any, *, derivatives: bool) -> SimpleNamespace:
    """In the place of ``kernel_for``."""
    if derivatives or scene.contact.law_file:
        raise NoDerivativesError
    return KERNEL

"""The kernel's functions as plain Python: they take a record whose fields are attributes."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import lru_cache, partial
from typing import Any
from unittest import mock

import numpy as np

from chain_impact.kernel.chain import mass_matrix_solver
from chain_impact.kernel.constraints.geometry import is_at_joint_stop
from chain_impact.kernel.initialize import initialize
from chain_impact.kernel.ode.quadratures import reset_quadratures
from chain_impact.kernel.record.fields import is_table
from chain_impact.kernel.status import OK
from chain_impact.scene.scene import Scene
from chain_impact.variables.prepared import PreparedScene


class Table(np.ndarray):
    """A table of a record with its columns as attributes.

    Unlike a recarray, it remembers its columns: a recarray makes a column at each access, which takes the
    plain kernel much of its time.
    """

    def __getattr__(self, name: str) -> Any:
        """Return a column, and remember it."""
        if name not in (self.dtype.names or ()):
            raise AttributeError(name)
        column = self.__dict__[name] = self[name].view(np.ndarray)
        return column

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value


class Plain:
    """A record of NumPy, ``numpy_record``, with its fields as attributes and, as in NumPy, by name."""

    def __init__(self, record: np.void) -> None:
        object.__setattr__(self, "numpy_record", record)

    def __getattr__(self, name: str) -> Any:
        """Return the present value of a number, or a part of the record, which it remembers."""
        record = self.__dict__["numpy_record"]
        try:
            value = record[name]
        except ValueError:
            raise AttributeError(name) from None
        if isinstance(value, np.void):
            value = self.__dict__[name] = Plain(value)
        elif isinstance(value, np.ndarray):
            layout = record.dtype[name]
            value = self.__dict__[name] = value.view(np.recarray).view(Table) if is_table(layout) else value
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        self.numpy_record[name] = value

    def __getitem__(self, name: str) -> Any:
        return getattr(self, name)

    def __setitem__(self, name: str, value: Any) -> None:
        self.numpy_record[name] = value

    def clear(self) -> None:
        """Set all numbers to zero, as ``clear_numbers`` in kernel/record/operations.py does."""
        for name in self.numpy_record.dtype.names:
            self.numpy_record[name] = np.zeros((), self.numpy_record.dtype[name])

    def copy_values(self, source: Plain) -> None:
        """Copy all values, as ``copy_values`` in kernel/tangent/duals.py does, without derivatives."""
        for name in self.numpy_record.dtype.names:
            self.numpy_record[name] = source.numpy_record[name]


@contextmanager
def as_plain_python() -> Iterator[None]:
    """Within the context, functions with a rule for complex numbers choose it if any argument is complex."""

    def by_type(function: Callable[..., Any], of_complex: Callable[..., Any], *arguments: Any) -> Any:
        return (of_complex if any(isinstance(argument, complex) for argument in arguments) else function)(
            *arguments
        )

    with ExitStack() as stack:
        for function, of_complex in mass_matrix_solver.COMPLEX_RULES.items():
            chosen = partial(by_type, function, of_complex)
            stack.enter_context(mock.patch.object(mass_matrix_solver, function.__name__, chosen))
        yield


def record_of(scene: Scene) -> Plain:
    """Return a new instance of a scene, not yet initialized."""
    return Plain(PreparedScene(scene).new_instance()[0])


@lru_cache(256)
def _initialized_record(pickled: bytes) -> np.ndarray:
    """Return the record of a pickled scene at the start of its run, which tests copy."""
    block = PreparedScene(pickle.loads(pickled)).new_instance()
    assert initialize(Plain(block[0]), 0.0) == OK
    return block


def initialized(scene: Scene) -> Plain:
    """Return an instance of a scene at the start of its run, at 0 s.

    Equal scenes are initialized once, except in a test that replaces functions (tests/kernel/conftest.py).
    """
    begin = _initialized_record if initialized.is_shared else _initialized_record.__wrapped__
    return Plain(begin(pickle.dumps(scene)).copy()[0])


initialized.is_shared = True


def make_rigid(d: Plain, rigid: Any = 1) -> None:
    """Set whether contacts are rigid (1) or have a force (0), with one value for all or one for each."""
    d.law.rigid[:] = rigid
    d.contact_settings.any_rigid, d.contact_settings.any_force_law = (
        int(d.law.rigid.any()),
        int(not d.law.rigid.all()),
    )
    pack(d)


def pack(d: Plain) -> None:
    """List the active contacts as the solver does, those with a force first, and reset the quadratures.

    Contacts with a force have no constraint in the active set.
    """
    packed = sorted(np.flatnonzero(d.contacts.active), key=lambda c: d.law.rigid[c])
    d.contacts.active_index[: len(packed)] = packed
    d.contacts.active_count = len(packed)
    d.contacts.force_law_count = sum(not d.law.rigid[c] for c in packed)
    d.contacts.joint_stop_count = sum(is_at_joint_stop(d, c) for c in packed)
    d.constraints.in_active_set[: d.contacts.force_law_count] = 0
    reset_quadratures(d)

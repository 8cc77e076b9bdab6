"""The kernel's functions, as plain Python: they take a record whose fields are attributes."""

from __future__ import annotations

from typing import Any

import numpy as np

from chain_impact.kernel.record.fields import is_table


class Plain:
    """A record of NumPy with its fields as attributes; they can also be had by name, as in NumPy's own."""

    def __init__(self, record: np.void) -> None:
        object.__setattr__(self, "_record", record)
        for name in record.dtype.names:
            if record.dtype[name].names:
                object.__setattr__(self, name, Plain(record[name]))
            elif is_table(record.dtype[name]):
                object.__setattr__(self, name, record[name].view(np.recarray))
            elif record.dtype[name].shape:
                object.__setattr__(self, name, record[name])

    def __getattr__(self, name: str) -> Any:
        """A number, as it is now."""
        try:
            return self._record[name]
        except ValueError:
            raise AttributeError(name) from None

    def __setattr__(self, name: str, value: Any) -> None:
        self._record[name] = value

    def __getitem__(self, name: str) -> Any:
        return getattr(self, name)

    def __setitem__(self, name: str, value: Any) -> None:
        self._record[name] = value

    def copy_values(self, source: Plain) -> None:
        """As ``copy_values`` in kernel/tangent/blocks.py, without derivatives."""
        for name in self._record.dtype.names:
            self._record[name] = source._record[name]

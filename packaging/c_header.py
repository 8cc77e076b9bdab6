"""Write shared.h of the C interface, all that C shares with Python: ``python packaging/c_header.py``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import chain, groupby, starmap
from operator import itemgetter
from pathlib import Path
from textwrap import wrap

from chain_impact.compilation.compilers import INTERFACE
from chain_impact.compilation.signatures import declarations
from chain_impact.fmu.model_bin import HEAD_FORMATS, MAGIC, TABLE_ROLES, TABLE_TYPES, VARIABLE_FORMATS
from chain_impact.kernel.chain.inputs import REINITIALIZE
from chain_impact.kernel.record.counts import COUNTS, FEATURES, LARGEST_COUNT
from chain_impact.kernel.status import ONSET_DUE, PAUSED

FILE: Path = INTERFACE / "common" / "shared.h"
C_TYPES = {"d": "double", "q": "int64_t", "Q": "uint64_t", "i": "int32_t"}
"""Format of a number in Python's struct → C's type."""
LINE_LENGTH = 110
"""Largest number of characters in a line of a structure."""


def header() -> str:
    """Return the text of the header."""
    parts = [
        "/* What Python shares with C. packaging/c_header.py writes this file. */",
        "#ifndef shared_h\n#define shared_h\n\n#include <stdint.h>",
        "/* fmu/model_bin.py: values of Variable.type and Variable.role; an enumeration is an integer */\n"
        + f"{_indices(TABLE_TYPES)}\n{_indices(TABLE_ROLES)}",
        "/* fmu/model_bin.py: the structures of resources/model.bin in an FMU */\n"
        + f'#define TABLE_MAGIC "{MAGIC.decode()}"',
        _structure("Variable", VARIABLE_FORMATS),
        _structure("Table", HEAD_FORMATS),
        "/* kernel/record/counts.py: the counts and flags at the start of a record, then the number of "
        "tangent instances */\n"
        f"enum {{ COUNTS = {len(COUNTS)}, FEATURES = {len(FEATURES)}, "
        f"SIZES = COUNTS + FEATURES + 1, LARGEST_COUNT = {LARGEST_COUNT} }};",
        "/* kernel/status.py: statuses of the kernel that are no faults */\n"
        f"enum {{ PAUSED = {PAUSED}, ONSET_DUE = {ONSET_DUE} }};",
        "/* kernel/chain/inputs.py: the value of given.pending with which the solver re-initializes */\n"
        f"enum {{ REINITIALIZE = {REINITIALIZE} }};",
        "/* compilation/signatures.py: the functions of the kernel */\n"
        f"typedef union {{ double real; int64_t integer; }} Word;\n{declarations()}",
        "#endif\n",
    ]
    return "\n\n".join(parts)


def _indices(names: Sequence[str]) -> str:
    return f"enum {{ {', '.join(names).upper()} }};"


def _structure(name: str, formats: Mapping[str, str]) -> str:
    """Return a structure of C; each line has neighbouring fields of the same type."""
    fields = (
        wrap(
            f"{kind} {', '.join(text for _, text in group)};",
            LINE_LENGTH,
            initial_indent=" " * 4,
            subsequent_indent=" " * 8,
        )
        for kind, group in groupby(starmap(_field, formats.items()), key=itemgetter(0))
    )
    return "\n".join(["typedef struct {", *chain.from_iterable(fields), f"}} {name};"])


def _field(name: str, kind: str) -> tuple[str, str]:
    """Return the C type of a field, and its name with the number of characters of a text."""
    if text := re.fullmatch(r"(\d+)s", kind):
        return "char", f"{name}[{text[1]}]"
    return C_TYPES[kind], name


if __name__ == "__main__":
    FILE.write_text(header(), encoding="utf-8")

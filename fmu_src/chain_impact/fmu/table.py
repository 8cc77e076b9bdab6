"""What an FMU knows of its model: one table, as JSON for pythonfmu's slave, as bytes for the C interface."""

from __future__ import annotations

import hashlib
import struct
import uuid
import zlib
from collections.abc import Iterable, Sequence
from typing import Any

from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.candidates import places as places_of
from chain_impact.scene.names import Place
from chain_impact.variables.kind import MOTION
from chain_impact.variables.model import Model
from chain_impact.variables.places import word_index

# as in compilation/c_interface/common/instance.h
HEAD, CHECKED_FROM = struct.Struct("<8sQQ40s15q"), 24
ROW, PLACE = struct.Struct("<ddqqqiiii"), struct.Struct("<q")
MAGIC = b"chaintab"
TYPES, KINDS = ("real", "integer"), ("fixed", "tunable", "input", "output", "independent")


def model_table(model: Model) -> dict[str, Any]:
    """What an FMU has to know of its model, but for the start values and the GUID."""
    variables, layout = model.variables, model.start.dtype
    places: dict[str, Place] = {
        "time": ("step", "time"),
        "changed": ("given", "changed"),
        "tolerance": ("solver", "tolerance"),
        "place": ("fault", "place"),
    }
    if model.sizes[-1]:
        places |= {"contradiction": ("moved", "contradiction"), "position": (MOTION, "position", 0)}
    return {
        "name": model.scene.name,
        "variables": [model.table_row(variable) for variable in variables],
        "first_output": sum(variable.causality != "output" for variable in variables),
        "words": {name: word_index(layout, place) for name, place in places.items()},
        "statuses": {str(status): text for status, text in STATUS_TEXT.items()},
        "places": places_of(model.scene),
    }


def guid_of(contents: Iterable[bytes]) -> str:
    """A GUID that follows from all that makes an FMU."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(len(content).to_bytes(8, "big") + content)
    return str(uuid.UUID(bytes=digest.digest()[:16]))


def packed(model: dict[str, Any], record: bytes, further: Sequence[tuple[list[Any], int]] = ()) -> bytes:
    """The table with its GUID, and the record with the start values, as the C interface reads them.

    The layout is that of the structures in compilation/c_interface/common/instance.h.

    Args:
        model: as ``model_table`` gives it, with the GUID.
        record: the start values.
        further: rows of variables that only FMI 3.0 has, and how many values each has.
    """
    texts = bytearray()
    variables = [*((row, 1) for row in model["variables"]), *further]

    def text(content: str) -> int:
        texts.extend(content.encode() + b"\0")
        return len(texts) - len(content.encode()) - 1

    rows = b"".join(
        ROW.pack(
            *(low, high, word, set_word, length),
            *(TYPES.index(type_), KINDS.index(kind), text(name), text(allowed)),
        )
        for (name, type_, word, kind, low, high, allowed, set_word), length in variables
    )
    codes = range(max(map(int, model["statuses"])) + 1)
    statuses = b"".join(
        PLACE.pack(text(model["statuses"].get(str(code), "unknown status"))) for code in codes
    )
    reasons = b"".join(PLACE.pack(text(place)) for place in model["places"])
    variables_at = HEAD.size
    statuses_at = variables_at + len(rows)
    places_at = statuses_at + len(statuses)
    record_at = places_at + len(reasons)
    texts_at = record_at + len(record)
    numbers = [len(variables), len(codes), len(model["places"])]
    names = ("time", "changed", "tolerance", "place", "contradiction", "position")
    numbers += [model["words"].get(name, 0) for name in names]
    numbers += [variables_at, statuses_at, places_at, texts_at, record_at, len(record)]
    parts = rows + statuses + reasons + record + bytes(texts)
    head = HEAD.pack(MAGIC, HEAD.size + len(parts), 0, model["guid"].encode(), *numbers)
    checked = head[CHECKED_FROM:] + parts
    return head[: CHECKED_FROM - 8] + zlib.crc32(checked).to_bytes(8, "little") + checked

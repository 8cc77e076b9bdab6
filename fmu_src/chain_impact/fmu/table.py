"""The data that the C interface of an FMU needs: the table resources/model.bin."""

from __future__ import annotations

import hashlib
import struct
import uuid
import zlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from chain_impact.fmu.model_description import TOKEN
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.candidates import places as places_of
from chain_impact.scene.names import DataPath
from chain_impact.variables.indices import word_index
from chain_impact.variables.kind import MOTION
from chain_impact.variables.prepared import PreparedScene

# the formats of the structures in compilation/c_interface/common/instance.h
HEAD, CHECKED_FROM = struct.Struct("<8sQQ40s15q"), 24
ROW, PLACE = struct.Struct("<ddqqqiiii"), struct.Struct("<q")
MAGIC = b"chaintab"
TYPES, KINDS = ("real", "integer"), ("fixed", "tunable", "input", "output", "independent")
Rows = Sequence[tuple[list[Any], int]]
"""A row of the table for each variable, with the number of values of the variable."""


def described(
    files: Mapping[str, bytes], prepared: PreparedScene, description: Element, fmi: int, further: Rows = ()
) -> dict[str, bytes]:
    """Add the model description and the table to the files of an FMU.

    Args:
        files: the other files of the FMU on which its results depend.
        prepared: the scene that the FMU simulates, prepared.
        description: the model description, to which the GUID of all these files is added.
        fmi: the version of FMI.
        further: variables that only FMI 3.0 has.
    """
    contents = (packed(prepared, "", further), ElementTree.tostring(description), *files.values())
    description.set(TOKEN[fmi], _guid_of(contents))
    table = packed(prepared, description.attrib[TOKEN[fmi]], further)
    ElementTree.indent(description)
    text = ElementTree.tostring(description, encoding="UTF-8", xml_declaration=True)
    return {**files, "modelDescription.xml": text, "resources/model.bin": table}


def _guid_of(contents: Iterable[bytes]) -> str:
    """Return a GUID that is computed from all contents of an FMU."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(len(content).to_bytes(8, "big") + content)
    return str(uuid.UUID(bytes=digest.digest()[:16]))


def packed(prepared: PreparedScene, guid: str, further: Rows) -> bytes:
    """Return the table with its GUID, and the record with the start values, in the form for the C interface.

    The structures in compilation/c_interface/common/instance.h define the layout.
    """
    texts, record = bytearray(), prepared.start.tobytes()
    variables = [*((prepared.table_row(variable), 1) for variable in prepared.variables), *further]

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
    codes = range(max(STATUS_TEXT) + 1)
    statuses = b"".join(PLACE.pack(text(STATUS_TEXT.get(code, "unknown status"))) for code in codes)
    places = places_of(prepared.scene)
    reasons = b"".join(PLACE.pack(text(place)) for place in places)
    variables_at = HEAD.size
    statuses_at = variables_at + len(rows)
    places_at = statuses_at + len(statuses)
    record_at = places_at + len(reasons)
    texts_at = record_at + len(record)
    numbers = [len(variables), len(codes), len(places), *_words(prepared)]
    numbers += [variables_at, statuses_at, places_at, texts_at, record_at, len(record)]
    parts = rows + statuses + reasons + record + bytes(texts)
    head = HEAD.pack(MAGIC, HEAD.size + len(parts), 0, guid.encode(), *numbers)
    checked = head[CHECKED_FROM:] + parts
    return head[: CHECKED_FROM - 8] + zlib.crc32(checked).to_bytes(8, "little") + checked


def _words(prepared: PreparedScene) -> list[int]:
    """Return the indices of the words of the record that the C interface itself reads or writes.

    The index is 0 for a word of moving parts if nothing moves.
    """
    paths: list[DataPath] = [
        ("step", "time"),
        ("given", "changed"),
        ("solver", "tolerance"),
        ("fault", "place"),
    ]
    if prepared.sizes.channels:
        paths += [("moved", "contradiction"), (MOTION, "position", 0)]
    words = [word_index(prepared.start.dtype, path) for path in paths]
    return words if prepared.sizes.channels else [*words, 0, 0]

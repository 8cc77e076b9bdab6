"""The data that the C interface of an FMU needs: the table resources/model.bin."""

from __future__ import annotations

import hashlib
import struct
import uuid
import zlib
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from chain_impact.fmu.model_description import TOKEN
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.candidates import parts_in_words
from chain_impact.scene.names import DataPath
from chain_impact.variables.indices import word_index
from chain_impact.variables.kind import MOTION
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.variable import TableRow

MAGIC = b"chaintab"
TABLE_TYPES, TABLE_KINDS = ("real", "integer"), ("fixed", "tunable", "input", "output", "independent")
VARIABLE = {
    # lowest and highest value that can be set; both limits are allowed values
    **dict.fromkeys(("low", "high"), "d"),
    # words of the record with the value in use and with the set value; a new value is written to both words
    **dict.fromkeys(("word", "set_word"), "q"),
    "length": "q",  # number of words from `word` on; more than one for an array
    # indices of the variable's type in TABLE_TYPES, and of its kind in TABLE_KINDS
    **dict.fromkeys(("type", "kind"), "i"),
    **dict.fromkeys(("name", "allowed"), "i"),  # offsets of the texts in the table
}
"""Field of the structure ``Variable`` of the C interface → format. A word is an index in the record, counted
in doubles."""
HEAD = {
    "magic": "8s",
    # the size of the whole file, and the checksum of the file after `checksum`
    **dict.fromkeys(("size", "checksum"), "Q"),
    "guid": "40s",
    **dict.fromkeys(("variable_count", "status_count", "part_count"), "q"),
    **dict.fromkeys(("time_word", "changed_word", "tolerance_word", "part_word"), "q"),
    # indices of words of prescribed motions; 0 without such motions
    **dict.fromkeys(("contradiction_word", "position_word"), "q"),
    # offsets in bytes from the beginning of the file; offsets of texts are from `texts_at`
    **dict.fromkeys(("variables_at", "statuses_at", "parts_at", "texts_at", "record_at"), "q"),
    "record_size": "q",
}
"""Field of the head of the table → format. packaging/c_header.py writes VARIABLE and HEAD for C."""
CHECKED_FROM = struct.calcsize("<" + "".join(HEAD[name] for name in ("magic", "size", "checksum")))
Rows = Sequence[tuple[TableRow, int]]
"""For each variable: its row of the table, and the number of its values."""


def with_description(
    files: Mapping[str, bytes], prepared: PreparedScene, description: Element, fmi: int, further: Rows = ()
) -> dict[str, bytes]:
    """Return the files of an FMU with the model description and the table added.

    Args:
        files: the other files of the FMU on which its results depend.
        prepared: the scene that the FMU simulates, prepared.
        description: the model description, to which the GUID of all these files is added.
        fmi: the version of FMI.
        further: variables that only FMI 3.0 has.
    """
    contents = (table_bytes(prepared, "", further), ElementTree.tostring(description), *files.values())
    description.set(TOKEN[fmi], _guid_of(contents))
    table = table_bytes(prepared, description.attrib[TOKEN[fmi]], further)
    ElementTree.indent(description)
    text = ElementTree.tostring(description, encoding="UTF-8", xml_declaration=True)
    return {**files, "modelDescription.xml": text, "resources/model.bin": table}


def _guid_of(contents: Iterable[bytes]) -> str:
    """Return a GUID that is computed from all contents of an FMU."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(len(content).to_bytes(8, "big") + content)
    return str(uuid.UUID(bytes=digest.digest()[:16]))


def table_bytes(prepared: PreparedScene, guid: str, further: Rows) -> bytes:
    """Return the table with its GUID, and the record with the start values, in the form for the C interface.

    The head, the variables, the texts of statuses and of parts of the scene, the record, and the texts follow
    each other.
    """
    texts, record = bytearray(), prepared.start.tobytes()
    variables = [*((prepared.table_row(variable), 1) for variable in prepared.variables), *further]

    def text(content: str) -> int:
        texts.extend(content.encode() + b"\0")
        return len(texts) - len(content.encode()) - 1

    def row(variable: TableRow, length: int) -> dict[str, float]:
        numbers = {name: getattr(variable, name) for name in ("low", "high", "word", "set_word")}
        numbers |= {"type": TABLE_TYPES.index(variable.type), "kind": TABLE_KINDS.index(variable.kind)}
        return numbers | {"length": length, "name": text(variable.name), "allowed": text(variable.allowed)}

    parts_of_scene = parts_in_words(prepared.scene)
    codes = range(max(STATUS_TEXT) + 1)
    parts = {
        "variables_at": b"".join(_structure(VARIABLE, row(*variable)) for variable in variables),
        "statuses_at": _numbers(text(STATUS_TEXT.get(code, "unknown status")) for code in codes),
        "parts_at": _numbers(text(part) for part in parts_of_scene),
        "record_at": record,
        "texts_at": bytes(texts),
    }
    content = b"".join(parts.values())
    starts = accumulate(map(len, parts.values()), initial=struct.calcsize("<" + "".join(HEAD.values())))
    head = dict(zip(parts, starts, strict=False)) | _words(prepared)
    head |= {"variable_count": len(variables), "status_count": len(codes), "part_count": len(parts_of_scene)}
    head |= {"size": head["texts_at"] + len(texts), "checksum": 0, "record_size": len(record)}
    packed_head = _structure(HEAD, {**head, "magic": MAGIC, "guid": guid.encode()})
    checked = packed_head[CHECKED_FROM:] + content
    return packed_head[: CHECKED_FROM - 8] + zlib.crc32(checked).to_bytes(8, "little") + checked


def _structure(formats: Mapping[str, str], values: Mapping[str, Any]) -> bytes:
    """Return a structure as bytes: little-endian, without gaps; in C the fields need no gaps, either."""
    return struct.pack("<" + "".join(formats.values()), *(values[name] for name in formats))


def _numbers(numbers: Iterable[int]) -> bytes:
    return b"".join(struct.pack("<q", number) for number in numbers)


def _words(prepared: PreparedScene) -> dict[str, int]:
    """Return the indices of the words of the record that the C interface itself reads or writes.

    The index of a word of prescribed motions is 0 if there is no such motion.
    """
    paths: dict[str, DataPath] = {
        "time_word": ("step", "time"),
        "changed_word": ("given", "changed"),
        "tolerance_word": ("solver", "tolerance"),
        "part_word": ("fault", "part"),
    }
    moving: dict[str, DataPath] = {
        "contradiction_word": ("moved", "contradiction"),
        "position_word": (MOTION, "position", 0),
    }
    moves = prepared.sizes.channels > 0
    words = {name: word_index(prepared.start.dtype, path) for name, path in paths.items()}
    return words | {
        name: word_index(prepared.start.dtype, path) if moves else 0 for name, path in moving.items()
    }

"""The table for an FMU's C interface: the file resources/model.bin, which describes variables and scene."""

from __future__ import annotations

import hashlib
import struct
import uuid
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from chain_impact.files import with_checksum
from chain_impact.fmu.model_description import TOKEN
from chain_impact.kernel.status import STATUS_TEXT
from chain_impact.scene.candidates import part_texts
from chain_impact.scene.texts.names import DataPath
from chain_impact.variables.indices import word_index
from chain_impact.variables.kind import GIVEN_CHANNEL
from chain_impact.variables.prepared import PreparedScene
from chain_impact.variables.variable import TableRow

MAGIC = b"chaintab"
TABLE_TYPES, TABLE_ROLES = ("real", "integer"), ("fixed", "tunable", "input", "output", "independent")
VARIABLE_FORMATS = {
    # the lowest and the highest value that may be set
    **dict.fromkeys(("low", "high"), "d"),
    # indices of words in the record: word, of the value in use; set_word, of the value that was set. A new
    # value is written to both.
    **dict.fromkeys(("word", "set_word"), "q"),
    "length": "q",  # number of words from `word` on: 1, or more for an array
    # indices in TABLE_TYPES and TABLE_ROLES
    **dict.fromkeys(("type", "role"), "i"),
    # where the texts of the name and of the allowed values begin: bytes after `texts_at` of HEAD_FORMATS
    **dict.fromkeys(("name", "allowed"), "i"),
}
"""Field of the C structure ``Variable`` → its format in Python's module struct.

A word is an index in the instance record, which counts numbers of 8 bytes.
"""
HEAD_FORMATS = {
    "magic": "8s",
    # size: of the whole file [byte]; checksum: CRC-32 of everything in the file after `checksum`
    **dict.fromkeys(("size", "checksum"), "Q"),
    "guid": "40s",
    **dict.fromkeys(("variable_count", "status_count", "part_count"), "q"),
    **dict.fromkeys(("time_word", "changed_word", "tolerance_word", "part_word"), "q"),
    # words of prescribed motions, all 0 if the scene has none: that with the number, from 1, of a channel
    # whose given positions and velocities contradict each other, or 0 for none; those that describe this
    # contradiction, the distance [m], its duration [s] and the given velocity [m/s]; and that with the given
    # position of the first channel
    **dict.fromkeys(("contradiction_word", "distance_word", "duration_word", "velocity_word"), "q"),
    "position_word": "q",
    # offsets in bytes from the beginning of the file
    **dict.fromkeys(("variables_at", "statuses_at", "parts_at", "texts_at", "record_at"), "q"),
    "record_size": "q",
}
"""Field at the beginning of the table → its format; packaging/c_header.py writes both for C."""
CHECKED_FROM = struct.calcsize("<" + "".join(HEAD_FORMATS[name] for name in ("magic", "size", "checksum")))
TableRows = Sequence[tuple[TableRow, int]]
"""For each variable: its row of the table, and the number of its values (1, or more for an array)."""


def files_with_description(
    files: Mapping[str, bytes],
    prepared_scene: PreparedScene,
    description: Element,
    fmi: int,
    further_rows: TableRows = (),
) -> dict[str, bytes]:
    """Return the files of an FMU, with the model description and the table added.

    Args:
        files: the other files of the FMU on which its results depend, as path → content.
        prepared_scene: the scene that the FMU simulates.
        description: the model description; its GUID, computed from the description, the table and ``files``,
            is added here.
        fmi: the version of FMI.
        further_rows: variables that only FMI 3.0 has.
    """
    contents = (
        table_bytes(prepared_scene, "", further_rows),
        ElementTree.tostring(description),
        *files.values(),
    )
    description.set(TOKEN[fmi], _guid_of(contents))
    table = table_bytes(prepared_scene, description.attrib[TOKEN[fmi]], further_rows)
    ElementTree.indent(description)
    text = ElementTree.tostring(description, encoding="UTF-8", xml_declaration=True)
    return {**files, "modelDescription.xml": text, "resources/model.bin": table}


def _guid_of(contents: Iterable[bytes]) -> str:
    """Return a GUID that is computed from the contents of an FMU, so that equal FMUs have equal GUIDs."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(len(content).to_bytes(8, "big") + content)
    return str(uuid.UUID(bytes=digest.digest()[:16]))


def table_bytes(prepared_scene: PreparedScene, guid: str, further_rows: TableRows) -> bytes:
    """Return the table's bytes, with ``guid`` in its head.

    In the file, these parts follow each other: the head, the variables, the offsets of the texts of statuses
    and of parts of the scene, the record with the start values, and the texts.
    """
    texts, record = bytearray(), prepared_scene.start.tobytes()
    variables = [
        *((prepared_scene.table_row(variable), 1) for variable in prepared_scene.variables),
        *further_rows,
    ]

    def text(content: str) -> int:
        texts.extend(content.encode() + b"\0")
        return len(texts) - len(content.encode()) - 1

    def row(variable: TableRow, length: int) -> dict[str, float]:
        numbers = {name: getattr(variable, name) for name in ("low", "high", "word", "set_word")}
        numbers |= {"type": TABLE_TYPES.index(variable.type), "role": TABLE_ROLES.index(variable.role)}
        return numbers | {"length": length, "name": text(variable.name), "allowed": text(variable.allowed)}

    parts_of_scene = part_texts(prepared_scene.scene)
    codes = range(max(STATUS_TEXT) + 1)
    parts = {
        "variables_at": b"".join(_structure(VARIABLE_FORMATS, row(*variable)) for variable in variables),
        "statuses_at": _numbers(text(STATUS_TEXT.get(code, "unknown status")) for code in codes),
        "parts_at": _numbers(text(part) for part in parts_of_scene),
        "record_at": record,
        "texts_at": bytes(texts),
    }
    content = b"".join(parts.values())
    starts = accumulate(
        map(len, parts.values()), initial=struct.calcsize("<" + "".join(HEAD_FORMATS.values()))
    )
    head = dict(zip(parts, starts, strict=False)) | _words(prepared_scene)
    head |= {"variable_count": len(variables), "status_count": len(codes), "part_count": len(parts_of_scene)}
    head |= {"size": head["texts_at"] + len(texts), "checksum": 0, "record_size": len(record)}
    packed_head = _structure(HEAD_FORMATS, {**head, "magic": MAGIC, "guid": guid.encode()})
    checked = packed_head[CHECKED_FROM:] + content
    return with_checksum(packed_head[: CHECKED_FROM - 8], checked)


def _structure(formats: Mapping[str, str], values: Mapping[str, Any]) -> bytes:
    """Return a structure as bytes, little-endian and without gaps.

    C compilers put no gaps into the same structure: each number begins at a multiple of its size, a text may
    begin anywhere, and the size of the structure is a multiple of 8.
    """
    return struct.pack("<" + "".join(formats.values()), *(values[name] for name in formats))


def _numbers(numbers: Iterable[int]) -> bytes:
    return b"".join(struct.pack("<q", number) for number in numbers)


def _words(prepared_scene: PreparedScene) -> dict[str, int]:
    """Return the words of the record that the C interface reads or writes, as field of HEAD_FORMATS → word.

    Words of prescribed motions are 0 if the scene has none.
    """
    paths: dict[str, DataPath] = {
        "time_word": ("step", "communication_point"),
        "changed_word": ("given", "pending"),
        "tolerance_word": ("solver", "tolerance"),
        "part_word": ("fault", "part"),
    }
    motion_words: dict[str, DataPath] = {
        "contradiction_word": ("channel", "contradiction"),
        "distance_word": ("channel", "contradiction_distance"),
        "duration_word": ("channel", "contradiction_duration"),
        "velocity_word": ("channel", "contradiction_velocity"),
        "position_word": (GIVEN_CHANNEL, "position", 0),
    }
    has_motions = prepared_scene.counts.channel_count > 0
    words = {name: word_index(prepared_scene.start.dtype, path) for name, path in paths.items()}
    return words | {
        name: word_index(prepared_scene.start.dtype, path) if has_motions else 0
        for name, path in motion_words.items()
    }

"""The symbols and libraries that a shared library needs and offers, read from its file."""

import hashlib
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Binary:
    """The contents of a shared library; ``machine`` is the number of the processor in its format.

    ``libraries`` are the libraries that it loads, ``needed`` the names that it uses from these, ``offered``
    the names that it defines.
    """

    machine: int
    libraries: set[str]
    needed: set[str]
    offered: set[str]


def binary(data: bytes) -> Binary:
    """Return the contents of a library; its first bytes determine the format."""
    for magic, read in ((b"\x7fELF\x02\x01", _elf), (b"MZ", _pe), (b"\xcf\xfa\xed\xfe", _macho)):
        if data.startswith(magic):
            return read(data)
    raise ValueError(f"a library that begins with {data[:8]!r}")


def read_binary(path: Path) -> Binary:
    """Return the contents of a library's file."""
    return binary(path.read_bytes())


def oldest_macos(data: bytes) -> tuple[int, int]:
    """Return the oldest macOS on which a Mach-O library runs, from its load command LC_BUILD_VERSION."""
    ((_, at),) = ((command, at) for command, at in _commands(data) if command == 0x32)
    (version,) = struct.unpack_from("<I", data, at + 12)
    return version >> 16, version >> 8 & 0xFF


def signed_without_identity(data: bytes) -> bool:
    """Return whether a Mach-O library has a valid signature: the hash of each page, and no identity."""
    places = [at for command, at in _commands(data) if command == 0x1D]  # LC_CODE_SIGNATURE
    if not places:
        return False
    start, _ = struct.unpack_from("<II", data, places[0] + 8)
    magic, _, count = struct.unpack_from(">III", data, start)
    parts = dict(struct.unpack_from(">II", data, start + 12 + 8 * i) for i in range(count))
    directory = data[start + parts[0] :]
    # after magic, length and version: flags, places of hashes and name, numbers of hashes, length of the code
    flags, hashes, _, _, pages, length = struct.unpack_from(">6I", directory, 12)
    size, kind, _, page = struct.unpack_from(">4B", directory, 36)
    computed = [
        hashlib.sha256(data[at : min(at + (1 << page), length)]).digest()
        for at in range(0, length, 1 << page)
    ]
    stored = [directory[hashes + size * i : hashes + size * (i + 1)] for i in range(pages)]
    return (magic, kind, length) == (0xFADE0CC0, 2, start) and bool(flags & 2) and computed == stored


def _commands(data: bytes) -> Iterator[tuple[int, int]]:
    """Return the load commands of a Mach-O library: number, and place in the file."""
    at = 32
    for _ in range(struct.unpack_from("<I", data, 16)[0]):
        command, size = struct.unpack_from("<II", data, at)
        yield command, at
        at += size


def _text(data: bytes, place: int) -> str:
    return data[place : data.index(b"\0", place)].decode()


def _elf(data: bytes) -> Binary:
    (machine,) = struct.unpack_from("<H", data, 18)
    start, size, count = struct.unpack_from("<Q", data, 40) + struct.unpack_from("<HH", data, 58)
    # name, type, flags, address, offset, size, link, info, alignment, size of an entry
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, start + size * i) for i in range(count)]
    binary = Binary(machine, set(), set(), set())
    for _, kind, _, _, offset, length, link, _, _, entry in sections:
        names = sections[link][4] if link < count else 0
        if kind == 11:  # SHT_DYNSYM
            for place in range(offset + entry, offset + length, entry):
                name, _, _, section = struct.unpack_from("<IBBH", data, place)
                (binary.offered if section else binary.needed).add(_text(data, names + name))
        if kind == 6:  # SHT_DYNAMIC
            for place in range(offset, offset + length, 16):
                tag, value = struct.unpack_from("<QQ", data, place)
                if tag == 1:  # DT_NEEDED
                    binary.libraries.add(_text(data, names + value))
    return binary


def _pe(data: bytes) -> Binary:
    (head,) = struct.unpack_from("<I", data, 0x3C)
    machine, count, optional = *struct.unpack_from("<HH", data, head + 4), head + 24
    (optional_size,) = struct.unpack_from("<H", data, head + 20)
    # virtual size, address, size in the file, place in the file
    sections = [
        struct.unpack_from("<IIII", data, optional + optional_size + 40 * i + 8) for i in range(count)
    ]

    def place(address: int) -> int:
        return next(start + address - at for size, at, _, start in sections if at <= address < at + size)

    (exports, _), (imports, _) = (struct.unpack_from("<II", data, optional + 112 + 8 * i) for i in range(2))
    binary = Binary(machine, set(), set(), set())
    entry = place(imports)
    while (row := struct.unpack_from("<IIIII", data, entry))[3]:
        binary.libraries.add(_text(data, place(row[3])).lower())
        names = place(row[0] or row[4])
        while name := struct.unpack_from("<Q", data, names)[0]:
            if not name >> 63:  # otherwise the symbol has a number instead of a name
                binary.needed.add(_text(data, place(name) + 2))
            names += 8
        entry += 20
    (names_count, _, names_at) = struct.unpack_from("<III", data, place(exports) + 24)
    for i in range(names_count):
        (name,) = struct.unpack_from("<I", data, place(names_at) + 4 * i)
        binary.offered.add(_text(data, place(name)))
    return binary


def _macho(data: bytes) -> Binary:
    (machine,) = struct.unpack_from("<I", data, 4)
    binary = Binary(machine, set(), set(), set())
    for command, at in _commands(data):
        if command & 0x7FFFFFFF in (0xC, 0x18, 0x1F):  # LC_LOAD_DYLIB, weak, re-exported
            binary.libraries.add(_text(data, at + struct.unpack_from("<I", data, at + 8)[0]))
        if command == 2:  # LC_SYMTAB
            symbols, count, texts, _ = struct.unpack_from("<IIII", data, at + 8)
            for i in range(count):
                name, kind, section, _, _ = struct.unpack_from("<IBBHQ", data, symbols + 16 * i)
                if kind & 1 and not kind & 0xE0:  # external symbols, not those for debuggers
                    (binary.offered if section else binary.needed).add(
                        _text(data, texts + name).removeprefix("_")
                    )
    return binary

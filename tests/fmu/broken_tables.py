"""Native FMUs in a clean process, whose resources/model.bin has one wrong number and a valid checksum."""

import ctypes
import mmap
import os
import random
import signal
import struct
import zlib
from ctypes import byref, c_size_t, c_void_p

from interface import Library


def guarded(fmu):
    """Return an FMU whose instances have an inaccessible memory page behind their memory."""
    system, page = ctypes.CDLL(None), mmap.PAGESIZE
    system.mmap.restype = c_void_p
    system.mmap.argtypes = [c_void_p, c_size_t, *[ctypes.c_int] * 3, ctypes.c_long]
    system.mprotect.argtypes = [c_void_p, c_size_t, ctypes.c_int]

    class Guarded(Library):
        def _allocate(self, count, size):
            rounded_size = -(-count * size // 8) * 8
            size_of_pages = -(-rounded_size // page) * page
            kind = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
            place = system.mmap(None, size_of_pages + page, mmap.PROT_READ | mmap.PROT_WRITE, kind, -1, 0)
            assert system.mprotect(place + size_of_pages, page, 0) == 0
            return place + size_of_pages - rounded_size

        def _free(self, address):
            """Free nothing: the memory ends with the process."""

    return Guarded(fmu)


def used(library, count):
    """Use an instance as an importer does.

    Return 0. Without an instance, return 1 if a message says that model.bin does not fit, else 2.
    """
    library.new_messages()
    instance, c, real = library.instantiate(), library.c, ctypes.c_double
    if not instance:
        (text,) = library.new_messages()
        return 1 if "model.bin that is not for this binary, or damaged" in text else 2
    instance = c_void_p(instance)

    def read_all():
        for reference in range(count):
            value, reference_cell = real(0.5), ctypes.c_uint(reference)
            c.fmi2GetReal(instance, byref(reference_cell), c_size_t(1), byref(value))

    c.fmi2SetupExperiment(instance, 0, real(0.0), real(0.0), 0, real(0.0))
    c.fmi2EnterInitializationMode(instance)
    read_all()
    c.fmi2ExitInitializationMode(instance)
    for step in range(3):
        c.fmi2DoStep(instance, real(0.01 * step), real(0.01), 0)
    read_all()
    c.fmi2Reset(instance)
    return 0


def mutants_of(table):
    """Return tables with one changed number or byte each: description → content.

    The second result has the beginnings of the descriptions for numbers that have a single valid value.
    """
    guid_ends, head_ends, row = 64, 208, struct.calcsize("<ddqqqiiii")
    numbers = struct.unpack_from("<18q", table, guid_ends)
    count, rows_at, record_at = numbers[0], numbers[12], numbers[16]
    head = [guid_ends + 8 * i for i in range(18)]
    record = [record_at + 8 * i for i in range(6)]
    rows = [rows_at + row * i + 16 + 8 * k for i in (0, 1, count // 2, count - 1) for k in range(5)]
    mutants = {}
    for at in head + record + rows:
        (stored,) = struct.unpack_from("<q", table, at)
        wrong_numbers = {
            0,
            -1,
            1,
            7,
            stored - 8,
            stored + 8,
            stored // 2,
            2 * stored + 8,
            1 << 31,
            1 << 61,
            -1 << 63,
        }
        for number in wrong_numbers - {stored}:
            mutants[f"{at}: {number}"] = table[:at] + struct.pack("<q", number) + table[at + 8 :]
    chance = random.Random(1)
    anywhere = [chance.randrange(head_ends, len(table)) for _ in range(100)]
    for at in [*range(guid_ends, head_ends), *anywhere]:
        for flip in (0x01, 0x80, 0xFF):
            changed_byte = bytes([table[at] ^ flip])
            mutants[f"byte {at} ^ {flip}"] = table[:at] + changed_byte + table[at + 1 :]
    return mutants, [f"{at}: " for at in (head[16], head[17], *record[1:4])]


def fates(fmu):
    """Run each mutant, with a recomputed checksum, in its own process.

    Return description → result of ``used`` or minus a signal's number, with the valid table as ``none``, and
    the second result of ``mutants_of``.
    """
    library = guarded(fmu)
    file = library.folder / "resources" / "model.bin"
    table, count, exit_codes = (
        file.read_bytes(),
        len(library.nodes),
        {"none": used(library, len(library.nodes))},
    )
    mutants, sizes = mutants_of(table)
    for name, content in mutants.items():
        file.write_bytes(content[:16] + zlib.crc32(content[24:]).to_bytes(8, "little") + content[24:])
        child = os.fork()
        if child == 0:
            signal.alarm(60)
            code = 99
            try:
                code = used(library, count)
            finally:
                os._exit(code)
        exit_codes[name] = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return [exit_codes, sizes]

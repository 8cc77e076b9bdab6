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
            wanted = -(-count * size // 8) * 8
            whole = -(-wanted // page) * page
            kind = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
            place = system.mmap(None, whole + page, mmap.PROT_READ | mmap.PROT_WRITE, kind, -1, 0)
            assert system.mprotect(place + whole, page, 0) == 0
            return place + whole - wanted

        def _free(self, address):
            """Free nothing: the memory ends with the process."""

    return Guarded(fmu)


def used(library, count):
    """Use an instance as an importer does.

    Return 0; or, if there is no instance, 1 if it is refused with the right sentence, else 2.
    """
    library.said()
    one, c, real = library.instantiate(), library.c, ctypes.c_double
    if not one:
        (text,) = library.said()
        return 1 if "model.bin that is not for this binary, or damaged" in text else 2
    one = c_void_p(one)

    def read_all():
        for reference in range(count):
            value, which = real(0.5), ctypes.c_uint(reference)
            c.fmi2GetReal(one, byref(which), c_size_t(1), byref(value))

    c.fmi2SetupExperiment(one, 0, real(0.0), real(0.0), 0, real(0.0))
    c.fmi2EnterInitializationMode(one)
    read_all()
    c.fmi2ExitInitializationMode(one)
    for step in range(3):
        c.fmi2DoStep(one, real(0.01 * step), real(0.01), 0)
    read_all()
    c.fmi2Reset(one)
    return 0


def mutants_of(whole):
    """Return tables with one changed number or byte each: description → content.

    The second result has the beginnings of the descriptions for numbers that have a single valid value.
    """
    guid_ends, head_ends, row = 64, 208, struct.calcsize("<ddqqqiiii")
    numbers = struct.unpack_from("<18q", whole, guid_ends)
    count, rows_at, record_at = numbers[0], numbers[12], numbers[16]
    head = [guid_ends + 8 * i for i in range(18)]
    record = [record_at + 8 * i for i in range(6)]
    rows = [rows_at + row * i + 16 + 8 * k for i in (0, 1, count // 2, count - 1) for k in range(5)]
    mutants = {}
    for at in head + record + rows:
        (right,) = struct.unpack_from("<q", whole, at)
        others = {0, -1, 1, 7, right - 8, right + 8, right // 2, 2 * right + 8, 1 << 31, 1 << 61, -1 << 63}
        for other in others - {right}:
            mutants[f"{at}: {other}"] = whole[:at] + struct.pack("<q", other) + whole[at + 8 :]
    chance = random.Random(1)
    anywhere = [chance.randrange(head_ends, len(whole)) for _ in range(100)]
    for at in [*range(guid_ends, head_ends), *anywhere]:
        for flip in (0x01, 0x80, 0xFF):
            changed = bytes([whole[at] ^ flip])
            mutants[f"byte {at} ^ {flip}"] = whole[:at] + changed + whole[at + 1 :]
    return mutants, [f"{at}: " for at in (head[16], head[17], *record[1:4])]


def fates(fmu):
    """Run each mutant, with a recomputed checksum, in its own process.

    Return description → exit code (or minus the number of a signal), with the right table as ``none``, and
    the second result of ``mutants_of``.
    """
    library = guarded(fmu)
    file = library.folder / "resources" / "model.bin"
    whole, count, found = file.read_bytes(), len(library.nodes), {"none": used(library, len(library.nodes))}
    mutants, sizes = mutants_of(whole)
    for what, content in mutants.items():
        file.write_bytes(content[:16] + zlib.crc32(content[24:]).to_bytes(8, "little") + content[24:])
        child = os.fork()
        if child == 0:
            signal.alarm(60)
            code = 99
            try:
                code = used(library, count)
            finally:
                os._exit(code)
        found[what] = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return [found, sizes]

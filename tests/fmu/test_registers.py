"""FMUs in hosts that change the processor's floating-point registers: registers.c, and a Python host."""

# Tests: compilation/compilers.py

import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest

from chain_impact.compilation.compilers import INCLUDES
from tests.fmu.importer import Instance
from tests.fmu.interface import Binary
from tests.helpers.tools.registers import TRAPS, WITHOUT_TRAPS, make_library
from tests.helpers.tools.zig import WARNINGS, zig
from tests.tiers import needs_compilers

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="registers.c is for x86-64 and Linux"
)
SOURCE = Path(__file__).with_name("registers.c")
ROOT = Path(__file__).parents[2]
# the models use a contact law with vectorised division, rigid walls, dry friction, and the general kernel
MODELS = ["four_link_box", "kneed_leg", "sliding_rod", "triple_pendulum"]
WAYS = 16  # traps on or off, denormal numbers on or off, four rounding modes
USUAL_REGISTERS = "1f80"
STACK = 64  # KiB, of the thread in which the host calls the FMU
STEPS = 300  # number of steps of 1/512 s


@pytest.fixture(scope="module")
def hosts(tmp_path_factory):
    """Return the folder of the compiled host programs for both versions of FMI, fmi2 and fmi3."""
    folder = tmp_path_factory.mktemp("hosts")
    for version in (2, 3):
        options = [*WARNINGS, f"-DFMI={version}", *(f"-I{place}" for place in INCLUDES)]
        zig(folder, *options, SOURCE, "-ldl", "-lm", "-pthread", "-o", folder / f"fmi{version}")
    return folder


@pytest.fixture(scope="module", params=MODELS)
def ways(request, strict, hosts):
    """Run the host program with a model: registers → used bytes of the stack, and values."""
    binary = Binary(strict[request.param])
    version, resources = 3 if binary.fmi3 else 2, binary.folder / "resources"
    location = f"{resources}/" if binary.fmi3 else resources.as_uri()
    outputs = [
        node.get("valueReference")
        for node in binary.nodes
        if node.get("causality") == "output"
        and (node.find("Real") is not None or node.tag == "Float64")
        and node.find("Dimension") is None
    ]
    command = [hosts / f"fmi{version}", binary.c._name, binary.guid.decode(), location, STACK, STEPS]
    command += [binary.references["gravity.x"], *outputs]
    process = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    assert process.returncode == 0, (process.returncode, process.stderr)
    lines = [line.split() for line in process.stdout.splitlines()]
    return {registers: (int(stack), values) for registers, stack, *values in lines}


@needs_compilers
def test_the_bits_are_the_same_whatever_a_host_has_set(ways):
    """The program ends with an error if a call changes the registers, and by a signal if a trap acts."""
    assert len(ways) == WAYS
    _, expected = ways[USUAL_REGISTERS]
    assert len(set(expected)) > STEPS
    for registers, (_, values) in ways.items():
        assert values == expected, registers


@needs_compilers
def test_the_stack_of_a_thread_that_the_docs_tell_is_enough(ways):
    (stack_size,) = re.findall(
        r"a stack of (\d+) KiB", (ROOT / "docs" / "fmi.md").read_text(encoding="utf-8")
    )
    assert max(stack for stack, _ in ways.values()) < 1024 * int(stack_size)


# rows_with runs in the clean process, with its own imports.


def rows_with(fmu, library, ways, step, steps):
    """Return the rows of outputs for each setting of the registers; times are exact multiples of the step."""
    import ctypes

    library, usual_setting, rows = ctypes.CDLL(library), ways[0], []
    for way in ways:
        instance = Instance(fmu).start()
        library.set_registers(way)
        try:
            rows.append(instance.run([i * step for i in range(1, steps + 1)]))
            left = library.registers() & ~0x3F
        finally:
            library.set_registers(usual_setting)
        if left != way:
            raise RuntimeError(f"registers {way:x} are {left:x} after the run")
    return rows


@needs_compilers
def test_an_fmu_in_a_host_in_python_gives_the_same_bits(fmus, clean, tmp_path):
    library = make_library(tmp_path)
    ways = [*WITHOUT_TRAPS, TRAPS]
    expected, *results = clean(rows_with, fmus["four_link_box"], str(library), ways, 1 / 512, STEPS)
    assert len(expected) == STEPS
    assert results == [expected] * len(ways[1:])

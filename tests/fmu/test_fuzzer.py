"""Random sequences of calls to the C interface, with sanitizers; fuzzer.c is seeded and bounded."""

# Tests: fmu/model_bin.py

import re
import shutil
import subprocess
from functools import cache, partial
from pathlib import Path

import pytest

from chain_impact import load_scene
from chain_impact.compilation import library
from chain_impact.compilation.compilers import INCLUDES, add_prelude, interface_sources, write_stubs
from chain_impact.compilation.library import kernel_library
from chain_impact.system import X86
from chain_impact.variables.prepared import PreparedScene
from tests.fmu.interface import description, unpacked
from tests.helpers.tools.zig import zig

pytestmark = pytest.mark.full("takes long")

SEEDS = range(3)
SEQUENCES, CALLS = 150, 500
MODEL = "pinned_arm"  # a model with inputs
NO_COMPILER = pytest.mark.skipif(not shutil.which("cc"), reason="an address sanitizer does not come with zig")


@pytest.fixture(scope="module", params=["zig", pytest.param("cc", marks=NO_COMPILER)])
def fuzzer(request, tmp_path_factory):
    """Return the fuzzing program with sanitizers; with cc its kernel has sanitizers, too."""
    folder, links = tmp_path_factory.mktemp("fuzzer"), len(load_scene(MODEL).chain.links)
    source, program = Path(__file__).with_name("fuzzer.c"), folder / "fuzzer"
    inputs = [*(f"-I{place}" for place in INCLUDES), source, *interface_sources(), "-lm", "-g"]
    inputs += ["-fno-omit-frame-pointer", "-o", program]
    if request.param == "zig":  # zig would need long to build its library of sanitizer messages
        kernel = kernel_library(links)
        zig(folder, *inputs, kernel, f"-Wl,-rpath,{kernel.parent}")
    else:
        command = ["cc", "-std=c11", "-D_POSIX_C_SOURCE=200809L", "-O1", "-fsanitize=undefined,address"]
        command += ["-fno-sanitize-recover=undefined", *inputs, sanitized_kernel(folder, links)]
        subprocess.run([*map(str, command), *map(str, write_stubs(program, None))], check=True)
    return program


def sanitized_kernel(folder, links):
    """Return an object of the kernel in which each access to memory is checked."""
    text = add_prelude(library._lowered_kernel(library.KERNEL), links)
    text, functions = re.subn(r"^(define .*)\{$", r"\1sanitize_address {", text, flags=re.M)
    assert functions > 500
    (folder / "kernel.ll").write_text(text)
    options = [f"-mcpu={X86}", "-Wno-everything", "-fsanitize=address"]
    zig(folder, "-c", *options, folder / "kernel.ll", "-o", folder / "kernel.o")
    return folder / "kernel.o"


@pytest.fixture(scope="module")
def printed(fuzzer, fmu):
    """Return a function: seed → output of its run; each seed runs once."""
    return cache(partial(run, fuzzer, fmu))


@pytest.fixture(scope="module")
def fmu(native):
    """Return GUID, resources and number of variables of a native FMU."""
    path = native[MODEL]
    location = (unpacked(path) / "resources").as_uri()
    return [description(path).get("guid"), location, str(len(PreparedScene(load_scene(MODEL)).variables))]


def run(fuzzer, fmu, seed):
    """Run random calls, which must end without a fault; return the output."""
    command = [str(fuzzer), str(seed), str(SEQUENCES), str(CALLS), *fmu]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stdout + process.stderr[-3000:]
    return process.stdout


@pytest.mark.parametrize("seed", SEEDS)
def test_no_sequence_of_calls_does_harm(printed, seed):
    assert int(re.match(r"(\d+) messages", printed(seed))[1]) > SEQUENCES


def test_equal_calls_give_equal_results(fuzzer, fmu, printed):
    assert run(fuzzer, fmu, SEEDS[0]) == printed(SEEDS[0])

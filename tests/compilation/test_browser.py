"""The kernel as a WebAssembly module: the module has no imports, and its powers equal the C library's."""

import ctypes
import hashlib
import math
import re
from importlib.resources import files
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from chain_impact.compilation import browser, compilers, ready
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.library import browser_module
from tests.tiers import needs_compilers

MUSL = "c4e9b6070c1905cbd13439272a3cae3903489e53cd95c7bad41f3bd913d0481c"
SECTIONS = {"type": 1, "import": 2, "export": 7}
LAW = "import math\n\n\ndef mine(penetration, stiffness, exponent):\n    return {}\n"
SINH = LAW.format("stiffness * math.sinh(penetration) ** exponent")


def number(content, at):
    """Return an unsigned number in LEB128, and where it ends."""
    value = shift = 0
    while True:
        byte = content[at]
        value, shift, at = value | (byte & 127) << shift, shift + 7, at + 1
        if byte < 128:
            return value, at


def sections(content):
    """Return the sections of a module: number → content."""
    assert content[:8] == b"\0asm\1\0\0\0"
    found, at = {}, 8
    while at < len(content):
        kind = content[at]
        size, at = number(content, at + 1)
        found[kind] = content[at : at + size]
        at += size
    return found


@pytest.mark.full("takes long")
def test_the_module_is_small_imports_nothing_exports_what_a_page_calls_and_has_no_path():
    """The module has no function names either. .ci/run compares modules from two folders, byte by byte."""
    content = browser_module().read_bytes()
    found = sections(content)
    assert SECTIONS["import"] not in found
    exported = set(re.findall(rb"[a-z_]{6,}", found[SECTIONS["export"]]))
    assert exported == {name.encode() for name in (*browser.EXPORTS, "memory")}
    assert len(content) < 340_000
    assert not re.search(rb"/(?:tmp|home|root|usr|work)/|\.ll\b|\.c\b", content)


@pytest.mark.full("takes long")
def test_what_is_musls_is_unchanged():
    digest = hashlib.sha256()
    for file in sorted((browser.MATHEMATICS / "musl").glob("*.[ch]")):
        digest.update(file.name.encode() + file.read_bytes())
    assert digest.hexdigest() == MUSL


@pytest.fixture(scope="module")
def mathematics(tmp_path_factory):
    """Return the module's own mathematical functions, compiled for this machine."""
    folder = tmp_path_factory.mktemp("mathematics")
    paths = [browser.MATHEMATICS, browser.MATHEMATICS / "musl"]
    sources = [browser.MATHEMATICS / "powers.c", *(paths[1] / f"{name}_data.c" for name in ("exp", "pow"))]
    sources += [paths[1] / "__math_invalid.c"]
    arguments = ["cc", "-target", "x86_64-linux-musl", "-shared", "-nostdlib", *browser.FLAGS]
    headers = files("ziglang") / "lib" / "libc" / "include"
    arguments += [f"-isystem{headers / name}" for name in ("x86_64-linux-musl", "generic-musl")]
    arguments += [*(f"-I{path}" for path in paths), "-o", str(folder / "powers.so"), *map(str, sources)]
    compilers.run_zig(arguments, folder / "powers.so")
    found = ctypes.CDLL(str(folder / "powers.so"))
    for name in ("pow", "hypot", "exp"):
        getattr(found, name).restype = ctypes.c_double
        getattr(found, name).argtypes = [ctypes.c_double] * (1 if name == "exp" else 2)
    return found


@needs_compilers
def test_powers_have_the_digits_of_the_c_library(mathematics):
    """All digits are equal on a processor with fused multiply-add, and nearly all on other processors."""
    chance = np.random.default_rng(30)
    bases = 10.0 ** chance.uniform(-12, 6, 20_000)
    exponents = chance.choice([0.4, 1 / 3, 0.5, 1.1, 1.3, 2.2, -0.6, 3.0], 20_000)
    arguments = chance.uniform(-3.0, 3.0, 20_000)
    fused = "fma" in Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    pairs = list(zip(bases.tolist(), exponents.tolist(), strict=True))
    differ = sum(mathematics.pow(a, b) != math.pow(a, b) for a, b in pairs)
    differ += sum(mathematics.exp(a) != math.exp(a) for a in arguments.tolist())
    assert differ <= (0 if fused else 100)
    near = [math.isclose(mathematics.hypot(a, b), math.hypot(a, b), rel_tol=2.3e-16) for a, b in pairs]
    assert all(near)


@pytest.mark.full("takes long")
def test_powers_of_special_numbers_are_those_of_the_c_library(mathematics):
    library_of_c = ctypes.CDLL("libm.so.6")
    library_of_c.pow.restype, library_of_c.pow.argtypes = ctypes.c_double, [ctypes.c_double] * 2
    bases = [0.0, -0.0, 1.0, -1.0, 2.0, -2.5, 5e-324, math.inf, -math.inf, math.nan, 1e300]
    exponents = [0.0, 1.0, 2.0, 3.0, -1.0, -3.0, 0.5, -0.5, 1e300, math.inf, -math.inf, math.nan]
    for base, exponent in product(bases, exponents):
        found, known = mathematics.pow(base, exponent), library_of_c.pow(base, exponent)
        np.testing.assert_equal(found, known, f"{base} ** {exponent}")


@pytest.mark.full("takes long")
def test_without_a_compiler_a_sentence_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path))
    monkeypatch.setattr(ready, "find_spec", lambda _: None)
    with pytest.raises(BuildError, match="a page that computes needs a compiler: "):
        browser_module()


@pytest.mark.full("takes long")
def test_a_law_of_the_users_own_is_compiled_in(tmp_path):
    law = tmp_path / "mine.py"
    law.write_text(SINH)
    module = browser_module(law_file=str(law))
    assert module.read_bytes() != browser_module().read_bytes()
    assert SECTIONS["import"] not in sections(module.read_bytes())


@needs_compilers
def test_a_law_that_calls_what_a_browser_does_not_have_says_so(tmp_path):
    law = tmp_path / "mine.py"
    law.write_text(LAW.format("stiffness * math.lgamma(penetration)"))
    with pytest.raises(BuildError, match=r"mine\.py calls lgamma, which a kernel in a browser does not have"):
        browser_module(law_file=str(law))

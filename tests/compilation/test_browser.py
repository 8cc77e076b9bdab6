"""The kernel as a WebAssembly module: the module has no imports, and with a user's law few."""

# Tests: compilation/compilers.py

import re

import pytest

from chain_impact.compilation import browser, prebuilt
from chain_impact.compilation.errors import BuildError
from chain_impact.compilation.library import browser_module
from chain_impact.pages.assembly import browser_text
from tests.helpers.scenes.law_texts import LAW, SINH
from tests.tiers import needs_compilers

SECTIONS = {"type": 1, "import": 2, "export": 7}


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
    contents, at = {}, 8
    while at < len(content):
        kind = content[at]
        size, at = number(content, at + 1)
        contents[kind] = content[at : at + size]
        at += size
    return contents


def test_the_exports_are_those_that_pages_use():
    exports_in_use = re.findall(r"\bexports\.(\w+)", browser_text("solver/kernel.js"))
    assert set(exports_in_use) == {*browser.EXPORTS, "memory"}


@pytest.mark.full("takes long")
def test_the_browser_module_is_small_and_exports_the_called_functions():
    """The module has no local paths. `.ci/run` compares modules from two folders, byte by byte."""
    module = browser_module().read_bytes()
    contents = sections(module)
    assert SECTIONS["import"] not in contents
    exported = set(re.findall(rb"[a-z_]{6,}", contents[SECTIONS["export"]]))
    assert exported == {name.encode() for name in (*browser.EXPORTS, "memory")}
    assert len(module) < 350_000
    assert not re.search(rb"/(?:tmp|home|root|usr|work)/|\.ll\b|\.c\b", module)


@pytest.mark.full("takes long")
def test_without_a_compiler_a_sentence_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("CHAIN_IMPACT_CACHE", str(tmp_path))
    monkeypatch.setattr(prebuilt, "find_spec", lambda _: None)
    with pytest.raises(BuildError, match="a page that computes needs a compiler: "):
        browser_module()


@pytest.mark.full("takes long")
def test_a_law_of_the_users_own_imports_what_it_calls(tmp_path):
    """Powers are the kernel's own, hyperbolic sines the browser's."""
    law = tmp_path / "mine.py"
    law.write_text(SINH)
    module = browser_module(law_file=str(law)).read_bytes()
    assert module != browser_module().read_bytes()
    assert sections(module)[SECTIONS["import"]][1:-2] == b"\x04Math\x04sinh"


@needs_compilers
def test_a_law_that_calls_what_a_browser_does_not_have_says_so(tmp_path):
    law = tmp_path / "mine.py"
    law.write_text(LAW.format("stiffness * math.lgamma(penetration)"))
    with pytest.raises(BuildError, match=r"mine\.py calls lgamma, which a kernel in a browser does not have"):
        browser_module(law_file=str(law))
